/* Stencils compiled without a scene: the first ALONE_COUNT of them, each behind those that it leans on; 7 are all. */
#include "alone.h"

#if ALONE_COUNT < 7 && defined(__GNUC__)
#pragma GCC diagnostic ignored "-Wunused-function"
#endif

#include "flow_norms.c"
#if ALONE_COUNT > 1 && (WITH_TURNS || WITH_FORCING)
#include "flow_fused.c"
#endif
#if ALONE_COUNT > 1 && WITH_TURNS
#include "flow_turns.c"
#endif
#if ALONE_COUNT > 2 && WITH_FORCING
#include "flow_drive.c"
#endif
#if ALONE_COUNT > 2
#include "flow_sums.c"
#include "flow_series.c"
#endif
#if ALONE_COUNT > 3
#include "flow_length.c"
#endif
#if ALONE_COUNT > 4
#include "flow_event.c"
#endif
#if ALONE_COUNT > 5 && WITH_COLUMNS
/* Norms of derivatives: the same stencil on their lanes. */
#define stem_norms wide_norms
#define stem_lanes wide_lanes
#define stem_lane_count wide_lane_count
#undef STEM_ZERO
#undef STEM_SIZE
#undef STEM_LARGER
#define STEM_ZERO WIDE_ZERO
#define STEM_SIZE WIDE_SIZE
#define STEM_LARGER WIDE_LARGER
#include "flow_norms.c"
#undef stem_norms
#undef stem_lanes
#undef stem_lane_count
#undef STEM_ZERO
#undef STEM_SIZE
#undef STEM_LARGER
#define STEM_ZERO 0
#define STEM_SIZE(x) phi_abs(x)
#define STEM_LARGER(a, b) STEM_CHOOSE((a) > (b), a, b)
#if WITH_PARAMETERS
#include "flow_parameters.c"
#endif
#if WITH_LINKS
#include "flow_links.c"
#else
#include "flow_products.c"
#endif
#include "flow_column_sums.c"
#include "flow_columns.c"
#endif
#if ALONE_COUNT > 6 && ALONE_BATCH
#include "flow_batch.c"
#elif ALONE_COUNT > 6
#if WITH_BESIDE
#include "flow_beside.c"
#endif
#include "flow_run.c"
#endif
