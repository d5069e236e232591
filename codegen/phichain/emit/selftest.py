"""selftest.c: inputs as hexadecimal floats, and results that come another way through the mathematics.

The expected values are those of the un-lowered Lagrangian in 50 digits (`mechanics.reference`), rounded once. Jacobians are
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

from phichain.errors import EmissionError
from phichain.mechanics.reference import reference
from phichain.program.interpret import Algebra, run
from phichain.program.lower import Lowered
from phichain.program.nodes import Array, Program
from phichain.scene import Scene

#: The measured error times this, rounded up to one digit, is the tolerance; contraction and libm may differ that much.
_MARGIN = 16
#: The quadrature behind phi's reference costs N^2 a node: longer chains go without a self-test of phi.
_LONGEST_PHI = 16
_STEP = Fraction(1, 10**24)
#: [s] A spatial step's stages leave the sphere by O(h^2), and the reference's do not.
_LONGEST_STEP = 2.0**-14
_JACOBIANS = {"state_jacobian": ("forward_dynamics", "a"), "phi_jacobian": ("phi", "out")}
#: The reference's names of outputs that the C calls otherwise.
_REFERENCE_NAMES = {
    "mass_matrix": ("M",), "coriolis": ("N",), "gravity_torque": ("G",), "positions": ("r",), "phi": ("phi",),
}  # fmt: skip


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
    tolerances: Mapping[str, str]


def make_selftest(scene: Scene, lowered: Lowered) -> Selftest:
    """Choose states, evaluate the reference, measure the Programs against it."""
    source = random.Random(scene.digest)
    count = 3 if scene.links <= 4 else 2 if scene.links <= 16 else 1
    cases: list[Case] = []
    tolerances: dict[str, str] = {}
    for name, program in lowered.wanted.items():
        if name in ("phi", "phi_jacobian") and scene.links > _LONGEST_PHI:
            continue
        mine = [_case(scene, program, source) for _ in range(count)]
        error = max(_error(scene, program, case) for case in mine)
        if not isfinite(error):
            problem = f"does not hold what {name} computes at moderate states"
            raise EmissionError("target.real", scene.real, problem, _range_remedy(scene), function=name)
        round_off = float(np.finfo(_kind(scene)).eps)
        tolerances[name] = _one_digit(scene, _MARGIN * max(error, round_off))
        cases += mine
    return Selftest(tuple(cases), tolerances)


def _range_remedy(scene: Scene) -> str:
    """What helps when numbers leave the range of the scene's type."""
    alternative = 'set real = "double", or ' if scene.real == "float" else ""
    return f"{alternative}choose units that bring masses, lengths and stiffnesses nearer to 1"


def _case(scene: Scene, program: Program, source: random.Random) -> Case:
    params = {array.name: _parameter(scene, array, source) for array in program.params}
    inputs = _inputs(scene, program, source)
    if "h" in inputs:
        inputs["h"] = [_step_length(scene, params, inputs)]
    direction: dict[str, list[float]] = {}
    if program.name in _JACOBIANS:
        direction = _direction(scene, program, inputs, source)
        slope = _reference_slope(scene, program.name, params, inputs, direction)
        return Case(program.name, params, inputs, direction, {"slope": slope})
    results = reference(scene, program.name, _named(program, inputs), params=_shaped(program.params, params))
    names = _REFERENCE_NAMES.get(program.name, tuple(array.name for array in program.outputs))
    expected = {
        array.name: _all_rounded(scene, _flat(results[name]))
        for array, name in zip(program.outputs, names, strict=True)
    }
    return Case(program.name, params, inputs, direction, expected)


def _all_rounded(scene: Scene, values: Sequence[Any]) -> list[float]:
    """The nearest numbers of the scene's type; what a zero has become in 50 digits is zero again."""
    least = max(map(abs, values)) * mp.mpf("1e-40")
    return [_rounded(scene, x) if abs(x) > least else 0.0 for x in values]


def _parameter(scene: Scene, array: Array, source: random.Random) -> list[float]:
    """Moderate values; com stays below length."""
    if array.name in ("com", "length"):
        low, high = (0.25, 0.5) if array.name == "com" else (0.5, 1.0)
        return [_rounded(scene, source.uniform(low, high)) for _ in range(array.size)]
    return [_rounded(scene, source.uniform(0.5, 2.0)) for _ in range(array.size)]


def _inputs(scene: Scene, program: Program, source: random.Random) -> dict[str, list[float]]:
    inputs = {}
    for array in program.inputs:
        draw: Callable[[], float] = lambda: source.uniform(-2.0, 2.0)
        if array.name == "s":
            draw = lambda: source.choice((-1.0, 1.0))
        elif array.name == "h":
            draw = lambda: _LONGEST_STEP
        elif array.name == "omega":
            draw = lambda: source.uniform(1.0, 4.0)
        inputs[array.name] = [_rounded(scene, draw()) for _ in range(array.size)]
    if not scene.is_planar and "q" in inputs:
        _on_sphere(scene, inputs)
    return inputs


def _step_length(scene: Scene, params: Mapping[str, list[float]], inputs: Mapping[str, list[float]]) -> float:
    """A step h [s], a power of two, well within the stability of RK4: h^2 |a| <= 2^-14 and h |a| <= 2^-5 max(1, |v|).

    Beyond it a light link's joint makes the step grow without bound, and its result says nothing about the code.
    """
    state = {name: inputs[name] for name in ("q", "v", "u") if name in inputs}
    acceleration = max(map(abs, reference(scene, "forward_dynamics", state, params=_by_shape(scene, params))["a"]))
    fastest = max(1.0, *map(abs, inputs["v"]))
    h = _LONGEST_STEP
    while h * h * acceleration > 2.0**-14 or h * acceleration > 2.0**-5 * fastest:
        h /= 2.0
    return h


