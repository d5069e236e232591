/* Self-test of cart1_float.
 *
 * Every function is compared with the un-lowered Lagrangian in 50 digits, rounded once; Jacobians along
 * one direction each. Build it with cart1_float.c and run it: it says how each comparison ended, and the
 * exit code is the number of failures. On a target define CART1_FLOAT_NO_MAIN and call
 * cart1_float_selftest from your own main: that needs nothing of the C library.
 */
#include "cart1_float.h"
#ifndef CART1_FLOAT_NO_MAIN
#include <stdio.h>
#endif

int cart1_float_selftest(void);

/* Who is told of each comparison; a null pointer for nobody. */
typedef void listener(const char *what, cart1_float_real error, cart1_float_real tolerance, int failed);

/* The size of a number. */
static cart1_float_real size_of(cart1_float_real x)
{
    return x < 0.0F ? -x : x;
}

/* Largest error over largest expected entry; NaN fails. Returns the number of failures, 0 or 1. */
static int compare(listener *tell, const char *what, int count, const cart1_float_real *found,
    const cart1_float_real *expected, cart1_float_real tolerance)
{
    cart1_float_real worst = 0.0F;
    cart1_float_real scale = 0.0F;
    int failed = 0;

    for (int i = 0; i < count; ++i) {
        const cart1_float_real error = size_of(found[i] - expected[i]);

        worst = error > worst ? error : worst;
        scale = size_of(expected[i]) > scale ? size_of(expected[i]) : scale;
        failed |= !(error >= 0.0F);
    }
    if (scale > 0.0F) {
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
    static const cart1_float_params parameters = {
        .mass = {0x1.76d05cp+0F},
        .length = {0x1.92e656p-1F},
        .com = {0x1.ac3c66p-2F},
        .cart_mass = 0x1.5e0458p+0F,
        .gravity = 0x1.38eb08p+0F,
        .damping = {0x1.d93de8p-1F},
        .stiffness = {0x1.b8c8c4p+0F},
    };
    static const cart1_float_real q[2] = {0x1.fc9798p+0F, -0x1.76c6ep+0F};
    static const cart1_float_real v[2] = {-0x1.b0d85ep-1F, -0x1.daaab4p-4F};
    static const cart1_float_real u[1] = {-0x1.860d5ep+0F};
    static const cart1_float_real a_expected[2] = {-0x1.b3044p-1F, 0x1.ac53eep+3F};
    cart1_float_real a[2];
    int failures = 0;

    cart1_float_forward_dynamics(&parameters, q, v, u, a);
    failures += compare(tell, "forward_dynamics", 2, a, a_expected, CART1_FLOAT_FORWARD_DYNAMICS_TOLERANCE);
    return failures;
}

static int case_2(listener *tell)
{
    static const cart1_float_params parameters = {
        .mass = {0x1.655d92p-1F},
        .length = {0x1.9eda5cp-1F},
        .com = {0x1.49c18p-2F},
        .cart_mass = 0x1.18ac4p+0F,
        .gravity = 0x1.e609f4p-1F,
        .damping = {0x1.3bb9fep+0F},
        .stiffness = {0x1.d5552cp+0F},
    };
    static const cart1_float_real q[2] = {-0x1.3f01ccp-4F, -0x1.5f936ep-4F};
    static const cart1_float_real v[2] = {-0x1.7a7166p+0F, -0x1.b4fcdap+0F};
    static const cart1_float_real u[1] = {-0x1.d4a46p-1F};
    static const cart1_float_real a_expected[2] = {-0x1.d2760cp+2F, 0x1.b07e6ep+5F};
    cart1_float_real a[2];
    int failures = 0;

    cart1_float_forward_dynamics(&parameters, q, v, u, a);
    failures += compare(tell, "forward_dynamics", 2, a, a_expected, CART1_FLOAT_FORWARD_DYNAMICS_TOLERANCE);
    return failures;
}

static int case_3(listener *tell)
{
    static const cart1_float_params parameters = {
        .mass = {0x1.a915ccp+0F},
        .length = {0x1.a9a184p-1F},
        .com = {0x1.5bd966p-2F},
        .cart_mass = 0x1.8a12cap-1F,
        .gravity = 0x1.78a7dp-1F,
        .damping = {0x1.c7adc6p-1F},
        .stiffness = {0x1.91b534p+0F},
    };
    static const cart1_float_real q[2] = {-0x1.6beb18p+0F, 0x1.a5058cp+0F};
    static const cart1_float_real v[2] = {-0x1.3159ep-1F, -0x1.1e4a58p+0F};
    static const cart1_float_real u[1] = {-0x1.9faac2p-2F};
    static const cart1_float_real a_expected[2] = {-0x1.cdb69ep-5F, -0x1.4e454ep+3F};
    cart1_float_real a[2];
    int failures = 0;

    cart1_float_forward_dynamics(&parameters, q, v, u, a);
    failures += compare(tell, "forward_dynamics", 2, a, a_expected, CART1_FLOAT_FORWARD_DYNAMICS_TOLERANCE);
    return failures;
}

static int case_4(listener *tell)
{
    static const cart1_float_params parameters = {
        .mass = {0x1.a3eb7p+0F},
        .length = {0x1.9d872ap-1F},
        .com = {0x1.bd70fap-2F},
        .cart_mass = 0x1.07899ep-1F,
        .gravity = 0x1.259436p+0F,
        .damping = {0x1.f94734p+0F},
        .stiffness = {0x1.1e50e6p-1F},
    };
    static const cart1_float_real q[2] = {0x1.e36df8p+0F, 0x1.781974p+0F};
    static const cart1_float_real v[2] = {-0x1.4e826ep-1F, 0x1.32f6e2p-1F};
    static const cart1_float_real kinetic_expected[1] = {0x1.f30e92p-2F};
    static const cart1_float_real potential_expected[1] = {0x1.0a786cp-1F};
    cart1_float_real kinetic;
    cart1_float_real potential;
    int failures = 0;

    cart1_float_energy(&parameters, q, v, &kinetic, &potential);
    failures += compare(tell, "energy, kinetic", 1, &kinetic, kinetic_expected, CART1_FLOAT_ENERGY_TOLERANCE);
    failures += compare(tell, "energy, potential", 1, &potential, potential_expected,
        CART1_FLOAT_ENERGY_TOLERANCE);
    return failures;
}

static int case_5(listener *tell)
{
    static const cart1_float_params parameters = {
        .mass = {0x1.ea5f38p-1F},
        .length = {0x1.f4caa2p-1F},
        .com = {0x1.41bb66p-2F},
        .cart_mass = 0x1.2e467p+0F,
        .gravity = 0x1.ffb1fap-1F,
        .damping = {0x1.8190ccp+0F},
        .stiffness = {0x1.76e6aep-1F},
    };
    static const cart1_float_real q[2] = {0x1.a711ep+0F, 0x1.efaaf8p+0F};
    static const cart1_float_real v[2] = {-0x1.73f51cp-1F, -0x1.eafa26p+0F};
    static const cart1_float_real kinetic_expected[1] = {0x1.2d41ap-1F};
    static const cart1_float_real potential_expected[1] = {0x1.7ae018p+0F};
    cart1_float_real kinetic;
    cart1_float_real potential;
    int failures = 0;

    cart1_float_energy(&parameters, q, v, &kinetic, &potential);
    failures += compare(tell, "energy, kinetic", 1, &kinetic, kinetic_expected, CART1_FLOAT_ENERGY_TOLERANCE);
    failures += compare(tell, "energy, potential", 1, &potential, potential_expected,
        CART1_FLOAT_ENERGY_TOLERANCE);
    return failures;
}

static int case_6(listener *tell)
{
    static const cart1_float_params parameters = {
        .mass = {0x1.0745e2p-1F},
        .length = {0x1.60a0fep-1F},
        .com = {0x1.a0af5ep-2F},
        .cart_mass = 0x1.cca8b8p+0F,
        .gravity = 0x1.bc4bf4p-1F,
        .damping = {0x1.0716fp+0F},
        .stiffness = {0x1.ac0c8ap+0F},
    };
    static const cart1_float_real q[2] = {0x1.015acep+0F, 0x1.53cc0cp+0F};
    static const cart1_float_real v[2] = {0x1.41f82p-1F, 0x1.dbef72p+0F};
    static const cart1_float_real kinetic_expected[1] = {0x1.53c062p-1F};
    static const cart1_float_real potential_expected[1] = {0x1.6ddd8ap+0F};
    cart1_float_real kinetic;
    cart1_float_real potential;
    int failures = 0;

    cart1_float_energy(&parameters, q, v, &kinetic, &potential);
    failures += compare(tell, "energy, kinetic", 1, &kinetic, kinetic_expected, CART1_FLOAT_ENERGY_TOLERANCE);
    failures += compare(tell, "energy, potential", 1, &potential, potential_expected,
        CART1_FLOAT_ENERGY_TOLERANCE);
    return failures;
}

static int case_7(listener *tell)
{
    static const cart1_float_params parameters = {
        .mass = {0x1.fb877cp+0F},
        .length = {0x1.81a39ep-1F},
        .com = {0x1.d9bb74p-2F},
        .cart_mass = 0x1.135a22p-1F,
        .gravity = 0x1.1b9404p+0F,
        .damping = {0x1.cfd2ccp+0F},
        .stiffness = {0x1.7dec6cp+0F},
    };
    static const cart1_float_real s[1] = {-0x1p+0F};
    static const cart1_float_real M_expected[4] = {0x1.429a46p+1F, -0x1.d5987cp-1F, -0x1.d5987cp-1F,
        0x1.b27f4cp-2F};
    static const cart1_float_real G_expected[4] = {0.0F, 0.0F, 0.0F, 0x1.e7538ap-2F};
    static const cart1_float_real D_expected[4] = {0.0F, 0.0F, 0.0F, 0x1.cfd2ccp+0F};
    static const cart1_float_real B_expected[2] = {0x1p+0F, 0.0F};
    cart1_float_real M[4];
    cart1_float_real G[4];
    cart1_float_real D[4];
    cart1_float_real B[2];
    int failures = 0;

    cart1_float_linearization(&parameters, s, M, G, D, B);
    failures += compare(tell, "linearization, M", 4, M, M_expected, CART1_FLOAT_LINEARIZATION_TOLERANCE);
    failures += compare(tell, "linearization, G", 4, G, G_expected, CART1_FLOAT_LINEARIZATION_TOLERANCE);
    failures += compare(tell, "linearization, D", 4, D, D_expected, CART1_FLOAT_LINEARIZATION_TOLERANCE);
    failures += compare(tell, "linearization, B", 2, B, B_expected, CART1_FLOAT_LINEARIZATION_TOLERANCE);
    return failures;
}

static int case_8(listener *tell)
{
    static const cart1_float_params parameters = {
        .mass = {0x1.ef94ap+0F},
        .length = {0x1.7b05fap-1F},
        .com = {0x1.800f3cp-2F},
        .cart_mass = 0x1.95388p+0F,
        .gravity = 0x1.6f2894p+0F,
        .damping = {0x1.b03a3ep+0F},
        .stiffness = {0x1.252c32p+0F},
    };
    static const cart1_float_real s[1] = {0x1p+0F};
    static const cart1_float_real M_expected[4] = {0x1.c2669p+1F, 0x1.73be36p-1F, 0x1.73be36p-1F,
        0x1.16d9b8p-2F};
    static const cart1_float_real G_expected[4] = {0.0F, 0.0F, 0.0F, 0x1.17e04p+1F};
    static const cart1_float_real D_expected[4] = {0.0F, 0.0F, 0.0F, 0x1.b03a3ep+0F};
    static const cart1_float_real B_expected[2] = {0x1p+0F, 0.0F};
    cart1_float_real M[4];
    cart1_float_real G[4];
    cart1_float_real D[4];
    cart1_float_real B[2];
    int failures = 0;

    cart1_float_linearization(&parameters, s, M, G, D, B);
    failures += compare(tell, "linearization, M", 4, M, M_expected, CART1_FLOAT_LINEARIZATION_TOLERANCE);
    failures += compare(tell, "linearization, G", 4, G, G_expected, CART1_FLOAT_LINEARIZATION_TOLERANCE);
    failures += compare(tell, "linearization, D", 4, D, D_expected, CART1_FLOAT_LINEARIZATION_TOLERANCE);
    failures += compare(tell, "linearization, B", 2, B, B_expected, CART1_FLOAT_LINEARIZATION_TOLERANCE);
    return failures;
}

static int case_9(listener *tell)
{
    static const cart1_float_params parameters = {
        .mass = {0x1.148b6cp-1F},
        .length = {0x1.d5f3ep-1F},
        .com = {0x1.bdfba4p-2F},
        .cart_mass = 0x1.317d9cp-1F,
        .gravity = 0x1.678a78p+0F,
        .damping = {0x1.50d354p-1F},
        .stiffness = {0x1.58fc3cp+0F},
    };
    static const cart1_float_real s[1] = {-0x1p+0F};
    static const cart1_float_real M_expected[4] = {0x1.230484p+0F, -0x1.e1c63p-3F, -0x1.e1c63p-3F,
        0x1.a3a78ap-4F};
    static const cart1_float_real G_expected[4] = {0.0F, 0.0F, 0.0F, 0x1.04680cp+0F};
    static const cart1_float_real D_expected[4] = {0.0F, 0.0F, 0.0F, 0x1.50d354p-1F};
    static const cart1_float_real B_expected[2] = {0x1p+0F, 0.0F};
    cart1_float_real M[4];
    cart1_float_real G[4];
    cart1_float_real D[4];
    cart1_float_real B[2];
    int failures = 0;

    cart1_float_linearization(&parameters, s, M, G, D, B);
    failures += compare(tell, "linearization, M", 4, M, M_expected, CART1_FLOAT_LINEARIZATION_TOLERANCE);
    failures += compare(tell, "linearization, G", 4, G, G_expected, CART1_FLOAT_LINEARIZATION_TOLERANCE);
    failures += compare(tell, "linearization, D", 4, D, D_expected, CART1_FLOAT_LINEARIZATION_TOLERANCE);
    failures += compare(tell, "linearization, B", 2, B, B_expected, CART1_FLOAT_LINEARIZATION_TOLERANCE);
    return failures;
}

static int case_10(listener *tell)
{
    static const cart1_float_params parameters = {
        .mass = {0x1.7778cp+0F},
        .length = {0x1.84f5cap-1F},
        .com = {0x1.025b14p-2F},
        .cart_mass = 0x1.cb2b08p-1F,
        .gravity = 0x1.3363cp-1F,
        .damping = {0x1.58dbfp+0F},
        .stiffness = {0x1.e1c6c6p+0F},
    };
    static const cart1_float_real q[2] = {-0x1.4f15bcp+0F, 0x1.661efap-8F};
    static const cart1_float_real v[2] = {-0x1.df47c4p-1F, -0x1.faccdp-1F};
    static const cart1_float_real u[1] = {-0x1.f50f92p-2F};
    static const cart1_float_real slope_expected[2] = {-0x1.3ef846p+2F, 0x1.0b1988p+5F};
    static const cart1_float_real dadq_direction[2] = {-0x1.2d5592p-1F, -0x1.abb222p-1F};
    static const cart1_float_real dadv_direction[2] = {0x1.7eb4bp-4F, 0x1.78ad64p-2F};
    static const cart1_float_real dadu_direction[1] = {0x1.e47bdcp-1F};
    cart1_float_real dadq[4];
    cart1_float_real dadv[4];
    cart1_float_real dadu[2];
    cart1_float_real slope[2];
    int failures = 0;

    cart1_float_state_jacobian(&parameters, q, v, u, dadq, dadv, dadu);
    for (int i = 0; i < 2; ++i) {
        slope[i] = 0.0F;
        for (int j = 0; j < 2; ++j) {
            slope[i] += dadq[2 * i + j] * dadq_direction[j];
        }
        for (int j = 0; j < 2; ++j) {
            slope[i] += dadv[2 * i + j] * dadv_direction[j];
        }
        for (int j = 0; j < 1; ++j) {
            slope[i] += dadu[1 * i + j] * dadu_direction[j];
        }
    }
    failures += compare(tell, "state_jacobian", 2, slope, slope_expected,
        CART1_FLOAT_STATE_JACOBIAN_TOLERANCE);
    return failures;
}

static int case_11(listener *tell)
{
    static const cart1_float_params parameters = {
        .mass = {0x1.ef8ea8p+0F},
        .length = {0x1.8be67p-1F},
        .com = {0x1.4ae71ap-2F},
        .cart_mass = 0x1.e84f24p+0F,
        .gravity = 0x1.d70d96p+0F,
        .damping = {0x1.adadb6p+0F},
        .stiffness = {0x1.673a98p+0F},
    };
    static const cart1_float_real q[2] = {-0x1.de03d6p-1F, 0x1.2534d8p-2F};
    static const cart1_float_real v[2] = {-0x1.09317p+0F, 0x1.aa8756p+0F};
    static const cart1_float_real u[1] = {0x1.a8c2fap+0F};
    static const cart1_float_real slope_expected[2] = {-0x1.38608ep-3F, 0x1.b8182p+1F};
    static const cart1_float_real dadq_direction[2] = {-0x1.a6cd94p-1F, -0x1.6e71ccp-2F};
    static const cart1_float_real dadv_direction[2] = {0x1.1fd8ep-2F, -0x1.c5179cp-5F};
    static const cart1_float_real dadu_direction[1] = {-0x1.272b0cp-3F};
    cart1_float_real dadq[4];
    cart1_float_real dadv[4];
    cart1_float_real dadu[2];
    cart1_float_real slope[2];
    int failures = 0;

    cart1_float_state_jacobian(&parameters, q, v, u, dadq, dadv, dadu);
    for (int i = 0; i < 2; ++i) {
        slope[i] = 0.0F;
        for (int j = 0; j < 2; ++j) {
            slope[i] += dadq[2 * i + j] * dadq_direction[j];
        }
        for (int j = 0; j < 2; ++j) {
            slope[i] += dadv[2 * i + j] * dadv_direction[j];
        }
        for (int j = 0; j < 1; ++j) {
            slope[i] += dadu[1 * i + j] * dadu_direction[j];
        }
    }
    failures += compare(tell, "state_jacobian", 2, slope, slope_expected,
        CART1_FLOAT_STATE_JACOBIAN_TOLERANCE);
    return failures;
}

static int case_12(listener *tell)
{
    static const cart1_float_params parameters = {
        .mass = {0x1.f5f528p+0F},
        .length = {0x1.3116b4p-1F},
        .com = {0x1.226dbp-2F},
        .cart_mass = 0x1.243442p+0F,
        .gravity = 0x1.f7f288p-1F,
        .damping = {0x1.2b764ep+0F},
        .stiffness = {0x1.08018ap+0F},
    };
    static const cart1_float_real q[2] = {0x1.7c177cp-2F, 0x1.29bef4p-2F};
    static const cart1_float_real v[2] = {-0x1.8ac518p+0F, 0x1.97adfep-4F};
    static const cart1_float_real u[1] = {0x1.5b2ccep+0F};
    static const cart1_float_real slope_expected[2] = {0x1.3a09bp-1F, -0x1.695a26p-5F};
    static const cart1_float_real dadq_direction[2] = {0x1.5fddp-3F, -0x1.e4e884p-2F};
    static const cart1_float_real dadv_direction[2] = {-0x1.165d5ep-2F, 0x1.8b8f5p-3F};
    static const cart1_float_real dadu_direction[1] = {0x1.e9a6b8p-1F};
    cart1_float_real dadq[4];
    cart1_float_real dadv[4];
    cart1_float_real dadu[2];
    cart1_float_real slope[2];
    int failures = 0;

    cart1_float_state_jacobian(&parameters, q, v, u, dadq, dadv, dadu);
    for (int i = 0; i < 2; ++i) {
        slope[i] = 0.0F;
        for (int j = 0; j < 2; ++j) {
            slope[i] += dadq[2 * i + j] * dadq_direction[j];
        }
        for (int j = 0; j < 2; ++j) {
            slope[i] += dadv[2 * i + j] * dadv_direction[j];
        }
        for (int j = 0; j < 1; ++j) {
            slope[i] += dadu[1 * i + j] * dadu_direction[j];
        }
    }
    failures += compare(tell, "state_jacobian", 2, slope, slope_expected,
        CART1_FLOAT_STATE_JACOBIAN_TOLERANCE);
    return failures;
}

static int case_13(listener *tell)
{
    static const cart1_float_params parameters = {
        .mass = {0x1.a94252p+0F},
        .length = {0x1.bfdee8p-1F},
        .com = {0x1.d9a6ep-2F},
        .cart_mass = 0x1.16cbbcp+0F,
        .gravity = 0x1.8a574p-1F,
        .damping = {0x1.d4a8f8p-1F},
        .stiffness = {0x1.c2453p+0F},
    };
    static const cart1_float_real q[2] = {-0x1.7c0d46p+0F, -0x1.5c0e14p-2F};
    static const cart1_float_real v[2] = {0x1.5fb884p+0F, 0x1.8c567p+0F};
    static const cart1_float_real u[1] = {0x1.f2c7a2p-3F};
    static const cart1_float_real q_next_expected[2] = {-0x1.7c07c8p+0F, -0x1.5bf54ep-2F};
    static const cart1_float_real v_next_expected[2] = {0x1.5fbb56p+0F, 0x1.8c49bp+0F};
    cart1_float_real q_next[2];
    cart1_float_real v_next[2];
    int failures = 0;

    cart1_float_step(&parameters, 0x1p-14F, q, v, u, q_next, v_next);
    failures += compare(tell, "step, q_next", 2, q_next, q_next_expected, CART1_FLOAT_STEP_TOLERANCE);
    failures += compare(tell, "step, v_next", 2, v_next, v_next_expected, CART1_FLOAT_STEP_TOLERANCE);
    return failures;
}

static int case_14(listener *tell)
{
    static const cart1_float_params parameters = {
        .mass = {0x1.6dd9b8p-1F},
        .length = {0x1.8e3ad4p-1F},
        .com = {0x1.8b6886p-2F},
        .cart_mass = 0x1.a4d0cap+0F,
        .gravity = 0x1.2acceap-1F,
        .damping = {0x1.2f56f6p+0F},
        .stiffness = {0x1.d9837cp+0F},
    };
    static const cart1_float_real q[2] = {-0x1.e0f294p-3F, -0x1.22892p+0F};
    static const cart1_float_real v[2] = {0x1.782ap+0F, 0x1.3a7894p+0F};
    static const cart1_float_real u[1] = {0x1.d238aap-1F};
    static const cart1_float_real q_next_expected[2] = {-0x1.e0c38ep-3F, -0x1.228436p+0F};
    static const cart1_float_real v_next_expected[2] = {0x1.782968p+0F, 0x1.3a96dcp+0F};
    cart1_float_real q_next[2];
    cart1_float_real v_next[2];
    int failures = 0;

    cart1_float_step(&parameters, 0x1p-14F, q, v, u, q_next, v_next);
    failures += compare(tell, "step, q_next", 2, q_next, q_next_expected, CART1_FLOAT_STEP_TOLERANCE);
    failures += compare(tell, "step, v_next", 2, v_next, v_next_expected, CART1_FLOAT_STEP_TOLERANCE);
    return failures;
}

static int case_15(listener *tell)
{
    static const cart1_float_params parameters = {
        .mass = {0x1.d89ec4p+0F},
        .length = {0x1.a71786p-1F},
        .com = {0x1.200868p-2F},
        .cart_mass = 0x1.2bcdb2p-1F,
        .gravity = 0x1.c732cep+0F,
        .damping = {0x1.4512a6p+0F},
        .stiffness = {0x1.6f37f6p+0F},
    };
    static const cart1_float_real q[2] = {-0x1.0139cep+0F, -0x1.f4c2bep-4F};
    static const cart1_float_real v[2] = {-0x1.43cffep-2F, -0x1.8cf27p+0F};
    static const cart1_float_real u[1] = {0x1.1c078ap-1F};
    static const cart1_float_real q_next_expected[2] = {-0x1.013b12p+0F, -0x1.f525dep-4F};
    static const cart1_float_real v_next_expected[2] = {-0x1.449522p-2F, -0x1.8c06cap+0F};
    cart1_float_real q_next[2];
    cart1_float_real v_next[2];
    int failures = 0;

    cart1_float_step(&parameters, 0x1p-14F, q, v, u, q_next, v_next);
    failures += compare(tell, "step, q_next", 2, q_next, q_next_expected, CART1_FLOAT_STEP_TOLERANCE);
    failures += compare(tell, "step, v_next", 2, v_next, v_next_expected, CART1_FLOAT_STEP_TOLERANCE);
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
};
enum { case_count = (int)(sizeof cases / sizeof cases[0]) };

/* The number of the first case that fails, counted from 1; 0 where all pass. */
int cart1_float_selftest(void)
{
    for (int number = 0; number < case_count; ++number) {
        if (cases[number](0) != 0) {
            return number + 1;
        }
    }
    return 0;
}
#ifndef CART1_FLOAT_NO_MAIN

static void print(const char *what, cart1_float_real error, cart1_float_real tolerance, int failed)
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
