/* Self-test of spatial2_cart.
 *
 * Every function is compared with the un-lowered Lagrangian in 50 digits, rounded once; Jacobians along one
 * direction each. Build it with spatial2_cart.c and run it: the exit code is the number of failures.
 */
#include "spatial2_cart.h"
#include <math.h>
#include <stdio.h>

/* Largest error over largest expected entry; NaN fails. Returns the number of failures, 0 or 1. */
static int compare(const char *what, int count, const spatial2_cart_real *found,
    const spatial2_cart_real *expected, spatial2_cart_real tolerance)
{
    spatial2_cart_real worst = 0.0;
    spatial2_cart_real scale = 0.0;
    int failed = 0;

    for (int i = 0; i < count; ++i) {
        const spatial2_cart_real error = fabs(found[i] - expected[i]);

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
    static const spatial2_cart_real q[8] = {0x1.032f7c1073868p-1, -0x1.fc03ebc0b9f6p-1, 0x1.909c14e508e39p-4,
        0x1.f02f54e2cf22fp-1, 0x1.cfabcb60695f8p-3, -0x1.db9f97c527877p-1, 0x1.4d77129f557e3p-2,
        0x1.689756c064976p-3};
    static const spatial2_cart_real v[8] = {0x1.3ffad289ab1dp-1, -0x1.18d28ec1a6a18p+0, 0x1.fc0d36ce7af79p-1,
        0x1.1e61264fea52bp-2, -0x1.a03321bc4aff5p+0, -0x1.44b69618c6f5ep-2, -0x1.ac88cee44d9c8p-1,
        -0x1.0005c2dabc494p-3};
    static const spatial2_cart_real u[2] = {0x1.315909ee5a698p-1, -0x1.f88d4e2d0929p+0};
    static const spatial2_cart_real a_expected[8] = {0x1.656aa409c6756p+0, -0x1.ed2cfc8771f4fp+0,
        0x1.e66db33e0a9d3p+4, -0x1.290555e63c72p+2, 0x1.aed9ce8f53835p+2, -0x1.426e24c39e93ep+1,
        0x1.7a8b95133d171p+2, -0x1.83adbda7b2a4bp+4};
    spatial2_cart_real a[8];
    int failures = 0;

    spatial2_cart_forward_dynamics(q, v, u, a);
    failures += compare("forward_dynamics", 8, a, a_expected, SPATIAL2_CART_FORWARD_DYNAMICS_TOLERANCE);
    return failures;
}

static int case_2(void)
{
    static const spatial2_cart_real q[8] = {-0x1.99ac3060b304p-3, 0x1.fb5cdbb34557p-2, -0x1.284b791e8f659p-1,
        0x1.26c3659f8c8b1p-1, -0x1.27bff8b004a85p-1, -0x1.1be973c2ee9c6p-2, 0x1.77651f0cf70e7p-1,
        0x1.3deab3c44c496p-1};
    static const spatial2_cart_real v[8] = {0x1.95b8568a63bbap+0, -0x1.53f36a9139be8p-2, 0x1.88ddc308e09dbp-2,
        0x1.817c3398250a7p-3, -0x1.92fb27059bd02p-3, -0x1.38751bf49ec99p-1, 0x1.8561449fd60c4p-2,
        -0x1.7168501d2cb3bp-1};
    static const spatial2_cart_real u[2] = {0x1.cf4aa95a6f218p-2, 0x1.5b81ba316c9ecp-1};
    static const spatial2_cart_real a_expected[8] = {0x1.fcaa081cb1dbcp+0, 0x1.1fae60ff1c7ecp-2,
        0x1.18e80228f52c2p+4, 0x1.643d830164151p+4, 0x1.2683138750254p+2, 0x1.2412f20bcbc57p+4,
        0x1.848d6f9192714p+3, -0x1.8befa3d28c897p+2};
    spatial2_cart_real a[8];
    int failures = 0;

    spatial2_cart_forward_dynamics(q, v, u, a);
    failures += compare("forward_dynamics", 8, a, a_expected, SPATIAL2_CART_FORWARD_DYNAMICS_TOLERANCE);
    return failures;
}

static int case_3(void)
{
    static const spatial2_cart_real q[8] = {-0x1.cd452accbcee6p+0, -0x1.636f34a051a14p-1,
        0x1.38eb220e12af5p-1, 0x1.dc711ef09c474p-2, -0x1.47d6282a5b10ep-1, 0x1.4b2ca586653f2p-1,
        0x1.1fb1db85f2362p-1, 0x1.0801929ca0977p-1};
    static const spatial2_cart_real v[8] = {-0x1.985634958cc66p+0, -0x1.4b4fdaad52562p+0,
        -0x1.b0ed397d776aep-4, 0x1.5eaf6ed76c55dp-1, 0x1.965752d622431p-2, 0x1.6b7260f8c5be2p-5,
        -0x1.edb8f23e56789p-3, 0x1.a80b54c510cdp-3};
    static const spatial2_cart_real u[2] = {0x1.57535e40bb5a2p+0, 0x1.4972455152102p+0};
    static const spatial2_cart_real a_expected[8] = {0x1.bac137c1a9294p-1, 0x1.30af7d026a6b3p+0,
        0x1.623e05351de75p+3, -0x1.0304d21cc8923p+4, -0x1.3274eabcd473cp+0, 0x1.64ad147da6f01p+4,
        -0x1.b1c22832c8da9p+4, 0x1.941d21c4a6a87p+0};
    spatial2_cart_real a[8];
    int failures = 0;

    spatial2_cart_forward_dynamics(q, v, u, a);
    failures += compare("forward_dynamics", 8, a, a_expected, SPATIAL2_CART_FORWARD_DYNAMICS_TOLERANCE);
    return failures;
}

static int case_4(void)
{
    static const spatial2_cart_real q[8] = {-0x1.4f49206c9bfccp+0, -0x1.fb46b4f598eb8p-1,
        -0x1.4d54d3dd8ce85p-1, -0x1.8482963d2dba7p-1, 0x1.366c69c6e0607p-6, -0x1.01e7544e07dfap-2,
        0x1.cd9e66ce7a2d9p-1, 0x1.68217df0e81a4p-2};
    static const spatial2_cart_real out_expected[64] = {0x1.999999999999ap-1, 0.0, 0.0, 0x1.bf0283d6b3be2p-10,
        0x1.17ba2ebb689acp-4, 0.0, 0x1.ccf7ab71ccee8p-8, -0x1.276f9df4c912fp-6, 0.0, 0x1.999999999999ap-1,
        -0x1.bf0283d6b3be2p-10, 0.0, -0x1.dfff4590f3ddfp-5, -0x1.ccf7ab71ccee8p-8, 0.0, -0x1.4a1ddc8cd6e0ep-8,
        0.0, -0x1.bf0283d6b3be2p-10, 0x1.ba5e353f7ced9p-6, 0.0, 0.0, -0x1.0a652a53a832cp-8,
        -0x1.2c98311a4eb43p-10, 0x1.e05b2749276afp-16, 0x1.bf0283d6b3be2p-10, 0.0, 0.0, 0x1.ba5e353f7ced9p-6,
        0.0, 0x1.cd9db3831a0abp-9, 0x1.0c61f8be9f263p-10, -0x1.ade454859efap-14, 0x1.17ba2ebb689acp-4,
        -0x1.dfff4590f3ddfp-5, 0.0, 0.0, 0x1.ba5e353f7ced9p-6, 0x1.6820f2109cda3p-10, 0x1.a3be4f494aeb9p-10,
        -0x1.991460e44cc79p-9, 0.0, -0x1.ccf7ab71ccee8p-8, -0x1.0a652a53a832cp-8, 0x1.cd9db3831a0abp-9,
        0x1.6820f2109cda3p-10, 0x1.0624dd2f1a9fdp-8, 0.0, 0.0, 0x1.ccf7ab71ccee8p-8, 0.0,
        -0x1.2c98311a4eb43p-10, 0x1.0c61f8be9f263p-10, 0x1.a3be4f494aeb9p-10, 0.0, 0x1.0624dd2f1a9fdp-8, 0.0,
        -0x1.276f9df4c912fp-6, -0x1.4a1ddc8cd6e0ep-8, 0x1.e05b2749276afp-16, -0x1.ade454859efap-14,
        -0x1.991460e44cc79p-9, 0.0, 0.0, 0x1.0624dd2f1a9fdp-8};
    spatial2_cart_real out[64];
    int failures = 0;

    spatial2_cart_mass_matrix(q, out);
    failures += compare("mass_matrix", 64, out, out_expected, SPATIAL2_CART_MASS_MATRIX_TOLERANCE);
    return failures;
}

static int case_5(void)
{
    static const spatial2_cart_real q[8] = {0x1.f84ca1171def6p+0, 0x1.aa8ff1206b58ep+0, -0x1.b71a40e0b2cfcp-2,
        0x1.0a40d41cc290fp-4, 0x1.cd56c14ae5073p-1, -0x1.65fb1e06e6ec8p-4, -0x1.f92c49bbe9835p-1,
        0x1.1931bfe46239ep-3};
    static const spatial2_cart_real out_expected[64] = {0x1.999999999999ap-1, 0.0, 0.0, 0x1.4c29fbcf862e2p-4,
        -0x1.7f6797d77e934p-8, 0.0, 0x1.67edc26c02d98p-9, 0x1.434f8b598b356p-6, 0.0, 0x1.999999999999ap-1,
        -0x1.4c29fbcf862e2p-4, 0.0, -0x1.3c2761e976811p-5, -0x1.67edc26c02d98p-9, 0.0, -0x1.ca3730acacb3ep-10,
        0.0, -0x1.4c29fbcf862e2p-4, 0x1.ba5e353f7ced9p-6, 0.0, 0.0, 0x1.76d7ec38c03edp-12,
        0x1.1df0d46ba987cp-15, 0x1.ef7399e693f51p-12, 0x1.4c29fbcf862e2p-4, 0.0, 0.0, 0x1.ba5e353f7ced9p-6,
        0.0, -0x1.4cbbeffc9f72cp-9, 0x1.fb120594135e1p-11, 0x1.5d957c10c53cbp-8, -0x1.7f6797d77e934p-8,
        -0x1.3c2761e976811p-5, 0.0, 0.0, 0x1.ba5e353f7ced9p-6, 0x1.726b610f658b1p-12, -0x1.c136a2043308dp-15,
        -0x1.4f73e1a18d86bp-13, 0.0, -0x1.67edc26c02d98p-9, 0x1.76d7ec38c03edp-12, -0x1.4cbbeffc9f72cp-9,
        0x1.726b610f658b1p-12, 0x1.0624dd2f1a9fdp-8, 0.0, 0.0, 0x1.67edc26c02d98p-9, 0.0,
        0x1.1df0d46ba987cp-15, 0x1.fb120594135e1p-11, -0x1.c136a2043308dp-15, 0.0, 0x1.0624dd2f1a9fdp-8, 0.0,
        0x1.434f8b598b356p-6, -0x1.ca3730acacb3ep-10, 0x1.ef7399e693f51p-12, 0x1.5d957c10c53cbp-8,
        -0x1.4f73e1a18d86bp-13, 0.0, 0.0, 0x1.0624dd2f1a9fdp-8};
    spatial2_cart_real out[64];
    int failures = 0;

    spatial2_cart_mass_matrix(q, out);
    failures += compare("mass_matrix", 64, out, out_expected, SPATIAL2_CART_MASS_MATRIX_TOLERANCE);
    return failures;
}

static int case_6(void)
{
    static const spatial2_cart_real q[8] = {-0x1.a111907ad8358p+0, 0x1.b205117fdfa74p-1, 0x1.47278fc44cda9p-1,
        0x1.481133444fd85p-1, -0x1.b3d32a69a666dp-2, -0x1.f7e7c221a44cp-1, -0x1.7a6435fb8abecp-4,
        -0x1.357bc91a7832ap-3};
    static const spatial2_cart_real out_expected[64] = {0x1.999999999999ap-1, 0.0, 0.0, -0x1.39cb3d41d3f82p-5,
        -0x1.d86ab03968bcap-5, 0.0, -0x1.8c2390c5b892cp-9, 0x1.e4574f5674277p-10, 0.0, 0x1.999999999999ap-1,
        0x1.39cb3d41d3f82p-5, 0.0, 0x1.d71a3faa0845p-5, 0x1.8c2390c5b892cp-9, 0.0, -0x1.427fd8677363ep-6, 0.0,
        0x1.39cb3d41d3f82p-5, 0x1.ba5e353f7ced9p-6, 0.0, 0.0, 0x1.01d3c732ea422p-15, 0x1.eff1c39c21a4dp-9,
        -0x1.496bf41cbb24cp-9, -0x1.39cb3d41d3f82p-5, 0.0, 0.0, 0x1.ba5e353f7ced9p-6, 0.0,
        0x1.73609fc93543bp-12, -0x1.bbfc0777a8461p-9, -0x1.eebcb99c4d915p-13, -0x1.d86ab03968bcap-5,
        0x1.d71a3faa0845p-5, 0.0, 0.0, 0x1.ba5e353f7ced9p-6, 0x1.2fbf3049248b9p-11, 0x1.30981c4f3ddfbp-11,
        -0x1.0e8ee652c0839p-8, 0.0, 0x1.8c2390c5b892cp-9, 0x1.01d3c732ea422p-15, 0x1.73609fc93543bp-12,
        0x1.2fbf3049248b9p-11, 0x1.0624dd2f1a9fdp-8, 0.0, 0.0, -0x1.8c2390c5b892cp-9, 0.0,
        0x1.eff1c39c21a4dp-9, -0x1.bbfc0777a8461p-9, 0x1.30981c4f3ddfbp-11, 0.0, 0x1.0624dd2f1a9fdp-8, 0.0,
        0x1.e4574f5674277p-10, -0x1.427fd8677363ep-6, -0x1.496bf41cbb24cp-9, -0x1.eebcb99c4d915p-13,
        -0x1.0e8ee652c0839p-8, 0.0, 0.0, 0x1.0624dd2f1a9fdp-8};
    spatial2_cart_real out[64];
    int failures = 0;

    spatial2_cart_mass_matrix(q, out);
    failures += compare("mass_matrix", 64, out, out_expected, SPATIAL2_CART_MASS_MATRIX_TOLERANCE);
    return failures;
}

static int case_7(void)
{
    static const spatial2_cart_real q[8] = {0x1.9beb408858c28p+0, -0x1.0689fba1cf144p-1,
        -0x1.54a2aba7c57b6p-2, 0x1.d6189d54f5c66p-1, -0x1.b8d3832652283p-3, -0x1.84b0b514cbe91p-1,
        -0x1.8628258e8b6fcp-2, 0x1.0e3351d9b6ca6p-1};
    static const spatial2_cart_real v[8] = {0x1.d2f2d9d364b3p+0, 0x1.f097d57b8b08p-1, -0x1.53a0fe96a7aeap+0,
        -0x1.c3a1611cf9841p-1, -0x1.b65be8d3dc39cp+0, -0x1.16d9d555851bap+0, -0x1.9b6493fef6cfap-4,
        -0x1.a3b2991e96dd7p+0};
    static const spatial2_cart_real out_expected[8] = {0x1.c830be798650cp-3, -0x1.b09186bbbe66bp-2,
        -0x1.33695b050cd1bp-7, -0x1.02dc8f854c567p-7, -0x1.3a8e4042c027ap-6, 0x1.b0ebec254a47dp-7,
        0x1.6c8cb28d29c8ep-7, 0x1.bafb8504e7ff5p-6};
    spatial2_cart_real out[8];
    int failures = 0;

    spatial2_cart_coriolis(q, v, out);
    failures += compare("coriolis", 8, out, out_expected, SPATIAL2_CART_CORIOLIS_TOLERANCE);
    return failures;
}

static int case_8(void)
{
    static const spatial2_cart_real q[8] = {-0x1.82f600576cab6p+0, 0x1.2102181a40e8cp+0,
        -0x1.4d11322eef848p-1, 0x1.294997bbf0f62p-3, -0x1.7db0648d278bfp-1, -0x1.44e5901a2db2ep-3,
        -0x1.b38c49d327915p-4, -0x1.f6936e536e555p-1};
    static const spatial2_cart_real v[8] = {-0x1.3eb06dcf32ddp-3, -0x1.c5adf4dfabf08p-1, 0x1.7a7ba579187bp+0,
        0x1.91794f3acfac6p-1, -0x1.232eaf9ee951dp+0, 0x1.d27a575ef95e3p+0, 0x1.14066da5724c5p+0,
        -0x1.a52aad0781f71p-2};
    static const spatial2_cart_real out_expected[8] = {0x1.04955a616fc2ap-2, -0x1.6526af5895784p-5,
        0x1.95a82d0f8a486p-8, 0x1.dbde59b37df22p-7, -0x1.5152884ba704ep-9, -0x1.6507cebba6d0bp-8,
        -0x1.a2d3670909d6cp-7, 0x1.28e3244a0acfcp-9};
    spatial2_cart_real out[8];
    int failures = 0;

    spatial2_cart_coriolis(q, v, out);
    failures += compare("coriolis", 8, out, out_expected, SPATIAL2_CART_CORIOLIS_TOLERANCE);
    return failures;
}

static int case_9(void)
{
    static const spatial2_cart_real q[8] = {0x1.850be586d3fb8p-2, 0x1.a1d29bc264e9p-2, -0x1.dd59f4bfaf9fdp-1,
        -0x1.66a179039172fp-5, -0x1.6f925c9c02c0ap-2, -0x1.ec8e9ae4d260fp-1, 0x1.b5007d8b0aa57p-3,
        0x1.5c9e136b27578p-3};
    static const spatial2_cart_real v[8] = {0x1.fe2a3161266bap+0, 0x1.3c3147add1fa8p-1, 0x1.43b9e8075276dp-2,
        -0x1.1a55a17f16005p-1, -0x1.81fa3e696007dp-1, -0x1.f81a54ac9cbf4p-9, 0x1.08e5a1558284p+0,
        -0x1.519ecaaf6c1cdp+0};
    static const spatial2_cart_real out_expected[8] = {0x1.15d2017ff24bfp-3, -0x1.0b6c41228f187p-7,
        -0x1.31984f44913e3p-10, -0x1.1676e3757979cp-7, 0x1.0a5ae0d9d661ap-8, 0x1.a6f7fd53118afp-12,
        0x1.816af3b8ac208p-9, -0x1.70a8480c722bap-10};
    spatial2_cart_real out[8];
    int failures = 0;

    spatial2_cart_coriolis(q, v, out);
    failures += compare("coriolis", 8, out, out_expected, SPATIAL2_CART_CORIOLIS_TOLERANCE);
    return failures;
}

static int case_10(void)
{
    static const spatial2_cart_real q[8] = {-0x1.79b3336968b38p-2, 0x1.6b2d3637a947cp-1,
        -0x1.33fa180556f35p-1, 0x1.2a53abef255f8p-1, 0x1.17d01fc2f44a4p-1, -0x1.3a6fac26ab2a2p-5,
        0x1.6aaa495ab3f14p-1, -0x1.68e059c923bedp-1};
    static const spatial2_cart_real out_expected[8] = {0.0, 0.0, -0x1.07648c82d5b51p-1, -0x1.0fe9af44d1185p-1,
        0.0, -0x1.1c9ea060c89c7p-3, -0x1.ed8a01eb97ecap-8, 0.0};
    spatial2_cart_real out[8];
    int failures = 0;

    spatial2_cart_gravity_torque(q, out);
    failures += compare("gravity_torque", 8, out, out_expected, SPATIAL2_CART_GRAVITY_TORQUE_TOLERANCE);
    return failures;
}

static int case_11(void)
{
    static const spatial2_cart_real q[8] = {0x1.38e9b9b8dd798p+0, -0x1.e20d8416db49p-1, -0x1.7c9bc4621f5b2p-1,
        0x1.3dcd44f24f2e2p-1, -0x1.fe6c242f66f1ep-3, 0x1.3be369fd0fb0dp-2, 0x1.a6172c7e27859p-3,
        -0x1.db75de4eb0477p-1};
    static const spatial2_cart_real out_expected[8] = {0.0, 0.0, -0x1.1896554509f4p-1, -0x1.500a09ee4967ep-1,
        0.0, -0x1.4b41b34d4c12ap-5, 0x1.efd17e380219bp-5, 0.0};
    spatial2_cart_real out[8];
    int failures = 0;

    spatial2_cart_gravity_torque(q, out);
    failures += compare("gravity_torque", 8, out, out_expected, SPATIAL2_CART_GRAVITY_TORQUE_TOLERANCE);
    return failures;
}

static int case_12(void)
{
    static const spatial2_cart_real q[8] = {-0x1.e1ced28d985e8p-1, -0x1.4a5be99fda2eep+0,
        -0x1.e29337d21876dp-2, 0x1.4b9af780275eap-1, 0x1.3288575bfa442p-1, 0x1.56cd892ff7f6p-1,
        0x1.0b6b973c6e0bdp-1, -0x1.0e6699e574cb7p-1};
    static const spatial2_cart_real out_expected[8] = {0.0, 0.0, -0x1.24c63c0de551dp-1, -0x1.aa10c68ec4586p-2,
        0.0, -0x1.a3be2c7560f3ep-4, 0x1.0d081d39ebc3cp-3, 0.0};
    spatial2_cart_real out[8];
    int failures = 0;

    spatial2_cart_gravity_torque(q, out);
    failures += compare("gravity_torque", 8, out, out_expected, SPATIAL2_CART_GRAVITY_TORQUE_TOLERANCE);
    return failures;
}

static int case_13(void)
{
    static const spatial2_cart_real q[8] = {-0x1.0f635f6dcc8cp-5, -0x1.7a34489dc5696p+0, 0x1.d3700fd2f57f3p-3,
        -0x1.203792b906f82p-2, -0x1.dd33676f531b8p-1, 0x1.2570b6999f1dfp-1, 0x1.83f9ec27d775ep-1,
        0x1.3f71d441f464dp-2};
    static const spatial2_cart_real v[8] = {-0x1.e81e880cde884p+0, -0x1.d71c698e770bap+0,
        0x1.5ebadcd501493p-2, 0x1.194aebcaea693p+0, -0x1.fbcc10d516a97p-3, -0x1.66eb3587ca25bp-2,
        -0x1.7100679f20336p-3, 0x1.14e4481c1ededp+0};
    static const spatial2_cart_real kinetic_expected[1] = {0x1.7e7f05a86bf1p+1};
    static const spatial2_cart_real potential_expected[1] = {0x1.85fbaa158bdfp-1};
    spatial2_cart_real kinetic;
    spatial2_cart_real potential;
    int failures = 0;

    spatial2_cart_energy(q, v, &kinetic, &potential);
    failures += compare("energy, kinetic", 1, &kinetic, kinetic_expected, SPATIAL2_CART_ENERGY_TOLERANCE);
    failures += compare("energy, potential", 1, &potential, potential_expected,
        SPATIAL2_CART_ENERGY_TOLERANCE);
    return failures;
}

static int case_14(void)
{
    static const spatial2_cart_real q[8] = {0x1.78c4934d62ecp-1, -0x1.76973604ba5a4p+0, -0x1.a6c6dd4ecaf24p-1,
        0x1.9b5d202725423p-2, -0x1.9574d7e764cd5p-2, -0x1.e12478ca748a8p-1, -0x1.5d8661d619ab2p-2,
        0x1.4658cc8a1a71fp-6};
    static const spatial2_cart_real v[8] = {0x1.9018b0ca10c5p-3, -0x1.7bfdff2164ce2p+0, -0x1.97163463760e6p-1,
        -0x1.18f650ebc5d29p+0, 0x1.16d798c2cffa1p-1, -0x1.23b4baf178beap-2, 0x1.91d06b2e1415dp-1,
        0x1.206f60e98b4a4p-7};
    static const spatial2_cart_real kinetic_expected[1] = {0x1.06d8dacb2e9d2p+0};
    static const spatial2_cart_real potential_expected[1] = {0x1.61f9c3d1a827dp-2};
    spatial2_cart_real kinetic;
    spatial2_cart_real potential;
    int failures = 0;

    spatial2_cart_energy(q, v, &kinetic, &potential);
    failures += compare("energy, kinetic", 1, &kinetic, kinetic_expected, SPATIAL2_CART_ENERGY_TOLERANCE);
    failures += compare("energy, potential", 1, &potential, potential_expected,
        SPATIAL2_CART_ENERGY_TOLERANCE);
    return failures;
}

static int case_15(void)
{
    static const spatial2_cart_real q[8] = {0x1.689b267456718p-2, 0x1.4c19594ce667ep+0, 0x1.2a073ed68f54ep-1,
        0x1.00bf99f5d0f44p-1, -0x1.47b97ad45a075p-1, 0x1.6c570bcb2acbbp-1, -0x1.c4fd76c0ea31ap-2,
        0x1.1776e1c2148f1p-1};
    static const spatial2_cart_real v[8] = {-0x1.780a451c9437cp+0, 0x1.98758fa6f093p-3, -0x1.6ffea5722ae7cp-1,
        0x1.2ae5c96b813d2p+0, 0x1.0b5c0ecf8bb53p-2, 0x1.ac177383a159dp-1, 0x1.0934e4ccfaafap-3,
        -0x1.f85f2406395f1p-1};
    static const spatial2_cart_real kinetic_expected[1] = {0x1.08443a31166fp+0};
    static const spatial2_cart_real potential_expected[1] = {0x1.d508be34a4d4ep-2};
    spatial2_cart_real kinetic;
    spatial2_cart_real potential;
    int failures = 0;

    spatial2_cart_energy(q, v, &kinetic, &potential);
    failures += compare("energy, kinetic", 1, &kinetic, kinetic_expected, SPATIAL2_CART_ENERGY_TOLERANCE);
    failures += compare("energy, potential", 1, &potential, potential_expected,
        SPATIAL2_CART_ENERGY_TOLERANCE);
    return failures;
}

static int case_16(void)
{
    static const spatial2_cart_real q[8] = {0x1.b90e46fc0d3a4p+0, 0x1.455c8b25517f8p-1, -0x1.a39de6aad1893p-1,
        -0x1.06c8130ceca0ep-1, -0x1.04db68aedf112p-2, 0x1.8850cf2218ff7p-1, -0x1.48921e8cbdb9ep-1,
        -0x1.08af82ba4712p-5};
    static const spatial2_cart_real out_expected[6] = {0x1.7a1cfdfc0765bp+0, 0x1.ed0dd7a948381p-2,
        -0x1.39074a6b72148p-4, 0x1.a15845e5d6b27p+0, 0x1.69a031d762ba9p-2, -0x1.537f3de4792ffp-4};
    spatial2_cart_real out[6];
    int failures = 0;

    spatial2_cart_positions(q, out);
    failures += compare("positions", 6, out, out_expected, SPATIAL2_CART_POSITIONS_TOLERANCE);
    return failures;
}

static int case_17(void)
{
    static const spatial2_cart_real q[8] = {-0x1.ef17dbc0ae364p-1, 0x1.94cf3a504b5cp-2, -0x1.8a0b112f3d3d3p-1,
        -0x1.c1ff00ff4f317p-3, -0x1.32f30856a359dp-1, 0x1.c62c63ffcdf9p-2, -0x1.ba5c8da1b0b8ep-2,
        0x1.92102438523ap-1};
    static const spatial2_cart_real out_expected[6] = {-0x1.32a7307439e45p+0, 0x1.514f609065e16p-2,
        -0x1.7056d6ce5d9efp-3, -0x1.1bf1c50dd5fe4p+0, 0x1.f1aceee01eacp-3, -0x1.75829b70deb78p-6};
    spatial2_cart_real out[6];
    int failures = 0;

    spatial2_cart_positions(q, out);
    failures += compare("positions", 6, out, out_expected, SPATIAL2_CART_POSITIONS_TOLERANCE);
    return failures;
}

static int case_18(void)
{
    static const spatial2_cart_real q[8] = {0x1.45b5e1f82b1c4p+0, 0x1.8999ff48a74d8p-1, 0x1.7d501f6ac0177p-2,
        0x1.c811666cf9849p-2, -0x1.a0e3056356795p-1, 0x1.744fdfe204375p-1, -0x1.0862135c82dbep-4,
        0x1.5de8724cf295bp-1};
    static const spatial2_cart_real out_expected[6] = {0x1.624f1786931ep+0, 0x1.ce0301d8ffee3p-1,
        -0x1.f443a010ce2b3p-3, 0x1.878a47839389fp+0, 0x1.c766f49049758p-1, -0x1.b8acefa67e9ap-4};
    spatial2_cart_real out[6];
    int failures = 0;

    spatial2_cart_positions(q, out);
    failures += compare("positions", 6, out, out_expected, SPATIAL2_CART_POSITIONS_TOLERANCE);
    return failures;
}

static int case_19(void)
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
    failures += compare("linearization, M", 36, M, M_expected, SPATIAL2_CART_LINEARIZATION_TOLERANCE);
    failures += compare("linearization, G", 36, G, G_expected, SPATIAL2_CART_LINEARIZATION_TOLERANCE);
    failures += compare("linearization, B", 12, B, B_expected, SPATIAL2_CART_LINEARIZATION_TOLERANCE);
    return failures;
}

