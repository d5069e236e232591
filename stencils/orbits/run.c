/* A run along a family: how far a step may go (`continuation/steps.py` says the same of other curves), and what is told of an orbit. */
enum run_stop {
    RUN_ON,     /* nothing on the way */
    RUN_MET,    /* the last orbit is to be looked at: a test function, a gap, or the start may lie before it */
    RUN_TURNED, /* the same where det [J; t] has another sign: whether the orbit is one of the same family is open */
    RUN_SMALL   /* a step below the smallest would be needed */
};
enum run_what { RUN_TANGENT, RUN_UNKNOWN, RUN_ANGLE, RUN_ENERGY, RUN_SIGMA, RUN_BRAKE_LOSS, RUN_ODD_LOSS, RUN_UNEQUAL, RUN_SLOPE, RUN_STEEPNESS, RUN_KAPPA };

#define RUN_SHORT 3e-6   /* steps that are too short to jump a gap: a change of sign is believed there */
#define RUN_LEAP 1.8     /* length of a step over a singular place, in distances from it */
#define RUN_LONGER 2.2   /* length of a step, in that of the one before, above which it is such a leap */
#define RUN_GROWING 4.0  /* how far such a place may be, in steps, while they grow */
#define RUN_SHRINKING 12.0
#define RUN_SHORTEST 4   /* orbits of a loop */
#define RUN_WIDEST 1e-2  /* half widths of gaps */
#define RUN_EVALUATIONS (DESK_ASKED - 512)

/* The largest |kappa|, dV . t, and how steep the potential is at the rest. */
static void brake_turns(brake_desk *desk)
{
    brake_orbit *orbit = &desk->orbit;
    phi_real re[brake_links], im[brake_links], folded[brake_links * brake_links], rise = 0, angles = 0;
    orbit->energy_slope = orbit->largest_kappa = 0;
    memcpy(folded, orbit->folded, sizeof folded);
    const int count = small_eigenvalues(brake_links - 1, folded, re, im);
    for (int i = 0; i < brake_links - 1; ++i) {
        const phi_real own = i < count ? hypot(1 - 2 * re[i], 2 * im[i]) : (phi_real)NAN;
        orbit->largest_kappa = own <= orbit->largest_kappa ? orbit->largest_kappa : own;
    }
    for (int i = 0; i < brake_links; ++i) {
        const phi_real angle = orbit->y[brake_cart + i] * desk->scale[brake_cart + i];
        orbit->energy_slope += orbit->slope[i] * (orbit->tangent[brake_cart + i] * desk->scale[brake_cart + i]);
        rise += orbit->slope[i] * orbit->slope[i];
        angles += angle * angle;
    }
    orbit->steepness = sqrt(rise) * sqrt(angles) / (2 * orbit->energy);
}

/* All of an orbit that is known: its tangent towards the normal, and what is told of it. */
static void brake_found(CONTEXT brake_desk *desk)
{
    brake_tangent(desk, desk->normal);
    desk->orbit.is_told = brake_tell(PASS desk);
    desk->orbit.error = brake_error(&desk->orbit);
    desk->orbit.energy = brake_energy(PASS desk);
    brake_turns(desk);
}

/* The orbit at orbit->y as it is, whether it closes or not; 0 where the chain cannot be followed. */
static int brake_whole(CONTEXT const phi_flow *begun, brake_desk *desk)
{
    desk->orbit.taken = 0;
    desk->orbit.converged = desk->orbit.is_whole = 1;
    if (!brake_evaluate(PASS begun, desk, desk->tolerance, brake_columns)) {
        return 0;
    }
    brake_measure(desk);
    return 1;
}

/* The orbit at desk->guess, with what Newton still finds to be wrong with it taken off: its columns stay, which are as good. Its size comes back in `length`;
 * where that is too large nothing is taken off. */
static int brake_settle(CONTEXT const phi_flow *begun, brake_desk *desk, phi_real *length)
{
    phi_real left[brake_all];
    memcpy(desk->orbit.y, desk->guess, sizeof desk->orbit.y);
    if (!brake_whole(PASS begun, desk)) {
        return 0;
    }
    brake_found(PASS desk);
    *length = brake_left(desk, left);
    if (*length <= BRAKE_SETTLED) {
        for (int i = 0; i < brake_all; ++i) {
            desk->orbit.y[i] += left[i];
        }
    }
    return 1;
}

/* Whether the step to desk->orbit is taken, and the step to try behind it. */
static enum run_stop run_judged(brake_desk *desk, phi_real *next)
{
    const phi_real step = desk->step, turned = desk->turned < 1 ? desk->turned : 1, turn = acos(turned > -1 ? turned : -1);
    int is_turned;
    phi_real ahead;
    if (!(turn <= desk->max_angle && desk->shifted <= 0.5 * step && desk->moved > 0.1 * step)) {
        return RUN_SMALL;
    }
    const phi_real change = run_changed(desk, &is_turned, &ahead);
    /* A leap over a singular place that changes no sign leapt over two of them, or over none and unseen. */
    const int last = (int)desk->count - 1, is_leap = last > 0 && step > RUN_LONGER * (desk->at[last] - desk->at[last - 1]);
    const int is_taken = step <= RUN_SHORT || (!is_turned && change <= desk->max_change && !is_leap);
    if (!is_taken && !is_turned) {
        return RUN_SMALL;
    }
    /* Aim at a turn and at half the change that is allowed, both of which grow with the step. */
    const phi_real by_turn = desk->aim_angle / (turn > 1e-6 ? turn : 1e-6), by_change = 0.5 * desk->max_change / (change > 1e-6 ? change : 1e-6);
    phi_real factor = by_turn < by_change ? by_turn : by_change;
    factor = factor < 0.5 ? 0.5 : factor > 2 ? 2 : factor;
    factor = desk->orbit.taken >= desk->most_corrections - 1 && factor > 0.7 ? 0.7 : factor;
    const phi_real longer = step * factor > desk->step_min ? step * factor : desk->step_min;
    const phi_real usual = longer < desk->step_max ? longer : desk->step_max;
    ahead *= step;
    const phi_real leap = RUN_LEAP * ahead, reach = (factor < 1 ? RUN_SHRINKING : RUN_GROWING) * usual;
    *next = usual < ahead && ahead < reach && leap <= desk->step_max ? leap : usual;
    return is_taken ? RUN_ON : RUN_TURNED;
}

