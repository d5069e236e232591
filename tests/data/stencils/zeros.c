/* Zeros of five functions, each with the looks that finding it took. */
#include "alone.h"
#include <stdio.h>
#include "flow/norms.c"
static int looks, which;
static phi_real stem_larger(const phi_real a, const phi_real b) { return a > b ? a : b; }
void phi_positions(const phi_real *q, phi_real *place) { (void)q, (void)place; }
static phi_real stem_entry(const int order, const stem_jets *jet, const int lane, const phi_real h, const int i)
{
    (void)order, (void)jet, (void)lane, (void)i;
    ++looks;
    return which == 0 ? cos(5 * h) : which == 1 ? exp(h) - 1.3 : which == 2 ? (h - 0.3) * (1 + h * h) : which == 3 ? 1e-9 - h : -sin(3 * (h + 0.7));
}
#include "flow/event.c"
int main(void)
{
    static const phi_real ends[5] = {0.5, 1, 1, 1, -1};
    const stem_event event = {STEM_OF_Q, 0, 0, 0};
    for (which = 0; which < 5; ++which) {
        const phi_real low = stem_entry(0, 0, 0, 0, 0), high = stem_entry(0, 0, 0, ends[which], 0);
        looks = 0;
        printf("%.17g ", stem_zero(22, 0, 0, &event, 0, 0, low, ends[which], high));
        printf("%d\n", looks);
    }
    return 0;
}
