/* The scalar that an event looks at, at a time h into a lane's step. */
static phi_real stem_scalar(POSITIONS_CONTEXT const int order, const stem_jets *jet, const int lane, const phi_real h, const stem_event *event)
{
#if WITH_SPHERE
    phi_real x[stem_x], place[stem_axes * stem_masses];
    stem_look(order, jet, lane, h, x);
    if (event->scalar != STEM_OF_DEPTH) {
        return x[event->index + (event->scalar == STEM_OF_V ? stem_q : 0)] - event->value;
    }
#else
    phi_real x[stem_q], place[stem_axes * stem_masses];
    if (event->scalar != STEM_OF_DEPTH) {
        return stem_entry(order, jet, lane, h, event->index + (event->scalar == STEM_OF_V ? stem_q : 0)) - event->value;
    }
    for (int i = 0; i < stem_q; ++i) {
        x[i] = stem_entry(order, jet, lane, h, i);
    }
#endif
    phi_positions(POSITIONS_PASS x, place);
    return place[stem_axes * event->index + stem_axes - 1] - event->value;
}

/* The scalar where a run starts: zero within rounding, so that one that stopped there does not stop again. */
static phi_real stem_at_start(POSITIONS_CONTEXT const int order, const stem_jets *jet, const int lane, const stem_event *event, const phi_real scales[PHI_SCALE_COUNT])
{
    stem_lanes norm[2];
    const phi_real scalar = stem_scalar(POSITIONS_PASS order, jet, lane, 0, event);
    stem_norms(scales[1], jet->state, norm);
    const phi_real angle = STEM_OF(norm[0], lane), rate = STEM_OF(norm[1], lane);
    phi_real size = stem_larger(rate / stem_larger(scales[0], rate), angle);
    if (event->scalar == STEM_OF_V) {
        size = stem_larger(rate, scales[0] * angle);
    }
    if (event->scalar == STEM_OF_DEPTH) {
        size = scales[1];
    } else if (event->index < stem_cart) {
        size *= scales[1];
    }
    return phi_abs(scalar) > 8 * PHI_EPSILON * (phi_abs(event->value) + size) ? scalar : 0;
}

/* The scalar, or by how much it grows over twice a short time around h. */
static phi_real stem_signal(POSITIONS_CONTEXT const int order, const stem_jets *jet, const int lane, const phi_real h, const stem_event *event, const phi_real around)
{
    if (!(around > 0 || around < 0)) {
        return stem_scalar(POSITIONS_PASS order, jet, lane, h, event);
    }
    return stem_scalar(POSITIONS_PASS order, jet, lane, h + around, event) - stem_scalar(POSITIONS_PASS order, jet, lane, h - around, event);
}

/* Whether a time lies between two others. */
static int stem_between(const phi_real low, const phi_real middle, const phi_real high)
{
    return (low < middle && middle < high) || (high < middle && middle < low);
}

/* Where the signal changes sign between two times, at the first of which it is `at_low`, at the other `at_high`: the
 * Illinois form of regula falsi, which halves the value of an end that stays twice. What rounding hides is looked for next to the
 * better end, then in the middle. */
static phi_real stem_zero(POSITIONS_CONTEXT const int order, const stem_jets *jet, const int lane, const stem_event *event, const phi_real around, phi_real low, phi_real at_low, phi_real high, phi_real at_high)
{
    const int rises = at_low < 0;
    int moved = 0; /* the end that moved last: -1 low, 1 high */
    for (int turn = 0; turn < 100 && (at_high > 0 || at_high < 0); ++turn) {
        phi_real middle = high - at_high * ((high - low) / (at_high - at_low));
        if (!stem_between(low, middle, high)) {
            const phi_real near = 4 * PHI_EPSILON * high;
            middle = moved < 0 ? low + (high > low ? phi_abs(near) : -phi_abs(near)) : high - (high > low ? phi_abs(near) : -phi_abs(near));
        }
        if (turn > 40 || !stem_between(low, middle, high)) {
            middle = low + (high - low) / 2;
            if (!stem_between(low, middle, high)) {
                break;
            }
        }
        const phi_real at_middle = stem_signal(POSITIONS_PASS order, jet, lane, middle, event, around);
        if (rises ? at_middle < 0 : at_middle > 0) {
            at_high = moved < 0 ? at_high / 2 : at_high;
            low = middle;
            at_low = at_middle;
            moved = -1;
        } else {
            at_low = moved > 0 ? at_low / 2 : at_low;
            high = middle;
            at_high = at_middle;
            moved = 1;
        }
    }
    return high;
}
#if !WITH_SPHERE

