"""Brake orbits in the compiled object: Newton's iteration over a quarter period of the Taylor flow, in one call.

The stencils are those of `stencils/orbits`, compiled beside a generated folder's own C and never written into it. They compute on a
desk of numbers, whose fields `desk` says.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any
from weakref import finalize

from phichain.contract.chain import Chain
from phichain.errors import ArrayError
from phichain.native.flows.desk import (
    KNOWN,
    LINE,
    OUTSIDE,
    STOPPED,
    WATCHED,
    WHAT,
    ZEROS,
    Array,
    Table,
)
from phichain.native.flows.told import Ahead, Event, Found, Reached, Run, Zero


def has_brake(chain: Chain) -> bool:
    """Whether the stencils serve a chain."""
    return chain.is_planar and chain.real == "double" and bool(chain.variational)


@dataclass(frozen=True)
class Braking:
    """The foreign functions.

    Attributes:
        at: The orbit at a guess.
        settled: The same, freed of what Newton still finds.
        corrected: The orbit that Newton finds from it.
        ahead: The next orbit.
        run: The next orbits.
        zero: The orbit at which a test function vanishes.
        places: Places of the curve.
        touched: A guess, by the orbits that are known.
    """

    at: Callable[..., int]
    settled: Callable[..., int]
    corrected: Callable[..., int]
    ahead: Callable[..., int]
    run: Callable[..., int]
    zero: Callable[..., int]
    places: Callable[..., int]
    touched: Callable[..., int]


class Brake:
    """Brake orbits of one chain with its parameters; one thread at a time, `another` for the next.

    Attributes:
        desk: The numbers that C computes on, by name, all of them views.
        asked: How many evaluations the last call took, which `desk["asked"]` tells.
    """

    def __init__(
        self, functions: Braking, take: Callable[[], Table], scale: Array, tolerance: float, rough: float, most_steps: int,
        give: Callable[[Table], None] | None = None,
    ) -> None:  # fmt: skip
        """Take a table, and a problem's sizes.

        Args:
            functions: The foreign functions.
            take: Makes a table, or finds one that nobody has.
            scale: Sizes of the unknowns (nq + 1,).
            tolerance: Tolerance of the flow.
            rough: The same far from an orbit.
            most_steps: Budget of its steps.
            give: Takes the table back when nobody has this any more.
        """
        self._given = functions, take, scale, tolerance, rough, most_steps, give
        self._functions, table = functions, take()
        if give is not None:
            finalize(self, give, table).atexit = False
        self._table, self.desk, self._fields, self._event_fields = table, table.desk, table.orbit, table.event
        table.memory.fill(0)
        self.desk["scale"][:] = scale
        for name, value in (("tolerance", tolerance), ("rough", rough), ("most_steps", most_steps)):
            self.desk[name].fill(value)
        self._orbit, self._guess, self._normal, self._before_jacobian, self._before_tangent, self._axis = (
            self.desk[name] for name in ("orbit", "guess", "normal", "before_jacobian", "before_tangent", "axis")
        )
        self._newton, self._where, self._ahead, self._stride, self._near = table.parts
        self._rows, self._line = table.rows
        self._counts = self.desk["line_count"], self.desk["outside_count"]
        self._desk, self._arguments = table.at, (*table.bound.context, table.at)

    def another(self) -> Brake:
        """The same on memory of its own, the flow's included."""
        return Brake(*self._given)

    @property
    def asked(self) -> list[list[float]]:
        """Evaluations of the last call: q_0, omega, the flow's tolerance, and how many columns were carried."""
        return self.desk["asked"][: int(self.desk["evaluations"])].tolist()

    def at(self, y: Array, along: Array | None = None) -> Found | None:
        """The orbit at y (nq + 1,), scaled, whether it closes or not, its tangent along a direction; None where the chain cannot be followed."""
        self._guess[:], self._normal[:] = y, 0 if along is None else along
        return Found(self._orbit.copy(), self._fields) if self._functions.at(*self._arguments) else None

    def settled(self, y: Array, along: Array) -> Found | None:
        """The same, freed of what Newton still finds to be wrong with it."""
        self._guess[:], self._normal[:] = y, along
        return Found(self._orbit.copy(), self._fields) if self._functions.settled(*self._arguments) else None

    def corrected(self, guess: Array, normal: Array, tol: float, trust: float, most: int) -> Found:
        """Newton from a guess (nq + 1,) in the plane across a normal, to a correction below tol or trust, with so many at most."""
        self._guess[:], self._normal[:] = guess, normal
        self._newton[:] = tol, trust, most
        self._functions.corrected(*self._arguments)
        return Found(self._orbit.copy(), self._fields)

    def ahead(self, known: Sequence[tuple[Array, Array]], jacobian: Array, step: float, tol: float, most: int) -> tuple[Found, Ahead]:
        """The orbit a step ahead of the last of those with tangents that are known, whose Jacobian (nq, nq + 1) is given, too.

        Raises:
            ArrayError: More than `KNOWN` are.
        """
        self._know(known)
        self._before_jacobian[:], self._before_tangent[:] = jacobian, known[-1][1]
        self._newton[:] = tol, 0.0, most
        self._where[:] = len(known), step
        self._functions.ahead(*self._arguments)
        return Found(self._orbit.copy(), self._fields), Ahead(*self._ahead.tolist())

    @staticmethod
    def watches(tests: Sequence[Any]) -> bool:
        """Whether a run can watch so many test functions (`continuation.compiled.protocol.Watch`), and knows all of them that have names."""
        return len(tests) <= WATCHED and all(test.what in WHAT for test in tests if test.what)

    def run(
        self, seen: Any, jacobian: Array, step: float, most: int, limits: Sequence[float], newton: tuple[float, float, int],
        start: tuple[int, Array, Array], tests: Sequence[Any],
    ) -> Run:  # fmt: skip
        """The next orbits behind the last one that is seen, whose Jacobian is given: so many at most, or up to one that somebody has to look at.

        Args:
            seen: The last places with their tangents, arclengths and sigmas; the test functions at the last ones of them, and their zeros in the last step (`continuation.compiled.protocol.Seen`).
            jacobian: At the last one (nq, nq + 1).
            step: The step to try.
            most: How many orbits.
            limits: step_min, step_max, max_angle, aim_angle and max_change of `continuation.options`.
            newton: Newton's tolerance, the corrections that it trusts, and how many.
            start: Orbits since the run's start, that, and its tangent.
            tests: Test functions.

        Returns:
            What it reached and met.

        Raises:
            ArrayError: More than `KNOWN` places are given, or more than `ZEROS` zeros.
        """
        desk, count = self.desk, len(seen.places)
        if len(seen.zeros) > ZEROS:
            raise ArrayError("seen.zeros", len(seen.zeros), f"must be at most {ZEROS}", "go on one by one")
        self._know(seen.places)
        self._before_jacobian[:], self._before_tangent[:] = jacobian, seen.places[-1][1]
        self._newton[:] = newton
        self._where[:] = count, step
        self._stride[:] = step, *limits, most, start[0]
        desk["start"][0], desk["start"][1] = start[1:]
        desk["watched"].fill(len(tests))
        desk["watch"][: len(tests)] = [_watched(test) for test in tests]
        desk["seen"].fill(len(seen.values))
        desk["at"][:count], desk["sigmas"][:count] = seen.at, seen.sigmas
        desk["values"][count - len(seen.values) : count, : len(tests)] = seen.values
        desk["zero_count"].fill(len(seen.zeros))
        if seen.zeros:
            desk["zeros"][: len(seen.zeros)] = seen.zeros
        desk["stopped"].fill(0)
        is_cut = False
        try:
            self._functions.run(*self._arguments)
        except KeyboardInterrupt:
            is_cut = True
        taken = int(desk["taken"])
        events = [Event.of(row, self._event_fields) for row in desk["events"][: int(desk["met"])].copy()]
        # Those before an orbit that was not reached are found again.
        events = [event for event in events if event.before < taken]
        told = self._reached("rows", taken, len(tests))
        stopped = "interrupted" if is_cut else STOPPED[int(desk["stopped"])]
        return Run(told, events, stopped, float(desk["step"]), is_cut or bool(desk["doubtful"] > 0))

    def zero(
        self, line: Sequence[tuple[float, Array, Array]], values: tuple[float, float], beyond: Sequence[tuple[float, float]],
        test: Any, newton: tuple[float, float, int], near: tuple[float, float, bool, float], shape: tuple[float, float, Array] | None = None,
    ) -> Zero | None:  # fmt: skip
        """The zero of a test function between two orbits.

        Args:
            line: Arclengths, places and tangents: of the two ends first, and then of all that is known of the curve, in order.
            values: The test function at the ends.
            beyond: Arclengths outside, and its values there.
            test: The test function.
            newton: Newton's tolerance, the corrections that it trusts, and how many.
            near: How far off the zero may be; how far from an orbit that is told; whether that is to have the columns of its own place; and |sigma| of [J; t] below which no other is guessed from an orbit.
            shape: Centre and half width of a neighbourhood in which the curve is a polynomial, and its coefficients (`SHAPE`, nq + 1), the constant ones first.

        Returns:
            None where it was not found so.
        """
        desk, outside = self.desk, beyond[-OUTSIDE:]
        if not self._lie(line):
            return None
        desk["shape_half"].fill(0 if shape is None else shape[1])
        if shape is not None:
            desk["shape_centre"].fill(shape[0])
            desk["shape"][:] = shape[2]
        self._newton[:], desk["watch"][0] = newton, _watched(test)
        desk["line_values"][:] = values
        self._near[:] = near
        self._counts[1].fill(len(outside))
        if outside:
            desk["outside"][: len(outside)] = outside
        if not self._functions.zero(*self._arguments):
            return None
        return Zero(self._reached("tries", int(desk["tried"]), 1), int(desk["taken"]), int(desk["stopped"]), float(desk["place"]))

    def places(self, line: Sequence[tuple[float, Array, Array]], at: Array, newton: tuple[float, float, int]) -> Array | None:
        """Where the curve between two orbits has some arclengths (`SHAPE`, nq + 1); `line` and `newton` as of `zero`; None where Newton did not get to all."""
        told = self.desk["placed"]
        if not self._lie(line):
            return None
        self._newton[:], told[:, 0] = newton, at
        return told[:, 1:].copy() if self._functions.places(*self._arguments) else None

    def _lie(self, line: Sequence[tuple[float, Array, Array]]) -> bool:
        """Put a line on the desk, where there is room for it."""
        if len(line) > LINE:
            return False
        at, places = self.desk["line_at"], self._line
        for k, (s, y, tangent) in enumerate(line):
            at[k], places[k][0][:], places[k][1][:] = s, y, tangent
        self._counts[0].fill(len(line))
        return True

    def _reached(self, where: str, count: int, tests: int) -> Reached:
        return Reached(self.desk[where][:count].copy(), self._fields, tests)

    def _know(self, known: Sequence[tuple[Array, Array]]) -> None:
        if len(known) > KNOWN:
            raise ArrayError("known", len(known), f"must be at most {KNOWN} places", "give those that are nearest")
        for (at, along), (y, tangent) in zip(self._rows, known, strict=False):
            at[:], along[:] = y, tangent

    @property
    def change(self) -> Array:
        """[J; t]^-1 [J'; t] of the last step, t its first tangent (nq + 1, nq + 1)."""
        return self.desk["change"].copy()

    def touched(self, known: Sequence[tuple[Array, Array]], axis: Array, at: float) -> Array | None:
        """Where the curve through places with tangents has a distance along an axis (nq + 1,); None where none goes along it.

        Raises:
            ArrayError: They are more than `KNOWN`.
        """
        self._know(known)
        self._where[:], self._axis[:] = (len(known), at), axis
        return self._guess.copy() if self._functions.touched(self._desk) else None


@lru_cache  # call after call of a run watches the same ones
def _watched(test: Any) -> tuple[float, ...]:
    """A test function as C takes it: which of `WHAT`, which one of these, what is taken off, how it may dip; of nothing where it is not known."""
    return (WHAT.index(test.what) if test.what else -1, *test[1:])

