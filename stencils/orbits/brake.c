/* Brake orbits by shooting over a quarter period, on the emitted flow: theta(0) = theta_0 at rest, theta(T/4) = 0. What it means is
 * told in `orbits/quarter/problem.py`; unknowns are y = (q_0, omega) / scale throughout. */

enum {
    brake_q = PHI_Q,
    brake_cart = PHI_CART,
    brake_links = PHI_Q - PHI_CART,
    brake_all = PHI_Q + 1,
    brake_columns = 2 * (PHI_Q - PHI_CART)
};

/* The inertia matrix that is left for the angles at no momentum, and what a cart's rate is then by theirs. */
static void brake_inertia(CONTEXT const phi_real q[brake_q], phi_real share[brake_links], phi_real inertia[brake_links * brake_links])
{
    phi_real mass[brake_q * brake_q];
    phi_mass_matrix(MASS_PASS q, mass);
    for (int i = 0; i < brake_links; ++i) {
        share[i] = brake_cart ? -mass[brake_cart + i] / mass[0] : 0;
    }
    for (int i = 0; i < brake_links; ++i) {
        for (int j = 0; j < brake_links; ++j) {
            const phi_real own = mass[(brake_cart + i) * brake_q + brake_cart + j];
            inertia[i * brake_links + j] = brake_cart ? own + mass[(brake_cart + i) * brake_q] * share[j] : own;
        }
    }
}

/* The residual at orbit->y, and with columns its Jacobian, both in scaled unknowns; 0 where the chain cannot be followed. The columns are
 * derivatives by the angles at the start, which the Jacobian is made of, and then by their rates. */
static int brake_evaluate(CONTEXT const phi_flow *begun, brake_desk *desk, const phi_real tolerance, const int columns)
{
    brake_orbit *orbit = &desk->orbit;
    phi_real z[brake_all], v[brake_q] = {0}, nothing = 0;
    phi_flow flow = *begun;
    const phi_real still[brake_q] = {0};

    for (int i = 0; i < brake_all; ++i) {
        z[i] = orbit->y[i] * desk->scale[i];
        nothing += 0 * z[i];
        desk->asked[(int)desk->evaluations % DESK_ASKED][i] = z[i];
    }
    const phi_real quarter = BRAKE_HALF_PI / z[brake_q];
    desk->asked[(int)desk->evaluations % DESK_ASKED][brake_all] = tolerance;
    desk->asked[(int)desk->evaluations % DESK_ASKED][brake_all + 1] = columns;
    if (!(z[brake_q] > 0 && nothing >= 0)) {
        return 0;
    }
    desk->evaluations += 1;
    flow.t = 0;
    flow.tolerance = tolerance;
    flow.columns = columns;
    flow.transition = columns ? desk->transition : NULL;
    if (columns) {
        phi_real share[brake_links], inertia[brake_links * brake_links];
        memset(desk->transition, 0, sizeof desk->transition);
        if (brake_cart && columns == brake_columns) {
            brake_inertia(PASS z, share, inertia);
        }
        for (int i = 0; i < brake_links; ++i) {
            desk->transition[(brake_cart + i) * columns + i] = 1;
            if (columns == brake_columns) {
                desk->transition[(brake_q + brake_cart + i) * columns + brake_links + i] = 1;
            }
            if (brake_cart && columns == brake_columns) {
                desk->transition[brake_q * columns + brake_links + i] = share[i];
            }
        }
    }
    memcpy(orbit->residual, z, sizeof orbit->residual);
    (void)still; /* what has no inputs takes none */
    if (PHI_FLOW(&flow, quarter, (unsigned long)desk->most_steps, still, orbit->residual, v) != PHI_FLOW_DONE) {
        return 0;
    }
    if (columns) {
        desk->steps = (phi_real)flow.steps;
        memcpy(desk->rates, v, sizeof desk->rates);
        for (int i = 0; i < brake_q; ++i) {
            phi_real *row = orbit->jacobian[i];
            for (int j = 0; j < brake_cart; ++j) {
                row[j] = i == j ? desk->scale[j] : 0;
            }
            for (int j = 0; j < brake_links; ++j) {
                row[brake_cart + j] = desk->transition[i * columns + j] * desk->scale[brake_cart + j];
            }
            row[brake_q] = v[i] * (-quarter / z[brake_q]) * desk->scale[brake_q];
        }
    }
    return 1;
}

/* max_i |F_i| / sum_j |J_ij| |y_j|, and what rounding may have left in the residual. */
static void brake_measure(brake_desk *desk)
{
    brake_orbit *orbit = &desk->orbit;
    orbit->relative = 0;
    for (int i = 0; i < brake_q; ++i) {
        phi_real terms = 0;
        for (int j = 0; j < brake_all; ++j) {
            terms += fabs(orbit->jacobian[i][j]) * fabs(orbit->y[j]);
        }
        const phi_real own = fabs(orbit->residual[i]) / (terms > 0 ? terms : 1);
        orbit->relative = own > orbit->relative ? own : orbit->relative;
        orbit->noise[i] = terms * (BRAKE_EPSILON * (1 + desk->steps));
    }
}

/* A vector at unit length, where it has one. */
static void brake_unit(phi_real vector[brake_links])
{
    phi_real square = 0;
    for (int i = 0; i < brake_links; ++i) {
        square += vector[i] * vector[i];
    }
    for (int i = 0; i < brake_links && square > 0; ++i) {
        vector[i] /= sqrt(square);
    }
}

