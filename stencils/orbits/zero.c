/* Where a test function vanishes between two orbits of a family: the polynomial through all that is known of it, inside a bracket
 * (`continuation/met/roots.py` says the same of other functions), along the curve that touches all that is known of the family. */
#define ZERO_NODES 7          /* values that are interpolated */
#define ZERO_TURNS 100        /* iterations for the zero of a polynomial */
#define ZERO_LAST 4e-16       /* moves of it, in units of itself, that are rounding */
#define ZERO_PATIENCE 3       /* values after which the bracket has to be half as long, or is halved */
#define ZERO_ROUNDING 1e-11   /* moves below which one that does not shrink is rounding */
#define ZERO_CLOSE 3e-6       /* moves from which the next one is nothing to speak of */
#define ZERO_APART 1e-6       /* distances of two orbits from which on what rough columns leave is nothing beside how a function changes */
#define ZERO_NEAR 3           /* orbits on either side of a place that it is guessed from */
#define ZERO_MOST (2 + DESK_TRIES + DESK_OUTSIDE)
enum { ZERO_FIRST = -2, ZERO_END }; /* the ends of the line, where orbits are counted */

typedef struct zero_pair {
    phi_real place, value;
} zero_pair;

/* Which try is the zero's, which one is nearest to it, or which end, and where the zero is. */
typedef struct zero_told {
    int at, other;
    phi_real place;
} zero_told;

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

/* desk->guess, and desk->normal across which it is, of the orbit at an arclength: in the plane across the chord through the cubic there. Where it belongs in the line comes back. */
static int zero_guess(brake_desk *desk, const phi_real s)
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
    if (!touch_curve(to - from, &desk->line[from], desk->axis, place, desk->guess)) {
        memcpy(desk->guess, cubic, sizeof cubic);
    }
    memcpy(desk->normal, chord, sizeof chord);
    return at;
}

/* The orbit at an arclength beside one where [J; t] is singular: on the polynomial, along which its tangent lies; 0 where it is no numbers. */
static int zero_on_shape(CONTEXT const phi_flow *begun, brake_desk *desk, const phi_real x)
{
    phi_real rows[brake_all * brake_all], along[brake_all], square = 0;
    for (int i = 0; i < brake_all; ++i) {
        desk->orbit.y[i] = along[i] = 0;
        for (int k = DESK_SHAPE - 1; k >= 0; --k) {
            along[i] = along[i] * x + desk->orbit.y[i];
            desk->orbit.y[i] = desk->orbit.y[i] * x + desk->shape[k][i];
        }
        square += along[i] * along[i];
    }
    if (!brake_whole(PASS begun, desk)) {
        return 0;
    }
    brake_found(PASS desk);
    for (int i = 0; i < brake_all; ++i) {
        desk->orbit.tangent[i] = along[i] / sqrt(square);
    }
    memcpy(rows, desk->orbit.jacobian, sizeof desk->orbit.jacobian);
    memcpy(rows + brake_q * brake_all, desk->orbit.tangent, sizeof desk->orbit.tangent);
    desk->orbit.sigma = small_signed(brake_all, rows);
    brake_turns(desk);
    return 1;
}

/* The orbit at desk->guess with the columns of its own place: what the state alone says is wrong with the guess is taken off before they are asked for, by the Jacobian of
 * desk->orbit, an orbit nearby. 0 where that is more than it would know, or no numbers. */
static int zero_exact(CONTEXT const phi_flow *begun, brake_desk *desk)
{
    phi_real left[brake_all], length;
    memcpy(desk->orbit.y, desk->guess, sizeof desk->orbit.y);
    if (!brake_evaluate(PASS begun, desk, desk->tolerance, 0) || !(brake_left(desk, left) <= BRAKE_SETTLED)) {
        return 0;
    }
    for (int i = 0; i < brake_all; ++i) {
        desk->guess[i] += left[i];
    }
    return brake_settle(PASS begun, desk, &length) && length <= BRAKE_SETTLED;
}

/* The orbit at an arclength, in desk->orbit. Known to the line unless Newton failed; 0 where it is no numbers. One that is to be the zero itself is asked for with all
 * its columns at once, which serves where its guess is as good as those that are settled. */
