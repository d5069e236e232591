/* Self-test of spatial2_cart.
 *
 * Every function is compared with the un-lowered Lagrangian in 50 digits, rounded once; Jacobians along
 * one direction each. Build it with spatial2_cart.c and run it: it says how each comparison ended, and the
 * exit code is the number of failures. On a target define SPATIAL2_CART_NO_MAIN and call
 * spatial2_cart_selftest from your own main: that needs nothing of the C library.
 */
#include "spatial2_cart.h"
#include <stddef.h>
#ifndef SPATIAL2_CART_NO_MAIN
#include <stdio.h>
#endif

int spatial2_cart_selftest(void);

/* Who is told of each comparison; a null pointer for nobody. */
typedef void listener(const char *what, spatial2_cart_real error, spatial2_cart_real tolerance, int failed);

/* The size of a number. */
static spatial2_cart_real size_of(spatial2_cart_real x)
{
    return x < 0.0 ? -x : x;
}

/* Largest error over largest expected entry; NaN fails. Returns the number of failures, 0 or 1. */
static int compare(listener *tell, const char *what, int count, const spatial2_cart_real *found,
    const spatial2_cart_real *expected, spatial2_cart_real tolerance)
{
    spatial2_cart_real worst = 0.0;
    spatial2_cart_real scale = 0.0;
    int failed = 0;

    for (int i = 0; i < count; ++i) {
        const spatial2_cart_real error = size_of(found[i] - expected[i]);

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
    static const spatial2_cart_real q[8] = {0x1.8c424893969ecp+0, 0x1.29e47012405dp+0, 0x1.6171fc70d1f41p-1,
        -0x1.54341b978dc13p-2, 0x1.4911712d454eap-1, -0x1.852535d355a5cp-1, -0x1.05d22bf2a05e5p-1,
        0x1.9aa80916d832p-2};
    static const spatial2_cart_real v[8] = {-0x1.9d07dcb7b22dp-1, -0x1.3c11f2126f494p+0,
        -0x1.b1459e2a181fdp+0, -0x1.f13a20cdaaa4ep+0, 0x1.a0af1929047ccp-1, -0x1.f48658791b172p-3,
        -0x1.c7a5cf53bf9cbp-1, -0x1.99152027cf549p+0};
    static const spatial2_cart_real u[2] = {0x1.124fa0cdb4664p+0, -0x1.70ea5ecdf3338p-2};
    static const spatial2_cart_real a_expected[8] = {0x1.d421ced3d5cddp+1, -0x1.73046f97725a2p+0,
        -0x1.bdf7c788ff4e5p+3, -0x1.e8912357b9e9dp+4, -0x1.a1845c267dde2p-1, -0x1.56f00e4dd3d07p+2,
        0x1.4fc0aec896615p+4, 0x1.09a488d098966p+4};
    spatial2_cart_real a[8];
    int failures = 0;

    spatial2_cart_forward_dynamics(q, v, u, a);
    failures += compare(tell, "forward_dynamics", 8, a, a_expected, SPATIAL2_CART_FORWARD_DYNAMICS_TOLERANCE);
    return failures;
}

static int case_2(listener *tell)
{
    static const spatial2_cart_real q[8] = {0x1.88580135fab58p+0, -0x1.984ddb7d5bc3ep+0, 0x1.65eed084d77b4p-2,
        -0x1.bcbd0608b8b6p-1, -0x1.67922198a5af7p-2, 0x1.64227dc6f33a5p-1, 0x1.5dba54c07ffafp-2,
        -0x1.43a099cd07233p-1};
    static const spatial2_cart_real v[8] = {0x1.cc2534237038ep+0, -0x1.53c0abcb7504p-5, 0x1.d3408266ede6cp-3,
        0x1.d50eba2534102p-2, -0x1.cfe089709fc31p-1, 0x1.34fb4d541d907p-5, -0x1.204b6256a4035p+1,
        -0x1.2ceb79b1f5acbp+0};
    static const spatial2_cart_real u[2] = {0x1.0ef3c3af04d34p+0, 0x1.4e8362bc7643cp-1};
    static const spatial2_cart_real a_expected[8] = {0x1.d71f5b8cb84dcp+0, 0x1.fe68b2a4de008p+0,
        -0x1.e0692e8f049cfp+4, -0x1.29a075a7200bfp+3, -0x1.b86680240bb69p+2, 0x1.a754afbf07b86p+2,
        -0x1.d7ee83d490b6fp-3, 0x1.c9e26c18571f6p+2};
    spatial2_cart_real a[8];
    int failures = 0;

    spatial2_cart_forward_dynamics(q, v, u, a);
    failures += compare(tell, "forward_dynamics", 8, a, a_expected, SPATIAL2_CART_FORWARD_DYNAMICS_TOLERANCE);
    return failures;
}

static int case_3(listener *tell)
{
    static const spatial2_cart_real q[8] = {-0x1.fdefa563a0548p-2, 0x1.dd7c62f048f1p+0, 0x1.efef40382f63fp-5,
        0x1.6a96637594c93p-1, -0x1.68286107f23adp-1, 0x1.c0e105ef2592cp-3, -0x1.b5c96e0425abbp-1,
        -0x1.e1389415ea595p-2};
    static const spatial2_cart_real v[8] = {0x1.8d6977dc7b35p+0, 0x1.47eebf9e18ffp+0, 0x1.bbccc9136d933p-2,
        0x1.c284a937470e3p-3, 0x1.08f91cc138de4p-2, -0x1.65d66f82dbf5fp+0, -0x1.29125c8d9247ap-1,
        0x1.9d754adc2238dp-2};
    static const spatial2_cart_real u[2] = {-0x1.c4a045a374b1p-1, 0x1.800cbaafc722ep+0};
    static const spatial2_cart_real a_expected[8] = {-0x1.f341a24d5fff5p+0, 0x1.bd3e7bda4d529p-1,
        0x1.290cb58ab5d14p+4, -0x1.b957dd86630d9p+2, -0x1.560fd55092b88p+2, -0x1.191aed662261cp+5,
        -0x1.2ea20f40c985ep+2, -0x1.f236ef4ecee22p+2};
    spatial2_cart_real a[8];
    int failures = 0;

    spatial2_cart_forward_dynamics(q, v, u, a);
    failures += compare(tell, "forward_dynamics", 8, a, a_expected, SPATIAL2_CART_FORWARD_DYNAMICS_TOLERANCE);
    return failures;
}

static int case_4(listener *tell)
{
    static const spatial2_cart_real q[8] = {-0x1.7d3a97a93eff8p+0, 0x1.7b72368f02a86p+0, 0x1.e99af0bc16c7p-2,
        0x1.28ea8dbae30b5p-1, -0x1.51b8f092054bcp-1, -0x1.f9d1b606ed5c2p-3, -0x1.35f565393ef4dp-1,
        0x1.83666f5ae7c34p-1};
    static const spatial2_cart_real q_dot[8] = {0x1.2733a164507b8p-1, -0x1.7359bbd12d45cp+0,
        0x1.18a60c6277ecdp-1, 0x1.5a023ed471226p-1, 0x1.fba21df441456p-1, -0x1.8875dde8f1052p+0,
        0x1.adbfff978ec83p-1, 0x1.5e84a39ce99c1p-3};
    static const spatial2_cart_real u[2] = {0x1.b83c135ea7e88p+0, -0x1.4dda3ab96060cp-1};
    static const spatial2_cart_real q_ddot_expected[8] = {0x1.f7587cc70e14cp+0, -0x1.8ba10f3191419p+1,
        0x1.c0cc4ec9b792dp+1, 0x1.3c2c0e03390f2p+4, 0x1.68d8621f38202p+4, -0x1.0e28cf769b7fap+3,
        0x1.0dd0893d7764ep+1, -0x1.494b1eade7b52p+2};
    spatial2_cart_real q_ddot[8];
    int failures = 0;

    spatial2_cart_direction_dynamics(q, q_dot, u, q_ddot);
    failures += compare(tell, "direction_dynamics", 8, q_ddot, q_ddot_expected,
        SPATIAL2_CART_DIRECTION_DYNAMICS_TOLERANCE);
    return failures;
}

static int case_5(listener *tell)
{
    static const spatial2_cart_real q[8] = {0x1.40bd949c6597cp+0, -0x1.538ba33182176p+0,
        -0x1.358f67b8775c4p-1, 0x1.0407a6f39c317p-1, -0x1.3a2ac59e7fe3p-1, -0x1.2ad99b6487553p-2,
        -0x1.e9a3eb5619b3ep-1, -0x1.08e8e6816447p-6};
    static const spatial2_cart_real q_dot[8] = {-0x1.3066583bf1e3p+0, 0x1.683a172a89b38p+0,
        0x1.c36f265c4e752p-1, -0x1.3f45c7438662dp+0, -0x1.e6a9ae2b42f8p+0, 0x1.f759827a173b3p-3,
        -0x1.4ce4203f5260bp-4, 0x1.7ba071da3f55dp-2};
    static const spatial2_cart_real u[2] = {0x1.4654aadf368p-8, -0x1.5e79d9c10dd32p+0};
    static const spatial2_cart_real q_ddot_expected[8] = {0x1.25c11388ed7e8p-1, -0x1.9b17eb6b51736p+1,
        -0x1.b668e53a48ff3p+2, 0x1.bbbf7f252dd51p+3, 0x1.beb2c60bac86dp+4, 0x1.0400e418c5967p+3,
        -0x1.31a06bb2d892ep+1, 0x1.cd8ecfa442a82p+2};
    spatial2_cart_real q_ddot[8];
    int failures = 0;

    spatial2_cart_direction_dynamics(q, q_dot, u, q_ddot);
    failures += compare(tell, "direction_dynamics", 8, q_ddot, q_ddot_expected,
        SPATIAL2_CART_DIRECTION_DYNAMICS_TOLERANCE);
    return failures;
}

static int case_6(listener *tell)
{
    static const spatial2_cart_real q[8] = {0x1.47698b60bea72p+0, 0x1.5182992551868p-2, -0x1.2b8d935033031p-4,
        0x1.60c0d5c0f61p-4, 0x1.fcb8b93e4bc6bp-1, -0x1.8c74f5437ed2fp-1, -0x1.c3a313253eb01p-4,
        0x1.3f07272bedcbdp-1};
    static const spatial2_cart_real q_dot[8] = {-0x1.a3bb5845c0e5cp+0, -0x1.fca31faec0e9cp+0,
        0x1.ff4daed0e61dbp-1, 0x1.a6092d144c5dap+0, -0x1.1c3729543a987p-4, 0x1.0bad01076782p-1,
        0x1.006b71ebeec72p-4, 0x1.525038f914d7ep-1};
    static const spatial2_cart_real u[2] = {0x1.b1f6f6675b486p+0, 0x1.6e4d7aad3beb8p-1};
    static const spatial2_cart_real q_ddot_expected[8] = {0x1.81d37516c98aap+1, 0x1.dfadc44c5759cp+0,
        -0x1.ccfb6069502f4p+3, -0x1.601b27687b8c2p+3, -0x1.ecdc31c232078p+1, 0x1.d038117e01f77p+4,
        0x1.4ac77b35d275ap+3, 0x1.25e951be464a3p+5};
    spatial2_cart_real q_ddot[8];
    int failures = 0;

    spatial2_cart_direction_dynamics(q, q_dot, u, q_ddot);
    failures += compare(tell, "direction_dynamics", 8, q_ddot, q_ddot_expected,
        SPATIAL2_CART_DIRECTION_DYNAMICS_TOLERANCE);
    return failures;
}

static int case_7(listener *tell)
{
    static const spatial2_cart_real q[8] = {0x1.5eccd703703bep+0, -0x1.2311df709d78p+0, -0x1.86e3c9b1f7bd3p-1,
        0x1.143864a7d153dp-4, 0x1.48df51b584bc2p-1, 0x1.1ef9399df026bp-2, 0x1.d4e0579d01606p-3,
        0x1.dd4cc8f0dd928p-1};
    static const spatial2_cart_real out_expected[64] = {0x1.999999999999ap-1, 0.0, 0.0, 0x1.d9937fe6aaa89p-5,
        -0x1.8dc1d89fbccaap-8, 0.0, 0x1.3178d285ac86cp-6, -0x1.2c14b2f3d7ebdp-8, 0.0, 0x1.999999999999ap-1,
        -0x1.d9937fe6aaa89p-5, 0.0, -0x1.1970cea918c5bp-4, -0x1.3178d285ac86cp-6, 0.0, 0x1.6f537cf31ee9ep-8,
        0.0, -0x1.d9937fe6aaa89p-5, 0x1.ba5e353f7ced9p-6, 0.0, 0.0, 0x1.e30dd9cdaec16p-9,
        -0x1.db9b83483a2bp-14, -0x1.1b220aa2ba3efp-10, 0x1.d9937fe6aaa89p-5, 0.0, 0.0, 0x1.ba5e353f7ced9p-6,
        0.0, 0x1.12eb207103d39p-10, 0x1.2ea653232680ep-9, -0x1.ce99f3b5f57cep-11, -0x1.8dc1d89fbccaap-8,
        -0x1.1970cea918c5bp-4, 0.0, 0.0, 0x1.ba5e353f7ced9p-6, 0x1.17db861d867c4p-8, -0x1.8b85103522e51p-12,
        -0x1.383dca03d6abp-10, 0.0, -0x1.3178d285ac86cp-6, 0x1.e30dd9cdaec16p-9, 0x1.12eb207103d39p-10,
        0x1.17db861d867c4p-8, 0x1.0624dd2f1a9fdp-8, 0.0, 0.0, 0x1.3178d285ac86cp-6, 0.0,
        -0x1.db9b83483a2bp-14, 0x1.2ea653232680ep-9, -0x1.8b85103522e51p-12, 0.0, 0x1.0624dd2f1a9fdp-8, 0.0,
        -0x1.2c14b2f3d7ebdp-8, 0x1.6f537cf31ee9ep-8, -0x1.1b220aa2ba3efp-10, -0x1.ce99f3b5f57cep-11,
        -0x1.383dca03d6abp-10, 0.0, 0.0, 0x1.0624dd2f1a9fdp-8};
    spatial2_cart_real out[64];
    int failures = 0;

    spatial2_cart_mass_matrix(q, out);
    failures += compare(tell, "mass_matrix", 64, out, out_expected, SPATIAL2_CART_MASS_MATRIX_TOLERANCE);
    return failures;
}

static int case_8(listener *tell)
{
    static const spatial2_cart_real q[8] = {-0x1.b12c94700b9cap+0, -0x1.9101eab61e932p+0,
        -0x1.933a7d988d242p-2, -0x1.5a608af1fc4a7p-1, -0x1.3e9eac76029d1p-1, -0x1.01e5c954025adp-4,
        -0x1.e427d68cf9917p-1, -0x1.46ca8396ad2fep-2};
    static const spatial2_cart_real out_expected[64] = {0x1.999999999999ap-1, 0.0, 0.0, -0x1.cad0029574675p-5,
        0x1.f2c876294256cp-5, 0.0, -0x1.a24ae5df95ffep-8, 0x1.35dc0e6eb4342p-6, 0.0, 0x1.999999999999ap-1,
        0x1.cad0029574675p-5, 0.0, -0x1.225312bfc1c82p-5, 0x1.a24ae5df95ffep-8, 0.0, -0x1.4a1be2fae44b5p-10,
        0.0, 0x1.cad0029574675p-5, 0x1.ba5e353f7ced9p-6, 0.0, 0.0, 0x1.49a468f53f439p-8,
        -0x1.0bfd4f0ac524ep-12, -0x1.ed07190f2efd4p-13, -0x1.cad0029574675p-5, 0.0, 0.0, 0x1.ba5e353f7ced9p-6,
        0.0, -0x1.24d6872861fb4p-9, 0x1.5f5cfb22283bbp-10, -0x1.cec8e3c9555b7p-9, 0x1.f2c876294256cp-5,
        -0x1.225312bfc1c82p-5, 0.0, 0.0, 0x1.ba5e353f7ced9p-6, -0x1.8b507c6f55127p-11, -0x1.53942f7bb2577p-10,
        0x1.054cc3abf5a76p-8, 0.0, 0x1.a24ae5df95ffep-8, 0x1.49a468f53f439p-8, -0x1.24d6872861fb4p-9,
        -0x1.8b507c6f55127p-11, 0x1.0624dd2f1a9fdp-8, 0.0, 0.0, -0x1.a24ae5df95ffep-8, 0.0,
        -0x1.0bfd4f0ac524ep-12, 0x1.5f5cfb22283bbp-10, -0x1.53942f7bb2577p-10, 0.0, 0x1.0624dd2f1a9fdp-8, 0.0,
        0x1.35dc0e6eb4342p-6, -0x1.4a1be2fae44b5p-10, -0x1.ed07190f2efd4p-13, -0x1.cec8e3c9555b7p-9,
        0x1.054cc3abf5a76p-8, 0.0, 0.0, 0x1.0624dd2f1a9fdp-8};
    spatial2_cart_real out[64];
    int failures = 0;

    spatial2_cart_mass_matrix(q, out);
    failures += compare(tell, "mass_matrix", 64, out, out_expected, SPATIAL2_CART_MASS_MATRIX_TOLERANCE);
    return failures;
}

static int case_9(listener *tell)
{
    static const spatial2_cart_real q[8] = {-0x1.fec15aba6f35p+0, -0x1.af637b3aa5dbp-3, 0x1.ae431713450ebp-2,
        0x1.a35392a330e79p-2, 0x1.9e9cefd402e98p-1, 0x1.e4c78ec56f476p-3, -0x1.42a4d7be5a26p-1,
        -0x1.7a9fefd3d8e16p-1};
    static const spatial2_cart_real out_expected[64] = {0x1.999999999999ap-1, 0.0, 0.0, 0x1.2a857979ed9dep-4,
        -0x1.2dea409e7521ap-5, 0.0, -0x1.e4a3c256d82acp-7, 0x1.9cfbf56e87decp-7, 0.0, 0x1.999999999999ap-1,
        -0x1.2a857979ed9dep-4, 0.0, 0x1.35c9e7a77966cp-5, 0x1.e4a3c256d82acp-7, 0.0, 0x1.364246e4c2194p-8,
        0.0, -0x1.2a857979ed9dep-4, 0x1.ba5e353f7ced9p-6, 0.0, 0.0, -0x1.50f1a8f8d9e54p-8,
        -0x1.30ebdb8afc409p-11, -0x1.2d7e6dd12e562p-10, 0x1.2a857979ed9dep-4, 0.0, 0.0, 0x1.ba5e353f7ced9p-6,
        0.0, 0x1.a076dda65e61bp-10, -0x1.88badce67468p-9, 0x1.91512ece22571p-9, -0x1.2dea409e7521ap-5,
        0x1.35c9e7a77966cp-5, 0.0, 0.0, 0x1.ba5e353f7ced9p-6, 0x1.e8b93e955b1a2p-10, 0x1.dc4d5843e3c9ap-10,
        -0x1.f2e2aae8107c8p-11, 0.0, 0x1.e4a3c256d82acp-7, -0x1.50f1a8f8d9e54p-8, 0x1.a076dda65e61bp-10,
        0x1.e8b93e955b1a2p-10, 0x1.0624dd2f1a9fdp-8, 0.0, 0.0, -0x1.e4a3c256d82acp-7, 0.0,
        -0x1.30ebdb8afc409p-11, -0x1.88badce67468p-9, 0x1.dc4d5843e3c9ap-10, 0.0, 0x1.0624dd2f1a9fdp-8, 0.0,
        0x1.9cfbf56e87decp-7, 0x1.364246e4c2194p-8, -0x1.2d7e6dd12e562p-10, 0x1.91512ece22571p-9,
        -0x1.f2e2aae8107c8p-11, 0.0, 0.0, 0x1.0624dd2f1a9fdp-8};
    spatial2_cart_real out[64];
    int failures = 0;

    spatial2_cart_mass_matrix(q, out);
    failures += compare(tell, "mass_matrix", 64, out, out_expected, SPATIAL2_CART_MASS_MATRIX_TOLERANCE);
    return failures;
}

static int case_10(listener *tell)
{
    static const spatial2_cart_real q[8] = {0x1.3fbbe14fcfc6p+0, -0x1.9840e060a0e78p-1, -0x1.c9eeb4824f03ep-2,
        0x1.de3e9838745f9p-2, -0x1.868ffbd65ad4fp-1, 0x1.ea9b59522682cp-3, -0x1.87e8d95ef807ap-1,
        0x1.31ca357f5dacfp-1};
    static const spatial2_cart_real v[8] = {-0x1.c59dcf10d82bep+0, 0x1.1d663930670cap+0, 0x1.6e280e2948d7ap-3,
        0x1.39faf5759c427p-5, -0x1.4d32fdb1cf5e7p-4, 0x1.0f52e4890f5ffp+0, -0x1.cfb2ffb7d9d2dp-1,
        -0x1.95f9108c20169p+0};
    static const spatial2_cart_real out_expected[8] = {-0x1.438f45bce93d8p-6, 0x1.10ab82955cd02p-4,
        0x1.0b50e0db748cep-7, -0x1.27c1c755ff57ep-9, -0x1.93f71dccb2372p-8, -0x1.3360fd8e409ap-14,
        0x1.5415166284a37p-16, 0x1.d0820e420d822p-15};
    spatial2_cart_real out[8];
    int failures = 0;

    spatial2_cart_coriolis(q, v, out);
    failures += compare(tell, "coriolis", 8, out, out_expected, SPATIAL2_CART_CORIOLIS_TOLERANCE);
    return failures;
}

static int case_11(listener *tell)
{
    static const spatial2_cart_real q[8] = {0x1.b5a1e6503dec8p+0, -0x1.4131bbff82774p+0, 0x1.3ce3ebe051968p-1,
        0x1.6871469bce587p-2, 0x1.6781a17e64d7ap-1, 0x1.78ef02b0c4a0fp-1, -0x1.106424dea9fa1p-2,
        -0x1.3e9d8d1fba289p-1};
    static const spatial2_cart_real v[8] = {0x1.48a004dec3a64p+0, -0x1.c2832dffc317p+0, 0x1.95076d2727608p+0,
        -0x1.21bdab6369543p-1, -0x1.1c64917b833bep+0, -0x1.4d4f72da55f57p-1, -0x1.a0e71222e7ac9p-2,
        -0x1.3136a79b7b928p-1};
    static const spatial2_cart_real out_expected[8] = {-0x1.eb615acb2c66ep-3, -0x1.f9e9cae022018p-4,
        0x1.7f9f7fc238c5ap-13, -0x1.4f2c7d3ddf46bp-8, 0x1.3ae98b0ffc328p-9, -0x1.9bd4263042537p-11,
        0x1.67d13713f43ecp-6, -0x1.5210e6e2fb397p-7};
    spatial2_cart_real out[8];
    int failures = 0;

    spatial2_cart_coriolis(q, v, out);
    failures += compare(tell, "coriolis", 8, out, out_expected, SPATIAL2_CART_CORIOLIS_TOLERANCE);
    return failures;
}

static int case_12(listener *tell)
{
    static const spatial2_cart_real q[8] = {0x1.a73a5ece73e08p-2, 0x1.6d87882b42d4p-5, 0x1.0b678e65c4717p-2,
        -0x1.e61fd4e7ad8a1p-1, 0x1.64ab71af5c37cp-3, -0x1.cf098616f815cp-2, -0x1.c34eefb4046fp-1,
        -0x1.16f7937ec112ap-3};
    static const spatial2_cart_real v[8] = {0x1.17d57eb353a34p-1, 0x1.b2b2050d20e58p-2, -0x1.737b34a9bcff1p-1,
        -0x1.0073b6aee8ff9p-6, 0x1.00a9d27c869fep+0, 0x1.95f4076f21b12p-1, -0x1.22a30800ae4f6p-1,
        0x1.0a900aae1056p+0};
    static const spatial2_cart_real out_expected[8] = {-0x1.2050a81f0f0dp-6, 0x1.558f139d86ef9p-3,
        -0x1.c4adf634456a3p-9, 0x1.146e5e63fe7dbp-11, 0x1.07e22d66af4fep-7, 0x1.54bd3eb750059p-9,
        -0x1.a025fd4d689afp-12, -0x1.8d424094dde54p-8};
    spatial2_cart_real out[8];
    int failures = 0;

    spatial2_cart_coriolis(q, v, out);
    failures += compare(tell, "coriolis", 8, out, out_expected, SPATIAL2_CART_CORIOLIS_TOLERANCE);
    return failures;
}

static int case_13(listener *tell)
{
    static const spatial2_cart_real q[8] = {0x1.8722ae4f94a4p+0, -0x1.f558241ac8196p+0, -0x1.8b6d37be63085p-3,
        0x1.f19704e957bdap-1, 0x1.146c8151603p-3, 0x1.57d7fbba21193p-1, -0x1.623fbe0284968p-9,
        0x1.7b5c060f7254fp-1};
    static const spatial2_cart_real out_expected[8] = {0.0, 0.0, -0x1.b75277b72edfdp-1, -0x1.5d1f46bee6f31p-3,
        0.0, 0x1.1603bd771f257p-11, 0x1.0dd938db98f3bp-3, 0.0};
    spatial2_cart_real out[8];
    int failures = 0;

    spatial2_cart_gravity_torque(q, out);
    failures += compare(tell, "gravity_torque", 8, out, out_expected, SPATIAL2_CART_GRAVITY_TORQUE_TOLERANCE);
    return failures;
}

static int case_14(listener *tell)
{
    static const spatial2_cart_real q[8] = {0x1.dde8b4f94f0dep+0, 0x1.7b97389c0b824p+0, 0x1.18341432d45dcp-2,
        -0x1.ec5326ddd74a5p-1, 0x1.6f5b8c42a64dcp-6, -0x1.15cea38a29b5dp-1, -0x1.93d57ebdaf57dp-1,
        -0x1.27dfa4a69289bp-2};
    static const spatial2_cart_real out_expected[8] = {0.0, 0.0, 0x1.b2ac6f7fd18fcp-1, 0x1.eec881429cc83p-3,
        0.0, 0x1.3cedcc1e7d86cp-3, -0x1.b40bd0c4ca467p-4, 0.0};
    spatial2_cart_real out[8];
    int failures = 0;

    spatial2_cart_gravity_torque(q, out);
    failures += compare(tell, "gravity_torque", 8, out, out_expected, SPATIAL2_CART_GRAVITY_TORQUE_TOLERANCE);
    return failures;
}

static int case_15(listener *tell)
{
    static const spatial2_cart_real q[8] = {-0x1.6e75965b2857p+0, 0x1.4703de66d296cp-1, 0x1.445f2470fdfdp-1,
        0x1.2e633b671698bp-1, -0x1.ffd0bf9985c1bp-2, 0x1.c067d92c227abp-1, 0x1.cce56c4ea6cabp-2,
        0x1.6519b36a18b95p-3};
    static const spatial2_cart_real out_expected[8] = {0.0, 0.0, -0x1.0afa6073fa048p-1, 0x1.1e63423f68a4ap-1,
        0.0, -0x1.69b619671867p-4, 0x1.5fe8a47f694b1p-3, 0.0};
    spatial2_cart_real out[8];
    int failures = 0;

    spatial2_cart_gravity_torque(q, out);
    failures += compare(tell, "gravity_torque", 8, out, out_expected, SPATIAL2_CART_GRAVITY_TORQUE_TOLERANCE);
    return failures;
}

static int case_16(listener *tell)
{
    static const spatial2_cart_real q[8] = {-0x1.ceab45148c028p+0, -0x1.6f72bc30bcb34p+0,
        0x1.401f2374284cbp-1, 0x1.b1c6d287e579fp-3, -0x1.8095e2f8206e4p-1, 0x1.b35845b25eb4bp-1,
        0x1.244fc63ce9f1bp-4, -0x1.0afd819af7d03p-1};
    static const spatial2_cart_real v[8] = {0x1.54fa339da50e8p-2, -0x1.499ea48b4f37ap+0,
        -0x1.5a9e975ecacd2p-1, 0x1.39a30eda06a64p-1, -0x1.90298b3280983p-2, 0x1.dca4bbbbd4861p-6,
        0x1.2bfa35d214243p+0, 0x1.a993b51028213p-3};
    static const spatial2_cart_real kinetic_expected[1] = {0x1.969bc08acfbf6p-1};
    static const spatial2_cart_real potential_expected[1] = {0x1.87ef1c0f49772p-1};
    spatial2_cart_real kinetic;
    spatial2_cart_real potential;
    int failures = 0;

    spatial2_cart_energy(q, v, &kinetic, &potential);
    failures += compare(tell, "energy, kinetic", 1, &kinetic, kinetic_expected,
        SPATIAL2_CART_ENERGY_TOLERANCE);
    failures += compare(tell, "energy, potential", 1, &potential, potential_expected,
        SPATIAL2_CART_ENERGY_TOLERANCE);
    return failures;
}

static int case_17(listener *tell)
{
    static const spatial2_cart_real q[8] = {0x1.0e46ecc040612p+0, -0x1.11e6082899bf4p-1, 0x1.287a87419c0d7p-4,
        0x1.15924ce00bc77p-4, -0x1.fd7a1712b68c4p-1, -0x1.b2a141c23da84p-2, -0x1.4337c8988b6d9p-1,
        0x1.4c567868b0bafp-1};
    static const spatial2_cart_real v[8] = {-0x1.06c63747330e4p+0, 0x1.5774d4437dd1ap+0, 0x1.35856c97a1d25p+0,
        0x1.a012b8601cdedp-2, 0x1.d9945dd05de36p-4, -0x1.629dccc7c241p-1, 0x1.b9492d6a5182ep+0,
        0x1.393c1d3aa1483p+0};
    static const spatial2_cart_real kinetic_expected[1] = {0x1.4ff3fd8a13df9p+0};
    static const spatial2_cart_real potential_expected[1] = {0x1.809ccc915b871p-1};
    spatial2_cart_real kinetic;
    spatial2_cart_real potential;
    int failures = 0;

    spatial2_cart_energy(q, v, &kinetic, &potential);
    failures += compare(tell, "energy, kinetic", 1, &kinetic, kinetic_expected,
        SPATIAL2_CART_ENERGY_TOLERANCE);
    failures += compare(tell, "energy, potential", 1, &potential, potential_expected,
        SPATIAL2_CART_ENERGY_TOLERANCE);
    return failures;
}

static int case_18(listener *tell)
{
    static const spatial2_cart_real q[8] = {-0x1.662109d09c56ep+0, 0x1.29cb3e99d3a2p-3, -0x1.7697573f2fdc2p-4,
        0x1.e203f8e568331p-1, 0x1.4c572feb016d2p-2, -0x1.fc5c3a17168cap-1, -0x1.4d11e9e695701p-5,
        -0x1.ca3492b2be22ap-4};
    static const spatial2_cart_real v[8] = {-0x1.df4baf8bde2e2p+0, 0x1.b9cd9a4043068p+0,
        -0x1.4fcc5891dc6ecp-1, 0x1.0ec197abb748cp-4, -0x1.81978f11c533bp-2, 0x1.ad4b35d326ca8p-3,
        0x1.41ea4f3016b52p-1, -0x1.0b64601fb31cbp+1};
    static const spatial2_cart_real kinetic_expected[1] = {0x1.5512cedf0e118p+1};
    static const spatial2_cart_real potential_expected[1] = {-0x1.0ef2d23da81ccp-2};
    spatial2_cart_real kinetic;
    spatial2_cart_real potential;
    int failures = 0;

    spatial2_cart_energy(q, v, &kinetic, &potential);
    failures += compare(tell, "energy, kinetic", 1, &kinetic, kinetic_expected,
        SPATIAL2_CART_ENERGY_TOLERANCE);
    failures += compare(tell, "energy, potential", 1, &potential, potential_expected,
        SPATIAL2_CART_ENERGY_TOLERANCE);
    return failures;
}

static int case_19(listener *tell)
{
    static const spatial2_cart_real q[8] = {0x1.aa2c70e92cefp-3, 0x1.653474249eaccp-1, 0x1.3cfc265746a5bp-1,
        0x1.670645d96e818p-1, 0x1.6a06fd00e9d19p-2, 0x1.99d3f40352314p-2, -0x1.1299625778124p-1,
        -0x1.7c75ad8a33dfdp-1};
    static const spatial2_cart_real out_expected[6] = {0x1.93471c428da7bp-2, 0x1.d0e989190ca06p-1,
        0x1.b26ec9344bc84p-4, 0x1.e53e4d10047e6p-2, 0x1.99fe0f078e365p-1, -0x1.5c9aff51a808ap-5};
    spatial2_cart_real out[6];
    int failures = 0;

    spatial2_cart_positions(q, out);
    failures += compare(tell, "positions", 6, out, out_expected, SPATIAL2_CART_POSITIONS_TOLERANCE);
    return failures;
}

static int case_20(listener *tell)
{
    static const spatial2_cart_real q[8] = {-0x1.ae507c06e011cp-1, 0x1.31f902b049332p+0, 0x1.53989eebf69b4p-3,
        -0x1.4cd1dcd237f57p-4, 0x1.f731f727bc22ep-1, 0x1.50d7044873636p-1, 0x1.bbfcd70074791p-3,
        0x1.7145e469454b4p-1};
    static const spatial2_cart_real out_expected[6] = {-0x1.94d83ce860c62p-1, 0x1.2bbb79bf8b59cp+0,
        0x1.2deac77e3dae8p-2, -0x1.517a08d9e34bdp-1, 0x1.36d4ff1f8e432p+0, 0x1.c1a0560ebfccap-2};
    spatial2_cart_real out[6];
    int failures = 0;

    spatial2_cart_positions(q, out);
    failures += compare(tell, "positions", 6, out, out_expected, SPATIAL2_CART_POSITIONS_TOLERANCE);
    return failures;
}

static int case_21(listener *tell)
{
    static const spatial2_cart_real q[8] = {0x1.bbc4c888ed0bp-2, 0x1.f043d377ab24p-5, 0x1.e30200b97b94bp-3,
        0x1.97508db022fd1p-1, -0x1.1dc21760d9a7p-1, -0x1.05bea8e844366p-1, -0x1.16b44de9873dap-1,
        -0x1.548684077e16ap-1};
    static const spatial2_cart_real out_expected[6] = {0x1.021c24525fca4p-1, 0x1.326c02a570c92p-2,
        -0x1.56e8e8da9ec86p-3, 0x1.9b859eae3de52p-2, 0x1.85e160900efa9p-3, -0x1.33aa42d6b506ep-2};
    spatial2_cart_real out[6];
    int failures = 0;

    spatial2_cart_positions(q, out);
    failures += compare(tell, "positions", 6, out, out_expected, SPATIAL2_CART_POSITIONS_TOLERANCE);
    return failures;
}

static int case_22(listener *tell)
{
    static const spatial2_cart_real s[2] = {0x1p+0, 0x1p+0};
    static const spatial2_cart_real M_expected[36] = {0x1.999999999999ap-1, 0.0, 0.0, 0x1.70a3d70a3d70ap-4,
        0.0, 0x1.47ae147ae147cp-6, 0.0, 0x1.999999999999ap-1, -0x1.70a3d70a3d70ap-4, 0.0,
        -0x1.47ae147ae147cp-6, 0.0, 0.0, -0x1.70a3d70a3d70ap-4, 0x1.ba5e353f7ced9p-6, 0.0,
        0x1.89374bc6a7efap-8, 0.0, 0x1.70a3d70a3d70ap-4, 0.0, 0.0, 0x1.ba5e353f7ced9p-6, 0.0,
        0x1.89374bc6a7efap-8, 0.0, -0x1.47ae147ae147cp-6, 0x1.89374bc6a7efap-8, 0.0, 0x1.0624dd2f1a9fdp-8,
        0.0, 0x1.47ae147ae147cp-6, 0.0, 0.0, 0x1.89374bc6a7efap-8, 0.0, 0x1.0624dd2f1a9fdp-8};
    static const spatial2_cart_real G_expected[36] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
        0.0, 0.0, 0.0, 0x1.c40b780346dc6p-1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0x1.c40b780346dc6p-1, 0.0, 0.0,
        0.0, 0.0, 0.0, 0.0, 0x1.91d14e3bcd35cp-3, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0x1.91d14e3bcd35cp-3};
    static const spatial2_cart_real B_expected[12] = {0x1p+0, 0.0, 0.0, 0x1p+0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
        0.0, 0.0};
    spatial2_cart_real M[36];
    spatial2_cart_real G[36];
    spatial2_cart_real B[12];
    int failures = 0;

    spatial2_cart_linearization(s, M, G, B);
    failures += compare(tell, "linearization, M", 36, M, M_expected, SPATIAL2_CART_LINEARIZATION_TOLERANCE);
    failures += compare(tell, "linearization, G", 36, G, G_expected, SPATIAL2_CART_LINEARIZATION_TOLERANCE);
    failures += compare(tell, "linearization, B", 12, B, B_expected, SPATIAL2_CART_LINEARIZATION_TOLERANCE);
    return failures;
}

