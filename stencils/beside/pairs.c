/* Numbers with what rounding took from them: the value as a processor has it, and the rest, to first order. A product goes nowhere but
 * through its own rest, so that no compiler may contract it. */
typedef struct stem_pair {
    phi_real value, rest;
} stem_pair;

static STEM_IN_PLACE stem_pair stem_add(const stem_pair a, const stem_pair b)
{
    const phi_real sum = a.value + b.value, part = sum - a.value;
    const stem_pair found = {sum, ((a.value - (sum - part)) + (b.value - part)) + (a.rest + b.rest)};
    return found;
}

static STEM_IN_PLACE stem_pair stem_negative(const stem_pair a)
{
    const stem_pair found = {-a.value, -a.rest};
    return found;
}

static STEM_IN_PLACE stem_pair stem_subtract(const stem_pair a, const stem_pair b)
{
    return stem_add(a, stem_negative(b));
}

static STEM_IN_PLACE stem_pair stem_multiply(const stem_pair a, const stem_pair b)
{
    const phi_real product = a.value * b.value;
    const stem_pair found = {product, stem_fused(a.value, b.value, -product) + (a.value * b.rest + a.rest * b.value)};
    return found;
}

/* By a number that has no rest. */
static STEM_IN_PLACE stem_pair stem_scale(const stem_pair a, const phi_real by)
{
    const phi_real product = a.value * by;
    const stem_pair found = {product, stem_fused(a.value, by, -product) + a.rest * by};
    return found;
}

static STEM_IN_PLACE stem_pair stem_divide(const stem_pair a, const stem_pair b)
{
    const phi_real quotient = a.value / b.value;
    const stem_pair found = {quotient, (stem_fused(-quotient, b.value, a.value) + (a.rest - quotient * b.rest)) / b.value};
    return found;
}

/* Sine and cosine: what is left of an angle beside multiples of a right one, and their series, of which the first terms have rests. */
static void stem_sine_cosine(const stem_pair *angle, stem_pair *sine, stem_pair *cosine)
{
    const phi_real high = PHI_TURN_HIGH / 4, low = PHI_TURN_LOW / 4;
    const phi_real whole = (angle->value * (1 / high) + PHI_ROUNDER) - PHI_ROUNDER, large = whole * high;
    const phi_real near = angle->value - large, beside = angle->rest - (stem_fused(whole, high, -large) + whole * low);
    const stem_pair one = {1, 0}, sixth = {-0x1.5555555555555p-3, -0x1.5555555555555p-57}, of_fifth = {0x1.1111111111111p-7, 0x1.1111111111111p-63};
    const stem_pair half = {-PHI_HALF, 0}, of_fourth = {0x1.5555555555555p-5, 0x1.5555555555555p-59};
    const stem_pair x = {near + beside, beside - ((near + beside) - near)}, square = stem_multiply(x, x);
    const phi_real z = square.value;
    const phi_real odd = ((z * (-1 / 355687428096000.0) + 1 / 1307674368000.0) * z - 1 / 6227020800.0) * z + 1 / 39916800.0;
    const phi_real even = ((z * (-1 / 6402373705728000.0) + 1 / 20922789888000.0) * z - 1 / 87178291200.0) * z + 1 / 479001600.0;
    const stem_pair seventh = {((odd * z - 1 / 362880.0) * z + 1 / 5040.0) * -1, 0};
    const stem_pair sixth_order = {(((even * z - 1 / 3628800.0) * z + 1 / 40320.0) * z - 1 / 720.0), 0};
    const stem_pair s = stem_add(x, stem_multiply(stem_multiply(x, square), stem_add(sixth, stem_multiply(square, stem_add(of_fifth, stem_multiply(square, seventh))))));
    const stem_pair c = stem_add(one, stem_multiply(square, stem_add(half, stem_multiply(square, stem_add(of_fourth, stem_multiply(square, sixth_order))))));
    const int turned = (int)(whole - 4 * ((whole / 4 + PHI_ROUNDER) - PHI_ROUNDER)) & 3;
    const stem_pair first = turned & 1 ? c : s, second = turned & 1 ? s : c;
    *sine = turned & 2 ? stem_negative(first) : first;
    *cosine = (turned + 1) & 2 ? stem_negative(second) : second;
}
