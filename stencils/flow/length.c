/* The larger of two numbers; the second where one is NaN. */
static phi_real stem_larger(const phi_real a, const phi_real b)
{
    return a > b ? a : b;
}

/* Powers of two just below lengths of time; 1 for none. */
static void stem_unit(const stem_lanes *length, stem_lanes *unit)
{
    const stem_lanes one = STEM_ZERO + 1;
    stem_words bits;
    memcpy(&bits, length, sizeof bits);
    bits &= ~PHI_DIGITS_MASK;
    memcpy(unit, &bits, sizeof bits);
    *unit = STEM_CHOOSE((*length > PHI_NEAR) & (*length < PHI_FAR), *unit, one);
}

/* Binary logarithms of sizes, to a hundredth, to the power 1 / order, in units of seconds. Exponents are counted apart, so
 * that the unit of time does not touch a digit. Nothing counts as the least number. */
static void stem_root(const int order, const stem_lanes *unit, const stem_lanes *size, stem_lanes *root)
{
    const stem_lanes zero = STEM_ZERO;
    const stem_lanes some = STEM_CHOOSE(*size > 0, *size, zero);
    stem_words bits, unit_bits, rest;
    stem_lanes exponent, shift, digits;
    memcpy(&bits, &some, sizeof bits);
    memcpy(&unit_bits, unit, sizeof unit_bits);
    rest = (bits & PHI_DIGITS_MASK) | PHI_ONE_BITS;
    bits = (bits >> PHI_DIGITS) | PHI_COUNT_BITS;
    unit_bits = (unit_bits >> PHI_DIGITS) | PHI_COUNT_BITS;
    memcpy(&digits, &rest, sizeof rest);
    memcpy(&exponent, &bits, sizeof bits);
    memcpy(&shift, &unit_bits, sizeof unit_bits);
    exponent = (exponent - PHI_COUNT_ONE) - (phi_real)order * (shift - PHI_COUNT_ONE);
    *root = (exponent + ((6 - digits) * digits - 5) / 3) / (phi_real)order;
}

/* Order of the series for a local error: as many more as it has digits. */
static int stem_order_for(const phi_real goal)
{
    const stem_lanes one = STEM_ZERO + 1, size = STEM_ZERO + goal;
    stem_lanes root;
    stem_root(1, &one, &size, &root);
    const phi_real wanted = 1 - PHI_SHARE * STEM_OF(root, 0);
    const int whole = (int)wanted, order = (phi_real)whole < wanted ? whole + 1 : whole;
    return order < 4 ? 4 : (order > stem_highest ? stem_highest : order);
}

/* Times at which neither of the last two terms exceeds the goal, to half a per cent; given are their sizes over the goal. */
static void stem_radius(const int order, const stem_lanes *unit, const stem_lanes *end, const stem_lanes *next, stem_lanes *radius)
{
    const stem_lanes limit = STEM_ZERO + PHI_HUGE;
    stem_lanes of_end, of_next, power, rounded, part;
    stem_words bits, shift;
    stem_root(order, unit, end, &of_end);
    stem_root(order - 1, unit, next, &of_next);
    power = -STEM_LARGER(of_end, of_next);
    power = STEM_CHOOSE(power < limit, power, limit);
    power = STEM_CHOOSE(power > -limit, power, -limit);
    /* The nearest whole number ends up in the last bits of `rounded`. */
    rounded = power + PHI_ROUNDER;
    part = power - (rounded - PHI_ROUNDER);
    part = 1 + part * (35 + 12 * part) / 50;
    memcpy(&bits, &part, sizeof bits);
    memcpy(&shift, &rounded, sizeof shift);
    bits += shift << PHI_DIGITS;
    memcpy(radius, &bits, sizeof bits);
}

/* Step lengths: each of the last two terms within the goal, relative to the motion (Jorba and Zou 2005). Zero where a
 * coefficient or the square of a rate is not finite. `scales` holds the fastest linear rate and the length of the chain, `state` the
 * states' norms. */
