"""Steps over time: the classical Runge-Kutta step against its formula, with the proven forward dynamics at its stages.

A stage's angle is the sum of the angle at the start and of h times a rate, whose sine is an element of its own for every value; in space
stages leave the manifold, and the roots at the end are elements of their own. So the step is compared as a formula in what it calls.
"""

from __future__ import annotations

from collections.abc import Sequence

from phichain.proof.case import Case, Wrong, nothing, proves
from phichain.proof.lagrange import triples
from phichain.proof.modular.compiled import FAULTS, Circle, Given
from phichain.proof.modular.field import HALF, PRIME, Vector, dot, inverse, plus


@proves("step")
def step(case: Case) -> None:
    """k_1 = f(x), k_2 = f(x + h/2 k_1), k_3 = f(x + h/2 k_2), k_4 = f(x + h k_3), x + h/6 (k_1 + 2 k_2 + 2 k_3 + k_4)."""
    point = case.point
    h = point.free("h", 1)[0]
    found = case.run(point.given(h=[h]))
    rates: list[tuple[Vector, Vector]] = []
    for ahead in (0, h * HALF % PRIME, h * HALF % PRIME, h):
        moved = [[ahead * entry % PRIME for entry in rate] for rate in rates[-1]] if rates else [[0] * case.scene.nv] * 2
        rates.append(_slope(case, plus(point.q, moved[0]), plus(point.v, moved[1]), moved[0]))
    ends = []
    for start, part in ((point.q, 0), (point.v, 1)):
        total = [k1 + 2 * (k2 + k3) + k4 for k1, k2, k3, k4 in zip(*(rate[part] for rate in rates), strict=True)]
        ends.append(plus(start, total, h * inverse(6)))
    q, v = ends if case.scene.is_planar else _projected(case, *ends)
    case.same("q_next", found["q_next"], q)
    case.same("v_next", found["v_next"], v)


def _slope(case: Case, q: Vector, v: Vector, moved: Sequence[int]) -> tuple[Vector, Vector]:
    """(q', v') at a stage, whose angles have moved from those of the point."""
    point, carts = case.point, case.point.carts
    circles = {"q": [_turned(start, point.atom(by)) for start, by in zip(point.circles, moved, strict=True)]}
    values = point.parameters | {"q": q, "v": v, "u": point.u}
    try:
        a = case.forward.values(Given(values, circles if case.scene.is_planar else {}), point)["a"][0]
    except FAULTS as fault:
        raise Wrong(f"no stage, for {nothing(fault)}") from fault
    return (v if case.scene.is_planar else [*v[:carts], *triples(q, v, carts)]), a


def _turned(a: Circle, b: Circle) -> Circle:
    return (a[0] * b[0] - a[1] * b[1]) % PRIME, (a[1] * b[0] + a[0] * b[1]) % PRIME


def _projected(case: Case, q: Vector, v: Vector) -> tuple[Vector, Vector]:
    """Unit vectors made unit, by the same element for the same root, and rates made tangent."""
    carts = case.point.carts
    units, turns = q[:carts], v[:carts]
    for k in range(carts, len(q), 3):
        link, turn = q[k : k + 3], v[k : k + 3]
        scale = inverse(case.point.root(dot(link, link)))
        unit = [scale * entry % PRIME for entry in link]
        units, turns = [*units, *unit], [*turns, *plus(turn, unit, -dot(unit, turn))]
    return units, turns
