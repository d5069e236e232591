/* Forces repeat every turn, and large angles have no digits to spare: angles are followed within a turn of the hanging
 * chain, whole turns are counted apart. 2 pi = turn_high + turn_low to twice the precision. */
static const phi_real stem_turn_high = PHI_TURN_HIGH, stem_turn_low = PHI_TURN_LOW;

/* The nearest whole number. */
static phi_real stem_whole(const phi_real x)
{
    const phi_real size = phi_abs(x), whole = size < PHI_WHOLE ? (size + PHI_WHOLE) - PHI_WHOLE : size;
    return x < 0 ? -whole : whole;
}

/* An angle and its whole turns as one number. */
static phi_real stem_turned(const phi_real x, const phi_real turns)
{
    if (!(turns > 0 || turns < 0)) {
        return x;
    }
    return stem_fused(turns, stem_turn_high, x + turns * stem_turn_low);
}

/* Take whole turns out of a lane's angles, to the last bit that `lost` can hold; whether there were any. */
static int stem_wind(const int lane, stem_jets *jet)
{
    int wound = 0;
    for (int i = stem_cart; i < stem_q; ++i) {
        const phi_real x = STEM_OF(jet->state[i], lane);
        if (phi_abs(x) > 4) {
            const phi_real turns = stem_whole(x / stem_turn_high);
            const phi_real rest = stem_fused(-turns, stem_turn_high, x);
            const phi_real whole = STEM_OF(jet->lost[i], lane) - turns * stem_turn_low, sum = rest + whole;
            STEM_AT(jet->state[i], lane) = sum;
            STEM_AT(jet->lost[i], lane) = whole - (sum - rest);
            STEM_AT(jet->turns[i], lane) += turns;
            wound = 1;
        }
    }
    return wound;
}

/* A lane's angles as they are, rounded; `lost` holds the rest. */
static void stem_unwind(const int lane, stem_jets *jet)
{
    for (int i = stem_cart; i < stem_q; ++i) {
        const phi_real turns = STEM_OF(jet->turns[i], lane), x = STEM_OF(jet->state[i], lane);
        if (turns > 0 || turns < 0) {
            const phi_real large = turns * stem_turn_high, near = large + x, part = near - large;
            const phi_real rest = stem_fused(turns, stem_turn_high, -large) + turns * stem_turn_low;
            const phi_real whole = ((large - (near - part)) + (x - part)) + (rest + STEM_OF(jet->lost[i], lane));
            const phi_real sum = near + whole;
            STEM_AT(jet->state[i], lane) = sum;
            STEM_AT(jet->lost[i], lane) = whole - (sum - near);
            STEM_AT(jet->turns[i], lane) = 0;
        }
    }
}
