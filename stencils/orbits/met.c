/* What a run meets on its way: zeros of test functions that it passes are located at once (`met/locate.py` says the same of other curves);
 * orbits before which something else may lie are somebody's to look at. */
#define MET_BENT 4.0      /* how many times as far as it bent on the way to a step a function may bend within it */
#define MET_HUMP 1.5      /* height of a hump, in its mean */
#define MET_BEFORE 3      /* orbits before a step that help to find zeros in it */
#define MET_TRUST 1e-8    /* corrections on the way that are taken without asking again */
#define MET_SPACING 1e-14 /* how far off a zero may be, in units of 1 + s */
#define MET_BESIDE 1e-9   /* how far from the orbit that is computed, likewise */
#define MET_REGULAR 0.1   /* sigma, in the larger one of the step's ends, below which no other orbit is guessed from one */
#define MET_PLACES 64     /* at which polynomials are looked at within a step */
#define MET_FEWER 3       /* polynomials of successive degrees, whose distances tell their error */
#define MET_DOUBT 2.0     /* error of the best of them, in its largest distance from the others */
#define MET_MARGIN 1e-2   /* height, in the least one of the ends, below which somebody else looks closer */
#define MET_LINKS 2       /* with more there are several kappa, of which it has to be known which is which */

/* A test function at one of the last places, divided by its distances from its zeros in the last step but one. */
static phi_real met_divided(const brake_desk *desk, const int k, const int at)
{
    const int last = (int)desk->count - 1;
    const phi_real size = desk->at[last - 1] - desk->at[last - 2];
    phi_real value = desk->values[at][k];
    for (int i = 0; i < (int)desk->zero_count; ++i) {
        value = (int)desk->zeros[i][0] == k ? value / ((desk->at[at] - desk->zeros[i][1]) / size) : value;
    }
    return value;
}

/* The mean over the last step but one of a component of the tangent: it is the slope of an unknown, which is known at both ends. */
static phi_real met_mean(const brake_desk *desk, const int k)
{
    const int last = (int)desk->count - 1, b = last - 1, a = last - 2, i = (int)desk->watch[k][1];
    return (desk->known[b][0][i] - desk->known[a][0][i]) / (desk->at[b] - desk->at[a]);
}

/* The polynomial through so many of some values, by Newton's divided differences, at a place. */
static phi_real met_polynomial(const int count, const phi_real *at, const phi_real *shares, const phi_real place)
{
    phi_real value = shares[count - 1];
    for (int i = count - 2; i >= 0; --i) {
        value = value * (place - at[i]) + shares[i];
    }
    return value;
}

/* Whether a function of one sign at both ends of the last step but one stays clear of zero there wherever the polynomial through all that is known of it, or
 * one of those of lower degrees, turns: what is near enough to be looked at closer is not judged here. A whole one is not divided by zeros. */
static int met_is_clear(const brake_desk *desk, const int k, const int is_whole)
{
    const int last = (int)desk->count - 1, first = last + 1 - (int)desk->seen, b = last - 1, a = last - 2;
    const phi_real from = desk->at[a], length = desk->at[b] - from, middle = from + length / 2;
    phi_real at[DESK_KNOWN], shares[DESK_KNOWN], heights[MET_FEWER][MET_PLACES + 1];
    int count = 0;
    /* The nearest first, of which those of lower degrees keep most. */
    for (int i = first; i <= last; ++i) {
        int j = count++;
        for (; j > 0 && fabs(at[j - 1] - middle) > fabs(desk->at[i] - middle); --j) {
            at[j] = at[j - 1];
            shares[j] = shares[j - 1];
        }
        at[j] = desk->at[i];
        shares[j] = met_divided(desk, k, i);
    }
    if (count <= MET_FEWER) {
        return 0;
    }
    const phi_real one = fabs(met_divided(desk, k, a)), other = fabs(met_divided(desk, k, b)), sign = met_divided(desk, k, a) < 0 ? -1 : 1;
    phi_real margin = MET_MARGIN * (one < other ? one : other), mean = 0;
    for (int order = 1; order < count; ++order) {
        for (int i = count - 1; i >= order; --i) {
            shares[i] = (shares[i] - shares[i - 1]) / (at[i] - at[i - order]);
        }
    }
    for (int i = 0; i <= MET_PLACES; ++i) {
        for (int fewer = 0; fewer < MET_FEWER; ++fewer) {
            heights[fewer][i] = sign * met_polynomial(count - fewer, at, shares, from + length * i / MET_PLACES);
        }
    }
    if (is_whole && desk->watch[k][3] > 1) {
        /* What its mean is off by values do not tell: the height of a hump. */
        for (int i = 0; i < MET_PLACES; i += 2) {
            mean += sign * (heights[0][i] + 4 * heights[0][i + 1] + heights[0][i + 2]) / (3 * MET_PLACES);
        }
        margin += MET_BENT * MET_HUMP * fabs(sign * met_mean(desk, k) - mean);
    }
    if (!((one < other ? one : other) > margin)) {
        return 0;
    }
    for (int i = 1; i < MET_PLACES; ++i) {
        int is_turn = 0;
        phi_real error = 0;
        for (int fewer = 0; fewer < MET_FEWER; ++fewer) {
            const phi_real *own = heights[fewer] + i, off = fabs(own[0] - heights[0][i]);
            is_turn = is_turn || (own[0] - own[-1]) * (own[1] - own[0]) <= 0;
            error = off > error ? off : error;
        }
        if (is_turn && !(heights[0][i] - MET_DOUBT * error > margin)) {
            return 0;
        }
    }
    return 1;
}