static int case_20(void)
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
    failures += compare("linearization, M", 36, M, M_expected, SPATIAL2_CART_LINEARIZATION_TOLERANCE);
    failures += compare("linearization, G", 36, G, G_expected, SPATIAL2_CART_LINEARIZATION_TOLERANCE);
    failures += compare("linearization, B", 12, B, B_expected, SPATIAL2_CART_LINEARIZATION_TOLERANCE);
    return failures;
}

static int case_21(void)
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
    failures += compare("linearization, M", 36, M, M_expected, SPATIAL2_CART_LINEARIZATION_TOLERANCE);
    failures += compare("linearization, G", 36, G, G_expected, SPATIAL2_CART_LINEARIZATION_TOLERANCE);
    failures += compare("linearization, B", 12, B, B_expected, SPATIAL2_CART_LINEARIZATION_TOLERANCE);
    return failures;
}

static int case_22(void)
{
    static const spatial2_cart_real q[8] = {-0x1.f8f6da3ea6818p-2, -0x1.7479f8c12dccp+0, -0x1.519535bcf64ap-1,
        -0x1.421fc473e9e01p-1, -0x1.a582d33c9aae4p-2, 0x1.3064b1d266f33p-2, 0x1.9b666bf5bb67fp-1,
        -0x1.08108d7c9a329p-1};
    static const spatial2_cart_real v[8] = {0x1.415b38ff3cf28p-1, -0x1.80bd8b0d68a68p-2, 0x1.3cb5d432668e8p+0,
        -0x1.5a80a41c24f74p-1, -0x1.e4fe65cde240dp-1, 0x1.6b837dedc5ad9p-2, 0x1.57aa7a87e2956p-2,
        0x1.7477133d9cfcep-1};
    static const spatial2_cart_real u[2] = {-0x1.261916c607d14p-1, -0x1.c4ebc4f097182p+0};
    static const spatial2_cart_real slope_expected[8] = {-0x1.538a1ce1548ecp-4, 0x1.5f93d8bd1b157p+1,
        -0x1.ae24b7c90db6p+2, -0x1.fda66023c94e1p+3, 0x1.6a253bd65c37ap+3, 0x1.ec1e1838cbf22p+3,
        -0x1.29f29aa635b01p+3, 0x1.43c70d98bde81p+4};
    static const spatial2_cart_real dadq_direction[8] = {-0x1.7a64c79e0de5cp-1, 0x1.5d004485f99dp-1,
        0x1.bf7a9c33366ebp-2, -0x1.f9489e100ac0cp-3, -0x1.4a9dc251166fbp-2, 0x1.69ebbb60a197ap-1,
        -0x1.bebd681553a3dp-3, 0x1.14c7637b8a24ep-4};
    static const spatial2_cart_real dadv_direction[8] = {-0x1.e4665e814eb34p-2, 0x1.d9347b6a4ca98p-1,
        0x1.88abb33528f7p-2, 0x1.a79e0503796ebp+0, -0x1.5ce2084021041p-1, -0x1.ce156d3f2f498p-2,
        0x1.479a7c14c7d6p-6, 0x1.b0161983b9c5p-3};
    static const spatial2_cart_real dadu_direction[2] = {0x1.817ee686d0f8p-6, 0x1.8f7cddbefa5fap-1};
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
    failures += compare("state_jacobian", 8, slope, slope_expected, SPATIAL2_CART_STATE_JACOBIAN_TOLERANCE);
    return failures;
}