/* Whether an entry of a lane's state stays on its side of zero over a step, where it starts so far from it: all its coefficients
 * together do not lead there. */
static int stem_keeps_off(const int order, const stem_jets *jet, const int lane, const phi_real h, const int i, const phi_real from)
{
    const phi_real unit = STEM_OF(jet->start->unit[0], lane), t = phi_abs(h) / unit, square = t * t;
    phi_real even = 0, odd = 0;
    int n = order;
    if (n % 2 == 0) {
        even = phi_abs(STEM_OF(jet->x[n][i], lane));
        --n;
    }
    for (; n > 0; n -= 2) {
        odd = odd * square + phi_abs(STEM_OF(jet->x[n][i], lane));
        even = n > 1 ? even * square + phi_abs(STEM_OF(jet->x[n - 1][i], lane)) : even;
    }
    return 2 * ((odd + even * t) * t) < phi_abs(from) * (i < stem_q ? 1 : unit);
}
#endif

/* Time into a lane's step at which its scalar changes sign, or 2 h when it does not. `before` is what it was at the end
 * of the last step, and becomes what it is at the end of this one. */
static phi_real stem_crossing(POSITIONS_CONTEXT const int order, const stem_jets *jet, const int lane, const phi_real h, const stem_event *event, phi_real *before)
{
#if !WITH_SPHERE
    if (event->scalar != STEM_OF_DEPTH && stem_keeps_off(order, jet, lane, h, event->index + (event->scalar == STEM_OF_V ? stem_q : 0), *before)) {
        const phi_real end = stem_scalar(POSITIONS_PASS order, jet, lane, h, event);
        if ((*before < 0 && end < 0) || (*before > 0 && end > 0)) {
            *before = end;
            return 2 * h;
        }
    }
#endif
    const phi_real around = h / 1024;
    phi_real low = 0, at_low = *before, growth = 0;
    int is_known = 0; /* by how much the scalar grows around low */
    for (int look = 1; look <= stem_looks; ++look) {
        const phi_real end = look == stem_looks ? h : h * (phi_real)look / (phi_real)stem_looks;
        const phi_real at_end = stem_scalar(POSITIONS_PASS order, jet, lane, end, event);
        phi_real high = end, at_high = at_end;
        if (!((at_low < 0 && at_end >= 0) || (at_low > 0 && at_end <= 0))) {
            /* Twice across zero and back, perhaps; or, where it starts at zero, once: where it turns in between, lowest where it
             * lies above zero at the end and highest where it lies below. */
            const phi_real from = is_known ? growth : stem_signal(POSITIONS_PASS order, jet, lane, low, event, around);
            growth = stem_signal(POSITIONS_PASS order, jet, lane, end, event, around);
            is_known = 1;
            if (at_end > 0 ? from < 0 && growth > 0 : from > 0 && growth < 0) {
                high = stem_zero(POSITIONS_PASS order, jet, lane, event, around, low, from, end, growth);
                at_high = stem_scalar(POSITIONS_PASS order, jet, lane, high, event);
            }
        } else {
            is_known = 0;
        }
        for (;;) {
            const int rises = at_low < 0 && at_high >= 0, falls = at_low > 0 && at_high <= 0;
            if ((rises && event->direction >= 0) || (falls && event->direction <= 0)) {
                return stem_zero(POSITIONS_PASS order, jet, lane, event, 0, low, at_low, high, at_high);
            }
            low = high;
            at_low = at_high;
            if (!stem_between(low, end, 2 * end)) {
                break;
            }
            high = end;
            at_high = at_end;
        }
    }
    *before = at_low;
    return 2 * h;
}
