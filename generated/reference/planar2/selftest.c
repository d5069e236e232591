/* Self-test of planar2.
 *
 * Every function is compared with the un-lowered Lagrangian in 50 digits, rounded once; Jacobians along
 * one direction each. Build it with planar2.c and run it: it says how each comparison ended, and the exit
 * code is the number of failures. On a target define PLANAR2_NO_MAIN and call planar2_selftest from your
 * own main: that needs nothing of the C library.
 */
#include "planar2.h"
#include <stddef.h>
#ifndef PLANAR2_NO_MAIN
#include <stdio.h>
#endif

int planar2_selftest(void);

/* Who is told of each comparison; a null pointer for nobody. */
typedef void listener(const char *what, planar2_real error, planar2_real tolerance, int failed);

/* The size of a number. */
static planar2_real size_of(planar2_real x)
{
    return x < 0.0 ? -x : x;
}

/* Largest error over largest expected entry; NaN fails. Returns the number of failures, 0 or 1. */
static int compare(listener *tell, const char *what, int count, const planar2_real *found,
    const planar2_real *expected, planar2_real tolerance)
{
    planar2_real worst = 0.0;
    planar2_real scale = 0.0;
    int failed = 0;

    for (int i = 0; i < count; ++i) {
        const planar2_real error = size_of(found[i] - expected[i]);

        worst = error > worst ? error : worst;
        scale = size_of(expected[i]) > scale ? size_of(expected[i]) : scale;
        failed |= !(error >= 0.0);
    }
    if (scale > 0.0) {
        worst /= scale;
    }
    failed |= worst > tolerance;
    if (tell != 0) {
        tell(what, worst, tolerance, failed);
    }
    return failed;
}

static int case_1(listener *tell)
{
    static const planar2_real q[2] = {-0x1.29660004d562p-2, 0x1.2c5825afdba8p-6};
    static const planar2_real v[2] = {-0x1.f07946d8c10f2p+0, -0x1.2f4e150139608p-2};
    static const planar2_real u[2] = {-0x1.6fd87cb47aaaap+0, -0x1.bbce8ef03f34p-2};
    static const planar2_real a_expected[2] = {0x1.161f31772d3f9p+3, -0x1.d88340b05522cp+4};
    planar2_real a[2];
    int failures = 0;

    planar2_forward_dynamics(q, v, u, a);
    failures += compare(tell, "forward_dynamics", 2, a, a_expected, PLANAR2_FORWARD_DYNAMICS_TOLERANCE);
    return failures;
}

static int case_2(listener *tell)
{
    static const planar2_real q[2] = {-0x1.54c03368e4c8p-3, 0x1.79da8b356368p-1};
    static const planar2_real v[2] = {0x1.0442d824c351cp-1, -0x1.474c2ca955f88p-2};
    static const planar2_real u[2] = {-0x1.d6f76ab3b29c4p-1, 0x1.2a62d163a25p-3};
    static const planar2_real a_expected[2] = {0x1.dcf0e2d37fec9p+1, -0x1.a2739ae79ca23p+4};
    planar2_real a[2];
    int failures = 0;

    planar2_forward_dynamics(q, v, u, a);
    failures += compare(tell, "forward_dynamics", 2, a, a_expected, PLANAR2_FORWARD_DYNAMICS_TOLERANCE);
    return failures;
}

static int case_3(listener *tell)
{
    static const planar2_real q[2] = {0x1.8879c24969d48p-2, -0x1.3da005ac9328ap+0};
    static const planar2_real v[2] = {-0x1.8dd1b56f14304p+0, 0x1.2377ad63df8b2p+0};
    static const planar2_real u[2] = {0x1.25286acc1233p-3, -0x1.c0851d59dc22ap+0};
    static const planar2_real a_expected[2] = {0x1.a96c0bd659c12p+2, -0x1.063d22436fff8p+5};
    planar2_real a[2];
    int failures = 0;

    planar2_forward_dynamics(q, v, u, a);
    failures += compare(tell, "forward_dynamics", 2, a, a_expected, PLANAR2_FORWARD_DYNAMICS_TOLERANCE);
    return failures;
}

static int case_4(listener *tell)
{
    static const planar2_real q[2] = {-0x1.d1506324532ap-3, -0x1.85caf6e79d8e2p+0};
    static const planar2_real v[2] = {0x1.ddf2202c4741ap+0, 0x1.4b5db453b4ad6p+0};
    static const planar2_real a[2] = {0x1.d3115f4755ad2p+0, -0x1.2770f5545c36p-2};
    static const planar2_real u_expected[2] = {-0x1.4929e231893cfp+0, -0x1.5ee9f120778c4p+0};
    planar2_real u[2];
    int failures = 0;

    planar2_inverse_dynamics(q, v, a, u);
    failures += compare(tell, "inverse_dynamics", 2, u, u_expected, PLANAR2_INVERSE_DYNAMICS_TOLERANCE);
    return failures;
}

