/* Newton's iteration on the residual and normal . (y - guess) = 0. Far from the curve columns may be rough; close to it the last ones
 * serve while what they are off by, times the correction, is rounding; the last evaluation is a whole one, at the very place that is
 * told, so that whoever comes back to it finds every bit again. */

/* What is left to correct at orbit->y: -[J; normal]^-1 [F; normal . (y - guess)], and its length; no number where the matrix is singular. */
static phi_real brake_left(const brake_desk *desk, phi_real left[brake_all])
{
    const brake_orbit *orbit = &desk->orbit;
    phi_real matrix[brake_all * brake_all], square = 0;
    memcpy(matrix, orbit->jacobian, sizeof orbit->jacobian);
    memcpy(matrix + brake_q * brake_all, desk->normal, sizeof desk->normal);
    left[brake_q] = 0;
    for (int i = 0; i < brake_q; ++i) {
        left[i] = -orbit->residual[i];
    }
    for (int i = 0; i < brake_all; ++i) {
        left[brake_q] -= desk->normal[i] * (orbit->y[i] - desk->guess[i]);
    }
    if (!small_solve(brake_all, matrix, 1, left)) {
        return HUGE_VAL;
    }
    for (int i = 0; i < brake_all; ++i) {
        square += left[i] * left[i];
    }
    return sqrt(square);
}

static phi_real brake_size(const phi_real y[brake_all])
{
    phi_real square = 0;
    for (int i = 0; i < brake_all; ++i) {
        square += y[i] * y[i];
    }
    return 1 + sqrt(square);
}

/* [J; t]^-1 [J'; t] - 1 of an orbit and the next one, in desk->change; its size comes back, no number where [J; t] is singular. */
static phi_real brake_change(brake_desk *desk)
{
    phi_real matrix[brake_all * brake_all], *change = desk->change[0], square = 0;
    memcpy(matrix, desk->before_jacobian, sizeof desk->before_jacobian);
    memcpy(matrix + brake_q * brake_all, desk->before_tangent, sizeof desk->before_tangent);
    memcpy(change, desk->orbit.jacobian, sizeof desk->orbit.jacobian);
    memcpy(change + brake_q * brake_all, desk->before_tangent, sizeof desk->before_tangent);
    if (!small_solve(brake_all, matrix, brake_all, change)) {
        return HUGE_VAL;
    }
    for (int i = 0; i < brake_all; ++i) {
        for (int j = 0; j < brake_all; ++j) {
            const phi_real moved = desk->change[i][j] - (i == j);
            square += moved * moved;
        }
    }
    return sqrt(square);
}

/* Spectral radius of [J; t]^-1 dJ, whether det [J; t] has another sign behind the step, and how far beyond it vanishes, in steps. */
static phi_real run_changed(brake_desk *desk, int *is_turned, phi_real *ahead)
{
    phi_real matrix[brake_all * brake_all], re[brake_all], im[brake_all], largest = 0, first = 1, second = 0;
    *is_turned = 0;
    *ahead = HUGE_VAL;
    if (desk->changed < RUN_SEEN || !(desk->changed < HUGE_VAL)) {
        return desk->changed;
    }
    memcpy(matrix, desk->change, sizeof desk->change);
    if (small_eigenvalues(brake_all, matrix, re, im) < brake_all) {
        return HUGE_VAL;
    }
    for (int i = 0; i < brake_all; ++i) {
        const phi_real kept = first * re[i] - second * im[i], own = hypot(re[i] - 1, im[i]);
        second = first * im[i] + second * re[i];
        first = kept;
        largest = own > largest ? own : largest;
        if (fabs(im[i]) < 0.1 * hypot(1 - re[i], im[i]) && 0 < re[i] && re[i] < 1 && re[i] / (1 - re[i]) < *ahead) {
            *ahead = re[i] / (1 - re[i]);
        }
    }
    *is_turned = first < 0;
    *ahead = *is_turned ? HUGE_VAL : *ahead;
    return largest;
}

/* From desk->guess back to the curve; orbit->converged says whether it got there. A guess at which the Jacobian has changed by more than is
 * allowed since the orbit before, without a sign of det [J; t] that would have to be looked into, is left at once; 0 allows all. */
