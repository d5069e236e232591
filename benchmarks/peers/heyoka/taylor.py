"""heyoka's adaptive Taylor integrator on phichain's scenes: an expert's formulation for each kind of chain."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from benchmarks.chains import GRAVITY, Chain
from benchmarks.harness import BenchmarkError
from benchmarks.peers import recursions
from phichain.scene import Scene

Expression = Any
FORMS = ("link frame", "closed form", "tension")
"""Planar: the articulated recursion in relative angles; the dense Lagrangian in absolute ones, factorised symbol by
symbol. Spatial: the tension form on unit vectors."""
_MOST_DENSE = 4


@dataclass(frozen=True)
class _Numbers:
    """What the recursion reads of a chain, in any type of number."""

    mass: tuple[Any, ...]
    length: tuple[Any, ...]
    com: tuple[Any, ...]

    @property
    def links(self) -> int:
        return len(self.mass)


def form_of(scene: Scene) -> str:
    """The form that serves any chain of this kind.

    Raises:
        BenchmarkError: none of them does.
    """
    if scene.gravity != GRAVITY:
        raise BenchmarkError("the peers' formulations have g = 9.81")
    if scene.is_planar and not scene.has_cart:
        return "link frame"
    if scene.is_planar and scene.links <= _MOST_DENSE:
        return "closed form"
    if not scene.is_planar and scene.has_cart and not (scene.stiffness or scene.damping or scene.com):
        return "tension"
    raise BenchmarkError("no expert's form at hand for this chain")


def equations(
    scene: Scene, form: str | None = None, number: Callable[[float], Any] = float
) -> list[tuple[Expression, Expression]]:
    """(state, its rate) for (q, v); in the scene's coordinates but for the closed form, whose angles are absolute.

    Args:
        scene: the chain.
        form: one of FORMS; the one that serves by default.
        number: the type of the constants.
    """
    return {"link frame": _link_frame, "closed form": _closed_form, "tension": _tension}[
        form or form_of(scene)
    ](scene, number)


def _link_frame(scene: Scene, number: Callable[[float], Any]) -> list[tuple[Expression, Expression]]:
    import heyoka as hy

    theta, rate = _symbols("theta", scene.links), _symbols("rate", scene.links)
    values = (tuple(map(number, x)) for x in (scene.mass, scene.length, scene.com or scene.length))
    springs, dampers = ([*map(number, x or (0.0,) * scene.links)] for x in (scene.stiffness, scene.damping))
    pulled = scene.stiffness is not None or scene.damping is not None
    torque = (
        [-k * a - d * w for k, d, a, w in zip(springs, dampers, theta, rate, strict=True)] if pulled else []
    )
    found = recursions.planar_link_frame(_Numbers(*values), theta, rate, torque, hy.sin, hy.cos)  # type: ignore[arg-type]
    return [*zip(theta, rate, strict=True), *zip(rate, found, strict=True)]


def _closed_form(scene: Scene, number: Callable[[float], Any]) -> list[tuple[Expression, Expression]]:
    """M(phi) w' = ... with L D L^T written out; a cart comes first."""
    import heyoka as hy

    n, c = scene.links, int(scene.has_cart)
    phi, w = _symbols("phi", n), _symbols("w", n)
    mass, length, com = (tuple(map(number, x)) for x in (scene.mass, scene.length, scene.com or scene.length))
    beyond = [sum(mass[k + 1 :], start=number(0.0)) for k in range(n)]
    mu = [mass[k] * com[k] + length[k] * beyond[k] for k in range(n)]
    matrix: list[list[Any]] = [[number(0.0)] * (n + c) for _ in range(n + c)]
    right: list[Any] = [number(0.0)] * (n + c)
    for i in range(n):
        matrix[c + i][c + i] = mass[i] * com[i] * com[i] + length[i] * length[i] * beyond[i]
        right[c + i] = -(GRAVITY * mu[i]) * hy.sin(phi[i])
        for j in range(n):
            if j != i:
                coupling = length[min(i, j)] * mu[max(i, j)]
                matrix[c + i][c + j] = coupling * hy.cos(phi[i] - phi[j])
                right[c + i] = right[c + i] - coupling * hy.sin(phi[i] - phi[j]) * w[j] * w[j]
    for i, torque in enumerate(_joint_torques(scene, phi, w, number)):
        right[c + i] = right[c + i] + torque
    if c:
        matrix[0][0] = number(scene.cart_mass) + sum(mass, start=number(0.0))  # type: ignore[arg-type]
        for i in range(n):
            matrix[0][c + i] = matrix[c + i][0] = mu[i] * hy.cos(phi[i])
            right[0] = right[0] + mu[i] * hy.sin(phi[i]) * w[i] * w[i]
    x, rate = _symbols("x", c), _symbols("x_rate", c)
    solved = _solved(matrix, right)
    return [*zip(x + phi, rate + w, strict=True), *zip(rate + w, solved, strict=True)]


def _joint_torques(scene: Scene, phi: list[Any], w: list[Any], number: Callable[[float], Any]) -> list[Any]:
    if scene.stiffness is None and scene.damping is None:
        return []
    n = scene.links
    springs, dampers = ([*map(number, x or (0.0,) * n)] for x in (scene.stiffness, scene.damping))
    bend = [phi[0], *(b - a for a, b in itertools.pairwise(phi))]
    spin = [w[0], *(b - a for a, b in itertools.pairwise(w))]
    own = [-k * a - d * s for k, d, a, s in zip(springs, dampers, bend, spin, strict=True)]
    return [own[i] - own[i + 1] if i + 1 < n else own[i] for i in range(n)]


def _solved(matrix: list[list[Any]], right: list[Any]) -> list[Any]:
    """L D L^T without pivoting, from the last row up: the cart, if any, is eliminated last."""
    size = len(right)
    m, b = [list(row) for row in matrix], list(right)
    for p in reversed(range(size)):
        for i in range(p):
            factor = m[i][p] / m[p][p]
            b[i] = b[i] - factor * b[p]
            for j in range(i + 1):
                m[i][j] = m[i][j] - factor * m[p][j]
                m[j][i] = m[i][j]
    found: list[Any] = []
    for i in range(size):
        rest = b[i]
        for j, value in enumerate(found):
            rest = rest - m[i][j] * value
        found.append(rest / m[i][i])
    return found


def _tension(scene: Scene, number: Callable[[float], Any]) -> list[tuple[Expression, Expression]]:
    n = scene.links
    chain = Chain("spatial", scene.mass, scene.length, scene.length, scene.cart_mass, False)  # type: ignore[arg-type]
    q, v = _symbols("q", 2 + 3 * n), _symbols("v", 2 + 3 * n)
    found = recursions.spatial_tension(chain, q, v, ())
    moving = list(v[:2])
    for k in range(n):
        a, u = v[2 + 3 * k : 5 + 3 * k], q[2 + 3 * k : 5 + 3 * k]
        moving += [a[1] * u[2] - a[2] * u[1], a[2] * u[0] - a[0] * u[2], a[0] * u[1] - a[1] * u[0]]
    return [*zip(q, moving, strict=True), *zip(v, found, strict=True)]


def _symbols(name: str, count: int) -> list[Expression]:
    import heyoka as hy

    if not count:
        return []
    found = hy.make_vars(*(f"{name}_{k}" for k in range(count)))
    return [found] if count == 1 else list(found)
