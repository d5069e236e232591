/* Derivatives of the flow, as many columns at a time as a vector of them has. */
#if WITH_DRY

/* Sums of order n of what makes up dry friction, behind the others. */
static void wide_dry_sums(const int n, const stem_jets *PHI_RESTRICT jet, const wide_jets *PHI_RESTRICT wide, wide_lanes *PHI_RESTRICT sums)
{
    for (int i = stem_lefts; i < stem_lefts + stem_dry; ++i) {
        wide_lanes slope = WIDE_ZERO, square = WIDE_ZERO;
        for (int j = 0; j <= n; ++j) {
            slope += wide->left[j][i + stem_dry] * jet->left[n + 1 - j][i + 2 * stem_dry];
            slope += wide->left[j][i + 2 * stem_dry] * jet->left[n + 1 - j][i + stem_dry];
            square += wide->left[j][i] * jet->left[n + 1 - j][i];
        }
        sums[i - stem_lefts] = slope;
        sums[i - stem_lefts + stem_dry] = square + square;
    }
}
#endif
#if WITH_RUBS

/* The coefficient n > 0 of the slope of T(s), by powers of s - s_0. */
static phi_real stem_bend(const int n, const int i, const stem_jets *jet)
{
    const phi_real over = jet->start->rubs[0][i];
    phi_real sum = 2 * jet->start->rubs[2][i] * (over * jet->left[n + 1][stem_width - 5 * stem_rubs + 5 * i + 3]);
    for (int k = 2; k <= n; ++k) {
        sum += (phi_real)(k + 1) * jet->start->rubs[k + 1][i] * jet->powers[n][k][i];
    }
    return over * sum;
}

/* Sums of order n of what makes up dry friction, behind the others: f_1 itself stands for its own, of which the rest takes
 * care, where the order is linear in them. */
static void wide_rub_sums(const int n, const phi_real kept, const stem_jets *PHI_RESTRICT jet, const wide_jets *PHI_RESTRICT wide, wide_lanes *PHI_RESTRICT sums)
{
    for (int i = 0; i < stem_rubs; ++i, sums += 6) {
        const int w = stem_width - 5 * stem_rubs + 5 * i, s = w + 3, t = w + 4;
        wide_lanes square = WIDE_ZERO, x = WIDE_ZERO, y = WIDE_ZERO, z = WIDE_ZERO, beyond = WIDE_ZERO;
        for (int j = 0; j < n; ++j) {
            const wide_lanes *moved = wide->left[j + 1];
            const phi_real *own = jet->left[n - j + 1];
            square += moved[w] * own[w] + moved[w + 1] * own[w + 1] + moved[w + 2] * own[w + 2];
            x += moved[w] * own[t] + moved[t] * own[w];
            y += moved[w + 1] * own[t] + moved[t] * own[w + 1];
            z += moved[w + 2] * own[t] + moved[t] * own[w + 2];
            beyond += moved[s] * stem_bend(n - j, i, jet);
        }
        sums[0] = square + square;
        sums[1] = x;
        sums[2] = y;
        sums[3] = z;
        sums[4] = beyond;
        sums[5] = WIDE_EVERY(kept * jet->start->rubs[1][i]);
    }
}
#endif
