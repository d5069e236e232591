/* Where a test function vanishes between two orbits of a family: the polynomial through all that is known of it, inside a bracket
 * (`continuation/met/roots.py` says the same of other functions), along the curve that touches all that is known of the family. */
#define ZERO_NODES 7          /* values that are interpolated */
#define ZERO_TURNS 100        /* iterations for the zero of a polynomial */
#define ZERO_LAST 4e-16       /* moves of it, in units of itself, that are rounding */
#define ZERO_PATIENCE 3       /* values after which the bracket has to be half as long, or is halved */
#define ZERO_ROUNDING 1e-11   /* moves below which one that does not shrink is rounding */
#define ZERO_NEAR 3           /* orbits on either side of a place that it is guessed from */
#define ZERO_MOST (2 + DESK_ROWS + DESK_OUTSIDE)

typedef struct zero_pair {
    phi_real place, value;
} zero_pair;

/* The zero inside the bracket of the polynomial through its ends and what is closest to them. */
static phi_real zero_of_polynomial(const int count, const zero_pair *known, const zero_pair a, const zero_pair b)
{
    zero_pair nodes[ZERO_NODES] = {a, b};
    const phi_real middle = (a.place + b.place) / 2, close = ZERO_ROUNDING * (1 + fabs(middle));
    int is_used[ZERO_MOST] = {0}, size = 2;
    while (size < ZERO_NODES) {
        int nearest = -1, is_new = 1;
        for (int i = 0; i < count; ++i) {
            if (!is_used[i] && (nearest < 0 || fabs(known[i].place - middle) < fabs(known[nearest].place - middle))) {
                nearest = i;
            }
        }
        if (nearest < 0) {
            break;
        }
        is_used[nearest] = 1;
        /* Values closer than rounding differ by rounding, and say nothing of a slope. */
        for (int i = 0; i < size; ++i) {
            is_new = is_new && fabs(known[nearest].place - nodes[i].place) > close;
        }
        if (is_new) {
            nodes[size++] = known[nearest];
        }
    }
    for (int order = 1; order < size; ++order) {
        for (int k = size - 1; k >= order; --k) {
            nodes[k].value = (nodes[k].value - nodes[k - 1].value) / (nodes[k].place - nodes[k - order].place);
        }
    }
    phi_real low = a.place, high = b.place, x = a.place - a.value * (b.place - a.place) / (b.value - a.value);
    for (int turn = 0; turn < ZERO_TURNS; ++turn) {
        phi_real value = nodes[size - 1].value, slope = 0;
        for (int k = size - 2; k >= 0; --k) {
            slope = slope * (x - nodes[k].place) + value;
            value = value * (x - nodes[k].place) + nodes[k].value;
        }
        if (!(value < 0 || value > 0)) {
            break;
        }
        if ((value > 0) == (a.value > 0)) {
            low = x;
        } else {
            high = x;
        }
        const phi_real ahead = slope < 0 || slope > 0 ? x - value / slope : low;
        if (fabs(ahead - x) <= ZERO_LAST * fabs(x)) {
            break;
        }
        x = low < ahead && ahead < high ? ahead : (low + high) / 2;
    }
    return x < a.place ? a.place : x > b.place ? b.place : x;
}

/* What places and tangents of the bracket's ends count for in the cubic through them, at an arclength. */
static void zero_cubic(const brake_desk *desk, const phi_real s, phi_real share[4])
{
    const phi_real length = desk->line_at[1] - desk->line_at[0], x = (s - desk->line_at[0]) / length;
    share[0] = (1 + 2 * x) * (1 - x) * (1 - x);
    share[1] = x * x * (3 - 2 * x);
    share[2] = length * x * (1 - x) * (1 - x);
    share[3] = length * x * x * (x - 1);
}

/* The orbit at an arclength, in desk->orbit: in the plane across the chord through the cubic there. Known to the line unless Newton failed; 0 where it is no numbers. */
static int zero_orbit(CONTEXT const phi_flow *begun, brake_desk *desk, const phi_real s, int *is_reached)
{
    phi_real share[4], chord[brake_all], length = 0, cubic[brake_all], place = 0;
    const phi_real *a = desk->line[0][0], *b = desk->line[1][0], *leaving = desk->line[0][1], *arriving = desk->line[1][1];
    const int count = (int)desk->line_count;
    int from = 2, to;
    zero_cubic(desk, s, share);
    for (int i = 0; i < brake_all; ++i) {
        chord[i] = b[i] - a[i];
        length += chord[i] * chord[i];
    }
    for (int i = 0; i < brake_all; ++i) {
        cubic[i] = share[0] * a[i] + share[1] * b[i] + share[2] * leaving[i] + share[3] * arriving[i];
        desk->axis[i] = chord[i] / sqrt(length);
        place += desk->axis[i] * cubic[i];
    }
    /* The line lies in order behind its two ends, which are in it once more. */
    while (from < count && desk->line_at[from] < s) {
        ++from;
    }
    const int at = from;
    to = at + ZERO_NEAR < count ? at + ZERO_NEAR : count;
    from = at - ZERO_NEAR > 2 ? at - ZERO_NEAR : 2;
    phi_real(*near)[2][DESK_ALL] = &desk->line[from];
    if (!touch_curve(to - from, near, desk->axis, place, desk->guess)) {
        memcpy(desk->guess, cubic, sizeof cubic);
    }
    memcpy(desk->normal, chord, sizeof chord);
    brake_correct(PASS begun, desk, 0);
    *is_reached = desk->orbit.converged > 0;
    memcpy(desk->normal, leaving, sizeof desk->normal);
    if (!*is_reached) {
        memcpy(desk->orbit.y, desk->guess, sizeof cubic);
        if (!brake_whole(PASS begun, desk)) {
            return 0;
        }
    }
    brake_found(PASS desk);
    /* One beside which [J; t] is singular has lost too many digits for others to be guessed from. */
    if (*is_reached && count < DESK_LINE && fabs(desk->orbit.sigma) >= desk->line_regular) {
        memmove(desk->line + at + 1, desk->line + at, (size_t)(count - at) * sizeof desk->line[0]);
        memmove(desk->line_at + at + 1, desk->line_at + at, (size_t)(count - at) * sizeof desk->line_at[0]);
        memcpy(desk->line[at][0], desk->orbit.y, sizeof desk->orbit.y);
        memcpy(desk->line[at][1], desk->orbit.tangent, sizeof desk->orbit.tangent);
        desk->line_at[at] = s;
        desk->line_count += 1;
    }
    return 1;
}

