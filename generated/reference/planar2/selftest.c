/* Self-test of planar2.
 *
 * Every function is compared with the un-lowered Lagrangian in 50 digits, rounded once; Jacobians along one
 * direction each. Build it with planar2.c and run it: the exit code is the number of failures.
 */
#include "planar2.h"
#include <math.h>
#include <stdio.h>

/* Largest error over largest expected entry; NaN fails. Returns the number of failures, 0 or 1. */
static int compare(const char *what, int count, const planar2_real *found, const planar2_real *expected,
    planar2_real tolerance)
{
    planar2_real worst = 0.0;
    planar2_real scale = 0.0;
    int failed = 0;

    for (int i = 0; i < count; ++i) {
        const planar2_real error = fabs(found[i] - expected[i]);

        worst = error > worst ? error : worst;
        scale = fabs(expected[i]) > scale ? fabs(expected[i]) : scale;
        failed |= !(error >= 0.0);
    }
    if (scale > 0.0) {
        worst /= scale;
    }
    failed |= worst > tolerance;
    printf("%-32s error %9.2e  tolerance %9.2e  %s\n", what, (double)worst, (double)tolerance,
        failed ? "FAILED" : "passed");
    return failed;
}

static int case_1(void)
{
    static const planar2_real q[2] = {0x1.dd0717495f2ap-3, -0x1.e16442ead4f04p-1};
    static const planar2_real v[2] = {0x1.0909d5f98f9fp-1, 0x1.0dba7055a5efp-1};
    static const planar2_real u[2] = {-0x1.deb3739b4f514p+0, 0x1.a7a599d82a226p+0};
    static const planar2_real a_expected[2] = {-0x1.042795dbebc19p+6, 0x1.b93d5ef571d88p+7};
    planar2_real a[2];
    int failures = 0;

    planar2_forward_dynamics(q, v, u, a);
    failures += compare("forward_dynamics", 2, a, a_expected, PLANAR2_FORWARD_DYNAMICS_TOLERANCE);
    return failures;
}

static int case_2(void)
{
    static const planar2_real q[2] = {0x1.53decd0e8e6acp+0, 0x1.f533cf26c760cp+0};
    static const planar2_real v[2] = {0x1.7b8491aff572cp+0, -0x1.8eafaecbae1ep-1};
    static const planar2_real u[2] = {0x1.feb8b10e75eaep+0, -0x1.4ccefb37bdf04p-1};
    static const planar2_real a_expected[2] = {-0x1.383ba64192517p+3, -0x1.0daa3848ee097p+4};
    planar2_real a[2];
    int failures = 0;

    planar2_forward_dynamics(q, v, u, a);
    failures += compare("forward_dynamics", 2, a, a_expected, PLANAR2_FORWARD_DYNAMICS_TOLERANCE);
    return failures;
}

static int case_3(void)
{
    static const planar2_real q[2] = {-0x1.700e8b0d0a424p-1, 0x1.a7b7c74a237ccp-1};
    static const planar2_real v[2] = {0x1.e58f8a2065322p+0, 0x1.f662ec568da5cp-1};
    static const planar2_real u[2] = {-0x1.51970d772f098p-1, -0x1.bf4cc8309a06p-3};
    static const planar2_real a_expected[2] = {0x1.eedc9551267f6p+4, -0x1.6551ead872a62p+6};
    planar2_real a[2];
    int failures = 0;

    planar2_forward_dynamics(q, v, u, a);
    failures += compare("forward_dynamics", 2, a, a_expected, PLANAR2_FORWARD_DYNAMICS_TOLERANCE);
    return failures;
}

static int case_4(void)
{
    static const planar2_real q[2] = {0x1.2791da61157fcp-1, -0x1.0432a529964b8p+0};
    static const planar2_real v[2] = {-0x1.61ee4394f70c8p+0, -0x1.b8527d2eb09b4p-1};
    static const planar2_real a[2] = {-0x1.7e6205d6493fp-2, -0x1.819cca39c015p-3};
    static const planar2_real u_expected[2] = {0x1.8b9c3664c3c07p+0, -0x1.4e3328496a26ap-1};
    planar2_real u[2];
    int failures = 0;

    planar2_inverse_dynamics(q, v, a, u);
    failures += compare("inverse_dynamics", 2, u, u_expected, PLANAR2_INVERSE_DYNAMICS_TOLERANCE);
    return failures;
}

