"""How far a Program may be off: its own error in the scene's arithmetic, held against what the problem itself amplifies.

A tolerance measured on the Program that it judges says nothing when the Program is bad. So the error may be at most

    LIMIT max(1, kappa) epsilon,     kappa = max |f(x (1 +- d)) - f(x)| / (d max |f(x)|),

f the reference in 50 digits, x every input, parameter and constant of the scene, the signs drawn at random: what an ideal
function that rounds nothing but its arguments would suffer. Signs may happen to cancel, as those of two nearly equal angles in
the sine of their difference do; they are drawn anew until the error is explained. Beyond that, generation is refused.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from decimal import ROUND_CEILING, Context, Decimal
from math import inf, isfinite
from typing import Any, Final

from mpmath import mp, mpf

from phichain.emit.selftest.case import Case, columns
from phichain.emit.selftest.expected import exact_results
from phichain.errors import EmissionError
from phichain.ir.interpret import run
from phichain.ir.nodes import Program
from phichain.ir.rounded import EPSILON, arithmetic, nearest
from phichain.reference.nudge import SIZE_BITS, Nudge
from phichain.scene import Scene

#: The measured error times this, rounded up to one digit, is the tolerance; contraction and libm may differ that much.
MARGIN: Final = 16
#: Units of round-off that a Program may lose for each that the problem loses; no committed scene loses more than three.
LIMIT: Final = 16
#: Choices of signs that are tried before an error counts as unexplained: two cancel in one of two, 16 times in one of 65536.
_CHOICES: Final = 16


def tolerance(scene: Scene, program: Program, cases: Sequence[Case]) -> str:
    """A function's tolerance as a literal of the scene's type.

    Raises:
        EmissionError: the Program overflows, or loses more digits than the problem does.
    """
    epsilon = EPSILON[scene.real]
    worst = epsilon
    for case in cases:
        errors = measured(scene, program, case)
        if not all(map(isfinite, errors.values())):
            raise out_of_range(scene, program.name)
        if max(errors.values()) > LIMIT * epsilon:
            _check(scene, program, case, errors)
        worst = max(worst, *errors.values())
    return one_digit(scene, MARGIN * worst)


def _check(scene: Scene, program: Program, case: Case, errors: Mapping[str, float]) -> None:
    """Raise unless the problem's own amplification explains the errors."""
    kappa = dict.fromkeys(errors, 1.0)
    for some in amplifications(scene, program, case):
        kappa = {output: max(kappa[output], some[output]) for output in kappa}
        most = {output: LIMIT * kappa[output] * EPSILON[scene.real] for output in kappa}
        unexplained = [output for output, error in errors.items() if error > most[output]]
        if not unexplained:
            return
    output = unexplained[0]
    raise EmissionError(
        "target.real", scene.real,
        f"{program.name} is {errors[output]:.1e} off at moderate states, where the problem itself allows {most[output]:.1e}",
        _digits_remedy(scene), function=program.name, output=output, error=errors[output], most=most[output],
    )  # fmt: skip


def measured(scene: Scene, program: Program, case: Case) -> dict[str, float]:
    """The Program's error in the scene's arithmetic, max norm over max norm, by output; infinite where it overflows."""
    outputs = run(program, arithmetic(scene.real), {**case.params, **case.inputs})
    if case.direction:
        outputs = {**outputs, "slope": _applied(scene, program, case, outputs)}
    return {name: _distance(outputs[name], expected) for name, expected in case.expected.items()}


def amplifications(scene: Scene, program: Program, case: Case) -> Iterator[dict[str, float]]:
    """kappa above by output, for one choice of signs after the other."""
    still = exact_results(scene, program, case)
    for choice in range(_CHOICES):
        moved = exact_results(scene, program, case, Nudge(f"{program.name} {choice}"))
        yield {name: _moved(values, moved[name]) for name, values in still.items()}


def _moved(still: Sequence[Any], moved: Sequence[Any]) -> float:
    with mp.workdps(50):
        scale = max(map(abs, still))
        change = max(abs(a - b) for a, b in zip(still, moved, strict=True))
        return nearest("double", change / scale * mpf(2) ** SIZE_BITS) if scale else 0.0


def _applied(
    scene: Scene, program: Program, case: Case, outputs: Mapping[str, Sequence[float]]
) -> list[float]:
    """Jacobian times direction, summed as selftest.c does."""
    apply = arithmetic(scene.real).apply
    total = [0.0] * len(case.expected["slope"])
    for output, arguments in columns(program, case).items():
        along = [x for name in arguments for x in case.direction[name]]
        for i in range(len(total)):
            row = outputs[output][len(along) * i : len(along) * (i + 1)]
            for entry, step in zip(row, along, strict=True):
                total[i] = apply("add", (total[i], apply("mul", (entry, step), "")), "")
    return total


def _distance(found: Sequence[float], expected: Sequence[float]) -> float:
    if not all(map(isfinite, (*found, *expected))):
        return inf
    scale = max(abs(x) for x in expected)
    worst = max(abs(a - b) for a, b in zip(found, expected, strict=True))
    return worst / scale if scale else worst


def one_digit(scene: Scene, value: float) -> str:
    """A tolerance rounded up to one digit, as a literal of the scene's type."""
    digit, exponent = f"{Context(prec=1, rounding=ROUND_CEILING).plus(Decimal(value)):.0e}".lower().split("e")
    text = f"{digit}.0e{int(exponent)}"
    return f"{text}F" if scene.real == "float" else text


def out_of_range(scene: Scene, function: str) -> EmissionError:
    """The refusal of a scene whose numbers leave the range of its type."""
    problem = f"does not hold what {function} computes at moderate states"
    return EmissionError("target.real", scene.real, problem, _range_remedy(scene), function=function)


def _range_remedy(scene: Scene) -> str:
    """What helps when numbers leave the range of the scene's type."""
    alternative = 'set real = "double", or ' if scene.real == "float" else ""
    return f"{alternative}choose units that bring masses, lengths and stiffnesses nearer to 1"


def _digits_remedy(scene: Scene) -> str:
    """What helps when digits are lost."""
    alternative = 'set real = "double", or ' if scene.real == "float" else ""
    return f"{alternative}bring masses, and lengths and com, nearer to each other, or leave the function out of want"
