/* What a run meets on its way: zeros of test functions that it passes are located at once (`met/locate.py` says the same of other curves);
 * orbits before which something else may lie are somebody's to look at. */
#define MET_BEFORE 3      /* orbits before a step that help to find zeros in it */
#define MET_TRUST 1e-8    /* corrections on the way that are taken without asking again */
#define MET_SPACING 1e-14 /* how far off a zero may be, in units of 1 + s */
#define MET_BESIDE 1e-9   /* how far from the orbit that is computed, likewise */
#define MET_REGULAR 0.1   /* sigma, in the larger one of the step's ends, below which no other orbit is guessed from one */
#define MET_LINKS 2       /* with more there are several kappa, of which it has to be known which is which */

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

/* The zero beside an orbit that was computed: along its tangent, and what else is known by its change from another one, where the function has a value. */
static void met_moved(const brake_desk *desk, const brake_row *at, const brake_row *other, const phi_real value, brake_event *event)
{
    const phi_real apart = at->arclength - other->arclength, fallen = at->values[0] - value;
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
    if (!zero_between(PASS begun, desk, desk->watch[k], &told) || (told.other == ZERO_FIRST && !(desk->taken > 0))) {
        return 0;
    }
    /* Where all tries lie together it is an end of the step, both of which are rows of this run. */
    const brake_row *at = &desk->tries[told.at], *ends = &desk->rows[(int)desk->taken];
    const brake_row *other = told.other == ZERO_FIRST ? ends - 1 : told.other == ZERO_END ? ends : &desk->tries[told.other];
    const phi_real value = other->values[told.other < 0 ? k : 0];
    event->before = desk->taken;
    event->which = k;
    met_moved(desk, at, other, value, event);
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
        desk->doubtful = desk->doubtful > 0 || (desk->seen > 2 && desk->watch[k][0] >= 0 && dip_may_dip(desk, k));
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