static int case_5(void)
{
    static const planar2_real q[2] = {0x1.fa8cc8bf1e96ep+0, 0x1.87bfea5ba58f8p+0};
    static const planar2_real v[2] = {0x1.f48f6fe0501cp-3, -0x1.6f2a29012ef56p+0};
    static const planar2_real a[2] = {-0x1.023b7796fe9a4p-1, 0x1.272fd825287ap-4};
    static const planar2_real u_expected[2] = {0x1.60e8a532dc3b5p+1, -0x1.ce565efda9bcfp-2};
    planar2_real u[2];
    int failures = 0;

    planar2_inverse_dynamics(q, v, a, u);
    failures += compare("inverse_dynamics", 2, u, u_expected, PLANAR2_INVERSE_DYNAMICS_TOLERANCE);
    return failures;
}

static int case_6(void)
{
    static const planar2_real q[2] = {0x1.0a8e3366ee288p-1, 0x1.e61b61defaebp-2};
    static const planar2_real v[2] = {-0x1.8742079a9cf5cp-1, 0x1.93804f595f86ep+0};
    static const planar2_real a[2] = {0x1.2b48c0c4bc31p-1, 0x1.a3b978b9f43p-1};
    static const planar2_real u_expected[2] = {0x1.8d16197ac880fp+1, 0x1.1f2eeca0ee583p+0};
    planar2_real u[2];
    int failures = 0;

    planar2_inverse_dynamics(q, v, a, u);
    failures += compare("inverse_dynamics", 2, u, u_expected, PLANAR2_INVERSE_DYNAMICS_TOLERANCE);
    return failures;
}

static int case_7(void)
{
    static const planar2_real q[2] = {0x1.36d9fd09215a4p+0, 0x1.e0ff965135ed8p-1};
    static const planar2_real out_expected[4] = {0x1.0b8cb9d25abcbp-2, 0x1.171973a4b5795p-4,
        0x1.171973a4b5795p-4, 0x1p-5};
    planar2_real out[4];
    int failures = 0;

    planar2_mass_matrix(q, out);
    failures += compare("mass_matrix", 4, out, out_expected, PLANAR2_MASS_MATRIX_TOLERANCE);
    return failures;
}

static int case_8(void)
{
    static const planar2_real q[2] = {-0x1.9c0c94cc009a6p+0, 0x1.ecb7cd444d5f6p+0};
    static const planar2_real out_expected[4] = {0x1.2748f470a1407p-3, 0x1.3a47a3850a034p-7,
        0x1.3a47a3850a034p-7, 0x1p-5};
    planar2_real out[4];
    int failures = 0;

    planar2_mass_matrix(q, out);
    failures += compare("mass_matrix", 4, out, out_expected, PLANAR2_MASS_MATRIX_TOLERANCE);
    return failures;
}

static int case_9(void)
{
    static const planar2_real q[2] = {0x1.1e3202c48bf4ap+0, -0x1.9c6e20ee981fp+0};
    static const planar2_real out_expected[4] = {0x1.75b24ac6ea8a6p-3, 0x1.d6c92b1baa297p-6,
        0x1.d6c92b1baa297p-6, 0x1p-5};
    planar2_real out[4];
    int failures = 0;

    planar2_mass_matrix(q, out);
    failures += compare("mass_matrix", 4, out, out_expected, PLANAR2_MASS_MATRIX_TOLERANCE);
    return failures;
}

static int case_10(void)
{
    static const planar2_real q[2] = {0x1.9ac5e11fceea8p-1, 0x1.405cc5a99b16p+0};
    static const planar2_real v[2] = {0x1.022c12e62146p-2, -0x1.dc55cd1c446p+0};
    static const planar2_real out_expected[2] = {-0x1.32b9294ed4d23p-3, 0x1.ee64773cb9deap-9};
    planar2_real out[2];
    int failures = 0;

    planar2_coriolis(q, v, out);
    failures += compare("coriolis", 2, out, out_expected, PLANAR2_CORIOLIS_TOLERANCE);
    return failures;
}