static int zero_orbit(CONTEXT const phi_flow *begun, brake_desk *desk, const phi_real s, const int is_last, int *is_reached)
{
    const phi_real x = desk->shape_half > 0 ? (s - desk->shape_centre) / desk->shape_half : HUGE_VAL;
    if (fabs(x) <= 1) {
        *is_reached = 0;
        return zero_on_shape(PASS begun, desk, x);
    }
    const int at = zero_guess(desk, s), count = (int)desk->line_count;
    *is_reached = is_last && zero_exact(PASS begun, desk);
    if (!*is_reached) {
        brake_correct(PASS begun, desk, 0);
        *is_reached = desk->orbit.converged > 0;
        memcpy(desk->normal, desk->line[0][1], sizeof desk->normal);
        if (!*is_reached) {
            memcpy(desk->orbit.y, desk->guess, sizeof desk->orbit.y);
            if (!brake_whole(PASS begun, desk)) {
                return 0;
            }
        }
        brake_found(PASS desk);
    }
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

/* An orbit with the columns of its own place, where that is wanted and they are not. */
static int zero_settled(CONTEXT const phi_flow *begun, brake_desk *desk, brake_row *row, const phi_real watch[5])
{
    const int count = (int)row->orbit.taken;
    const phi_real last = count > 0 ? row->orbit.corrections[count - 1] : 0;
    if (!(desk->line_settle > 0) || (row->orbit.is_whole > 0 && last <= ZERO_SETTLED)) {
        return 1;
    }
    memcpy(desk->guess, row->orbit.y, sizeof desk->guess);
    memcpy(desk->normal, row->orbit.tangent, sizeof desk->normal);
    desk->orbit = row->orbit;
    const int is_known = zero_exact(PASS begun, desk);
    row->orbit = desk->orbit;
    row->values[0] = run_value(desk, watch);
    return is_known;
}

/* The orbit at which a test function vanishes between the two ends of the line, settled where that is wanted; 0 where it was not found so. What
 * was computed on the way is told in tries, desk->tried of them. */
static int zero_between(CONTEXT const phi_flow *begun, brake_desk *desk, const phi_real watch[5], zero_told *told)
{
    zero_pair known[ZERO_MOST], a, b;
    int count = 0, rows = 0, left = ZERO_PATIENCE;
    for (; count < 2; ++count) {
        known[count].place = desk->line_at[count];
        known[count].value = desk->line_values[count];
    }
    for (int i = 0; i < (int)desk->outside_count; ++i) {
        /* Behind those that are found, so that the first of them is as in the bracket. */
        known[2 + DESK_TRIES + i].place = desk->outside[i][0];
        known[2 + DESK_TRIES + i].value = desk->outside[i][1];
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
        memcpy(all + count, known + 2 + DESK_TRIES, (size_t)outside * sizeof all[0]);
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
        const int is_last = desk->line_settle > 0 && is_known && move <= ZERO_CLOSE * (1 + fabs(place));
        if (rows == DESK_TRIES || desk->evaluations > DESK_ASKED - 32 || !zero_orbit(PASS begun, desk, place, is_last, &is_reached) || !(desk->orbit.is_told > 0)) {
            return 0;
        }
        brake_row *row = &desk->tries[rows++];
        row->arclength = place;
        row->step = is_reached;
        row->orbit = desk->orbit;
        row->values[0] = run_value(desk, watch);
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
    /* What is closer differs by what rough columns leave. */
    for (int i = 0; i < count; ++i) {
        const phi_real own = fabs(known[i].place - known[zero].place), least = other < 0 ? HUGE_VAL : fabs(known[other].place - known[zero].place);
        const int is_apart = own >= ZERO_APART, was_apart = least >= ZERO_APART && least < HUGE_VAL;
        if (i != zero && (is_apart > was_apart || (is_apart == was_apart && own < least))) {
            other = i;
        }
    }
    desk->tried = rows;
    told->place = place;
    told->at = zero + ZERO_FIRST;
    told->other = other + ZERO_FIRST;
    return zero > 1 && zero_settled(PASS begun, desk, &desk->tries[zero - 2], watch);
}
