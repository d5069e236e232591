/* What is called from outside, each on the caller's desk. */

int phi_brake_at(CONTEXT const phi_flow *begun, brake_desk *desk);
int phi_brake_corrected(CONTEXT const phi_flow *begun, brake_desk *desk);
int phi_brake_touched(brake_desk *desk);
double phi_brake_changed(brake_desk *desk);

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
    desk->evaluations = 0;
    memcpy(desk->orbit.y, desk->guess, sizeof desk->orbit.y);
    if (!brake_evaluate(PASS begun, desk, desk->tolerance, 1)) {
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

/* desk->guess at a distance desk->place along desk->axis, by the orbits that are known; how many of them served comes back. */
int phi_brake_touched(brake_desk *desk)
{
    return touch_curve((int)desk->count, desk->known, desk->axis, desk->place, desk->guess);
}

/* How far the Jacobian changed from the orbit before to this one. */
double phi_brake_changed(brake_desk *desk)
{
    return brake_change(desk);
}
