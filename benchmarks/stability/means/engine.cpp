/* Reference motions of pendulum chains in quadruple (or 80-bit) precision, by means that share nothing with phichain:
 * the dense Lagrangian of the design, formed and factorised whole, in absolute angles or on unit vectors, integrated by
 * Gragg's extrapolation (Bulirsch and Stoer; Hairer, Norsett and Wanner, II.9) or, where stiff, by the Radau IIA method
 * of s stages and order 2 s - 1 (Hairer and Wanner, IV.5) with steps controlled by halving them.
 */
#include "engine_run.hpp"

#include <cstdio>

static int text(char *out, size_t size, quad a) { return quadmath_snprintf(out, size, "%.33Qe", a); }
static int text(char *out, size_t size, long double a) { return snprintf(out, size, "%.21Le", a); }

template <class T>
static int integrate_as(const chain &p, const double *x0, int count, const double *times, double tol, int order,
                        const double *tableau, long budget, char *out, size_t size, double *info)
{
    Model<T> model(p);
    Run<T> run(model, tol);
    const int nx = run.nx;
    std::vector<T> x(nx);
    const double *turn = p.direction ? p.direction + 5 * p.links + 2 : nullptr;
    for (int i = 0; i < nx; ++i)
        x[i] = T(x0[i]) * (T(1) + (turn ? T(p.amount) * T(turn[i]) : T(0)));
    model.enter(x);
    run.note(x);
    run.steps = 0;
    if (tableau) { /* c and A in three doubles each */
        run.stages = order;
        auto sum = [&](int i) { return T(tableau[3 * i]) + T(tableau[3 * i + 1]) + T(tableau[3 * i + 2]); };
        for (int i = 0; i < order; ++i)
            run.node.push_back(sum(i));
        for (int i = 0; i < order * order; ++i)
            run.weight.push_back(sum(order + i));
    }
    T now = T(0), h = abs_(T(times[0])) / T(1000);
    if (info[0] > 0)
        h = T(info[0]);
    size_t used = 0;
    int kick = 0;
    for (int k = 0; k < count; ++k) {
        for (; kick < p.kicks && p.kick_time[kick] < times[k]; ++kick) {
            if (!run.advance(x, T(p.kick_time[kick]) - now, h, order, budget))
                return 1;
            now = T(p.kick_time[kick]);
            for (int i = 0; i < nx; ++i)
                x[i] *= T(1) + T(p.amount) * T(p.kick_direction[(size_t)kick * nx + i]);
            if (model.spatial)
                model.settle(x);
        }
        if (!run.advance(x, T(times[k]) - now, h, order, budget))
            return 1;
        now = T(times[k]);
        for (const T &entry : model.leave(x)) {
            if (used + 60 > size)
                return 2;
            used += (size_t)text(out + used, size - used, entry);
            out[used++] = ' ';
        }
        out[used - 1] = '\n';
    }
    out[used] = 0;
    info[0] = (double)run.steps;
    info[1] = (double)run.fastest;
    return 0;
}

/* States at `times` (rising or falling from 0), one line each, in the scene's coordinates. tableau: null for Gragg's
 * extrapolation with `order` columns, else c and A of Radau IIA with `order` stages. info: in the first step (0: any),
 * out the number of steps and the fastest rate. */
extern "C" int integrate(int wide, const chain *p, const double *x0, int count, const double *times, double tol, int order,
                         const double *tableau, long budget, char *out, size_t size, double *info)
{
    return wide ? integrate_as<quad>(*p, x0, count, times, tol, order, tableau, budget, out, size, info)
                : integrate_as<long double>(*p, x0, count, times, tol, order, tableau, budget, out, size, info);
}

template <class T> static int accelerate(const chain &p, const double *x0, char *out, size_t size)
{
    Model<T> model(p);
    const int nx = 2 * model.nq();
    const double *turn = p.direction ? p.direction + 5 * p.links + 2 : nullptr;
    std::vector<T> x(nx), dx(nx);
    for (int i = 0; i < nx; ++i)
        x[i] = T(x0[i]) * (T(1) + (turn ? T(p.amount) * T(turn[i]) : T(0)));
    model.enter(x);
    model.rhs(x.data(), dx.data());
    dx = model.leave(dx);
    size_t used = 0;
    for (int i = nx / 2; i < nx; ++i) {
        if (used + 60 > size)
            return 2;
        used += (size_t)text(out + used, size - used, dx[i]);
        out[used++] = ' ';
    }
    out[used - 1] = 0;
    return 0;
}

extern "C" int accelerations(int wide, const chain *p, const double *x0, char *out, size_t size)
{
    return wide ? accelerate<quad>(*p, x0, out, size) : accelerate<long double>(*p, x0, out, size);
}