static int case_23(void)
{
    static const spatial2_cart_real q[8] = {0x1.aa4fac35e2d84p+0, 0x1.2bf001b10908p-1, 0x1.7db2525064709p-1,
        -0x1.49c5c7d259605p-1, -0x1.5f09fda1b17dfp-3, -0x1.e34c8db01f9b8p-1, 0x1.f7d89dc9d2277p-4,
        -0x1.39af2fbcedf6ap-2};
    static const spatial2_cart_real v[8] = {0x1.404c8f9f12a8p-2, 0x1.5fb8cc33b51dcp+0, 0x1.6a4e85e3c962p-3,
        0x1.338e26621aef3p-3, 0x1.a419cae65eb52p-3, 0x1.a969d36e838edp-2, 0x1.712b11cca5e44p+0,
        -0x1.66f58f2d0d772p-1};
    static const spatial2_cart_real u[2] = {0x1.125eedb851474p-1, -0x1.735bfbd1e877cp+0};
    static const spatial2_cart_real slope_expected[8] = {0x1.dbdceb02d8c29p-1, 0x1.1505421f9969p-2,
        -0x1.8b9e5d39be56ep+3, -0x1.e495204b7bcccp-1, -0x1.18b9ccc0ab56ep+1, -0x1.a531994aadbacp+2,
        -0x1.4e653b5606a9bp+4, 0x1.d227b4feca755p+2};
    static const spatial2_cart_real dadq_direction[8] = {-0x1.2410049727296p-1, -0x1.fc1f05474e096p-1,
        -0x1.0d66b356a4631p-4, -0x1.d23619cf0f3bdp-3, 0x1.2380caaf67ea1p-1, -0x1.75520f48efcfep-6,
        -0x1.8cb21b19da8a8p-3, -0x1.effe3b3b3558p-8};
    static const spatial2_cart_real dadv_direction[8] = {0x1.76a0b7be23a2p-1, -0x1.83baebebbf82ep-1,
        -0x1.c790b8deb5178p-6, 0x1.6c515ab213304p-4, -0x1.50fcb0fd6d6a6p-5, -0x1.46137d72e7eb8p-1,
        0x1.b57d625308c15p-1, 0x1.6152547f4235dp+0};
    static const spatial2_cart_real dadu_direction[2] = {-0x1.a440b92a7b6dcp-2, 0x1.5d2c4c0cb407p-1};
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
    failures += compare("state_jacobian", 8, slope, slope_expected, SPATIAL2_CART_STATE_JACOBIAN_TOLERANCE);
    return failures;
}

