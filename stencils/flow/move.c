/* Where the states come from there, and what rounding takes from that. */
static void stem_move(const stem_lanes increment[stem_x], stem_jets *PHI_RESTRICT jet)
{
    for (int i = 0; i < stem_x; ++i) {
        const stem_lanes whole = increment[i] + jet->lost[i], before = jet->state[i], after = before + whole;
        jet->moved_lost[i] = (before - (after - (after - before))) + (whole - (after - before));
        jet->moved[i] = after;
    }
#if WITH_SPHERE
    {
        stem_lanes settled[stem_x];
        stem_settle(jet->moved, jet->moved_lost, settled);
        memcpy(jet->moved_lost, settled, sizeof settled);
    }
#endif
}

/* The whole of it, as the caller sees it. */
static void stem_look(const int order, const stem_jets *jet, const int lane, const phi_real h, phi_real x[stem_x])
{
#if WITH_SPHERE
    phi_real inside[stem_x];
    for (int i = 0; i < stem_x; ++i) {
        inside[i] = stem_entry(order, jet, lane, h, i);
    }
    stem_leave(inside, inside + stem_q, x, x + stem_q);
#else
    for (int i = 0; i < stem_x; ++i) {
        x[i] = stem_entry(order, jet, lane, h, i);
    }
#endif
}
