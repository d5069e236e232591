/* Runs of a compiled law on a compiled chain, each with parameters of its own: the law is called once a sample on what its sensors read,
 * its inputs come late by whole samples and are held in between. */

/* What a sensor of this resolution reads; one of none reads exactly. */
static phi_real loop_read(const phi_real value, const phi_real resolution)
{
    return resolution > 0 ? resolution * floor(value / resolution + 0.5) : value;
}

#if WITH_STEP
/* One step of the chain's own. */
static void loop_step(LOOP_CONTEXT const phi_real h, const phi_real u[LOOP_NU], phi_real x[LOOP_NX])
{
    phi_real after[LOOP_NX];

    phi_step(LOOP_PASS h, x, x + LOOP_NX / 2, u, after, after + LOOP_NX / 2);
    for (int i = 0; i < LOOP_NX; ++i) {
        x[i] = after[i];
    }
}
#else
static void loop_rates(LOOP_CONTEXT const phi_real x[LOOP_NX], const phi_real u[LOOP_NU], phi_real rate[LOOP_NX])
{
    for (int i = 0; i < LOOP_NX / 2; ++i) {
        rate[i] = x[LOOP_NX / 2 + i];
    }
    phi_forward_dynamics(LOOP_PASS x, x + LOOP_NX / 2, u, rate + LOOP_NX / 2);
}

/* One step of the classical Runge-Kutta method. */
static void loop_step(LOOP_CONTEXT const phi_real h, const phi_real u[LOOP_NU], phi_real x[LOOP_NX])
{
    phi_real k[4][LOOP_NX], at[LOOP_NX];

    loop_rates(LOOP_PASS x, u, k[0]);
    for (int stage = 1; stage < 4; ++stage) {
        const phi_real share = stage < 3 ? h / 2 : h;
        for (int i = 0; i < LOOP_NX; ++i) {
            at[i] = x[i] + share * k[stage - 1][i];
        }
        loop_rates(LOOP_PASS at, u, k[stage]);
    }
    for (int i = 0; i < LOOP_NX; ++i) {
        x[i] += h / 6 * (k[0][i] + 2 * (k[1][i] + k[2][i]) + k[3][i]);
    }
}
#endif

/* Whether every entry is near the target, angles less whole turns. */
static int loop_is_near(const phi_real x[LOOP_NX], const loop_task *task)
{
    for (int i = 0; i < LOOP_NX; ++i) {
        const phi_real turn = task->turns[i], away = x[i] - task->target[i];
        const phi_real off = turn > 0 ? away - turn * floor(away / turn + 0.5) : away;

        if (!(off <= task->near[i] && off >= -task->near[i])) {
            return 0;
        }
    }
    return 1;
}

/* One run. x is the start and becomes the end; largest holds the largest distance of x[0] from 0 and then the largest size of every
 * input; phase what the law called itself last, 0 of one that says nothing; trace, if it is there, state and inputs of every so many samples.
 * A run ends where the law says that it gives up. Returns after which call the target was not left any more. */
static long loop_run(LOOP_CONTEXT const loop_task *task, const long late, phi_real x[LOOP_NX], phi_real largest[1 + LOOP_NU], int *phase,
    phi_real *trace)
{
    phi_real queue[LOOP_LATEST + 1][LOOP_NU] = { { 0 } };
    long since = 0;
    LOOP_STATE
    *phase = 0;
    for (long k = 0; k < task->calls; ++k) {
        law_real measured[LOOP_NY], pushed[LOOP_NU];

        for (int i = 0; i < LOOP_NY; ++i) {
            measured[i] = (law_real)loop_read(x[task->reads[i]], task->resolution[i]);
        }
        if (k == 0) {
            LOOP_RESET
        }
        LOOP_CALL
        if (*phase == task->lost) {
            return task->calls;
        }
        for (int i = 0; i < LOOP_NU; ++i) {
            const phi_real u = (phi_real)pushed[i], size = u < 0 ? -u : u;

            queue[k % (late + 1)][i] = u;
            largest[1 + i] = size > largest[1 + i] ? size : largest[1 + i];
        }
        const phi_real *u = queue[(k + 1) % (late + 1)];
        if (trace && k % task->every == 0) {
            for (int i = 0; i < LOOP_NX; ++i) {
                *trace++ = x[i];
            }
            for (int i = 0; i < LOOP_NU; ++i) {
                *trace++ = u[i];
            }
        }
        for (int step = 0; step < task->steps; ++step) {
            loop_step(LOOP_PASS task->sample / (phi_real)task->steps, u, x);
        }
        const phi_real far = x[0] < 0 ? -x[0] : x[0];
        largest[0] = far > largest[0] ? far : largest[0];
        since = loop_is_near(x, task) ? since : k + 1;
    }
    return since;
}

/* Many runs: late (runs), parameters (runs, as the struct has them), x (runs, nx), largest (runs, 1 + nu), since (runs),
 * phases (runs). */
void loop_runs(const long runs, const loop_task *task, const long *late, const LOOP_PARAMS *parameters, phi_real *x, phi_real *largest,
    long *since, int *phases, phi_real *trace)
{
    for (long run = 0; run < runs; ++run) {
#if WITH_PARAMS
        const LOOP_PARAMS *const p = &parameters[run];
#endif
        since[run] = loop_run(LOOP_PASS task, late[run], &x[run * LOOP_NX], &largest[run * (1 + LOOP_NU)], &phases[run], trace);
    }
#if !WITH_PARAMS
    (void)parameters;
#endif
}