static int case_11(void)
{
    static const planar2_real q[2] = {-0x1.a5c69931f2158p-1, 0x1.5dda97ee118e8p-2};
    static const planar2_real v[2] = {0x1.565ffe313e5dep+0, -0x1.3a3da14fec5dp-2};
    static const planar2_real out_expected[2] = {0x1.f29d8cc00443ep-7, 0x1.32d4a11cb40e5p-5};
    planar2_real out[2];
    int failures = 0;

    planar2_coriolis(q, v, out);
    failures += compare("coriolis", 2, out, out_expected, PLANAR2_CORIOLIS_TOLERANCE);
    return failures;
}

static int case_12(void)
{
    static const planar2_real q[2] = {-0x1.1e14839298ab4p+0, -0x1.af4241f73e5dcp+0};
    static const planar2_real v[2] = {-0x1.aed333b3dde2p-4, 0x1.9502541402f34p+0};
    static const planar2_real out_expected[2] = {0x1.13faa6ee0f061p-3, -0x1.682cb835cfb2dp-11};
    planar2_real out[2];
    int failures = 0;

    planar2_coriolis(q, v, out);
    failures += compare("coriolis", 2, out, out_expected, PLANAR2_CORIOLIS_TOLERANCE);
    return failures;
}

static int case_13(void)
{
    static const planar2_real q[2] = {0x1.974063c184a98p+0, -0x1.68380f417eaap-2};
    static const planar2_real out_expected[2] = {0x1.3597f96924d7ep+2, 0x1.28cdb2ae2cf96p+0};
    planar2_real out[2];
    int failures = 0;

    planar2_gravity_torque(q, out);
    failures += compare("gravity_torque", 2, out, out_expected, PLANAR2_GRAVITY_TORQUE_TOLERANCE);
    return failures;
}

static int case_14(void)
{
    static const planar2_real q[2] = {-0x1.36d419db193f4p+0, 0x1.dc4d24326a96p-2};
    static const planar2_real out_expected[2] = {-0x1.1210e8823c05p+2, -0x1.ab8458dcea869p-1};
    planar2_real out[2];
    int failures = 0;

    planar2_gravity_torque(q, out);
    failures += compare("gravity_torque", 2, out, out_expected, PLANAR2_GRAVITY_TORQUE_TOLERANCE);
    return failures;
}

static int case_15(void)
{
    static const planar2_real q[2] = {-0x1.a5aed2ba23b48p-1, 0x1.f14b1bd8a9666p+0};
    static const planar2_real out_expected[2] = {-0x1.9874b2c7b6127p+0, 0x1.1a6a89c267438p+0};
    planar2_real out[2];
    int failures = 0;

    planar2_gravity_torque(q, out);
    failures += compare("gravity_torque", 2, out, out_expected, PLANAR2_GRAVITY_TORQUE_TOLERANCE);
    return failures;
}

static int case_16(void)
{
    static const planar2_real q[2] = {-0x1.86d59406b79b8p+0, 0x1.cef8e051d0126p+0};
    static const planar2_real v[2] = {0x1.7edb51ca056f8p+0, 0x1.482cb5c3c36dp-1};
    static const planar2_real kinetic_expected[1] = {0x1.97a1075a80462p-3};
    static const planar2_real potential_expected[1] = {-0x1.570e921c3fb61p+0};
    planar2_real kinetic;
    planar2_real potential;
    int failures = 0;

    planar2_energy(q, v, &kinetic, &potential);
    failures += compare("energy, kinetic", 1, &kinetic, kinetic_expected, PLANAR2_ENERGY_TOLERANCE);
    failures += compare("energy, potential", 1, &potential, potential_expected, PLANAR2_ENERGY_TOLERANCE);
    return failures;
}

static int case_17(void)
{
    static const planar2_real q[2] = {-0x1.df9b060d7849cp+0, 0x1.bbdb331df0ab4p-1};
    static const planar2_real v[2] = {0x1.29977567166eap+0, -0x1.7e4b97cea5e8ep+0};
    static const planar2_real kinetic_expected[1] = {0x1.77b4eded1232dp-4};
    static const planar2_real potential_expected[1] = {0x1.c34e8fbfc1479p-2};
    planar2_real kinetic;
    planar2_real potential;
    int failures = 0;

    planar2_energy(q, v, &kinetic, &potential);
    failures += compare("energy, kinetic", 1, &kinetic, kinetic_expected, PLANAR2_ENERGY_TOLERANCE);
    failures += compare("energy, potential", 1, &potential, potential_expected, PLANAR2_ENERGY_TOLERANCE);
    return failures;
}