static int case_23(listener *tell)
{
    static const spatial2_cart_real s[2] = {0x1p+0, -0x1p+0};
    static const spatial2_cart_real M_expected[36] = {0x1.999999999999ap-1, 0.0, 0.0, 0x1.70a3d70a3d70ap-4,
        0.0, -0x1.47ae147ae147cp-6, 0.0, 0x1.999999999999ap-1, -0x1.70a3d70a3d70ap-4, 0.0,
        0x1.47ae147ae147cp-6, 0.0, 0.0, -0x1.70a3d70a3d70ap-4, 0x1.ba5e353f7ced9p-6, 0.0,
        -0x1.89374bc6a7efap-8, 0.0, 0x1.70a3d70a3d70ap-4, 0.0, 0.0, 0x1.ba5e353f7ced9p-6, 0.0,
        -0x1.89374bc6a7efap-8, 0.0, 0x1.47ae147ae147cp-6, -0x1.89374bc6a7efap-8, 0.0, 0x1.0624dd2f1a9fdp-8,
        0.0, -0x1.47ae147ae147cp-6, 0.0, 0.0, -0x1.89374bc6a7efap-8, 0.0, 0x1.0624dd2f1a9fdp-8};
    static const spatial2_cart_real G_expected[36] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
        0.0, 0.0, 0.0, 0x1.c40b780346dc6p-1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0x1.c40b780346dc6p-1, 0.0, 0.0,
        0.0, 0.0, 0.0, 0.0, -0x1.91d14e3bcd35cp-3, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -0x1.91d14e3bcd35cp-3};
    static const spatial2_cart_real B_expected[12] = {0x1p+0, 0.0, 0.0, 0x1p+0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
        0.0, 0.0};
    spatial2_cart_real M[36];
    spatial2_cart_real G[36];
    spatial2_cart_real B[12];
    int failures = 0;

    spatial2_cart_linearization(s, M, G, B);
    failures += compare(tell, "linearization, M", 36, M, M_expected, SPATIAL2_CART_LINEARIZATION_TOLERANCE);
    failures += compare(tell, "linearization, G", 36, G, G_expected, SPATIAL2_CART_LINEARIZATION_TOLERANCE);
    failures += compare(tell, "linearization, B", 12, B, B_expected, SPATIAL2_CART_LINEARIZATION_TOLERANCE);
    return failures;
}