static int case_5(listener *tell)
{
    static const planar2_real q[2] = {0x1.29bec306d62fp-2, -0x1.83def40af4d26p+0};
    static const planar2_real v[2] = {-0x1.97a459894f3fp-2, 0x1.0efe657448d98p-1};
    static const planar2_real a[2] = {-0x1.5d14b00c1de2p-2, 0x1.9c2ab08a90264p+0};
    static const planar2_real u_expected[2] = {-0x1.e312149c8d728p-4, -0x1.1ff37d0d0088ep+0};
    planar2_real u[2];
    int failures = 0;

    planar2_inverse_dynamics(q, v, a, u);
    failures += compare(tell, "inverse_dynamics", 2, u, u_expected, PLANAR2_INVERSE_DYNAMICS_TOLERANCE);
    return failures;
}

static int case_6(listener *tell)
{
    static const planar2_real q[2] = {-0x1.90da633eaac2ep+0, -0x1.5e147f89d9f9ap+0};
    static const planar2_real v[2] = {0x1.0388dae9fff2p+0, -0x1.78aca93578354p-1};
    static const planar2_real a[2] = {0x1.d34c7769b190ap+0, 0x1.1a4fae8467f8p-6};
    static const planar2_real u_expected[2] = {-0x1.ccf8a64ecf548p+1, -0x1.e2fe00e5bfdeap-3};
    planar2_real u[2];
    int failures = 0;

    planar2_inverse_dynamics(q, v, a, u);
    failures += compare(tell, "inverse_dynamics", 2, u, u_expected, PLANAR2_INVERSE_DYNAMICS_TOLERANCE);
    return failures;
}

static int case_7(listener *tell)
{
    static const planar2_real q[2] = {-0x1.e4eb2ffed137ep+0, 0x1.33766e7e7bb1p+0};
    static const planar2_real out_expected[4] = {0x1.dc84cd85699c8p-3, 0x1.b9099b0ad339p-5,
        0x1.b9099b0ad339p-5, 0x1p-5};
    planar2_real out[4];
    int failures = 0;

    planar2_mass_matrix(q, out);
    failures += compare(tell, "mass_matrix", 4, out, out_expected, PLANAR2_MASS_MATRIX_TOLERANCE);
    return failures;
}

static int case_8(listener *tell)
{
    static const planar2_real q[2] = {0x1.5e93675fa029p+0, -0x1.3cbf3faa07836p+0};
    static const planar2_real out_expected[4] = {0x1.d3cd8b83c907bp-3, 0x1.a79b1707920f5p-5,
        0x1.a79b1707920f5p-5, 0x1p-5};
    planar2_real out[4];
    int failures = 0;

    planar2_mass_matrix(q, out);
    failures += compare(tell, "mass_matrix", 4, out, out_expected, PLANAR2_MASS_MATRIX_TOLERANCE);
    return failures;
}

static int case_9(listener *tell)
{
    static const planar2_real q[2] = {-0x1.bfc8817baa4d2p+0, 0x1.9b0f53f23ac1ep+0};
    static const planar2_real out_expected[4] = {0x1.7710d83d7c4c9p-3, 0x1.dc4360f5f1322p-6,
        0x1.dc4360f5f1322p-6, 0x1p-5};
    planar2_real out[4];
    int failures = 0;

    planar2_mass_matrix(q, out);
    failures += compare(tell, "mass_matrix", 4, out, out_expected, PLANAR2_MASS_MATRIX_TOLERANCE);
    return failures;
}

static int case_10(listener *tell)
{
    static const planar2_real q[2] = {-0x1.e9516c30eb244p-1, 0x1.698ef30a157bp-2};
    static const planar2_real v[2] = {0x1.5c0291d7f6f36p+0, -0x1.4bbbc8a919522p+0};
    static const planar2_real out_expected[2] = {0x1.4677938fbdfe9p-5, 0x1.472ecb7f18e4dp-5};
    planar2_real out[2];
    int failures = 0;

    planar2_coriolis(q, v, out);
    failures += compare(tell, "coriolis", 2, out, out_expected, PLANAR2_CORIOLIS_TOLERANCE);
    return failures;
}

