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


def spatial_articulated(
    chain: Chain, position: Sequence[Scalar], velocity: Sequence[Scalar], force: Sequence[Scalar]
) -> list[Scalar]:
    """The articulated-body recursion on S^2: 3 x 3 inertias in the world frame, one 3 x 3 pivot a link.

    What the textbook algorithm becomes for links that are unit vectors: with M = m I + A, hat the cross
    product and h = b - l |w|^2 M q, the pivot S = hat M hat^T + q q^T gives omega' = -S^-1 hat (M a + h) / l,
    A' = M + M hat S^-1 hat M and b' = h + M hat S^-1 hat h. About 190 operations per link.
    """
    count, cart = chain.links, float(chain.cart_mass or 0.0)
    q = [position[2 + 3 * k : 5 + 3 * k] for k in range(count)]
    w = [velocity[2 + 3 * k : 5 + 3 * k] for k in range(count)]
    inertia: list[list[Scalar]] = [[0.0] * 3 for _ in range(3)]
    bias: list[Scalar] = [0.0] * 3
    stored: list[tuple[list[list[Scalar]], list[Scalar], list[list[Scalar]], Scalar]] = []
    for k in reversed(range(count)):
        length, square = chain.length[k], sum((x * x for x in w[k]), 0.0)
        total = [[inertia[i][j] + (chain.mass[k] if i == j else 0.0) for j in range(3)] for i in range(3)]
        turned = _columns_crossed(q[k], total)  # hat M
        pivot = [
            [_crossed(q[k], turned[i])[j] + q[k][i] * q[k][j] for j in range(3)] for i in range(3)
        ]  # hat M hat^T + q q^T, rows of hat M crossed with q
        inverse = _inverse(pivot)
        lean = [bias[i] - (length * square) * _dot(total[i], q[k]) for i in range(3)]
        stored.append((turned, _crossed(q[k], lean), inverse, square))
        gain = [[_dot(inverse[i], [turned[a][j] for a in range(3)]) for j in range(3)] for i in range(3)]
        push = [_dot(inverse[i], _crossed(q[k], lean)) for i in range(3)]
        columns = [[turned[a][i] for a in range(3)] for i in range(3)]
        inertia = [[total[i][j] - _dot(columns[i], [gain[a][j] for a in range(3)]) for j in range(3)] for i in range(3)]
        bias = [lean[i] - _dot(columns[i], push) for i in range(3)]
    drive = list(force) if len(force) else [0.0, 0.0]
    left = [[inertia[i][j] + (cart if i == j else 0.0) for j in range(2)] for i in range(2)]
    right = [drive[i] - bias[i] + GRAVITY * inertia[i][2] for i in range(2)]
    inverse_cart = 1.0 / (left[0][0] * left[1][1] - left[0][1] * left[1][0])
    base = [
        (left[1][1] * right[0] - left[0][1] * right[1]) * inverse_cart,
        (left[0][0] * right[1] - left[1][0] * right[0]) * inverse_cart,
    ]
    joint: list[Scalar] = [*base, -GRAVITY]
    result = list(base)
    for k in range(count):
        turned, lean, inverse, square = stored[count - 1 - k]
        length = chain.length[k]
        moved = [_dot(turned[i], joint) + lean[i] for i in range(3)]
        rate = [-_dot(inverse[i], moved) * (1.0 / length) for i in range(3)]
        result.extend(rate)
        swing = _crossed(rate, q[k])
        joint = [joint[i] + length * (swing[i] - square * q[k][i]) for i in range(3)]
    return result


def _dot(a: Sequence[Scalar], b: Sequence[Scalar]) -> Scalar:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _crossed(a: Sequence[Scalar], b: Sequence[Scalar]) -> list[Scalar]:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def _columns_crossed(a: Sequence[Scalar], matrix: list[list[Scalar]]) -> list[list[Scalar]]:
    """hat(a) times a matrix."""
    columns = [_crossed(a, [matrix[i][j] for i in range(3)]) for j in range(3)]
    return [[columns[j][i] for j in range(3)] for i in range(3)]


def _inverse(s: list[list[Scalar]]) -> list[list[Scalar]]:
    """Inverse of a symmetric 3 x 3 matrix by cofactors."""
    c00 = s[1][1] * s[2][2] - s[1][2] * s[1][2]
    c01 = s[1][2] * s[0][2] - s[0][1] * s[2][2]
    c02 = s[0][1] * s[1][2] - s[1][1] * s[0][2]
    c11 = s[0][0] * s[2][2] - s[0][2] * s[0][2]
    c12 = s[0][1] * s[0][2] - s[0][0] * s[1][2]
    c22 = s[0][0] * s[1][1] - s[0][1] * s[0][1]
    scale = 1.0 / (s[0][0] * c00 + s[0][1] * c01 + s[0][2] * c02)
    return [[x * scale for x in row] for row in ([c00, c01, c02], [c01, c11, c12], [c02, c12, c22])]


#: The spatial forms by name; a table says which one a peer was given.
SPATIAL = {"tension": spatial_tension, "twisted": spatial_tension_twisted, "recursion": spatial_articulated}
#: How a table names them; the tension form is this project's own (design of the emitted code).
LABELS = {"tension": ", given the tension form", "twisted": ", given the twisted form", "recursion": ", recursion on S^2"}


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