static int case_24(void)
{
    static const spatial2_cart_real q[8] = {-0x1.959b9398f19a8p-2, 0x1.ca3ce1c16f5c8p-1, 0x1.14a6dcc235f7fp-1,
        -0x1.6c90e9d2515a9p-2, 0x1.865c137c49956p-1, 0x1.62fdb865ab0d4p-9, 0x1.5f284d25df2bep-6,
        -0x1.ffe1690cc7c2ap-1};
    static const spatial2_cart_real v[8] = {-0x1.9aefd61f0924p+0, -0x1.5b331a9abd3a2p+0,
        -0x1.6fda30be338adp+0, 0x1.9d17e036dd3f4p-1, 0x1.6526658354b4cp+0, -0x1.193abef58280cp-3,
        0x1.4827cf01c5589p+0, 0x1.bc24df3468309p-6};
    static const spatial2_cart_real u[2] = {0x1.c21e00b16e4b8p-1, 0x1.d7fac010de63cp-1};
    static const spatial2_cart_real slope_expected[8] = {-0x1.8129ec6c3a725p-2, -0x1.7a8f1097e1e17p+1,
        -0x1.336676141621ap+4, 0x1.aa46bf352a256p+3, 0x1.16c05acdecef6p+3, -0x1.3a2aa9d0d833fp+5,
        0x1.3eaba539055f3p+4, 0x1.8ddeaaf5fd81p+4};
    static const spatial2_cart_real dadq_direction[8] = {0x1.3357756a6282ep-1, -0x1.8b8765c188208p-1,
        -0x1.92e777da60204p-2, -0x1.37e5da19bfe9cp-3, 0x1.a970a85caad4ap-3, -0x1.d7d57768e7efbp-2,
        -0x1.7d4def8210086p-1, -0x1.1a081163bfdf2p-6};
    static const spatial2_cart_real dadv_direction[8] = {-0x1.509e79c9dd78ep-1, -0x1.f537cc2a24c8ap-1,
        0x1.4b6825d8c2628p-2, 0x1.750cfc91b4cf2p+0, -0x1.04d0d8804435cp-1, -0x1.4001b7c545301p-1,
        -0x1.897ae3da27d6p-5, -0x1.ca1f248445c1p-1};
    static const spatial2_cart_real dadu_direction[2] = {0x1.9ca1bb639138p-7, -0x1.c7d19926a0442p-1};
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
    failures += compare("state_jacobian", 8, slope, slope_expected, SPATIAL2_CART_STATE_JACOBIAN_TOLERANCE);
    return failures;
}