static int case_11(listener *tell)
{
    static const planar2_real q[2] = {0x1.a630ed60e4996p+0, 0x1.ce0c340dc37ep-4};
    static const planar2_real v[2] = {0x1.2f2b54beae63p-1, -0x1.0a2cea6a82136p+0};
    static const planar2_real out_expected[2] = {0x1.151a91a05c25p-10, 0x1.43509e5e9eabdp-9};
    planar2_real out[2];
    int failures = 0;

    planar2_coriolis(q, v, out);
    failures += compare(tell, "coriolis", 2, out, out_expected, PLANAR2_CORIOLIS_TOLERANCE);
    return failures;
}

static int case_12(listener *tell)
{
    static const planar2_real q[2] = {0x1.a774065d46d62p+0, 0x1.cfc891993681p-1};
    static const planar2_real v[2] = {-0x1.faa20a79f3cap-2, 0x1.7dbf44fa305b4p-1};
    static const planar2_real out_expected[2] = {0x1.251a05e277c08p-7, 0x1.8a8224d78a419p-7};
    planar2_real out[2];
    int failures = 0;

    planar2_coriolis(q, v, out);
    failures += compare(tell, "coriolis", 2, out, out_expected, PLANAR2_CORIOLIS_TOLERANCE);
    return failures;
}

static int case_13(listener *tell)
{
    static const planar2_real q[2] = {-0x1.84b7e07336368p-2, 0x1.98c0f2023d36p-1};
    static const planar2_real out_expected[2] = {-0x1.baaa16e0c903dp-1, 0x1.fe92247e2b338p-2};
    planar2_real out[2];
    int failures = 0;

    planar2_gravity_torque(q, out);
    failures += compare(tell, "gravity_torque", 2, out, out_expected, PLANAR2_GRAVITY_TORQUE_TOLERANCE);
    return failures;
}

static int case_14(listener *tell)
{
    static const planar2_real q[2] = {-0x1.ffbd2563b0638p-2, 0x1.e76a84c6680e8p+0};
    static const planar2_real out_expected[2] = {-0x1.1b6f9e7cce5ffp-1, 0x1.35933349867fbp+0};
    planar2_real out[2];
    int failures = 0;

    planar2_gravity_torque(q, out);
    failures += compare(tell, "gravity_torque", 2, out, out_expected, PLANAR2_GRAVITY_TORQUE_TOLERANCE);
    return failures;
}

static int case_15(listener *tell)
{
    static const planar2_real q[2] = {-0x1.1ce22f0a8beaap+0, -0x1.e23f04cf665dp-1};
    static const planar2_real out_expected[2] = {-0x1.18a5b0061db58p+2, -0x1.15e020747a65fp+0};
    planar2_real out[2];
    int failures = 0;

    planar2_gravity_torque(q, out);
    failures += compare(tell, "gravity_torque", 2, out, out_expected, PLANAR2_GRAVITY_TORQUE_TOLERANCE);
    return failures;
}

static int case_16(listener *tell)
{
    static const planar2_real q[2] = {-0x1.88e2a6a0086cep+0, 0x1.3eabb1efe292p-1};
    static const planar2_real v[2] = {-0x1.705419a663554p+0, 0x1.8257cdfe5491ep+0};
    static const planar2_real kinetic_expected[1] = {0x1.40d84029cfdc3p-3};
    static const planar2_real potential_expected[1] = {-0x1.c425f2d6c2e6bp-1};
    planar2_real kinetic;
    planar2_real potential;
    int failures = 0;

    planar2_energy(q, v, &kinetic, &potential);
    failures += compare(tell, "energy, kinetic", 1, &kinetic, kinetic_expected, PLANAR2_ENERGY_TOLERANCE);
    failures += compare(tell, "energy, potential", 1, &potential, potential_expected,
        PLANAR2_ENERGY_TOLERANCE);
    return failures;
}

static int case_17(listener *tell)
{
    static const planar2_real q[2] = {-0x1.45e4b0ea610ap-3, 0x1.2790a8fe8a932p+0};
    static const planar2_real v[2] = {-0x1.8a7932865caf8p-2, 0x1.6ed2332a9063ap+0};
    static const planar2_real kinetic_expected[1] = {0x1.2fd70c70c1738p-6};
    static const planar2_real potential_expected[1] = {-0x1.132b8dd9df81dp+2};
    planar2_real kinetic;
    planar2_real potential;
    int failures = 0;

    planar2_energy(q, v, &kinetic, &potential);
    failures += compare(tell, "energy, kinetic", 1, &kinetic, kinetic_expected, PLANAR2_ENERGY_TOLERANCE);
    failures += compare(tell, "energy, potential", 1, &potential, potential_expected,
        PLANAR2_ENERGY_TOLERANCE);
    return failures;
}

