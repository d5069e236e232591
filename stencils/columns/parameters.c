/* Derivatives by parameters: each column has a direction among them, along which what a step holds is differentiated. */
#if WITH_FORCING
/* Coefficients of A cos(omega t) along the columns' directions of A and omega. */
static void wide_force(const int order, const stem_jets *PHI_RESTRICT jet, wide_jets *PHI_RESTRICT wide)
{
    const phi_real one = 1, no_time = 0, unit = jet->start->unit[0], pace = unit * jet->omega, t = jet->t + jet->t_lost;
    const wide_lanes d_amplitude = wide->along[stem_forcing], d_omega = wide->along[stem_forcing + 1];
    const wide_lanes d_phase = t * d_omega, d_pace = unit * d_omega;
    phi_real wave[2], force = jet->start->drive[0], aside = jet->start->drive[1];
    stem_drive(jet, &one, &no_time, wave);
    wide_lanes d_force = wave[0] * d_amplitude - aside * d_phase, d_aside = wave[1] * d_amplitude + force * d_phase;
    wide->force[0] = d_force;
    for (int n = 1; n < order; ++n) {
        const phi_real share = stem_now[n - 1][1], turned = share * (pace * force);
        const wide_lanes d_turned = share * (pace * d_force + d_pace * force);
        d_force = -share * (pace * d_aside + d_pace * aside);
        d_aside = d_turned;
        force = -share * (pace * aside);
        aside = turned;
        wide->force[n] = d_force;
    }
}
#endif

/* What a step holds, along the columns' directions. */
static void wide_begin(CONTEXT const stem_jets *PHI_RESTRICT jet, wide_jets *PHI_RESTRICT wide)
{
    const phi_real *lost = jet->lost;
    phi_real first[stem_x];
    for (int i = 0; i < stem_q; ++i) {
        first[i] = jet->state[i];
        first[stem_q + i] = jet->start->unit[0] * jet->state[stem_q + i];
    }
    wide_factor_along(PASS first, first + stem_q, INPUTS FORCE(jet->start->drive) jet->start->unit, LOST FORCE(wide->force) ALONG_FACTOR FORCE(wide->later) wide->held);
#if !WITH_LOST
    (void)lost;
#endif
}

/* Columns at a time h into a step. */
static void wide_look(const int order, const phi_real unit, const wide_jets *PHI_RESTRICT wide, const phi_real h, wide_lanes seen[PHI_RESTRICT stem_x])
{
    const phi_real t = h / unit;
    for (int i = 0; i < stem_x; ++i) {
        const phi_real share = i < stem_q ? 1 : 1 / unit;
        wide_lanes sum = wide->x[order][i];
        for (int n = order - 1; n >= 0; --n) {
            sum = sum * t + wide->x[n][i];
        }
        seen[i] = share * sum;
    }
}
