"""Brake orbits as their chain's compiled object finds them: the problem of `quarter`, whole iterations of it in one call.

What an evaluation costs besides the flow is a few hundred operations on matrices of N rows: in C a microsecond, from Python twenty times
that. `stencils/orbits` has them; this is what reads its answers.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Sequence
from dataclasses import fields
from typing import Any, Final

import numpy as np

from phichain.continuation import Evaluation, Options, Point
from phichain.continuation.compiled.block import BlockPoint
from phichain.continuation.compiled.protocol import Met, Ran, Seen, Step, Stepped, Told, Watch
from phichain.continuation.linear import eigenvalues
from phichain.continuation.problem import LateExtra, Multipliers
from phichain.orbits.quarter.map import QuarterMap, ordered
from phichain.system import Vector


class BrakeMap(QuarterMap):
    """The quarter map with what the compiled object has found of it already; its arrays are taken out when they are asked for."""

    _found: Any
    _tests: dict[str, float]

    def __init__(self, found: Any) -> None:
        """Keep what C told."""
        own, numbers = vars(self), found.numbers
        own["_found"] = found
        own["_tests"] = {
            "brake loss": numbers.brake_loss, "odd loss": numbers.odd_loss, "unequal brakes": numbers.unequal_brakes, "error": numbers.error,
            "energy slope": numbers.energy_slope, "steepness": numbers.steepness, "largest kappa": numbers.largest_kappa,
        }  # fmt: skip

    def __getattr__(self, name: str) -> Any:
        """An array when it is first read.

        Raises:
            AttributeError: There is none of that name.
        """
        if name not in _ARRAYS:
            raise AttributeError(name)
        vars(self)[name] = array = self._found.array(name)
        return array

    def kappa(self) -> Multipliers:
        """As of any quarter map."""
        return _kappa(self._found.array("folded"))

    def test(self, name: str, of: Callable[[QuarterMap], float]) -> float:
        """What C has found."""
        value: float = self._tests[name]
        return value


_ARRAYS: Final = frozenset(item.name for item in fields(QuarterMap))
_SEVERAL: Final = 2
_NUMBERS: Final = {"residual": "relative", "iterations": "taken", "energy": "energy", "error": "error"}
"""Fields of points, and the error of omega, that are numbers of their rows; of a run every row is one that Newton got to."""
_VALUES: Final = 2
"""Numbers of a row's head before its test functions."""


class _Own(threading.local):
    """What every thread has of its own: the numbers that C computes on."""

    def __init__(self, brake: Any, unused: list[Any]) -> None:
        """Called once in each thread: the first one takes what there is."""
        try:
            self.brake = unused.pop()
        except IndexError:
            self.brake = brake.another()


class Braking:
    """A compiled problem (`continuation.compiled.protocol.Compiled`) of brake orbits; several threads may ask it at once."""

    def __init__(self, brake: Any) -> None:
        """Take what a compiled flow's `brake` made."""
        self._own, self._scale = _Own(brake, [brake]), brake.desk["scale"]

    @property
    def _brake(self) -> Any:
        return self._own.brake

    def evaluate(self, z: Vector) -> Evaluation:
        """Residual and Jacobian at the unknowns themselves (nq + 1,)."""
        found = self._brake.at(z / self._scale)
        if found is None:
            size = len(z) - 1
            return Evaluation(np.full(size, np.nan), np.full((size, size + 1), np.nan))
        return Evaluation(found.array("residual"), found.array("jacobian") / self._scale, _BrakeExtra(found))

    def at(self, y: Vector, along: Vector) -> Told | None:
        """See `Compiled`."""
        found = self._brake.at(y, along)
        return None if found is None else _told(found)

    def settled(self, y: Vector, along: Vector) -> Told | None:
        """See `Compiled`."""
        found = self._brake.settled(y, along)
        return None if found is None else _told(found)

    def corrected(self, guess: Vector, normal: Vector, tol: float, trust: float, most: int) -> Told:
        """See `Compiled`."""
        return _told(self._brake.corrected(guess, normal, tol, trust, most))

    def touched(self, known: Sequence[tuple[Vector, Vector]], axis: Vector, place: float) -> Vector | None:
        """See `Compiled`."""
        there: Vector | None = self._brake.touched(known, axis, place)
        return there

    def ahead(self, known: Sequence[tuple[Vector, Vector]], jacobian: Vector, step: float, tol: float, most: int) -> Stepped:
        """See `Compiled`."""
        found, way = self._brake.ahead(known, jacobian, step, tol, most)
        return Stepped(_told(found), way.moved, way.shifted, way.turned, way.changed, self._change)

    def watches(self, tests: Sequence[Watch]) -> bool:
        """See `Compiled`."""
        known: bool = self._brake.watches(tests)
        return known

    def run(
        self, seen: Seen, jacobian: Vector, step: float, most: int, options: Options, start: tuple[int, Vector, Vector], tests: Sequence[Watch]
    ) -> Ran:
        """See `Compiled`."""
        limits = options.step_min, options.step_max, options.max_angle, options.aim_angle, options.max_change
        newton = options.tol, options.trust, options.max_iterations
        found = self._brake.run(seen, jacobian, step, most, limits, newton, start, tests)
        met: dict[int, list[Met]] = {}
        for event in found.events:
            met.setdefault(event.before, []).append(Met(event.which, event.y, event.arclength, event.left, _kappa(event.folded)))
        block, known = _Rows(found.rows), (found.rows.number("is_told") > 0).tolist()
        steps = [
            Step(BlockPoint.of(block, k), head[1], tuple(head[_VALUES:]) if known[k] else None, met.get(k, ()))
            for k, head in enumerate(found.rows.heads)
        ]  # fmt: skip
        return Ran(steps, found.stopped, found.tried, found.is_doubtful)

    def zero(
        self, line: Sequence[tuple[float, Vector, Vector]], values: tuple[float, float], beyond: Sequence[tuple[float, float]], test: Watch,
        options: Options, near: tuple[float, float, bool, float], shape: tuple[float, float, Vector] | None = None,
    ) -> tuple[list[tuple[Told, float, bool]], int, int, float] | None:  # fmt: skip
        """See `Compiled`."""
        newton = options.tol, options.trust, options.max_iterations
        found = self._brake.zero(line, values, beyond, test, newton, near, shape)
        if found is None:
            return None
        rows = _Rows(found.rows)
        return [(rows.fields(k), head[_VALUES], head[1] > 0) for k, head in enumerate(found.rows.heads)], *found[1:]

    def places(self, line: Sequence[tuple[float, Vector, Vector]], at: Vector, options: Options) -> Vector | None:
        """See `Compiled`."""
        found: Vector | None = self._brake.places(line, at, (options.tol, 0.0, options.max_iterations))
        return found

    def _change(self) -> Vector:
        change: Vector = self._brake.change
        return change