static int case_18(listener *tell)
{
    static const planar2_real q[2] = {0x1.0518f9e2ce68p-4, 0x1.dfd40a07e85cep+0};
    static const planar2_real v[2] = {0x1.2d8e4b3849758p+0, -0x1.4ad9d2ab9193ep+0};
    static const planar2_real kinetic_expected[1] = {0x1.c72ce73f2769p-4};
    static const planar2_real potential_expected[1] = {-0x1.9d90286359513p+1};
    planar2_real kinetic;
    planar2_real potential;
    int failures = 0;

    planar2_energy(q, v, &kinetic, &potential);
    failures += compare(tell, "energy, kinetic", 1, &kinetic, kinetic_expected, PLANAR2_ENERGY_TOLERANCE);
    failures += compare(tell, "energy, potential", 1, &potential, potential_expected,
        PLANAR2_ENERGY_TOLERANCE);
    return failures;
}

static int case_19(listener *tell)
{
    static const planar2_real q[2] = {0x1.06adef84c3b14p-1, 0x1.3a05206950238p-2};
    static const planar2_real out_expected[4] = {0x1.f69cf7d06be2p-4, 0x1.be14f3282eed5p-3,
        0x1.b66db55107a1ap-2, 0x1.36648b12df91fp-1};
    planar2_real out[4];
    int failures = 0;

    planar2_positions(q, out);
    failures += compare(tell, "positions", 4, out, out_expected, PLANAR2_POSITIONS_TOLERANCE);
    return failures;
}

static int case_20(listener *tell)
{
    static const planar2_real q[2] = {-0x1.7e0fed0bb6ebcp-1, -0x1.c094f37fe7834p+0};
    static const planar2_real out_expected[4] = {-0x1.5b94250969e96p-3, 0x1.77f161081f986p-3,
        -0x1.f518f3c68007bp-2, 0x1.5629fb78029f1p-3};
    planar2_real out[4];
    int failures = 0;

    planar2_positions(q, out);
    failures += compare(tell, "positions", 4, out, out_expected, PLANAR2_POSITIONS_TOLERANCE);
    return failures;
}

static int case_21(listener *tell)
{
    static const planar2_real q[2] = {0x1.69718fbb3f9ep-3, -0x1.982abb9796978p-2};
    static const planar2_real out_expected[4] = {0x1.6791f794e925ep-5, 0x1.f80c0511b01fdp-3,
        0x1.0bfb315ad85f1p-5, 0x1.78e106b6de4fcp-1};
    planar2_real out[4];
    int failures = 0;

    planar2_positions(q, out);
    failures += compare(tell, "positions", 4, out, out_expected, PLANAR2_POSITIONS_TOLERANCE);
    return failures;
}

static int case_22(listener *tell)
{
    static const planar2_real s[2] = {0x1p+0, 0x1p+0};
    static const planar2_real M_expected[4] = {0x1.4p-2, 0x1.8p-4, 0x1.8p-4, 0x1p-5};
    static const planar2_real G_expected[4] = {0x1.39eb851eb851fp+2, 0x1.39eb851eb851fp+0,
        0x1.39eb851eb851fp+0, 0x1.39eb851eb851fp+0};
    static const planar2_real B_expected[4] = {0x1p+0, 0.0, 0.0, 0x1p+0};
    planar2_real M[4];
    planar2_real G[4];
    planar2_real B[4];
    int failures = 0;

    planar2_linearization(s, M, G, B);
    failures += compare(tell, "linearization, M", 4, M, M_expected, PLANAR2_LINEARIZATION_TOLERANCE);
    failures += compare(tell, "linearization, G", 4, G, G_expected, PLANAR2_LINEARIZATION_TOLERANCE);
    failures += compare(tell, "linearization, B", 4, B, B_expected, PLANAR2_LINEARIZATION_TOLERANCE);
    return failures;
}

static int case_23(listener *tell)
{
    static const planar2_real s[2] = {-0x1p+0, 0x1p+0};
    static const planar2_real M_expected[4] = {0x1p-4, -0x1p-5, -0x1p-5, 0x1p-5};
    static const planar2_real G_expected[4] = {-0x1.39eb851eb851fp+1, 0x1.39eb851eb851fp+0,
        0x1.39eb851eb851fp+0, 0x1.39eb851eb851fp+0};
    static const planar2_real B_expected[4] = {0x1p+0, 0.0, 0.0, 0x1p+0};
    planar2_real M[4];
    planar2_real G[4];
    planar2_real B[4];
    int failures = 0;

    planar2_linearization(s, M, G, B);
    failures += compare(tell, "linearization, M", 4, M, M_expected, PLANAR2_LINEARIZATION_TOLERANCE);
    failures += compare(tell, "linearization, G", 4, G, G_expected, PLANAR2_LINEARIZATION_TOLERANCE);
    failures += compare(tell, "linearization, B", 4, B, B_expected, PLANAR2_LINEARIZATION_TOLERANCE);
    return failures;
}