static int case_25(void)
{
    static const spatial2_cart_real q[8] = {-0x1.e17eb229409fp+0, 0x1.b34c852641p-11, -0x1.34f55c33c84c3p-2,
        -0x1.42b0116cb4712p-1, 0x1.6e44caf5025f4p-1, -0x1.516bbd8dd644bp-1, -0x1.4a56d8e1539cap-1,
        -0x1.8bd056546600bp-2};
    static const spatial2_cart_real v[8] = {-0x1.b1d4242da7b04p-1, -0x1.773ffe09768a8p-2,
        0x1.00467dab6a912p-2, 0x1.3d0d40fd54954p-1, 0x1.4d5ef3dec4fa8p-1, 0x1.18dbee86fd053p-1,
        -0x1.c0ec05b7ef4d1p-3, -0x1.2384d0b9de682p-1};
    static const spatial2_cart_real u[2] = {-0x1.1fd4bc8200a78p+0, 0x1.218de6799bd62p+0};
    static const spatial2_cart_real q_next_expected[8] = {-0x1.e18215ea38a2p+0, 0x1.a792a61241feep-11,
        -0x1.34e7b2f0943p-2, -0x1.42b311ba0b1ep-1, 0x1.6e450781dbc9fp-1, -0x1.516e0087b3a31p-1,
        -0x1.4a52270963886p-1, -0x1.8bd84c03cf872p-2};
    static const spatial2_cart_real v_next_expected[8] = {-0x1.b1ecd3cc4825fp-1, -0x1.7737c71030192p-2,
        0x1.fe5d3a6b0eba6p-3, 0x1.3d8a69a9e0bbcp-1, 0x1.4d92348c6d414p-1, 0x1.181846a2a9b9bp-1,
        -0x1.be5f5b50f1f06p-3, -0x1.234793160563ap-1};
    spatial2_cart_real q_next[8];
    spatial2_cart_real v_next[8];
    int failures = 0;

    spatial2_cart_step(0x1p-14, q, v, u, q_next, v_next);
    failures += compare("step, q_next", 8, q_next, q_next_expected, SPATIAL2_CART_STEP_TOLERANCE);
    failures += compare("step, v_next", 8, v_next, v_next_expected, SPATIAL2_CART_STEP_TOLERANCE);
    return failures;
}

