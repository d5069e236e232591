/* A firmware-style main loop around generated code: fixed step, no allocation, the energy as a health check.
 *
 *     make generate N=4
 *     cc -std=c99 -O2 -I generated/planar4 examples/firmware/main.c generated/planar4/planar4.c -lm -o swing && ./swing
 */
#include <math.h>
#include <stdio.h>

#include "planar4.h"

enum { LINKS = 4, STEPS_PER_SECOND = 1000, SECONDS = 5 };

static double total_energy(const planar4_real *q, const planar4_real *v)
{
    planar4_real kinetic, potential;
    planar4_energy(q, v, &kinetic, &potential);
    return (double)kinetic + (double)potential;
}

int main(void)
{
    /* Two states take turns, because outputs must not overlap inputs. */
    planar4_real q[2][LINKS] = {{0.5, 0.0, 0.0, 0.0}};
    planar4_real v[2][LINKS] = {{0.0, 0.0, 0.0, 0.0}};
    const planar4_real torque[LINKS] = {0.0, 0.0, 0.0, 0.0};
    const planar4_real h = (planar4_real)1.0 / STEPS_PER_SECOND;
    const double start = total_energy(q[0], v[0]);
    int now = 0;

    for (int second = 1; second <= SECONDS; ++second) {
        for (int tick = 0; tick < STEPS_PER_SECOND; ++tick, now = !now) {
            planar4_step(h, q[now], v[now], torque, q[!now], v[!now]);
        }
        printf("t = %d s  theta_1 = % .9f rad  energy error = % .1e J\n", second, (double)q[now][0],
               total_energy(q[now], v[now]) - start);
    }
    return fabs(total_energy(q[now], v[now]) - start) < 1e-6 ? 0 : 1;
}