static int case_18(void)
{
    static const planar2_real q[2] = {0x1.2a09e1bd8f17ep+0, -0x1.d07cb5b83d384p-1};
    static const planar2_real v[2] = {0x1.e444f7695d604p+0, 0x1.5e326bb1707p-2};
    static const planar2_real kinetic_expected[1] = {0x1.0a560a5c09c28p-1};
    static const planar2_real potential_expected[1] = {-0x1.5206609ebe572p+1};
    planar2_real kinetic;
    planar2_real potential;
    int failures = 0;

    planar2_energy(q, v, &kinetic, &potential);
    failures += compare("energy, kinetic", 1, &kinetic, kinetic_expected, PLANAR2_ENERGY_TOLERANCE);
    failures += compare("energy, potential", 1, &potential, potential_expected, PLANAR2_ENERGY_TOLERANCE);
    return failures;
}

static int case_19(void)
{
    static const planar2_real q[2] = {0x1.a12520cb4a8b6p+0, 0x1.1fd3efecd5aap-3};
    static const planar2_real out_expected[4] = {0x1.ff1e6ddaee789p-3, -0x1.e066d7a9db12fp-7,
        0x1.7d071efa548abp-1, -0x1.42c09b17102c8p-4};
    planar2_real out[4];
    int failures = 0;

    planar2_positions(q, out);
    failures += compare("positions", 4, out, out_expected, PLANAR2_POSITIONS_TOLERANCE);
    return failures;
}

static int case_20(void)
{
    static const planar2_real q[2] = {0x1.692e257c5f3dp-2, 0x1.5b07595f6c812p+0};
    static const planar2_real out_expected[4] = {0x1.61bcdda9c9085p-4, 0x1.e07afa7850394p-3,
        0x1.ae73e4362c861p-2, 0x1.bd642b1aca7efp-2};
    planar2_real out[4];
    int failures = 0;

    planar2_positions(q, out);
    failures += compare("positions", 4, out, out_expected, PLANAR2_POSITIONS_TOLERANCE);
    return failures;
}

static int case_21(void)
{
    static const planar2_real q[2] = {-0x1.d4a10c2b66c7ep+0, -0x1.64fa68f0f7c62p+0};
    static const planar2_real out_expected[4] = {-0x1.eed1df8567b35p-3, -0x1.0709ece92f77cp-4,
        -0x1.d97c2c856ba33p-2, -0x1.82a0fae96276p-2};
    planar2_real out[4];
    int failures = 0;

    planar2_positions(q, out);
    failures += compare("positions", 4, out, out_expected, PLANAR2_POSITIONS_TOLERANCE);
    return failures;
}

static int case_22(void)
{
    static const planar2_real s[2] = {0x1p+0, -0x1p+0};
    static const planar2_real M_expected[4] = {0x1p-4, -0x1p-5, -0x1p-5, 0x1p-5};
    static const planar2_real G_expected[4] = {0x1.39eb851eb851fp+1, -0x1.39eb851eb851fp+0,
        -0x1.39eb851eb851fp+0, -0x1.39eb851eb851fp+0};
    static const planar2_real B_expected[4] = {0x1p+0, 0.0, 0.0, 0x1p+0};
    planar2_real M[4];
    planar2_real G[4];
    planar2_real B[4];
    int failures = 0;

    planar2_linearization(s, M, G, B);
    failures += compare("linearization, M", 4, M, M_expected, PLANAR2_LINEARIZATION_TOLERANCE);
    failures += compare("linearization, G", 4, G, G_expected, PLANAR2_LINEARIZATION_TOLERANCE);
    failures += compare("linearization, B", 4, B, B_expected, PLANAR2_LINEARIZATION_TOLERANCE);
    return failures;
}

static int case_23(void)
{
    static const planar2_real s[2] = {-0x1p+0, -0x1p+0};
    static const planar2_real M_expected[4] = {0x1.4p-2, 0x1.8p-4, 0x1.8p-4, 0x1p-5};
    static const planar2_real G_expected[4] = {-0x1.39eb851eb851fp+2, -0x1.39eb851eb851fp+0,
        -0x1.39eb851eb851fp+0, -0x1.39eb851eb851fp+0};
    static const planar2_real B_expected[4] = {0x1p+0, 0.0, 0.0, 0x1p+0};
    planar2_real M[4];
    planar2_real G[4];
    planar2_real B[4];
    int failures = 0;

    planar2_linearization(s, M, G, B);
    failures += compare("linearization, M", 4, M, M_expected, PLANAR2_LINEARIZATION_TOLERANCE);
    failures += compare("linearization, G", 4, G, G_expected, PLANAR2_LINEARIZATION_TOLERANCE);
    failures += compare("linearization, B", 4, B, B_expected, PLANAR2_LINEARIZATION_TOLERANCE);
    return failures;
}

