"""Chain S and its kind: the tension form, the same from both ends, and the articulated recursion on unit vectors."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from benchmarks.chains import GRAVITY, Chain

Scalar = Any  # a float, an mpf, a casadi.SX or a heyoka.expression


def spatial_tension(
    chain: Chain, position: Sequence[Scalar], velocity: Sequence[Scalar], force: Sequence[Scalar]
) -> list[Scalar]:
    """Tension form on unit vectors: links as distance constraints, one tridiagonal system, tip to cart.

    Arguments in the contract's order: ``position = [x (2), q_1 .. q_N]``, ``velocity = [x' (2), omega_1 ..
    omega_N]``. No trigonometry; per link, about 36 operations with unit masses and lengths.
    """
    system = _tension_system(chain, position, velocity, force)
    return system.accelerations(_eliminated(system))


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


def spatial_tension_direct(
    chain: Chain, position: Sequence[Scalar], rate: Sequence[Scalar], force: Sequence[Scalar]
) -> list[Scalar]:
    """``[x'', q_1'', .. q_N'']`` from ``rate = [x', q_1', .. q_N']``: the tension form without angular velocities.

    Every mass is pulled by two tensions along unit vectors, so q'' needs no cross product: the best form for a Taylor
    series, and this project's own.
    """
    system = _tension_system(chain, position, rate, force)
    tension = _eliminated(system)
    base = system.accelerations(tension)[:2]
    count, unit = chain.links, 1.0 / chain.length[0]
    q = system.directions
    result = list(base)
    before: list[Scalar] = [base[0] * unit, base[1] * unit, -GRAVITY * unit]
    for k in range(count):
        light = chain.mass[0] / chain.mass[k]
        own = [-(tension[k] * light) * x for x in q[k]]
        if k + 1 < count:
            own = [x + (tension[k + 1] * light) * y for x, y in zip(own, q[k + 1], strict=True)]
        result.extend((x - y) * (chain.length[0] / chain.length[k]) for x, y in zip(own, before, strict=True))
        before = own
    return result


def spatial_articulated(
    chain: Chain, position: Sequence[Scalar], velocity: Sequence[Scalar], force: Sequence[Scalar]
) -> list[Scalar]:
    """The articulated-body recursion on S^2: 3 x 3 inertias in the world frame, a 2 x 2 pivot in each tangent plane.

    What the textbook algorithm becomes for links that are unit vectors and masses at r along them. With A and b the
    inertia and force beyond the link, B = m r I + l A, P = m r^2 I + l^2 A, h = l (b - l |w|^2 A q), the inverse of P in
    the tangent plane is K = hat P hat^T / (q . adj(P) q), hat the cross product with q; then q'' + |w|^2 q = -K (B a + h),
    A' = m I + A - B K B and b' = b - |w|^2 B q - B K h. No 3 x 3 inverse; about 250 operations a link.
    """
    count, cart = chain.links, float(chain.cart_mass or 0.0)
    q = [position[2 + 3 * k : 5 + 3 * k] for k in range(count)]
    w = [velocity[2 + 3 * k : 5 + 3 * k] for k in range(count)]
    inertia: list[list[Scalar]] = [[0.0] * 3 for _ in range(3)]
    bias: list[Scalar] = [0.0] * 3
    stored: list[tuple[list[list[Scalar]], list[Scalar], Scalar]] = []
    for k in reversed(range(count)):
        m, l, r, square = chain.mass[k], chain.length[k], chain.com[k], _dot(w[k], w[k])
        lever = _scaled_plus(inertia, l, m * r)  # B
        moment = _scaled_plus(inertia, l * l, m * r * r)  # P
        turned = _columns_crossed(q[k], moment)
        scale = 1.0 / _dot(q[k], [_dot(row, q[k]) for row in _adjugate(moment)])
        mobility = _symmetric(lambda i, j, t=turned, u=q[k], x=scale: _crossed(u, t[i])[j] * x)  # K
        lean = [l * (bias[i] - (l * square) * _dot(inertia[i], q[k])) for i in range(3)]
        gain = [[_dot(mobility[i], lever[j]) for j in range(3)] for i in range(3)]  # K B
        push = [_dot(mobility[i], lean) for i in range(3)]
        stored.append((gain, push, square))
        bias = [bias[i] - _dot(lever[i], [square * x + y for x, y in zip(q[k], push, strict=True)]) for i in range(3)]
        inertia = _symmetric(
            lambda i, j, b=lever, g=gain, a=inertia, m=m: (
                (a[i][j] + m if i == j else a[i][j]) - _dot(b[i], [g[s][j] for s in range(3)])
            )
        )
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
        gain, push, square = stored[count - 1 - k]
        swing = [-(_dot(gain[i], joint) + push[i]) for i in range(3)]
        result.extend(_crossed(q[k], swing))
        joint = [joint[i] + chain.length[k] * (swing[i] - square * q[k][i]) for i in range(3)]
    return result


def _scaled_plus(matrix: list[list[Scalar]], scale: Scalar, diagonal: Scalar) -> list[list[Scalar]]:
    """scale x matrix + diagonal x I of a symmetric matrix."""
    return _symmetric(lambda i, j: scale * matrix[i][j] + (diagonal if i == j else 0.0))


def _symmetric(entry: Callable[[int, int], Scalar]) -> list[list[Scalar]]:
    """A symmetric 3 x 3 matrix from the entries on and above its diagonal."""
    upper = {(i, j): entry(i, j) for i in range(3) for j in range(i, 3)}
    return [[upper[min(i, j), max(i, j)] for j in range(3)] for i in range(3)]


def _dot(a: Sequence[Scalar], b: Sequence[Scalar]) -> Scalar:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _crossed(a: Sequence[Scalar], b: Sequence[Scalar]) -> list[Scalar]:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def _columns_crossed(a: Sequence[Scalar], matrix: list[list[Scalar]]) -> list[list[Scalar]]:
    """hat(a) times a matrix."""
    columns = [_crossed(a, [matrix[i][j] for i in range(3)]) for j in range(3)]
    return [[columns[j][i] for j in range(3)] for i in range(3)]


def _adjugate(s: list[list[Scalar]]) -> list[list[Scalar]]:
    """Cofactors of a symmetric 3 x 3 matrix."""
    c00 = s[1][1] * s[2][2] - s[1][2] * s[1][2]
    c01 = s[1][2] * s[0][2] - s[0][1] * s[2][2]
    c02 = s[0][1] * s[1][2] - s[1][1] * s[0][2]
    c11 = s[0][0] * s[2][2] - s[0][2] * s[0][2]
    c12 = s[0][1] * s[0][2] - s[0][0] * s[1][2]
    c22 = s[0][0] * s[1][1] - s[0][1] * s[0][1]
    return [[c00, c01, c02], [c01, c11, c12], [c02, c12, c22]]


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


def _eliminated(system: _TensionSystem) -> list[Scalar]:
    """The tensions, eliminated from tip to cart."""
    count = system.chain.links
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
    return tension