static int case_26(void)
{
    static const spatial2_cart_real q[8] = {-0x1.513f922b102fap+0, 0x1.3ca0d65773cp-9, -0x1.a5cb89ed5697p-1,
        -0x1.1ce0fd54847f1p-1, 0x1.bbc30fd1bbd2bp-4, -0x1.9a2a7a28eb5f6p-2, 0x1.17b7a13b7c1bcp-1,
        0x1.789eeb19b76e6p-1};
    static const spatial2_cart_real v[8] = {-0x1.2a3287c7331cp-2, -0x1.9e2b4064f3c54p-1, 0x1.5e4daeba5d46fp-2,
        -0x1.c1dbdf142d461p-2, 0x1.615c3d4ebeb56p-2, -0x1.ff099234e826bp-1, -0x1.c8a9f4927824fp-2,
        -0x1.b2c75422578b9p-3};
    static const spatial2_cart_real u[2] = {0x1.9b7af66fb2f9p+0, 0x1.f88eeea622746p+0};
    static const spatial2_cart_real q_next_expected[8] = {-0x1.5140bc4f523cdp+0, 0x1.362858f1e9ef9p-9,
        -0x1.a5ca61d3aa58cp-1, -0x1.1ce38f889260bp-1, 0x1.bb9fc77a2b164p-4, -0x1.9a2de0d2fd297p-2,
        0x1.17be2e28c72b1p-1, 0x1.7899207bc4327p-1};
    static const spatial2_cart_real v_next_expected[8] = {-0x1.2a15fc2a8cfd6p-2, -0x1.9e1372561c0ep-1,
        0x1.5d35df45a527p-2, -0x1.c030174b5cbdfp-2, 0x1.61a1947d15a37p-2, -0x1.feb8384bc4ab3p-1,
        -0x1.c96d589fb43aap-2, -0x1.b0f3dea4e2544p-3};
    spatial2_cart_real q_next[8];
    spatial2_cart_real v_next[8];
    int failures = 0;

    spatial2_cart_step(0x1p-14, q, v, u, q_next, v_next);
    failures += compare("step, q_next", 8, q_next, q_next_expected, SPATIAL2_CART_STEP_TOLERANCE);
    failures += compare("step, v_next", 8, v_next, v_next_expected, SPATIAL2_CART_STEP_TOLERANCE);
    return failures;
}

