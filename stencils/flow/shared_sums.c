/* Trajectories side by side in space. A vector holds a number of every trajectory, and what is kept is no more than the fastest
 * memory takes: left row j is row j + 1 of the configuration, a link's multiplier serves its three lanes, its squares are one sum. */

/* Sums of order n over 0 <= j <= n of left_j right_{n-j} and of left_j left_{n-j}, where orders come one by one. */
static void stem_sums(const int n, const stem_jets *PHI_RESTRICT jet, stem_lanes *PHI_RESTRICT sums)
{
    for (int k = 0; k < stem_masses; ++k) {
        stem_lanes x = STEM_ZERO, y = x, z = x, square = x;
        for (int j = 0; j <= n; ++j) {
            const stem_lanes *left = STEM_LEFT(j) + 3 * k, *other = STEM_LEFT(n - j) + 3 * k, right = jet->right[n - j][k];
            x += left[0] * right;
            y += left[1] * right;
            z += left[2] * right;
            square += left[0] * other[0] + left[1] * other[1] + left[2] * other[2];
        }
        sums[3 * k] = x;
        sums[3 * k + 1] = y;
        sums[3 * k + 2] = z;
        sums[stem_lefts * stem_rights + k] = square;
    }
#if WITH_CROSSED
    for (int i = stem_lefts; i < stem_lefts * stem_rights; ++i) {
        stem_lanes sum = STEM_ZERO;
        for (int j = 0; j <= n; ++j) {
            sum += STEM_LEFT(j)[i % stem_lefts] * jet->right[n - j][i - stem_lefts + stem_masses];
        }
        sums[i] = sum;
    }
#endif
}

/* Orders come in blocks of four: what the products of orders n to n + 3 can take from rows up to n, four sums at a time, which share
 * what they read. For n > 3. */
