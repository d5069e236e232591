/* A chain's equations of motion from the dense Lagrangian of the design, in any type of number. */
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <quadmath.h>
#include <vector>

typedef __float128 quad;

static inline quad abs_(quad a) { return fabsq(a); }
static inline long double abs_(long double a) { return fabsl(a); }
static inline quad sqrt_(quad a) { return sqrtq(a); }
static inline long double sqrt_(long double a) { return sqrtl(a); }
static inline void sincos_(quad a, quad *s, quad *c) { sincosq(a, s, c); }
static inline void sincos_(long double a, long double *s, long double *c) { *s = sinl(a); *c = cosl(a); }
/* Every number is base * (1 + amount * direction): the directions serve condition numbers. */
extern "C" struct chain {
    int links, spatial, cart;
    const double *mass, *length, *com, *stiffness, *damping, *force;
    double cart_mass, gravity, amount;
    const double *direction; /* mass, length, com, stiffness, damping (n each), cart mass, gravity, state; null without */
    int kicks;               /* the state is changed again at these times, each with signs of its own */
    const double *kick_time, *kick_direction;
};

template <class T> struct Model {
    int n, c; /* links; cart coordinates */
    bool spatial;
    std::vector<T> m, l, r, k, d, f, mu, cc;
    T m0, g, total;
    mutable std::vector<T> M, b, s, co, tau;

    int nq() const { return c + (spatial ? 3 : 1) * n; }

    explicit Model(const chain &p) : n(p.links), c(p.cart ? (p.spatial ? 2 : 1) : 0), spatial(p.spatial)
    {
        auto moved = [&](double value, int at) {
            return T(value) * (T(1) + (p.direction ? T(p.amount) * T(p.direction[at]) : T(0)));
        };
        for (int i = 0; i < n; ++i) {
            m.push_back(moved(p.mass[i], i));
            l.push_back(moved(p.length[i], n + i));
            r.push_back(moved(p.com[i], 2 * n + i));
            k.push_back(moved(p.stiffness[i], 3 * n + i));
            d.push_back(moved(p.damping[i], 4 * n + i));
        }
        for (int i = 0; i < c; ++i)
            f.push_back(T(p.force[i]));
        m0 = moved(p.cart_mass, 5 * n);
        g = moved(p.gravity, 5 * n + 1);
        std::vector<T> beyond(n, T(0));
        total = m0 + m[n - 1];
        for (int i = n - 2; i >= 0; --i) {
            beyond[i] = beyond[i + 1] + m[i + 1];
            total += m[i];
        }
        for (int i = 0; i < n; ++i)
            mu.push_back(m[i] * r[i] + l[i] * beyond[i]);
        cc.resize((size_t)n * n);
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j)
                cc[(size_t)i * n + j] = i == j ? m[i] * r[i] * r[i] + l[i] * l[i] * beyond[i] : l[std::min(i, j)] * mu[std::max(i, j)];
        M.resize((size_t)nq() * nq());
        b.resize(nq());
        s.resize(n);
        co.resize(n);
        tau.resize(n + 1);
    }

    /* L D L^T without pivoting; the solution replaces b. */
    void solve() const
    {
        const int z = nq();
        for (int j = 0; j < z; ++j) {
            T *row = &M[(size_t)j * z];
            for (int i = 0; i < j; ++i) {
                T *other = &M[(size_t)i * z];
                T sum = row[i];
                for (int q = 0; q < i; ++q)
                    sum -= row[q] * other[q];
                row[i] = sum; /* l_ji d_i */
            }
            T pivot = row[j];
            for (int i = 0; i < j; ++i) {
                T scaled = row[i] / M[(size_t)i * z + i];
                pivot -= scaled * row[i];
                row[i] = scaled;
            }
            row[j] = pivot;
            for (int i = 0; i < j; ++i)
                b[j] -= row[i] * b[i];
        }
        for (int j = z - 1; j >= 0; --j) {
            T sum = b[j] / M[(size_t)j * z + j];
            for (int i = j + 1; i < z; ++i)
                sum -= M[(size_t)i * z + j] * b[i];
            b[j] = sum;
        }
    }

    void rhs(const T *x, T *dx) const { spatial ? rhs_spatial(x, dx) : rhs_planar(x, dx); }

    /* absolute angles: x = [X, phi, X', w] */
    void rhs_planar(const T *x, T *dx) const
    {
        const int z = nq();
        const T *phi = x + c, *w = x + z + c;
        for (int i = 0; i < n; ++i)
            sincos_(phi[i], &s[i], &co[i]);
        for (int i = 0; i < n; ++i) {
            const T bend = i ? phi[i] - phi[i - 1] : phi[0], rate = i ? w[i] - w[i - 1] : w[0];
            tau[i] = -k[i] * bend - d[i] * rate;
        }
        tau[n] = T(0);
        for (int i = 0; i < n; ++i) {
            T right = tau[i] - tau[i + 1] - g * mu[i] * s[i];
            for (int j = 0; j < n; ++j) {
                const T cij = cc[(size_t)i * n + j];
                M[(size_t)(i + c) * z + j + c] = cij * (co[i] * co[j] + s[i] * s[j]);
                right -= cij * (s[i] * co[j] - co[i] * s[j]) * w[j] * w[j];
            }
            b[i + c] = right;
        }
        if (c) {
            M[0] = total;
            b[0] = f[0];
            for (int i = 0; i < n; ++i) {
                M[(size_t)(i + 1) * z] = M[i + 1] = mu[i] * co[i];
                b[0] += mu[i] * s[i] * w[i] * w[i];
            }
        }
        solve();
        for (int i = 0; i < z; ++i) {
            dx[i] = x[z + i];
            dx[z + i] = b[i];
        }
    }

    static void cross(const T *a, const T *v, T *out)
    {
        const T x = a[1] * v[2] - a[2] * v[1], y = a[2] * v[0] - a[0] * v[2], q = a[0] * v[1] - a[1] * v[0];
        out[0] = x, out[1] = y, out[2] = q;
    }

    /* (16) with gravity along +e_3: x = [X (2), q_k (3 each), X', omega_k] */
    void rhs_spatial(const T *x, T *dx) const
    {
        const int z = nq();
        const T *q = x + c, *w = x + z + c;
        std::fill(M.begin(), M.end(), T(0));
        std::fill(b.begin(), b.end(), T(0));
        std::vector<T> &square = s;
        for (int i = 0; i < n; ++i)
            square[i] = w[3 * i] * w[3 * i] + w[3 * i + 1] * w[3 * i + 1] + w[3 * i + 2] * w[3 * i + 2];
        for (int a = 0; a < c; ++a) {
            M[(size_t)a * z + a] = total;
            b[a] = f[a];
            for (int i = 0; i < n; ++i)
                b[a] += mu[i] * square[i] * q[3 * i + a];
        }
        for (int i = 0; i < n; ++i) {
            const T *u = q + 3 * i;
            const T hat[3][3] = {{T(0), -u[2], u[1]}, {u[2], T(0), -u[0]}, {-u[1], u[0], T(0)}};
            T push[3] = {T(0), T(0), mu[i] * g};
            for (int j = 0; j < n; ++j) {
                const T scale = cc[(size_t)i * n + j];
                if (j == i) {
                    for (int a = 0; a < 3; ++a)
                        M[(size_t)(c + 3 * i + a) * z + c + 3 * i + a] = scale;
                    continue;
                }
                const T *o = q + 3 * j;
                for (int a = 0; a < 3; ++a)
                    push[a] += scale * square[j] * o[a];
                const T dot = u[0] * o[0] + u[1] * o[1] + u[2] * o[2]; /* -hat u hat o = (u.o) I - o u^T */
                for (int a = 0; a < 3; ++a)
                    for (int e = 0; e < 3; ++e)
                        M[(size_t)(c + 3 * i + a) * z + c + 3 * j + e] = scale * ((a == e ? dot : T(0)) - o[a] * u[e]);
            }
            for (int a = 0; a < 3; ++a) {
                push[a] += k[i] * (i ? q[3 * i - 3 + a] : T(a == 2 ? 1 : 0));
                if (i + 1 < n)
                    push[a] += k[i + 1] * q[3 * i + 3 + a];
            }
            T moment[3], turn[3];
            cross(u, push, moment);
            for (int a = 0; a < 3; ++a) {
                turn[a] = -d[i] * (w[3 * i + a] - (i ? w[3 * i - 3 + a] : T(0)));
                if (i + 1 < n)
                    turn[a] += d[i + 1] * (w[3 * i + 3 + a] - w[3 * i + a]);
            }
            const T along = turn[0] * u[0] + turn[1] * u[1] + turn[2] * u[2];
            for (int a = 0; a < 3; ++a) {
                b[c + 3 * i + a] = moment[a] + turn[a] - along * u[a];
                for (int e = 0; e < c; ++e)
                    M[(size_t)(c + 3 * i + a) * z + e] = M[(size_t)e * z + c + 3 * i + a] = mu[i] * hat[a][e];
            }
        }
        solve();
        for (int a = 0; a < c; ++a)
            dx[a] = x[z + a];
        for (int i = 0; i < n; ++i)
            cross(w + 3 * i, q + 3 * i, dx + c + 3 * i);
        for (int i = 0; i < z; ++i)
            dx[z + i] = b[i];
    }

    /* the scene's own coordinates into the engine's, and back */
    void enter(std::vector<T> &x) const
    {
        const int z = nq();
        if (spatial)
            settle(x);
        else {
            for (int half = 0; half < 2; ++half)
                for (int i = 1; i < n; ++i)
                    x[half * z + c + i] += x[half * z + c + i - 1];
        }
    }
    /* the nearest unit vectors and tangent rates */
    void settle(std::vector<T> &x) const
    {
        const int z = nq();
        for (int i = 0; i < n; ++i) {
            T *q = &x[c + 3 * i], *w = &x[z + c + 3 * i];
            const T norm = sqrt_(q[0] * q[0] + q[1] * q[1] + q[2] * q[2]);
            for (int a = 0; a < 3; ++a)
                q[a] /= norm;
            const T along = q[0] * w[0] + q[1] * w[1] + q[2] * w[2];
            for (int a = 0; a < 3; ++a)
                w[a] -= along * q[a];
        }
    }
    std::vector<T> leave(const std::vector<T> &x) const
    {
        std::vector<T> y = x;
        if (!spatial)
            for (int half = 0; half < 2; ++half)
                for (int i = n - 1; i > 0; --i)
                    y[half * nq() + c + i] -= y[half * nq() + c + i - 1];
        return y;
    }
};
