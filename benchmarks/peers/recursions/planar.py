"""Chain P and its kind: the articulated sweep in link frames, the dense closed form, the tension form."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from typing import Any, Protocol

from benchmarks.chains import GRAVITY

Scalar = Any  # a float, an mpf, a casadi.SX or a heyoka.expression
Function = Callable[[Scalar], Scalar]


class Numbers(Protocol):
    """What the recursions read of a chain, in any type of number."""

    @property
    def mass(self) -> Sequence[Any]: ...
    @property
    def length(self) -> Sequence[Any]: ...
    @property
    def com(self) -> Sequence[Any]: ...


def link_frame(
    chain: Numbers, turn: Sequence[Scalar], spin: Sequence[Scalar], moment: Sequence[Scalar], sin: Function, cos: Function,
    cart_mass: Scalar | None = None, force: Scalar = 0.0,
) -> tuple[Scalar, list[Scalar]]:  # fmt: skip
    """Articulated-body sweep in link frames (x along the link, y along its tangent).

    ``A = [axx axy; axy ayy]`` and ``b = (bx, by)`` are the inertia and the force of everything beyond a
    link, at its tip and in its frame. Per link, about 55 operations with unit lengths; every pivot costs one reciprocal.

    Args:
        chain: Masses, lengths, centres.
        turn: Relative angles.
        spin: Absolute rates.
        moment: Generalised forces of the absolute angles; empty for none.
        sin: Of the scalar type.
        cos: Of the scalar type.
        cart_mass: None on a fixed base.
        force: On the cart.

    Returns:
        The cart's acceleration (None on a fixed base) and the absolute angular ones.
    """
    count = len(chain.mass)
    # numbers are folded in units that make the first length 1; symbols are left as they are
    unit = chain.length[0] if isinstance(chain.length[0], float) and cart_mass is None else 1.0
    mass = [m * unit**2 for m in chain.mass]
    length = [x / unit for x in chain.length]
    com = [x / unit for x in chain.com]
    sine, cosine = [sin(x) for x in turn], [cos(x) for x in turn]
    square = [w * w for w in spin]
    axx = axy = ayy = bx = by = 0.0
    gain: list[tuple[Scalar, Scalar, Scalar]] = [(0.0, 0.0, 0.0)] * count
    for k in reversed(range(count)):
        m, l, r = mass[k], length[k], com[k]
        offset = m * r * (1.0 - r / l)
        inverse = 1.0 / (m * r**2 + l**2 * ayy)
        ux = l * axy
        kx = ux * inverse
        ky = 1.0 / l + offset * inverse
        pull = by - square[k] * ux
        p = (moment[k] if len(moment) else 0.0) - l * pull
        gain[k] = (p * inverse, kx, ky)
        if k == 0 and cart_mass is None:
            break
        x = (m + axx) - ux * kx
        y = m * (l - r) ** 2 * (ayy * inverse)
        bx = bx - (m * r + l * axx) * square[k] + kx * p
        by = pull + ky * p
        s, c = sine[k], cosine[k]
        lean = s * (x - y) - c * (2.0 * offset * kx)
        swap = s * lean
        axx, axy, ayy = x - swap, c * lean + offset * kx, y + swap
        bx, by = c * bx - s * by, s * bx + c * by
    gravity, sideways = GRAVITY / unit, 0.0
    if cart_mass is not None:
        sideways = (force + gravity * axy - by) / (cart_mass + ayy)
    ax, ay = -gravity * cosine[0], gravity * sine[0]
    if cart_mass is not None:
        ax, ay = ax + sideways * sine[0], ay + sideways * cosine[0]
    found: list[Scalar] = []
    for k in range(count):
        share, kx, ky = gain[k]
        found.append(share - kx * ax - ky * ay)
        if k + 1 < count:
            ax, ay = ax - length[k] * square[k], ay + length[k] * found[k]
            s, c = sine[k + 1], cosine[k + 1]
            ax, ay = c * ax + s * ay, c * ay - s * ax
    return (None if cart_mass is None else sideways), found


def closed_form(
    chain: Numbers, phi: Sequence[Scalar], spin: Sequence[Scalar], moment: Sequence[Scalar], sin: Function, cos: Function,
    cart_mass: Scalar | None = None, force: Scalar = 0.0,
) -> tuple[Scalar, list[Scalar]]:  # fmt: skip
    """The dense Lagrangian in absolute angles, its matrix factorised symbol by symbol; arguments as `link_frame`.

    The cosine and sine of a difference come from those of the angles.
    """
    n, c = len(chain.mass), 0 if cart_mass is None else 1
    mass, length, com = chain.mass, chain.length, chain.com
    beyond = [sum(mass[k + 1 :]) for k in range(n)]
    mu = [mass[k] * com[k] + length[k] * beyond[k] for k in range(n)]
    sine, cosine = [sin(x) for x in phi], [cos(x) for x in phi]
    matrix: list[list[Scalar]] = [[0.0] * (n + c) for _ in range(n + c)]
    right: list[Scalar] = [0.0] * (n + c)
    for i in range(n):
        matrix[c + i][c + i] = mass[i] * com[i] * com[i] + length[i] * length[i] * beyond[i]
        right[c + i] = -(GRAVITY * mu[i]) * sine[i] + (moment[i] if len(moment) else 0.0)
    for i, j in itertools.combinations(range(n), 2):
        coupling = length[i] * mu[j]
        matrix[c + i][c + j] = matrix[c + j][c + i] = coupling * (cosine[i] * cosine[j] + sine[i] * sine[j])
        swing = coupling * (sine[i] * cosine[j] - cosine[i] * sine[j])
        right[c + i] = right[c + i] - swing * (spin[j] * spin[j])
        right[c + j] = right[c + j] + swing * (spin[i] * spin[i])
    if c:
        matrix[0][0] = cart_mass + sum(mass)
        right[0] = force
        for i in range(n):
            matrix[0][c + i] = matrix[c + i][0] = mu[i] * cosine[i]
            right[0] = right[0] + mu[i] * sine[i] * (spin[i] * spin[i])
    found = solved(matrix, right)
    return (found[0], found[1:]) if c else (None, found)


def tension(
    chain: Numbers, turn: Sequence[Scalar], spin: Sequence[Scalar], sin: Function, cos: Function
) -> tuple[None, list[Scalar]]:
    """r = l, unforced, fixed base: the tridiagonal tensions over relative angles."""
    mass, length, n = chain.mass, chain.length, len(chain.mass)
    sine, cosine = [sin(x) for x in turn], [cos(x) for x in turn]
    light = [1.0 / m for m in mass]
    diagonal: list[Scalar] = [light[0]] + [light[k - 1] + light[k] for k in range(1, n)]
    right: list[Scalar] = [length[k] * (spin[k] * spin[k]) for k in range(n)]
    right[0] = right[0] + GRAVITY * cosine[0]
    off: list[Scalar] = [0.0] + [cosine[k] * light[k - 1] for k in range(1, n)]
    gain: list[Scalar] = [0.0] * n
    inverse: list[Scalar] = [0.0] * n
    for k in reversed(range(n)):
        inverse[k] = 1.0 / diagonal[k]
        if k:
            gain[k] = off[k] * inverse[k]
            diagonal[k - 1] = diagonal[k - 1] - off[k] * gain[k]
            right[k - 1] = right[k - 1] + gain[k] * right[k]
    pull = [right[0] * inverse[0]]
    for k in range(1, n):
        pull.append(right[k] * inverse[k] + gain[k] * pull[k - 1])
    found: list[Scalar] = []
    for k in range(n):
        a = -GRAVITY * sine[0] if k == 0 else -(pull[k - 1] * light[k - 1]) * sine[k]
        found.append((a + (pull[k + 1] * light[k]) * sine[k + 1] if k + 1 < n else a) * (1.0 / length[k]))
    return None, found


def solved(matrix: list[list[Scalar]], right: list[Scalar]) -> list[Scalar]:
    """L D L^T without pivoting, from the last row up, one reciprocal a pivot: the cart, if any, is eliminated last."""
    size = len(right)
    m, b = [list(row) for row in matrix], list(right)
    inverse: list[Scalar] = [0.0] * size
    for p in reversed(range(size)):
        inverse[p] = 1.0 / m[p][p]
        for i in range(p):
            factor = m[i][p] * inverse[p]
            b[i] = b[i] - factor * b[p]
            for j in range(i + 1):
                m[i][j] = m[j][i] = m[i][j] - factor * m[p][j]
    found: list[Scalar] = []
    for i in range(size):
        rest = b[i]
        for j, value in enumerate(found):
            rest = rest - m[i][j] * value
        found.append(rest * inverse[i])
    return found
