/* a b + c, rounded once. Where no instruction does it, nothing contracts either, and the product's rounding error is found
 * from halves (Dekker 1971). */
static phi_real stem_fused(const phi_real a, const phi_real b, const phi_real c)
{
#if defined(PHI_FAST_FMA) || defined(PHI_FMA_OF_GCC)
    return phi_fma(a, b, c);
#else
    const phi_real wide_a = a * PHI_HALVES, high_a = wide_a - (wide_a - a), low_a = a - high_a;
    const phi_real wide_b = b * PHI_HALVES, high_b = wide_b - (wide_b - b), low_b = b - high_b;
    const phi_real product = a * b, sum = product + c, part = sum - product;
    const phi_real rest = (((high_a * high_b - product) + high_a * low_b) + low_a * high_b) + low_a * low_b;
    return sum + (((product - (sum - part)) + (c - part)) + rest);
#endif
}