static int case_24(listener *tell)
{
    static const spatial2_cart_real s[2] = {0x1p+0, 0x1p+0};
    static const spatial2_cart_real M_expected[36] = {0x1.999999999999ap-1, 0.0, 0.0, 0x1.70a3d70a3d70ap-4,
        0.0, 0x1.47ae147ae147cp-6, 0.0, 0x1.999999999999ap-1, -0x1.70a3d70a3d70ap-4, 0.0,
        -0x1.47ae147ae147cp-6, 0.0, 0.0, -0x1.70a3d70a3d70ap-4, 0x1.ba5e353f7ced9p-6, 0.0,
        0x1.89374bc6a7efap-8, 0.0, 0x1.70a3d70a3d70ap-4, 0.0, 0.0, 0x1.ba5e353f7ced9p-6, 0.0,
        0x1.89374bc6a7efap-8, 0.0, -0x1.47ae147ae147cp-6, 0x1.89374bc6a7efap-8, 0.0, 0x1.0624dd2f1a9fdp-8,
        0.0, 0x1.47ae147ae147cp-6, 0.0, 0.0, 0x1.89374bc6a7efap-8, 0.0, 0x1.0624dd2f1a9fdp-8};
    static const spatial2_cart_real G_expected[36] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
        0.0, 0.0, 0.0, 0x1.c40b780346dc6p-1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0x1.c40b780346dc6p-1, 0.0, 0.0,
        0.0, 0.0, 0.0, 0.0, 0x1.91d14e3bcd35cp-3, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0x1.91d14e3bcd35cp-3};
    static const spatial2_cart_real B_expected[12] = {0x1p+0, 0.0, 0.0, 0x1p+0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
        0.0, 0.0};
    spatial2_cart_real M[36];
    spatial2_cart_real G[36];
    spatial2_cart_real B[12];
    int failures = 0;

    spatial2_cart_linearization(s, M, G, B);
    failures += compare(tell, "linearization, M", 36, M, M_expected, SPATIAL2_CART_LINEARIZATION_TOLERANCE);
    failures += compare(tell, "linearization, G", 36, G, G_expected, SPATIAL2_CART_LINEARIZATION_TOLERANCE);
    failures += compare(tell, "linearization, B", 12, B, B_expected, SPATIAL2_CART_LINEARIZATION_TOLERANCE);
    return failures;
}