/* Whether a function may come to zero within the last step but one where its signs, and those of its zeros that are known, do not say so (`met/dips.py`). */
static int met_may_dip(const brake_desk *desk, const int k)
{
    const int last = (int)desk->count - 1, b = last - 1, a = last - 2;
    const phi_real first = met_divided(desk, k, a), after = met_divided(desk, k, b), length = desk->at[b] - desk->at[a];
    int is_known = 0;
    for (int i = 0; i < (int)desk->zero_count; ++i) {
        is_known = is_known || (int)desk->zeros[i][0] == k;
    }
    if (!((is_known || desk->watch[k][3] > 0) && first * after > 0)) {
        return 0;
    }
    const phi_real slope = (after - first) / length;
    phi_real bent = 0;
    if (desk->seen > 3) {
        bent = fabs(slope - (first - met_divided(desk, k, a - 1)) / (desk->at[a] - desk->at[a - 1])) / (desk->at[b] - desk->at[a - 1]);
    }
    const phi_real behind = fabs(slope - (met_divided(desk, k, last) - after) / (desk->at[last] - desk->at[b])) / (desk->at[last] - desk->at[a]);
    bent = behind > bent ? behind : bent;
    phi_real deep = bent * length * length / 4;
    if (desk->watch[k][3] > 1 && !is_known) {
        const phi_real off = MET_HUMP * fabs(met_mean(desk, k) - (first + after) / 2);
        deep = off > deep ? off : deep;
    }
    return (fabs(first) < fabs(after) ? fabs(first) : fabs(after)) < MET_BENT * deep && !met_is_clear(desk, k, !is_known);
}

/* The curve of the last step: its ends, and all that is known of it. */
static void met_line(brake_desk *desk)
{
    const int last = (int)desk->count - 1, seen = (int)desk->seen < MET_BEFORE + 2 ? (int)desk->seen : MET_BEFORE + 2;
    const phi_real a = fabs(desk->sigmas[last - 1]), b = fabs(desk->sigmas[last]), size = 1 + desk->at[last];
    for (int i = 0; i < 2; ++i) {
        memcpy(desk->line[i], desk->known[last - 1 + i], sizeof desk->line[i]);
        desk->line_at[i] = desk->at[last - 1 + i];
    }
    for (int i = 0; i < seen; ++i) {
        memcpy(desk->line[2 + i], desk->known[last + 1 - seen + i], sizeof desk->line[i]);
        desk->line_at[2 + i] = desk->at[last + 1 - seen + i];
    }
    desk->line_count = 2 + seen;
    desk->line_spacing = MET_SPACING * size;
    desk->line_near = MET_BESIDE * size;
    desk->line_settle = 1;
    desk->shape_half = 0;
    desk->line_regular = MET_REGULAR * (a > b ? a : b);
}

/* The zero beside an orbit that was computed: along its tangent, and what else is known by its change from another one. */
static void met_moved(const brake_desk *desk, const brake_row *at, const brake_row *other, brake_event *event)
{
    const phi_real apart = at->arclength - other->arclength, fallen = at->values[0] - other->values[0];
    phi_real there[4], here[4], ends[4] = {0}, along = 0, moved = 0;
    event->arclength = fabs(fallen) > 0 ? at->arclength - at->values[0] * apart / fallen : at->arclength;
    const phi_real share = (event->arclength - at->arclength) / apart;
    for (int i = 0; i < brake_all; ++i) {
        const phi_real across = desk->line[1][0][i] - desk->line[0][0][i];
        for (int j = 0; j < 4; ++j) {
            ends[j] += across * desk->line[j % 2][j / 2][i];
        }
        along += across * at->orbit.tangent[i];
    }
    zero_cubic(desk, event->arclength, there);
    zero_cubic(desk, at->arclength, here);
    for (int j = 0; j < 4; ++j) {
        moved += ends[j] * (there[j] - here[j]) / along;
    }
    for (int i = 0; i < brake_all; ++i) {
        event->y[i] = at->orbit.y[i] + moved * at->orbit.tangent[i];
    }
    for (int i = 0; i < brake_links * brake_links; ++i) {
        event->folded[i] = at->orbit.folded[i] + share * (at->orbit.folded[i] - other->orbit.folded[i]);
    }
    event->left = at->values[0] + share * fallen;
}