static int case_24(listener *tell)
{
    static const planar2_real s[2] = {0x1p+0, 0x1p+0};
    static const planar2_real M_expected[4] = {0x1.4p-2, 0x1.8p-4, 0x1.8p-4, 0x1p-5};
    static const planar2_real G_expected[4] = {0x1.39eb851eb851fp+2, 0x1.39eb851eb851fp+0,
        0x1.39eb851eb851fp+0, 0x1.39eb851eb851fp+0};
    static const planar2_real B_expected[4] = {0x1p+0, 0.0, 0.0, 0x1p+0};
    planar2_real M[4];
    planar2_real G[4];
    planar2_real B[4];
    int failures = 0;

    planar2_linearization(s, M, G, B);
    failures += compare(tell, "linearization, M", 4, M, M_expected, PLANAR2_LINEARIZATION_TOLERANCE);
    failures += compare(tell, "linearization, G", 4, G, G_expected, PLANAR2_LINEARIZATION_TOLERANCE);
    failures += compare(tell, "linearization, B", 4, B, B_expected, PLANAR2_LINEARIZATION_TOLERANCE);
    return failures;
}

static int case_25(listener *tell)
{
    static const planar2_real q[2] = {-0x1.4b05e1f7be398p-2, -0x1.47d9c49ebd224p-1};
    static const planar2_real v[2] = {0x1.b4c1b4611d4dp+0, 0x1.0709f0234ec38p-2};
    static const planar2_real u[2] = {-0x1.671f4042a51f4p+0, 0x1.b4aae53b49696p+0};
    static const planar2_real slope_expected[2] = {0x1.ac90115d803a1p+5, -0x1.7777d93959744p+7};
    static const planar2_real dadq_direction[2] = {0x1.6ca8e983186ecp-2, -0x1.a03ca6aa43d58p-2};
    static const planar2_real dadv_direction[2] = {0x1.73b76b2fb26ep-2, 0x1.7a61d1addb3ecp-1};
    static const planar2_real dadu_direction[2] = {-0x1.60a688eff307ep-1, -0x1.4e3218e49e384p-2};
    planar2_real dadq[4];
    planar2_real dadv[4];
    planar2_real dadu[4];
    planar2_real slope[2];
    int failures = 0;

    planar2_state_jacobian(q, v, u, dadq, dadv, dadu);
    for (int i = 0; i < 2; ++i) {
        slope[i] = 0.0;
        for (int j = 0; j < 2; ++j) {
            slope[i] += dadq[2 * i + j] * dadq_direction[j];
        }
        for (int j = 0; j < 2; ++j) {
            slope[i] += dadv[2 * i + j] * dadv_direction[j];
        }
        for (int j = 0; j < 2; ++j) {
            slope[i] += dadu[2 * i + j] * dadu_direction[j];
        }
    }
    failures += compare(tell, "state_jacobian", 2, slope, slope_expected, PLANAR2_STATE_JACOBIAN_TOLERANCE);
    return failures;
}

static int case_26(listener *tell)
{
    static const planar2_real q[2] = {-0x1.7732a460f60bp-1, -0x1.b852a765f029ep+0};
    static const planar2_real v[2] = {0x1.30db2f8e3278p-3, -0x1.ebb4a7df4643ap+0};
    static const planar2_real u[2] = {0x1.c5afa94945d66p+0, -0x1.1d2ad0d8488cap+0};
    static const planar2_real slope_expected[2] = {0x1.b41fcfdd5bbd1p+2, 0x1.529fa1775b49ep-2};
    static const planar2_real dadq_direction[2] = {-0x1.d2ef333d20ba8p-2, -0x1.77b57a3e6fb0cp-2};
    static const planar2_real dadv_direction[2] = {-0x1.e81f29dfd9f1ap-1, -0x1.350f12132d088p-2};
    static const planar2_real dadu_direction[2] = {0x1.f69573a85fe38p-3, 0x1.adefecc5d44d8p-3};
    planar2_real dadq[4];
    planar2_real dadv[4];
    planar2_real dadu[4];
    planar2_real slope[2];
    int failures = 0;

    planar2_state_jacobian(q, v, u, dadq, dadv, dadu);
    for (int i = 0; i < 2; ++i) {
        slope[i] = 0.0;
        for (int j = 0; j < 2; ++j) {
            slope[i] += dadq[2 * i + j] * dadq_direction[j];
        }
        for (int j = 0; j < 2; ++j) {
            slope[i] += dadv[2 * i + j] * dadv_direction[j];
        }
        for (int j = 0; j < 2; ++j) {
            slope[i] += dadu[2 * i + j] * dadu_direction[j];
        }
    }
    failures += compare(tell, "state_jacobian", 2, slope, slope_expected, PLANAR2_STATE_JACOBIAN_TOLERANCE);
    return failures;
}

