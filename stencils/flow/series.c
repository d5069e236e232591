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
#if WITH_OUTRIGHT

/* The coefficients of the states up to the highest order, which nearly every step wants, from jet->start. */
static STEM_APART void stem_expand(CONTEXT const int order, stem_jets *PHI_RESTRICT jet)
{
    const stem_start *start = jet->start;
    stem_lanes *rows = (stem_lanes *)(void *)jet->x;
#if WITH_COLUMNS
    stem_outright(PASS start->held, start->right[0], start->slope, (stem_lanes *)(void *)jet->left, (stem_lanes *)(void *)jet->right, rows);
#else
    stem_outright(PASS start->held, start->right[0], start->slope, rows);
#endif
    (void)order;
}
#else

/* The coefficients of the states up to the given order, from jet->start. */
static STEM_APART void stem_expand(CONTEXT const int order, stem_jets *PHI_RESTRICT jet)
{
    const int first = 4 + order % 4;
    memcpy(jet->left, jet->start->left, sizeof jet->start->left);
    memcpy(jet->right, jet->start->right, sizeof jet->start->right);
    memcpy(jet->x[1], jet->start->slope, sizeof jet->start->slope);
#if WITH_FORCING
    const stem_lanes pace = jet->omega * jet->start->unit[0];
    stem_lanes force = jet->start->drive[0], aside = jet->start->drive[1];
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
        jet->kept[0][stem_all - 6 * (stem_rubs - i) + 5] = jet->start->rubs[1][i];
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
#if WITH_SQUARES
            stem_square_sums(n, jet, sums + (size_t)(stem_lefts * stem_rights));
#endif
        } else if (turn == 0) {
            stem_ahead(n, jet);
#if WITH_SQUARES
            stem_square_ahead(n, jet);
#endif
        } else {
            /* A number that compilers see is one that they take in line. */
            if (turn == 1) {
                stem_rest(n, 1, jet);
            } else if (turn == 2) {
                stem_rest(n, 2, jet);
            } else {
                stem_rest(n, 3, jet);
            }
#if WITH_SQUARES
            stem_square_rest(n, turn, jet);
#endif
        }
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
        stem_order(PASS jet->start->BEHIND, sums, NEWEST(jet->left[n]) jet->x[n], stem_now[n], FORCE(&force) jet->left[n + 1], jet->right[n + 1], jet->x[n + 1]);
    }
}
#endif

/* How far the states move in times h, x_1 t + x_2 t^2 + ... with t = h / unit, and h times the slope of the rates' series in the
 * units of their coefficients: even and odd powers apart, so that no sum waits for the one before. Order 1, the most of it, is added
 * last and rounded once. Angles have rates for slopes, to the last term. */
static void stem_advance(const int order, const stem_jets *PHI_RESTRICT jet, const stem_lanes *h, stem_lanes increment[PHI_RESTRICT stem_x], stem_lanes along[PHI_RESTRICT stem_q])
{
    const stem_lanes t = *h / jet->start->unit[0], share = t / jet->start->unit[0], square = t * t;
    for (int i = 0; i < stem_q; ++i) {
        /* From order 2 on: even powers, odd ones, and the slopes of the rates' along t^2. */
        stem_lanes angle = STEM_ZERO, rate = angle, slope = angle, odd_angle = angle, odd_rate = angle, odd_slope = angle;
        int n = order;
        if (n % 2 == 0) {
            angle = jet->x[n][i];
            rate = jet->x[n--][stem_q + i];
        }
        for (; n > 1; n -= 2) {
            odd_slope = odd_slope * square + odd_rate;
            slope = slope * square + rate;
            odd_angle = odd_angle * square + jet->x[n][i];
            odd_rate = odd_rate * square + jet->x[n][stem_q + i];
            angle = angle * square + jet->x[n - 1][i];
            rate = rate * square + jet->x[n - 1][stem_q + i];
        }
        const stem_lanes rest = odd_rate * t + rate, bend = 2 * (odd_slope * square + slope * t) + odd_rate;
        increment[i] = ((odd_angle * t + angle) * t + jet->x[1][i]) * t;
        increment[stem_q + i] = (rest * t + jet->x[1][stem_q + i]) * share;
        along[i] = ((2 * rest + bend * t) * t + jet->x[1][stem_q + i]) * t;
    }
}

/* One entry of a lane's state at a time h into its step, whole turns added; powers apart as in stem_advance. */
static phi_real stem_entry(const int order, const stem_jets *jet, const int lane, const phi_real h, const int i)
{
    const phi_real unit = STEM_OF(jet->start->unit[0], lane), t = h / unit, square = t * t;
    phi_real sum = 0, odd = 0;
    int n = order;
    if (n % 2 == 0) {
        sum = STEM_OF(jet->x[n][i], lane);
        --n;
    }
    for (; n > 1; n -= 2) {
        odd = odd * square + STEM_OF(jet->x[n][i], lane);
        sum = sum * square + STEM_OF(jet->x[n - 1][i], lane);
    }
    sum = (odd * t + sum) * t + STEM_OF(jet->x[1][i], lane);
    sum = STEM_OF(jet->state[i], lane) + (sum * (i < stem_q ? t : t / unit) + STEM_OF(jet->lost[i], lane));
#if WITH_TURNS
    return i < stem_cart || i >= stem_q ? sum : stem_turned(sum, STEM_OF(jet->turns[i], lane));
#else
    return sum;
#endif
}

/* Largest of the angles' coefficients of order n, and of the rates'. */
static void stem_terms(const int n, const stem_jets *jet, const phi_real reach, stem_lanes norm[2])
{
    stem_norms(reach, jet->x[n], norm);
}
