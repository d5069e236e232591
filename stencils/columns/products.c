/* Derivatives of sums. Along a derivative d the recurrences hold with the same factors: sums of order n are those of
 * d left_j right_{n-j} + left_j d right_{n-j}, and of what the first factors start from, `lead`. */
static void wide_sums(const int n, const stem_jets *PHI_RESTRICT jet, const wide_jets *PHI_RESTRICT wide, wide_lanes *PHI_RESTRICT sums)
{
    for (int row = 0; row < stem_rights; ++row) {
        for (int i = 0; i < stem_lefts; ++i) {
            const int k = stem_lefts * row + i;
            wide_lanes sum = wide->lead[i] * jet->right[n + 1][k], other = WIDE_ZERO;
            for (int j = 0; j <= n; ++j) {
                sum += wide->left[j][i] * jet->right[n - j][k];
                other += wide->right[j][k] * jet->left[n - j][i];
            }
            sums[k] = sum + other;
        }
    }
}

/* Orders come in blocks of four: what the sums of orders n to n + 3 can take from derivatives up to order n, which share
 * what they read: eight sums at a time that do not wait for each other. All factors are known already. */
static STEM_APART void wide_ahead(const int n, const stem_jets *PHI_RESTRICT jet, const wide_jets *PHI_RESTRICT wide, wide_lanes sums[PHI_RESTRICT 4][stem_all])
{
    for (int row = 0; row < stem_rights; ++row) {
        for (int i = 0; i < stem_lefts; ++i) {
            const int k = stem_lefts * row + i;
            const wide_lanes lead = wide->lead[i];
            wide_lanes right_1 = WIDE_EVERY(jet->right[n + 1][k]), left_1 = WIDE_EVERY(jet->left[n + 1][i]);
            wide_lanes right_2 = WIDE_EVERY(jet->right[n + 2][k]), left_2 = WIDE_EVERY(jet->left[n + 2][i]);
            wide_lanes right_3 = WIDE_EVERY(jet->right[n + 3][k]), left_3 = WIDE_EVERY(jet->left[n + 3][i]);
            wide_lanes first = lead * right_1, second = lead * right_2, third = lead * right_3, fourth = lead * jet->right[n + 4][k];
            wide_lanes first_too = WIDE_ZERO, second_too = first_too, third_too = first_too, fourth_too = first_too;
            for (int j = 0; j <= n; ++j) {
                const wide_lanes d_left = wide->left[j][i], right = WIDE_EVERY(jet->right[n - j][k]);
                const wide_lanes d_right = wide->right[j][k], left = WIDE_EVERY(jet->left[n - j][i]);
                first += d_left * right;
                second += d_left * right_1;
                third += d_left * right_2;
                fourth += d_left * right_3;
                first_too += d_right * left;
                second_too += d_right * left_1;
                third_too += d_right * left_2;
                fourth_too += d_right * left_3;
                right_3 = right_2;
                right_2 = right_1;
                right_1 = right;
                left_3 = left_2;
                left_2 = left_1;
                left_1 = left;
            }
            sums[0][k] = first + first_too;
            sums[1][k] = second + second_too;
            sums[2][k] = third + third_too;
            sums[3][k] = fourth + fourth_too;
        }
    }
}

/* What the sums of order n, `turn` orders after the start of a block, still want of the derivatives that have come since. */
static void wide_rest(const int n, const int turn, const stem_jets *PHI_RESTRICT jet, const wide_jets *PHI_RESTRICT wide, wide_lanes *PHI_RESTRICT sums)
{
    for (int row = 0; row < stem_rights; ++row) {
        for (int i = 0; i < stem_lefts; ++i) {
            const int k = stem_lefts * row + i;
            wide_lanes sum = sums[k];
            for (int j = 0; j < turn; ++j) {
                sum += wide->left[n - j][i] * jet->right[j][k];
                sum += wide->right[n - j][k] * jet->left[j][i];
            }
            sums[k] = sum;
        }
    }
}
#if WITH_SQUARES

/* Sums of order n of the squares, behind the others. */
static void wide_square_sums(const int n, const stem_jets *PHI_RESTRICT jet, const wide_jets *PHI_RESTRICT wide, wide_lanes *PHI_RESTRICT sums)
{
    for (int i = 0; i < stem_squares; ++i) {
        wide_lanes sum = wide->lead[i] * jet->left[n + 1][i];
        for (int j = 0; j <= n; ++j) {
            sum += wide->left[j][i] * jet->left[n - j][i];
        }
        sums[i] = sum + sum;
    }
}
#endif