/* A test function at desk->orbit. */
static phi_real run_value(const brake_desk *desk, const phi_real watch[5])
{
    const brake_orbit *orbit = &desk->orbit;
    const int which = (int)watch[1];
    switch ((enum run_what)(int)watch[0]) {
    case RUN_TANGENT: return orbit->tangent[which] - watch[2];
    case RUN_UNKNOWN: return orbit->y[which] * desk->scale[which] - watch[2];
    case RUN_ANGLE: {
        phi_real largest = 0;
        for (int i = brake_cart; i < brake_q; ++i) {
            const phi_real own = fabs(orbit->y[i] * desk->scale[i]);
            largest = own > largest ? own : largest;
        }
        return largest - watch[2];
    }
    case RUN_ENERGY: return orbit->energy - watch[2];
    case RUN_SIGMA: return orbit->sigma - watch[2];
    case RUN_BRAKE_LOSS: return orbit->brake_loss - watch[2];
    case RUN_ODD_LOSS: return orbit->odd_loss - watch[2];
    case RUN_UNEQUAL: return orbit->unequal_brakes - watch[2];
    case RUN_SLOPE: return orbit->energy_slope - watch[2];
    case RUN_STEEPNESS: return orbit->steepness - watch[2];
    case RUN_KAPPA: return orbit->largest_kappa - watch[2];
    default: return (phi_real)NAN;
    }
}

/* Whether the branch may have turned away from a gap at the last orbit but one: sigma is least there, and a parabola of its square says so. */
static int run_may_turn(const brake_desk *desk)
{
    const int last = (int)desk->count - 1;
    const phi_real *sigma = desk->sigmas + last - 2, *at = desk->at + last - 2;
    if (last < 2 || !(fabs(sigma[0]) > fabs(sigma[1]) && fabs(sigma[1]) <= fabs(sigma[2]))) {
        return 0;
    }
    const phi_real rising = (sigma[2] * sigma[2] - sigma[1] * sigma[1]) / (at[2] - at[1]), falling = (sigma[1] * sigma[1] - sigma[0] * sigma[0]) / (at[1] - at[0]);
    const phi_real bend = (rising - falling) / (at[2] - at[0]), slope = falling + bend * (at[1] - at[0]);
    const phi_real least = sigma[1] * sigma[1] - slope * slope / (4 * bend);
    return bend > 0 && least > 0 && least <= 2 * RUN_WIDEST * RUN_WIDEST * bend;
}

/* Whether the last step passed through the run's start in its direction. */
static int run_is_closed(const brake_desk *desk)
{
    const phi_real(*before)[brake_all] = desk->known[(int)desk->count - 2], (*after)[brake_all] = desk->known[(int)desk->count - 1];
    phi_real along = 0, behind = 0, beyond = 0;
    for (int i = 0; i < brake_all; ++i) {
        along += after[1][i] * desk->start[1][i];
        behind += desk->start[1][i] * (before[0][i] - desk->start[0][i]);
        beyond += desk->start[1][i] * (after[0][i] - desk->start[0][i]);
    }
    return desk->since >= RUN_SHORTEST && along > 0 && behind < 0 && beyond >= 0;
}

/* desk->orbit as the next one of the run, told in a row, with the step to try behind it. */
static void run_taken(brake_desk *desk, const phi_real next)
{
    brake_row *row = &desk->rows[(int)desk->taken];
    int last = (int)desk->count - 1;
    row->arclength = desk->at[last] + desk->moved;
    row->step = next;
    row->orbit = desk->orbit;
    if (last + 1 == DESK_KNOWN || last + 1 == RUN_TOUCHED) {
        memmove(desk->known, desk->known[1], sizeof desk->known - sizeof desk->known[0]);
        memmove(desk->at, desk->at + 1, sizeof desk->at - sizeof desk->at[0]);
        memmove(desk->values, desk->values[1], sizeof desk->values - sizeof desk->values[0]);
        memmove(desk->sigmas, desk->sigmas + 1, sizeof desk->sigmas - sizeof desk->sigmas[0]);
        last -= 1;
    }
    last += 1;
    desk->count = last + 1;
    desk->seen = desk->seen + 1 < desk->count ? desk->seen + 1 : desk->count;
    memcpy(desk->known[last][0], desk->orbit.y, sizeof desk->orbit.y);
    memcpy(desk->known[last][1], desk->orbit.tangent, sizeof desk->orbit.tangent);
    memcpy(desk->before_jacobian, desk->orbit.jacobian, sizeof desk->before_jacobian);
    memcpy(desk->before_tangent, desk->orbit.tangent, sizeof desk->before_tangent);
    desk->at[last] = row->arclength;
    desk->sigmas[last] = desk->orbit.sigma;
    desk->since += 1;
    for (int k = 0; k < (int)desk->watched; ++k) {
        row->values[k] = desk->values[last][k] = run_value(desk, desk->watch[k]);
    }
}
