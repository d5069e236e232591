/* Sums of blocks of four orders beside plain ones: prints how far they are apart. */
#include "alone.h"
#include <stdio.h>
#if WITH_SHARED
#include "flow/shared_sums.c"
/* One multiplier serves three lanes. */
#define RIGHT(k) ((k) < stem_lefts ? (k) / 3 : stem_masses + (k) - stem_lefts)
#else
#include "flow/sums.c"
#define RIGHT(k) (k)
#endif
#define AT(x) STEM_OF(x, 0)
static stem_jets whole;
static phi_real left[32][stem_lefts], right[32][stem_lefts * stem_rights];
static void reveal(int n)
{
    stem_jets *jet = &whole;
    for (int i = 0; i < stem_lefts; ++i) STEM_LEFT(n)[i] = STEM_ZERO + left[n][i];
    for (int k = 0; k < stem_lefts * stem_rights; ++k) jet->right[n][RIGHT(k)] = STEM_ZERO + right[n][k];
}
static double off(int n, const stem_lanes *sums)
{
    double worst = 0;
    for (int k = 0; k < stem_all; ++k) {
        const int products = stem_lefts * stem_rights, first = WITH_SHARED ? 3 * (k - products) : k - products;
        double sum = 0;
        for (int j = 0; j <= n; ++j) {
            if (k < products) sum += left[j][k % stem_lefts] * right[n - j][k];
            else for (int i = first; i <= first + 2 * WITH_SHARED; ++i) sum += left[j][i] * left[n - j][i];
        }
        const double apart = fabs(AT(sums[k]) - sum);
        worst = apart <= worst ? worst : apart;
    }
    return worst;
}
int main(void)
{
    unsigned seed = 1;
    for (int n = 0; n < 32; ++n) {
        for (int i = 0; i < stem_lefts; ++i) left[n][i] = (double)((seed = seed * 1664525u + 1013904223u) >> 8) / (1 << 24) - 0.5;
        for (int k = 0; k < stem_lefts * stem_rights; ++k) right[n][k] = WITH_SHARED && k < stem_lefts && k % 3 ? right[n][k - 1] : (double)((seed = seed * 1664525u + 1013904223u) >> 8) / (1 << 24) - 0.5;
    }
    for (int first = 4; first < 19; ++first) {
        memset(&whole, 255, sizeof whole); /* rows that are not known yet are no numbers */
        for (int n = 0; n <= first; ++n) reveal(n);
        stem_ahead(first, &whole);
        stem_square_ahead(first, &whole);
        printf("%g\n", off(first, whole.sums[0]));
        for (int turn = 1; turn < 4; ++turn) {
            reveal(first + turn);
            stem_rest(first + turn, turn, &whole);
#if !WITH_SHARED
            stem_square_rest(first + turn, turn, &whole);
#endif
            printf("%g\n", off(first + turn, whole.sums[turn]));
        }
    }
    for (int n = 1; n < 8; ++n) {
        memset(&whole, 255, sizeof whole);
        for (int j = 0; j <= n; ++j) reveal(j);
        stem_sums(n, &whole, whole.sums[0]);
#if !WITH_SHARED
        stem_square_sums(n, &whole, whole.sums[0] + stem_lefts * stem_rights);
#endif
        printf("%g\n", off(n, whole.sums[0]));
    }
    return 0;
}