static int case_27(listener *tell)
{
    static const planar2_real q[2] = {-0x1.a04d18d7a919ap+0, -0x1.6f6bf404e310cp+0};
    static const planar2_real v[2] = {-0x1.0e8413cb0b7b8p-1, -0x1.35241de8445a4p+0};
    static const planar2_real u[2] = {0x1.67ac3f42985fcp+0, -0x1.aaedbbee19844p+0};
    static const planar2_real slope_expected[2] = {0x1.2767cc4ba31cap+5, -0x1.a553be7c573c4p+6};
    static const planar2_real dadq_direction[2] = {0x1.23ba35b380cfp-2, 0x1.f88103da5cb74p-1};
    static const planar2_real dadv_direction[2] = {-0x1.94d3d96b3f1a4p-2, 0x1.840822b72f4cep-1};
    static const planar2_real dadu_direction[2] = {0x1.3b7e9aea31e9p-1, -0x1.45bd5bc430176p-1};
    planar2_real dadq[4];
    planar2_real dadv[4];
    planar2_real dadu[4];
    planar2_real slope[2];
    int failures = 0;

    planar2_state_jacobian(q, v, u, dadq, dadv, dadu);
    for (int i = 0; i < 2; ++i) {
        slope[i] = 0.0;
        for (int j = 0; j < 2; ++j) {
            slope[i] += dadq[2 * i + j] * dadq_direction[j];
        }
        for (int j = 0; j < 2; ++j) {
            slope[i] += dadv[2 * i + j] * dadv_direction[j];
        }
        for (int j = 0; j < 2; ++j) {
            slope[i] += dadu[2 * i + j] * dadu_direction[j];
        }
    }
    failures += compare(tell, "state_jacobian", 2, slope, slope_expected, PLANAR2_STATE_JACOBIAN_TOLERANCE);
    return failures;
}

static int case_28(listener *tell)
{
    static const planar2_real amplitude[2] = {-0x1.8df70a74969ep+0, 0x1.0e4bb5acbc3bp-2};
    static const planar2_real out_expected[2] = {-0x1.07fd6b7b5544dp+2, -0x1.b9e679c93f348p-1};
    planar2_real out[2];
    int failures = 0;

    planar2_phi(amplitude, 0x1.afc2834adaa66p+0, out);
    failures += compare(tell, "phi", 2, out, out_expected, PLANAR2_PHI_TOLERANCE);
    return failures;
}

static int case_29(listener *tell)
{
    static const planar2_real amplitude[2] = {-0x1.1808ec91bffc4p+0, -0x1.623327f4cb67cp+0};
    static const planar2_real out_expected[2] = {-0x1.6e315e3abd368p+1, -0x1.c439cd59bdd4fp-1};
    planar2_real out[2];
    int failures = 0;

    planar2_phi(amplitude, 0x1.09fb2a999b9ffp+1, out);
    failures += compare(tell, "phi", 2, out, out_expected, PLANAR2_PHI_TOLERANCE);
    return failures;
}

static int case_30(listener *tell)
{
    static const planar2_real amplitude[2] = {-0x1.f71347ef64418p-2, -0x1.1250a4b69ce44p+0};
    static const planar2_real out_expected[2] = {-0x1.dd4931fa36d4p-2, -0x1.55b9e41e4b82bp-1};
    planar2_real out[2];
    int failures = 0;

    planar2_phi(amplitude, 0x1.ae9229f59a66dp+1, out);
    failures += compare(tell, "phi", 2, out, out_expected, PLANAR2_PHI_TOLERANCE);
    return failures;
}

static int case_31(listener *tell)
{
    static const planar2_real amplitude[2] = {-0x1.e3ed356141064p+0, 0x1.2d993c76865cep+0};
    static const planar2_real slope_expected[2] = {-0x1.4c9ab7cc4a4e2p+1, -0x1.32fd0d36fece5p-1};
    static const planar2_real out_direction[3] = {0x1.744d1ff9e4efcp-2, 0x1.04291c4543e14p-2,
        -0x1.42e5768bb40a4p-1};
    planar2_real out[6];
    planar2_real slope[2];
    int failures = 0;

    planar2_phi_jacobian(amplitude, 0x1.923bcfde6fc86p+1, out);
    for (int i = 0; i < 2; ++i) {
        slope[i] = 0.0;
        for (int j = 0; j < 3; ++j) {
            slope[i] += out[3 * i + j] * out_direction[j];
        }
    }
    failures += compare(tell, "phi_jacobian", 2, slope, slope_expected, PLANAR2_PHI_JACOBIAN_TOLERANCE);
    return failures;
}

