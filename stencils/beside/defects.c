/* First coefficients of the series of a step with what rounding took from them: the Programs of the recurrences once more, on pairs. */
static void stem_first(CONTEXT const stem_step *step, const stem_jets *jet, stem_pair x[stem_paired + 1][stem_x])
{
    enum { numbers = (int)(sizeof jet->start->held / sizeof(phi_real)), products = stem_lefts * stem_rights };
    stem_pair held[numbers], left[stem_paired + 1][stem_lefts], right[stem_paired + 1][products], sums[products];
    stem_pair given[stem_x], none[stem_x];
    const stem_pair scale[2] = {{step->unit, 0}, {step->unit * step->unit, 0}};
    memset(none, 0, sizeof none);
    memset(given, 0, sizeof given);
    for (int i = 0; i < stem_q; ++i) {
        x[0][i].value = step->state[i];
        x[0][i].rest = step->lost[i];
        x[0][stem_q + i].value = step->unit * step->state[stem_q + i];
        x[0][stem_q + i].rest = step->unit * step->lost[stem_q + i];
    }
#if WITH_INPUTS
    for (int i = 0; i < stem_inputs; ++i) {
        given[i].value = jet->u[i];
    }
#endif
    stem_factor_pairs(PASS x[0], x[0] + stem_q, given, scale, none, held, left[0], right[0]);
    for (int n = 0; n < stem_paired; ++n) {
        const stem_pair one = {1, 0}, next = {(phi_real)(n + 1), 0}, after = {(phi_real)((n + 1) * (n + 2)), 0};
        const stem_pair now[4] = {next, stem_divide(one, next), stem_divide(one, after), {n == 0 ? 1 : 0, 0}};
        for (int k = 0; k < products; ++k) {
            sums[k] = stem_multiply(left[0][k % stem_lefts], right[n][k]);
            for (int j = 1; j <= n; ++j) {
                sums[k] = stem_add(sums[k], stem_multiply(left[j][k % stem_lefts], right[n - j][k]));
            }
        }
        stem_order_pairs(PASS held, sums, left[n], x[n], now, left[n + 1], right[n + 1], x[n + 1]);
    }
    (void)jet;
}

/* The error of a step with its sign: what it moved by, less what the first coefficients say without rounding and the others as they are,
 * whose rounding is a hundredth of theirs; and what its series leaves, where that is more than the noise it is found in. */
static void stem_defect(CONTEXT const phi_real goal, const stem_step *step, const stem_jets *jet, phi_real error[stem_x])
{
    stem_pair x[stem_paired + 1][stem_x];
    const phi_real t = step->h / step->unit;
    stem_first(PASS step, jet, x);
    for (int i = 0; i < stem_x; ++i) {
        const stem_pair gap = {step->gap[i], step->rest[i]};
        stem_pair sum = x[stem_paired][i];
        for (int n = stem_paired; n > 1; --n) {
            sum = stem_add(stem_scale(sum, t), x[n - 1][i]);
        }
        sum = stem_subtract(gap, stem_scale(stem_scale(sum, t), i < stem_q ? 1 : 1 / step->unit));
        error[i] = (goal < PHI_EPSILON ? 0 : step->error[i]) + (sum.value + sum.rest);
    }
}
