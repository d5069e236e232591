/* What a call of a stencil is given and returns, and prototypes of the Programs: the rest of `alone.h`. */
#ifndef PHICHAIN_ALONE_CALLS_H
#define PHICHAIN_ALONE_CALLS_H

/* What a batch keeps of its trajectories. */
typedef struct stem_state {
    size_t trajectory[stem_lane_count];
    int busy[stem_lane_count], is_new[stem_lane_count], result[stem_lane_count];
    phi_real t[stem_lane_count], t_lost[stem_lane_count], t_end[stem_lane_count];
    phi_real h[stem_lane_count], left[stem_lane_count], at_event[stem_lane_count];
    unsigned long steps[stem_lane_count], written[stem_lane_count];
} stem_state;

/* --- what a call is given and returns --- */

enum {
    PHI_DONE,
    PHI_EVENT,
    PHI_STEP_BUDGET,
    PHI_NOT_FINITE,
    PHI_NO_WORKSPACE
};
enum {
    PHI_BATCH_DONE,
    PHI_BATCH_EVENT,
    PHI_BATCH_STEP_BUDGET,
    PHI_BATCH_NOT_FINITE
};
enum { stem_goes_on = -1 };
#define PHI_BATCH_WORK 100000

#if WITH_INPUTS
#define INPUTS jet->u,
#define PASS_INPUTS u,
#define INPUTS_OF_ALL const phi_real u[],
#define OWN_INPUTS const phi_real u[stem_inputs],
#define LANES_OF_INPUTS const stem_lanes *u,
#else
#define INPUTS
#define PASS_INPUTS
#define INPUTS_OF_ALL
#define OWN_INPUTS
#define LANES_OF_INPUTS
#endif
#if WITH_FORCING
#define FORCE(of) of,
#define AFTER(time) time,
#define BEHIND later
#define LANES_OF_FORCE const stem_lanes *force,
#define LANES_LATER stem_lanes *later,
#define PASS_FORCING amplitude, omega,
#define FORCING_OF_ALL const phi_real amplitude[], const phi_real omega[],
#define OWN_FORCING const phi_real amplitude, const phi_real omega,
#else
#define FORCE(of)
#define AFTER(time)
#define BEHIND held
#define LANES_OF_FORCE
#define LANES_LATER
#define PASS_FORCING
#define FORCING_OF_ALL
#define OWN_FORCING
#endif

#if ALONE_BATCH
#define ARGUMENTS CONTEXT const size_t n, phi_flow_batch *flow, const phi_real t_end[], const unsigned long max_steps, INPUTS_OF_ALL FORCING_OF_ALL phi_real q[], phi_real v[], const stem_event *event, const unsigned long count, const phi_real times[], phi_real q_out[], phi_real v_out[], void *work
size_t phi_propagate_batch(ARGUMENTS);
#else
#define ARGUMENTS CONTEXT phi_flow *flow, const phi_real t_end, const unsigned long max_steps, OWN_INPUTS OWN_FORCING phi_real q[stem_q], phi_real v[stem_q], const stem_event *event, const unsigned long count, const phi_real *times, phi_real *q_out, phi_real *v_out OWN_BESIDE
#define PASS_ALL PASS flow, t_end, max_steps, PASS_INPUTS PASS_FORCING q, v, event, count, times, q_out, v_out PASS_BESIDE
#if WITH_BESIDE
struct stem_stop;
struct stem_beside;
#define OWN_BESIDE , const int goes_on, struct stem_stop *stop, phi_real *steps
#define PASS_BESIDE , goes_on, stop, steps
#define JUDGED CONTEXT OWN_INPUTS const unsigned long count, const phi_real *steps, const phi_real tolerance, struct stem_beside *room, phi_real *errors
#else
#define OWN_BESIDE
#define PASS_BESIDE
#endif
int phi_propagate(ARGUMENTS);
#endif

/* --- Programs --- */

#if WITH_PARAMETERS
#define VARIES(...) __VA_ARGS__,
#define ALONG_FACTOR wide->along,
#define ALONG_ORDER wide->along,
#else
#define VARIES(...)
#endif