static int case_27(void)
{
    static const spatial2_cart_real q[8] = {-0x1.c8215e5e5035p-1, -0x1.43523a4ccd0a8p+0,
        -0x1.dfe6fd50118bap-1, -0x1.39003cbd614b5p-2, 0x1.56d2253f89028p-3, 0x1.dd7ee5ebf386p-2,
        0x1.428cafd4afb48p-1, 0x1.3df8739b01368p-1};
    static const spatial2_cart_real v[8] = {-0x1.4c20589d5c3e8p+0, 0x1.1e9d9b8c01b98p-1, 0x1.00757d45a00fp-2,
        -0x1.0ea266e686beep+0, -0x1.0e5bf3f0cdea9p-1, 0x1.dea476e4596e6p+0, 0x1.49082f6080081p-3,
        -0x1.911c07caba7bcp+0};
    static const spatial2_cart_real u[2] = {-0x1.bf2698a2b6fbcp+0, -0x1.cf02d75564e08p-1};
    static const spatial2_cart_real q_next_expected[8] = {-0x1.c82bbf8febaa6p-1, -0x1.434ffd1e940b3p+0,
        -0x1.dfe9b1e8b681p-1, -0x1.38f8fc849031fp-2, 0x1.56b005794965dp-3, 0x1.dd9049f5ef30fp-2,
        0x1.427d8d3c864fap-1, 0x1.3e0145fdc3ac8p-1};
    static const spatial2_cart_real v_next_expected[8] = {-0x1.4c2c0e2586791p+0, 0x1.1e909d82c564fp-1,
        0x1.ff7945adfdf2ap-3, -0x1.0e1b6ea2af198p+0, -0x1.0e749b1d8965fp-1, 0x1.de9b8c6e95736p+0,
        0x1.49a7abe2e6685p-3, -0x1.91298e48c234dp+0};
    spatial2_cart_real q_next[8];
    spatial2_cart_real v_next[8];
    int failures = 0;

    spatial2_cart_step(0x1p-14, q, v, u, q_next, v_next);
    failures += compare("step, q_next", 8, q_next, q_next_expected, SPATIAL2_CART_STEP_TOLERANCE);
    failures += compare("step, v_next", 8, v_next, v_next_expected, SPATIAL2_CART_STEP_TOLERANCE);
    return failures;
}

