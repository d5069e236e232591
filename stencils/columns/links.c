/* Derivatives of the sums of a planar chain. With C, S cosine and sine of a link's angle psi from where it stood at the step's
 * start, w its rate, and P, Q the last two rows of right, which begin with zero, dC = -S dpsi and dS = C dpsi give
 *
 *     d sum_{j=0..n} C_{j+1} w_{n-j} = (n + 2) sum_{j=0..n+1} C_{j+1} dpsi_{n+1-j},   the same with S for C,
 *     d sum_{j=0..n} (C_{j+1} P_{n-j} + S_{j+1} Q_{n-j}) = sum_{j=0..n+1} K_{n+1-j} dpsi_j + sum_{j=0..n} (C_{j+1} dP_{n-j} + S_{j+1} dQ_{n-j}),
 *
 * K = C Q - S P: five products a link instead of eight, the coefficients of K the same for all columns. The last two sums
 * are only ever wanted together. */

/* Numbers side by side as a vector, wherever they begin. */
static wide_lanes wide_load(const phi_real *numbers)
{
    return *(const wide_lanes *)(const void *)numbers;
}

/* What all columns take from a motion: C and S from order 1 on, and K, link by link. */
static STEM_APART void wide_share(const int order, stem_jets *PHI_RESTRICT jet)
{
    enum { behind = wide_room + wide_lane_count };
    for (int k = 0; k < wide_links; ++k) {
        phi_real *cosine = jet->shared[0][k], *sine = jet->shared[1][k];
        phi_real p[behind] = {0}, q[behind] = {0};
        for (int n = 0; n <= order; ++n) {
            cosine[n] = jet->left[n][k];
            sine[n] = jet->left[n][k + wide_links];
            p[wide_lane_count + n] = jet->right[n][k + 2 * wide_links];
            q[wide_lane_count + n] = jet->right[n][k + 3 * wide_links];
        }
        for (int n = order + 1; n < wide_room; ++n) {
            cosine[n] = sine[n] = 0;
        }
        for (int first = 0; first <= order; first += wide_lane_count) {
            const int end = first + wide_lane_count;
            wide_lanes sum = wide_load(q + end), other = WIDE_ZERO;
            for (int j = 0; j < end - 1; ++j) {
                sum += cosine[j] * wide_load(q + end - 1 - j);
                other += sine[j] * wide_load(p + end - 1 - j);
            }
            *(wide_lanes *)(void *)(jet->shared[2][k] + first) = sum - other;
        }
    }
}

/* The rows that come out of order n - 1, where sums look for them. */
static void wide_keep(const int n, wide_jets *PHI_RESTRICT wide)
{
    for (int k = 0; k < wide_links; ++k) {
        wide->turn[k][n + 1] = stem_now[n][1] * wide->right[0][k];
        wide->arms[0][k][n] = wide->right[0][k + 2 * wide_links];
        wide->arms[1][k][n] = wide->right[0][k + 3 * wide_links];
    }
}

/* What sums of order n take from the angles at the step's start alone. */
static void wide_sums(const int n, const stem_jets *PHI_RESTRICT jet, const wide_jets *PHI_RESTRICT wide, wide_lanes *PHI_RESTRICT sums)
{
    for (int k = 0; k < wide_links; ++k) {
        const wide_lanes turn = wide->turn[k][0];
        sums[k] = turn * jet->shared[0][k][n + 1];
        sums[k + wide_links] = turn * jet->shared[1][k][n + 1];
        sums[k + 2 * wide_links] = turn * jet->shared[2][k][n + 1];
        sums[k + 3 * wide_links] = WIDE_ZERO;
    }
}

/* Two products, each at four orders in turn: sums over 0 <= i < count of d_i a_{count-1+turn-i}, which share what they read:
 * eight that do not wait for each other, four terms at a time so that nothing read is moved. */
