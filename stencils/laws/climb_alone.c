/* climb.c compiled without a law: what one puts into it. */
#define PHI_NX 4
#define PHI_RUNGS 3
#define PHI_NODES 5

typedef float phi_real;
typedef enum phi_phase { PHI_CALMING, PHI_CLIMBING, PHI_HOLDING } phi_phase;
typedef struct phi_state {
    phi_phase phase;
    phi_real rung, at, side;
} phi_state;

phi_phase phi_law(phi_state *state, const phi_real x_meas[PHI_NX], phi_real u[1]);
void phi_reset(phi_state *state);

static const phi_real phi_sample = 0.001F, phi_pace = 2, phi_back = 0.5F, phi_follow = 0.2F, phi_tube = 0.25F, phi_rest = 0.01F, phi_leave = 4;
static const phi_real phi_slow[PHI_RUNGS], phi_rise[PHI_RUNGS];
static const phi_real phi_table[PHI_RUNGS][PHI_NODES + 2][9];

static void phi_catching(const phi_real x_meas[PHI_NX], phi_real u[1], phi_real *level)
{
    u[0] = -x_meas[2];
    *level = x_meas[0] * x_meas[0];
}

static void phi_calming(const phi_real x_meas[PHI_NX], phi_real u[1], phi_real *size)
{
    u[0] = -x_meas[2];
    *size = x_meas[1] * x_meas[1];
}

static void phi_following(const phi_real x_meas[PHI_NX], const phi_real below[9], const phi_real above[9], const phi_real slow[2], const phi_real f, const phi_real g,
    const phi_real side, phi_real u[1], phi_real *slip, phi_real *rate, phi_real *load, phi_real *off)
{
    u[0] = side * slow[0] * (below[0] + f * (above[0] - below[0]) + g * x_meas[0]);
    *slip = u[0];
    *rate = 1;
    *load = u[0];
    *off = x_meas[1] * x_meas[1];
}

#include "laws/climb.c"