static int case_28(void)
{
    static const spatial2_cart_real q[8] = {0x1.e161d2b174134p-1, 0x1.1659a0f4e0aap+0, -0x1.943e1172edeeap-1,
        0x1.2f8a6cf31080cp-1, -0x1.44d70ebeacf41p-3, -0x1.e6076f13860ddp-1, 0x1.1472391fede6fp-2,
        0x1.4a3104285b7c9p-3};
    static const spatial2_cart_real v[8] = {0x1.6444a9a7c1488p-1, 0x1.69a89b2b3232p-1, -0x1.d8c12406af2adp-1,
        -0x1.580804d52fe16p+0, -0x1.b51454bb2755dp-2, -0x1.cc98f27c1ec59p-2, -0x1.fb7db5972afedp-1,
        -0x1.fa30945899179p-1};
    static const spatial2_cart_real q_out_expected[8] = {0x1.e161d2b174134p-1, 0x1.1659a0f4e0aap+0,
        -0x1.943e1172edeeap-1, 0x1.2f8a6cf31080cp-1, -0x1.44d70ebeacf41p-3, -0x1.e6076f13860ddp-1,
        0x1.1472391fede6fp-2, 0x1.4a3104285b7c9p-3};
    static const spatial2_cart_real v_out_expected[8] = {0x1.6444a9a7c1488p-1, 0x1.69a89b2b3232p-1,
        -0x1.d8c12406af2adp-1, -0x1.580804d52fe16p+0, -0x1.b51454bb2755dp-2, -0x1.cc98f27c1ec59p-2,
        -0x1.fb7db5972afedp-1, -0x1.fa30945899179p-1};
    spatial2_cart_real q_out[8];
    spatial2_cart_real v_out[8];
    int failures = 0;

    spatial2_cart_project(q, v, q_out, v_out);
    failures += compare("project, q_out", 8, q_out, q_out_expected, SPATIAL2_CART_PROJECT_TOLERANCE);
    failures += compare("project, v_out", 8, v_out, v_out_expected, SPATIAL2_CART_PROJECT_TOLERANCE);
    return failures;
}

static int case_29(void)
{
    static const spatial2_cart_real q[8] = {-0x1.b0e7d2f86495p+0, 0x1.550dafa2a5b56p+0, 0x1.bfd381cad6cf1p-2,
        0x1.6ce67574f7492p-1, 0x1.18cf95582a7b9p-1, -0x1.f4d96c3b771e4p-2, 0x1.2d07f630edafp-1,
        0x1.49ddc530bbc61p-1};
    static const spatial2_cart_real v[8] = {-0x1.f95dddda9b728p-1, -0x1.2d13146bf0a2cp-1,
        -0x1.2a6641ca51cb6p-2, -0x1.914df07d75ee1p-2, 0x1.7bb4f4ded8251p-1, 0x1.0f7060b741b4ep+0,
        -0x1.6c9c6f6c127c8p-1, 0x1.74700e3e7fa47p+0};
    static const spatial2_cart_real q_out_expected[8] = {-0x1.b0e7d2f86495p+0, 0x1.550dafa2a5b56p+0,
        0x1.bfd381cad6cf1p-2, 0x1.6ce67574f7492p-1, 0x1.18cf95582a7b9p-1, -0x1.f4d96c3b771e4p-2,
        0x1.2d07f630edafp-1, 0x1.49ddc530bbc61p-1};
    static const spatial2_cart_real v_out_expected[8] = {-0x1.f95dddda9b728p-1, -0x1.2d13146bf0a2cp-1,
        -0x1.2a6641ca51cb6p-2, -0x1.914df07d75ee2p-2, 0x1.7bb4f4ded8251p-1, 0x1.0f7060b741b4ep+0,
        -0x1.6c9c6f6c127c8p-1, 0x1.74700e3e7fa47p+0};
    spatial2_cart_real q_out[8];
    spatial2_cart_real v_out[8];
    int failures = 0;

    spatial2_cart_project(q, v, q_out, v_out);
    failures += compare("project, q_out", 8, q_out, q_out_expected, SPATIAL2_CART_PROJECT_TOLERANCE);
    failures += compare("project, v_out", 8, v_out, v_out_expected, SPATIAL2_CART_PROJECT_TOLERANCE);
    return failures;
}

static int case_30(void)
{
    static const spatial2_cart_real q[8] = {-0x1.e554402c95b7cp-1, 0x1.472340451d25p-3, 0x1.61100d1f6cdc9p-1,
        -0x1.3e160745bdf1ap-1, -0x1.7d1d37c73ad26p-2, -0x1.a3c813081eb2dp-2, -0x1.0267a0ef44907p-1,
        0x1.84fea03ea33f3p-1};
    static const spatial2_cart_real v[8] = {0x1.f82dcd8a9429p-2, 0x1.e0dad3d698ecap+0, 0x1.4983fad8d4d5ap-1,
        0x1.e4fc5648aebf7p-1, -0x1.8e11f0ff1b3dap-2, -0x1.3409923ed3bd4p+1, 0x1.1ad9b32948b68p-1,
        -0x1.dcf0857f090fdp-1};
    static const spatial2_cart_real q_out_expected[8] = {-0x1.e554402c95b7cp-1, 0x1.472340451d25p-3,
        0x1.61100d1f6cdc9p-1, -0x1.3e160745bdf1ap-1, -0x1.7d1d37c73ad26p-2, -0x1.a3c813081eb2dp-2,
        -0x1.0267a0ef44907p-1, 0x1.84fea03ea33f3p-1};
    static const spatial2_cart_real v_out_expected[8] = {0x1.f82dcd8a9429p-2, 0x1.e0dad3d698ecap+0,
        0x1.4983fad8d4d5ap-1, 0x1.e4fc5648aebf7p-1, -0x1.8e11f0ff1b3dap-2, -0x1.3409923ed3bd4p+1,
        0x1.1ad9b32948b69p-1, -0x1.dcf0857f090fep-1};
    spatial2_cart_real q_out[8];
    spatial2_cart_real v_out[8];
    int failures = 0;

    spatial2_cart_project(q, v, q_out, v_out);
    failures += compare("project, q_out", 8, q_out, q_out_expected, SPATIAL2_CART_PROJECT_TOLERANCE);
    failures += compare("project, v_out", 8, v_out, v_out_expected, SPATIAL2_CART_PROJECT_TOLERANCE);
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
    printf("%s\n", failures ? "FAILED" : "all passed");
    return failures;
}
