"""selftest.c: inputs as hexadecimal floats, and results that come another way through the mathematics.

The expected values are those of the un-lowered Lagrangian in 50 digits (`reference`), rounded once. Jacobians are
checked along one random direction, for which the reference differentiates the equations of motion numerically at
raised precision. Tolerances are measured: the Program's own error in the scene's arithmetic, with a margin, refused where it
is more than the problem's conditioning allows (`tolerance`). Nothing here depends on the processor.
"""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from mpmath import mp

from phichain.contract.function import Derivative
from phichain.contract.functions import ROWS
from phichain.emit.selftest.case import Case
from phichain.emit.selftest.expected import true_results
from phichain.emit.selftest.flow import FlowCase, flow_cases
from phichain.emit.selftest.states import draw_inputs, draw_parameter, rounded, slowed, step_length
from phichain.emit.selftest.tolerance import one_digit, out_of_range, tolerance
from phichain.ir.nodes import Program
from phichain.lowering.lower import Lowered
from phichain.lowering.preparation import preparation
from phichain.reference.algebra import cross
from phichain.scene import Scene


@dataclass(frozen=True)
class Selftest:
    """All cases of a scene, and the tolerance of each function as a literal of the scene's type.

    Attributes:
        cases: calls of functions.
        motions: runs of flows.
        tolerances: by function.
        prepared: calls of NAME_forward_dynamics_prepared, in terms of the forward dynamics.
    """

    cases: tuple[Case, ...]
    motions: tuple[FlowCase, ...]
    tolerances: Mapping[str, str]
    prepared: tuple[Case, ...] = ()


def make_selftest(scene: Scene, lowered: Lowered) -> Selftest:
    """Choose states, evaluate the reference, measure the Programs against it.

    Raises:
        EmissionError: a Program overflows at moderate states, or loses more digits than its problem does.
    """
    source = random.Random(scene.digest)
    count = 3 if scene.links <= 4 else 2 if scene.links <= 16 else 1
    cases: list[Case] = []
    tolerances: dict[str, str] = {}
    for name, program in lowered.wanted.items():
        if scene.links > (ROWS[name].longest_checked or scene.links):
            continue
        mine = [_case(scene, program, source) for _ in range(count)]
        tolerances[name] = tolerance(scene, program, mine)
        cases += mine
    prepared: list[Case] = []
    if "prepare" in scene.want:
        program = preparation(lowered.model).whole
        prepared = [_case(scene, program, source) for _ in range(count)]
        tolerances["forward_dynamics_prepared"] = tolerance(scene, program, prepared)
    motions = flow_cases(scene, lowered)
    tolerances |= {motion.function: one_digit(scene, motion.accepted) for motion in motions}
    return Selftest(tuple(cases), motions, tolerances, tuple(prepared))


def _case(scene: Scene, program: Program, source: random.Random) -> Case:
    params = {array.name: draw_parameter(scene, array, source) for array in program.params}
    inputs = slowed(scene, draw_inputs(scene, program.inputs, source), source)
    if "h" in inputs:
        inputs["h"] = [rounded(scene, step_length(scene, params, inputs, program.name == "step_jacobian"))]
        if not inputs["h"][0]:
            raise out_of_range(scene, program.name)
    derivative = ROWS[program.name].derivative
    direction = {} if derivative is None else _direction(scene, derivative, inputs, source)
    case = Case(program.name, params, inputs, direction, {})
    results = true_results(scene, program, case)
    return replace(case, expected={name: _all_rounded(scene, values) for name, values in results.items()})


def _all_rounded(scene: Scene, values: Sequence[Any]) -> list[float]:
    """The nearest numbers of the scene's type; what a zero has become in 50 digits is zero again."""
    least = max(map(abs, values)) * mp.mpf("1e-40")
    return [rounded(scene, x) if abs(x) > least else 0.0 for x in values]


def _direction(
    scene: Scene, derivative: Derivative, inputs: Mapping[str, list[float]], source: random.Random
) -> dict[str, list[float]]:
    """A random direction in the differentiated arguments, tangent to the sphere where q is on one."""
    moved = [name for name in derivative.by if name in inputs]
    direction: dict[str, list[Any]] = {
        name: [Fraction(source.uniform(-1.0, 1.0)) for _ in inputs[name]] for name in moved
    }
    if not scene.is_planar:
        for start in range(2 if scene.has_cart else 0, scene.nq, 3):
            part = slice(start, start + 3)
            q, omega = (list(map(Fraction, inputs[name][part])) for name in ("q", "v"))
            direction["q"][part], direction["v"][part] = _tangent(q, omega, direction["v"][part])
    return {name: [rounded(scene, x) for x in values] for name, values in direction.items()}


def _tangent(
    q: Sequence[Fraction], omega: Sequence[Fraction], turn: Sequence[Fraction]
) -> tuple[list[Fraction], list[Fraction]]:
    """The change of a link and of its rate when both turn and q.omega = 0 is kept: dq.omega + q.domega = 0."""
    change = cross(turn, q)
    spin = [a + b for a, b in zip(cross(turn, omega), cross(change, omega), strict=True)]
    fault = _dot(change, omega) + _dot(q, spin)
    return change, [a - fault * b for a, b in zip(spin, q, strict=True)]


def _dot(a: Sequence[Fraction], b: Sequence[Fraction]) -> Fraction:
    return sum((x * y for x, y in zip(a, b, strict=True)), Fraction(0))
