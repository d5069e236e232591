/* Times compiled functions from C: every candidate on the same random states, in turn, many times over.
 *
 * All candidates have one signature, f(out, state, parameters, time). A sample is the time of a fixed number of
 * evaluations that walk on through the states, so that slow candidates meet as many of them as fast ones over the
 * rounds. Candidates take turns within a round: whatever else the machine does touches all of them alike, and ratios
 * are formed round by round.
 *
 * Independent: no result feeds the next evaluation, so the processor overlaps them (throughput). Chained: every entry
 * of the next state waits for results of the last evaluation, as in an integrator (latency).
 */
#include <stddef.h>
#include <time.h>

typedef void evaluation(double *out, const double *state, const double *parameters, const double *time);

typedef struct {
    evaluation *function;
    size_t evaluations; /* in one sample */
    size_t at;          /* the state that comes next */
} candidate;

typedef struct {
    const double *states; /* count rows of (q, v, u) */
    const double *parameters;
    size_t count, width, outputs;
} workload;

/* Zero, but the compiler does not know: 0 x result carries a dependence and no value. */
static volatile double nothing = 0.0;

static double nanoseconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return 1e9 * (double)now.tv_sec + (double)now.tv_nsec;
}

static void independent(candidate *c, const workload *w, size_t evaluations, double *out)
{
    for (size_t i = 0; i < evaluations; ++i) {
        c->function(out, w->states + c->at * w->width, w->parameters, NULL);
        if (++c->at == w->count)
            c->at = 0;
    }
}

static void chained(candidate *c, const workload *w, size_t evaluations, double *out, double *state)
{
    const double zero = nothing;
    for (size_t i = 0; i < evaluations; ++i) {
        const double *next = w->states + c->at * w->width;
        for (size_t j = 0, k = 0; j < w->width; ++j) {
            state[j] = next[j] + zero * out[k];
            if (++k == w->outputs)
                k = 0;
        }
        c->function(out, state, w->parameters, NULL);
        if (++c->at == w->count)
            c->at = 0;
    }
}

/* One evaluation for each of the first `count` states, all results kept: out is count x outputs. */
void harness_evaluate(const candidate *c, const workload *w, size_t count, double *out)
{
    for (size_t i = 0; i < count; ++i)
        c->function(out + i * w->outputs, w->states + i * w->width, w->parameters, NULL);
}

/* Nanoseconds per evaluation, samples[round * candidates + i]; scratch holds outputs + width doubles, zeros. */
void harness_measure(candidate *list, int candidates, const workload *w, int rounds, int is_chained, double *scratch,
                     double *samples)
{
    double *out = scratch, *state = scratch + w->outputs;
    for (int round = 0; round < rounds; ++round) {
        for (int turn = 0; turn < candidates; ++turn) {
            /* the order rotates: nobody always runs in the same neighbour's wake */
            candidate *c = &list[(turn + round) % candidates];
            /* its code and the states back into the caches, unmeasured */
            independent(c, w, 1 + c->evaluations / 8, out);
            const double start = nanoseconds();
            if (is_chained)
                chained(c, w, c->evaluations, out, state);
            else
                independent(c, w, c->evaluations, out);
            const double spent = nanoseconds() - start;
            samples[(size_t)round * (size_t)candidates + (size_t)(c - list)] = spent / (double)c->evaluations;
        }
    }
}
