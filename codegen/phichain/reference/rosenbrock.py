"""Reference of the Rosenbrock step: dense, its Jacobian from differences at raised precision.

In space the step lives in the chart of the tangent planes at its start: z = (s, sigma) with q = s + sqrt(1 - |s|^2) q_0 and
omega = sigma - q_0 (sigma . q) / (q_0 . q). Neither the Jacobian nor the solves know that the chain is a chain.
"""

from __future__ import annotations

from typing import Any

from mpmath import fdot, mp, mpf

from phichain.contract.rodas5p import GAMMA, STAGES, A, C, M
from phichain.reference.algebra import Matrix, Vector, cross, moved, solve, transposed, unit
from phichain.reference.case import Case, Outputs, judges
from phichain.reference.motion import forward_dynamics
from phichain.reference.pose import cart_axes, project


@judges("step_rosenbrock")
def step_rosenbrock(case: Case) -> Outputs:
    """One step of Rodas5P and the difference to its embedded method, u held."""
    size, h = case.scene.nv, case.inputs["h"]
    q, v = case.inputs["q"], case.inputs["v"]
    if not case.scene.is_planar:
        q, v = project(case.scene, q, v)
        case = case.at(q=q, v=v)
    gain = h * _exact(GAMMA)
    slope = _jacobian(case)
    matrix = [[(1 if i == j else 0) - gain * slope[i][j] for j in range(2 * size)] for i in range(2 * size)]
    inverse = transposed(solve(matrix, [unit(2 * size, i) for i in range(2 * size)]))
    stages: list[Vector] = []
    for weights, couplings in zip(A, C, strict=True):
        field = _field(case, _sum(weights, stages, 2 * size))
        right = moved([h * entry for entry in field], _sum(couplings, stages, 2 * size), mpf(1))
        stages.append([_exact(GAMMA) * fdot(row, right) for row in inverse])
    assert len(stages) == STAGES
    q_next, v_next = _state(case, _sum(M, stages, 2 * size))
    error = stages[-1]
    return {"q_next": q_next, "v_next": v_next, "q_error": error[:size], "v_error": error[size:]}


def _exact(value: Any) -> Any:
    return mpf(value.numerator) / value.denominator


def _sum(weights: tuple[Any, ...], stages: list[Vector], size: int) -> Vector:
    total: Vector = [mpf(0)] * size
    for weight, stage in zip(weights, stages, strict=True):
        total = moved(total, stage, _exact(weight))
    return total


def _jacobian(case: Case) -> Matrix:
    """The derivative of the field at the start of the step, column by column."""
    size = 2 * case.scene.nv
    width = mp.prec // 2 + 10
    h = mpf(2) ** -width
    with mp.workprec(mp.prec + width + 10):
        columns = []
        for i in range(size):
            ahead, behind = (_field(case, [sign * h * entry for entry in unit(size, i)]) for sign in (1, -1))
            columns.append([(a - b) / (2 * h) for a, b in zip(ahead, behind, strict=True)])
        return transposed(columns)


def _state(case: Case, z: Vector) -> tuple[Vector, Vector]:
    """(q, v) at the coordinates z."""
    size = case.scene.nv
    q, v = moved(case.inputs["q"], z[:size], mpf(1)), moved(case.inputs["v"], z[size:], mpf(1))
    if case.scene.is_planar:
        return q, v
    for k in range(cart_axes(case.scene), size, 3):
        here = case.inputs["q"][k : k + 3]
        aside, turning = _across(here, z[k : k + 3]), _across(here, z[size + k : size + k + 3])
        q[k : k + 3] = moved(aside, here, mp.sqrt(1 - fdot(aside, aside)))
        rate = moved(case.inputs["v"][k : k + 3], turning, mpf(1))
        v[k : k + 3] = moved(rate, here, -fdot(rate, q[k : k + 3]) / fdot(here, q[k : k + 3]))
    return q, v


def _field(case: Case, z: Vector) -> Vector:
    """z' at the coordinates z."""
    q, v = _state(case, z)
    a = forward_dynamics(case.at(q=q, v=v))["a"]
    if case.scene.is_planar:
        return [*v, *a]
    carts = cart_axes(case.scene)
    shift, turn = v[:carts], a[:carts]
    for k in range(carts, len(q), 3):
        here = case.inputs["q"][k : k + 3]
        shift = shift + _across(here, cross(v[k : k + 3], q[k : k + 3]))
        turn = turn + _across(here, a[k : k + 3])
    return [*shift, *turn]


def _across(here: Vector, vector: Vector) -> Vector:
    """vector less its part along the unit vector `here`."""
    return moved(vector, here, -fdot(here, vector))
