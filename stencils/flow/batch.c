/* A lane takes up a trajectory. */
static void stem_take(const size_t n, const size_t k, const int lane, const phi_flow_batch *flow, const phi_real t_end[], INPUTS_OF_ALL FORCING_OF_ALL const phi_real q[], const phi_real v[], stem_state *lanes, stem_jets *jet)
{
    phi_real x[stem_x];
    for (size_t i = 0; i < stem_q; ++i) {
        x[i] = q[i * n + k];
        x[stem_q + i] = v[i * n + k];
    }
#if WITH_SPHERE
    phi_real rate[stem_q];
    stem_enter(x, x + stem_q, rate);
    memcpy(x + stem_q, rate, sizeof rate);
#endif
    for (size_t i = 0; i < stem_x; ++i) {
        STEM_AT(jet->state[i], lane) = x[i];
        STEM_AT(jet->lost[i], lane) = flow->lost[(i + 1) * n + k];
    }
#if WITH_INPUTS
    for (size_t i = 0; i < stem_inputs; ++i) {
        STEM_AT(jet->u[i], lane) = u[i * n + k];
    }
#endif
#if WITH_FORCING
    STEM_AT(jet->amplitude, lane) = amplitude[k];
    STEM_AT(jet->omega, lane) = omega[k];
#endif
#if WITH_TURNS
    for (int i = 0; i < stem_q; ++i) {
        STEM_AT(jet->turns[i], lane) = 0;
    }
    (void)stem_wind(lane, jet);
#endif
    lanes->trajectory[lane] = k;
    lanes->busy[lane] = lanes->is_new[lane] = 1;
    lanes->t[lane] = flow->t[k];
    lanes->t_lost[lane] = flow->lost[k];
    lanes->t_end[lane] = t_end[k];
    lanes->steps[lane] = lanes->written[lane] = 0;
}

/* A lane hands back its trajectory. */
static void stem_give(const size_t n, const int lane, const stem_state *lanes, stem_jets *jet, phi_flow_batch *flow, phi_real q[], phi_real v[])
{
    const size_t k = lanes->trajectory[lane];
    phi_real x[stem_x];
#if WITH_TURNS
    stem_unwind(lane, jet);
#endif
    for (size_t i = 0; i < stem_x; ++i) {
        x[i] = STEM_OF(jet->state[i], lane);
        flow->lost[(i + 1) * n + k] = STEM_OF(jet->lost[i], lane);
    }
#if WITH_SPHERE
    phi_real seen[stem_x];
    stem_leave(x, x + stem_q, seen, seen + stem_q);
#if WITH_SPRINGS
    for (size_t i = stem_cart; i < stem_q; ++i) {
        flow->lost[(i + 1) * n + k] += x[i] - seen[i]; /* unit vectors are rounded anew */
    }
#endif
    memcpy(x, seen, sizeof x);
#endif
    for (size_t i = 0; i < stem_q; ++i) {
        q[i * n + k] = x[i];
        v[i * n + k] = x[stem_q + i];
    }
    flow->t[k] = lanes->t[lane];
    flow->lost[k] = lanes->t_lost[lane];
    flow->steps[k] = lanes->steps[lane];
    flow->written[k] = lanes->written[lane];
    flow->result[k] = lanes->result[lane];
}

/* A lane without a trajectory rests where another one is: finite numbers, which nobody reads. */
static void stem_rest_lane(const int lane, const int other, stem_jets *jet)
{
    for (size_t i = 0; i < stem_x; ++i) {
        STEM_AT(jet->state[i], lane) = STEM_OF(jet->state[i], other);
        STEM_AT(jet->lost[i], lane) = 0;
    }
#if WITH_TURNS
    for (size_t i = 0; i < stem_q; ++i) {
        STEM_AT(jet->turns[i], lane) = 0;
    }
#endif
#if WITH_INPUTS
    for (size_t i = 0; i < stem_inputs; ++i) {
        STEM_AT(jet->u[i], lane) = STEM_OF(jet->u[i], other);
    }
#endif
#if WITH_FORCING
    STEM_AT(jet->amplitude, lane) = STEM_OF(jet->amplitude, other);
    STEM_AT(jet->omega, lane) = STEM_OF(jet->omega, other);
#endif
}

