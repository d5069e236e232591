/* Trajectories side by side in space: a link's multiplier stands three times in the first right row, for its three lanes, and is
 * read once for all of them; what a vector holds is a number of every trajectory, so that lanes are not side by side. */

/* What the sums of the first right row at orders n to n + 3 can take from rows up to n. For n > 3. */
static void stem_ahead_triples(const int n, stem_jets *PHI_RESTRICT jet)
{
    for (int k = 0; k < stem_lefts; k += 3) {
        stem_lanes far = jet->right[n - 1][k], middle = jet->right[n - 2][k], near = jet->right[n - 3][k];
        stem_lanes first[3], second[3], third[3], fourth[3];
        for (int i = 0; i < 3; ++i) {
            first[i] = jet->left[1][k + i] * far + jet->left[2][k + i] * middle + jet->left[3][k + i] * near;
            second[i] = jet->left[2][k + i] * far + jet->left[3][k + i] * middle;
            third[i] = jet->left[3][k + i] * far;
            fourth[i] = STEM_ZERO;
        }
        int j = 4;
        do {
            const stem_lanes right = jet->right[n - j][k];
            for (int i = 0; i < 3; ++i) {
                const stem_lanes left = jet->left[j][k + i];
                first[i] += left * right;
                second[i] += left * near;
                third[i] += left * middle;
                fourth[i] += left * far;
            }
            far = middle;
            middle = near;
            near = right;
        } while (++j <= n);
        far = jet->right[n][k];
        for (int i = 0; i < 3; ++i) {
            jet->sums[0][k + i] = first[i] + jet->left[0][k + i] * far;
            jet->sums[1][k + i] = second[i] + jet->left[1][k + i] * far;
            jet->sums[2][k + i] = third[i] + jet->left[2][k + i] * far;
            jet->sums[3][k + i] = fourth[i] + jet->left[3][k + i] * far;
        }
    }
}

/* What they still want of the rows that have come since, `turn` orders after the start of a block; the newest last. */
static void stem_rest_triples(const int n, const int turn, stem_jets *PHI_RESTRICT jet)
{
    for (int k = 0; k < stem_lefts; k += 3) {
        stem_lanes x = jet->sums[turn][k], y = jet->sums[turn][k + 1], z = jet->sums[turn][k + 2];
        int j = turn - 1;
        do {
            const stem_lanes near = jet->right[j][k], far = jet->right[n - j][k];
            x += jet->left[n - j][k] * near;
            y += jet->left[n - j][k + 1] * near;
            z += jet->left[n - j][k + 2] * near;
            x += jet->left[j][k] * far;
            y += jet->left[j][k + 1] * far;
            z += jet->left[j][k + 2] * far;
        } while (--j >= 0);
        jet->sums[turn][k] = x;
        jet->sums[turn][k + 1] = y;
        jet->sums[turn][k + 2] = z;
    }
}

/* What the sums of squares of orders n to n + 3 can take from rows up to n, every pair once; order n is whole then. For n > 3. */
static void stem_square_ahead(const int n, stem_jets *PHI_RESTRICT jet)
{
    enum { behind = stem_lefts * stem_rights, width = (int)(sizeof jet->left[0] / sizeof jet->left[0][0]) };
    const int half = (n - 1) / 2;
    for (int i = 0; i < stem_squares; ++i) {
        stem_lanes near = jet->left[n][i], middle = STEM_ZERO, far = middle;
        stem_lanes first = jet->left[0][i] * near, second = middle, third = middle, fourth = middle;
        stem_lanes (*low)[width] = &jet->left[1], (*high)[width] = &jet->left[n - 1];
        int pairs = half;
        do {
            const stem_lanes row = (*low)[i], other = (*high)[i];
            first += row * other;
            second += row * near;
            third += row * middle;
            fourth += row * far;
            far = middle;
            middle = near;
            near = other;
            ++low;
            --high;
        } while (--pairs > 0);
        if (n % 2 == 0) {
            /* The row in the middle meets itself. */
            const stem_lanes row = (*low)[i];
            first += PHI_HALF * (row * row);
            second += row * near;
            third += row * middle + PHI_HALF * (near * near);
            fourth += row * far + near * middle;
        } else {
            second += PHI_HALF * (near * near);
            third += near * middle;
            fourth += near * far + PHI_HALF * (middle * middle);
        }
        jet->sums[0][behind + i] = first + first;
        jet->sums[1][behind + i] = second;
        jet->sums[2][behind + i] = third;
        jet->sums[3][behind + i] = fourth;
    }
}
