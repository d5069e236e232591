/* What a scene puts into the stencils, so that they compile without one: names, types, sizes, and prototypes of the
 * functions that a scene's Programs become. `alone.c` compiles every stencil on these; none of it is ever emitted.
 *
 *   WITH_...       the features of the stencils, 0 or 1 each
 *   ALONE_FLOAT    1: single precision
 *   ALONE_BATCH    1: trajectories side by side, as propagate_batch has them
 *   ALONE_VECTORS  1: side by side in the compiler's vectors
 *   ALONE_CART     coordinates of a cart
 *   ALONE_NEWEST   1: `order` is given the last row of left as well
 *   ALONE_PARAMS   1: runtime parameters; 2: some that no position depends on
 */
#ifndef PHICHAIN_ALONE_H
#define PHICHAIN_ALONE_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#if WITH_TURNS && WITH_SPHERE
#error "unit vectors have no turns"
#endif
#if WITH_SHARED && !(WITH_SPHERE && ALONE_BATCH)
#error "rows are shared by trajectories side by side in space"
#endif
#if WITH_LINKS && (WITH_SPHERE || WITH_SQUARES || !WITH_COLUMNS)
#error "links by their angles are derivatives of a planar chain"
#endif
#if WITH_ANGLES && (WITH_SPHERE || WITH_SQUARES || ALONE_BATCH)
#error "links by their angles are those of one planar chain"
#endif
#if WITH_PARAMETERS && !WITH_COLUMNS
#error "derivatives by parameters are columns"
#endif
#if WITH_OWN_TRIGONOMETRY && !WITH_FORCING
#error "nothing but a forcing's phase goes through sines and cosines"
#endif
#if WITH_OUTRIGHT && (WITH_SHARED || WITH_PARAMETERS || WITH_SQUARES || WITH_DRY || WITH_RUBS || WITH_FORCING)
#error "orders that come all at once are those of a link that nothing but weight and torque moves"
#endif
#if WITH_BESIDE && (ALONE_BATCH || ALONE_FLOAT || WITH_FORCING)
#error "neighbours fly beside one run in double precision that nothing forces"
#endif
#if WITH_PAIRS && (!WITH_BESIDE || WITH_SPHERE || WITH_DRY || WITH_SQUARES)
#error "pairs are numbers of a planar chain without dry friction, beside its flow"
#endif
#if ALONE_BATCH && (WITH_COLUMNS || defined(PHI_WORK_ON_STACK))
#error "the batch form carries no derivatives and works in the caller's memory"
#endif

#include "alone_numbers.h"

/* --- words of the compiler --- */

#define PHI_RESTRICT restrict
#define PHI_ALIGNED
#define STEM_APART
#define STEM_SINGLY
#define STEM_IN_PLACE inline

/* --- sizes of a small chain --- */

enum {
    stem_q = ALONE_CART + 3,
    stem_x = 2 * stem_q,
    stem_cart = ALONE_CART,
    stem_inputs = 2,
    stem_masses = 1,
    stem_axes = 3,
    stem_lefts = WITH_SHARED ? 3 : 4,
    stem_rights = WITH_SHARED && !WITH_CROSSED ? 1 : 2,
    stem_squares = WITH_SHARED ? 1 : (WITH_SQUARES ? 2 : 0),
    stem_dry = WITH_DRY ? 2 : 0,
    stem_rubs = WITH_RUBS ? 2 : 0,
    stem_width = stem_lefts + 3 * stem_dry + 5 * stem_rubs,
#if WITH_SHARED
    stem_row = stem_cart + stem_width,
#endif
    stem_all = stem_lefts * stem_rights + stem_squares + 2 * stem_dry + 6 * stem_rubs,
    stem_highest = 22,
#if WITH_PARAMETERS
    stem_varied = 4,
#endif
#if WITH_PARAMETERS && WITH_FORCING
    stem_forcing = 2,
#endif
    stem_looks = 4
};
#if WITH_SHARED
#define STEM_LEFT(j) (jet->x[(j) + 1] + stem_cart)
#define STEM_BEGUN (start->row[0] + stem_cart)
#else
#define STEM_LEFT(j) (jet->left[j])
#define STEM_BEGUN (start->left[0])
#endif
extern const phi_real stem_now[stem_highest][4];