#if WITH_LOST
#define LOST lost,
#define LANES_LOST const stem_lanes *lost,
#else
#define LOST
#define LANES_LOST
#endif
#if ALONE_NEWEST
#define NEWEST(row) row,
#define LANES_NEWEST(lanes) const lanes *newest,
#define LANES_NEWEST_TOO const wide_lanes *d_newest,
#else
#define LANES_NEWEST_TOO
#define NEWEST(row)
#define LANES_NEWEST(lanes)
#endif

void stem_factor(CONTEXT const stem_lanes *q, const stem_lanes *v, LANES_OF_INPUTS LANES_OF_FORCE const stem_lanes *scale, LANES_LOST stem_lanes *held, LANES_LATER stem_lanes *left, stem_lanes *right);
#if WITH_SHARED
void stem_order(CONTEXT const stem_lanes *held, const stem_lanes *sums, const stem_lanes *row, const stem_lanes *row_after, const phi_real now[4], LANES_OF_FORCE stem_lanes *row_ahead, stem_lanes *right);
#else
#if WITH_OUTRIGHT
#if WITH_COLUMNS
void stem_outright(CONTEXT const stem_lanes *held, const stem_lanes *right, const stem_lanes *slope, stem_lanes *left, stem_lanes *rates, stem_lanes *rows);
#else
void stem_outright(CONTEXT const stem_lanes *held, const stem_lanes *right, const stem_lanes *slope, stem_lanes *rows);
#endif
#endif
void stem_order(CONTEXT const stem_lanes *held, const stem_lanes *sums, LANES_NEWEST(stem_lanes) const stem_lanes *coefficient, const phi_real now[4], LANES_OF_FORCE stem_lanes *left, stem_lanes *right, stem_lanes *next);
#endif
void phi_positions(POSITIONS_CONTEXT const phi_real *q, phi_real *place);
#if WITH_OWN_TRIGONOMETRY
void phi_sincos(int n, const phi_real *angle, phi_real *sine, phi_real *cosine);
#endif
#if WITH_SPHERE
void stem_enter(const phi_real *q, const phi_real *v, phi_real *rate);
void stem_leave(const phi_real *q, const phi_real *rate, phi_real *q_out, phi_real *v_out);
void stem_settle(const stem_lanes *x, const stem_lanes *lost, stem_lanes *settled);
#endif
#if WITH_COLUMNS
void stem_enter_column(const phi_real *q, const phi_real *v, const phi_real *dq, const phi_real *dv, phi_real *d_rate);
void stem_leave_column(const phi_real *q, const phi_real *rate, const phi_real *dq, const phi_real *d_rate, phi_real *dq_out, phi_real *dv_out);
void wide_rows(CONTEXT const phi_real *held, const phi_real *left, const phi_real *right, const wide_lanes *dq, const wide_lanes *dv, wide_lanes *lead, wide_lanes *d_left, wide_lanes *d_right);
void wide_order(CONTEXT const phi_real *held, const wide_lanes *sums, LANES_NEWEST(wide_lanes) const wide_lanes *coefficient, const phi_real now[4], wide_lanes *left, wide_lanes *right, wide_lanes *next);
#if WITH_PARAMETERS
#if WITH_FORCING
#define D_FORCE const wide_lanes *d_force,
#define D_LATER wide_lanes *d_later,
#else
#define D_FORCE
#define D_LATER
#endif
void wide_factor_along(CONTEXT const phi_real *q, const phi_real *v, LANES_OF_INPUTS LANES_OF_FORCE const phi_real *scale, LANES_LOST D_FORCE const wide_lanes *d_length, D_LATER wide_lanes *d_held);
void wide_order_along(CONTEXT const phi_real *held, const phi_real *sums, LANES_NEWEST(phi_real) const phi_real *coefficient, const phi_real now[4], LANES_OF_FORCE const wide_lanes *d_held, const wide_lanes *d_sums, LANES_NEWEST_TOO const wide_lanes *d_coefficient, D_FORCE const wide_lanes *d_length, wide_lanes *d_left, wide_lanes *d_right, wide_lanes *d_next);
#endif
#endif

#endif