def frequency_error_of(point: Point) -> float:
    """How far off omega may be, relative: what C found of `quarter.problem.frequency_error`."""
    extra = point.extra
    error: float = extra.error if isinstance(extra, _BrakeExtra) else extra.found.test("error", _unknown)
    return error


def _unknown(_: QuarterMap) -> float:
    return math.nan


class _BrakeExtra(LateExtra):
    """Multipliers and quarter map of what C told, each by itself: of most orbits on the way it is the multipliers alone that are read."""

    _told: Any

    def __init__(self, told: Any) -> None:
        """Keep what C told."""
        self.__dict__["_told"] = told

    @property
    def error(self) -> float:
        """Of omega."""
        error: float = self._told.numbers.error
        return error

    def _made(self, name: str) -> dict[str, Any]:
        """See `LateExtra`.

        Raises:
            LinAlgError: The place has none of them.
        """
        if not self._told.numbers.is_told > 0:
            raise np.linalg.LinAlgError("matrix is not positive definite")
        return {name: _kappa(self._told.array("folded")) if name == "multipliers" else BrakeMap(self._told)}


def _kappa(folded: Vector) -> Multipliers:
    """Those of d^T a across the force, as C tells it."""
    inner = math.isqrt(len(folded)) - 1
    kappa = np.array([1 - 2 * own for own in folded[:inner].tolist()], complex) if inner < _SEVERAL else ordered(1 - 2 * eigenvalues(folded[: inner * inner].reshape(inner, inner)))
    kappa.flags.writeable = False
    return kappa


class _Rows:
    """Orbits that C told in rows, as a block of points (`continuation.compiled.block.Block`)."""

    def __init__(self, rows: Any) -> None:
        """Take the rows."""
        self._rows = rows

    def fields(self, place: int) -> dict[str, Any]:
        """See `Block`."""
        told = _told(self._rows.found(place))
        del told["converged"]
        return told | {"arclength": float(self._rows.arclengths[place]), "iterations": len(told["corrections"])}

    def column(self, name: str) -> np.ndarray | None:
        """See `Block`."""
        rows = self._rows
        if name in ("y", "tangent"):
            array: Vector = rows.array(name)
            return array
        if name in _NUMBERS:
            number: Vector = rows.number(_NUMBERS[name])
            return number.astype(int) if name == "iterations" else number
        return rows.arclengths if name == "arclength" else self._multipliers() if name == "multipliers" else None

    def _multipliers(self) -> Multipliers | None:
        """Those of all orbits where each has one at most; the others are each a matrix's own."""
        folded = self._rows.array("folded")
        inner = math.isqrt(folded.shape[1]) - 1
        is_each = inner >= _SEVERAL or not (self._rows.number("is_told") > 0).all()
        return None if is_each else (1 - 2 * folded[:, :inner]).astype(complex)


def _told(found: Any) -> Told:
    numbers, array = found.numbers, found.array
    converged, count = numbers.converged > 0, int(numbers.taken)
    return {
        "y": array("y"), "tangent": array("tangent"), "jacobian": array("jacobian"), "residual": numbers.relative if converged else math.inf,
        "corrections": tuple(array("corrections")[:count].tolist()), "converged": converged, "sigma": numbers.sigma,
        "is_settled": numbers.is_whole > 0, "extra": _BrakeExtra(found), "energy": numbers.energy,
    }  # fmt: skip