static int case_25(listener *tell)
{
    static const spatial2_cart_real q[8] = {-0x1.ba18ce0d58786p+0, -0x1.8e28901ac28p-5, 0x1.b6a4e87c77ddcp-1,
        -0x1.92542b6831ce6p-2, 0x1.5628ad162d34fp-2, 0x1.8881129b628efp-1, 0x1.ad8c703a3de0bp-2,
        0x1.f1d23404a1538p-2};
    static const spatial2_cart_real v[8] = {0x1.763f71e4b3dd2p+0, 0x1.b4eb5cd3faf14p-1, -0x1.f8492305361e4p-4,
        0x1.c54ba46d76f98p-1, 0x1.5b50d235f3abfp+0, -0x1.7c80248d81f1ap-2, 0x1.f894a7cc4c77p-5,
        0x1.10cacac8a538ep-1};
    static const spatial2_cart_real u[2] = {0x1.897ffeb15664p-1, 0x1.da9773f9b7becp+0};
    static const spatial2_cart_real slope_expected[8] = {-0x1.55f981209502bp+0, -0x1.e447eaf2d4c0dp-2,
        -0x1.243d4bf96dbcap+3, 0x1.742199d59b165p+1, -0x1.71d2f79cd3131p-6, 0x1.a687a899102bfp+2,
        0x1.9a89ef41563a6p+3, -0x1.f813c4123b689p+1};
    static const spatial2_cart_real dadq_direction[8] = {0x1.b55498f3843dp-2, 0x1.60adc14aa7bep-4,
        -0x1.8699377ab7e3p-5, -0x1.c64027b6aa3a3p-3, -0x1.1bc2b7955e2b9p-3, -0x1.65fe137351a85p-1,
        0x1.4a02cbf495b44p-1, 0x1.17c30b3f981a2p-1};
    static const spatial2_cart_real dadv_direction[8] = {0x1.5521b47bd1fp-6, 0x1.baedf348aa156p-1,
        0x1.957f746796b61p-2, -0x1.6ce154cd43409p-5, 0x1.0a3ee92ed4451p-4, -0x1.f99df817cc9e7p-2,
        -0x1.f7fd4f2f7a8fbp-4, -0x1.520f87bf7e597p-2};
    static const spatial2_cart_real dadu_direction[2] = {-0x1.cf236e3ca0d4cp-2, -0x1.52c9ff7c5bbc8p-3};
    spatial2_cart_real dadq[64];
    spatial2_cart_real dadv[64];
    spatial2_cart_real dadu[16];
    spatial2_cart_real slope[8];
    int failures = 0;

    spatial2_cart_state_jacobian(q, v, u, dadq, dadv, dadu);
    for (int i = 0; i < 8; ++i) {
        slope[i] = 0.0;
        for (int j = 0; j < 8; ++j) {
            slope[i] += dadq[8 * i + j] * dadq_direction[j];
        }
        for (int j = 0; j < 8; ++j) {
            slope[i] += dadv[8 * i + j] * dadv_direction[j];
        }
        for (int j = 0; j < 2; ++j) {
            slope[i] += dadu[2 * i + j] * dadu_direction[j];
        }
    }
    failures += compare(tell, "state_jacobian", 8, slope, slope_expected,
        SPATIAL2_CART_STATE_JACOBIAN_TOLERANCE);
    return failures;
}