static int case_24(void)
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
    failures += compare("linearization, M", 4, M, M_expected, PLANAR2_LINEARIZATION_TOLERANCE);
    failures += compare("linearization, G", 4, G, G_expected, PLANAR2_LINEARIZATION_TOLERANCE);
    failures += compare("linearization, B", 4, B, B_expected, PLANAR2_LINEARIZATION_TOLERANCE);
    return failures;
}

static int case_25(void)
{
    static const planar2_real q[2] = {0x1.9ca42a898594ep+0, 0x1.81f7fa2ba2b4p-3};
    static const planar2_real v[2] = {-0x1.f5f7344285e38p-1, -0x1.ca6f3d001a808p-1};
    static const planar2_real u[2] = {-0x1.3293e055a2b5ep+0, -0x1.336605c2265d8p-2};
    static const planar2_real slope_expected[2] = {-0x1.953f7955af57ap+5, 0x1.5b3e22bbda0f7p+7};
    static const planar2_real dadq_direction[2] = {-0x1.837c1003adaf8p-3, -0x1.d5c9b750dcce6p-1};
    static const planar2_real dadv_direction[2] = {0x1.30c15053e48p-7, 0x1.512bb9cb2935p-4};
    static const planar2_real dadu_direction[2] = {0x1.95b256fa64de4p-1, 0x1.067678172413ap-1};
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
    failures += compare("state_jacobian", 2, slope, slope_expected, PLANAR2_STATE_JACOBIAN_TOLERANCE);
    return failures;
}

static int case_26(void)
{
    static const planar2_real q[2] = {0x1.a93fbbd4be3dcp-1, -0x1.325f1448b77bep+0};
    static const planar2_real v[2] = {-0x1.db76e6f766038p+0, 0x1.b32ab6e9346dcp-1};
    static const planar2_real u[2] = {0x1.7c10ada1be7b8p-2, 0x1.3bfd2b633b55p-1};
    static const planar2_real slope_expected[2] = {-0x1.bd76d1d315a0cp+3, 0x1.ca5a8e6daef16p+4};
    static const planar2_real dadq_direction[2] = {0x1.9a303649aaccp-4, 0x1.5cb3188eb23acp-2};
    static const planar2_real dadv_direction[2] = {-0x1.17a632eac0ab4p-1, -0x1.449ac2f5591c4p-1};
    static const planar2_real dadu_direction[2] = {-0x1.0831695601104p-2, -0x1.d87a223d3fcp-9};
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
    failures += compare("state_jacobian", 2, slope, slope_expected, PLANAR2_STATE_JACOBIAN_TOLERANCE);
    return failures;
}

static int case_27(void)
{
    static const planar2_real q[2] = {0x1.0af446c4f12cap+0, -0x1.c080a751bd36cp+0};
    static const planar2_real v[2] = {-0x1.7e9e043130d82p+0, -0x1.70086c307150ep+0};
    static const planar2_real u[2] = {0x1.32ba0202feff6p+0, 0x1.9f985449cfcf8p-2};
    static const planar2_real slope_expected[2] = {-0x1.0fb1c9d360842p+4, -0x1.c207099c9d4e6p+4};
    static const planar2_real dadq_direction[2] = {0x1.e63a810ebf404p-2, 0x1.5399c9ad2e54ep-1};
    static const planar2_real dadv_direction[2] = {-0x1.3d14d14df5bap-2, 0x1.cbba97e1a0edp-4};
    static const planar2_real dadu_direction[2] = {-0x1.fdc642a8f8c5cp-2, -0x1.c4a3559537b42p-1};
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
    failures += compare("state_jacobian", 2, slope, slope_expected, PLANAR2_STATE_JACOBIAN_TOLERANCE);
    return failures;
}

