"""Planar chains with losses as a dense Lagrangian says them, in any number of digits: nothing of phichain but the scene's numbers.

In absolute angles T = 1/2 m_0 x'^2 + 1/2 sum_a m_a |r_a'|^2 gives M = sum_a m_a J_a^T J_a and h = sum_a m_a J_a^T (centripetal - g);
with theta = S^-1 phi both are pulled back, and joint k resists its relative rate and its relative angle as its law says.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from mpmath import lu_solve, matrix, mp, mpf

from phichain.scene import Scene


def _per_link(scene: Scene, name: str) -> list[Any]:
    value = getattr(scene, name)
    return [mpf(0)] * scene.links if value is None else [mpf(x) for x in value]


def angle_map(scene: Scene) -> Any:
    """S of phi = S theta."""
    reach = {"absolute": 0, "adjacent": 1, "relative": scene.links}[str(scene.angles)]
    return matrix([[mpf(0 <= i - j <= reach) for j in range(scene.links)] for i in range(scene.links)])


def resisting(scene: Scene, relative: Sequence[Any], rates: Sequence[Any]) -> list[Any]:
    """What spring, damper and dry friction of every joint ask for."""
    names = ("stiffness", "rest_angle", "damping", "friction")
    speed = mpf(scene.friction_speed or 1)
    return [
        k * (angle - rest) + d * rate + force * mp.tanh(rate / speed)
        for angle, rate, k, rest, d, force in zip(relative, rates, *(_per_link(scene, name) for name in names), strict=True)
    ]


def accelerations(scene: Scene, q: Sequence[Any], v: Sequence[Any], u: Sequence[Any] = ()) -> list[Any]:
    """a of M a + h + resistance = B u, by LU of the dense matrix."""
    cart, links = int(scene.has_cart), scene.links
    S = angle_map(scene)
    phi, phi_dot = (S * matrix([mpf(x) for x in part[cart:]]) for part in (q, v))
    length, com = _per_link(scene, "length"), _per_link(scene, "length" if scene.com is None else "com")
    size = cart + links
    M, h = matrix(size, size), matrix(size, 1)
    if cart:
        M[0, 0] = mpf(scene.cart_mass)
    for a, mass in enumerate(_per_link(scene, "mass")):
        arms = [*length[:a], com[a]]
        sideways = [mpf(1)] * cart + [arms[k] * mp.cos(phi[k]) if k <= a else mpf(0) for k in range(links)]
        down = [mpf(0)] * cart + [-arms[k] * mp.sin(phi[k]) if k <= a else mpf(0) for k in range(links)]
        inward = [-sum(arms[k] * phi_dot[k] ** 2 * turn(phi[k]) for k in range(a + 1)) for turn in (mp.sin, mp.cos)]
        for i in range(size):
            h[i] += mass * (sideways[i] * inward[0] + down[i] * (inward[1] - mpf(scene.gravity)))
            for j in range(size):
                M[i, j] += mass * (sideways[i] * sideways[j] + down[i] * down[j])
    relative, rates = ([part[0], *(part[k] - part[k - 1] for k in range(1, links))] for part in (phi, phi_dot))
    moments = [*resisting(scene, relative, rates), mpf(0)]
    for k in range(links):
        h[cart + k] += moments[k] - moments[k + 1]
    whole = matrix(size, size)
    for i in range(cart):
        whole[i, i] = mpf(1)
    for i in range(links):
        for j in range(links):
            whole[cart + i, cart + j] = S[i, j]
    right = -(whole.T * h)
    if cart:
        speed = mpf(v[0])
        right[0] -= mpf(scene.cart_damping or 0) * speed
        right[0] -= mpf(scene.cart_friction or 0) * mp.tanh(speed / mpf(scene.cart_friction_speed or 1))
    for entry, value in zip(scene.driven, u, strict=True):
        right[entry] += mpf(value)
    return list(lu_solve(whole.T * M * whole, right))
