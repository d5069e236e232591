/* Stencils compiled without a scene: the first ALONE_COUNT of them, each behind those that it leans on; 7 are all. */
#include "alone.h"

#if ALONE_COUNT < 7 && defined(__GNUC__)
#pragma GCC diagnostic ignored "-Wunused-function"
#endif

#include "flow/norms.c"
#if ALONE_COUNT > 1 && (WITH_TURNS || WITH_FORCING || (ALONE_COUNT > 6 && WITH_PAIRS))
#include "flow/fused.c"
#endif
#if ALONE_COUNT > 1 && WITH_TURNS
#include "flow/turns.c"
#endif
#if ALONE_COUNT > 2 && WITH_FORCING
#include "flow/drive.c"
#endif
#if ALONE_COUNT > 2
#if WITH_RUBS
#include "flow/rubs.c"
#endif
#if WITH_SHARED
#include "flow/shared_sums.c"
#include "flow/shared.c"
#else
#if !WITH_OUTRIGHT
#include "flow/sums.c"
#endif
#include "flow/series.c"
#endif
#include "flow/move.c"
#endif
#if ALONE_COUNT > 3
#include "flow/length.c"
#endif
#if ALONE_COUNT > 4
#include "flow/event.c"
#endif
#if ALONE_COUNT > 5 && WITH_COLUMNS
/* Norms of derivatives: the same stencil on their lanes. */
#define stem_norm wide_norm
#define stem_norms wide_norms
#define stem_lanes wide_lanes
#define stem_lane_count wide_lane_count
#undef STEM_ZERO
#undef STEM_SIZE
#undef STEM_LARGER
#define STEM_ZERO WIDE_ZERO
#define STEM_SIZE WIDE_SIZE
#define STEM_LARGER WIDE_LARGER
#include "flow/norms.c"
#undef stem_norm
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
#include "columns/parameters.c"
#endif
#if WITH_LINKS
#include "columns/links.c"
#else
#include "columns/products.c"
#endif
#include "columns/sums.c"
#include "columns/series.c"
#endif
#if ALONE_COUNT > 6 && ALONE_BATCH
#include "flow/batch.c"
#elif ALONE_COUNT > 6
#if WITH_BESIDE
#if WITH_PAIRS
#include "beside/pairs.c"
void (*const alone_turned)(const stem_pair *angle, stem_pair *sine, stem_pair *cosine) = stem_sine_cosine;
void stem_factor_pairs(CONTEXT const stem_pair *q, const stem_pair *v, const stem_pair *u, const stem_pair *scale, const stem_pair *lost, stem_pair *held, stem_pair *left, stem_pair *right);
void stem_order_pairs(CONTEXT const stem_pair *held, const stem_pair *sums, const stem_pair *newest, const stem_pair *coefficient, const stem_pair *now, stem_pair *left, stem_pair *right, stem_pair *next);
#endif
#include "beside/steps.c"
#if WITH_PAIRS
#include "beside/defects.c"
#endif
#include "beside/neighbours.c"
#endif
#include "flow/run.c"
#endif
