/* What flies beside a run and says how large its errors are: neighbours, each off the path by what the errors of all steps so far
 * have come to, over a share that keeps them in its tangent. Low orders over the run's own steps will do: those of the
 * path's series, of which no run has fewer, are taken from the neighbour's, so that what both leave out cancels. Only near
 * round-off is the sign of an error chance, and a second neighbour worth while. */
enum {
    stem_neighbours = 2,
    stem_low = 5
};

typedef struct stem_beside {
    stem_jets jet;
    phi_real off[stem_neighbours][stem_x], share[stem_neighbours]; /* from the path; what a unit of that stands for */
    stem_words drawn;
    int lost;
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

/* What a neighbour becomes over a step. */
static void stem_follow(CONTEXT const stem_jets *jet, const phi_real *h, phi_real off[stem_x], stem_jets *beside)
{
    const phi_real t = *h / jet->start->unit[0];
    phi_real moved[stem_x], increment[stem_x];
    for (int i = 0; i < stem_x; ++i) {
        moved[i] = jet->state[i] + off[i];
    }
    stem_begin(PASS jet, moved, jet->lost, &jet->start->unit[0], beside->start);
    stem_expand(PASS stem_low, beside);
    for (int i = 0; i < stem_x; ++i) {
        phi_real sum = beside->x[stem_low][i] - jet->x[stem_low][i];
        for (int n = stem_low - 1; n > 0; --n) {
            sum = sum * t + (beside->x[n][i] - jet->x[n][i]);
        }
        increment[i] = sum * (i < stem_q ? t : t / jet->start->unit[0]);
    }
    for (int i = 0; i < stem_x; ++i) {
        off[i] += increment[i];
    }
}

/* The error of a step: what its series leaves, by how far it is from the equations at its end, which grows as the order's power
 * of time; and half a unit in the last place of what the state moves by, of either sign. */
static void stem_local(const int order, const stem_jets *jet, const phi_real *h, stem_words *drawn, phi_real error[stem_x])
{
    const phi_real unit = jet->start->unit[0], t = *h / unit, ratio = unit / jet->end->unit[0], square = t * t;
    phi_real even[stem_x], odd[stem_x];
    for (int i = 0; i < stem_x; ++i) {
        even[i] = odd[i] = 0;
    }
    for (int n = order - order % 2; n > 0; n -= 2) {
        for (int i = 0; i < stem_x; ++i) {
            even[i] = even[i] * square + (phi_real)n * jet->x[n][i];
        }
    }
    for (int n = order - (order + 1) % 2; n > 0; n -= 2) {
        for (int i = 0; i < stem_x; ++i) {
            odd[i] = odd[i] * square + (phi_real)n * jet->x[n][i];
        }
    }
    for (int i = 0; i < stem_x; ++i) {
        const phi_real share = i < stem_q ? t : t / unit, slope = jet->end->slope[i] * (i < stem_q ? ratio : ratio * ratio);
        const phi_real rounding = PHI_EPSILON / 2 * (jet->moved[i] - jet->state[i]);
        *drawn = *drawn * 6364136223846793005u + 1442695040888963407u;
        error[i] = share * ((even[i] * t + odd[i]) - slope) / (phi_real)(order + 1) + (*drawn >> 63 ? rounding : -rounding);
    }
}

/* Go on with the neighbours over a step that has been taken, and say how far off angles and rates are at its end. */
static void stem_watch(CONTEXT const int order, const stem_jets *jet, const phi_real h, const phi_real goal, const phi_real scales[PHI_SCALE_COUNT], stem_beside *room, phi_real error[2])
{
    const int count = goal < 16 * PHI_EPSILON ? stem_neighbours : 1;
    phi_real largest = 0;
    error[0] = error[1] = 0;
    for (int k = 0; k < count; ++k) {
        phi_real local[stem_x], size[2], *off = room->off[k];
        if (!room->lost) {
            stem_local(order, jet, &h, &room->drawn, local);
            if (room->share[k] > 0) {
                stem_follow(PASS jet, &h, off, &room->jet);
            } else {
                stem_norms(scales[1], local, size);
                room->share[k] = stem_larger(size[0], size[1] / scales[0]) / PHI_NEIGHBOUR;
            }
            if (room->share[k] > 0) {
                for (int i = 0; i < stem_x; ++i) {
                    off[i] += local[i] / room->share[k];
                }
#if WITH_SPHERE
                stem_tangent(jet->moved, off);
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
