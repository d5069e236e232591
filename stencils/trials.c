/* Runs of a compiled law on a compiled chain, each with parameters of its own: the law is called once a sample and its inputs are held. */

static void trial_rates(TRIAL_CONTEXT const phi_real x[TRIAL_NX], const phi_real u[TRIAL_NU], phi_real rate[TRIAL_NX])
{
    for (int i = 0; i < TRIAL_NX / 2; ++i) {
        rate[i] = x[TRIAL_NX / 2 + i];
    }
    phi_forward_dynamics(TRIAL_PASS x, x + TRIAL_NX / 2, u, rate + TRIAL_NX / 2);
}

/* One step of the classical Runge-Kutta method. */
static void trial_step(TRIAL_CONTEXT const phi_real h, const phi_real u[TRIAL_NU], phi_real x[TRIAL_NX])
{
    phi_real k[4][TRIAL_NX], at[TRIAL_NX];

    trial_rates(TRIAL_PASS x, u, k[0]);
    for (int stage = 1; stage < 4; ++stage) {
        const phi_real share = stage < 3 ? h / 2 : h;
        for (int i = 0; i < TRIAL_NX; ++i) {
            at[i] = x[i] + share * k[stage - 1][i];
        }
        trial_rates(TRIAL_PASS at, u, k[stage]);
    }
    for (int i = 0; i < TRIAL_NX; ++i) {
        x[i] += h / 6 * (k[0][i] + 2 * (k[1][i] + k[2][i]) + k[3][i]);
    }
}

/* What the law reads of a state: the nearest step of every sensor that has steps, whose resolution is above zero. */
static void trial_measured(const phi_real x[TRIAL_NX], const phi_real resolution[TRIAL_READ], law_real measured[TRIAL_READ])
{
    for (int i = 0; i < TRIAL_READ; ++i) {
        const phi_real steps = resolution[i] > 0 ? x[i] / resolution[i] : 0;
        /* A state that is no number, or far beyond all sense, is handed on as it is. */
        const int is_stepped = resolution[i] > 0 && steps < 1e9 && steps > -1e9;

        measured[i] = (law_real)(is_stepped ? resolution[i] * (phi_real)(long)(steps + (steps < 0 ? -0.5 : 0.5)) : x[i]);
    }
}

/* One run of so many samples. x is the start and becomes the end; largest holds the largest distance of x[0] from 0 and then the
 * largest size of every input; trace, if it is there, the state and the inputs of every sample. Returns the last phase. */
static int trial_run(TRIAL_CONTEXT const long samples, const phi_real sample, const int steps, const phi_real resolution[TRIAL_READ],
    phi_real x[TRIAL_NX], phi_real largest[1 + TRIAL_NU], phi_real *trace)
{
    law_state state;
    law_real measured[TRIAL_READ];

    trial_measured(x, resolution, measured);
#if WITH_OBSERVER
    law_reset(&state, measured);
#else
    law_reset(&state);
#endif
    for (long k = 0; k < samples; ++k) {
        law_real pushed[TRIAL_NU];
        phi_real u[TRIAL_NU];

        trial_measured(x, resolution, measured);
        if (law_call(&state, (law_real)((phi_real)k * sample), measured, pushed) == LAW_LOST) {
            return LAW_LOST;
        }
        for (int i = 0; i < TRIAL_NU; ++i) {
            u[i] = (phi_real)pushed[i];
            const phi_real size = u[i] < 0 ? -u[i] : u[i];
            largest[1 + i] = size > largest[1 + i] ? size : largest[1 + i];
        }
        if (trace) {
            for (int i = 0; i < TRIAL_NX; ++i) {
                *trace++ = x[i];
            }
            for (int i = 0; i < TRIAL_NU; ++i) {
                *trace++ = u[i];
            }
        }
        for (int step = 0; step < steps; ++step) {
            trial_step(TRIAL_PASS sample / steps, u, x);
        }
        const phi_real far = x[0] < 0 ? -x[0] : x[0];
        largest[0] = far > largest[0] ? far : largest[0];
    }
    return (int)state.phase;
}

/* Many runs: x (runs, nx), parameters (runs, as the struct has them), largest (runs, 1 + nu), phases (runs). */
void trial_runs(const long runs, const long samples, const phi_real sample, const int steps, const phi_real resolution[TRIAL_READ],
    const TRIAL_PARAMS *parameters, phi_real *x, phi_real *largest, int *phases, phi_real *trace)
{
    for (long run = 0; run < runs; ++run) {
#if WITH_PARAMS
        const TRIAL_PARAMS *const p = &parameters[run];
#endif
        phases[run] = trial_run(TRIAL_PASS samples, sample, steps, resolution, &x[run * TRIAL_NX], &largest[run * (1 + TRIAL_NU)], trace);
    }
#if !WITH_PARAMS
    (void)parameters;
#endif
}