/* Whether at an event an unknown or the energy is beyond a level that both ends of the step have on one side. */
static int met_is_beyond(brake_desk *desk, const brake_row *at, const brake_event *event)
{
    const int last = (int)desk->count - 1;
    int is_beyond = 0;
    desk->orbit = at->orbit;
    memcpy(desk->orbit.y, event->y, sizeof event->y);
    for (int k = 0; k < (int)desk->watched; ++k) {
        const phi_real *watch = desk->watch[k], first = desk->values[last - 1][k];
        const int what = (int)watch[0];
        if ((what == RUN_UNKNOWN || what == RUN_ANGLE || what == RUN_ENERGY) && first * desk->values[last][k] > 0) {
            is_beyond = is_beyond || first * run_value(desk, watch) < 0;
        }
    }
    return is_beyond;
}

/* The zero of a test function in the last step, as an event; 0 where it was not found so. */
static int met_located(CONTEXT const phi_flow *begun, brake_desk *desk, const int k)
{
    const int last = (int)desk->count - 1;
    brake_event *event = &desk->events[(int)desk->met];
    zero_told told;
    if (brake_links > MET_LINKS || desk->met >= DESK_EVENTS) {
        return 0;
    }
    desk->line_values[0] = desk->values[last - 1][k];
    desk->line_values[1] = desk->values[last][k];
    desk->outside_count = 0;
    for (int i = last - 2; i > last - 2 - MET_BEFORE && i > last - (int)desk->seen; --i) {
        desk->outside[(int)desk->outside_count][0] = desk->at[i];
        desk->outside[(int)desk->outside_count][1] = desk->values[i][k];
        desk->outside_count += 1;
    }
    if (!zero_between(PASS begun, desk, desk->watch[k], &told) || told.other < 0) {
        return 0;
    }
    const brake_row *at = &desk->tries[told.at];
    event->before = desk->taken;
    event->which = k;
    met_moved(desk, at, &desk->tries[told.other], event);
    desk->met += 1;
    return !met_is_beyond(desk, at, event);
}

/* What lies before the last orbit: whether somebody has to look at it comes back, which may be known already. */
static enum run_stop met_judged(CONTEXT const phi_flow *begun, brake_desk *desk, enum run_stop stopped)
{
    const int last = (int)desk->count - 1, before = (int)desk->met;
    const phi_real trust = desk->trust;
    int is_crossed[DESK_WATCHED], is_any = 0;
    desk->doubtful = 0;
    for (int k = 0; k < (int)desk->watched; ++k) {
        const phi_real first = desk->values[last - 1][k], own = desk->values[last][k];
        is_crossed[k] = desk->watch[k][0] >= 0 && (first * own < 0 || (!(own < 0 || own > 0) && (first < 0 || first > 0)));
        is_any = is_any || is_crossed[k];
        /* Of what is not known here somebody else takes care. */
        desk->doubtful = desk->doubtful > 0 || (desk->seen > 2 && desk->watch[k][0] >= 0 && met_may_dip(desk, k));
        if (stopped == RUN_ON && is_crossed[k] && !(desk->watch[k][4] > 0 && first * own < 0)) {
            stopped = RUN_MET;
        }
    }
    if (stopped == RUN_ON && (desk->doubtful > 0 || run_may_turn(desk) || run_is_closed(desk) || !(desk->orbit.is_told > 0))) {
        stopped = RUN_MET;
    }
    if (is_any) {
        met_line(desk);
        desk->trust = trust > MET_TRUST ? trust : MET_TRUST;
    }
    for (int k = 0; k < (int)desk->watched && stopped == RUN_ON; ++k) {
        if (is_crossed[k] && !met_located(PASS begun, desk, k)) {
            stopped = RUN_MET;
        }
    }
    desk->trust = trust;
    desk->met = stopped == RUN_ON ? desk->met : before;
    desk->zero_count = 0;
    for (int i = before; i < (int)desk->met && desk->zero_count < DESK_ZEROS; ++i) {
        desk->zeros[(int)desk->zero_count][0] = desk->events[i].which;
        desk->zeros[(int)desk->zero_count][1] = desk->events[i].arclength;
        desk->zero_count += 1;
    }
    return stopped;
}
