/* Largest angle and rate of a row in every lane, the cart's in lengths of the chain. */
static void stem_norms(const phi_real reach, const stem_lanes x[stem_x], phi_real norm[2][stem_lane_count])
{
    for (int lane = 0; lane < stem_lane_count; ++lane) {
        norm[0][lane] = norm[1][lane] = 0;
    }
    for (int i = 0; i < stem_q; ++i) {
        const phi_real share = i < stem_cart ? 1 / reach : 1;
        for (int lane = 0; lane < stem_lane_count; ++lane) {
            const phi_real angle = phi_abs(STEM_OF(x[i], lane)) * share, rate = phi_abs(STEM_OF(x[stem_q + i], lane)) * share;
            norm[0][lane] = angle > norm[0][lane] ? angle : norm[0][lane];
            norm[1][lane] = rate > norm[1][lane] ? rate : norm[1][lane];
        }
    }
}
