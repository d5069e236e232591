/* Largest angle and rate of a row in every lane, the cart's in lengths of the chain. */
static void stem_norms(const phi_real reach, const stem_lanes x[stem_x], stem_lanes norm[2])
{
    stem_lanes angle = STEM_ZERO, rate = STEM_ZERO;
    for (int i = 0; i < stem_q; ++i) {
        const phi_real share = i < stem_cart ? 1 / reach : 1;
        const stem_lanes of_angle = STEM_SIZE(x[i]) * share, of_rate = STEM_SIZE(x[stem_q + i]) * share;
        angle = STEM_LARGER(of_angle, angle);
        rate = STEM_LARGER(of_rate, rate);
    }
    norm[0] = angle;
    norm[1] = rate;
}
