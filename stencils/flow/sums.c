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
    for (int row = 0; row < stem_rights; ++row) {
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
#if WITH_ANGLES
    /* Cosines begin with zero, and so do moments of force: of the newest rows not all products are any. */
    enum { half = stem_lefts / 2, whole = stem_lefts };
    for (int i = 0; i < half; ++i) {
        stem_lanes turned = jet->sums[turn][i], across = jet->sums[turn][whole + i];
        for (int j = turn - 1; j > 0; --j) {
            turned += jet->left[j][i] * jet->right[n - j][i];
            across += jet->left[j][i] * jet->right[n - j][whole + i];
            turned += jet->left[n - j][i] * jet->right[j][i];
            across += jet->left[n - j][i] * jet->right[j][whole + i];
        }
        jet->sums[turn][i] = turned + jet->left[n][i] * jet->right[0][i];
        jet->sums[turn][whole + i] = across;
    }
    for (int i = half; i < whole; ++i) {
        stem_lanes turned = jet->sums[turn][i], along = jet->sums[turn][whole + i];
        for (int j = turn - 1; j > 0; --j) {
            turned += jet->left[j][i] * jet->right[n - j][i];
            along += jet->left[j][i] * jet->right[n - j][whole + i];
            turned += jet->left[n - j][i] * jet->right[j][i];
            along += jet->left[n - j][i] * jet->right[j][whole + i];
        }
        turned += jet->left[n][i] * jet->right[0][i];
        jet->sums[turn][i] = turned + jet->left[0][i] * jet->right[n][i];
        jet->sums[turn][whole + i] = along + jet->left[0][i] * jet->right[n][whole + i];
    }
#else
    for (int row = 0; row < stem_rights; ++row) {
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
#endif
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
