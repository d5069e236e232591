/* A cos(omega t) and A sin(omega t), for amplitudes A, at times after the steps' starts, omega t to twice the precision. */
static void stem_drive(const stem_jets *jet, const stem_lanes *amplitude_of, const stem_lanes *after, stem_lanes drive[PHI_RESTRICT 2])
{
    for (int lane = 0; lane < stem_lane_count; ++lane) {
        const phi_real amplitude = STEM_OF(*amplitude_of, lane), omega = STEM_OF(jet->omega, lane);
        const phi_real t = STEM_OF(jet->t, lane), whole = STEM_OF(*after, lane) + STEM_OF(jet->t_lost, lane), now = t + whole;
        const phi_real phase = omega * now, rest = stem_fused(omega, now, -phase) + omega * (whole - (now - t));
#if WITH_OWN_TRIGONOMETRY
        phi_real cosine, sine;
        phi_sincos(1, &phase, &sine, &cosine);
#else
        const phi_real cosine = phi_cos(phase), sine = phi_sin(phase);
#endif
        STEM_AT(drive[0], lane) = amplitude * (cosine - rest * sine);
        STEM_AT(drive[1], lane) = amplitude * (sine + rest * cosine);
    }
}