def _on_sphere(scene: Scene, inputs: dict[str, list[float]]) -> None:
    """Unit vectors and tangent rates, each rounded once."""
    first = 2 if scene.has_cart else 0
    for start in range(first, scene.nq, 3):
        q = inputs["q"][start : start + 3]
        with mp.workdps(50):
            norm = mp.sqrt(mp.fsum(mp.mpf(x) ** 2 for x in q))
            unit = [mp.mpf(x) / norm for x in q]
        inputs["q"][start : start + 3] = [_rounded(scene, x) for x in unit]
        if "v" in inputs:
            omega = inputs["v"][start : start + 3]
            with mp.workdps(50):
                along = mp.fsum(a * b for a, b in zip(unit, omega, strict=True))
                omega = [_rounded(scene, w - along * x) for w, x in zip(omega, unit, strict=True)]
            inputs["v"][start : start + 3] = omega


def _direction(
    scene: Scene, program: Program, inputs: Mapping[str, list[float]], source: random.Random
) -> dict[str, list[float]]:
    """A random direction in the differentiated arguments, tangent to the sphere where q is on one."""
    moved = ("amplitude", "omega") if program.name == "phi_jacobian" else ("q", "v", "u")
    direction = {name: [source.uniform(-1.0, 1.0) for _ in inputs[name]] for name in moved if name in inputs}
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
    return {name: [_rounded(scene, x) for x in values] for name, values in direction.items()}


def _reference_slope(
    scene: Scene, name: str, params: Mapping[str, list[float]], inputs: Mapping[str, list[float]],
    direction: Mapping[str, list[float]],
) -> list[float]:  # fmt: skip
    """The derivative of the dense reference along the direction, by a central difference in many digits."""
    function, output = _JACOBIANS[name]
    values = {p: v for p, v in params.items()}
    ends = []
    with mp.workdps(90):
        for sign in (1, -1):
            moved = {
                key: [mp.mpf(x) + sign * _step() * mp.mpf(d) for x, d in zip(given, direction[key], strict=True)]
                for key, given in inputs.items()
            }
            arguments = {key: given[0] if key == "omega" else given for key, given in moved.items()}
            result = reference(scene, function, arguments, digits=80, params=_by_shape(scene, values))
            ends.append(_flat(result["phi" if output == "out" else "a"]))
        return [_rounded(scene, (up - down) / (2 * _step())) for up, down in zip(*ends, strict=True)]


def _step() -> Any:
    return mp.mpf(_STEP.numerator) / _STEP.denominator


def _by_shape(scene: Scene, values: Mapping[str, list[float]]) -> dict[str, Any]:
    return {name: given if scene.runtime_shapes[name] else given[0] for name, given in values.items()}


def _shaped(arrays: Sequence[Array], values: Mapping[str, list[float]]) -> dict[str, Any]:
    return {array.name: values[array.name] if array.shape else values[array.name][0] for array in arrays}


def _named(program: Program, inputs: Mapping[str, list[float]]) -> dict[str, Any]:
    return _shaped(program.inputs, inputs)


def _flat(value: Any) -> list[Any]:
    if isinstance(value, list):
        return [entry for part in value for entry in _flat(part)]
    return [value]


# --- measuring -------------------------------------------------------------------------------------------------------


def _error(scene: Scene, program: Program, case: Case) -> float:
    """The Program's error in the scene's arithmetic, max norm over max norm; sines correctly rounded, so reproducible."""
    kind = _kind(scene)
    arithmetic: dict[str, Callable[..., Any]] = {
        "add": lambda a, b: a + b, "sub": lambda a, b: a - b, "mul": lambda a, b: a * b, "div": lambda a, b: a / b,
        "neg": lambda a: -a, "sqrt": np.sqrt, "sin": lambda x: kind(float(mp.sin(float(x)))),
        "cos": lambda x: kind(float(mp.cos(float(x)))),
        **{f"besselj{n}": lambda x, n=n: kind(float(mp.besselj(n, float(x)))) for n in range(5)},
    }  # fmt: skip
    algebra = Algebra(lambda value: kind(float(value)), lambda operation, args, label: arithmetic[operation](*args))
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
    if program.name == "phi_jacobian":
        return {"out": ["amplitude", "omega"]}
    return {f"dad{name}": [name] for name in case.direction}


def _distance(found: Sequence[Any], expected: Sequence[float]) -> float:
    scale = max(abs(x) for x in expected)
    worst = max(abs(float(a) - b) for a, b in zip(found, expected, strict=True))
    return worst / scale if scale else worst


def _kind(scene: Scene) -> Any:
    return np.float32 if scene.real == "float" else np.float64


def _rounded(scene: Scene, value: Any) -> float:
    """The nearest number of the scene's type (a mpf is rounded once)."""
    number = float(value)
    if scene.real == "double":
        return number
    with np.errstate(over="ignore"):  # an infinite expectation makes an infinite error, which `make_selftest` refuses
        nearest = np.float32(number)
    if float(nearest) != number and isinstance(value, mp.mpf):
        # double rounding: decide between the two neighbours by the exact value
        other = np.nextafter(nearest, np.float32(np.inf if value > float(nearest) else -np.inf))
        nearest = min((nearest, other), key=lambda x: abs(mp.mpf(float(x)) - value))
    return float(nearest)


def _one_digit(scene: Scene, value: float) -> str:
    """A tolerance rounded up to one digit, as a literal of the scene's type."""
    exponent = floor(log10(value))
    text = f"{ceil(value / 10.0**exponent)}.0e{exponent}"
    return f"{text}f" if scene.real == "float" else text
