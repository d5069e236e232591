/* What is called from outside, each on the caller's desk. */

int phi_brake_at(CONTEXT const phi_flow *begun, brake_desk *desk);
int phi_brake_corrected(CONTEXT const phi_flow *begun, brake_desk *desk);
int phi_brake_touched(brake_desk *desk);
int phi_brake_settled(CONTEXT const phi_flow *begun, brake_desk *desk);
int phi_brake_ahead(CONTEXT const phi_flow *begun, brake_desk *desk);

/* All of an orbit that is known: its tangent towards the normal, and what is told of it. */
static void brake_found(CONTEXT brake_desk *desk)
{
    brake_tangent(desk, desk->normal);
    desk->orbit.is_told = brake_tell(PASS desk);
    desk->orbit.error = brake_error(&desk->orbit);
    desk->orbit.energy = brake_energy(PASS desk);
}

/* The orbit at desk->guess, whether it closes or not; 0 where the chain cannot be followed. */
int phi_brake_at(CONTEXT const phi_flow *begun, brake_desk *desk)
{
    desk->evaluations = desk->orbit.taken = 0;
    desk->orbit.converged = desk->orbit.is_whole = 1;
    memcpy(desk->orbit.y, desk->guess, sizeof desk->orbit.y);
    if (!brake_evaluate(PASS begun, desk, desk->tolerance, brake_columns)) {
        return 0;
    }
    brake_measure(desk);
    brake_found(PASS desk);
    return 1;
}

/* The orbit in the plane through desk->guess across desk->normal; 0 where Newton did not get there. */
int phi_brake_corrected(CONTEXT const phi_flow *begun, brake_desk *desk)
{
    desk->evaluations = 0;
    brake_correct(PASS begun, desk);
    if (desk->orbit.converged > 0) {
        brake_found(PASS desk);
    }
    return desk->orbit.converged > 0;
}

/* The same orbit as at desk->guess, with what Newton still finds to be wrong with it taken off: its columns stay, which are as good. */
int phi_brake_settled(CONTEXT const phi_flow *begun, brake_desk *desk)
{
    phi_real left[brake_all];
    desk->evaluations = desk->orbit.taken = 0;
    desk->orbit.converged = desk->orbit.is_whole = 1;
    memcpy(desk->orbit.y, desk->guess, sizeof desk->orbit.y);
    if (!brake_evaluate(PASS begun, desk, desk->tolerance, brake_columns)) {
        return 0;
    }
    brake_measure(desk);
    brake_found(PASS desk);
    if (brake_left(desk, left) <= BRAKE_SETTLED) {
        for (int i = 0; i < brake_all; ++i) {
            desk->orbit.y[i] += left[i];
        }
    }
    return 1;
}

/* desk->guess at a distance desk->place along desk->axis, by the orbits that are known; how many of them served comes back. */
int phi_brake_touched(brake_desk *desk)
{
    return touch_curve((int)desk->count, desk->known, desk->axis, desk->place, desk->guess);
}

/* The next orbit, a step ahead of the last one that is known, whose Jacobian and tangent are desk->before_...; 0 where Newton did not get there. */
int phi_brake_ahead(CONTEXT const phi_flow *begun, brake_desk *desk)
{
    const phi_real *last = desk->known[(int)desk->count - 1][0], *along = desk->before_tangent, step = desk->place;
    phi_real moved = 0, shifted = 0, turned = 0;
    desk->evaluations = 0;
    memcpy(desk->normal, along, sizeof desk->normal);
    memcpy(desk->axis, along, sizeof desk->axis);
    for (int i = 0; i < brake_all; ++i) {
        desk->place += along[i] * last[i];
    }
    if (!phi_brake_touched(desk)) {
        for (int i = 0; i < brake_all; ++i) {
            desk->guess[i] = last[i] + step * along[i];
        }
    }
    brake_correct(PASS begun, desk);
    if (!(desk->orbit.converged > 0)) {
        return 0;
    }
    brake_found(PASS desk);
    for (int i = 0; i < brake_all; ++i) {
        moved += (desk->orbit.y[i] - last[i]) * (desk->orbit.y[i] - last[i]);
        shifted += (desk->orbit.y[i] - desk->guess[i]) * (desk->orbit.y[i] - desk->guess[i]);
        turned += desk->orbit.tangent[i] * along[i];
    }
    desk->moved = sqrt(moved);
    desk->shifted = sqrt(shifted);
    desk->turned = turned;
    desk->changed = brake_change(desk);
    return 1;
}
