/* The coefficients of the derivatives up to the given order, from wide->x[0] and the state's. */
static STEM_APART void wide_expand(CONTEXT const int order, VARIES(const int varies) const stem_jets *PHI_RESTRICT jet, wide_jets *PHI_RESTRICT wide)
{
    static const phi_real first[4] = {1, 1, PHI_HALF, 0};
    wide_lanes block[4][stem_all];
#if WITH_PARAMETERS
    phi_real at[stem_x];
    for (int i = 0; i < stem_x; ++i) {
        at[i] = i < stem_q ? jet->state[i] : jet->start->unit[0] * jet->state[i];
    }
#endif
    wide_rows(PASS ROWS_0 wide->lead, wide->left[0], wide->right[0]);
#if WITH_LINKS
    for (int k = 0; k < wide_links; ++k) {
        wide->turn[k][0] = wide->lead[k + wide_links];
    }
#endif
    for (int n = 0; n < order; ++n) {
        wide_lanes *left = wide->left[(n + 1) % wide_left_rows], *right = wide->right[(n + 1) % wide_right_rows];
        const int turn = n < order % 4 ? 0 : (n - order % 4) % 4;
        wide_lanes *sums = block[turn];
#if WITH_LINKS
        wide_keep(n, wide);
#endif
#if WITH_LINKS
        if (n < order % 4) {
            wide_sums(n, jet, wide, sums);
        } else if (turn == 0) {
            wide_ahead(n, jet, wide, block);
        }
        wide_rest(n, n < order % 4 ? n + 1 : turn, jet, wide, sums);
#else
        if (n < order % 4) {
            wide_sums(n, jet, wide, sums);
        } else if (turn == 0) {
            wide_ahead(n, jet, wide, block);
        } else {
            wide_rest(n, turn, jet, wide, sums);
        }
#endif
#if WITH_SQUARES
        wide_square_sums(n, jet, wide, sums + stem_lefts * stem_rights);
#endif
#if WITH_DRY
        wide_dry_sums(n, jet, wide, sums + stem_all - 2 * stem_dry);
#endif
#if WITH_RUBS
#if WITH_PARAMETERS
        wide_rub_sums(n, varies ? 0 : 1, jet, wide, sums + stem_all - 6 * stem_rubs);
#else
        wide_rub_sums(n, 1, jet, wide, sums + stem_all - 6 * stem_rubs);
#endif
#endif
#if WITH_PARAMETERS
        if (varies) {
#if WITH_FORCING
            const phi_real *constants = n > 0 ? jet->start->later : jet->start->held;
            const wide_lanes *d_constants = n > 0 ? wide->later : wide->held, none = WIDE_ZERO;
#else
            const phi_real *constants = jet->start->held;
            const wide_lanes *d_constants = wide->held;
#endif
            wide_order_along(PASS constants, jet->kept[n], NEWEST(jet->left[n]) n > 0 ? jet->x[n] : at, stem_now[n], FORCE(jet->force + n) d_constants, sums, NEWEST(wide->left[n % wide_left_rows]) wide->x[n], FORCE(n > 0 ? wide->force + n : &none) ALONG_ORDER left, right, wide->x[n + 1]);
            continue;
        }
#endif
        wide_order(PASS jet->start->held, sums, NEWEST(wide->left[n % wide_left_rows]) wide->x[n], n > 0 ? stem_now[n] : first, left, right, wide->x[n + 1]);
    }
}

/* Time at which the last two terms of every column are within the goal, relative to the column; zero when a coefficient
 * is not finite. */
static phi_real wide_length(const int order, const stem_jets *jet, const wide_jets *wide, const phi_real goal, const phi_real scales[PHI_SCALE_COUNT])
{
    phi_real state[2], radius;
    wide_lanes size[2], last[2], before[2];
    const phi_real unit = jet->start->unit[0];
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
    phi_real pace = stem_larger(scales[0], state[1]);
    pace = unit * (pace > 0 ? pace : 1);
    wide_norms(scales[1], wide->x[0], size);
    wide_norms(scales[1], wide->x[order], last);
    wide_norms(scales[1], wide->x[order - 1], before);
#if WITH_PARAMETERS
    /* A column that starts from nothing is measured by what its first coefficients make of it. */
    wide_lanes first[2], second[2];
    wide_norms(scales[1], wide->x[1], first);
    wide_norms(scales[1], wide->x[2], second);
#endif
    for (int lane = 0; lane < wide_lane_count; ++lane) {
#if WITH_PARAMETERS
        const phi_real begun = stem_larger(WIDE_OF(first[0], lane), WIDE_OF(first[1], lane) / pace);
        const phi_real grown = stem_larger(WIDE_OF(second[0], lane), WIDE_OF(second[1], lane) / pace);
        const phi_real carried = stem_larger(WIDE_OF(size[0], lane), WIDE_OF(size[1], lane) / pace);
        const phi_real allowed = goal * stem_larger(carried, stem_larger(begun, grown));
#else
        const phi_real allowed = goal * stem_larger(WIDE_OF(size[0], lane), WIDE_OF(size[1], lane) / pace);
#endif
        if (allowed > 0) {
            end = stem_larger(stem_larger(WIDE_OF(last[0], lane), WIDE_OF(last[1], lane) / pace) / allowed, end);
            next = stem_larger(stem_larger(WIDE_OF(before[0], lane), WIDE_OF(before[1], lane) / pace) / allowed, next);
        }
    }
    stem_radius(order, &unit, &end, &next, &radius);
    return radius;
}

