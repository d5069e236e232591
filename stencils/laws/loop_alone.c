/* loop.c compiled without a chain and a law: what one puts into it. */
#define LOOP_NX 4
#define LOOP_NU 1
#define LOOP_NY 2
#define LOOP_LATEST 10
#define LOOP_STATE law_state state;
#define LOOP_RESET law_reset(&state);
#define LOOP_CALL *phase = law_call(&state, measured, pushed);

#include <math.h>

typedef double phi_real;
typedef float law_real;
typedef struct phi_params {
    phi_real mass[1];
} phi_params;
typedef struct law_state {
    int phase;
} law_state;
typedef struct loop_task {
    long calls, every, steps, lost;
    double sample;
    double target[LOOP_NX], turns[LOOP_NX], near[LOOP_NX];
    double resolution[LOOP_NY];
    long reads[LOOP_NY];
} loop_task;

#if WITH_PARAMS
#define LOOP_PARAMS phi_params
#define LOOP_CONTEXT const phi_params *const p,
#define LOOP_PASS p,
#else
#define LOOP_PARAMS phi_real
#define LOOP_CONTEXT
#define LOOP_PASS
#endif
#if WITH_STEP
void phi_step(LOOP_CONTEXT phi_real h, const phi_real *q, const phi_real *v, const phi_real *u, phi_real *q_next, phi_real *v_next);
#else
void phi_forward_dynamics(LOOP_CONTEXT const phi_real *q, const phi_real *v, const phi_real *u, phi_real *a);
#endif

int law_call(law_state *state, const law_real *measured, law_real *u);
void law_reset(law_state *state);
void loop_runs(long runs, const loop_task *task, const long *late, const LOOP_PARAMS *parameters, phi_real *x, phi_real *largest, long *since, int *phases, phi_real *trace);

#include "laws/loop.c"
