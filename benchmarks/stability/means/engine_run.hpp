/* Two integrators of high order with error control: Gragg's extrapolation and Radau IIA. */
#pragma once

#include "engine_model.hpp"

template <class T> struct Run {
    const Model<T> &model;
    double tol;
    int nx, stages;
    long steps = 0;
    T fastest = T(0), natural; /* the fastest rate so far; sqrt(g / length), below which no rate is resolved */
    std::vector<T> node, weight; /* Radau IIA: c (s), A (s x s) */

    Run(const Model<T> &given, double tolerance) : model(given), tol(tolerance), nx(2 * given.nq()), stages(0)
    {
        T sum = T(0);
        for (const T &length : given.l)
            sum += length;
        natural = sqrt_(given.g / sum);
    }

    /* the largest difference, positions over max(1, |q|), rates over the fastest rate so far or the natural one */
    double distance(const std::vector<T> &a, const std::vector<T> &b) const
    {
        T size[2] = {T(1), std::max(fastest, natural)}, gap[2] = {T(0), T(0)};
        for (int i = 0; i < nx; ++i) {
            const int half = i >= nx / 2;
            size[half] = std::max(size[half], abs_(b[i]));
            gap[half] = std::max(gap[half], abs_(a[i] - b[i]));
        }
        return (double)std::max(gap[0] / size[0], gap[1] / size[1]);
    }

    void note(const std::vector<T> &x)
    {
        for (int i = nx / 2; i < nx; ++i)
            fastest = std::max(fastest, abs_(x[i]));
        ++steps;
    }

    /* one step of Gragg's method with `columns` columns; returns the error estimate */
    double extrapolated(const std::vector<T> &x, T h, int columns, std::vector<T> &out)
    {
        std::vector<std::vector<T>> row;
        std::vector<T> slope(nx), y0(nx), y1(nx), f(nx);
        model.rhs(x.data(), slope.data());
        double error = 0;
        for (int j = 0; j < columns; ++j) {
            const int parts = 2 * (j + 1);
            const T hs = h / T(parts);
            y0 = x;
            for (int i = 0; i < nx; ++i)
                y1[i] = x[i] + hs * slope[i];
            for (int step = 1; step < parts; ++step) {
                model.rhs(y1.data(), f.data());
                for (int i = 0; i < nx; ++i) {
                    const T next = y0[i] + (hs + hs) * f[i];
                    y0[i] = y1[i];
                    y1[i] = next;
                }
            }
            model.rhs(y1.data(), f.data());
            std::vector<T> best(nx);
            for (int i = 0; i < nx; ++i)
                best[i] = (y1[i] + y0[i] + hs * f[i]) / T(2);
            row.push_back(best);
            for (int back = j - 1; back >= 0; --back) {
                const T ratio = T(parts) / T(2 * (back + 1));
                const T scale = T(1) / (ratio * ratio - T(1));
                for (int i = 0; i < nx; ++i)
                    row[back][i] = row[back + 1][i] + (row[back + 1][i] - row[back][i]) * scale;
            }
            if (j == columns - 2)
                out = row[0];
        }
        error = distance(out, row[0]);
        out = row[0];
        return error;
    }

    /* df/dx by differences: a Jacobian of half the digits is enough, Newton iterates to the end */
    std::vector<T> jacobian(const std::vector<T> &x) const
    {
        std::vector<T> J((size_t)nx * nx), f(nx), moved(nx), y = x;
        model.rhs(x.data(), f.data());
        for (int j = 0; j < nx; ++j) {
            const T width = T(sizeof(T) > 8 && tol < 1e-18 ? 1e-15 : 1e-9) * std::max(T(1), abs_(x[j]));
            y[j] = x[j] + width;
            model.rhs(y.data(), moved.data());
            for (int i = 0; i < nx; ++i)
                J[(size_t)i * nx + j] = (moved[i] - f[i]) / width;
            y[j] = x[j];
        }
        return J;
    }

    bool radau(const std::vector<T> &x, T h, const std::vector<T> &J, std::vector<T> &out) const
    {
        const int z = stages * nx;
        std::vector<T> lu((size_t)z * z), Z(z, T(0)), F(z), R(z), y(nx);
        std::vector<int> swap(z);
        for (int a = 0; a < stages; ++a)
            for (int e = 0; e < stages; ++e)
                for (int i = 0; i < nx; ++i)
                    for (int j = 0; j < nx; ++j)
                        lu[(size_t)(a * nx + i) * z + e * nx + j] =
                            T(a == e && i == j ? 1 : 0) - h * weight[a * stages + e] * J[(size_t)i * nx + j];
        for (int p = 0; p < z; ++p) {
            int best = p;
            for (int i = p + 1; i < z; ++i)
                if (abs_(lu[(size_t)i * z + p]) > abs_(lu[(size_t)best * z + p]))
                    best = i;
            swap[p] = best;
            if (best != p)
                std::swap_ranges(&lu[(size_t)p * z], &lu[(size_t)p * z] + z, &lu[(size_t)best * z]);
            for (int i = p + 1; i < z; ++i) {
                T factor = lu[(size_t)i * z + p] / lu[(size_t)p * z + p];
                lu[(size_t)i * z + p] = factor;
                if (factor != T(0))
                    for (int j = p + 1; j < z; ++j)
                        lu[(size_t)i * z + j] -= factor * lu[(size_t)p * z + j];
            }
        }
        double before = INFINITY;
        const double done = sizeof(T) == sizeof(quad) && tol < 1e-18 ? 1e-31 : 3e-19;
        for (int round = 0; round < 60; ++round) {
            for (int a = 0; a < stages; ++a) {
                for (int i = 0; i < nx; ++i)
                    y[i] = x[i] + Z[a * nx + i];
                model.rhs(y.data(), &F[a * nx]);
            }
            for (int a = 0; a < stages; ++a)
                for (int i = 0; i < nx; ++i) {
                    T sum = -Z[a * nx + i];
                    for (int e = 0; e < stages; ++e)
                        sum += h * weight[a * stages + e] * F[e * nx + i];
                    R[a * nx + i] = sum;
                }
            for (int p = 0; p < z; ++p)
                std::swap(R[p], R[swap[p]]);
            for (int p = 0; p < z; ++p)
                for (int j = 0; j < p; ++j)
                    R[p] -= lu[(size_t)p * z + j] * R[j];
            for (int p = z - 1; p >= 0; --p) {
                for (int j = p + 1; j < z; ++j)
                    R[p] -= lu[(size_t)p * z + j] * R[j];
                R[p] /= lu[(size_t)p * z + p];
            }
            T size[2] = {T(1), std::max(fastest, natural)}, gap[2] = {T(0), T(0)};
            for (int p = 0; p < z; ++p) {
                const int half = p % nx >= nx / 2;
                Z[p] += R[p];
                gap[half] = std::max(gap[half], abs_(R[p]));
                size[half] = std::max(size[half], abs_(x[p % nx] + Z[p]));
            }
            const double change = (double)std::max(gap[0] / size[0], gap[1] / size[1]);
            if (!(change == change) || change > 1e3)
                return false;
            if (change <= done || (change >= before && change < 1e4 * done)) {
                for (int i = 0; i < nx; ++i)
                    out[i] = x[i] + Z[(stages - 1) * nx + i];
                return true;
            }
            before = change;
        }
        return false;
    }

    /* two half steps against a whole one; returns the error estimate of the worse */
    double halved(const std::vector<T> &x, T h, std::vector<T> &out)
    {
        std::vector<T> whole(nx), half(nx);
        if (!radau(x, h, jacobian(x), whole) || !radau(x, h / T(2), jacobian(x), half))
            return 1e30 * tol;
        if (!radau(half, h / T(2), jacobian(half), out))
            return 1e30 * tol;
        return distance(whole, out);
    }

    bool advance(std::vector<T> &x, T span, T &h, int columns, long budget)
    {
        const int order = stages ? 2 * stages - 1 : 2 * columns - 2;
        const T sign = span < T(0) ? T(-1) : T(1);
        T left = abs_(span);
        std::vector<T> out(nx);
        while (left > T(0)) {
            if (steps > budget)
                return false;
            const bool last = h >= left;
            const T take = last ? left : h;
            const double error = stages ? halved(x, sign * take, out) : extrapolated(x, sign * take, columns, out);
            double factor = error > 0 ? 0.85 * pow(tol / error, 1.0 / (order + 1)) : 4.0;
            if (!(factor == factor))
                factor = 0.1;
            factor = std::min(4.0, std::max(0.1, factor));
            if (error <= tol) {
                x = out;
                note(x);
                left = last ? T(0) : left - take;
                if (!last || factor < 1)
                    h = take * T(factor);
            } else {
                h = take * T(std::min(factor, 0.9));
            }
        }
        return true;
    }
};
