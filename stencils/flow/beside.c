/* What a run leaves of its steps, and what flies beside them when somebody asks how large its errors are: neighbours, each off the path
 * by what the errors of all steps so far have come to, over a share that keeps them in its tangent. Low orders over the run's own steps
 * will do, of the path as of its neighbours, so that what both leave out cancels. Only near round-off is the sign of an error chance,
 * and a second neighbour worth while. */
enum {
    stem_neighbours = 2,
    stem_low = 5
};

typedef struct stem_step {
    phi_real written, h, unit; /* rows of states that were written up to its end */
    phi_real state[stem_x], error[stem_x]; /* where it began, and what its series leaves */
    phi_real rates[stem_low][stem_q]; /* first coefficients of the rates, from order 1 on */
#if WITH_SPHERE
    phi_real moved[stem_x]; /* where it ended */
#endif
} stem_step;

/* What a run that stopped for want of room goes on with, as if it had not. */
typedef struct stem_stop {
    stem_start end;
    phi_real state[stem_x], lost[stem_x], unit;
#if WITH_TURNS
    phi_real turns[stem_q];
#endif
    int is_new;
} stem_stop;

typedef struct stem_beside {
    stem_jets jet;
    phi_real off[stem_neighbours][stem_x], share[stem_neighbours]; /* from the path; what a unit of that stands for */
    stem_words drawn;
    int lost;
} stem_beside;

static void stem_keep(const stem_jets *jet, const phi_real unit, const int is_new, stem_stop *stop)
{
    memcpy(&stop->end, jet->end, sizeof stop->end);
    memcpy(stop->state, jet->state, sizeof stop->state);
    memcpy(stop->lost, jet->lost, sizeof stop->lost);
#if WITH_TURNS
    memcpy(stop->turns, jet->turns, sizeof stop->turns);
#endif
    stop->unit = unit;
    stop->is_new = is_new;
}

static void stem_go_on(const stem_stop *stop, stem_jets *jet, phi_real *unit, int *is_new)
{
    memcpy(jet->end, &stop->end, sizeof stop->end);
    memcpy(jet->state, stop->state, sizeof stop->state);
    memcpy(jet->lost, stop->lost, sizeof stop->lost);
#if WITH_TURNS
    memcpy(jet->turns, stop->turns, sizeof stop->turns);
#endif
    *unit = stop->unit;
    *is_new = stop->is_new;
}

/* A step that has been taken, and its error: what its series leaves, by how far that is from the equations at its end, which grows as
 * the order's power of time. Angles have rates for slopes, so that they lack the last of these terms and what the rates lack. */
static void stem_note(const int order, const stem_jets *jet, const phi_real h, stem_step *step)
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
    for (int n = 0; n < stem_low; ++n) {
        memcpy(step->rates[n], jet->x[n + 1] + stem_q, sizeof step->rates[n]);
    }
    step->h = h;
    step->unit = unit;
}

#if WITH_SPHERE
/* Of a difference what a run keeps, which sets its links' lengths and their rates right after every step. */
static void stem_tangent(const phi_real state[stem_x], phi_real off[stem_x])
{
    for (int i = stem_cart; i < stem_q; i += 3) {
        const phi_real *q = state + i, *rate = state + stem_q + i;
        phi_real *aside = off + i, *faster = off + stem_q + i;
        const phi_real stretched = q[0] * aside[0] + q[1] * aside[1] + q[2] * aside[2];
        for (int k = 0; k < 3; ++k) {
            aside[k] -= q[k] * stretched;
        }
        const phi_real along = q[0] * faster[0] + q[1] * faster[1] + q[2] * faster[2];
        const phi_real tilted = along + (rate[0] * aside[0] + rate[1] * aside[1] + rate[2] * aside[2]);
        for (int k = 0; k < 3; ++k) {
            faster[k] -= q[k] * tilted;
        }
    }
}
#endif

/* What angles and rates move by over a step, from the first coefficients of the rates; angles have rates for slopes. */
static void stem_forward(const stem_step *step, const phi_real rates[stem_low][stem_q], const phi_real rate[stem_q], phi_real increment[stem_x])
{
    const phi_real unit = step->unit, t = step->h / unit;
    for (int i = 0; i < stem_q; ++i) {
        phi_real faster = 0, farther = 0;
        for (int n = stem_low; n > 0; --n) {
            farther = farther * t + rates[n - 1][i] / (phi_real)(n + 1);
            faster = faster * t + rates[n - 1][i];
        }
        increment[i] = (rate[i] * unit + farther * t) * t;
        increment[stem_q + i] = faster * t / unit;
    }
}

