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
    for (int row = 0; row < stem_rights; ++row) {
        for (int i = 0; i < stem_lefts; ++i) {
            const int k = stem_lefts * row + i;
            stem_lanes sum = jet->sums[turn][k];
            int j = turn - 1;
            do {
                sum += jet->left[j][i] * jet->right[n - j][k] + jet->left[n - j][i] * jet->right[j][k];
            } while (--j >= 0);
            jet->sums[turn][k] = sum;
        }
    }
}
#if WITH_SQUARES

/* Sums of order n of left_j left_{n-j}, behind the others. */
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
        jet->powers[n - 1][1][i] = jet->start.rubs[0][i] * jet->left[n][s];
        for (int k = 2; k <= n; ++k) {
            stem_lanes power = STEM_ZERO;
            for (int j = 1; j <= n - k + 1; ++j) {
                power += jet->powers[j][1][i] * jet->powers[n - j][k - 1][i];
            }
            jet->powers[n][k][i] = power;
            beyond += jet->start.rubs[k][i] * power;
        }
        sums[0] = square;
        sums[1] = x;
        sums[2] = y;
        sums[3] = z;
        sums[4] = beyond;
        sums[5] = jet->start.rubs[1][i];
    }
}
#endif

/* Factor the mass matrix in the states x + lost, time in the given units, and solve for the coefficients of order 1. */
static void stem_begin(CONTEXT const stem_jets *jet, const stem_lanes x[stem_x], const stem_lanes lost[stem_x], const stem_lanes *unit, AFTER(const stem_lanes *after) stem_start *PHI_RESTRICT start)
{
    stem_lanes sums[stem_all], first[stem_x];
    start->unit[0] = *unit;
    start->unit[1] = *unit * *unit;
    for (int i = 0; i < stem_q; ++i) {
        first[i] = x[i];
        first[stem_q + i] = *unit * x[stem_q + i];
    }
#if WITH_FORCING
    stem_drive(jet, &jet->amplitude, after, start->drive);
#endif
    stem_factor(PASS first, first + stem_q, INPUTS FORCE(start->drive) start->unit, LOST start->held, FORCE(start->later) start->left[0], start->right[0]);
    for (int k = 0; k < stem_lefts * stem_rights; ++k) {
        sums[k] = start->left[0][k % stem_lefts] * start->right[0][k];
    }
#if WITH_SQUARES
    for (int i = 0; i < stem_squares; ++i) {
        sums[stem_lefts * stem_rights + i] = start->left[0][i] * start->left[0][i];
    }
#endif
#if WITH_DRY
    for (int k = stem_all - 2 * stem_dry; k < stem_all; ++k) {
        sums[k] = STEM_ZERO;
    }
#endif
#if WITH_RUBS
    stem_rub(start);
    for (int k = stem_all - 6 * stem_rubs; k < stem_all; ++k) {
        sums[k] = STEM_ZERO;
    }
    for (int i = 0; i < stem_rubs; ++i) {
        sums[stem_all - 6 * (stem_rubs - i) + 5] = start->rubs[1][i];
    }
#endif
#if WITH_FORCING
    /* What is constant in time, the forcing as it is now included. */
    const stem_lanes one = STEM_ZERO + 1;
#endif
    stem_order(PASS start->held, sums, NEWEST(start->left[0]) first, stem_now[0], FORCE(&one) start->left[1], start->right[1], start->slope);
#if !WITH_INPUTS
#if !WITH_FORCING
    (void)jet;
#endif
#endif
#if !WITH_LOST
    (void)lost;
#endif
}

/* The coefficients of the states up to the given order, from jet->start. */
static STEM_APART void stem_expand(CONTEXT const int order, stem_jets *PHI_RESTRICT jet)
{
    const int first = 4 + order % 4;
    memcpy(jet->left, jet->start.left, sizeof jet->start.left);
    memcpy(jet->right, jet->start.right, sizeof jet->start.right);
    memcpy(jet->x[1], jet->start.slope, sizeof jet->start.slope);
#if WITH_FORCING
    const stem_lanes pace = jet->omega * jet->start.unit[0];
    stem_lanes force = jet->start.drive[0], aside = jet->start.drive[1];
#endif
#if WITH_PARAMETERS
    /* Derivatives by parameters want the sums themselves, and what counts as constant in time. */
    for (int k = 0; k < stem_lefts * stem_rights; ++k) {
        jet->kept[0][k] = jet->left[0][k % stem_lefts] * jet->right[0][k];
    }
#if WITH_SQUARES
    for (int i = 0; i < stem_squares; ++i) {
        jet->kept[0][stem_lefts * stem_rights + i] = jet->left[0][i] * jet->left[0][i];
    }
#endif
#if WITH_RUBS
    memset(jet->kept[0] + (stem_all - 6 * stem_rubs), 0, (size_t)(6 * stem_rubs) * sizeof(phi_real));
    for (int i = 0; i < stem_rubs; ++i) {
        jet->kept[0][stem_all - 6 * (stem_rubs - i) + 5] = jet->start.rubs[1][i];
    }
#endif
#if WITH_FORCING
    jet->force[0] = 1;
#endif
#endif
    for (int n = 1; n < order; ++n) {
        const int turn = n < first ? 0 : (n - first) % 4;
        stem_lanes *sums = jet->sums[turn];
        if (n < first) {
            stem_sums(n, jet, sums);
        } else if (turn == 0) {
            stem_ahead(n, jet);
        } else {
            stem_rest(n, turn, jet);
        }
#if WITH_SQUARES
        stem_square_sums(n, jet, sums + (size_t)(stem_lefts * stem_rights));
#endif
#if WITH_DRY
        stem_dry_sums(n, jet, sums + (size_t)(stem_all - 2 * stem_dry));
#endif
#if WITH_RUBS
        stem_rub_sums(n, jet, sums + (size_t)(stem_all - 6 * stem_rubs));
#endif
#if WITH_FORCING
        /* The forcing's coefficient of order n, and that of the sine beside it. */
        const stem_lanes share = pace * stem_now[n - 1][1], turned = share * force;
        force = -(share * aside);
        aside = turned;
#if WITH_PARAMETERS
        jet->force[n] = force;
#endif
#endif
#if WITH_PARAMETERS
        memcpy(jet->kept[n], sums, sizeof jet->kept[n]);
#endif
        stem_order(PASS jet->start.BEHIND, sums, NEWEST(jet->left[n]) jet->x[n], stem_now[n], FORCE(&force) jet->left[n + 1], jet->right[n + 1], jet->x[n + 1]);
    }
}