static int case_26(listener *tell)
{
    static const spatial2_cart_real q[8] = {0x1.88ffb23e67234p+0, 0x1.d6e3847f989fp-1, -0x1.0a7a6790df2cp-1,
        0x1.71fc59f5af251p-1, -0x1.d1ce7cfe97388p-2, -0x1.086140ce698ffp-3, 0x1.c1b4416909912p-1,
        -0x1.d75875c174a91p-2};
    static const spatial2_cart_real v[8] = {-0x1.3143912ec01a8p+0, -0x1.7caee0c67d9d8p-1,
        0x1.04d6514ad5fa9p-1, 0x1.0cc287e33920dp+0, 0x1.15ba35f921e06p+0, 0x1.f6db505958a03p-3,
        -0x1.2c7385f4f814p-9, -0x1.2bf87d56c19c6p-4};
    static const spatial2_cart_real u[2] = {0x1.7a0cec598a39p+0, 0x1.8b1cabf487b1p-3};
    static const spatial2_cart_real slope_expected[8] = {0x1.bf757a7ab9011p+0, -0x1.5c72b81b8c9b9p+0,
        -0x1.7239c407d9878p+4, 0x1.e88422e786c8p+4, -0x1.3891423732416p+2, 0x1.b73a2b3f96dc7p+1,
        -0x1.9e233fbe1a68p+3, -0x1.0d06b618bcd7dp+4};
    static const spatial2_cart_real dadq_direction[8] = {0x1.7cfe5eb7c4246p-1, -0x1.fe0130eef82fcp-1,
        -0x1.2f74764d2d912p-1, -0x1.8a2328ef615e6p-1, -0x1.16eb32536b485p-1, 0x1.17a7fd8b4eefdp+0,
        -0x1.7cf0df41ec8d2p-3, -0x1.5295ebc3d797bp-1};
    static const spatial2_cart_real dadv_direction[8] = {0x1.cbef175d6cfc8p-2, -0x1.d4fd793f39738p-2,
        -0x1.53e4cb5bae556p+0, 0x1.1ccf9f80e258dp+0, -0x1.d003793ffc008p-2, 0x1.61f9bece561b6p-5,
        -0x1.18d135a161d99p-2, 0x1.3a45ef5d59225p-3};
    static const spatial2_cart_real dadu_direction[2] = {0x1.073e12d98a844p-1, -0x1.daed5a702447ep-1};
    spatial2_cart_real dadq[64];
    spatial2_cart_real dadv[64];
    spatial2_cart_real dadu[16];
    spatial2_cart_real slope[8];
    int failures = 0;

    spatial2_cart_state_jacobian(q, v, u, dadq, dadv, dadu);
    for (int i = 0; i < 8; ++i) {
        slope[i] = 0.0;
        for (int j = 0; j < 8; ++j) {
            slope[i] += dadq[8 * i + j] * dadq_direction[j];
        }
        for (int j = 0; j < 8; ++j) {
            slope[i] += dadv[8 * i + j] * dadv_direction[j];
        }
        for (int j = 0; j < 2; ++j) {
            slope[i] += dadu[2 * i + j] * dadu_direction[j];
        }
    }
    failures += compare(tell, "state_jacobian", 8, slope, slope_expected,
        SPATIAL2_CART_STATE_JACOBIAN_TOLERANCE);
    return failures;
}