/* Units of time and first coefficients where lanes have taken up trajectories; the others have theirs already. */
static void stem_begin_new(CONTEXT const phi_real scales[PHI_SCALE_COUNT], stem_state *lanes, stem_jets *jet)
{
    const stem_lanes linear = STEM_ZERO + scales[0];
    stem_lanes speed[2], fresh, length, unit = jet->start->unit[0];
    stem_norms(scales[1], jet->state, speed);
    length = 1 / STEM_LARGER(linear, speed[1]);
    stem_unit(&length, &fresh);
    for (int lane = 0; lane < stem_lane_count; ++lane) {
        if (lanes->is_new[lane] || !lanes->busy[lane]) {
            STEM_AT(unit, lane) = STEM_OF(fresh, lane);
        }
    }
#if WITH_FORCING
    const stem_lanes no_time = STEM_ZERO;
#endif
    stem_begin(PASS jet, jet->state, jet->lost, &unit, AFTER(&no_time) jet->start);
}

/* Where a lane stands before its step: the time left and how far it may go, or how it ended. */
static void stem_propose(const int lane, const unsigned long max_steps, const phi_real length, stem_state *lanes)
{
    const phi_real t = lanes->t[lane], left = (lanes->t_end[lane] - t) - lanes->t_lost[lane];
    const phi_real way = lanes->t_end[lane] < t ? -1 : 1, h = way * length;
    lanes->h[lane] = 0;
    lanes->left[lane] = left;
    if (!lanes->busy[lane]) {
        return;
    }
    if (!(left * way > 0)) {
        lanes->result[lane] = left * way <= 0 ? PHI_BATCH_DONE : PHI_BATCH_NOT_FINITE; /* no way leads to a time that is no number */
    } else if (lanes->steps[lane] == max_steps) {
        lanes->result[lane] = PHI_BATCH_STEP_BUDGET;
    } else if (!((t + 1024 * h) * way > t * way)) {
        lanes->result[lane] = PHI_BATCH_NOT_FINITE;
    } else {
        lanes->result[lane] = stem_goes_on;
        lanes->h[lane] = h * way < left * way ? h : left;
    }
}

