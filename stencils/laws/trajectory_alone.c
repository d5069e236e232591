/* trajectory.c compiled without a law: what one puts into it. */
#define PHI_NX 4
#define PHI_NU 1
#if WITH_OBSERVER
#define PHI_READ 2
#if WITH_LEARNING
#define PHI_MEMORY 5
#define PHI_ROW 31
#define PHI_HELD 33
#else
#define PHI_MEMORY 4
#define PHI_ROW 27
#endif
#else
#define PHI_READ 4
#define PHI_ROW 9
#endif
#define PHI_KNOTS 3

typedef float phi_real;
typedef enum phi_phase { PHI_SWINGING, PHI_HOLDING, PHI_LOST } phi_phase;
typedef struct phi_state {
    phi_phase phase;
#if WITH_OBSERVER
    phi_real expected[PHI_MEMORY];
#endif
} phi_state;

phi_phase phi_law(phi_state *state, phi_real t, const phi_real measured[PHI_READ], phi_real u[PHI_NU]);
#if WITH_OBSERVER
void phi_reset(phi_state *state, const phi_real measured[PHI_READ]);
#else
void phi_reset(phi_state *state);
#endif

static const phi_real phi_rate = 100, phi_tube = 1;
#if WITH_RAIL
static const phi_real phi_rail = 1;
#endif
static const phi_real phi_table[PHI_KNOTS][PHI_ROW];
#if WITH_LEARNING
static const phi_real phi_held[PHI_HELD];
#endif

#if WITH_OBSERVER
#if WITH_LEARNING
static void phi_holding(const phi_real y_meas[PHI_READ], const phi_real expected[PHI_MEMORY], const phi_real held[PHI_HELD],
    phi_real u[PHI_NU], phi_real *off, phi_real following[PHI_MEMORY])
{
    u[0] = held[2];
    *off = y_meas[1] * y_meas[1];
    for (int i = 0; i < PHI_MEMORY; ++i) {
        following[i] = expected[i];
    }
}

#endif
static void phi_tracking(const phi_real y_meas[PHI_READ], const phi_real expected[PHI_MEMORY], const phi_real here[PHI_ROW],
    const phi_real next[PHI_ROW], const phi_real f, phi_real u[PHI_NU], phi_real *off, phi_real following[PHI_MEMORY])
{
    u[0] = here[4] + f * (next[4] - here[4]);
    *off = y_meas[1] * y_meas[1];
    for (int i = 0; i < PHI_MEMORY; ++i) {
        following[i] = expected[i];
    }
}

static void phi_beginning(const phi_real y_meas[PHI_READ], const phi_real here[PHI_ROW], phi_real following[PHI_MEMORY])
{
    for (int i = 0; i < PHI_MEMORY; ++i) {
        following[i] = i < PHI_READ ? y_meas[i] - here[i] : 0;
    }
}
#else
static void phi_tracking(const phi_real x_meas[PHI_NX], const phi_real here[PHI_ROW], const phi_real next[PHI_ROW], const phi_real f,
    phi_real u[PHI_NU], phi_real *off)
{
    u[0] = here[4] + f * (next[4] - here[4]);
    *off = x_meas[1] * x_meas[1];
}
#endif

#include "laws/trajectory.c"
