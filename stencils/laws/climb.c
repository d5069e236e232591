/* One input along a family of orbits. The phase of the orbit is where the chain is, the rung which orbit of the family it is on. */
phi_phase phi_law(phi_state *state, const phi_real x_meas[PHI_NX], phi_real u[1])
{
    const phi_real top = PHI_RUNGS - 1;
    phi_real level, size, slip, rate, load, off;

    phi_catching(x_meas, u, &level);
    if (level <= (state->phase == PHI_HOLDING ? phi_leave : 1)) {
        state->phase = PHI_HOLDING;
        return state->phase;
    }
    if (state->phase == PHI_HOLDING) {
        state->phase = PHI_CALMING;
    }
    phi_calming(x_meas, u, &size);
    if (state->phase == PHI_CALMING && size <= phi_rest) {
        phi_reset(state);
        state->phase = PHI_CLIMBING;
    }
    if (state->phase == PHI_CLIMBING) {
        phi_real push[1];
        const phi_real way = state->at * (phi_real)(PHI_NODES - 1);
        const int rung = state->rung < top - 1 ? (int)state->rung : PHI_RUNGS - 2;
        const int node = way < (phi_real)(PHI_NODES - 2) ? (int)way : PHI_NODES - 2;

        phi_following(x_meas, phi_table[rung][node], phi_table[rung + 1][node], &phi_slow[rung], state->rung - (phi_real)rung, way - (phi_real)node,
            state->side, push, &slip, &rate, &load, &off);
        if (off <= phi_tube) {
            u[0] = push[0];
            /* As fast as the input has room, and back down at half that pace where it has none; slowly where the orbit is slow. */
            const phi_real room = 1 - load, most = phi_rise[rung] * rate, pace = most < phi_pace ? most : phi_pace;
            const phi_real raised = state->rung + phi_sample * pace * (room > -phi_back ? room : -phi_back);

            state->rung = raised > 0 ? (raised < top ? raised : top) : 0;
            state->at += phi_sample * rate + phi_follow * slip;
            if (state->at >= 1) {
                state->at -= 1;
                state->side = -state->side;
            } else if (state->at < 0) {
                state->at += 1;
                state->side = -state->side;
            }
        } else {
            state->phase = PHI_CALMING;
        }
    }
    /* A measurement that is no number pushes nothing. */
    if (!(u[0] - u[0] <= 0)) {
        u[0] = 0;
        state->phase = PHI_CALMING;
    }
    return state->phase;
}

/* Ready to begin, whatever the chain does. */
void phi_reset(phi_state *state)
{
    state->phase = PHI_CALMING;
    state->rung = 0;
    state->at = 0;
    state->side = 1;
}
