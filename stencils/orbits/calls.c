/* What is called from outside, each on the caller's desk. */

int phi_brake_at(CONTEXT const phi_flow *begun, brake_desk *desk);
int phi_brake_corrected(CONTEXT const phi_flow *begun, brake_desk *desk);
int phi_brake_touched(brake_desk *desk);
int phi_brake_settled(CONTEXT const phi_flow *begun, brake_desk *desk);
int phi_brake_ahead(CONTEXT const phi_flow *begun, brake_desk *desk);
int phi_brake_run(CONTEXT const phi_flow *begun, brake_desk *desk);
int phi_brake_zero(CONTEXT const phi_flow *begun, brake_desk *desk);
int phi_brake_places(CONTEXT const phi_flow *begun, brake_desk *desk);

/* The orbit at desk->guess, whether it closes or not; 0 where the chain cannot be followed. */
int phi_brake_at(CONTEXT const phi_flow *begun, brake_desk *desk)
{
    desk->evaluations = 0;
    memcpy(desk->orbit.y, desk->guess, sizeof desk->orbit.y);
    if (!brake_whole(PASS begun, desk)) {
        return 0;
    }
    brake_found(PASS desk);
    return 1;
}

/* The orbit in the plane through desk->guess across desk->normal; 0 where Newton did not get there. */
int phi_brake_corrected(CONTEXT const phi_flow *begun, brake_desk *desk)
{
    desk->evaluations = 0;
    brake_correct(PASS begun, desk, 0);
    if (desk->orbit.converged > 0) {
        brake_found(PASS desk);
    }
    return desk->orbit.converged > 0;
}

/* The same orbit as at desk->guess, with what Newton still finds to be wrong with it taken off: its columns stay, which are as good. */
int phi_brake_settled(CONTEXT const phi_flow *begun, brake_desk *desk)
{
    phi_real length;
    desk->evaluations = 0;
    return brake_settle(PASS begun, desk, &length);
}

/* desk->guess at a distance desk->place along desk->axis, by the orbits that are known; how many of them served comes back. */
int phi_brake_touched(brake_desk *desk)
{
    return touch_curve((int)desk->count, desk->known, desk->axis, desk->place, desk->guess);
}

/* The next orbit, a step ahead of the last one that is known, whose Jacobian and tangent are desk->before_...; 0 where Newton did not get there. */
static int brake_stride(CONTEXT const phi_flow *begun, brake_desk *desk, const phi_real step, const phi_real allowed)
{
    const phi_real *last = desk->known[(int)desk->count - 1][0], *along = desk->before_tangent;
    phi_real moved = 0, shifted = 0, turned = 0;
    memcpy(desk->normal, along, sizeof desk->normal);
    memcpy(desk->axis, along, sizeof desk->axis);
    desk->place = step;
    for (int i = 0; i < brake_all; ++i) {
        desk->place += along[i] * last[i];
    }
    if (!phi_brake_touched(desk)) {
        for (int i = 0; i < brake_all; ++i) {
            desk->guess[i] = last[i] + step * along[i];
        }
    }
    brake_correct(PASS begun, desk, allowed);
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

/* The same of one step, desk->place. */
int phi_brake_ahead(CONTEXT const phi_flow *begun, brake_desk *desk)
{
    desk->evaluations = 0;
    return brake_stride(PASS begun, desk, desk->place, 0);
}

/* The next orbits, one after the other, as many as are wanted or until one that somebody has to look at; how many of them comes back. Zeros of test
 * functions that a run passes are located on the way, and told as events. */
int phi_brake_run(CONTEXT const phi_flow *begun, brake_desk *desk)
{
    desk->evaluations = desk->taken = desk->met = 0;
    enum run_stop stopped = RUN_ON;
    while (stopped == RUN_ON && desk->taken < desk->wanted && desk->taken < DESK_ROWS && desk->evaluations < RUN_EVALUATIONS) {
        phi_real next = 0;
        stopped = RUN_SMALL;
        while (stopped == RUN_SMALL && desk->step >= desk->step_min) {
            const phi_real allowed = desk->step > RUN_SHORT ? desk->max_change : 0;
            if (brake_stride(PASS begun, desk, desk->step, allowed)) {
                stopped = run_judged(desk, &next);
            }
            desk->step *= stopped == RUN_SMALL ? 0.5 : 1;
        }
        if (stopped != RUN_SMALL) {
            run_taken(desk, next);
            stopped = met_judged(PASS begun, desk, stopped);
            desk->step = stopped == RUN_TURNED ? desk->step : next;
            desk->taken += 1;
        }
    }
    desk->stopped = stopped;
    return (int)desk->taken;
}

/* The orbit between two others at which a test function vanishes (`zero.c`), settled where that is wanted; 0 where it was not found so. Of desk->tried orbits
 * desk->taken is that of the zero, desk->stopped that of its neighbour or -1, -2 for an end, and desk->place where the zero is. */
int phi_brake_zero(CONTEXT const phi_flow *begun, brake_desk *desk)
{
    zero_told told;
    desk->evaluations = 0;
    if (!zero_between(PASS begun, desk, desk->watch[0], &told)) {
        return 0;
    }
    desk->taken = told.at;
    desk->stopped = told.other;
    desk->place = told.place;
    return 1;
}

/* Where the curve has desk->placed's arclengths between the ends of the line, nothing else of the orbits there; 0 where Newton did not get to all. */
int phi_brake_places(CONTEXT const phi_flow *begun, brake_desk *desk)
{
    int is_reached = 1;
    desk->evaluations = 0;
    desk->is_place = 1;
    for (int i = 0; i < DESK_SHAPE && is_reached; ++i) {
        zero_guess(desk, desk->placed[i][0]);
        brake_correct(PASS begun, desk, 0);
        is_reached = desk->orbit.converged > 0;
        memcpy(desk->placed[i] + 1, desk->orbit.y, sizeof desk->orbit.y);
    }
    desk->is_place = 0;
    return is_reached;
}