/* Carry columns of derivatives over a step of length h or, where they ask for it, a shorter one, which is returned; zero
 * where they are not finite. */
static phi_real stem_carry(CONTEXT const int order, stem_jets *jet, const phi_real goal, const phi_real scales[PHI_SCALE_COUNT], phi_real h, VARIES(const phi_flow *flow, const unsigned long wanted, const phi_real *times) const int count, phi_real *transition)
{
    wide_jets *wide = (wide_jets *)(void *)jet->columns;
    const phi_real unit = jet->start->unit[0];
#if WITH_LINKS
    wide_share(order, jet);
#endif
    for (int first = 0; first < count;) {
        const int many = count - first < wide_lane_count ? count - first : wide_lane_count;
        for (int i = 0; i < stem_x; ++i) {
            const phi_real share = i < stem_q ? 1 : unit;
            for (int lane = 0; lane < wide_lane_count; ++lane) {
                WIDE_AT(wide->x[0][i], lane) = lane < many ? share * transition[count * i + first + lane] : 0;
            }
        }
#if WITH_PARAMETERS
        int varies = 0;
        for (int i = 0; i < stem_varied; ++i) {
            for (int lane = 0; lane < wide_lane_count; ++lane) {
                const phi_real direction = flow->along != NULL && lane < many ? flow->along[count * i + first + lane] : 0;
                WIDE_AT(wide->along[i], lane) = direction;
                varies |= direction > 0 || direction < 0;
            }
        }
        if (varies) {
#if WITH_FORCING
            wide_force(order, jet, wide);
#endif
            wide_begin(PASS jet, wide);
        }
#endif
        wide_expand(PASS order, VARIES(varies) jet, wide);
        const phi_real longest = wide_length(order, jet, wide, PHI_LEEWAY * goal, scales);
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
        const phi_real t = h / unit, square = t * t;
        phi_real zero = 0;
        for (int i = 0; i < stem_q; ++i) {
            /* Even and odd powers apart, so that no sum waits for the one before. */
            wide_lanes angle = wide->x[order][i], rate = wide->x[order][stem_q + i];
            wide_lanes next_angle = wide->x[order - 1][i], next_rate = wide->x[order - 1][stem_q + i];
            int n = order - 2;
            for (; n > 0; n -= 2) {
                angle = angle * square + wide->x[n][i];
                rate = rate * square + wide->x[n][stem_q + i];
                next_angle = next_angle * square + wide->x[n - 1][i];
                next_rate = next_rate * square + wide->x[n - 1][stem_q + i];
            }
            if (n == 0) {
                angle = angle * square + wide->x[0][i] + t * next_angle;
                rate = rate * square + wide->x[0][stem_q + i] + t * next_rate;
            } else {
                angle = angle * t + next_angle;
                rate = rate * t + next_rate;
            }
            for (int lane = 0; lane < many; ++lane) {
                const phi_real of_angle = WIDE_OF(angle, lane), of_rate = 1 / unit * WIDE_OF(rate, lane);
                jet->carried[count * i + first + lane] = of_angle;
                jet->carried[count * (stem_q + i) + first + lane] = of_rate;
                zero += 0 * of_angle + 0 * of_rate;
            }
        }
        if (!(zero >= 0 && zero <= 0)) {
            return 0;
        }
#if WITH_PARAMETERS
        /* At times behind a step that later columns shorten they are written again. */
        for (size_t at = flow->written; flow->passed != NULL && times != NULL && at < wanted; ++at) {
            const phi_real inside = (times[at] - flow->t) - flow->t_lost;
            wide_lanes seen[stem_x];
            if (h > 0 ? inside > h : inside < h) {
                break;
            }
            wide_look(order, unit, wide, inside, seen);
            for (size_t i = 0; i < stem_x; ++i) {
                for (int lane = 0; lane < many; ++lane) {
                    flow->passed[(at * stem_x + i) * (size_t)count + (size_t)(first + lane)] = WIDE_OF(seen[i], lane);
                }
            }
        }
#endif
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
