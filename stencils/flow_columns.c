/* Derivatives of the flow, as many columns at a time as a vector of them has. Along a derivative d the recurrences hold
 * with the same factors: sums of order n are those of d left_j right_{n-j} + left_j d right_{n-j}, and of what the first
 * factors start from, `lead`. */
static void wide_sums(const int n, const stem_jets *PHI_RESTRICT jet, const wide_jets *PHI_RESTRICT wide, wide_lanes *PHI_RESTRICT sums)
{
    for (int i = 0; i < stem_lefts; ++i) {
        for (int row = 0; row < stem_rights; ++row) {
            const int k = stem_lefts * row + i;
            wide_lanes sum = wide->lead[i] * jet->right[n + 1][k], other = WIDE_ZERO;
            for (int j = 0; j <= n; ++j) {
                sum += wide->left[j][i] * jet->right[n - j][k];
                other += wide->right[n - j][k] * jet->left[j][i];
            }
            sums[k] = sum + other;
        }
    }
#if WITH_SQUARES
    for (int i = 0; i < stem_squares; ++i) {
        wide_lanes sum = wide->lead[i] * jet->left[n + 1][i];
        for (int j = 0; j <= n; ++j) {
            sum += wide->left[j][i] * jet->left[n - j][i];
        }
        sums[stem_lefts * stem_rights + i] = sum + sum;
    }
#endif
}

/* The coefficients of the derivatives up to the given order, from wide->x[0] and the state's. */
static STEM_APART void wide_expand(CONTEXT const int order, const stem_jets *PHI_RESTRICT jet, wide_jets *PHI_RESTRICT wide)
{
    static const phi_real first[4] = {1, 1, PHI_HALF, 0};
    wide_lanes sums[stem_all];
    wide_rows(PASS ROWS_0 wide->lead, wide->left[0], wide->right[0]);
    for (int n = 0; n < order; ++n) {
        wide_sums(n, jet, wide, sums);
        wide_order(PASS jet->start.held, sums, NEWEST(wide->left[n]) wide->x[n], n > 0 ? stem_now[n] : first, wide->left[n + 1], wide->right[n + 1], wide->x[n + 1]);
    }
}

/* Time at which the last two terms of every column are within the goal, relative to the column; zero when a coefficient
 * is not finite. */
static phi_real wide_length(const int order, const stem_jets *jet, const wide_jets *wide, const phi_real goal, const phi_real scales[2])
{
    phi_real state[2][1], size[2][wide_lane_count], last[2][wide_lane_count], before[2][wide_lane_count];
    const phi_real unit = jet->start.unit[0];
    phi_real end = 0, next = 0, zero = 0;
    for (int i = 0; i < stem_x; ++i) {
        for (int lane = 0; lane < wide_lane_count; ++lane) {
            zero += 0 * WIDE_OF(wide->x[order][i], lane);
        }
    }
    if (!(zero >= 0 && zero <= 0)) {
        return 0;
    }
    stem_norms(scales[1], jet->state, state);
    phi_real pace = stem_larger(scales[0], state[1][0]);
    pace = unit * (pace > 0 ? pace : 1);
    wide_norms(scales[1], wide->x[0], size);
    wide_norms(scales[1], wide->x[order], last);
    wide_norms(scales[1], wide->x[order - 1], before);
    for (int lane = 0; lane < wide_lane_count; ++lane) {
        const phi_real allowed = goal * stem_larger(size[0][lane], size[1][lane] / pace);
        if (allowed > 0) {
            end = stem_larger(stem_larger(last[0][lane], last[1][lane] / pace) / allowed, end);
            next = stem_larger(stem_larger(before[0][lane], before[1][lane] / pace) / allowed, next);
        }
    }
    return stem_radius(order, unit, end, next);
}

/* Carry columns of derivatives over a step of length h or, where they ask for it, a shorter one, which is returned; zero
 * where they are not finite. */
static phi_real stem_carry(CONTEXT const int order, stem_jets *jet, const phi_real goal, const phi_real scales[2], phi_real h, const int count, phi_real *transition)
{
    wide_jets *wide = (wide_jets *)(void *)jet->columns;
    const phi_real unit = jet->start.unit[0];
    for (int first = 0; first < count;) {
        const int many = count - first < wide_lane_count ? count - first : wide_lane_count;
        for (int i = 0; i < stem_x; ++i) {
            const phi_real share = i < stem_q ? 1 : unit;
            for (int lane = 0; lane < wide_lane_count; ++lane) {
                WIDE_AT(wide->x[0][i], lane) = lane < many ? share * transition[count * i + first + lane] : 0;
            }
        }
        wide_expand(PASS order, jet, wide);
        const phi_real longest = wide_length(order, jet, wide, goal, scales);
        /* Later columns accept a little more, so that going back to the first ones is rare. */
        if (longest < phi_abs(h) * (first > 0 ? PHI_SLACK : 1)) {
            if (!(longest > 0)) {
                return 0;
            }
            h = h > 0 ? longest : -longest;
            if (first > 0) {
                first = 0;
                continue;
            }
        }
        const phi_real t = h / unit;
        phi_real zero = 0;
        for (int i = 0; i < stem_x; ++i) {
            wide_lanes sum = wide->x[order][i];
            for (int n = order - 1; n >= 0; --n) {
                sum = sum * t + wide->x[n][i];
            }
            for (int lane = 0; lane < many; ++lane) {
                const phi_real carried = (i < stem_q ? 1 : 1 / unit) * WIDE_OF(sum, lane);
                jet->carried[count * i + first + lane] = carried;
                zero += 0 * carried;
            }
        }
        if (!(zero >= 0 && zero <= 0)) {
            return 0;
        }
        first += wide_lane_count;
    }
    memcpy(transition, jet->carried, (size_t)count * stem_x * sizeof *transition);
    return h;
}
#if WITH_SPHERE

/* Derivatives of (q, v), row-major, become those of (q, q'), column by column. */
static void stem_enter_columns(const phi_real q[], const phi_real v[], const int count, phi_real *transition)
{
    for (int column = 0; column < count; ++column) {
        phi_real dq[stem_q], dv[stem_q], rate[stem_q];
        for (int i = 0; i < stem_q; ++i) {
            dq[i] = transition[count * i + column];
            dv[i] = transition[count * (stem_q + i) + column];
        }
        stem_enter_column(q, v, dq, dv, rate);
        for (int i = 0; i < stem_q; ++i) {
            transition[count * (stem_q + i) + column] = rate[i];
        }
    }
}

/* The way back. */
static void stem_leave_columns(const phi_real q[], const phi_real rate[], const int count, phi_real *transition)
{
    for (int column = 0; column < count; ++column) {
        phi_real dq[stem_q], d_rate[stem_q], seen[stem_x];
        for (int i = 0; i < stem_q; ++i) {
            dq[i] = transition[count * i + column];
            d_rate[i] = transition[count * (stem_q + i) + column];
        }
        stem_leave_column(q, rate, dq, d_rate, seen, seen + stem_q);
        for (int i = 0; i < stem_x; ++i) {
            transition[count * i + column] = seen[i];
        }
    }
}
#endif
