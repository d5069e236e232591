/* Sums of order n over 0 <= j <= n of left_j right_{n-j}, where orders come one by one. */
static void stem_sums(const int n, const stem_jets *PHI_RESTRICT jet, stem_lanes *PHI_RESTRICT sums)
{
    for (int row = 0; row < stem_rights; ++row) {
        for (int i = 0; i < stem_lefts; ++i) {
            stem_lanes sum = jet->left[0][i] * jet->right[n][stem_lefts * row + i];
            int j = 1;
            do {
                sum += jet->left[j][i] * jet->right[n - j][stem_lefts * row + i];
            } while (++j <= n);
            sums[stem_lefts * row + i] = sum;
        }
    }
}

/* Orders come in blocks of four: what the sums of orders n to n + 3 can take from rows up to n, four sums at a time,
 * which share what they read. For n > 3. */
static void stem_ahead(const int n, stem_jets *PHI_RESTRICT jet)
{
#if WITH_TRIPLES
    stem_ahead_triples(n, jet);
    for (int row = 1; row < stem_rights; ++row) {
#else
    for (int row = 0; row < stem_rights; ++row) {
#endif
        for (int i = 0; i < stem_lefts; ++i) {
            const int k = stem_lefts * row + i;
            stem_lanes far = jet->right[n - 1][k], middle = jet->right[n - 2][k], near = jet->right[n - 3][k];
            stem_lanes first = jet->left[1][i] * far + jet->left[2][i] * middle + jet->left[3][i] * near;
            stem_lanes second = jet->left[2][i] * far + jet->left[3][i] * middle;
            stem_lanes third = jet->left[3][i] * far, fourth = STEM_ZERO;
            int j = 4;
            do {
                const stem_lanes left = jet->left[j][i], right = jet->right[n - j][k];
                first += left * right;
                second += left * near;
                third += left * middle;
                fourth += left * far;
                far = middle;
                middle = near;
                near = right;
            } while (++j <= n);
            far = jet->right[n][k];
            jet->sums[0][k] = first + jet->left[0][i] * far;
            jet->sums[1][k] = second + jet->left[1][i] * far;
            jet->sums[2][k] = third + jet->left[2][i] * far;
            jet->sums[3][k] = fourth + jet->left[3][i] * far;
        }
    }
}

/* What the sums `turn` orders after the start of a block still want of the rows that have come since; the newest last, for
 * which everything else waits. */
static STEM_SINGLY void stem_rest(const int n, const int turn, stem_jets *PHI_RESTRICT jet)
{
#if WITH_TRIPLES
    stem_rest_triples(n, turn, jet);
    for (int row = 1; row < stem_rights; ++row) {
#else
    for (int row = 0; row < stem_rights; ++row) {
#endif
        for (int i = 0; i < stem_lefts; ++i) {
            const int k = stem_lefts * row + i;
            stem_lanes sum = jet->sums[turn][k];
            int j = turn - 1;
            do {
                sum += jet->left[j][i] * jet->right[n - j][k];
                sum += jet->left[n - j][i] * jet->right[j][k];
            } while (--j >= 0);
            jet->sums[turn][k] = sum;
        }
    }
}
#if WITH_SQUARES

/* Sums of order n of left_j left_{n-j}, behind the others, where orders come one by one. */
static void stem_square_sums(const int n, const stem_jets *PHI_RESTRICT jet, stem_lanes *PHI_RESTRICT sums)
{
    for (int i = 0; i < stem_squares; ++i) {
        stem_lanes sum = jet->left[0][i] * jet->left[n][i];
        for (int j = 1; 2 * j < n; ++j) {
            sum += jet->left[j][i] * jet->left[n - j][i];
        }
        sum += sum;
        if (n % 2 == 0) {
            sum += jet->left[n / 2][i] * jet->left[n / 2][i];
        }
        sums[i] = sum;
    }
}
#if !WITH_TRIPLES

/* What the sums of orders n to n + 3 can take from rows up to n, every pair once; order n is whole then. For n > 3. */
static void stem_square_ahead(const int n, stem_jets *PHI_RESTRICT jet)
{
    enum { behind = stem_lefts * stem_rights };
    const int half = (n - 1) / 2;
    for (int i = 0; i < stem_squares; ++i) {
        stem_lanes near = jet->left[n][i], middle = STEM_ZERO, far = middle;
        stem_lanes first = jet->left[0][i] * near, second = middle, third = middle, fourth = middle;
        int j = 1;
        do {
            const stem_lanes row = jet->left[j][i], other = jet->left[n - j][i];
            first += row * other;
            second += row * near;
            third += row * middle;
            fourth += row * far;
            far = middle;
            middle = near;
            near = other;
        } while (++j <= half);
        jet->sums[0][behind + i] = first;
        jet->sums[1][behind + i] = second;
        jet->sums[2][behind + i] = third;
        jet->sums[3][behind + i] = fourth;
    }
    /* The rows in the middle meet themselves and each other. */
    for (int i = 0; i < stem_squares; ++i) {
        const stem_lanes row = jet->left[half + 1][i], next = jet->left[half + 2][i], third = jet->left[half + 3][i];
        stem_lanes (*sum)[stem_all] = jet->sums;
        const int k = behind + i;
        if (n % 2 == 0) {
            sum[0][k] += PHI_HALF * (row * row);
            sum[1][k] += row * next;
            sum[2][k] += row * third + PHI_HALF * (next * next);
            sum[3][k] += next * third;
            if (n > 4) {
                sum[3][k] += row * jet->left[half + 4][i];
            }
        } else {
            sum[1][k] += PHI_HALF * (row * row);
            sum[2][k] += row * next;
            sum[3][k] += row * third + PHI_HALF * (next * next);
        }
        sum[0][k] += sum[0][k];
    }
}
#endif

/* What the sums `turn` orders after the start of a block still want of the rows that have come since, and the other half. */
static STEM_SINGLY void stem_square_rest(const int n, const int turn, stem_jets *PHI_RESTRICT jet)
{
    for (int i = 0; i < stem_squares; ++i) {
        stem_lanes sum = jet->sums[turn][stem_lefts * stem_rights + i];
        int j = turn - 1;
        sum += sum;
        do {
            sum += (jet->left[j][i] + jet->left[j][i]) * jet->left[n - j][i];
        } while (--j >= 0);
        jet->sums[turn][stem_lefts * stem_rights + i] = sum;
    }
}
#endif
#if WITH_DRY

/* Sums over 0 < j <= n of what makes up dry friction at order n + 1, behind the others: its steepness s_{n+1-j} with its
 * change d_j, and its saturation y_j with y_{n+1-j}. */
static void stem_dry_sums(const int n, const stem_jets *PHI_RESTRICT jet, stem_lanes *PHI_RESTRICT sums)
{
    for (int i = stem_lefts; i < stem_lefts + stem_dry; ++i) {
        stem_lanes slope = STEM_ZERO, square = STEM_ZERO;
        for (int j = 1; j <= n; ++j) {
            slope += jet->left[n + 1 - j][i + stem_dry] * jet->left[j][i + 2 * stem_dry];
            square += jet->left[n + 1 - j][i] * jet->left[j][i];
        }
        sums[i - stem_lefts] = slope;
        sums[i - stem_lefts + stem_dry] = square;
    }
}
#endif
#if WITH_RUBS

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
        const stem_lanes *place = start->left[0] + (stem_width - 5 * stem_rubs + 5 * i);
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
            const stem_lanes *near = jet->left[j + 1], *far = jet->left[n - j + 1];
            square += near[w] * far[w] + near[w + 1] * far[w + 1] + near[w + 2] * far[w + 2];
            x += near[t] * far[w];
            y += near[t] * far[w + 1];
            z += near[t] * far[w + 2];
        }
        jet->powers[n - 1][1][i] = jet->start->rubs[0][i] * jet->left[n][s];
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
#endif
