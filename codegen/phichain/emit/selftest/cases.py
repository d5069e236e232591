"""selftest.c: inputs as hexadecimal floats, and results that come another way through the mathematics.

The expected values are those of the un-lowered Lagrangian in 50 digits (`reference`), rounded once. Jacobians are
checked along one random direction, for which the reference differentiates the dense equations of motion numerically at
raised precision. Tolerances are measured: the Program's own error in the scene's arithmetic, with a margin.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import ceil, floor, isfinite, log10
from typing import Any

import numpy as np
from mpmath import mp

from phichain.contract.function import Derivative
from phichain.contract.functions import ROWS
from phichain.emit.selftest.flow import FlowCase, flow_cases
from phichain.emit.selftest.states import (
    by_shape,
    draw_inputs,
    draw_parameter,
    kind_of,
    rounded,
    shaped,
    step_length,
)
from phichain.errors import EmissionError
from phichain.ir.interpret import Algebra, run
from phichain.ir.nodes import Program
from phichain.lowering.lower import Lowered
from phichain.reference import reference
from phichain.scene import Scene

#: The measured error times this, rounded up to one digit, is the tolerance; contraction and libm may differ that much.
_MARGIN = 16
_STEP = Fraction(1, 10**24)


@dataclass(frozen=True)
class Case:
    """One call and what it must return.

    Attributes:
        function: the contract's name.
        params: values of the runtime parameters, by name.
        inputs: values of the inputs, by name.
        direction: for a Jacobian, the direction it is applied to, one part an argument.
        expected: values by output name; for a Jacobian under "slope".
    """

    function: str
    params: Mapping[str, list[float]]
    inputs: Mapping[str, list[float]]
    direction: Mapping[str, list[float]]
    expected: Mapping[str, list[float]]


@dataclass(frozen=True)
class Selftest:
    """All cases of a scene, and the tolerance of each function as a literal of the scene's type."""

    cases: tuple[Case, ...]
    motions: tuple[FlowCase, ...]
    tolerances: Mapping[str, str]


def make_selftest(scene: Scene, lowered: Lowered) -> Selftest:
    """Choose states, evaluate the reference, measure the Programs against it."""
    source = random.Random(scene.digest)
    count = 3 if scene.links <= 4 else 2 if scene.links <= 16 else 1
    cases: list[Case] = []
    tolerances: dict[str, str] = {}
    for name, program in lowered.wanted.items():
        if scene.links > (ROWS[name].longest_checked or scene.links):
            continue
        mine = [_case(scene, program, source) for _ in range(count)]
        error = max(_error(scene, program, case) for case in mine)
        if not isfinite(error):
            problem = f"does not hold what {name} computes at moderate states"
            raise EmissionError("target.real", scene.real, problem, _range_remedy(scene), function=name)
        round_off = float(np.finfo(kind_of(scene)).eps)
        tolerances[name] = _one_digit(scene, _MARGIN * max(error, round_off))
        cases += mine
    motions = flow_cases(scene, lowered)
    tolerances |= {motion.function: _one_digit(scene, motion.accepted) for motion in motions}
    return Selftest(tuple(cases), motions, tolerances)


def _range_remedy(scene: Scene) -> str:
    """What helps when numbers leave the range of the scene's type."""
    alternative = 'set real = "double", or ' if scene.real == "float" else ""
    return f"{alternative}choose units that bring masses, lengths and stiffnesses nearer to 1"


def _case(scene: Scene, program: Program, source: random.Random) -> Case:
    params = {array.name: draw_parameter(scene, array, source) for array in program.params}
    inputs = draw_inputs(scene, program.inputs, source)
    if "h" in inputs:
        inputs["h"] = [step_length(scene, params, inputs)]
    direction: dict[str, list[float]] = {}
    row = ROWS[program.name]
    if row.derivative is not None:
        direction = _direction(scene, row.derivative, inputs, source)
        slope = _reference_slope(scene, row.derivative, params, inputs, direction)
        return Case(program.name, params, inputs, direction, {"slope": slope})
    results = reference(scene, program.name, _named(program, inputs), params=shaped(program.params, params))
    names = row.outputs_in_reference(scene)
    expected = {
        argument.name: _all_rounded(scene, _flat(results[names[argument.name]]))
        for argument in row.outputs_of(scene)
        if argument.is_checked
    }
    return Case(program.name, params, inputs, direction, expected)


def _all_rounded(scene: Scene, values: Sequence[Any]) -> list[float]:
    """The nearest numbers of the scene's type; what a zero has become in 50 digits is zero again."""
    least = max(map(abs, values)) * mp.mpf("1e-40")
    return [rounded(scene, x) if abs(x) > least else 0.0 for x in values]