/* Rows `first` and on of the transition, by angles or by rates, in canonical coordinates: end^T T root^-T. */
static void brake_block(const brake_desk *desk, const int first, const int column, const phi_real *end, const phi_real *root, phi_real *block)
{
    for (int i = 0; i < brake_links; ++i) {
        for (int j = 0; j < brake_links; ++j) {
            phi_real sum = 0;
            for (int k = i; k < brake_links; ++k) {
                sum += end[k * brake_links + i] * desk->transition[(first + k) * brake_columns + column + j];
            }
            for (int k = 0; k < j; ++k) {
                sum -= block[i * brake_links + k] * root[j * brake_links + k];
            }
            block[i * brake_links + j] = sum / root[j * brake_links + j];
        }
    }
}

/* Orthonormal columns (N, N - 1) across a unit vector: a reflection that turns it into an axis, without that axis. */
static void brake_across(const phi_real unit[brake_links], phi_real across[brake_links][brake_links])
{
    phi_real normal[brake_links], square = 0;
    int largest = 0, column = 0;
    for (int i = 1; i < brake_links; ++i) {
        largest = fabs(unit[i]) > fabs(unit[largest]) ? i : largest;
    }
    memcpy(normal, unit, sizeof normal);
    normal[largest] += unit[largest] < 0 ? -1 : 1;
    for (int i = 0; i < brake_links; ++i) {
        square += normal[i] * normal[i];
    }
    for (int j = 0; j < brake_links; ++j) {
        for (int i = 0; i < brake_links && j != largest; ++i) {
            across[i][column] = (i == j) - 2 * normal[i] * normal[j] / square;
        }
        column += j != largest;
    }
}

/* The tangent, turned towards a direction, and sigma of [J; t]. */
static void brake_tangent(brake_desk *desk, const phi_real towards[brake_all])
{
    brake_orbit *orbit = &desk->orbit;
    phi_real rows[brake_all * brake_all], along = 0;
    memcpy(rows, orbit->jacobian, sizeof orbit->jacobian);
    small_null(brake_q, rows, orbit->tangent);
    for (int i = 0; i < brake_all; ++i) {
        along += orbit->tangent[i] * towards[i];
    }
    for (int i = 0; i < brake_all && !(along >= 0); ++i) {
        orbit->tangent[i] = -orbit->tangent[i];
    }
    memcpy(rows, orbit->jacobian, sizeof orbit->jacobian);
    memcpy(rows + brake_q * brake_all, orbit->tangent, sizeof orbit->tangent);
    orbit->sigma = small_signed(brake_all, rows);
}

/* All that is told of an orbit whose columns are at hand: the quarter map, its kappa, and the test functions; 0 where an inertia matrix is none. */
static int brake_tell(CONTEXT brake_desk *desk)
{
    enum { n = brake_links };
    brake_orbit *orbit = &desk->orbit;
    const phi_real still[brake_q] = {0};
    phi_real z[brake_q], share[n], root[n * n], end[n * n], across[n][n], moving[n][n], pushed[n][n], square[(n + 1) * (n + 1)];

    for (int i = 0; i < brake_q; ++i) {
        z[i] = orbit->y[i] * desk->scale[i];
    }
    brake_inertia(PASS z, share, root);
    brake_inertia(PASS still, share, end);
    if (!(small_root(n, root) && small_root(n, end))) {
        return 0;
    }
    brake_block(desk, brake_cart, 0, end, root, orbit->a[0]);
    brake_block(desk, brake_cart, n, end, root, orbit->b[0]);
    brake_block(desk, brake_q + brake_cart, 0, end, root, orbit->c[0]);
    brake_block(desk, brake_q + brake_cart, n, end, root, orbit->d[0]);
    for (int i = 0; i < n; ++i) {
        orbit->rate[i] = orbit->force[i] = orbit->slope[i] = 0;
        for (int k = i; k < n; ++k) {
            orbit->rate[i] += end[k * n + i] * desk->rates[brake_cart + k];
        }
    }
    for (int i = 0; i < n; ++i) {
        for (int k = 0; k < n; ++k) {
            orbit->force[i] += orbit->c[k][i] * orbit->rate[k];
        }
    }
    for (int i = 0; i < n; ++i) {
        for (int k = 0; k <= i; ++k) {
            orbit->slope[i] += root[i * n + k] * orbit->force[k];
        }
    }
    brake_unit(orbit->rate);
    brake_unit(orbit->force);
    brake_across(orbit->force, across);
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n - 1; ++j) {
            moving[i][j] = pushed[i][j] = 0;
            for (int k = 0; k < n; ++k) {
                moving[i][j] += orbit->a[i][k] * across[k][j];
                pushed[i][j] += orbit->d[i][k] * across[k][j];
            }
        }
    }
    for (int i = 0; i < n - 1; ++i) {
        for (int j = 0; j < n - 1; ++j) {
            orbit->folded[i * (n - 1) + j] = 0;
            for (int k = 0; k < n; ++k) {
                orbit->folded[i * (n - 1) + j] += pushed[k][i] * moving[k][j];
            }
        }
    }
    for (int i = 0; i < n; ++i) {
        memcpy(square + i * (n + 1), orbit->d[i], sizeof orbit->d[i]);
        square[i * (n + 1) + n] = orbit->rate[i];
        square[n * (n + 1) + i] = orbit->force[i];
    }
    square[(n + 1) * (n + 1) - 1] = 0;
    orbit->brake_loss = small_signed(n + 1, square);
    memcpy(square, orbit->b, sizeof orbit->b);
    orbit->odd_loss = small_signed(n, square);
    memcpy(square, orbit->c, sizeof orbit->c);
    orbit->unequal_brakes = small_signed(n, square);
    return 1;
}