/* How far the states move in times h: x_1 t + x_2 t^2 + ... by Horner's rule, t = h / unit. */
static void stem_increment(const int order, const stem_jets *PHI_RESTRICT jet, const stem_lanes *h, stem_lanes increment[PHI_RESTRICT stem_x])
{
    const stem_lanes t = *h / jet->start.unit[0], share = t / jet->start.unit[0];
    for (int i = 0; i < stem_x; ++i) {
        stem_lanes sum = jet->x[order][i];
        for (int n = order - 1; n > 0; --n) {
            sum = sum * t + jet->x[n][i];
        }
        increment[i] = sum * (i < stem_q ? t : share);
    }
}

/* The same, and h times the slope of the series in the units of its coefficients: even and odd powers apart, so that no sum
 * waits for the one before. Order 1, the most of it, is added last and rounded once. */
static void stem_advance(const int order, const stem_jets *PHI_RESTRICT jet, const stem_lanes *h, stem_lanes increment[PHI_RESTRICT stem_x], stem_lanes along[PHI_RESTRICT stem_x])
{
    const stem_lanes t = *h / jet->start.unit[0], share = t / jet->start.unit[0], square = t * t;
    for (int i = 0; i < stem_x; ++i) {
        stem_lanes sum = jet->x[order][i], next = jet->x[order - 1][i];
        stem_lanes slope = (phi_real)order * sum, next_slope = (phi_real)(order - 1) * next;
        int n = order - 2;
        for (; n > 2; n -= 2) {
            sum = sum * square + jet->x[n][i];
            next = next * square + jet->x[n - 1][i];
            slope = slope * square + (phi_real)n * jet->x[n][i];
            next_slope = next_slope * square + (phi_real)(n - 1) * jet->x[n - 1][i];
        }
        if (n == 2) {
            sum = (sum * square + jet->x[2][i]) + next * t;
            slope = (slope * square + 2 * jet->x[2][i]) + next_slope * t;
        } else {
            sum = sum * t + next;
            slope = slope * t + next_slope;
        }
        sum = sum * t + jet->x[1][i];
        slope = slope * t + jet->x[1][i];
        increment[i] = sum * (i < stem_q ? t : share);
        along[i] = slope * t;
    }
}

/* Where the states come from there, and what rounding takes from that. */
static void stem_move(const stem_lanes increment[stem_x], stem_jets *PHI_RESTRICT jet)
{
    for (int i = 0; i < stem_x; ++i) {
        const stem_lanes whole = increment[i] + jet->lost[i], before = jet->state[i], after = before + whole;
        jet->moved_lost[i] = (before - (after - (after - before))) + (whole - (after - before));
        jet->moved[i] = after;
    }
#if WITH_SPHERE
    {
        stem_lanes settled[stem_x];
        stem_settle(jet->moved, jet->moved_lost, settled);
        memcpy(jet->moved_lost, settled, sizeof settled);
    }
#endif
}

/* One entry of a lane's state at a time h into its step, whole turns added. */
static phi_real stem_entry(const int order, const stem_jets *jet, const int lane, const phi_real h, const int i)
{
    const phi_real unit = STEM_OF(jet->start.unit[0], lane), t = h / unit;
    phi_real sum = STEM_OF(jet->x[order][i], lane);
    for (int n = order - 1; n > 0; --n) {
        sum = sum * t + STEM_OF(jet->x[n][i], lane);
    }
    sum = STEM_OF(jet->state[i], lane) + (sum * (i < stem_q ? t : t / unit) + STEM_OF(jet->lost[i], lane));
#if WITH_TURNS
    return i < stem_cart || i >= stem_q ? sum : stem_turned(sum, STEM_OF(jet->turns[i], lane));
#else
    return sum;
#endif
}

/* The whole of it, as the caller sees it. */
static void stem_look(const int order, const stem_jets *jet, const int lane, const phi_real h, phi_real x[stem_x])
{
#if WITH_SPHERE
    phi_real inside[stem_x];
    for (int i = 0; i < stem_x; ++i) {
        inside[i] = stem_entry(order, jet, lane, h, i);
    }
    stem_leave(inside, inside + stem_q, x, x + stem_q);
#else
    for (int i = 0; i < stem_x; ++i) {
        x[i] = stem_entry(order, jet, lane, h, i);
    }
#endif
}
