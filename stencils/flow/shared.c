/* Factor the mass matrix in the states x + lost, time in the given units, and solve for row 2 of the configuration. */
static void stem_begin(CONTEXT const stem_jets *jet, const stem_lanes x[stem_x], const stem_lanes lost[stem_x], const stem_lanes *unit, AFTER(const stem_lanes *after) stem_start *PHI_RESTRICT start)
{
    stem_lanes sums[stem_all], row[stem_row], rate[stem_q], none[stem_lefts * stem_rights];
    start->unit[0] = *unit;
    start->unit[1] = *unit * *unit;
    memcpy(row, x, stem_q * sizeof *x);
    for (int i = 0; i < stem_q; ++i) {
        rate[i] = *unit * x[stem_q + i];
    }
#if WITH_FORCING
    stem_drive(jet, &jet->amplitude, after, start->drive);
#endif
    memcpy(start->row[0], rate, stem_cart * sizeof *rate);
    stem_factor(PASS row, rate, INPUTS FORCE(start->drive) start->unit, LOST start->held, FORCE(start->later) start->row[0] + stem_cart, none);
    for (int k = 0; k < stem_all; ++k) {
        sums[k] = STEM_ZERO;
    }
    for (int k = 0; k < stem_masses; ++k) {
        const stem_lanes *link = rate + stem_cart + 3 * k;
        sums[stem_lefts * stem_rights + k] = link[0] * link[0] + link[1] * link[1] + link[2] * link[2];
    }
#if WITH_RUBS
    stem_rub(start);
    for (int i = 0; i < stem_rubs; ++i) {
        sums[stem_all - 6 * (stem_rubs - i) + 5] = start->rubs[1][i];
    }
    memset(row + stem_q, 0, (stem_row - stem_q) * sizeof *row);
#endif
#if WITH_FORCING
    /* What is constant in time, the forcing as it is now included. */
    const stem_lanes one = STEM_ZERO + 1;
#endif
    stem_order(PASS start->held, sums, row, start->row[0], stem_now[0], FORCE(&one) start->row[1], start->right);
#if !WITH_INPUTS
#if !WITH_FORCING
    (void)jet;
#endif
#endif
#if !WITH_LOST
    (void)lost;
#endif
}

/* Rows of the configuration up to the given order and one beyond, from jet->start. */
static STEM_APART void stem_expand(CONTEXT const int order, stem_jets *PHI_RESTRICT jet)
{
    const int first = 4 + order % 4;
    memcpy(jet->x[1], jet->start->row, sizeof jet->start->row);
    memset(jet->right[0], 0, sizeof jet->right[0]);
    memcpy(jet->right[1], jet->start->right, sizeof jet->start->right);
#if WITH_FORCING
    const stem_lanes pace = jet->omega * jet->start->unit[0];
    stem_lanes force = jet->start->drive[0], aside = jet->start->drive[1];
#endif
    for (int n = 1; n < order; ++n) {
        const int turn = n < first ? 0 : (n - first) % 4;
        stem_lanes *sums = jet->sums[turn];
        if (n < first) {
            stem_sums(n, jet, sums);
        } else if (turn == 0) {
            stem_ahead(n, jet);
            stem_square_ahead(n, jet);
        } else if (turn == 1) {
            /* A number that compilers see is one that they take in line. */
            stem_rest(n, 1, jet);
        } else if (turn == 2) {
            stem_rest(n, 2, jet);
        } else {
            stem_rest(n, 3, jet);
        }
#if WITH_RUBS
        stem_rub_sums(n, jet, sums + (stem_all - 6 * stem_rubs));
#endif
#if WITH_FORCING
        /* The forcing's coefficient of order n, and that of the sine beside it. */
        const stem_lanes share = pace * stem_now[n - 1][1], turned = share * force;
        force = -(share * aside);
        aside = turned;
#endif
        stem_order(PASS jet->start->BEHIND, sums, jet->x[n], jet->x[n + 1], stem_now[n], FORCE(&force) jet->x[n + 2], jet->right[n + 1]);
    }
}

/* How far the states move in times h, and h times the slope of the rates' series in the units of their coefficients, by Horner's rule
 * and its derivatives: q_1 t + q_2 t^2 + s t^3, where d and e are the first slope of s and half the second. Order 1 of each, the most of
 * it, is added last and rounded once. */
static void stem_advance(const int order, const stem_jets *PHI_RESTRICT jet, const stem_lanes *h, stem_lanes increment[PHI_RESTRICT stem_x], stem_lanes along[PHI_RESTRICT stem_q])
{
    const stem_lanes t = *h / jet->start->unit[0], share = t / jet->start->unit[0];
    for (int i = 0; i < stem_q; ++i) {
        stem_lanes s = jet->x[order + 1][i], d = STEM_ZERO, e = STEM_ZERO;
        for (int n = order; n > 2; --n) {
            e = e * t + d;
            d = d * t + s;
            s = s * t + jet->x[n][i];
        }
        const stem_lanes second = jet->x[2][i], first = 2 * second;
        increment[i] = ((s * t + second) * t + jet->x[1][i]) * t;
        increment[stem_q + i] = ((3 * s + d * t) * t + first) * share;
        along[i] = ((6 * (s + d * t) + 2 * (e * (t * t))) * t + first) * t;
    }
}

/* One entry of a lane's state at a time h into its step. */
static phi_real stem_entry(const int order, const stem_jets *jet, const int lane, const phi_real h, const int i)
{
    const phi_real unit = STEM_OF(jet->start->unit[0], lane), t = h / unit;
    const int is_rate = i >= stem_q, at = i % stem_q;
    phi_real sum = 0;
    for (int n = order + 1; n > is_rate; --n) {
        sum = sum * t + STEM_OF(jet->x[n][at], lane) * (is_rate ? (phi_real)n : 1);
    }
    return STEM_OF(jet->state[i], lane) + (sum * (is_rate ? t / unit : t) + STEM_OF(jet->lost[i], lane));
}

/* Largest of the configuration's coefficients of order n, and of its rates'. */
static void stem_terms(const int n, const stem_jets *jet, const phi_real reach, stem_lanes norm[2])
{
    stem_norm(reach, jet->x[n], norm);
    stem_norm(reach, jet->x[n + 1], norm + 1);
    norm[1] *= (phi_real)(n + 1);
}