static void wide_pair(const int count, const wide_lanes *d, const phi_real *a, const wide_lanes *e, const phi_real *b, wide_lanes sums[PHI_RESTRICT 4], wide_lanes more[PHI_RESTRICT 4])
{
    wide_lanes a_1 = WIDE_EVERY(a[count]), a_2 = WIDE_EVERY(a[count + 1]), a_3 = WIDE_EVERY(a[count + 2]);
    wide_lanes b_1 = WIDE_EVERY(b[count]), b_2 = WIDE_EVERY(b[count + 1]), b_3 = WIDE_EVERY(b[count + 2]);
    wide_lanes first = WIDE_ZERO, second = first, third = first, fourth = first;
    wide_lanes first_too = first, second_too = first, third_too = first, fourth_too = first;
    int i = 0;
    for (; i < count % 4; ++i) {
        const wide_lanes a_0 = WIDE_EVERY(a[count - 1 - i]), b_0 = WIDE_EVERY(b[count - 1 - i]);
        first += d[i] * a_0;
        second += d[i] * a_1;
        third += d[i] * a_2;
        fourth += d[i] * a_3;
        first_too += e[i] * b_0;
        second_too += e[i] * b_1;
        third_too += e[i] * b_2;
        fourth_too += e[i] * b_3;
        a_3 = a_2;
        a_2 = a_1;
        a_1 = a_0;
        b_3 = b_2;
        b_2 = b_1;
        b_1 = b_0;
    }
    for (; i < count; i += 4) {
        const phi_real *near = a + (count - 4 - i), *close = b + (count - 4 - i);
        const wide_lanes a_0 = WIDE_EVERY(near[3]), b_0 = WIDE_EVERY(close[3]);
        first += d[i] * a_0;
        second += d[i] * a_1;
        third += d[i] * a_2;
        fourth += d[i] * a_3;
        first_too += e[i] * b_0;
        second_too += e[i] * b_1;
        third_too += e[i] * b_2;
        fourth_too += e[i] * b_3;
        a_3 = WIDE_EVERY(near[2]);
        b_3 = WIDE_EVERY(close[2]);
        first += d[i + 1] * a_3;
        second += d[i + 1] * a_0;
        third += d[i + 1] * a_1;
        fourth += d[i + 1] * a_2;
        first_too += e[i + 1] * b_3;
        second_too += e[i + 1] * b_0;
        third_too += e[i + 1] * b_1;
        fourth_too += e[i + 1] * b_2;
        a_2 = WIDE_EVERY(near[1]);
        b_2 = WIDE_EVERY(close[1]);
        first += d[i + 2] * a_2;
        second += d[i + 2] * a_3;
        third += d[i + 2] * a_0;
        fourth += d[i + 2] * a_1;
        first_too += e[i + 2] * b_2;
        second_too += e[i + 2] * b_3;
        third_too += e[i + 2] * b_0;
        fourth_too += e[i + 2] * b_1;
        a_1 = WIDE_EVERY(near[0]);
        b_1 = WIDE_EVERY(close[0]);
        first += d[i + 3] * a_1;
        second += d[i + 3] * a_2;
        third += d[i + 3] * a_3;
        fourth += d[i + 3] * a_0;
        first_too += e[i + 3] * b_1;
        second_too += e[i + 3] * b_2;
        third_too += e[i + 3] * b_3;
        fourth_too += e[i + 3] * b_0;
    }
    sums[0] = first;
    sums[1] = second;
    sums[2] = third;
    sums[3] = fourth;
    more[0] = first_too;
    more[1] = second_too;
    more[2] = third_too;
    more[3] = fourth_too;
}

/* Orders come in blocks of four: what the sums of orders n to n + 3 take from derivatives before the newest, so that none of this
 * waits for it. All that columns share is known already. */
static STEM_APART void wide_ahead(const int n, const stem_jets *PHI_RESTRICT jet, const wide_jets *PHI_RESTRICT wide, wide_lanes sums[PHI_RESTRICT 4][stem_all])
{
    const int count = n + 2, half = count / 2;
    for (int k = 0; k < wide_links; ++k) {
        const phi_real *cosine = jet->shared[0][k], *sine = jet->shared[1][k], *lever = jet->shared[2][k];
        const wide_lanes *turn = wide->turn[k];
        wide_lanes of_cosine[4], of_sine[4], far[4], near[4], arm[4], arm_too[4];
        wide_pair(count, turn, cosine, turn, sine, of_cosine, of_sine);
        /* One product, its two halves side by side. */
        wide_pair(half, turn, lever + count - half, turn + half, lever + count - 2 * half, far, near);
        wide_pair(n + 1, wide->arms[0][k], cosine, wide->arms[1][k], sine, arm, arm_too);
        for (int next = 0; next < 4; ++next) {
            wide_lanes moment = (far[next] + near[next]) + (arm[next] + arm_too[next]);
            if (count > 2 * half) {
                moment += turn[count - 1] * lever[next];
            }
            sums[next][k] = of_cosine[next];
            sums[next][k + wide_links] = of_sine[next];
            sums[next][k + 2 * wide_links] = moment;
            sums[next][k + 3 * wide_links] = WIDE_ZERO;
        }
    }
}

/* What the sums of order n, `turn` orders after the start of a block, want of the newest derivatives, too; the newest of all last,
 * for which everything else waits. */
static void wide_rest(const int n, const int turn, const stem_jets *PHI_RESTRICT jet, const wide_jets *PHI_RESTRICT wide, wide_lanes *PHI_RESTRICT sums)
{
    const phi_real weight = (phi_real)(n + 2);
    for (int k = 0; k < wide_links; ++k) {
        const phi_real *cosine = jet->shared[0][k], *sine = jet->shared[1][k], *lever = jet->shared[2][k];
        const wide_lanes *newest = wide->turn[k] + n + 1, *along = wide->arms[0][k] + n, *across = wide->arms[1][k] + n;
        wide_lanes of_cosine = sums[k], of_sine = sums[k + wide_links], moment = sums[k + 2 * wide_links], arm = WIDE_ZERO;
        for (int j = turn - 1; j >= 0; --j) {
            of_cosine += newest[-j] * cosine[j];
            of_sine += newest[-j] * sine[j];
            moment += newest[-j] * lever[j];
            moment += along[-j] * cosine[j];
            arm += across[-j] * sine[j];
        }
        sums[k] = weight * of_cosine;
        sums[k + wide_links] = weight * of_sine;
        sums[k + 2 * wide_links] = moment + arm;
    }
}
