"""What a case must return: the reference in 50 digits, for Jacobians its derivative along the case's direction."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mpmath import mp, mpf

from phichain.contract.function import Derivative
from phichain.contract.functions import ROWS
from phichain.emit.selftest.case import Case
from phichain.emit.selftest.states import by_shape, shaped
from phichain.ir.nodes import Program
from phichain.reference import reference
from phichain.reference.nudge import Nudge
from phichain.scene import Scene

_STEP_DIGITS = 24
_DIGITS = 50
#: What is below may be all that rounding left of a zero: so many more digits tell.
_DOUBTFUL = "1e-60"
_MORE_DIGITS = 40


def true_results(scene: Scene, program: Program, case: Case) -> dict[str, list[Any]]:
    """`exact_results` with zeros where fifty digits leave round-off alone: what more digits change as a whole."""
    results = exact_results(scene, program, case)
    if all(max(map(abs, values)) > mpf(_DOUBTFUL) for values in results.values()):
        return results
    better = exact_results(scene, program, case, digits=_DIGITS + _MORE_DIGITS)
    return {
        name: [x if 2 * abs(x - y) < abs(x) else mpf(0) for x, y in zip(values, better[name], strict=True)]
        for name, values in results.items()
    }


def exact_results(
    scene: Scene, program: Program, case: Case, nudge: Nudge | None = None, digits: int = _DIGITS
) -> dict[str, list[Any]]:
    """The reference's outputs as flat mpf by name, or the derivative under "slope"; with a nudge, those of the numbers moved."""
    row = ROWS[program.name]
    if row.derivative is not None:
        slope = {"slope": _slope(scene, row.derivative, case, nudge)}
        return slope | (_value(scene, program, row.derivative, case, nudge) if row.derivative.keeps else {})
    inputs = shaped(program.inputs, case.inputs)
    params = shaped(program.params, case.params)
    results = reference(scene, program.name, inputs, digits, params, nudge)
    names = row.outputs_in_reference(scene)
    return {a.name: _flat(results[names[a.name]]) for a in row.outputs_of(scene) if a.is_checked}


def _value(
    scene: Scene, program: Program, derivative: Derivative, case: Case, nudge: Nudge | None
) -> dict[str, list[Any]]:
    """The output that is differentiated, itself."""
    inputs, params = shaped(program.inputs, case.inputs), shaped(program.params, case.params)
    results = reference(scene, derivative.function, inputs, params=params, nudge=nudge)
    return {derivative.output: _flat(results[ROWS[derivative.function].outputs_in_reference(scene)[derivative.output]])}


def _slope(scene: Scene, derivative: Derivative, case: Case, nudge: Nudge | None) -> list[Any]:
    """The derivative of the reference along the direction, by a central difference in many digits."""
    output = ROWS[derivative.function].outputs_in_reference(scene)[derivative.output]
    params = by_shape(scene, case.params)
    with mp.workdps(90):
        step = mpf(10) ** -_STEP_DIGITS
        direction: Mapping[str, list[Any]] = case.direction
        if nudge is not None:
            direction = {name: nudge(f"{name} direction", along) for name, along in direction.items()}
        ends = [_moved(scene, derivative, case, direction, way * step, params, nudge)[output] for way in (1, -1)]
        return [(up - down) / (2 * step) for up, down in zip(*map(_flat, ends), strict=True)]


def _moved(
    scene: Scene, derivative: Derivative, case: Case, direction: Mapping[str, list[Any]], distance: Any,
    params: Mapping[str, Any], nudge: Nudge | None,
) -> dict[str, Any]:  # fmt: skip
    """The reference at a distance along the direction, in 80 digits."""
    inputs = {
        name: [mpf(x) + distance * d for x, d in zip(given, direction[name], strict=True)]
        for name, given in case.inputs.items()
    }
    arguments = {name: given[0] if name == "omega" else given for name, given in inputs.items()}
    return reference(scene, derivative.function, arguments, digits=80, params=params, nudge=nudge)


def _flat(value: Any) -> list[Any]:
    if isinstance(value, list):
        return [entry for part in value for entry in _flat(part)]
    return [value]
