"""Accelerations to 40 digits by the dense Lagrangian, the yardstick of every candidate's error.

Nothing is shared with the candidates: the inertia matrix of (13) and (16) is formed from its definition and
factorised whole.
"""

from __future__ import annotations

import mpmath as mp
import numpy as np
from numpy.typing import NDArray

from benchmarks.chains import GRAVITY, Chain

DIGITS = 40
Matrix = list[list[mp.mpf]]
Vector = list[mp.mpf]


def accelerations(chain: Chain, state: NDArray[np.float64]) -> NDArray[np.float64]:
    """Accelerations at one state row (q, v, u), correctly rounded but for conditioning at 40 digits.

    A spatial state's unit vectors and tangent rates are taken as the nearest exact ones.
    """
    with mp.workdps(DIGITS):
        row = [mp.mpf(float(x)) for x in state]
        solution = _planar(chain, row) if chain.space == "planar" else _spatial(chain, row)
        return np.array([float(x) for x in solution])


def relative_error(measured: NDArray[np.float64], reference: NDArray[np.float64]) -> float:
    """Largest of max norm over max norm, row by row."""
    return float(np.max(np.max(np.abs(measured - reference), axis=1) / np.max(np.abs(reference), axis=1)))


def _coefficients(chain: Chain) -> tuple[Vector, Matrix]:
    """``mu_k`` and ``c_ij`` of the Lagrangian."""
    mass, length, com = ([mp.mpf(x) for x in values] for values in (chain.mass, chain.length, chain.com))
    count = chain.links
    beyond = [mp.fsum(mass[k + 1 :]) for k in range(count)]
    mu = [mass[k] * com[k] + length[k] * beyond[k] for k in range(count)]
    coupling = [[length[min(i, j)] * mu[max(i, j)] for j in range(count)] for i in range(count)]
    for k in range(count):
        coupling[k][k] = mass[k] * com[k] ** 2 + length[k] ** 2 * beyond[k]
    return mu, coupling


def jacobian(chain: Chain, state: NDArray[np.float64]) -> NDArray[np.float64]:
    """``[d a/d q, d a/d v]`` at one state row, each nv x nv, row-major and one after the other.

    Central differences of the 40-digit accelerations over 1e-13: their error is far below a double's.
    """
    size, step = chain.nq + chain.nv, mp.mpf(10) ** -13
    with mp.workdps(DIGITS):
        row = [mp.mpf(float(x)) for x in state]
        solve = _planar if chain.space == "planar" else _spatial
        columns = []
        for j in range(size):
            up, down = ([*row[:j], row[j] + way * step, *row[j + 1 :]] for way in (1, -1))
            columns.append(
                [float((a - b) / (2 * step)) for a, b in zip(solve(chain, up), solve(chain, down), strict=True)]
            )
    matrix = np.array(columns).T
    return np.concatenate([matrix[:, : chain.nq].ravel(), matrix[:, chain.nq :].ravel()])


def _planar(chain: Chain, row: Vector) -> Vector:
    """(13)-(14) in absolute angles, a cart first, mapped back to relative ones where the chain has them."""
    count, c = chain.links, chain.carts
    mu, coupling = _coefficients(chain)
    inputs = row[2 * chain.nq :]
    angles, rates = row[c : chain.nq], row[chain.nq + c : 2 * chain.nq]
    relative = chain.angles == "relative"
    torque = list(inputs) if chain.forced and not c else [mp.mpf(0)] * count
    phi = [mp.fsum(angles[: k + 1]) for k in range(count)] if relative else angles
    rate = [mp.fsum(rates[: k + 1]) for k in range(count)] if relative else rates
    cosine, sine = [mp.cos(x) for x in phi], [mp.sin(x) for x in phi]
    inertia = [
        [coupling[i][j] * (cosine[i] * cosine[j] + sine[i] * sine[j]) for j in range(count)]
        for i in range(count)
    ]
    right = []
    for i in range(count):
        outer = torque[i + 1] if i + 1 < count and relative else mp.mpf(0)
        spin = mp.fsum(
            coupling[i][j] * (sine[i] * cosine[j] - cosine[i] * sine[j]) * rate[j] ** 2 for j in range(count)
        )
        right.append(torque[i] - outer - spin - GRAVITY * mu[i] * sine[i])
    if c:
        top = [mp.mpf(chain.cart_mass) + mp.fsum(mp.mpf(m) for m in chain.mass), *(m * x for m, x in zip(mu, cosine, strict=True))]
        inertia = [top, *([a, *line] for a, line in zip(top[1:], inertia, strict=True))]
        force = inputs[0] if chain.forced else mp.mpf(0)
        right = [force + mp.fsum(m * x * w**2 for m, x, w in zip(mu, sine, rate, strict=True)), *right]
    found = _solve_spd(inertia, right)
    base, alpha = found[:c], found[c:]
    return [*base, *([alpha[k] - (alpha[k - 1] if k else 0) for k in range(count)] if relative else alpha)]


