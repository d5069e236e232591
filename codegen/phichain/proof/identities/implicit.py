"""The linear solves of implicit steps: (I - g J) k = r, with J the derivative of the proven forward dynamics along k itself.

In the plane J is that of (v, a(q, v)). In space it is taken in the chart at the state (`spatial/chart.py`): coordinates (s, sigma) across
q_k, whose rates are P (omega x q) and P omega'. There dq = ds, domega = dsigma - q (omega . ds), and along k

    k_s - g P d(omega x q) = r_s,    k_sigma - g P d omega' = r_sigma.
"""

from __future__ import annotations

from dataclasses import replace

from phichain.proof.case import Case, Wrong, nothing, proves
from phichain.proof.modular.compiled import FAULTS
from phichain.proof.modular.field import Vector, cross, dot, plus

_FACTORS, _SOLUTION = "implicit_factors", "implicit_solution"


@proves(_SOLUTION, is_helper=True)
def implicit_solution(case: Case) -> None:
    """k of random right sides, by both Programs, solves the linear equations."""
    point, nv = case.point, case.scene.nv
    gain, (right_q, right_v) = point.free("gain", 1), (point.tangent("right_q"), point.tangent("right_v"))
    a = _forward(case)[0]
    factors = case.of(_FACTORS).run(point.given(gain=gain, a=a))
    found = case.run(point.given(gain=gain, right_q=right_q, right_v=right_v, **factors))
    k_q, k_v = found["k_q"], found["k_v"]
    turns = _turns(case, k_q, k_v)
    moved = dict(zip(("q", "v"), (k_q, turns), strict=True))
    rates = (k_v, _forward(case, moved)[1]) if case.scene.is_planar else _in_chart(case, k_q, turns, moved)
    for name, k, rate, right in (("k_q", k_q, rates[0], right_q), ("k_v", k_v, rates[1], right_v)):
        case.same(name, plus(k, rate, -gain[0]), right)
    assert len(k_q) == nv


@proves(_FACTORS, is_helper=True)
def implicit_factors(case: Case) -> None:
    """They are what the solution makes of them: proven with it."""
    implicit_solution(case.of(_SOLUTION))


def _forward(case: Case, moved: dict[str, Vector] | None = None) -> tuple[Vector, ...]:
    """Accelerations at the point, and their derivative along a direction."""
    try:
        return case.forward.slopes(replace(case.point.given(), along=moved or {}), case.point)["a"]
    except FAULTS as fault:
        raise Wrong(f"no accelerations, for {nothing(fault)}") from fault


def _turns(case: Case, shift: Vector, turn: Vector) -> Vector:
    """dv: in space domega = dsigma - q (omega . ds)."""
    if case.scene.is_planar:
        return turn
    carts, found = case.point.carts, turn[: case.point.carts]
    for k, link in enumerate(case.point.links):
        at = slice(carts + 3 * k, carts + 3 * k + 3)
        found = [*found, *plus(turn[at], link, -dot(case.point.v[at], shift[at]))]
    return found


def _in_chart(case: Case, shift: Vector, turns: Vector, moved: dict[str, Vector]) -> tuple[Vector, Vector]:
    """The derivatives of s' and sigma' along a direction."""
    carts, point, a = case.point.carts, case.point, _forward(case, moved)[1]
    rates, accelerations = turns[:carts], a[:carts]
    for k, link in enumerate(point.links):
        at = slice(carts + 3 * k, carts + 3 * k + 3)
        moving = plus(cross(turns[at], link), cross(point.v[at], shift[at]))
        rates = [*rates, *plus(moving, link, -dot(link, moving))]
        accelerations = [*accelerations, *plus(a[at], link, -dot(link, a[at]))]
    return rates, accelerations