static int case_27(listener *tell)
{
    static const spatial2_cart_real q[8] = {-0x1.c825250e22f1ep+0, 0x1.5017551dd0168p+0, 0x1.f267d15047d7ap-1,
        -0x1.12a6b844a4437p-4, -0x1.c03caafd590b5p-3, 0x1.0e525aa58abbbp-6, -0x1.defb6a11abf2bp-1,
        0x1.69612bb33dda8p-2};
    static const spatial2_cart_real v[8] = {0x1.b1f490f740e08p+0, 0x1.db988ba0953p-1, -0x1.a5defb40048f6p-3,
        0x1.ae8c920a7cadap+0, -0x1.6e736ee5eeb5cp+0, -0x1.f9ac0ba975dbep-1, -0x1.72b17d85dd631p-1,
        -0x1.df819a9a1f347p+0};
    static const spatial2_cart_real u[2] = {-0x1.363c2eb25e86ep+0, 0x1.764e535de819ap+0};
    static const spatial2_cart_real slope_expected[8] = {-0x1.335943bc3e95p+0, -0x1.ee34d122d651p-2,
        -0x1.62056e0988a19p-1, -0x1.38a5d472e3eddp+0, 0x1.fa006e14384e7p-1, -0x1.1151453e3509ap-2,
        -0x1.339852c19dc08p+1, -0x1.0261698d05822p+3};
    static const spatial2_cart_real dadq_direction[8] = {0x1.7a71925c68d3ap-1, -0x1.367d0b38965ap-3,
        -0x1.dd57f41dd405cp-5, 0x1.11785fa8179adp-4, -0x1.1e54a0eb2e40ep-2, 0x1.e2f5092d591ep-1,
        -0x1.01276ebda16acp-5, -0x1.04bc539f0e9edp-3};
    static const spatial2_cart_real dadv_direction[8] = {0x1.f431af36af7cp-2, -0x1.7c69e1094cc4cp-1,
        -0x1.52893e23ce07ep-4, 0x1.5c9dc79c11215p+0, 0x1.9ca3c786e6509p+0, -0x1.d26df752fcap-2,
        -0x1.1b5468ea426a8p-1, 0x1.d0f9b5de42f6ap-2};
    static const spatial2_cart_real dadu_direction[2] = {-0x1.0e36bbff186ccp-2, -0x1.205ff432353ccp-2};
    spatial2_cart_real dadq[64];
    spatial2_cart_real dadv[64];
    spatial2_cart_real dadu[16];
    spatial2_cart_real slope[8];
    int failures = 0;

    spatial2_cart_state_jacobian(q, v, u, dadq, dadv, dadu);
    for (int i = 0; i < 8; ++i) {
        slope[i] = 0.0;
        for (int j = 0; j < 8; ++j) {
            slope[i] += dadq[8 * i + j] * dadq_direction[j];
        }
        for (int j = 0; j < 8; ++j) {
            slope[i] += dadv[8 * i + j] * dadv_direction[j];
        }
        for (int j = 0; j < 2; ++j) {
            slope[i] += dadu[2 * i + j] * dadu_direction[j];
        }
    }
    failures += compare(tell, "state_jacobian", 8, slope, slope_expected,
        SPATIAL2_CART_STATE_JACOBIAN_TOLERANCE);
    return failures;
}

