/* trials.c compiled without a chain and a law: what one puts into it. */
#define TRIAL_NX 4
#define TRIAL_NU 1
#if WITH_OBSERVER
#define TRIAL_READ 2
#else
#define TRIAL_READ 4
#endif
#define LAW_LOST 2

typedef double phi_real;
typedef float law_real;
typedef struct phi_params {
    phi_real mass[1];
} phi_params;
typedef struct law_state {
    int phase;
} law_state;

#if WITH_PARAMS
#define TRIAL_PARAMS phi_params
#define TRIAL_CONTEXT const phi_params *const p,
#define TRIAL_PASS p,
void phi_forward_dynamics(const phi_params *p, const phi_real *q, const phi_real *v, const phi_real *u, phi_real *a);
#else
#define TRIAL_PARAMS phi_real
#define TRIAL_CONTEXT
#define TRIAL_PASS
void phi_forward_dynamics(const phi_real *q, const phi_real *v, const phi_real *u, phi_real *a);
#endif

int law_call(law_state *state, law_real t, const law_real *measured, law_real *u);
#if WITH_OBSERVER
void law_reset(law_state *state, const law_real *measured);
#else
void law_reset(law_state *state);
#endif
void trial_runs(long runs, long samples, phi_real sample, int steps, const phi_real resolution[TRIAL_READ], const TRIAL_PARAMS *parameters, phi_real *x, phi_real *largest, int *phases, phi_real *trace);

#include "trials.c"