static int case_28(void)
{
    static const planar2_real amplitude[2] = {0x1.0a0949a41b2fcp-1, 0x1.68f22d7e40fecp+0};
    static const planar2_real out_expected[2] = {0x1.49879e78541cdp+1, 0x1.3e81697d397acp+0};
    planar2_real out[2];
    int failures = 0;

    planar2_phi(amplitude, 0x1.a3530b65569dp+0, out);
    failures += compare("phi", 2, out, out_expected, PLANAR2_PHI_TOLERANCE);
    return failures;
}

static int case_29(void)
{
    static const planar2_real amplitude[2] = {0x1.eb4c7eee8c2cp+0, 0x1.b2e0544652ea6p+0};
    static const planar2_real out_expected[2] = {-0x1.c8f6602ac201fp+1, -0x1.aa44f5bf05f3bp-2};
    planar2_real out[2];
    int failures = 0;

    planar2_phi(amplitude, 0x1.c3438213c8eb5p+1, out);
    failures += compare("phi", 2, out, out_expected, PLANAR2_PHI_TOLERANCE);
    return failures;
}

static int case_30(void)
{
    static const planar2_real amplitude[2] = {-0x1.e5e3c1ae362p-6, 0x1.05a838e73b694p+0};
    static const planar2_real out_expected[2] = {0x1.b0604c9120d62p-1, 0x1.072dbe61b7061p+0};
    planar2_real out[2];
    int failures = 0;

    planar2_phi(amplitude, 0x1.3aeddc9c315e5p+0, out);
    failures += compare("phi", 2, out, out_expected, PLANAR2_PHI_TOLERANCE);
    return failures;
}

static int case_31(void)
{
    static const planar2_real amplitude[2] = {-0x1.79209a6b1e45cp+0, 0x1.6da025fcb99dp+0};
    static const planar2_real slope_expected[2] = {-0x1.002cd1d207c6fp-1, 0x1.ae69190fe803ep-2};
    static const planar2_real out_direction[3] = {0x1.bc79d9c7c40e4p-1, 0x1.ad153b855f80ap-1,
        -0x1.53f8333f5a188p-3};
    planar2_real out[6];
    planar2_real slope[2];
    int failures = 0;

    planar2_phi_jacobian(amplitude, 0x1.8d6f874fad1fdp+1, out);
    for (int i = 0; i < 2; ++i) {
        slope[i] = 0.0;
        for (int j = 0; j < 3; ++j) {
            slope[i] += out[3 * i + j] * out_direction[j];
        }
    }
    failures += compare("phi_jacobian", 2, slope, slope_expected, PLANAR2_PHI_JACOBIAN_TOLERANCE);
    return failures;
}

static int case_32(void)
{
    static const planar2_real amplitude[2] = {0x1.7dee87f9d5be8p+0, -0x1.d39aa2cc4ef84p+0};
    static const planar2_real slope_expected[2] = {-0x1.2d32fa46a4b84p+0, -0x1.0466b3684d168p-3};
    static const planar2_real out_direction[3] = {0x1.a4793e25bb3e8p-1, -0x1.7f4034759e7dcp-1,
        0x1.ea995ef842dbap-1};
    planar2_real out[6];
    planar2_real slope[2];
    int failures = 0;

    planar2_phi_jacobian(amplitude, 0x1.3765d621ca95fp+1, out);
    for (int i = 0; i < 2; ++i) {
        slope[i] = 0.0;
        for (int j = 0; j < 3; ++j) {
            slope[i] += out[3 * i + j] * out_direction[j];
        }
    }
    failures += compare("phi_jacobian", 2, slope, slope_expected, PLANAR2_PHI_JACOBIAN_TOLERANCE);
    return failures;
}

static int case_33(void)
{
    static const planar2_real amplitude[2] = {-0x1.be2859f04d036p+0, 0x1.a87ee63e44482p+0};
    static const planar2_real slope_expected[2] = {0x1.0b72a9b952c1fp+0, 0x1.b386a27bede31p-2};
    static const planar2_real out_direction[3] = {0x1.a68357f5df9dap-1, -0x1.f1b6cf4a8137p-1,
        0x1.f01fb236b1ce2p-1};
    planar2_real out[6];
    planar2_real slope[2];
    int failures = 0;

    planar2_phi_jacobian(amplitude, 0x1.b0b24247a15e5p+1, out);
    for (int i = 0; i < 2; ++i) {
        slope[i] = 0.0;
        for (int j = 0; j < 3; ++j) {
            slope[i] += out[3 * i + j] * out_direction[j];
        }
    }
    failures += compare("phi_jacobian", 2, slope, slope_expected, PLANAR2_PHI_JACOBIAN_TOLERANCE);
    return failures;
}

