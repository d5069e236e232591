/* The polynomial that touches a curve at several of its points, over the distance along a direction: Hermite's, of the points that do
 * not turn away from it (`continuation/osculating.py` says the same of other curves).
 *   count  in   points
 *   known  in   each of them, and the curve's unit tangent there
 *   axis   in   unit vector
 *   place  in   axis . y that is wanted
 *   there  out  y
 * 0 comes back where no point goes along the axis. */
static int touch_curve(const int count, phi_real (*known)[2][TOUCH_SIZE], const phi_real axis[TOUCH_SIZE], const phi_real place, phi_real there[TOUCH_SIZE])
{
    phi_real own[TOUCH_MOST], along[TOUCH_MOST], off[TOUCH_MOST];
    int kept[TOUCH_MOST], ranked[TOUCH_MOST], all = 0, few = 0;
    for (int k = 0; k < count; ++k) {
        own[k] = along[k] = 0;
        for (int i = 0; i < TOUCH_SIZE; ++i) {
            own[k] += known[k][0][i] * axis[i];
            along[k] += known[k][1][i] * axis[i];
        }
        off[k] = place - own[k];
        if (along[k] > TOUCH_TURNED) {
            int at = all++;
            for (; at > 0 && fabs(off[ranked[at - 1]]) > fabs(off[k]); --at) {
                ranked[at] = ranked[at - 1];
            }
            ranked[at] = k;
        }
    }
    /* The nearest first; of two that are close together beside their distance the farther adds nothing but rounding. */
    for (int r = 0; r < all; ++r) {
        int is_new = 1;
        for (int j = 0; j < few && is_new; ++j) {
            is_new = fabs(own[ranked[r]] - own[kept[j]]) > TOUCH_APART * fabs(off[ranked[r]]);
        }
        if (is_new) {
            kept[few++] = ranked[r];
        }
    }
    for (int i = 0; i < TOUCH_SIZE; ++i) {
        there[i] = 0;
    }
    for (int r = 0; r < few; ++r) {
        const int k = kept[r];
        phi_real lagrange = 1, bend = 0;
        for (int j = 0; j < few; ++j) {
            if (j != r) {
                const phi_real apart = own[k] - own[kept[j]];
                lagrange *= off[kept[j]] / apart;
                bend += 1 / apart;
            }
        }
        const phi_real square = lagrange * lagrange, value = (1 - 2 * off[k] * bend) * square, slope = off[k] * square / along[k];
        for (int i = 0; i < TOUCH_SIZE; ++i) {
            there[i] += value * known[k][0][i] + slope * known[k][1][i];
        }
    }
    return few;
}
