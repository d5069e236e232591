/* The inputs along the trajectory at a time, and which phase that is: the way between two rows of the table, and its ends beyond. */
phi_phase phi_law(phi_state *state, const phi_real t, const phi_real measured[PHI_READ], phi_real u[PHI_NU])
{
    const phi_real last = PHI_KNOTS - 1, at = t * phi_rate;
    /* Comparisons with a time that is not a number do not hold: it counts as 0 here, and is given up below. */
    const phi_real place = at > 0 ? (at < last ? at : last) : 0;
    const int knot = (int)place, next = knot < PHI_KNOTS - 1 ? knot + 1 : knot;
    phi_real off;
#if WITH_OBSERVER
    phi_real following[PHI_MEMORY];

#if WITH_LEARNING
    if (at >= last) {
        phi_holding(measured, state->expected, phi_held, u, &off, following);
    } else {
        phi_tracking(measured, state->expected, phi_table[knot], phi_table[next], place - (phi_real)knot, u, &off, following);
    }
#else
    phi_tracking(measured, state->expected, phi_table[knot], phi_table[next], place - (phi_real)knot, u, &off, following);
#endif
    for (int i = 0; i < PHI_MEMORY; ++i) {
        state->expected[i] = following[i];
    }
#else

    phi_tracking(measured, phi_table[knot], phi_table[next], place - (phi_real)knot, u, &off);
#endif
    int is_sound = off <= phi_tube && (at <= last || at > last);
#if WITH_RAIL
    is_sound = is_sound && measured[0] <= phi_rail && measured[0] >= -phi_rail;
#endif
    for (int i = 0; i < PHI_NU; ++i) {
        is_sound = is_sound && u[i] - u[i] <= 0;
    }
    if (!is_sound || state->phase == PHI_LOST) {
        for (int i = 0; i < PHI_NU; ++i) {
            u[i] = 0;
        }
        state->phase = PHI_LOST;
    } else {
        state->phase = at < last ? PHI_SWINGING : PHI_HOLDING;
    }
    return state->phase;
}

#if WITH_OBSERVER
/* Ready for the next swing, at rest where the first measurement is. */
void phi_reset(phi_state *state, const phi_real measured[PHI_READ])
{
    state->phase = PHI_SWINGING;
    phi_beginning(measured, phi_table[0], state->expected);
}
#else
/* Ready for the next swing. */
void phi_reset(phi_state *state)
{
    state->phase = PHI_SWINGING;
}
#endif