static int case_28(listener *tell)
{
    static const spatial2_cart_real q[8] = {-0x1.e9c56dba2978p-4, -0x1.cfa8df82e172p-2, -0x1.99361db85b78bp-1,
        -0x1.c6f5e89d8c10dp-2, -0x1.9e73e2850b389p-2, 0x1.96b96c7818d73p-2, -0x1.b1ef92992e12ap-1,
        0x1.687c66a972283p-2};
    static const spatial2_cart_real v[8] = {0x1.12858c78fc8e8p-1, 0x1.f6d7789c3d528p+0, 0x1.eaec3d92cd173p-2,
        -0x1.a0992a8239706p+0, 0x1.adead8ff1e415p-1, 0x1.0530efb714379p+1, 0x1.bb0e9eee6538p-2,
        -0x1.42b8982b79007p+0};
    static const spatial2_cart_real u[2] = {-0x1.0a9f950404edap+0, -0x1.d2764921a4044p+0};
    static const spatial2_cart_real q_next_expected[8] = {-0x1.e9a31d545e092p-4, -0x1.cf8972656ea19p-2,
        -0x1.992ddd6072b75p-1, -0x1.c6fd8a91df6a6p-2, -0x1.9e8c1700ff398p-2, 0x1.96aac60a53d73p-2,
        -0x1.b1f9522c7bcd4p-1, 0x1.685dfbd167466p-2};
    static const spatial2_cart_real v_next_expected[8] = {0x1.1280d06def119p-1, 0x1.f6cc35d060bcap+0,
        0x1.ea328efcf08cep-2, -0x1.a032faae4d0c8p+0, 0x1.adc1d29f9f61ep-1, 0x1.0519a36b20e3bp+1,
        0x1.bb3b99fd7769ap-2, -0x1.4268f02d150c6p+0};
    spatial2_cart_real q_next[8];
    spatial2_cart_real v_next[8];
    int failures = 0;

    spatial2_cart_step(0x1p-14, q, v, u, q_next, v_next);
    failures += compare(tell, "step, q_next", 8, q_next, q_next_expected, SPATIAL2_CART_STEP_TOLERANCE);
    failures += compare(tell, "step, v_next", 8, v_next, v_next_expected, SPATIAL2_CART_STEP_TOLERANCE);
    return failures;
}

static int case_29(listener *tell)
{
    static const spatial2_cart_real q[8] = {-0x1.28ffd7d187614p-1, -0x1.7b0fbe6e59bap-4,
        -0x1.56d35d29503bep-1, -0x1.985a95e4ecba1p-5, -0x1.7b6cc1b0a8632p-1, -0x1.273640ba7e1f2p-1,
        0x1.38766baecc97p-1, 0x1.1623783e404ddp-1};
    static const spatial2_cart_real v[8] = {0x1.74efc58540036p+0, 0x1.c39ea382cadecp+0, -0x1.c94b7625e1424p+0,
        0x1.d089d6b6fc1a9p+0, 0x1.7defdd1fb93c4p+0, 0x1.487a920a39cf9p-4, 0x1.1fcfa52b6afc9p-1,
        -0x1.17bf9e765bc9bp-1};
    static const spatial2_cart_real u[2] = {0x1.12e3df579c3cp+0, 0x1.0dea154a2781p+0};
    static const spatial2_cart_real q_next_expected[8] = {-0x1.28f43025ae188p-1, -0x1.7a9ed5b0d039ap-4,
        -0x1.56dd87d8b5a2fp-1, -0x1.9983ed105c6ffp-5, -0x1.7b62515025fe1p-1, -0x1.273123d4fd37fp-1,
        0x1.387897a6c2807p-1, 0x1.162674d5de48dp-1};
    static const spatial2_cart_real v_next_expected[8] = {0x1.74fb30a905d0bp+0, 0x1.c3a748ccd10e9p+0,
        -0x1.c966e09a6facp+0, 0x1.d0fe809d3012ep+0, 0x1.7e00c762f06d9p+0, 0x1.49e1acfdc5bb4p-4,
        0x1.20232b3a090b8p-1, -0x1.17edceedce51ep-1};
    spatial2_cart_real q_next[8];
    spatial2_cart_real v_next[8];
    int failures = 0;

    spatial2_cart_step(0x1p-14, q, v, u, q_next, v_next);
    failures += compare(tell, "step, q_next", 8, q_next, q_next_expected, SPATIAL2_CART_STEP_TOLERANCE);
    failures += compare(tell, "step, v_next", 8, v_next, v_next_expected, SPATIAL2_CART_STEP_TOLERANCE);
    return failures;
}

static int case_30(listener *tell)
{
    static const spatial2_cart_real q[8] = {-0x1.853956b9f1dep-1, -0x1.a94c42d4d1f34p+0, 0x1.edd082a4a8b08p-2,
        0x1.c49417a05accbp-2, -0x1.8343c6f47b289p-1, 0x1.b3b061e217d11p-2, -0x1.aa8adfd3fbbbbp-2,
        -0x1.9b57d608ec6e4p-1};
    static const spatial2_cart_real v[8] = {0x1.8bde60b0c73acp+0, 0x1.83c9b0c7dbe1cp-1, -0x1.0423e65afe03fp-6,
        0x1.ec1b41a9ffa35p-1, 0x1.1a5e39238f9fep-1, -0x1.1ef74ecd7437p-5, 0x1.1995a62ca7d52p-2,
        -0x1.49fbac1a10c8fp-3};
    static const spatial2_cart_real u[2] = {0x1.e34c5ae22ee08p-1, 0x1.7dc055acf0df8p-1};
    static const spatial2_cart_real q_next_expected[8] = {-0x1.852cf7c24db19p-1, -0x1.a9493b413c1d1p+0,
        0x1.edc0fbc05f29p-2, 0x1.c498299b5e59dp-2, -0x1.8347898e0f62dp-1, 0x1.b3abc4f43de67p-2,
        -0x1.aa8c6f8badd8ep-2, -0x1.9b58a71c69afp-1};
    static const spatial2_cart_real v_next_expected[8] = {0x1.8bdf885cbc47ap+0, 0x1.83c9e4fe79dd7p-1,
        -0x1.e3c56d0bc8321p-7, 0x1.eb9fe82bd0253p-1, 0x1.1a733f6d7516ap-1, -0x1.2cdb36225de4bp-5,
        0x1.19c12723ab4bcp-2, -0x1.4bff915352d53p-3};
    spatial2_cart_real q_next[8];
    spatial2_cart_real v_next[8];
    int failures = 0;

    spatial2_cart_step(0x1p-14, q, v, u, q_next, v_next);
    failures += compare(tell, "step, q_next", 8, q_next, q_next_expected, SPATIAL2_CART_STEP_TOLERANCE);
    failures += compare(tell, "step, v_next", 8, v_next, v_next_expected, SPATIAL2_CART_STEP_TOLERANCE);
    return failures;
}

static int case_31(listener *tell)
{
    static const spatial2_cart_real q[8] = {0x1.4e5e0689a2edep+0, -0x1.125adf8f0f386p+0,
        -0x1.80f0434564aeap-1, 0x1.115204fb1aa3fp-6, 0x1.517b1e2f9e723p-1, 0x1.391ec284c962fp-1,
        0x1.2a8286a5f5473p-1, -0x1.11d892f0bb6p-1};
    static const spatial2_cart_real v[8] = {-0x1.1d472e4c306d2p+0, -0x1.0eb198b1d015p+0, 0x1.515e353afecf1p-1,
        -0x1.7d8adcc4b9f7ap+0, 0x1.941f5e6d146edp-1, -0x1.20ed1f8875e0dp+0, 0x1.4d5d171e8ff7ep-1,
        -0x1.2956a399c75fcp-1};
    static const spatial2_cart_real q_out_expected[8] = {0x1.4e5e0689a2edep+0, -0x1.125adf8f0f386p+0,
        -0x1.80f0434564aeap-1, 0x1.115204fb1aa3fp-6, 0x1.517b1e2f9e723p-1, 0x1.391ec284c962fp-1,
        0x1.2a8286a5f5473p-1, -0x1.11d892f0bb6p-1};
    static const spatial2_cart_real v_out_expected[8] = {-0x1.1d472e4c306d2p+0, -0x1.0eb198b1d015p+0,
        0x1.515e353afecf1p-1, -0x1.7d8adcc4b9f7ap+0, 0x1.941f5e6d146edp-1, -0x1.20ed1f8875e0dp+0,
        0x1.4d5d171e8ff7dp-1, -0x1.2956a399c75fbp-1};
    spatial2_cart_real q_out[8];
    spatial2_cart_real v_out[8];
    int failures = 0;

    spatial2_cart_project(q, v, q_out, v_out);
    failures += compare(tell, "project, q_out", 8, q_out, q_out_expected, SPATIAL2_CART_PROJECT_TOLERANCE);
    failures += compare(tell, "project, v_out", 8, v_out, v_out_expected, SPATIAL2_CART_PROJECT_TOLERANCE);
    return failures;
}