static void stem_lengths(const int order, const stem_jets *jet, const phi_real goal, const phi_real scales[PHI_SCALE_COUNT], const stem_lanes state[2], stem_lanes *length)
{
    const stem_lanes zero = STEM_ZERO, one = STEM_ZERO + 1, unit = jet->start->unit[0];
    stem_lanes last[2], before[2], finite = zero, rates = zero, turned = zero;
    for (int i = 0; i < stem_q; ++i) {
#if WITH_SHARED
        finite += 0 * jet->x[order][i];
        rates += 0 * jet->x[order + 1][i];
#else
        finite += 0 * jet->x[order][i];
        rates += 0 * jet->x[order][stem_q + i];
#endif
        turned += 0 * (jet->state[stem_q + i] * jet->state[stem_q + i]);
    }
    finite += rates + turned;
    stem_terms(order, jet, scales[1], last);
    stem_terms(order - 1, jet, scales[1], before);
#if WITH_FORCING
    /* From rest a forced chain moves as far in a unit of time as its first coefficients say. */
    stem_lanes first[2], second[2];
    stem_terms(1, jet, scales[1], first);
    stem_terms(2, jet, scales[1], second);
    const stem_lanes driven = STEM_LARGER(first[1], second[1]), going = state[1] / scales[0];
    const stem_lanes turning = STEM_LARGER(going, driven), wide = STEM_LARGER(state[0], turning);
#else
    const stem_lanes turning = state[1] / scales[0], wide = STEM_LARGER(state[0], turning);
#endif
    const stem_lanes angle = goal * STEM_CHOOSE(wide < 1, wide, one);
#if WITH_SPRINGS
    /* A stiff spring moves links by little and fast. What rates may be off by follows from them alone and, where that motion
     * turns, from its acceleration; angles speak of the weight. */
    stem_lanes begun[2];
    stem_terms(1, jet, scales[1], begun);
    const stem_lanes shaken = begun[1] * ((scales[0] > 0 ? 1 / scales[0] : 0) / jet->start->unit[1]);
    const stem_lanes linear = angle * scales[PHI_WEIGHT_SCALE], moving = goal * STEM_LARGER(shaken, state[1]);
#else
    const stem_lanes linear = angle * scales[0], moving = goal * state[1];
#endif
    const stem_lanes rate = unit * STEM_LARGER(linear, moving);
    const stem_lanes last_angle = last[0] / angle, last_rate = last[1] / rate;
    const stem_lanes next_angle = before[0] / angle, next_rate = before[1] / rate;
    const stem_lanes end = STEM_LARGER(last_angle, last_rate), next = STEM_LARGER(next_angle, next_rate);
    stem_lanes radius;
    stem_radius(order, &unit, &end, &next, &radius);
    *length = STEM_CHOOSE((finite >= 0) & (finite <= 0), radius, zero);
}

/* How far the series are from the equations at the ends of their steps: h times the difference of the rates' two slopes there,
 * over what is allowed. Expects the start of the next steps in jet->end, and h times the series' slopes; angles have their rates
 * for slopes, whatever the equations say. */
static void stem_defects(const stem_jets *jet, const stem_lanes along[stem_q], const stem_lanes *h, const phi_real room, const phi_real scales[PHI_SCALE_COUNT], const stem_lanes state[2], stem_lanes *defect)
{
    stem_lanes apart[stem_q], slope[stem_q], motion, off;
    const stem_lanes t = *h / jet->start->unit[0], unit = jet->start->unit[0] / jet->end->unit[0], share = t * (unit * unit);
    const stem_lanes one = STEM_ZERO + 1;
    for (int i = 0; i < stem_q; ++i) {
#if WITH_SHARED
        slope[i] = share * (2 * jet->end->row[1][i]);
#else
        slope[i] = share * jet->end->slope[stem_q + i];
#endif
        apart[i] = along[i] - slope[i];
    }
    stem_norm(scales[1], slope, &motion);
    stem_norm(scales[1], apart, &off);
    const stem_lanes turning = state[1] / scales[0], wide = STEM_LARGER(state[0], turning);
    const stem_lanes angle = STEM_CHOOSE(wide < 1, wide, one), linear = angle * scales[PHI_WEIGHT_SCALE];
    const stem_lanes rate = jet->start->unit[0] * STEM_LARGER(linear, state[1]);
    /* A large angle is known to as many digits only, and so is its acceleration. */
    const stem_lanes moving = motion * STEM_LARGER(state[0], one);
    *defect = off / STEM_LARGER(rate, moving) / room;
}

/* Each lane's first of h, h/2, h/4, ... at whose end the series keeps to the equations; what the next steps start from
 * is left in jet->end, where they start in jet->moved. Coefficients alone mislead where they have not seen yet what moves
 * next: when a chain is released from rest, its outer links enter at an order that no series reaches. A defect that
 * shrinks no faster than the step is rounding: no shorter step would help. */
static void stem_check(CONTEXT const int order, stem_jets *jet, const phi_real goal, const phi_real scales[PHI_SCALE_COUNT], const stem_lanes state[2], stem_lanes *h)
{
    const phi_real room = PHI_ROOM * stem_larger(goal, PHI_EPSILON);
    phi_real last[stem_lane_count] = {0};
    int slow[stem_lane_count] = {0}, shorter = 1;
    while (shorter) {
        stem_lanes increment[stem_x], along[stem_q], defects, unit, length = STEM_SIZE(*h);
        stem_advance(order, jet, h, increment, along);
        stem_move(increment, jet);
        stem_unit(&length, &unit);
        stem_begin(PASS jet, jet->moved, jet->moved_lost, &unit, AFTER(h) jet->end);
        stem_defects(jet, along, h, room, scales, state, &defects);
        shorter = 0;
        for (int lane = 0; lane < stem_lane_count; ++lane) {
            const phi_real defect = STEM_OF(defects, lane);
            if (!(defect > 1) || slow[lane] == 3) {
                continue;
            }
            slow[lane] = 4 * defect > last[lane] && defect * room < PHI_NOISE ? slow[lane] + 1 : 0;
            last[lane] = defect;
            if (slow[lane] < 3) {
                STEM_AT(*h, lane) /= 2;
                shorter = 1;
            }
        }
    }
}
