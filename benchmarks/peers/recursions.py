"""The O(N) recursions an expert would write by hand for chains P and S, over any scalar type.

CasADi and heyoka build their expressions by running these functions on their own symbols, so neither is
held back by a poorer formula than the other's. Constants are folded before the symbols are met: units are
chosen so that the first link's length and the unit of torque are 1, which removes most multiplications of a
uniform chain, and every division by a pivot is one reciprocal.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from benchmarks.chains import GRAVITY, Chain

Scalar = Any  # a float, an mpf, a casadi.SX or a heyoka.expression
Function = Callable[[Scalar], Scalar]


def planar_link_frame(
    chain: Chain,
    theta: Sequence[Scalar],
    rate: Sequence[Scalar],
    torque: Sequence[Scalar],
    sin: Function,
    cos: Function,
) -> list[Scalar]:
    """Articulated-body sweep in link frames (x along the link, y along its tangent) for relative angles.

    ``A = [axx axy; axy ayy]`` and ``b = (bx, by)`` are the inertia and the force of everything beyond a
    link, at its tip and in its frame. Per link, about 55 operations with unit lengths.
    """
    count, unit = chain.links, chain.length[0]
    mass = [m * unit**2 for m in chain.mass]
    length = [x / unit for x in chain.length]
    com = [x / unit for x in chain.com]
    sine, cosine = [sin(x) for x in theta], [cos(x) for x in theta]
    square = _squared_absolute_rates(rate)

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
        moment = (torque[k] - torque[k + 1] if k + 1 < count else torque[k]) if len(torque) else 0.0
        p = moment - l * pull
        gain[k] = (p * inverse, kx, ky)
        if k == 0:
            break
        x = (m + axx) - ux * kx
        y = m * (l - r) ** 2 * (ayy * inverse)
        bx = bx - (m * r + l * axx) * square[k] + kx * p
        by = pull + ky * p
        s, c = sine[k], cosine[k]
        turn = s * (x - y) - c * (2.0 * offset * kx)
        swap = s * turn
        axx, axy, ayy = x - swap, c * turn + offset * kx, y + swap
        bx, by = c * bx - s * by, s * bx + c * by

    ax, ay = -(GRAVITY / unit) * cosine[0], (GRAVITY / unit) * sine[0]
    result: list[Scalar] = []
    before: Scalar = 0.0
    for k in range(count):
        share, kx, ky = gain[k]
        alpha = share - kx * ax - ky * ay
        result.append(alpha - before)
        before = alpha
        if k + 1 < count:
            ax, ay = ax - length[k] * square[k], ay + length[k] * alpha
            s, c = sine[k + 1], cosine[k + 1]
            ax, ay = c * ax + s * ay, c * ay - s * ax
    return result


def _squared_absolute_rates(rate: Sequence[Scalar]) -> list[Scalar]:
    """Squares of the running sums of the relative rates."""
    squares, total = [], rate[0]
    for k, own in enumerate(rate):
        total = total + own if k else own
        squares.append(total * total)
    return squares


def spatial_tension(
    chain: Chain, position: Sequence[Scalar], velocity: Sequence[Scalar], force: Sequence[Scalar]
) -> list[Scalar]:
    """Tension form on unit vectors: links as distance constraints, one tridiagonal system, tip to cart.

    Arguments in the contract's order: ``position = [x (2), q_1 .. q_N]``, ``velocity = [x' (2), omega_1 ..
    omega_N]``. No trigonometry; per link, about 36 operations with unit masses and lengths.
    """
    system = _tension_system(chain, position, velocity, force)
    count = chain.links
    diagonal, off, right = list(system.diagonal), system.off, list(system.right)
    gain: list[Scalar] = [0.0] * count
    inverse: list[Scalar] = [0.0] * count
    for k in reversed(range(count)):
        inverse[k] = 1.0 / diagonal[k]
        if k:
            gain[k] = off[k] * inverse[k]
            diagonal[k - 1] = diagonal[k - 1] - off[k] * gain[k]
            right[k - 1] = right[k - 1] + gain[k] * right[k]
    tension = [right[0] * inverse[0]]
    for k in range(1, count):
        tension.append(right[k] * inverse[k] + gain[k] * tension[k - 1])
    return system.accelerations(tension)


def spatial_tension_twisted(
    chain: Chain, position: Sequence[Scalar], velocity: Sequence[Scalar], force: Sequence[Scalar]
) -> list[Scalar]:
    """The same system eliminated from both ends to the middle, two chains that do not wait for each other.

    No peer is known to do this by itself; it is here so that a table can tell a better formula from a
    better code generator.
    """
    system = _tension_system(chain, position, velocity, force)
    count = chain.links
    middle = count // 2
    diagonal, off, right = list(system.diagonal), system.off, list(system.right)
    gain: list[Scalar] = [0.0] * count
    scaled: list[Scalar] = [0.0] * count
    for k in reversed(range(middle + 1, count)):
        inverse = 1.0 / diagonal[k]
        gain[k], scaled[k] = off[k] * inverse, right[k] * inverse
        diagonal[k - 1] = diagonal[k - 1] - off[k] * gain[k]
        right[k - 1] = right[k - 1] + gain[k] * right[k]
    for k in range(middle):
        inverse = 1.0 / diagonal[k]
        gain[k], scaled[k] = off[k + 1] * inverse, right[k] * inverse
        diagonal[k + 1] = diagonal[k + 1] - off[k + 1] * gain[k]
        right[k + 1] = right[k + 1] + gain[k] * right[k]
    tension: list[Scalar] = [0.0] * count
    tension[middle] = right[middle] / diagonal[middle]
    for k in range(middle + 1, count):
        tension[k] = scaled[k] + gain[k] * tension[k - 1]
    for k in reversed(range(middle)):
        tension[k] = scaled[k] + gain[k] * tension[k + 1]
    return system.accelerations(tension)


@dataclass(frozen=True)
class _TensionSystem:
    """``diagonal[k] t_k - off[k] t_{k-1} - off[k+1] t_{k+1} = right[k]``, first mass and length as units."""

    chain: Chain
    directions: list[Sequence[Scalar]]
    crosses: list[list[Scalar]]
    diagonal: list[Scalar]
    off: list[Scalar]
    right: list[Scalar]
    force: Sequence[Scalar]

    def accelerations(self, tension: Sequence[Scalar]) -> list[Scalar]:
        """``[x'', omega_1', .. omega_N']`` from the tensions."""
        chain, count = self.chain, self.chain.links
        mass = [m / chain.mass[0] for m in chain.mass]
        length = [x / chain.length[0] for x in chain.length]
        cart = float(chain.cart_mass or 0.0)
        q = self.directions[0]
        scale = chain.mass[0] * chain.length[0] / cart
        pull = [tension[0] * q[i] * scale for i in range(2)]
        base = [pull[i] + self.force[i] * (1.0 / cart) for i in range(2)] if len(self.force) else pull
        # q_1 x (g e_3 - x'') over l_1, the only place where gravity and the cart enter a link
        gravity, unit = GRAVITY / chain.length[0], 1.0 / chain.length[0]
        sway = [base[i] * unit for i in range(2)]
        first = [
            q[1] * gravity + q[2] * sway[1],
            -(q[0] * gravity) - q[2] * sway[0],
            q[1] * sway[0] - q[0] * sway[1],
        ]
        result = list(base)
        for k in range(count):
            own = first if k == 0 else [-(tension[k - 1] / mass[k - 1]) * x for x in self.crosses[k - 1]]
            if k + 1 < count:
                outer = tension[k + 1] * (1.0 / mass[k])
                own = [outer * x + y for x, y in zip(self.crosses[k], own, strict=True)]
            result.extend(y * (1.0 / length[k]) for y in own)
        return result


def _tension_system(
    chain: Chain, position: Sequence[Scalar], velocity: Sequence[Scalar], force: Sequence[Scalar]
) -> _TensionSystem:
    count = chain.links
    mass = [m / chain.mass[0] for m in chain.mass]
    length = [x / chain.length[0] for x in chain.length]
    cart = float(chain.cart_mass or 0.0)
    q = [position[2 + 3 * k : 5 + 3 * k] for k in range(count)]
    w = [velocity[2 + 3 * k : 5 + 3 * k] for k in range(count)]
    horizontal = q[0][0] * q[0][0] + q[0][1] * q[0][1]
    diagonal: list[Scalar] = [1.0 / mass[0] + (chain.mass[0] / cart) * horizontal]
    off: list[Scalar] = [0.0]
    right: list[Scalar] = [
        length[k] * (w[k][0] * w[k][0] + w[k][1] * w[k][1] + w[k][2] * w[k][2]) for k in range(count)
    ]
    drive = (GRAVITY / chain.length[0]) * q[0][2]
    if len(force):
        drive = drive - (1.0 / (cart * chain.length[0])) * (force[0] * q[0][0] + force[1] * q[0][1])
    right[0] = right[0] + drive
    crosses = []
    for k in range(1, count):
        a, b = q[k - 1], q[k]
        diagonal.append(1.0 / mass[k - 1] + 1.0 / mass[k])
        off.append((a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) * (1.0 / mass[k - 1]))
        crosses.append([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
    return _TensionSystem(chain, q, crosses, diagonal, off, right, force)
