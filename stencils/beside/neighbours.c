/* What flies beside the steps of a run when somebody asks how large its errors are: neighbours, each off the path by what the errors of
 * all steps so far have come to, over a share that keeps them in its tangent. Low orders over the run's own steps will do, of the path as of
 * its neighbours, so that what both leave out cancels. Where errors are known with their signs, one neighbour takes them off the path and
 * flies where the motion would be. Where the sign of rounding is chance, three say near round-off how large a sum of such errors is. Once
 * all have turned into one direction, which any error does that grows, one is enough. */
enum {
    stem_neighbours = 3,
    stem_turning = 16, /* steps in one direction after which it stays */
    stem_parts = 64 /* of a step: longer ones are halved where they are too long for a neighbour */
};

typedef struct stem_beside {
    stem_jets jet;
    phi_real off[stem_neighbours][stem_x], share[stem_neighbours]; /* from the path; what a unit of that stands for */
    stem_words drawn;
    int count, alike, lost; /* neighbours, 0 before the first step; steps since they had more than one direction */
} stem_beside;

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

/* Whether the last term of a neighbour's series is more than a small part of the largest: it is elsewhere, where the step is too long for it. */
static int stem_is_coarse(const int low, const stem_jets *beside, const phi_real unit, const phi_real t)
{
    phi_real power = 1, last = 0, largest = 0;
    for (int n = 0; n <= low; ++n) {
        last = 0;
        for (int i = stem_q; i < stem_x; ++i) {
            last = stem_larger(phi_abs(n > 0 ? beside->x[n][i] : unit * beside->state[i]) * power, last);
        }
        largest = stem_larger(last, largest);
        power *= phi_abs(t);
    }
    return 1024 * last > largest;
}

/* What a neighbour becomes over a step; angles have rates for slopes. Where the step is too long for it, it takes parts of it, halves of halves. */
static void stem_follow(CONTEXT const int low, const stem_step *step, const int is_far, phi_real off[stem_x], stem_jets *beside)
{
    const phi_real unit = step->unit, whole = step->h / unit;
    phi_real left = whole, before[stem_x];
    int is_whole = 1;
    for (int i = 0; i < stem_x; ++i) {
        beside->state[i] = before[i] = step->state[i] + off[i];
    }
    do {
        stem_begin(PASS beside, beside->state, beside->lost, &step->unit, beside->start);
        stem_expand(PASS low, beside);
        phi_real part = left;
        while (is_far && phi_abs(part) > phi_abs(whole) / stem_parts && stem_is_coarse(low, beside, unit, part)) {
            part /= 2;
            is_whole = 0;
        }
        /* Over a whole step both leave out the same. */
        for (int i = 0; is_whole && i < stem_q; ++i) {
            phi_real faster = 0, farther = 0;
            for (int n = low; n > 0; --n) {
                const phi_real apart = beside->x[n][stem_q + i] - step->rates[(n - 1) * stem_q + i];
                farther = farther * part + apart / (phi_real)(n + 1);
                faster = faster * part + apart;
            }
            off[i] += (off[stem_q + i] * unit + farther * part) * part;
            off[stem_q + i] += faster * part / unit;
        }
        for (int i = 0; !is_whole && i < stem_q; ++i) {
            phi_real faster = 0, farther = 0;
            for (int n = low; n > 0; --n) {
                farther = farther * part + beside->x[n][stem_q + i] / (phi_real)(n + 1);
                faster = faster * part + beside->x[n][stem_q + i];
            }
            beside->state[i] += (beside->state[stem_q + i] * unit + farther * part) * part;
            beside->state[stem_q + i] += faster * part / unit;
        }
        left -= part;
    } while (phi_abs(left) > 0);
    for (int i = 0; !is_whole && i < stem_q; ++i) {
        phi_real faster = 0, farther = 0;
        for (int n = low; n > 0; --n) {
            farther = farther * whole + step->rates[(n - 1) * stem_q + i] / (phi_real)(n + 1);
            faster = faster * whole + step->rates[(n - 1) * stem_q + i];
        }
        off[i] += (beside->state[i] - before[i]) - (step->state[stem_q + i] * unit + farther * whole) * whole;
        off[stem_q + i] += (beside->state[stem_q + i] - before[stem_q + i]) - faster * whole / unit;
    }
}