static int case_34(void)
{
    static const planar2_real q[2] = {0x1.bfedb6d01aeacp+0, 0x1.71c9a23199cp-5};
    static const planar2_real v[2] = {-0x1.ddd224e9e35a4p+0, 0x1.0108e476e87ep+0};
    static const planar2_real u[2] = {-0x1.ca4a1c499e108p-1, -0x1.99fe2d8062c74p+0};
    static const planar2_real q_next_expected[2] = {0x1.bfe642344c4d1p+0, 0x1.7248cc341ca53p-5};
    static const planar2_real v_next_expected[2] = {-0x1.dc7bc30dfd517p+0, 0x1.f73e4f944e754p-1};
    planar2_real q_next[2];
    planar2_real v_next[2];
    int failures = 0;

    planar2_step(0x1p-14, q, v, u, q_next, v_next);
    failures += compare("step, q_next", 2, q_next, q_next_expected, PLANAR2_STEP_TOLERANCE);
    failures += compare("step, v_next", 2, v_next, v_next_expected, PLANAR2_STEP_TOLERANCE);
    return failures;
}

static int case_35(void)
{
    static const planar2_real q[2] = {-0x1.d9730913d6b04p+0, -0x1.f5044d84e2ca4p+0};
    static const planar2_real v[2] = {0x1.bdb4db05050dap+0, 0x1.7ecf8b1c1852p-2};
    static const planar2_real u[2] = {0x1.f40a3fd2949bcp+0, 0x1.c84957a1ac4ap-2};
    static const planar2_real q_next_expected[2] = {-0x1.d96c1131e5afdp+0, -0x1.f502cf1aaa1dbp+0};
    static const planar2_real v_next_expected[2] = {0x1.be3c1da62a00cp+0, 0x1.7e04f0f35793ep-2};
    planar2_real q_next[2];
    planar2_real v_next[2];
    int failures = 0;

    planar2_step(0x1p-14, q, v, u, q_next, v_next);
    failures += compare("step, q_next", 2, q_next, q_next_expected, PLANAR2_STEP_TOLERANCE);
    failures += compare("step, v_next", 2, v_next, v_next_expected, PLANAR2_STEP_TOLERANCE);
    return failures;
}

static int case_36(void)
{
    static const planar2_real q[2] = {0x1.65877f58b3f84p+0, -0x1.b23c8fab5b49cp+0};
    static const planar2_real v[2] = {-0x1.9af0f1ba17898p-1, -0x1.8ca51a1dda62cp+0};
    static const planar2_real u[2] = {-0x1.fc627065eb75ap+0, 0x1.93589fa1f2b34p-1};
    static const planar2_real q_next_expected[2] = {0x1.65844828cf572p+0, -0x1.b242c014c2a28p+0};
    static const planar2_real v_next_expected[2] = {-0x1.9c3ef147cab23p-1, -0x1.8b8f993264db6p+0};
    planar2_real q_next[2];
    planar2_real v_next[2];
    int failures = 0;

    planar2_step(0x1p-14, q, v, u, q_next, v_next);
    failures += compare("step, q_next", 2, q_next, q_next_expected, PLANAR2_STEP_TOLERANCE);
    failures += compare("step, v_next", 2, v_next, v_next_expected, PLANAR2_STEP_TOLERANCE);
    return failures;
}

int main(void)
{
    int failures = 0;

    failures += case_1();
    failures += case_2();
    failures += case_3();
    failures += case_4();
    failures += case_5();
    failures += case_6();
    failures += case_7();
    failures += case_8();
    failures += case_9();
    failures += case_10();
    failures += case_11();
    failures += case_12();
    failures += case_13();
    failures += case_14();
    failures += case_15();
    failures += case_16();
    failures += case_17();
    failures += case_18();
    failures += case_19();
    failures += case_20();
    failures += case_21();
    failures += case_22();
    failures += case_23();
    failures += case_24();
    failures += case_25();
    failures += case_26();
    failures += case_27();
    failures += case_28();
    failures += case_29();
    failures += case_30();
    failures += case_31();
    failures += case_32();
    failures += case_33();
    failures += case_34();
    failures += case_35();
    failures += case_36();
    printf("%s\n", failures ? "FAILED" : "all passed");
    return failures;
}
