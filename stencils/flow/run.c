/* The whole way, in a workspace. */
static STEM_APART int stem_run(ARGUMENTS, stem_jets *jet)
{
    const phi_real at_least = stem_larger(flow->tolerance, PHI_EPSILON);
    const phi_real tolerance = at_least < 1 ? at_least : 1;
    /* Errors add up over the steps: each aims below the tolerance. */
    const phi_real goal = tolerance * PHI_MARGIN;
    const int order = stem_order_for(goal);
    const phi_real way = t_end < flow->t ? -1 : 1;
    int result = PHI_STEP_BUDGET, is_new = 1;
#if WITH_SCALES
    const phi_real scales[PHI_SCALE_COUNT] = {PHI_SCALES}; /* PHI_SCALE_WORDS */
#else
    phi_real scales[PHI_SCALE_COUNT]; /* PHI_SCALE_WORDS */
    stem_scales(p, scales);
#endif
    phi_real at_event = 0, speed[2], unit, span;

    memcpy(jet->state, q, stem_q * sizeof *q);
    memcpy(jet->state + stem_q, v, stem_q * sizeof *v);
    memcpy(jet->lost, flow->lost, sizeof jet->lost);
#if WITH_INPUTS
    memcpy(jet->u, u, sizeof jet->u);
#endif
#if WITH_FORCING
    const phi_real no_time = 0;
    jet->amplitude = amplitude;
    jet->omega = omega;
#endif
#if WITH_SPHERE
    stem_enter(q, v, jet->state + stem_q);
#if WITH_COLUMNS
    stem_enter_columns(q, v, flow->columns, flow->transition);
#endif
#endif
#if WITH_TURNS
    memset(jet->turns, 0, sizeof jet->turns);
    (void)stem_wind(0, jet);
#endif
    stem_norms(scales[1], jet->state, speed);
    span = 1 / stem_larger(scales[0], speed[1]);
    stem_unit(&span, &unit);
    if (event != NULL) {
        memset(jet->x, 0, sizeof jet->x);
        jet->start->unit[0] = unit;
        at_event = stem_at_start(POSITIONS_PASS order, jet, 0, event, scales);
    }
    flow->tolerance = tolerance;
    flow->order = order;
    flow->steps = 0;
    flow->written = 0;
#if WITH_BESIDE
    int low = stem_low_for(goal, order, t_end - flow->t, scales[0]);
    if (goes_on) {
        stem_go_on(stop, jet, &unit, &is_new, &low);
    }
#endif
    while (result == PHI_STEP_BUDGET) {
        const phi_real left = (t_end - flow->t) - flow->t_lost;
        phi_real length;
        if (!(left * way > 0)) {
            result = left * way <= 0 ? PHI_DONE : PHI_NOT_FINITE; /* no way leads to a time that is no number */
            break;
        }
        if (flow->steps == max_steps) {
            break;
        }
#if WITH_FORCING
        jet->t = flow->t;
        jet->t_lost = flow->t_lost;
#endif
        if (is_new) {
            stem_begin(PASS jet, jet->state, jet->lost, &unit, AFTER(&no_time) jet->start);
        } else {
            memcpy(jet->start, jet->end, sizeof jet->start);
        }
        stem_expand(PASS order, jet);
        stem_norms(scales[1], jet->state, speed);
        stem_lengths(order, jet, goal, scales, speed, &length);
        if (!((flow->t + 1024 * (way * length)) * way > flow->t * way)) {
            result = PHI_NOT_FINITE;
            break;
        }
        phi_real h = length < left * way ? way * length : left;
        stem_check(PASS order, jet, goal, scales, speed, &h);
        is_new = 0;
        if (!(h * way < left * way)) {
            result = PHI_DONE;
        }
        if (event != NULL) {
            const phi_real crossing = stem_crossing(POSITIONS_PASS order, jet, 0, h, event, &at_event);
            if (crossing * way <= h * way) {
                h = crossing;
                result = PHI_EVENT;
                is_new = 1;
            }
        }
#if WITH_COLUMNS
        if (flow->columns > 0) {
            const phi_real kept = stem_carry(PASS order, jet, goal, scales, h, VARIES(flow, count, times) flow->columns, flow->transition);
            if (kept * way < h * way) {
                if (!(kept * way > 0)) {
                    result = PHI_NOT_FINITE;
                    break;
                }
                h = kept;
                result = PHI_STEP_BUDGET;
                is_new = 1;
                if (event != NULL) {
                    at_event = stem_scalar(POSITIONS_PASS order, jet, 0, h, event);
                }
            }
        }
#endif
        if (is_new) {
            phi_real increment[stem_x], along[stem_q];
            span = phi_abs(h);
            stem_unit(&span, &unit);
            stem_advance(order, jet, &h, increment, along);
            stem_move(increment, jet);
#if WITH_BESIDE
            /* The error of a step that was cut is measured where it ends now. */
            stem_begin(PASS jet, jet->moved, jet->moved_lost, &unit, AFTER(&h) jet->end);
#endif
        }
        while (times != NULL && flow->written < count) {
            const phi_real inside = (times[flow->written] - flow->t) - flow->t_lost;
            phi_real x[stem_x];
            if (!(inside * way <= h * way)) {
                break;
            }
            stem_look(order, jet, 0, inside, x);
            memcpy(q_out + flow->written * stem_q, x, stem_q * sizeof *x);
            memcpy(v_out + flow->written * stem_q, x + stem_q, stem_q * sizeof *x);
#if WITH_PARAMETERS
#if WITH_SPHERE
            if (flow->passed != NULL && flow->columns > 0) {
                phi_real within[stem_x];
                for (int i = 0; i < stem_x; ++i) {
                    within[i] = stem_entry(order, jet, 0, inside, i);
                }
                stem_leave_columns(within, within + stem_q, flow->columns, flow->passed + flow->written * stem_x * (size_t)flow->columns);
            }
#endif
#endif
            ++flow->written;
        }
#if WITH_BESIDE
        stem_step *noted = (stem_step *)(void *)(steps + stem_place(low, flow->steps));
        stem_note(goal, order, low, jet, h, noted);
#endif
        memcpy(jet->state, jet->moved, sizeof jet->state);
        memcpy(jet->lost, jet->moved_lost, sizeof jet->lost);
#if WITH_TURNS
        /* The next step starts from what a run that began here would see. */
        if (stem_wind(0, jet) && !is_new) {
            unit = jet->end->unit[0];
            is_new = 1;
        }
#endif
        const phi_real whole = h + flow->t_lost, after = flow->t + whole;
        flow->t_lost = whole - (after - flow->t);
        flow->t = after;
        if (result == PHI_DONE) {
            flow->t = t_end;
            flow->t_lost = 0;
        }
        if (times == NULL && flow->own != NULL && flow->written < count) {
            phi_real *q_end = q_out + flow->written * stem_q, *v_end = v_out + flow->written * stem_q;
#if WITH_SPHERE
            stem_leave(jet->state, jet->state + stem_q, q_end, v_end);
#else
            memcpy(q_end, jet->state, stem_q * sizeof *q_end);
            memcpy(v_end, jet->state + stem_q, stem_q * sizeof *v_end);
#endif
#if WITH_TURNS
            for (int i = stem_cart; i < stem_q; ++i) {
                q_end[i] = stem_turned(q_end[i], jet->turns[i]);
            }
#endif
            flow->own[flow->written++] = flow->t;
        }
#if WITH_BESIDE
        noted->written = (phi_real)flow->written;
#endif
        ++flow->steps;
    }
#if WITH_BESIDE
    stem_keep(jet, unit, is_new, low, stop);
#endif
#if WITH_TURNS
    stem_unwind(0, jet);
#endif
#if WITH_SPHERE
#if WITH_COLUMNS
    stem_leave_columns(jet->state, jet->state + stem_q, flow->columns, flow->transition);
#endif
    stem_leave(jet->state, jet->state + stem_q, q, v);
#if WITH_SPRINGS
    /* Unit vectors are rounded anew: what that takes goes with them, for a call that goes on. */
    for (int i = stem_cart; i < stem_q; ++i) {
        jet->lost[i] += jet->state[i] - q[i];
    }
#endif
#else
    memcpy(q, jet->state, stem_q * sizeof *q);
    memcpy(v, jet->state + stem_q, stem_q * sizeof *v);
#endif
    memcpy(flow->lost, jet->lost, sizeof flow->lost);
    return result;
}
#ifdef PHI_WORK_ON_STACK

/* The same in a workspace of its own. */
static STEM_APART int stem_run_on_stack(ARGUMENTS)
{
    phi_workspace work PHI_ALIGNED;
    return stem_run(PASS_ALL, &work);
}
#endif

/* PROPAGATE_DOC */
int phi_propagate(ARGUMENTS)
{
    if (flow->work != NULL) {
        return stem_run(PASS_ALL, flow->work);
    }
#ifdef PHI_WORK_ON_STACK
    return stem_run_on_stack(PASS_ALL);
#else
    flow->steps = sizeof(phi_workspace);
    return PHI_NO_WORKSPACE;
#endif
}