/* Plus or minus one. */
static phi_real stem_draw(stem_words *drawn)
{
    *drawn = *drawn * 6364136223846793005u + 1442695040888963407u;
    return *drawn >> 63 ? 1 : -1;
}

/* The error of a step as one neighbour takes it. The equations are rounded, too, by what the slopes at its end differ by, as far as that
 * is rounding: no less than half a unit in the last place of all terms, and no more than 16. Rounded numbers of the chain are wrong the same
 * way all along, which one of the neighbours takes for half a unit of what the rates move by. */
static void stem_local(const int order, const int low, const stem_step *step, const phi_real sign, const int is_steady, stem_words *drawn, phi_real error[stem_x])
{
    const phi_real t = phi_abs(step->h) / step->unit;
    for (int i = 0; i < stem_q; ++i) {
        const phi_real left = sign * step->error[stem_q + i], apart = phi_abs(left) * (phi_real)(order + 1) / 2;
        phi_real terms = 0, net = 0;
        for (int n = low; n > 0; --n) {
            terms = terms * t + phi_abs(step->rates[(n - 1) * stem_q + i]);
            net = net * (step->h / step->unit) + step->rates[(n - 1) * stem_q + i];
        }
        const phi_real least = PHI_EPSILON / 2 * terms * t / step->unit, most = 32 * least;
        const phi_real steady = (i % 2 ? -PHI_EPSILON : PHI_EPSILON) / 2 * net * step->h / (step->unit * step->unit);
        const phi_real rate = (is_steady ? steady : 0) + stem_draw(drawn) * (apart > most ? most : stem_larger(apart, least));
        const phi_real angle = stem_draw(drawn) * (PHI_EPSILON / 2) * step->h * step->state[stem_q + i];
        error[i] = sign * step->error[i] + angle + rate * step->h / 2;
        error[stem_q + i] = left + rate;
    }
}

/* Whether two neighbours of some size are off the path in one direction, or against each other: what grows does so either way. */
static int stem_are_alike(const phi_real fastest, const phi_real one[stem_x], const phi_real far, const phi_real other[stem_x], const phi_real farther)
{
    phi_real with = 0, against = 0;
    for (int i = 0; i < stem_x; ++i) {
        const phi_real unit = i < stem_q ? 1 : fastest, a = one[i] / (unit * far), b = other[i] / (unit * farther);
        with = stem_larger(phi_abs(a - b), with);
        against = stem_larger(phi_abs(a + b), against);
    }
    return (with < PHI_HALF / 16) | (against < PHI_HALF / 16);
}

/* What so many neighbours say together: near round-off, where errors are chance, three quarters of what they are off on average; else what the
 * one says whose errors have their signs or, where these all but cancel, a small part of what they come to with others. */
static phi_real stem_together(const int is_chance, const int count, const phi_real sizes[stem_neighbours])
{
    phi_real sum = 0;
    if (!is_chance) {
        return count > 1 ? stem_larger(sizes[1] / 32, sizes[0]) : sizes[0];
    }
    for (int k = 0; k < count; ++k) {
        sum += sizes[k] / (phi_real)count;
    }
    return sum * 3 / 4;
}