static void stem_ahead(const int n, stem_jets *PHI_RESTRICT jet)
{
    for (int k = 0; k < stem_masses; ++k) {
        stem_lanes far = jet->right[n - 1][k], middle = jet->right[n - 2][k], near = jet->right[n - 3][k];
        stem_lanes first[3], second[3], third[3], fourth[3];
        for (int i = 0; i < 3; ++i) {
            const stem_lanes one = STEM_LEFT(1)[3 * k + i], two = STEM_LEFT(2)[3 * k + i], three = STEM_LEFT(3)[3 * k + i];
            first[i] = one * far + two * middle + three * near;
            second[i] = two * far + three * middle;
            third[i] = three * far;
            fourth[i] = STEM_ZERO;
        }
        int j = 4;
        do {
            const stem_lanes right = jet->right[n - j][k];
            for (int i = 0; i < 3; ++i) {
                const stem_lanes left = STEM_LEFT(j)[3 * k + i];
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
            jet->sums[0][3 * k + i] = first[i] + STEM_LEFT(0)[3 * k + i] * far;
            jet->sums[1][3 * k + i] = second[i] + STEM_LEFT(1)[3 * k + i] * far;
            jet->sums[2][3 * k + i] = third[i] + STEM_LEFT(2)[3 * k + i] * far;
            jet->sums[3][3 * k + i] = fourth[i] + STEM_LEFT(3)[3 * k + i] * far;
        }
    }
#if WITH_CROSSED
    for (int i = stem_lefts; i < stem_lefts * stem_rights; ++i) {
        const int at = i % stem_lefts, k = i - stem_lefts + stem_masses;
        stem_lanes far = jet->right[n - 1][k], middle = jet->right[n - 2][k], near = jet->right[n - 3][k];
        stem_lanes first = STEM_LEFT(1)[at] * far + STEM_LEFT(2)[at] * middle + STEM_LEFT(3)[at] * near;
        stem_lanes second = STEM_LEFT(2)[at] * far + STEM_LEFT(3)[at] * middle;
        stem_lanes third = STEM_LEFT(3)[at] * far, fourth = STEM_ZERO;
        int j = 4;
        do {
            const stem_lanes left = STEM_LEFT(j)[at], right = jet->right[n - j][k];
            first += left * right;
            second += left * near;
            third += left * middle;
            fourth += left * far;
            far = middle;
            middle = near;
            near = right;
        } while (++j <= n);
        far = jet->right[n][k];
        jet->sums[0][i] = first + STEM_LEFT(0)[at] * far;
        jet->sums[1][i] = second + STEM_LEFT(1)[at] * far;
        jet->sums[2][i] = third + STEM_LEFT(2)[at] * far;
        jet->sums[3][i] = fourth + STEM_LEFT(3)[at] * far;
    }
#endif
}

/* What the squares of orders n to n + 3 can take from rows up to n, half of it, every pair once. For n > 3. */
static void stem_square_ahead(const int n, stem_jets *PHI_RESTRICT jet)
{
    for (int k = 0; k < stem_masses; ++k) {
        stem_lanes far[3], middle[3], near[3], first[3], second[3], third[3], fourth[3];
        for (int i = 0; i < 3; ++i) {
            near[i] = STEM_LEFT(n)[3 * k + i];
            middle[i] = far[i] = second[i] = third[i] = fourth[i] = STEM_ZERO;
            first[i] = STEM_LEFT(0)[3 * k + i] * near[i];
        }
        int j = 1;
        do {
            for (int i = 0; i < 3; ++i) {
                const stem_lanes row = STEM_LEFT(j)[3 * k + i], other = STEM_LEFT(n - j)[3 * k + i];
                first[i] += row * other;
                second[i] += row * near[i];
                third[i] += row * middle[i];
                fourth[i] += row * far[i];
                far[i] = middle[i];
                middle[i] = near[i];
                near[i] = other;
            }
        } while (2 * ++j < n);
        for (int i = 0; i < 3; ++i) {
            /* The row in the middle meets itself. */
            const stem_lanes row = STEM_LEFT(j)[3 * k + i];
            if (n % 2 == 0) {
                first[i] += PHI_HALF * (row * row);
                second[i] += row * near[i];
                third[i] += row * middle[i] + PHI_HALF * (near[i] * near[i]);
                fourth[i] += row * far[i] + near[i] * middle[i];
            } else {
                second[i] += PHI_HALF * (near[i] * near[i]);
                third[i] += near[i] * middle[i];
                fourth[i] += near[i] * far[i] + PHI_HALF * (middle[i] * middle[i]);
            }
        }
        const int at = stem_lefts * stem_rights + k;
        jet->sums[0][at] = 2 * (first[0] + first[1] + first[2]);
        jet->sums[1][at] = second[0] + second[1] + second[2];
        jet->sums[2][at] = third[0] + third[1] + third[2];
        jet->sums[3][at] = fourth[0] + fourth[1] + fourth[2];
    }
}

/* What the sums `turn` orders after the start of a block still want of the rows that have come since; the newest last, for which
 * everything else waits. */
static void stem_rest(const int n, const int turn, stem_jets *PHI_RESTRICT jet)
{
    stem_lanes *sums = jet->sums[turn];
    for (int k = 0; k < stem_masses; ++k) {
        stem_lanes x = sums[3 * k], y = sums[3 * k + 1], z = sums[3 * k + 2];
        stem_lanes along_x = sums[stem_lefts * stem_rights + k], along_y = STEM_ZERO, along_z = STEM_ZERO;
        int j = turn - 1;
        do {
            const stem_lanes *old = STEM_LEFT(j) + 3 * k, *newer = STEM_LEFT(n - j) + 3 * k;
            const stem_lanes near = jet->right[j][k], far = jet->right[n - j][k];
            x += newer[0] * near;
            y += newer[1] * near;
            z += newer[2] * near;
            along_x += old[0] * newer[0];
            along_y += old[1] * newer[1];
            along_z += old[2] * newer[2];
            x += old[0] * far;
            y += old[1] * far;
            z += old[2] * far;
        } while (--j >= 0);
        sums[3 * k] = x;
        sums[3 * k + 1] = y;
        sums[3 * k + 2] = z;
        sums[stem_lefts * stem_rights + k] = 2 * (along_x + along_y + along_z);
    }
#if WITH_CROSSED
    for (int i = stem_lefts; i < stem_lefts * stem_rights; ++i) {
        const int at = i % stem_lefts, k = i - stem_lefts + stem_masses;
        stem_lanes sum = sums[i];
        int j = turn - 1;
        do {
            sum += STEM_LEFT(j)[at] * jet->right[n - j][k];
            sum += STEM_LEFT(n - j)[at] * jet->right[j][k];
        } while (--j >= 0);
        sums[i] = sum;
    }
#endif
}
