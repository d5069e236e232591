/* Times compiled forward dynamics from C: every candidate on the same random states, in turn, many times over.
 *
 * One sample is the time of `passes` sweeps over all states. Candidates take turns within a round, so that whatever
 * else the machine does touches all of them alike, and ratios are formed round by round.
 */
#include <stddef.h>
#include <stdint.h>
#include <time.h>

enum abi { PLAIN = 0, FLAT = 1 };

typedef struct {
    void (*function)(void); /* cast back to the type its abi names before it is called */
    int abi;
    int passes;
} candidate;

typedef struct {
    const double *states; /* count rows of (q, v, u) */
    size_t count;
    size_t nq, nv, nu;
} workload;

typedef void (*plain_forced)(const double *, const double *, const double *, double *);
typedef void (*plain_unforced)(const double *, const double *, double *);
typedef void (*flat)(double *, const double *, const double *, const double *);

static double nanoseconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return 1e9 * (double)now.tv_sec + (double)now.tv_nsec;
}

static void sweep(const candidate *c, const workload *w, double *out, size_t out_stride)
{
    const size_t width = w->nq + w->nv + w->nu;
    const double *s = w->states;
    if (c->abi == FLAT) {
        flat f = (flat)c->function;
        for (size_t i = 0; i < w->count; ++i)
            f(out + i * out_stride, s + i * width, NULL, NULL);
    } else if (w->nu != 0) {
        plain_forced f = (plain_forced)c->function;
        for (size_t i = 0; i < w->count; ++i)
            f(s + i * width, s + i * width + w->nq, s + i * width + w->nq + w->nv, out + i * out_stride);
    } else {
        plain_unforced f = (plain_unforced)c->function;
        for (size_t i = 0; i < w->count; ++i)
            f(s + i * width, s + i * width + w->nq, out + i * out_stride);
    }
}

/* One evaluation per state, all results kept: out is count x nv. */
void harness_evaluate(const candidate *c, const workload *w, double *out)
{
    sweep(c, w, out, w->nv);
}

/* Nanoseconds per evaluation, samples[round * candidates + i]; scratch holds nv doubles. */
void harness_measure(const candidate *list, int candidates, const workload *w, int rounds, double *scratch,
                     double *samples)
{
    for (int round = 0; round < rounds; ++round) {
        for (int turn = 0; turn < candidates; ++turn) {
            /* the order rotates: nobody always runs in the same neighbour's wake */
            const int i = (turn + round) % candidates;
            const candidate *c = &list[i];
            sweep(c, w, scratch, 0); /* its code and the states back into the caches, unmeasured */
            const double start = nanoseconds();
            for (int pass = 0; pass < c->passes; ++pass)
                sweep(c, w, scratch, 0);
            const double spent = nanoseconds() - start;
            samples[(size_t)round * (size_t)candidates + (size_t)i] =
                spent / ((double)c->passes * (double)w->count);
        }
    }
}