/* Go on with the neighbours over a step, along which the path's series are known, and say how far off angles and rates are at its end. */
static void stem_watch(CONTEXT const phi_real goal, const int order, const stem_step *step, const int is_chance, const phi_real scales[PHI_SCALE_COUNT], stem_beside *room, phi_real error[2])
{
    const int low = (int)step->low;
    phi_real largest = 0, far[stem_neighbours], aside[2][stem_neighbours];
    int alike = 1;
    for (int k = 0; k < room->count; ++k) {
        phi_real local[stem_x], size[2], nothing = 0, *off = room->off[k];
        if (!room->lost) {
#if WITH_PAIRS
            if (stem_rounds(goal)) {
                stem_defect(PASS goal, step, &room->jet, local);
            } else {
                stem_local(order, low, step, k == 0 ? 1 : stem_draw(&room->drawn), k == 2, &room->drawn, local);
            }
#else
            stem_local(order, low, step, k == 0 ? 1 : stem_draw(&room->drawn), k == 2, &room->drawn, local);
            (void)goal;
#endif
            if (room->share[k] > 0) {
                stem_norms(scales[1], off, size);
                stem_follow(PASS low, step, 32 * stem_larger(size[0], size[1] / scales[0]) > 1, off, &room->jet);
            } else {
                stem_norms(scales[1], local, size);
                room->share[k] = stem_larger(size[0], size[1] / scales[0]) / PHI_NEIGHBOUR;
            }
            if (room->share[k] > 0) {
                for (int i = 0; i < stem_x; ++i) {
                    off[i] -= local[i] / room->share[k];
                }
#if WITH_SPHERE
                stem_tangent(step->moved, off);
#endif
            }
        }
        stem_norms(scales[1], off, size);
        far[k] = stem_larger(size[0], size[1] / scales[0]);
        aside[0][k] = aside[1][k] = 0;
        for (int i = 0; i < stem_x; ++i) {
            nothing += 0 * (room->share[k] * off[i]);
            aside[i / stem_q][k] = stem_larger(room->share[k] * phi_abs(off[i]), aside[i / stem_q][k]);
        }
        largest = stem_larger(room->share[k] * far[k], largest);
        /* No comparison sees what is no number: a neighbour that is none is as far off as can be. */
        if (!(nothing >= 0)) {
            aside[0][k] = aside[1][k] = largest = HUGE_VAL;
        }
        alike = alike && far[k] > 0 && stem_are_alike(scales[0], room->off[0], far[0], off, far[k]);
        if (!room->lost && far[k] > 0 && (far[k] > 1024 * PHI_NEIGHBOUR || far[k] < PHI_NEIGHBOUR / 1024)) {
            /* One that is where the motion itself would be is followed as far as it goes, tangent or not. */
            const phi_real to = stem_larger(is_chance ? 0 : room->share[k] * far[k], PHI_NEIGHBOUR);
            for (int i = 0; i < stem_x; ++i) {
                off[i] *= to / far[k];
            }
            room->share[k] *= far[k] / to;
            far[k] = to;
        }
    }
    error[0] = stem_together(is_chance, room->count, aside[0]);
    error[1] = stem_together(is_chance, room->count, aside[1]);
    room->lost = room->lost || !(largest < 8);
    room->alike = alike ? room->alike + 1 : 0;
    if (room->count > 1 && room->alike >= stem_turning && !room->lost) {
        phi_real sizes[stem_neighbours];
        for (int k = 0; k < room->count; ++k) {
            sizes[k] = room->share[k] * far[k];
        }
        const phi_real together = stem_together(is_chance, room->count, sizes), alone = stem_together(is_chance, 1, sizes);
        room->share[0] *= together / alone;
        room->count = 1;
    }
}

void phi_errors_beside(JUDGED);

/* Fly beside so many steps, in room that is empty where they are a run's first; errors of angles and rates at the end of each. */
void phi_errors_beside(JUDGED)
{
#if WITH_SCALES
    const phi_real scales[PHI_SCALE_COUNT] = {PHI_SCALES}; /* PHI_SCALE_WORDS */
#else
    phi_real scales[PHI_SCALE_COUNT]; /* PHI_SCALE_WORDS */
    stem_scales(p, scales);
#endif
#if WITH_INPUTS
    memcpy(room->jet.u, u, sizeof room->jet.u);
#endif
    const phi_real goal = tolerance * PHI_MARGIN;
    const int order = stem_order_for(goal), low = count > 0 ? (int)((const stem_step *)(const void *)steps)->low : 0;
#if WITH_PAIRS
    const int is_chance = 0, few = stem_rounds(goal) ? 1 : 2;
#else
    const int is_chance = goal < 16 * PHI_EPSILON, few = is_chance ? 3 : 2;
#endif
    if (room->count == 0) {
        room->count = few;
    }
    for (unsigned long k = 0; k < count; ++k) {
        const stem_step *step = (const stem_step *)(const void *)(steps + stem_place(low, k));
        stem_watch(PASS goal, order, step, is_chance, scales, room, errors + 2 * k);
    }
}