/* PROPAGATE_DOC */
size_t phi_propagate_batch(ARGUMENTS)
{
    if (work == NULL) {
        return PHI_BATCH_WORK;
    }
    const uintptr_t misplaced = (uintptr_t)work % sizeof(stem_lanes);
    stem_jets *jet = (stem_jets *)(void *)((char *)work + (misplaced ? sizeof(stem_lanes) - misplaced : 0));
    stem_state lanes;
    stem_lanes step;
    const phi_real at_least = stem_larger(flow->tolerance, PHI_EPSILON);
    const phi_real tolerance = at_least < 1 ? at_least : 1;
    /* Errors add up over the steps: each aims below the tolerance. */
    const phi_real goal = tolerance * PHI_MARGIN;
    const int order = stem_order_for(goal);
#if WITH_SCALES
    const phi_real scales[PHI_SCALE_COUNT] = {PHI_SCALES}; /* PHI_SCALE_WORDS */
#else
    phi_real scales[PHI_SCALE_COUNT]; /* PHI_SCALE_WORDS */
    stem_scales(p, scales);
#endif
    size_t waiting = 0, running = 0, done = 0;
    int changed = 1;

    flow->tolerance = tolerance;
    flow->order = order;
    memset(&lanes, 0, sizeof lanes);
    jet->start = jet->starts;
    jet->end = jet->starts + 1;
    memset(jet->start->unit, 0, sizeof jet->start->unit);
    for (int lane = 0; lane < stem_lane_count; ++lane) {
        if (waiting < n) {
            stem_take(n, waiting++, lane, flow, t_end, PASS_INPUTS PASS_FORCING q, v, &lanes, jet);
            ++running;
        } else if (lane > 0) {
            stem_rest_lane(lane, 0, jet);
        }
    }
    while (running > 0) {
        stem_lanes length, speed[2];
#if WITH_FORCING
        memcpy(&jet->t, lanes.t, sizeof jet->t);
        memcpy(&jet->t_lost, lanes.t_lost, sizeof jet->t_lost);
#endif
        if (changed) {
            stem_begin_new(PASS scales, &lanes, jet);
        }
        if (event != NULL && changed) {
            memset(jet->x, 0, sizeof jet->x);
            for (int lane = 0; lane < stem_lane_count; ++lane) {
                if (lanes.busy[lane] && lanes.is_new[lane]) {
                    lanes.at_event[lane] = stem_at_start(POSITIONS_PASS order, jet, lane, event, scales);
                }
            }
        }
        memset(lanes.is_new, 0, sizeof lanes.is_new);
        changed = 0;
        stem_expand(PASS order, jet);
        stem_norms(scales[1], jet->state, speed);
        stem_lengths(order, jet, goal, scales, speed, &length);
        for (int lane = 0; lane < stem_lane_count; ++lane) {
            stem_propose(lane, max_steps, STEM_OF(length, lane), &lanes);
        }
        memcpy(&step, lanes.h, sizeof step);
        stem_check(PASS order, jet, goal, scales, speed, &step);
        memcpy(lanes.h, &step, sizeof step);
        for (int lane = 0; lane < stem_lane_count; ++lane) {
            if (!lanes.busy[lane]) {
                continue;
            }
            if (lanes.result[lane] != stem_goes_on) {
                /* It stays where it is: nothing of a series that is not finite reaches its state. */
                stem_give(n, lane, &lanes, jet, flow, q, v);
                continue;
            }
            const phi_real t = lanes.t[lane], way = lanes.t_end[lane] < t ? -1 : 1;
            phi_real h = lanes.h[lane];
            if (!(h * way < lanes.left[lane] * way)) {
                lanes.result[lane] = PHI_BATCH_DONE;
            }
            if (event != NULL) {
                const phi_real crossing = stem_crossing(POSITIONS_PASS order, jet, lane, h, event, &lanes.at_event[lane]);
                if (crossing * way <= h * way) {
                    h = crossing;
                    lanes.result[lane] = PHI_BATCH_EVENT;
                }
            }
            while (lanes.written[lane] < count) {
                const size_t at = lanes.written[lane], k = lanes.trajectory[lane];
                const phi_real inside = (times[at] - t) - lanes.t_lost[lane];
                phi_real x[stem_x];
                if (!(inside * way <= h * way)) {
                    break;
                }
                stem_look(order, jet, lane, inside, x);
                for (size_t i = 0; i < stem_q; ++i) {
                    q_out[(at * stem_q + i) * n + k] = x[i];
                    v_out[(at * stem_q + i) * n + k] = x[stem_q + i];
                }
                ++lanes.written[lane];
            }
            const phi_real whole = h + lanes.t_lost[lane], after = t + whole;
            lanes.t_lost[lane] = whole - (after - t);
            lanes.t[lane] = after;
            if (lanes.result[lane] == PHI_BATCH_DONE) {
                lanes.t[lane] = lanes.t_end[lane];
                lanes.t_lost[lane] = 0;
            }
            if (h < lanes.h[lane] || h > lanes.h[lane]) {
                lanes.h[lane] = h;
                changed = 1;
            }
            ++lanes.steps[lane];
        }
        if (changed) {
            stem_lanes increment[stem_x], along[stem_q];
            memcpy(&step, lanes.h, sizeof step);
            stem_advance(order, jet, &step, increment, along);
            stem_move(increment, jet);
        }
        memcpy(jet->state, jet->moved, sizeof jet->state);
        memcpy(jet->lost, jet->moved_lost, sizeof jet->lost);
        for (int lane = 0; lane < stem_lane_count; ++lane) {
            if (!lanes.busy[lane]) {
                continue;
            }
#if WITH_TURNS
            /* The next step starts from what a trajectory that began here would see. */
            if (stem_wind(lane, jet)) {
                changed = 1;
            }
#endif
            if (lanes.result[lane] == stem_goes_on) {
                continue;
            }
            if (lanes.h[lane] > 0 || lanes.h[lane] < 0) {
                stem_give(n, lane, &lanes, jet, flow, q, v);
            }
            done += lanes.result[lane] == PHI_BATCH_DONE ? 1u : 0u;
            lanes.busy[lane] = 0;
            changed = 1;
            --running;
            if (waiting < n) {
                stem_take(n, waiting++, lane, flow, t_end, PASS_INPUTS PASS_FORCING q, v, &lanes, jet);
                ++running;
            }
        }
        for (int lane = 0, other = 0; running > 0 && lane < stem_lane_count; ++lane) {
            if (lanes.busy[lane]) {
                continue;
            }
            while (!lanes.busy[other]) {
                ++other;
            }
            stem_rest_lane(lane, other, jet);
        }
        stem_start *before = jet->start;
        jet->start = jet->end;
        jet->end = before;
    }
    return done;
}
