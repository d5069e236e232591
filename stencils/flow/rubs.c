/* Coefficients f_k of T(s) = tanh(root s) / root s about s_0 = `square`, from T(s_0) = `share` and 1 - tanh^2 = `steepness`.
 * From 4 on by q' = -T q and 2 s T' = q - T for q = 1 - s T^2, as f_k s_0^k, since f_k itself soon leaves the type's range; below,
 * where these lose digits, by the continued fraction T = 1 / (1 + s / (3 + s / (5 + ...))), whose series have no differences. */
static STEM_APART void stem_taylor(const phi_real square, const phi_real share, const phi_real steepness, phi_real f[PHI_RESTRICT stem_highest + 2])
{
    phi_real other[stem_highest + 2];
    if (square < 4) {
        memset(f, 0, (size_t)(stem_highest + 2) * sizeof *f);
        f[0] = 1 / (phi_real)27;
        for (int odd = 25; odd > 0; odd -= 2) {
            other[0] = (phi_real)odd + square * f[0];
            for (int k = 1; k < stem_highest + 2; ++k) {
                other[k] = square * f[k] + f[k - 1];
            }
            f[0] = 1 / other[0];
            for (int k = 1; k < stem_highest + 2; ++k) {
                phi_real sum = other[k] * f[0];
                for (int j = 1; j < k; ++j) {
                    sum += other[j] * f[k - j];
                }
                f[k] = -(f[0] * sum);
            }
        }
        return;
    }
    f[0] = share;
    other[0] = steepness;
    for (int k = 0; k < stem_highest + 1; ++k) {
        phi_real sum = 0;
        for (int j = 0; j <= k; ++j) {
            sum += f[j] * other[k - j];
        }
        f[k + 1] = PHI_HALF * (other[k] - (phi_real)(2 * k + 1) * f[k]) / (phi_real)(k + 1);
        other[k + 1] = -(square * sum) / (phi_real)(k + 1);
    }
}

/* The same for every place that rubs and every lane: with c = s_0 from 4 on and 1 below, 1 / c, f_1 itself, and f_k c^k from 2 on, where
 * powers of (s - s_0) / c meet them. */
static void stem_rub(stem_start *PHI_RESTRICT start)
{
    for (int i = 0; i < stem_rubs; ++i) {
        const stem_lanes *place = STEM_BEGUN + (stem_width - 5 * stem_rubs + 5 * i);
        for (int lane = 0; lane < stem_lane_count; ++lane) {
            const phi_real x = STEM_OF(place[0], lane), y = STEM_OF(place[1], lane), z = STEM_OF(place[2], lane);
            phi_real f[stem_highest + 2];
            const phi_real square = x * x + y * y + z * z;
            stem_taylor(square, STEM_OF(place[4], lane), STEM_OF(place[3], lane), f);
            f[0] = square < 4 ? 1 : 1 / square;
            f[1] *= f[0];
            for (int k = 0; k < stem_highest + 2; ++k) {
                STEM_AT(start->rubs[k][i], lane) = f[k];
            }
        }
    }
}

/* What makes up dry friction at order n, behind the other sums, of the rates w_j over v_0, s_j and T_j that left rows j + 1 hold:
 * sums of w_j.w_{n-j} and of T_j w_{n-j} over 0 < j < n, the part of T_n that powers of s - s_0 from the second on make, and f_1. */
static void stem_rub_sums(const int n, stem_jets *PHI_RESTRICT jet, stem_lanes *PHI_RESTRICT sums)
{
    for (int i = 0; i < stem_rubs; ++i, sums += 6) {
        const int w = stem_width - 5 * stem_rubs + 5 * i, s = w + 3, t = w + 4;
        stem_lanes square = STEM_ZERO, x = STEM_ZERO, y = STEM_ZERO, z = STEM_ZERO, beyond = STEM_ZERO;
        for (int j = 1; j < n; ++j) {
            const stem_lanes *near = STEM_LEFT(j + 1), *far = STEM_LEFT(n - j + 1);
            square += near[w] * far[w] + near[w + 1] * far[w + 1] + near[w + 2] * far[w + 2];
            x += near[t] * far[w];
            y += near[t] * far[w + 1];
            z += near[t] * far[w + 2];
        }
        jet->powers[n - 1][1][i] = jet->start->rubs[0][i] * STEM_LEFT(n)[s];
        for (int k = 2; k <= n; ++k) {
            stem_lanes power = STEM_ZERO;
            for (int j = 1; j <= n - k + 1; ++j) {
                power += jet->powers[j][1][i] * jet->powers[n - j][k - 1][i];
            }
            jet->powers[n][k][i] = power;
            beyond += jet->start->rubs[k][i] * power;
        }
        sums[0] = square;
        sums[1] = x;
        sums[2] = y;
        sums[3] = z;
        sums[4] = beyond;
        sums[5] = jet->start->rubs[1][i];
    }
}
