/* Sums of blocks of four orders beside plain ones: prints how far they are apart. */
#include "alone.h"
#include <stdio.h>
#if WITH_TRIPLES
#include "flow/triples.c"
#endif
#include "flow/sums.c"
#define AT(x) STEM_OF(x, 0)
static stem_jets jet;
static phi_real left[32][stem_lefts], right[32][stem_lefts * stem_rights];
static void reveal(int n)
{
    for (int i = 0; i < stem_lefts; ++i) jet.left[n][i] = STEM_ZERO + left[n][i];
    for (int k = 0; k < stem_lefts * stem_rights; ++k) jet.right[n][k] = STEM_ZERO + right[n][k];
}
static double off(int n, int turn)
{
    double worst = 0;
    for (int k = 0; k < stem_all; ++k) {
        double sum = 0;
        for (int j = 0; j <= n; ++j) sum += k < stem_lefts * stem_rights ? left[j][k % stem_lefts] * right[n - j][k] : left[j][k - stem_lefts * stem_rights] * left[n - j][k - stem_lefts * stem_rights];
        const double apart = fabs(AT(jet.sums[turn][k]) - sum);
        worst = apart <= worst ? worst : apart;
    }
    return worst;
}
int main(void)
{
    unsigned seed = 1;
    for (int n = 0; n < 32; ++n) {
        for (int i = 0; i < stem_lefts; ++i) left[n][i] = (double)((seed = seed * 1664525u + 1013904223u) >> 8) / (1 << 24) - 0.5;
        for (int k = 0; k < stem_lefts * stem_rights; ++k) right[n][k] = WITH_TRIPLES && k < stem_lefts && k % 3 ? right[n][k - 1] : (double)((seed = seed * 1664525u + 1013904223u) >> 8) / (1 << 24) - 0.5;
    }
    for (int first = 4; first < 19; ++first) {
        memset(&jet, 255, sizeof jet); /* rows that are not known yet are no numbers */
        for (int n = 0; n <= first; ++n) reveal(n);
        stem_ahead(first, &jet);
        stem_square_ahead(first, &jet);
        printf("%g\n", off(first, 0));
        for (int turn = 1; turn < 4; ++turn) {
            reveal(first + turn);
            stem_rest(first + turn, turn, &jet);
            stem_square_rest(first + turn, turn, &jet);
            printf("%g\n", off(first + turn, turn));
        }
    }
    return 0;
}