/* --- lanes: one number, or one of each trajectory that runs beside others --- */

#if ALONE_VECTORS
#define LANES_CHOOSE(lanes, condition, a, b) ((lanes)(((condition) & (__typeof__(condition))(a)) | (~(condition) & (__typeof__(condition))(b))))
#define LANES_SIZE(lanes, x) ((lanes)((__typeof__((x) < 0))(x) & (sizeof(phi_real) == 4 ? INT32_MAX : INT64_MAX)))
#else
#define LANES_CHOOSE(lanes, condition, a, b) ((condition) ? (a) : (b))
#define LANES_SIZE(lanes, x) phi_abs(x)
#endif
#if ALONE_BATCH && ALONE_VECTORS
typedef phi_real stem_lanes __attribute__((vector_size(64), may_alias));
typedef PHI_WORD stem_words __attribute__((vector_size(64), may_alias));
#define STEM_CHOOSE(condition, a, b) LANES_CHOOSE(stem_lanes, condition, a, b)
#define STEM_SIZE(x) LANES_SIZE(stem_lanes, x)
#else
typedef phi_real stem_lanes;
typedef PHI_WORD stem_words;
#define STEM_CHOOSE(condition, a, b) ((condition) ? (a) : (b))
#define STEM_SIZE(x) phi_abs(x)
#endif
#define STEM_LARGER(a, b) STEM_CHOOSE((a) > (b), a, b)
#if ALONE_BATCH
enum { stem_lane_count = ALONE_VECTORS ? 64 / (int)sizeof(phi_real) : 1 };
#define STEM_ZERO ((0) - (stem_lanes){0})
#else
enum { stem_lane_count = 1 };
#define STEM_ZERO 0
#endif
#define STEM_OF(lanes, lane) (((const phi_real *)&(lanes))[lane])
#define STEM_AT(lanes, lane) (((phi_real *)&(lanes))[lane])

/* --- runtime parameters --- */

typedef struct phi_params {
    phi_real length;
} phi_params;
#if ALONE_PARAMS
#define PASS p,
#define CONTEXT const phi_params *p,
#else
#define PASS
#define CONTEXT
#endif
#if ALONE_PARAMS == 1
#define POSITIONS_PASS p,
#define POSITIONS_CONTEXT const phi_params *p,
#else
#define POSITIONS_PASS
#define POSITIONS_CONTEXT
#endif
#if !WITH_SCALES
void stem_scales(const phi_params *p, phi_real scales[PHI_SCALE_COUNT]);
#endif

/* --- structs --- */

enum {
    STEM_OF_Q,
    STEM_OF_V,
    STEM_OF_DEPTH
};

typedef struct stem_event {
    int scalar, index, direction;
    phi_real value;
} stem_event;

typedef struct stem_start {
    stem_lanes unit[2], held[4];
#if WITH_SHARED
    stem_lanes row[2][stem_row], right[stem_masses + stem_lefts * (stem_rights - 1)];
#else
    stem_lanes slope[stem_x], left[2][stem_width], right[2][stem_lefts * stem_rights];
#endif
#if WITH_FORCING
    stem_lanes later[4], drive[2];
#endif
#if WITH_RUBS
    stem_lanes rubs[stem_highest + 2][stem_rubs];
#endif
} stem_start;

