/* Whether a function that has one sign at both ends of the last step but one may have the other one between: foretold from what is known already
 * (`continuation/met/dips.py` looks closer, and evaluates where it has to). */
#define DIP_BENT 4.0      /* how many times as far as it bent on the way to a step a function may bend within it */
#define DIP_HUMP 1.5      /* height of a hump, in its mean */
#define DIP_PLACES 64     /* at which polynomials are looked at within a step */
#define DIP_FEWER 3       /* polynomials of successive degrees, whose distances tell their error */
#define DIP_DOUBT 2.0     /* error of the best of them, in its largest distance from the others */
#define DIP_MARGIN 1e-2   /* height, in the least one of the ends, below which somebody else looks closer */
#define DIP_TOUCHED 4     /* nearest places at which the unknown itself is touched, and at one fewer */

/* A test function at one of the last places, divided by its distances from its zeros in the last step but one. */
static phi_real dip_divided(const brake_desk *desk, const int k, const int at)
{
    const int last = (int)desk->count - 1;
    const phi_real size = desk->at[last - 1] - desk->at[last - 2];
    phi_real value = desk->values[at][k];
    for (int i = 0; i < (int)desk->zero_count; ++i) {
        value = (int)desk->zeros[i][0] == k ? value / ((desk->at[at] - desk->zeros[i][1]) / size) : value;
    }
    return value;
}

/* The mean over the last step but one of a component of the tangent: it is the slope of an unknown, which is known at both ends. */
static phi_real dip_mean(const brake_desk *desk, const int k)
{
    const int last = (int)desk->count - 1, b = last - 1, a = last - 2, i = (int)desk->watch[k][1];
    return (desk->known[b][0][i] - desk->known[a][0][i]) / (desk->at[b] - desk->at[a]);
}

/* The polynomial through so many of some values, by Newton's divided differences, at a place. */
static phi_real dip_polynomial(const int count, const phi_real *at, const phi_real *shares, const phi_real place)
{
    phi_real value = shares[count - 1];
    for (int i = count - 2; i >= 0; --i) {
        value = value * (place - at[i]) + shares[i];
    }
    return value;
}

/* Whether a function of one sign at both ends of the last step but one stays clear of zero there wherever the polynomial through all that is known of it, or
 * one of those of lower degrees, turns: what is near enough to be looked at closer is not judged here. A whole one is not divided by zeros. */
static int dip_is_clear(const brake_desk *desk, const int k, const int is_whole)
{
    const int last = (int)desk->count - 1, first = last + 1 - (int)desk->seen, b = last - 1, a = last - 2;
    const phi_real from = desk->at[a], length = desk->at[b] - from, middle = from + length / 2;
    phi_real at[DESK_KNOWN], shares[DESK_KNOWN], heights[DIP_FEWER][DIP_PLACES + 1];
    int count = 0;
    /* The nearest first, of which those of lower degrees keep most. */
    for (int i = first; i <= last; ++i) {
        int j = count++;
        for (; j > 0 && fabs(at[j - 1] - middle) > fabs(desk->at[i] - middle); --j) {
            at[j] = at[j - 1];
            shares[j] = shares[j - 1];
        }
        at[j] = desk->at[i];
        shares[j] = dip_divided(desk, k, i);
    }
    if (count <= DIP_FEWER) {
        return 0;
    }
    const phi_real one = fabs(dip_divided(desk, k, a)), other = fabs(dip_divided(desk, k, b)), sign = dip_divided(desk, k, a) < 0 ? -1 : 1;
    phi_real margin = DIP_MARGIN * (one < other ? one : other), mean = 0;
    for (int order = 1; order < count; ++order) {
        for (int i = count - 1; i >= order; --i) {
            shares[i] = (shares[i] - shares[i - 1]) / (at[i] - at[i - order]);
        }
    }
    for (int i = 0; i <= DIP_PLACES; ++i) {
        for (int fewer = 0; fewer < DIP_FEWER; ++fewer) {
            heights[fewer][i] = sign * dip_polynomial(count - fewer, at, shares, from + length * i / DIP_PLACES);
        }
    }
    if (is_whole && desk->watch[k][3] > 1) {
        /* What its mean is off by values do not tell: the height of a hump. */
        for (int i = 0; i < DIP_PLACES; i += 2) {
            mean += sign * (heights[0][i] + 4 * heights[0][i + 1] + heights[0][i + 2]) / (3 * DIP_PLACES);
        }
        margin += DIP_BENT * DIP_HUMP * fabs(sign * dip_mean(desk, k) - mean);
    }
    if (!((one < other ? one : other) > margin)) {
        return 0;
    }
    for (int i = 1; i < DIP_PLACES; ++i) {
        int is_turn = 0;
        phi_real error = 0;
        for (int fewer = 0; fewer < DIP_FEWER; ++fewer) {
            const phi_real *own = heights[fewer] + i, off = fabs(own[0] - heights[0][i]);
            is_turn = is_turn || (own[0] - own[-1]) * (own[1] - own[0]) <= 0;
            error = off > error ? off : error;
        }
        if (is_turn && !(heights[0][i] - DIP_DOUBT * error > margin)) {
            return 0;
        }
    }
    return 1;
}