static int case_32(listener *tell)
{
    static const planar2_real amplitude[2] = {0x1.39607ba7efe48p+0, 0x1.ca5dcb920ad98p-2};
    static const planar2_real slope_expected[2] = {-0x1.cbdf532b841ap-4, 0x1.5e2e25cd6dfa9p-4};
    static const planar2_real out_direction[3] = {-0x1.a541f77dd55e4p-2, 0x1.bdb781108258p-6,
        0x1.d937b66ecbf78p-3};
    planar2_real out[6];
    planar2_real slope[2];
    int failures = 0;

    planar2_phi_jacobian(amplitude, 0x1.a1b62cb89f182p+1, out);
    for (int i = 0; i < 2; ++i) {
        slope[i] = 0.0;
        for (int j = 0; j < 3; ++j) {
            slope[i] += out[3 * i + j] * out_direction[j];
        }
    }
    failures += compare(tell, "phi_jacobian", 2, slope, slope_expected, PLANAR2_PHI_JACOBIAN_TOLERANCE);
    return failures;
}

static int case_33(listener *tell)
{
    static const planar2_real amplitude[2] = {0x1.2db7943040eb8p-1, 0x1.2e5f40802f632p+0};
    static const planar2_real slope_expected[2] = {0x1.4b6f4b5abd04dp-1, 0x1.581a9d31eae2ap-2};
    static const planar2_real out_direction[3] = {-0x1.1109eb3d91224p-2, 0x1.91c826b591508p-2,
        -0x1.3e9b332131678p-2};
    planar2_real out[6];
    planar2_real slope[2];
    int failures = 0;

    planar2_phi_jacobian(amplitude, 0x1.e32cf9eaf2398p+1, out);
    for (int i = 0; i < 2; ++i) {
        slope[i] = 0.0;
        for (int j = 0; j < 3; ++j) {
            slope[i] += out[3 * i + j] * out_direction[j];
        }
    }
    failures += compare(tell, "phi_jacobian", 2, slope, slope_expected, PLANAR2_PHI_JACOBIAN_TOLERANCE);
    return failures;
}

static int case_34(listener *tell)
{
    static const planar2_real q[2] = {0x1.9b43393f2ed3p+0, -0x1.7954313543a34p-1};
    static const planar2_real v[2] = {0x1.c8af6567e0d6p-2, -0x1.d16bce1c7c18ep+0};
    static const planar2_real u[2] = {0x1.151b41cf138a8p+0, -0x1.cd69502135f7cp-1};
    static const planar2_real q_next_expected[2] = {0x1.9b4502441af4ep+0, -0x1.7962c1e4e1f0fp-1};
    static const planar2_real v_next_expected[2] = {0x1.c95a6a653ea37p-2, -0x1.d2c01370f8edbp+0};
    planar2_real q_next[2];
    planar2_real v_next[2];
    int failures = 0;

    planar2_step(0x1p-14, q, v, u, q_next, v_next);
    failures += compare(tell, "step, q_next", 2, q_next, q_next_expected, PLANAR2_STEP_TOLERANCE);
    failures += compare(tell, "step, v_next", 2, v_next, v_next_expected, PLANAR2_STEP_TOLERANCE);
    return failures;
}

static int case_35(listener *tell)
{
    static const planar2_real q[2] = {-0x1.18c75393c948p-4, -0x1.cf244357373d8p-1};
    static const planar2_real v[2] = {-0x1.25af1f474f3ep-4, 0x1.06dad56837fcap+0};
    static const planar2_real u[2] = {-0x1.0047dc1a53f8ep+0, -0x1.251b8ef1a4c14p-1};
    static const planar2_real q_next_expected[2] = {-0x1.18cbedd94571bp-4, -0x1.cf1c0aa1930eap-1};
    static const planar2_real v_next_expected[2] = {-0x1.2773a2ef23a72p-4, 0x1.07529421bd4b9p+0};
    planar2_real q_next[2];
    planar2_real v_next[2];
    int failures = 0;

    planar2_step(0x1p-14, q, v, u, q_next, v_next);
    failures += compare(tell, "step, q_next", 2, q_next, q_next_expected, PLANAR2_STEP_TOLERANCE);
    failures += compare(tell, "step, v_next", 2, v_next, v_next_expected, PLANAR2_STEP_TOLERANCE);
    return failures;
}