def _direction(
    scene: Scene, derivative: Derivative, inputs: Mapping[str, list[float]], source: random.Random
) -> dict[str, list[float]]:
    """A random direction in the differentiated arguments, tangent to the sphere where q is on one."""
    moved = [name for name in derivative.by if name in inputs]
    direction = {name: [source.uniform(-1.0, 1.0) for _ in inputs[name]] for name in moved}
    if not scene.is_planar:
        for start in range(2 if scene.has_cart else 0, scene.nq, 3):
            part = slice(start, start + 3)
            turn = direction["v"][part]
            direction["q"][part] = np.cross(turn, inputs["q"][part]).tolist()
            spin = np.cross(turn, inputs["v"][part]) + np.cross(direction["q"][part], inputs["v"][part])
            unit = np.array(inputs["q"][part])
            # q.omega = 0 must keep: dq.omega + q.domega = 0
            fault = np.dot(direction["q"][part], inputs["v"][part]) + np.dot(unit, spin)
            direction["v"][part] = (spin - fault * unit).tolist()
    return {name: [rounded(scene, x) for x in values] for name, values in direction.items()}


def _reference_slope(
    scene: Scene, derivative: Derivative, params: Mapping[str, list[float]], inputs: Mapping[str, list[float]],
    direction: Mapping[str, list[float]],
) -> list[float]:  # fmt: skip
    """The derivative of the dense reference along the direction, by a central difference in many digits."""
    function = derivative.function
    output = ROWS[function].outputs_in_reference(scene)[derivative.output]
    values = {p: v for p, v in params.items()}
    ends = []
    with mp.workdps(90):
        for sign in (1, -1):
            moved = {
                key: [
                    mp.mpf(x) + sign * _step() * mp.mpf(d) for x, d in zip(given, direction[key], strict=True)
                ]
                for key, given in inputs.items()
            }
            arguments = {key: given[0] if key == "omega" else given for key, given in moved.items()}
            result = reference(scene, function, arguments, digits=80, params=by_shape(scene, values))
            ends.append(_flat(result[output]))
        return [rounded(scene, (up - down) / (2 * _step())) for up, down in zip(*ends, strict=True)]


def _step() -> Any:
    return mp.mpf(_STEP.numerator) / _STEP.denominator


def _named(program: Program, inputs: Mapping[str, list[float]]) -> dict[str, Any]:
    return shaped(program.inputs, inputs)


def _flat(value: Any) -> list[Any]:
    if isinstance(value, list):
        return [entry for part in value for entry in _flat(part)]
    return [value]


# --- measuring -------------------------------------------------------------------------------------------------------


def _error(scene: Scene, program: Program, case: Case) -> float:
    """The Program's error in the scene's arithmetic, max norm over max norm; sines correctly rounded, so reproducible."""
    kind = kind_of(scene)
    arithmetic: dict[str, Callable[..., Any]] = {
        "add": lambda a, b: a + b, "sub": lambda a, b: a - b, "mul": lambda a, b: a * b, "div": lambda a, b: a / b,
        "neg": lambda a: -a, "sqrt": np.sqrt, "sin": lambda x: kind(float(mp.sin(float(x)))),
        "cos": lambda x: kind(float(mp.cos(float(x)))),
        **{f"besselj{n}": lambda x, n=n: kind(float(mp.besselj(n, float(x)))) for n in range(5)},
        "select": lambda a, b, x, y: x if a < b else y, "floor": np.floor,
    }  # fmt: skip
    algebra = Algebra(
        lambda value: kind(float(value)), lambda operation, args, label: arithmetic[operation](*args)
    )
    given = {name: [kind(x) for x in values] for name, values in {**case.params, **case.inputs}.items()}
    with np.errstate(all="ignore"):
        outputs = run(program, algebra, given)
    if case.direction:
        outputs = {"slope": _applied(program, case, outputs)}
    return max(_distance(outputs[name], expected) for name, expected in case.expected.items())


def _applied(program: Program, case: Case, outputs: Mapping[str, list[Any]]) -> list[float]:
    """Jacobian times direction."""
    total = np.zeros(len(case.expected["slope"]))
    for output, arguments in columns(program, case).items():
        along = np.array([x for name in arguments for x in case.direction[name]])
        total += np.array(outputs[output], dtype=float).reshape(len(total), -1) @ along
    return list(total)


def columns(program: Program, case: Case) -> dict[str, list[str]]:
    """Which arguments' directions meet the columns of each output of a Jacobian."""
    outputs, moved = [array.name for array in program.outputs], list(case.direction)
    if len(outputs) == 1:
        return {outputs[0]: moved}
    return {output: [name] for output, name in zip(outputs, moved, strict=True)}


def _distance(found: Sequence[Any], expected: Sequence[float]) -> float:
    scale = max(abs(x) for x in expected)
    worst = max(abs(float(a) - b) for a, b in zip(found, expected, strict=True))
    return worst / scale if scale else worst


def _one_digit(scene: Scene, value: float) -> str:
    """A tolerance rounded up to one digit, as a literal of the scene's type."""
    exponent = floor(log10(value))
    text = f"{ceil(value / 10.0**exponent)}.0e{exponent}"
    return f"{text}f" if scene.real == "float" else text