static void brake_correct(CONTEXT const phi_flow *begun, brake_desk *desk, const phi_real allowed)
{
    brake_orbit *orbit = &desk->orbit;
    const phi_real rough = desk->rough > desk->tolerance ? desk->rough : desk->tolerance;
    int is_whole = !(rough > desk->tolerance), is_coarse = !is_whole, count = 0, since = 0, spent = 0;
    /* Off the place of the columns; what the next correction is thought to be; how strongly the Jacobian changes. */
    phi_real stale = 0, expected = HUGE_VAL, bend = 1, left[brake_all];

    /* Rough columns by the rates are carried where an orbit may be told by them. */
    const int few = desk->trust > 0 ? brake_columns : brake_links;

    memcpy(orbit->y, desk->guess, sizeof orbit->y);
    orbit->converged = 0;
    int is_known = brake_evaluate(PASS begun, desk, rough, is_whole ? brake_columns : few);
    if (is_known && is_coarse) {
        /* Beside a singular matrix what rough columns leave would be as far as the place where it is singular. */
        phi_real matrix[brake_all * brake_all];
        memcpy(matrix, orbit->jacobian, sizeof orbit->jacobian);
        memcpy(matrix + brake_q * brake_all, desk->normal, sizeof desk->normal);
        const phi_real sigma = fabs(small_signed(brake_all, matrix));
        bend = sigma < 1 ? 1 / sigma : 1;
        if (!(BRAKE_FLOOR * rough < BRAKE_CLEAR * sigma * sigma)) {
            is_known = brake_evaluate(PASS begun, desk, desk->tolerance, brake_columns);
            is_whole = 1;
            is_coarse = 0;
        }
    }
    if (is_known && allowed > 0) {
        int is_turned;
        phi_real ahead;
        desk->changed = brake_change(desk);
        is_known = run_changed(desk, &is_turned, &ahead) <= RUN_HOPELESS * allowed || is_turned;
    }
    while (is_known) {
        const phi_real length = brake_left(desk, left), scale = brake_size(orbit->y);
        if (!(length - length >= 0)) {
            break;
        }
        if (is_whole) {
            brake_measure(desk);
            const int is_thought = expected <= BRAKE_LEFT * scale && (length <= BRAKE_DOUBTFUL * scale || !(expected > 0));
            if (is_thought || (length <= BRAKE_ROUNDING * scale && orbit->relative <= BRAKE_EPSILON)) {
                orbit->converged = 1;
                break;
            }
        }
        if (spent == (int)desk->most_corrections || count == DESK_CORRECTIONS) {
            break;
        }
        for (int i = 0; i < brake_all; ++i) {
            orbit->y[i] += left[i];
        }
        orbit->corrections[count++] = length;
        if (desk->trust > 0 && stale + length <= desk->trust * scale) {
            /* Taken without asking again: Jacobian, and what came with it, stay those of the place before. */
            for (int i = 0; i < brake_q; ++i) {
                for (int j = 0; j < brake_all; ++j) {
                    orbit->residual[i] += orbit->jacobian[i][j] * left[j];
                }
            }
            brake_measure(desk);
            orbit->converged = 1;
            break;
        }
        spent += !(stale > 0);
        const int is_growing = count > 1 && length > 2 * orbit->corrections[count - 2];
        if (is_growing && (length > BRAKE_FAR || since > 0)) {
            break;
        }
        since += is_whole;
        if (stale > 0 && length > BRAKE_FLOOR * rough) {
            const phi_real seen = length / (orbit->corrections[count - 2] * stale);
            bend = seen > bend ? seen : bend;
        }
        expected = bend * length * (stale + length);
        stale += length;
        if (is_whole) {
            expected = length <= desk->tol * scale && !(desk->is_place > 0) ? 0 : expected;
        } else if (is_coarse) {
            expected = expected > BRAKE_FLOOR * rough ? expected : BRAKE_FLOOR * rough;
        }
        if (desk->is_place > 0 && expected <= BRAKE_LEFT * scale) {
            orbit->converged = 1;
            break;
        }
        const int is_stale = bend * stale > BRAKE_FRESH;
        if (is_whole || is_growing || expected <= BRAKE_LEFT * scale || (is_stale && length <= BRAKE_FAR)) {
            is_known = brake_evaluate(PASS begun, desk, desk->tolerance, brake_columns);
            is_whole = 1;
            stale = 0;
        } else {
            /* Where the columns are to be told they have to be near the place. */
            is_coarse = is_stale || desk->trust > 0;
            is_known = brake_evaluate(PASS begun, desk, is_coarse ? rough : desk->tolerance, is_coarse ? few : 0);
            stale = is_coarse ? 0 : stale;
        }
    }
    orbit->taken = count;
    orbit->is_whole = is_whole;
}

/* The potential energy of the rest, from that of the chain that hangs straight. */
static phi_real brake_energy(CONTEXT const brake_desk *desk)
{
#ifdef PHI_ENERGY
    const phi_real still[brake_q] = {0};
    phi_real z[brake_q], kinetic, high, low;
    for (int i = 0; i < brake_q; ++i) {
        z[i] = desk->orbit.y[i] * desk->scale[i];
    }
    PHI_ENERGY(z, still, &kinetic, &high);
    PHI_ENERGY(still, still, &kinetic, &low);
    return high - low;
#else
    (void)desk;
    return (phi_real)NAN;
#endif
}

/* How far off omega may be, relative: what rounding left in the residual, through [J; t]^-1. */
static phi_real brake_error(const brake_orbit *orbit)
{
    phi_real matrix[brake_all * brake_all], row[brake_all], sum = 0;
    for (int i = 0; i < brake_all; ++i) {
        for (int j = 0; j < brake_q; ++j) {
            matrix[i * brake_all + j] = orbit->jacobian[j][i];
        }
        matrix[i * brake_all + brake_q] = orbit->tangent[i];
        row[i] = i == brake_q;
    }
    if (!small_solve(brake_all, matrix, 1, row)) {
        return (phi_real)NAN;
    }
    for (int i = 0; i < brake_q; ++i) {
        sum += fabs(row[i]) * orbit->noise[i];
    }
    return sum / fabs(orbit->y[brake_q]);
}
