"""Accelerations of any rig by its dense Lagrangian in many digits: written by hand from mu_k and c_ij, and solved as one matrix."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from mpmath import cos, lu_solve, matrix, mpf, sin, sqrt, tanh

from phichain.scene import Scene

Numbers = Sequence[Any]
Given = Mapping[str, Numbers]
PER_LINK = ("mass", "length", "com", "inertia", "armature", "damping", "stiffness", "rest_angle", "friction")
ALONE = ("gravity", "cart_mass", "cart_damping", "cart_friction")


def numbers(scene: Scene) -> dict[str, list[Any]]:
    """Every number of a scene, exactly; zero for what it does not name."""
    found = {}
    for name in (*PER_LINK, *ALONE):
        value = getattr(scene, name)
        value = scene.length if name == "com" and value is None else value
        count = scene.links if name in PER_LINK else 1
        found[name] = [mpf(float(x)) for x in np.broadcast_to(0.0 if value is None else value, (count,))]
    return found


def rub(size: Any, speed: float | None, rate: Any) -> Any:
    """F tanh(v / v_0)."""
    return size * tanh(rate / mpf(speed)) if speed else mpf(0)


def sums(p: Given) -> tuple[list[Any], list[list[Any]], Any]:
    """mu_k, c_ij and the mass of all links."""
    m, l, r, n = p["mass"], p["length"], p["com"], len(p["mass"])
    beyond = [sum(m[k + 1 :], mpf(0)) for k in range(n)]
    mu = [m[k] * r[k] + l[k] * beyond[k] for k in range(n)]
    own = [m[k] * r[k] ** 2 + p["inertia"][k] + l[k] ** 2 * beyond[k] for k in range(n)]
    return mu, [[own[i] if i == j else l[min(i, j)] * mu[max(i, j)] for j in range(n)] for i in range(n)], sum(m, mpf(0))


def told(scene: Scene, u: Numbers) -> tuple[list[Any], list[Any], list[Any]]:
    """The base's acceleration, the force or acceleration of a cart, and joint torques."""
    wide = 2 if scene.is_planar else 3
    base = wide if scene.base == "moving" else 0
    cart = wide - 1 if scene.has_cart and scene.actuated != "none" else 0
    return [*u[:base], *[mpf(0)] * (wide - base)], list(u[base : base + cart]) or [mpf(0)] * (wide - 1), list(u[base + cart :])


def planar(scene: Scene, p: Given, q: Numbers, v: Numbers, u: Numbers) -> list[Any]:
    """x'' and the angles' accelerations, relative or absolute as the scene's."""
    n, carts, is_relative = scene.links, int(scene.has_cart), scene.angles == "relative"
    mu, c, whole = sums(p)
    moved, push, torque = told(scene, u)
    phi, rate = ([sum(x[carts : carts + k + 1]) if is_relative else x[carts + k] for k in range(n)] for x in (q, v))
    bend, turn = ([x[k] - (x[k - 1] if k else 0) for k in range(n)] for x in (phi, rate))
    joint = [
        -p["damping"][k] * turn[k] - p["stiffness"][k] * (bend[k] - p["rest_angle"][k]) - rub(p["friction"][k], scene.friction_speed, turn[k])
        + (torque[k] if torque and is_relative else 0)
        for k in range(n)
    ] + [mpf(0)]  # fmt: skip
    a, right = matrix(carts + n, carts + n), matrix(carts + n, 1)
    for i in range(n):
        right[carts + i] = joint[i] - joint[i + 1] - mu[i] * ((p["gravity"][0] - moved[1]) * sin(phi[i]) + moved[0] * cos(phi[i]))
        right[carts + i] += torque[i] if torque and not is_relative else 0
        for j in range(n):
            a[carts + i, carts + j] = c[i][j] * cos(phi[i] - phi[j])
            right[carts + i] -= c[i][j] * sin(phi[i] - phi[j]) * rate[j] ** 2
    for k, rotor in enumerate(p["armature"]):
        for i in (k - 1, k) if k else (k,):
            for j in (k - 1, k) if k else (k,):
                a[carts + i, carts + j] += rotor if i == j else -rotor
    if carts:
        is_told = scene.drive == "acceleration"
        a[0, 0] = mpf(1) if is_told else whole + p["cart_mass"][0]
        right[0] = push[0]
        for i in range(n):
            a[1 + i, 0] = mu[i] * cos(phi[i])
            a[0, 1 + i] = mpf(0) if is_told else a[1 + i, 0]
            right[0] += mpf(0) if is_told else mu[i] * sin(phi[i]) * rate[i] ** 2
        right[0] -= mpf(0) if is_told else p["cart_damping"][0] * v[0] + rub(p["cart_friction"][0], scene.cart_friction_speed, v[0])
    found = list(lu_solve(a, right))
    return found[:carts] + [found[carts + k] - (found[carts + k - 1] if k and is_relative else 0) for k in range(n)]