/* The orbit at which the test function desk->watch[0] vanishes between the two ends of the line; 0 where it was not found so. What was
 * computed on the way is told in rows, desk->count of them: desk->taken is that of the zero, desk->stopped that of its neighbour or -1, -2 for an end, and
 * desk->place where the zero is. */
static int zero_between(CONTEXT const phi_flow *begun, brake_desk *desk)
{
    zero_pair known[ZERO_MOST], a, b;
    int count = 0, rows = 0, left = ZERO_PATIENCE;
    for (; count < 2; ++count) {
        known[count].place = desk->line_at[count];
        known[count].value = desk->line_values[count];
    }
    for (int i = 0; i < (int)desk->outside_count; ++i) {
        /* Behind those that are found, so that the first of them is as in the bracket. */
        known[2 + DESK_ROWS + i].place = desk->outside[i][0];
        known[2 + DESK_ROWS + i].value = desk->outside[i][1];
    }
    a = known[0];
    b = known[1];
    phi_real wanted = b.place - a.place, last_move = HUGE_VAL, place;
    for (;;) {
        zero_pair all[ZERO_MOST], best = known[0];
        int is_known = 0, outside = (int)desk->outside_count, is_there = 0, is_reached = 0;
        for (int i = 0; i < count; ++i) {
            is_known = fabs(known[i].value) < fabs(best.value) ? i > 1 : is_known;
            best = fabs(known[i].value) < fabs(best.value) ? known[i] : best;
        }
        memcpy(all, known, (size_t)count * sizeof all[0]);
        memcpy(all + count, known + 2 + DESK_ROWS, (size_t)outside * sizeof all[0]);
        place = zero_of_polynomial(count + outside, all, a, b);
        const phi_real move = fabs(place - best.place);
        const int is_small = move < ZERO_ROUNDING * (1 + fabs(place)), is_rounding = is_small && 2 * move > last_move;
        if (count > 3 && is_known && move <= desk->line_near && a.place < place && place < b.place) {
            break;
        }
        if (b.place - a.place <= desk->line_spacing || (is_known && (move <= desk->line_spacing || is_rounding))) {
            if (is_known) {
                place = best.place;
                break;
            }
            place = (a.place + b.place) / 2;
        } else if (left == 0) {
            place = (a.place + b.place) / 2;
            wanted = (b.place - a.place) / 2;
            left = ZERO_PATIENCE;
        } else if (!(a.place < place && place < b.place)) {
            place = (a.place + b.place) / 2;
        }
        last_move = is_small ? move : HUGE_VAL;
        if (rows == DESK_ROWS || desk->evaluations > DESK_ASKED - 32 || !zero_orbit(PASS begun, desk, place, &is_reached) || !(desk->orbit.is_told > 0)) {
            return 0;
        }
        brake_row *row = &desk->rows[rows++];
        row->arclength = place;
        row->step = is_reached;
        row->orbit = desk->orbit;
        row->values[0] = run_value(desk, desk->watch[0]);
        const zero_pair found = {place, row->values[0]};
        known[count++] = found;
        if ((found.value < 0) == (a.value < 0)) {
            a = found;
        } else {
            b = found;
        }
        left = b.place - a.place > wanted / 2 ? left - 1 : ZERO_PATIENCE;
        wanted = left < ZERO_PATIENCE ? wanted : b.place - a.place;
        is_there = b.place - a.place <= desk->line_spacing || !(a.value < 0 || a.value > 0) || !(b.value < 0 || b.value > 0);
        if (is_there) {
            place = !(a.value < 0 || a.value > 0) ? a.place : !(b.value < 0 || b.value > 0) ? b.place : found.place;
            break;
        }
    }
    int zero = -1, other = -1;
    for (int i = 0; i < count; ++i) {
        zero = zero < 0 || fabs(known[i].place - place) < fabs(known[zero].place - place) ? i : zero;
    }
    for (int i = 0; i < count; ++i) {
        if (i != zero && (other < 0 || fabs(known[i].place - known[zero].place) < fabs(known[other].place - known[zero].place))) {
            other = i;
        }
    }
    desk->place = place;
    desk->count = rows;
    desk->taken = zero - 2;
    desk->stopped = other - 2;
    return zero > 1;
}
