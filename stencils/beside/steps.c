/* What a run leaves of its steps, for those who ask later how large its errors are. */
enum {
    stem_left_out = 15, /* binary digits of a step's change of a neighbour, where a run is short */
    stem_short = 9, /* those of the radians that the fastest linear motion goes through in a run that is */
    stem_paired = 3 /* orders whose rounding is known with its sign */
};

typedef struct stem_step {
    phi_real written, low, h, unit; /* rows of states that were written up to its end; first coefficients that follow */
    phi_real state[stem_x], error[stem_x]; /* where it began, and what its series leaves */
#if WITH_PAIRS
    phi_real lost[stem_x], gap[stem_x], rest[stem_x]; /* of where it began; what it moved by beyond its first coefficients, as a pair */
#endif
#if WITH_SPHERE
    phi_real moved[stem_x]; /* where it ended */
#endif
    phi_real rates[]; /* first coefficients of the rates, from order 1 on */
} stem_step;

/* What a run that stopped for want of room goes on with, as if it had not. */
typedef struct stem_stop {
    stem_start end;
    phi_real state[stem_x], lost[stem_x], unit;
#if WITH_TURNS
    phi_real turns[stem_q];
#endif
    int is_new, low;
} stem_stop;

/* The low order at which what is left out of a neighbour's way does not add up over a run: terms fall as the root of the goal. A motion
 * that is no chaos, stiff springs above all, may go on for many steps, of which there are as many as there are radians of its fastest. */
static int stem_low_for(const phi_real goal, const int order, const phi_real span, const phi_real fastest)
{
    const stem_lanes one = STEM_ZERO + 1, size = STEM_ZERO + goal, radians = STEM_ZERO + phi_abs(span) * fastest;
    stem_lanes root, turned;
    stem_root(order, &one, &size, &root);
    stem_root(1, &one, &radians, &turned);
    const phi_real longer = stem_larger(STEM_OF(turned, 0) - stem_short, 0);
    const phi_real wanted = (stem_left_out + longer + longer / 2) / -STEM_OF(root, 0);
    return wanted < (phi_real)order ? (int)wanted : order;
}

/* Where a step lies among those of so many coefficients. */
static size_t stem_place(const int low, const unsigned long k)
{
    return (sizeof(stem_step) / sizeof(phi_real) + (size_t)(low * stem_q)) * k;
}

static void stem_keep(const stem_jets *jet, const phi_real unit, const int is_new, const int low, stem_stop *stop)
{
    memcpy(&stop->end, jet->end, sizeof stop->end);
    memcpy(stop->state, jet->state, sizeof stop->state);
    memcpy(stop->lost, jet->lost, sizeof stop->lost);
#if WITH_TURNS
    memcpy(stop->turns, jet->turns, sizeof stop->turns);
#endif
    stop->unit = unit;
    stop->is_new = is_new;
    stop->low = low;
}

static void stem_go_on(const stem_stop *stop, stem_jets *jet, phi_real *unit, int *is_new, int *low)
{
    memcpy(jet->end, &stop->end, sizeof stop->end);
    memcpy(jet->state, stop->state, sizeof stop->state);
    memcpy(jet->lost, stop->lost, sizeof stop->lost);
#if WITH_TURNS
    memcpy(jet->turns, stop->turns, sizeof stop->turns);
#endif
    *unit = stop->unit;
    *is_new = stop->is_new;
    *low = stop->low;
}

#if WITH_PAIRS
/* Whether rounding is a part of a step's error that is worth its price. */
static int stem_rounds(const phi_real goal)
{
    return goal < 4096 * PHI_EPSILON;
}

/* What a step moved the state by, less what its series has behind the orders that are known with their rounding. */
static void stem_note_gap(const int order, const stem_jets *jet, const phi_real unit, const phi_real h, stem_step *step)
{
    const phi_real t = h / unit;
    phi_real tail[stem_x] = {0};
    for (int n = order; n > stem_paired; --n) {
        for (int i = 0; i < stem_x; ++i) {
            tail[i] = tail[i] * t + jet->x[n][i];
        }
    }
    for (int i = 0; i < stem_x; ++i) {
        const stem_pair begun = {jet->state[i], jet->lost[i]}, ended = {jet->moved[i], jet->moved_lost[i]}, left_out = {-tail[i], 0};
        stem_pair rest = stem_scale(left_out, i < stem_q ? t : t / unit);
        for (int n = 0; n < stem_paired; ++n) {
            rest = stem_scale(rest, t);
        }
        rest = stem_add(stem_subtract(ended, begun), rest);
        step->gap[i] = rest.value;
        step->rest[i] = rest.rest;
    }
    memcpy(step->lost, jet->lost, sizeof step->lost);
}
#endif

/* A step that has been taken, and its error: what its series leaves, by how far that is from the equations at its end, which grows as
 * the order's power of time. Angles have rates for slopes, so that they lack the last of these terms and what the rates lack. */
static void stem_note(const phi_real goal, const int order, const int low, const stem_jets *jet, const phi_real h, stem_step *step)
{
    const phi_real unit = jet->start->unit[0], t = h / unit, ratio = unit / jet->end->unit[0], share = t / unit;
    phi_real power = t;
    for (int n = 0; n < order; ++n) {
        power *= t;
    }
    for (int i = stem_q; i < stem_x; ++i) {
        const phi_real square = t * t;
        phi_real even = 0, odd = 0;
        for (int n = order - order % 2; n > 0; n -= 2) {
            even = even * square + (phi_real)n * jet->x[n][i];
        }
        for (int n = order - (order + 1) % 2; n > 0; n -= 2) {
            odd = odd * square + (phi_real)n * jet->x[n][i];
        }
        const phi_real left = share * ((even * t + odd) - ratio * ratio * jet->end->slope[i]) / (phi_real)(order + 1);
        step->error[i] = left;
        step->error[i - stem_q] = h * left / (phi_real)(order + 2) - power * jet->x[order][i] / (phi_real)(order + 1);
    }
    memcpy(step->state, jet->state, sizeof step->state);
#if WITH_SPHERE
    memcpy(step->moved, jet->moved, sizeof step->moved);
#endif
    for (int n = 0; n < low; ++n) {
        memcpy(step->rates + n * stem_q, jet->x[n + 1] + stem_q, stem_q * sizeof *step->rates);
    }
#if WITH_PAIRS
    if (stem_rounds(goal)) {
        stem_note_gap(order, jet, unit, h, step);
    }
#else
    (void)goal;
#endif
    step->low = (phi_real)low;
    step->h = h;
    step->unit = unit;
}

