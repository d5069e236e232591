"""What a compiled problem offers: whole iterations on it in one call, and the records that these are asked and answered in."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from phichain.system import Vector

Told = dict[str, Any]
"""What a compiled problem tells of a solution: the fields of a `correctors.Correction`."""


class Stepped(NamedTuple):
    """A step of a compiled problem.

    Attributes:
        told: Where it led.
        moved: How far, in arclength's chord.
        shifted: How far Newton moved the guess.
        turned: Cosine of the tangents' angle.
        changed: Size of [J; t]^-1 dJ.
        change: [J; t]^-1 [J'; t], asked for where that is not small.
    """

    told: Told
    moved: float
    shifted: float
    turned: float
    changed: float
    change: Callable[[], Vector]


class Watch(NamedTuple):
    """A test function as a compiled problem takes it.

    Attributes:
        what: Its name there; empty where it has none.
        which: Which one of these.
        less: What is taken off.
        dips: 1 where it may come to zero and leave it again within a step, 2 where it is a component of the tangent, which is known better; else 0.
        passes: Whether a run goes on beyond a zero, which is smooth, so that nobody has to look at it.
    """

    what: str
    which: int
    less: float
    dips: int
    passes: bool = False


class Seen(NamedTuple):
    """What a run knows of the last places that it comes from, one entry each, the newest last.

    Attributes:
        places: Them, and the tangents there.
        at: Arclengths.
        sigmas: The smallest singular values of [J; t].
        values: The test functions there; of the last ones alone that are on the same branch.
        zeros: Zeros of test functions in the last step: which one's, and at what arclength.
    """

    places: Sequence[tuple[Vector, Vector]]
    at: Sequence[float]
    sigmas: Sequence[float]
    values: Sequence[Sequence[float]]
    zeros: Sequence[tuple[int, float]] = ()


class Met(NamedTuple):
    """A zero of a test function that a run passed.

    Attributes:
        test: Which one's.
        y: The unknowns there (n + 1,), scaled.
        arclength: s there.
        value: What is left of the function.
        multipliers: Those of the solution there.
    """

    test: int
    y: Vector
    arclength: float
    value: float
    multipliers: NDArray[np.complex128]


class Step(NamedTuple):
    """A step of a run.

    Attributes:
        point: Where it led, a `Point`.
        step: The step to try behind it.
        values: The test functions there; None where it has none.
        met: The zeros before it that the run passed.
    """

    point: Any
    step: float
    values: tuple[float, ...] | None
    met: Sequence[Met]


class Ran(NamedTuple):
    """A run.

    Attributes:
        steps: Its steps.
        stopped: Why there are no more: "on" where there may be, "met" where the last one is to be looked at, "sign" where det [J; t] has another sign there
            besides, "small" where a smaller step than allowed would be needed, "interrupted" by Ctrl-C.
        tried: The step that was tried last.
        is_doubtful: Whether more zeros than signs show may lie before the last step but one.
    """

    steps: list[Step]
    stopped: str
    tried: float
    is_doubtful: bool


class Compiled(Protocol):
    """What a problem may have compiled: whole iterations in one call, where the numerics of a few rows cost more in Python than the problem itself."""

    def at(self, y: Vector, along: Vector) -> Told | None:
        """The problem at y (n + 1,), whether it is solved there or not, the tangent turned towards `along`; None where it is no numbers."""
        ...

    def settled(self, y: Vector, along: Vector) -> Told | None:
        """The same of what nearly solves it, freed of what Newton still finds to be wrong with it."""
        ...

    def corrected(self, guess: Vector, normal: Vector, tol: float, trust: float, most: int) -> Told:
        """`correctors.pseudo_arclength`."""
        ...

    def touched(self, known: Sequence[tuple[Vector, Vector]], axis: Vector, place: float) -> Vector | None:
        """`osculating.osculating`, of places with their tangents."""
        ...

    def ahead(self, known: Sequence[tuple[Vector, Vector]], jacobian: Vector, step: float, tol: float, most: int) -> Stepped:
        """A step from the last of some places with their tangents, whose Jacobian is given: `predictors.osculating` and `pseudo_arclength`."""
        ...

    def watches(self, tests: Sequence[Watch]) -> bool:
        """Whether a run can watch so many test functions, all that have names being its own."""
        ...

    def run(
        self, seen: Seen, jacobian: Vector, step: float, most: int, options: Any, start: tuple[int, Vector, Vector], tests: Sequence[Watch]
    ) -> Ran:
        """Steps from the last of some places, whose Jacobian is given, as `steps.advance` takes them; so many at most, or up to one that is to be looked at.

        Args:
            seen: The places.
            jacobian: dF/dy at the last one.
            step: The step to try.
            most: How many.
            options: Those of the run.
            start: Points on this branch, the first of them, and its tangent.
            tests: Test functions.

        Returns:
            What it reached and met.
        """
        ...

    def zero(
        self, line: Sequence[tuple[float, Vector, Vector]], values: tuple[float, float], beyond: Sequence[tuple[float, float]], test: Watch,
        options: Any, near: tuple[float, float, bool, float], shape: tuple[float, float, Vector] | None = None,
    ) -> tuple[list[tuple[Told, float, bool]], int, int, float] | None:  # fmt: skip
        """The zero of a test function between two places, as `met.roots.zero_between` finds it along `met.between.Between`.

        Args:
            line: Arclengths, places and tangents: of the two ends first, and then of all that is known of the curve, in order.
            values: The test function at the ends.
            beyond: Arclengths outside, and its values there.
            test: The test function.
            options: Those of Newton's iteration.
            near: How far off the zero may be; how far from a place that is known; whether that is to have the Jacobian of its own place; and |sigma|
                of [J; t] below which no other place is guessed from one.
            shape: Centre and half width of a neighbourhood in which the curve is a polynomial over (s - centre) / half width, and its coefficients,
                the constant ones first.

        Returns:
            What was found on the way: the fields of a `Point`, the function there, and whether Newton got there; which one is the
            nearest to the zero; which one is nearest to that, -2 for the first end and -1 for the last; and the zero's arclength. None where it was not found so.
        """
        ...

    def places(self, line: Sequence[tuple[float, Vector, Vector]], at: Vector, options: Any) -> Vector | None:
        """Where the curve has eight arclengths between two places, `line` as of `zero`, and nothing else there (8, n + 1); None where Newton did not get to all."""
        ...