def _spatial(chain: Chain, row: Vector) -> Vector:
    """(16): the inertia over (x, omega_1, ..) with its blocks ``c_ii I`` and ``-c_ij hat(q_i) hat(q_j)``."""
    count = chain.links
    mu, coupling = _coefficients(chain)
    start = chain.nq + 2
    force = row[chain.nq + chain.nv :] if chain.forced else [mp.mpf(0)] * 2
    direction = [_unit(row[2 + 3 * k : 5 + 3 * k]) for k in range(count)]
    rate = [_tangent(row[start + 3 * k : start + 3 * k + 3], direction[k]) for k in range(count)]
    size = 2 + 3 * count
    inertia = [[mp.mpf(0)] * size for _ in range(size)]
    right = [mp.mpf(0)] * size
    total = mp.mpf(chain.cart_mass or 0) + mp.fsum(chain.mass)
    squares = [mp.fsum(x * x for x in w) for w in rate]
    for axis in range(2):
        inertia[axis][axis] = total
        right[axis] = force[axis] + mp.fsum(mu[k] * squares[k] * direction[k][axis] for k in range(count))
    hats = [_hat(q) for q in direction]
    for i in range(count):
        at = 2 + 3 * i
        for r in range(3):
            inertia[at + r][at + r] = coupling[i][i]
            for axis in range(2):
                inertia[at + r][axis] = inertia[axis][at + r] = mu[i] * hats[i][r][axis]
        moment = [mu[i] * GRAVITY * x for x in _cross(direction[i], [mp.mpf(0), mp.mpf(0), mp.mpf(1)])]
        for j in range(count):
            if j == i:
                continue
            scale = coupling[i][j] * squares[j]
            moment = [x + scale * y for x, y in zip(moment, _cross(direction[i], direction[j]), strict=True)]
            for r in range(3):
                for c in range(3):
                    inertia[at + r][2 + 3 * j + c] = -coupling[i][j] * mp.fsum(
                        hats[i][r][s] * hats[j][s][c] for s in range(3)
                    )
        right[at : at + 3] = moment
    return _solve_spd(inertia, right)


def _solve_spd(matrix: Matrix, right: Vector) -> Vector:
    """Cholesky's ``L D L^T`` without pivoting, for a symmetric positive definite matrix."""
    size = len(right)
    lower = [[mp.mpf(0)] * size for _ in range(size)]
    diagonal = [mp.mpf(0)] * size
    for j in range(size):
        scaled = [lower[j][s] * diagonal[s] for s in range(j)]
        diagonal[j] = matrix[j][j] - mp.fdot(zip(scaled, lower[j][:j], strict=True))
        for i in range(j + 1, size):
            lower[i][j] = (matrix[i][j] - mp.fdot(zip(scaled, lower[i][:j], strict=True))) / diagonal[j]
    solution = list(right)
    for i in range(size):
        solution[i] -= mp.fdot(zip(lower[i][:i], solution[:i], strict=True))
    solution = [x / d for x, d in zip(solution, diagonal, strict=True)]
    for i in reversed(range(size)):
        solution[i] -= mp.fsum(lower[k][i] * solution[k] for k in range(i + 1, size))
    return solution


def _unit(vector: Vector) -> Vector:
    norm = mp.sqrt(mp.fsum(x * x for x in vector))
    return [x / norm for x in vector]


def _tangent(vector: Vector, normal: Vector) -> Vector:
    along = mp.fdot(zip(vector, normal, strict=True))
    return [x - along * n for x, n in zip(vector, normal, strict=True)]


def _hat(q: Vector) -> Matrix:
    zero = mp.mpf(0)
    return [[zero, -q[2], q[1]], [q[2], zero, -q[0]], [-q[1], q[0], zero]]


def _cross(a: Vector, b: Vector) -> Vector:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