/* The same of a component of the tangent, which is known better than from its values: it is the slope of an unknown over the distance along the step, and the
 * polynomials touch that at the nearest places. */
static int dip_slope_is_clear(brake_desk *desk, const int k)
{
    const int last = (int)desk->count - 1, first = last + 1 - (int)desk->seen, b = last - 1, a = last - 2, which = (int)desk->watch[k][1];
    const phi_real middle = (desk->at[a] + desk->at[b]) / 2, one = fabs(desk->values[a][k]), other = fabs(desk->values[b][k]);
    phi_real near[DESK_KNOWN][2][DESK_ALL], axis[DESK_ALL], there[DESK_ALL], length = 0, from = 0, before[2] = {0};
    int ranked[DESK_KNOWN], count = 0;
    for (int i = first; i <= last; ++i) {
        int j = count++;
        for (; j > 0 && fabs(desk->at[ranked[j - 1]] - middle) > fabs(desk->at[i] - middle); --j) {
            ranked[j] = ranked[j - 1];
        }
        ranked[j] = i;
    }
    count = count < DIP_TOUCHED ? count : DIP_TOUCHED;
    for (int i = 0; i < count; ++i) {
        memcpy(near[i], desk->known[ranked[i]], sizeof near[i]);
    }
    for (int i = 0; i < brake_all; ++i) {
        axis[i] = desk->known[b][0][i] - desk->known[a][0][i];
        length += axis[i] * axis[i];
    }
    length = sqrt(length);
    for (int i = 0; i < brake_all; ++i) {
        axis[i] /= length;
        from += axis[i] * desk->known[a][0][i];
    }
    const phi_real sign = desk->values[a][k] < 0 ? -1 : 1, short_one = length / DIP_PLACES;
    for (int i = 0; i <= DIP_PLACES; ++i) {
        phi_real slope[2];
        for (int fewer = 0; fewer < 2; ++fewer) {
            if (touch_curve(count - fewer, near, axis, from + i * short_one, there) < 2) {
                return 0;
            }
            slope[fewer] = sign * (there[which] - before[fewer]) / short_one;
            before[fewer] = there[which];
        }
        if (i > 0 && !(slope[0] - DIP_DOUBT * fabs(slope[0] - slope[1]) > DIP_MARGIN * (one < other ? one : other))) {
            return 0;
        }
    }
    return 1;
}

/* Whether a function may come to zero within the last step but one where its signs, and those of its zeros that are known, do not say so (`met/dips.py`). */
static int dip_may_dip(brake_desk *desk, const int k)
{
    const int last = (int)desk->count - 1, b = last - 1, a = last - 2;
    const phi_real first = dip_divided(desk, k, a), after = dip_divided(desk, k, b), length = desk->at[b] - desk->at[a];
    int is_known = 0;
    for (int i = 0; i < (int)desk->zero_count; ++i) {
        is_known = is_known || (int)desk->zeros[i][0] == k;
    }
    if (!((is_known || desk->watch[k][3] > 0) && first * after > 0)) {
        return 0;
    }
    const phi_real slope = (after - first) / length;
    phi_real bent = 0;
    if (desk->seen > 3) {
        bent = fabs(slope - (first - dip_divided(desk, k, a - 1)) / (desk->at[a] - desk->at[a - 1])) / (desk->at[b] - desk->at[a - 1]);
    }
    const phi_real behind = fabs(slope - (dip_divided(desk, k, last) - after) / (desk->at[last] - desk->at[b])) / (desk->at[last] - desk->at[a]);
    bent = behind > bent ? behind : bent;
    phi_real deep = bent * length * length / 4;
    if (desk->watch[k][3] > 1 && !is_known) {
        const phi_real off = DIP_HUMP * fabs(dip_mean(desk, k) - (first + after) / 2);
        deep = off > deep ? off : deep;
    }
    if (!((fabs(first) < fabs(after) ? fabs(first) : fabs(after)) < DIP_BENT * deep)) {
        return 0;
    }
    return !(dip_is_clear(desk, k, !is_known) || (desk->watch[k][3] > 1 && !is_known && dip_slope_is_clear(desk, k)));
}