/* What a neighbour becomes over a step. */
static void stem_follow(CONTEXT const stem_step *step, phi_real off[stem_x], stem_jets *beside)
{
    phi_real apart[stem_low][stem_q], increment[stem_x];
    for (int i = 0; i < stem_x; ++i) {
        beside->state[i] = step->state[i] + off[i];
    }
    stem_begin(PASS beside, beside->state, beside->lost, &step->unit, beside->start);
    stem_expand(PASS stem_low, beside);
    for (int n = 0; n < stem_low; ++n) {
        for (int i = 0; i < stem_q; ++i) {
            apart[n][i] = beside->x[n + 1][stem_q + i] - step->rates[n][i];
        }
    }
    stem_forward(step, (const phi_real(*)[stem_q])apart, off + stem_q, increment);
    for (int i = 0; i < stem_x; ++i) {
        off[i] += increment[i];
    }
}

/* The error of a step, and half a unit in the last place of what the state moves by, of either sign. */
static void stem_local(const stem_step *step, stem_words *drawn, phi_real error[stem_x])
{
    phi_real increment[stem_x];
    stem_forward(step, step->rates, step->state + stem_q, increment);
    for (int i = 0; i < stem_x; ++i) {
        const phi_real rounding = PHI_EPSILON / 2 * increment[i];
        *drawn = *drawn * 6364136223846793005u + 1442695040888963407u;
        error[i] = step->error[i] + (*drawn >> 63 ? rounding : -rounding);
    }
}

/* Go on with the neighbours over a step, along which the path's series are known, and say how far off angles and rates are at its end. */
static void stem_watch(CONTEXT const stem_step *step, const phi_real goal, const phi_real scales[2], stem_beside *room, phi_real error[2])
{
    const int count = goal < 16 * PHI_EPSILON ? stem_neighbours : 1;
    phi_real largest = 0;
    error[0] = error[1] = 0;
    for (int k = 0; k < count; ++k) {
        phi_real local[stem_x], size[2], *off = room->off[k];
        if (!room->lost) {
            stem_local(step, &room->drawn, local);
            if (room->share[k] > 0) {
                stem_follow(PASS step, off, &room->jet);
            } else {
                stem_norms(scales[1], local, size);
                room->share[k] = stem_larger(size[0], size[1] / scales[0]) / PHI_NEIGHBOUR;
            }
            if (room->share[k] > 0) {
                for (int i = 0; i < stem_x; ++i) {
                    off[i] += local[i] / room->share[k];
                }
#if WITH_SPHERE
                stem_tangent(step->moved, off);
#endif
            }
        }
        stem_norms(scales[1], off, size);
        const phi_real far = stem_larger(size[0], size[1] / scales[0]);
        phi_real nothing = 0;
        for (int i = 0; i < stem_x; ++i) {
            nothing += 0 * (room->share[k] * off[i]);
            error[i / stem_q] = stem_larger(room->share[k] * phi_abs(off[i]), error[i / stem_q]);
        }
        largest = stem_larger(room->share[k] * far, largest);
        /* No comparison sees what is no number: a neighbour that is none is as far off as can be. */
        if (!(nothing >= 0)) {
            error[0] = error[1] = largest = HUGE_VAL;
        }
        if (!room->lost && far > 0 && (far > 1024 * PHI_NEIGHBOUR || far < PHI_NEIGHBOUR / 1024)) {
            for (int i = 0; i < stem_x; ++i) {
                off[i] *= PHI_NEIGHBOUR / far;
            }
            room->share[k] *= far / PHI_NEIGHBOUR;
        }
    }
    room->lost = room->lost || !(largest < 8);
}

void phi_errors_beside(JUDGED);

/* Fly beside so many steps, in room that is empty where they are a run's first; errors of angles and rates at the end of each. */
void phi_errors_beside(JUDGED)
{
#if WITH_SCALES
    const phi_real scales[2] = {PHI_SCALES}; /* fastest linear rate, length of the chain */
#else
    phi_real scales[2]; /* fastest linear rate, length of the chain */
    stem_scales(p, scales);
#endif
#if WITH_INPUTS
    memcpy(room->jet.u, u, sizeof room->jet.u);
#endif
    for (unsigned long k = 0; k < count; ++k) {
        stem_watch(PASS steps + k, tolerance * PHI_MARGIN, scales, room, errors + 2 * k);
    }
}