def amplified(
    form: Callable[..., list[Any]], scene: Scene, p: Given, args: Sequence[Numbers], true: Numbers, rng: np.random.Generator
) -> Any:
    """What half a unit in the last place of every number does to the accelerations, of the largest; of four draws the worst."""
    found = mpf(0)
    for _ in range(4):
        near = lambda values: [x * (1 + mpf(2) ** -80 * int(rng.choice([-1, 1]))) for x in values]
        other = form(scene, {name: near(values) for name, values in p.items()}, *map(near, args))
        found = max(found, max(abs(a - b) for a, b in zip(true, other, strict=True)) / max(map(abs, true)) * mpf(2) ** 27)
    return found


def cross(a: Numbers, b: Numbers) -> list[Any]:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def dot(a: Numbers, b: Numbers) -> Any:
    return sum(x * y for x, y in zip(a, b, strict=True))


def across(link: Numbers) -> list[list[Any]]:
    """Two directions across a link, and each other."""
    axis = [mpf(k == min(range(3), key=lambda i: abs(link[i]))) for k in range(3)]
    one = cross(link, axis)
    one = [x / sqrt(dot(one, one)) for x in one]
    return [one, cross(link, one)]


def spatial(scene: Scene, p: Given, q: Numbers, v: Numbers, u: Numbers) -> list[Any]:
    """x'' and the links' angular accelerations, from virtual turns about two directions across each."""
    n, carts = scene.links, 2 * int(scene.has_cart)
    mu, c, whole = sums(p)
    moved, push, _ = told(scene, u)
    links, spins = ([list(x[carts + 3 * k : carts + 3 * k + 3]) for k in range(n)] for x in (q, v))
    links = [[x / sqrt(dot(link, link)) for x in link] for link in links]
    spins = [[x - y * dot(spin, link) for x, y in zip(spin, link, strict=True)] for spin, link in zip(spins, links, strict=True)]
    torque = [[mpf(0)] * 3 for _ in range(n)]
    for k in range(n):
        slip = [x - (spins[k - 1][i] if k else 0) for i, x in enumerate(spins[k])]
        size = sqrt(dot(slip, slip))
        loss = p["damping"][k] + rub(p["friction"][k], scene.friction_speed, size) / size
        back = cross(links[k], links[k - 1] if k else [mpf(0), mpf(0), mpf(1)])
        for i in range(3):
            acting = p["stiffness"][k] * back[i] - loss * slip[i]
            torque[k][i] += acting
            if k:
                torque[k - 1][i] -= acting
    turns = [(k, about, cross(about, links[k])) for k in range(n) for about in across(links[k])]
    weight = [-moved[0], -moved[1], p["gravity"][0] - moved[2]]
    a, right = matrix(carts + 2 * n, carts + 2 * n), matrix(carts + 2 * n, 1)
    for row, (i, about, aside) in enumerate(turns, carts):
        right[row] = dot(about, torque[i]) + mu[i] * dot(aside, weight)
        right[row] += sum(c[i][j] * dot(spins[j], spins[j]) * dot(aside, links[j]) for j in range(n))
        for column, (j, _, other) in enumerate(turns, carts):
            a[row, column] = c[i][j] * dot(aside, other)
        for k in range(carts):
            a[row, k] = mu[i] * aside[k]
            a[k, row] = mpf(0) if scene.drive == "acceleration" else a[row, k]
    speed = sqrt(dot(v[:carts], v[:carts])) if carts else mpf(0)
    for k in range(carts):
        a[k, k], right[k] = mpf(1), push[k]
        if scene.drive != "acceleration":
            a[k, k] = whole + p["cart_mass"][0]
            right[k] += sum(mu[i] * links[i][k] * dot(spins[i], spins[i]) for i in range(n))
            right[k] -= v[k] * (p["cart_damping"][0] + rub(p["cart_friction"][0], scene.cart_friction_speed, speed) / speed)
    found = list(lu_solve(a, right))
    rates = [[found[carts + 2 * k] * one + found[carts + 2 * k + 1] * two for one, two in zip(*(t[1] for t in turns[2 * k : 2 * k + 2]), strict=True)] for k in range(n)]
    return found[:carts] + [x for rate in rates for x in rate]
