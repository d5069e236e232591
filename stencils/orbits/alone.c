/* The stencils of brake orbits compiled without a scene: what one puts into them. */
#include <float.h>
#include <math.h>
#include <stddef.h>
#include <string.h>

#ifndef PHI_Q
#define PHI_Q 3
#define PHI_CART 1
#endif
typedef double phi_real;
typedef struct phi_flow {
    phi_real t, tolerance, *transition;
    int columns;
    unsigned long steps;
} phi_flow;
#define CONTEXT
#define PASS
#define MASS_PASS
#define PHI_FLOW_DONE 0
#define PHI_FLOW(flow, t_end, most, u, q, v) phi_propagate(flow, t_end, most, u, q, v)
int phi_propagate(phi_flow *flow, phi_real t_end, unsigned long most, const phi_real *u, phi_real *q, phi_real *v);
void phi_mass_matrix(const phi_real *q, phi_real *mass);
#if PHI_CART
#define PHI_ENERGY(q, v, kinetic, potential) phi_energy(q, v, kinetic, potential)
void phi_energy(const phi_real *q, const phi_real *v, phi_real *kinetic, phi_real *potential);
#endif
#include "orbits/desk.c"
#include "orbits/small.c"
#include "orbits/touch.c"
#include "orbits/brake.c"
#include "orbits/newton.c"
#include "orbits/run.c"
#include "orbits/zero.c"
#include "orbits/dips.c"
#include "orbits/met.c"
#include "orbits/calls.c"
