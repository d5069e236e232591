/* The larger of two numbers; the second where one is NaN. */
static phi_real stem_larger(const phi_real a, const phi_real b)
{
    return a > b ? a : b;
}

/* The power of two just below a length of time; 1 for none. */
static phi_real stem_unit(const phi_real length)
{
    int exponent = 0;
    const phi_real share = phi_frexp(length, &exponent);
    return share > 0 || share < 0 ? phi_ldexp(1, exponent - 1) : 1;
}

/* Logarithm of a size to the power 1 / order, in seconds; `shift` is the binary exponent of the unit of time. Its binary
 * exponent is counted apart, so that the unit does not touch a digit. */
static phi_real stem_root(const int order, const int shift, const phi_real size)
{
    int exponent = 0;
    const phi_real digits = phi_frexp(size, &exponent);
    if (!(digits > 0)) {
        return -PHI_HUGE;
    }
    return (phi_log(digits) + (phi_real)(exponent - order * shift) * PHI_LOG_TWO) / (phi_real)order;
}

/* The time at which neither of the last two terms exceeds the goal; given are their sizes over the goal. */
static phi_real stem_radius(const int order, const phi_real unit, const phi_real end, const phi_real next)
{
    int exponent = 0;
    (void)phi_frexp(unit, &exponent);
    return phi_exp(-stem_larger(stem_root(order, exponent - 1, end), stem_root(order - 1, exponent - 1, next)));
}

/* Step lengths: each of the last two terms within the goal, relative to the motion (Jorba and Zou 2005). Zero where a
 * coefficient or the square of a rate is not finite. `scales` holds the fastest linear rate and the length of the chain. */
static void stem_lengths(const int order, const stem_jets *jet, const phi_real goal, const phi_real scales[2], phi_real length[stem_lane_count])
{
    phi_real state[2][stem_lane_count], last[2][stem_lane_count], before[2][stem_lane_count];
    stem_lanes finite = STEM_ZERO;
    for (int i = 0; i < stem_x; ++i) {
        finite += 0 * jet->x[order][i];
    }
    for (int i = stem_q; i < stem_x; ++i) {
        finite += 0 * (jet->state[i] * jet->state[i]);
    }
    stem_norms(scales[1], jet->state, state);
    stem_norms(scales[1], jet->x[order], last);
    stem_norms(scales[1], jet->x[order - 1], before);
    for (int lane = 0; lane < stem_lane_count; ++lane) {
        const phi_real zero = STEM_OF(finite, lane), unit = STEM_OF(jet->start.unit[0], lane);
        const phi_real wide = stem_larger(state[0][lane], state[1][lane] / scales[0]);
        const phi_real angle = goal * (wide < 1 ? wide : 1);
        const phi_real rate = unit * stem_larger(angle * scales[0], goal * state[1][lane]);
        const phi_real end = stem_larger(last[0][lane] / angle, last[1][lane] / rate);
        const phi_real next = stem_larger(before[0][lane] / angle, before[1][lane] / rate);
        length[lane] = zero >= 0 && zero <= 0 ? stem_radius(order, unit, end, next) : 0;
    }
}

/* How far the series are from the equations at the ends of their steps: h times the difference of the two slopes there,
 * over what is allowed. Expects the start of the next steps in jet->end, and h times the series' slopes. */
static void stem_defects(const stem_jets *jet, const stem_lanes along[stem_x], const stem_lanes *h, const phi_real room, const phi_real scales[2], phi_real defect[stem_lane_count])
{
    stem_lanes apart[stem_x], slope[stem_x];
    phi_real state[2][stem_lane_count], motion[2][stem_lane_count], off[2][stem_lane_count];
    const stem_lanes t = *h / jet->start.unit[0], unit = jet->start.unit[0] / jet->end.unit[0], square = unit * unit;
    for (int i = 0; i < stem_x; ++i) {
        slope[i] = t * (jet->end.slope[i] * (i < stem_q ? unit : square));
        apart[i] = along[i] - slope[i];
    }
    stem_norms(scales[1], jet->state, state);
    stem_norms(scales[1], slope, motion);
    stem_norms(scales[1], apart, off);
    for (int lane = 0; lane < stem_lane_count; ++lane) {
        const phi_real wide = stem_larger(state[0][lane], state[1][lane] / scales[0]);
        const phi_real angle = wide < 1 ? wide : 1;
        const phi_real rate = STEM_OF(jet->start.unit[0], lane) * stem_larger(angle * scales[0], state[1][lane]);
        const phi_real of_angle = off[0][lane] / stem_larger(angle, motion[0][lane]);
        /* A large angle is known to as many digits only, and so is its acceleration. */
        const phi_real digits = stem_larger(state[0][lane], 1);
        const phi_real of_rate = off[1][lane] / stem_larger(rate, motion[1][lane] * digits);
        defect[lane] = stem_larger(of_angle, of_rate) / room;
    }
}

/* Each lane's first of h, h/2, h/4, ... at whose end the series keeps to the equations; what the next steps start from
 * is left in jet->end, where they start in jet->moved. Coefficients alone mislead where they have not seen yet what moves
 * next: when a chain is released from rest, its outer links enter at an order that no series reaches. A defect that
 * shrinks no faster than the step is rounding: no shorter step would help. */
static void stem_check(CONTEXT const int order, stem_jets *jet, const phi_real goal, const phi_real scales[2], stem_lanes *h)
{
    const phi_real room = PHI_ROOM * stem_larger(goal, PHI_EPSILON);
    phi_real defect[stem_lane_count], last[stem_lane_count] = {0};
    int slow[stem_lane_count] = {0}, shorter = 1;
    while (shorter) {
        stem_lanes increment[stem_x], along[stem_x], unit = *h;
        stem_advance(order, jet, h, increment, along);
        stem_move(increment, jet);
        for (int lane = 0; lane < stem_lane_count; ++lane) {
            STEM_AT(unit, lane) = stem_unit(phi_abs(STEM_OF(*h, lane)));
        }
        stem_begin(PASS jet, jet->moved, jet->moved_lost, &unit, &jet->end);
        stem_defects(jet, along, h, room, scales, defect);
        shorter = 0;
        for (int lane = 0; lane < stem_lane_count; ++lane) {
            if (!(defect[lane] > 1) || slow[lane] == 3) {
                continue;
            }
            slow[lane] = 4 * defect[lane] > last[lane] && defect[lane] * room < PHI_NOISE ? slow[lane] + 1 : 0;
            last[lane] = defect[lane];
            if (slow[lane] < 3) {
                STEM_AT(*h, lane) /= 2;
                shorter = 1;
            }
        }
    }
}