static int case_32(listener *tell)
{
    static const spatial2_cart_real q[8] = {-0x1.fa2e8d732de1p-3, -0x1.c64594767fd38p-2, 0x1.6664d25e040eap-1,
        0x1.3bb26bc52c385p-1, 0x1.70f657c7b6e97p-2, -0x1.b5191071479cap-4, 0x1.f12a556f1290ap-1,
        0x1.b5e92f1e19e9p-3};
    static const spatial2_cart_real v[8] = {0x1.e643ac965e508p-2, -0x1.64a0c490697a8p-2, 0x1.f38c8ffc8c1f3p-1,
        -0x1.fdbeb66cb0b9ep-2, -0x1.0b2991a825dbdp+0, 0x1.ff1de51627858p+0, -0x1.c2fd92794883p-5,
        0x1.3f15f76d462e8p+0};
    static const spatial2_cart_real q_out_expected[8] = {-0x1.fa2e8d732de1p-3, -0x1.c64594767fd38p-2,
        0x1.6664d25e040eap-1, 0x1.3bb26bc52c385p-1, 0x1.70f657c7b6e97p-2, -0x1.b5191071479cap-4,
        0x1.f12a556f1290ap-1, 0x1.b5e92f1e19e9p-3};
    static const spatial2_cart_real v_out_expected[8] = {0x1.e643ac965e508p-2, -0x1.64a0c490697a8p-2,
        0x1.f38c8ffc8c1f3p-1, -0x1.fdbeb66cb0b9fp-2, -0x1.0b2991a825dbdp+0, 0x1.ff1de51627858p+0,
        -0x1.c2fd927948833p-5, 0x1.3f15f76d462e8p+0};
    spatial2_cart_real q_out[8];
    spatial2_cart_real v_out[8];
    int failures = 0;

    spatial2_cart_project(q, v, q_out, v_out);
    failures += compare(tell, "project, q_out", 8, q_out, q_out_expected, SPATIAL2_CART_PROJECT_TOLERANCE);
    failures += compare(tell, "project, v_out", 8, v_out, v_out_expected, SPATIAL2_CART_PROJECT_TOLERANCE);
    return failures;
}

static int case_33(listener *tell)
{
    static const spatial2_cart_real q[8] = {-0x1.589b1d8106624p-1, 0x1.c92751e8ccc5p+0, -0x1.3640709b20478p-1,
        -0x1.31f79314d510ap-1, -0x1.0cd5a4b72ac51p-1, -0x1.fb362bbc684f9p-1, 0x1.d89de52e3404p-4,
        -0x1.2a4aca4c13217p-4};
    static const spatial2_cart_real v[8] = {-0x1.ae94fb476e9ep-2, 0x1.43a68324c596p-4, 0x1.9652871f6a538p-5,
        0x1.4bc782b532774p-1, -0x1.96e9e51d52ccbp-1, -0x1.16a2b13b8de05p-3, -0x1.d199e87a17b9fp-3,
        0x1.7d932d500bce9p+0};
    static const spatial2_cart_real q_out_expected[8] = {-0x1.589b1d8106624p-1, 0x1.c92751e8ccc5p+0,
        -0x1.3640709b20478p-1, -0x1.31f79314d510ap-1, -0x1.0cd5a4b72ac51p-1, -0x1.fb362bbc684f9p-1,
        0x1.d89de52e3404p-4, -0x1.2a4aca4c13217p-4};
    static const spatial2_cart_real v_out_expected[8] = {-0x1.ae94fb476e9ep-2, 0x1.43a68324c596p-4,
        0x1.9652871f6a535p-5, 0x1.4bc782b532774p-1, -0x1.96e9e51d52ccbp-1, -0x1.16a2b13b8de06p-3,
        -0x1.d199e87a17b9fp-3, 0x1.7d932d500bce9p+0};
    spatial2_cart_real q_out[8];
    spatial2_cart_real v_out[8];
    int failures = 0;

    spatial2_cart_project(q, v, q_out, v_out);
    failures += compare(tell, "project, q_out", 8, q_out, q_out_expected, SPATIAL2_CART_PROJECT_TOLERANCE);
    failures += compare(tell, "project, v_out", 8, v_out, v_out_expected, SPATIAL2_CART_PROJECT_TOLERANCE);
    return failures;
}

/* A short motion, its end compared, and the way back to its start. */
static int motion_1(listener *tell)
{
    static const spatial2_cart_real q_start[8] = {-0x1.0392227f66abp+0, -0x1.bde59e9054e9p+0,
        0x1.24dbeb5865476p-4, -0x1.f308d7ceeb824p-1, -0x1.b1edf23d8e336p-3, 0x1.31077d1a9e322p-1,
        0x1.21fa95b181727p-1, -0x1.239213d26d44ap-1};
    static const spatial2_cart_real v_start[8] = {-0x1.054fe340824d8p-1, -0x1.7cc6c4ada7ef4p+0,
        0x1.db9f9a853b939p+0, 0x1.c12cf805a35bp-4, 0x1.f5b6bcc976459p-4, 0x1.f6321595155a7p-1,
        -0x1.0ef486c36c4c8p+1, -0x1.14437e551d498p+0};
    static const spatial2_cart_real u[2] = {-0x1.9bae1310bfdp-3, 0x1.6cb5daa4749eep+0};
    static const spatial2_cart_real q_expected[SPATIAL2_CART_NQ] = {-0x1.0bedeedf6abccp+0,
        -0x1.d46210513f1ap+0, 0x1.4cd57cd15c8afp-4, -0x1.ec59866e6ba36p-1, -0x1.0c5d445230bdep-2,
        0x1.67e107315e3b1p-1, 0x1.196254b65e9efp-1, -0x1.ce671b98ac35ap-2};
    static const spatial2_cart_real v_expected[SPATIAL2_CART_NV] = {-0x1.11d0353939029p-1,
        -0x1.5197097c7ead1p+0, -0x1.a26e10e3fb29fp-3, -0x1.34c6b0badf162p-4, 0x1.b4c0c3427cf6dp-3,
        0x1.cd93bc8caa375p-1, -0x1.0d4de7ca001acp+1, -0x1.28473ef56b844p+0};
    static spatial2_cart_workspace work;
    spatial2_cart_flow flow = {.tolerance = 0x1p-52, .work = &work};
    spatial2_cart_real q[SPATIAL2_CART_NQ];
    spatial2_cart_real v[SPATIAL2_CART_NV];
    int failures = 0;

    for (int i = 0; i < SPATIAL2_CART_NQ; ++i) {
        q[i] = q_start[i];
    }
    for (int i = 0; i < SPATIAL2_CART_NV; ++i) {
        v[i] = v_start[i];
    }
    failures += spatial2_cart_propagate(&flow, 0x1p-4, 1000000, u, q, v, NULL, 0, NULL, NULL,
        NULL) != SPATIAL2_CART_DONE;
    failures += compare(tell, "propagate, q", SPATIAL2_CART_NQ, q, q_expected,
        SPATIAL2_CART_PROPAGATE_TOLERANCE);
    failures += compare(tell, "propagate, v", SPATIAL2_CART_NV, v, v_expected,
        SPATIAL2_CART_PROPAGATE_TOLERANCE);
    failures += spatial2_cart_propagate(&flow, 0.0, 1000000, u, q, v, NULL, 0, NULL, NULL,
        NULL) != SPATIAL2_CART_DONE;
    failures += compare(tell, "propagate and back, q", SPATIAL2_CART_NQ, q, q_start,
        SPATIAL2_CART_PROPAGATE_TOLERANCE);
    failures += compare(tell, "propagate and back, v", SPATIAL2_CART_NV, v, v_start,
        SPATIAL2_CART_PROPAGATE_TOLERANCE);
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
    motion_1,
};
enum { case_count = (int)(sizeof cases / sizeof cases[0]) };

/* The number of the first case that fails, counted from 1; 0 where all pass. */
int spatial2_cart_selftest(void)
{
    for (int number = 0; number < case_count; ++number) {
        if (cases[number](0) != 0) {
            return number + 1;
        }
    }
    return 0;
}
#ifndef SPATIAL2_CART_NO_MAIN

static void print(const char *what, spatial2_cart_real error, spatial2_cart_real tolerance, int failed)
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