static int case_36(listener *tell)
{
    static const planar2_real q[2] = {0x1.51c815da96808p-1, 0x1.9777376f666c4p+0};
    static const planar2_real v[2] = {0x1.db91dea13d9e8p-2, 0x1.a4938e2ca8dbp-1};
    static const planar2_real u[2] = {0x1.39e28da032e26p+0, -0x1.131118ceaf89p+0};
    static const planar2_real q_next_expected[2] = {0x1.51cbcd04da8edp-1, 0x1.977a7e88e4d78p+0};
    static const planar2_real v_next_expected[2] = {0x1.db986163db422p-2, 0x1.a285f2d640184p-1};
    planar2_real q_next[2];
    planar2_real v_next[2];
    int failures = 0;

    planar2_step(0x1p-14, q, v, u, q_next, v_next);
    failures += compare(tell, "step, q_next", 2, q_next, q_next_expected, PLANAR2_STEP_TOLERANCE);
    failures += compare(tell, "step, v_next", 2, v_next, v_next_expected, PLANAR2_STEP_TOLERANCE);
    return failures;
}

/* A short motion, its end compared, and the way back to its start. */
static int motion_1(listener *tell)
{
    static const planar2_real q_start[2] = {-0x1.8cf9fdef2b47ap+0, -0x1.1eb427880bd16p+0};
    static const planar2_real v_start[2] = {-0x1.4671c7a22a0d8p-1, 0x1.24bbbeef6d8fap+0};
    static const planar2_real u[2] = {-0x1.0a3ce5592823cp-1, -0x1.b2a89e16cf9a4p+0};
    static const planar2_real q_expected[PLANAR2_NQ] = {-0x1.8c920e339bc7ep+0, -0x1.246c2ba5135e5p+0};
    static const planar2_real v_expected[PLANAR2_NV] = {0x1.745b5a6908ec6p-1, -0x1.45b4643534db6p+1};
    static planar2_workspace work;
    planar2_flow flow = {.tolerance = 0x1p-52, .work = &work};
    planar2_real q[PLANAR2_NQ];
    planar2_real v[PLANAR2_NV];
    int failures = 0;

    for (int i = 0; i < PLANAR2_NQ; ++i) {
        q[i] = q_start[i];
    }
    for (int i = 0; i < PLANAR2_NV; ++i) {
        v[i] = v_start[i];
    }
    failures += planar2_propagate(&flow, 0x1p-5, 1000000, u, q, v, NULL, 0, NULL, NULL, NULL) != PLANAR2_DONE;
    failures += compare(tell, "propagate, q", PLANAR2_NQ, q, q_expected, PLANAR2_PROPAGATE_TOLERANCE);
    failures += compare(tell, "propagate, v", PLANAR2_NV, v, v_expected, PLANAR2_PROPAGATE_TOLERANCE);
    failures += planar2_propagate(&flow, 0.0, 1000000, u, q, v, NULL, 0, NULL, NULL, NULL) != PLANAR2_DONE;
    failures += compare(tell, "propagate and back, q", PLANAR2_NQ, q, q_start, PLANAR2_PROPAGATE_TOLERANCE);
    failures += compare(tell, "propagate and back, v", PLANAR2_NV, v, v_start, PLANAR2_PROPAGATE_TOLERANCE);
    return failures;
}

/* All cases, in the order of their numbers. */
static int (*const cases[])(listener *tell) = {
    case_1,
    case_2,
    case_3,
    case_4,
    case_5,
    case_6,
    case_7,
    case_8,
    case_9,
    case_10,
    case_11,
    case_12,
    case_13,
    case_14,
    case_15,
    case_16,
    case_17,
    case_18,
    case_19,
    case_20,
    case_21,
    case_22,
    case_23,
    case_24,
    case_25,
    case_26,
    case_27,
    case_28,
    case_29,
    case_30,
    case_31,
    case_32,
    case_33,
    case_34,
    case_35,
    case_36,
    motion_1,
};
enum { case_count = (int)(sizeof cases / sizeof cases[0]) };

/* The number of the first case that fails, counted from 1; 0 where all pass. */
int planar2_selftest(void)
{
    for (int number = 0; number < case_count; ++number) {
        if (cases[number](0) != 0) {
            return number + 1;
        }
    }
    return 0;
}
#ifndef PLANAR2_NO_MAIN

static void print(const char *what, planar2_real error, planar2_real tolerance, int failed)
{
    printf("%-32s error %9.2e  tolerance %9.2e  %s\n", what, (double)error, (double)tolerance,
        failed ? "FAILED" : "passed");
}

int main(void)
{
    int failures = 0;

    for (int number = 0; number < case_count; ++number) {
        failures += cases[number](print);
    }
    printf("%s\n", failures ? "FAILED" : "all passed");
    return failures;
}
#endif
