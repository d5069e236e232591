/* trajectory.c compiled without a law: what one puts into it. */
#define PHI_NX 4
#define PHI_NU 1
#define PHI_KNOTS 3

typedef float phi_real;
typedef enum phi_phase { PHI_SWINGING, PHI_HOLDING, PHI_LOST } phi_phase;
typedef struct phi_state {
    phi_phase phase;
} phi_state;

phi_phase phi_law(phi_state *state, phi_real t, const phi_real x_meas[PHI_NX], phi_real u[PHI_NU]);
void phi_reset(phi_state *state);

static const phi_real phi_rate = 100, phi_tube = 1;
#if WITH_RAIL
static const phi_real phi_rail = 1;
#endif
static const phi_real phi_table[PHI_KNOTS][PHI_NX + PHI_NU + PHI_NU * PHI_NX];

static void phi_tracking(const phi_real x_meas[PHI_NX], const phi_real here[9], const phi_real next[9], const phi_real f, phi_real u[PHI_NU], phi_real *off)
{
    u[0] = here[4] + f * (next[4] - here[4]);
    *off = x_meas[1] * x_meas[1];
}

#include "trajectory.c"