#if WITH_COLUMNS
#if ALONE_VECTORS
typedef phi_real wide_lanes __attribute__((vector_size(16), aligned(sizeof(phi_real)), may_alias));
#else
typedef phi_real wide_lanes;
#endif
enum { wide_lane_count = ALONE_VECTORS ? 16 / (int)sizeof(phi_real) : 1 };
#if WITH_LINKS
enum { wide_links = stem_lefts / 2, wide_room = 24, wide_left_rows = WITH_DRY ? stem_highest + 1 : 2, wide_right_rows = 1 };
#else
enum { wide_left_rows = stem_highest + 1, wide_right_rows = stem_highest + 1 };
#endif
#define WIDE_EVERY(number) ((number) - (wide_lanes){0})
#define WIDE_ZERO WIDE_EVERY(0)
#define WIDE_CHOOSE(condition, a, b) LANES_CHOOSE(wide_lanes, condition, a, b)
#define WIDE_SIZE(x) LANES_SIZE(wide_lanes, x)
#define WIDE_LARGER(a, b) WIDE_CHOOSE((a) > (b), a, b)
#define WIDE_OF(lanes, lane) (((const phi_real *)&(lanes))[lane])
#define WIDE_AT(lanes, lane) (((phi_real *)&(lanes))[lane])
#define ROWS_0 jet->start->held, jet->start->left[0], jet->start->right[0], wide->x[0], wide->x[0] + stem_q,

typedef struct wide_jets {
    wide_lanes x[stem_highest + 1][stem_x], left[wide_left_rows][stem_width];
    wide_lanes right[wide_right_rows][stem_lefts * stem_rights], lead[stem_lefts];
#if WITH_LINKS
    wide_lanes turn[wide_links][stem_highest + 1], arms[2][wide_links][stem_highest + 1];
#endif
#if WITH_PARAMETERS
    wide_lanes along[stem_varied], held[4];
#if WITH_FORCING
    wide_lanes later[4], force[stem_highest + 1];
#endif
#endif
} wide_jets;
#endif

typedef struct stem_jets {
#if ALONE_BATCH
    stem_start starts[2], *start, *end;
#else
    stem_start start[1], end[1];
#endif
#if WITH_SHARED
    stem_lanes x[stem_highest + 2][stem_row], right[stem_highest + 1][stem_masses + stem_lefts * (stem_rights - 1)];
#else
    stem_lanes x[stem_highest + 1][stem_x], left[stem_highest + 1][stem_width];
    stem_lanes right[stem_highest + 1][stem_lefts * stem_rights];
#endif
    stem_lanes sums[4][stem_all];
    stem_lanes state[stem_x], lost[stem_x], moved[stem_x], moved_lost[stem_x];
#if WITH_INPUTS
    stem_lanes u[stem_inputs];
#endif
#if WITH_FORCING
    stem_lanes t, t_lost, amplitude, omega;
#endif
#if WITH_TURNS
    stem_lanes turns[stem_q];
#endif
#if WITH_RUBS
    stem_lanes powers[stem_highest][stem_highest][stem_rubs];
#endif
#if WITH_PARAMETERS
    phi_real kept[stem_highest][stem_all];
#if WITH_FORCING
    phi_real force[stem_highest + 1];
#endif
#endif
#if WITH_COLUMNS
#if WITH_LINKS
    phi_real shared[3][wide_links][wide_room];
#endif
    phi_real columns[sizeof(wide_jets) / sizeof(phi_real)], carried[stem_x * stem_x];
#endif
} stem_jets;
typedef stem_jets phi_workspace;

typedef struct phi_flow {
    phi_real t, tolerance, t_lost, lost[stem_x], *own;
#if WITH_COLUMNS
    phi_real *transition;
    int columns;
#if WITH_PARAMETERS
    phi_real *along, *passed;
#endif
#endif
    phi_workspace *work;
    unsigned long steps, written;
    int order;
} phi_flow;

typedef struct phi_flow_batch {
    phi_real tolerance;
    phi_real *t, *lost;
    unsigned long *steps, *written;
    int *result, order;
} phi_flow_batch;

#include "alone_calls.h"

#endif
