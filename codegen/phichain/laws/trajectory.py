"""A law along a trajectory: references, inputs and gains in a table over time, and the regulator of the target behind its end."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from phichain.archive import NUMBER, TEXT, VALUES, Array, Schema, names, real
from phichain.errors import ArrayError
from phichain.laws.learning import Learning
from phichain.laws.numbers import less_turns, read_law
from phichain.laws.observer_along import ObserverAlong
from phichain.laws.state_feedback import StateFeedback
from phichain.records import Held, held, write_npz

Vector = NDArray[np.float64]

_TABLES = {"states": real("knots", "nx"), "inputs": real("knots", "nu"), "gains": real("knots", "nu", "nx")}
_OBSERVER = {
    "corrections": real("knots", "nx", "nq", optional=True), "flows": real("knots", "nq", "nx", optional=True),
    "drives": real("knots", "nq", "nu", optional=True),
}  # fmt: skip
_LEARNING = {
    "learned": real("knots", "np", "nq", optional=True), "pushes": real("knots", "nq", "np", optional=True),
    "bends": real("np", "nq", "nx+nu", optional=True), "steps": real("nq", optional=True), "inside": real("nx", "nq", optional=True),
    "outside": real("nx", "nq", optional=True), "bounds": real("np", optional=True),
}  # fmt: skip
_CATCH = {"target": real("nx"), "rest": real("nu"), "catch_gains": real("nu", "nx"), "low": real("nu"), "high": real("nu")}
_WORDS = {
    "name": TEXT, "digest": TEXT, "p": VALUES, "state_names": names("nx"), "state_units": names("nx"),
    "input_names": names("nu"), "input_units": names("nu"),
}  # fmt: skip
_NUMBERS = {"interval": NUMBER, "tube": NUMBER, "rail": NUMBER, "sample": NUMBER}
_SCHEMA = Schema(
    "TrajectoryLaw",
    {**_TABLES, **_CATCH, **_OBSERVER, **_LEARNING, "wraps": Array(np.bool_, ("nx",))},
    {**_WORDS, **_NUMBERS, "note": replace(TEXT, default=""), "learned_names": replace(names("np"), default=[])},
    filled=("knots", "nx", "nu"),
)


@dataclass(frozen=True, eq=False)
class TrajectoryLaw(Held):
    """u = clip(u_r(t) - K(t) w(x - x_r(t)), low, high) along a trajectory, and from its end on that of the target.

    Between two knots, f = t / interval - j of the way from the j-th on, u_r and K are straight lines, and x_r = (q_r, v_r) is the
    cubic that meets both knots' q and v, with its rate. The last row holds the target, the input that keeps the chain there and
    the regulator's gains: with the time held at the ends of the table, the law regulates the start before t = 0 and the target
    from the end on. It gives up (u = 0) where the angles have left x_r by `tube` or the cart its rail.

    With an observer it reads the positions alone, y, and x - x_r is what the observer makes of them; its memory z_expected begins
    at rest where the first measurement is. One that learns parameters gives up where a sensor is stuck, too.

    Attributes:
        catch: The regulator of the target, of which names, units, wraps, limits and sample hold all along.
        interval: Time between two knots, s.
        states: x_r = (q_r, v_r) at the knots (knots, nx).
        inputs: u_r (knots, nu).
        gains: K (knots, nu, nx).
        tube: Largest deviation of all angles together (2-norm) with which it goes on, rad.
        rail: Largest distance of the cart from 0, m; inf for none.
        note: What a reader of the header must know first; empty for nothing.
        observer: Where the deviation comes from if positions alone are measured; None where the whole state is.

    Raises:
        ArrayError: Shapes that do not fit, numbers that are not finite, times or bounds that are not positive, or a table that
            does not end with its regulator.
    """

    catch: StateFeedback
    interval: float
    states: Vector
    inputs: Vector
    gains: Vector
    tube: float = 1.0
    rail: float = float("inf")
    note: str = ""
    observer: ObserverAlong | None = None

    def __post_init__(self) -> None:
        nx, nu = len(self.catch.state_names), len(self.catch.input_names)
        knots = len(self.states)
        for name, shape in (("states", (nx,)), ("inputs", (nu,)), ("gains", (nu, nx))):
            table = held(getattr(self, name))
            if table.shape != (knots, *shape) or knots < 2 or not np.all(np.isfinite(table)):
                raise ArrayError(f"law.{name}", table, f"must hold finite numbers of shape {(knots, *shape)}", "give two knots or more")
            object.__setattr__(self, name, table)
        for name in ("interval", "tube", "rail"):
            if not getattr(self, name) > 0 or (name == "interval" and not np.isfinite(self.interval)):
                raise ArrayError(f"law.{name}", getattr(self, name), "is not positive", "give seconds, radians, metres")
        last = (self.states[-1], self.inputs[-1], self.gains[-1])
        target = map(np.array, (self.catch.target, self.catch.rest, self.catch.gains))
        if not all(np.array_equal(row, wanted) for row, wanted in zip(last, target, strict=True)):
            raise ArrayError("law.states", self.states[-1], "does not end in the target and its gains", "end with those of catch")
        if self.observer and self.observer.flows.shape[::2] + self.observer.drives.shape[2:] != (knots, nx, nu):
            raise ArrayError("law.observer", self.observer.flows.shape, "has other knots, states or inputs than the trajectory", "make one along it")

    @property
    def name(self) -> str:
        """The scene it belongs to."""
        return self.catch.name

    @property
    def digest(self) -> str:
        """That scene's canonical digest."""
        return self.catch.digest

    @property
    def p(self) -> Mapping[str, Any]:
        """Runtime parameters of the chain that it was made for."""
        return self.catch.p

    @property
    def duration(self) -> float:
        """Time from the first knot to the last, s."""
        return self.interval * (len(self.states) - 1)

    @property
    def numbers(self) -> int:
        """Numbers that the table holds."""
        return sum(int(part.size) for part in self.tables)

    @property
    def tables(self) -> tuple[Vector, ...]:
        """What stands in a row of the table (knots, ..), part by part: x_r, u_r, K; with an observer L, F, G; where it learns M, E."""
        seen = self.observer
        along = (seen.corrections, seen.flows, seen.drives) if seen else ()
        learned = (seen.learning.learned, seen.learning.pushes) if seen and seen.learning else ()
        return (self.states, self.inputs, self.gains, *along, *learned)

    @property
    def remembered(self) -> int:
        """Numbers that it keeps from one call to the next."""
        return self.observer.remembered if self.observer else 0

    @property
    def measured(self) -> int:
        """How many entries of x = (q, v) it reads, the first ones."""
        nx = self.states.shape[1]
        return nx // 2 if self.observer else nx

    def reference(self, t: float) -> tuple[Vector, Vector, Vector]:
        """(x_r, u_r, K) at a time."""
        j, k, f = self._weights(t)
        h, half = self.interval, self.states.shape[1] // 2
        (q0, v0), (q1, v1) = ((row[:half], row[half:]) for row in self.states[[j, k]])
        away = q1 - q0
        q = q0 + f * (h * v0 + f * (3 * away - h * (2 * v0 + v1) + f * (h * (v0 + v1) - 2 * away)))
        v = v0 + f * (6 * away / h - 4 * v0 - 2 * v1 + f * (3 * (v0 + v1) - 6 * away / h))
        u = self.inputs[j] + f * (self.inputs[k] - self.inputs[j])
        return np.concatenate([q, v]), u, self.gains[j] + f * (self.gains[k] - self.gains[j])

    def _weights(self, t: float) -> tuple[int, int, float]:
        """The knots about a time, and the share of the way between them."""
        place = min(max(t / self.interval, 0.0), len(self.states) - 1.0)
        j = int(place)
        return j, min(j + 1, len(self.states) - 1), place - j

    def reset(self, y: ArrayLike) -> Vector:
        """What is remembered at the first measurement of the positions (nq,): at rest there, parameters as they are taken to be."""
        off = less_turns(np.asarray(y, dtype=float) - self.states[0, : self.measured], self.catch.wraps[: self.measured])
        return np.concatenate([off, np.zeros(self.remembered - len(off))])

    def step(self, expected: Vector, t: float, y: ArrayLike) -> tuple[Vector, Vector]:
        """One call of a law with an observer: u (nu,) at a measurement y (nq,), and what the next call is to remember."""
        assert self.observer is not None
        reference, u, gains = self.reference(t)
        nq, nx, wraps, given = self.measured, len(reference), self.catch.wraps[: self.measured], np.asarray(y, dtype=float)
        off = less_turns(given - reference[:nq], wraps)
        z = self.observer.corrected(self._weights(t), expected[: self.observer.estimated], less_turns(off - expected[:nq], wraps))
        learning, kept, square = self.observer.learning, expected[self.observer.estimated :], float(np.sum(off[list(wraps)] ** 2))
        if learning:
            kept = learning.pulled(kept, given, z[:nx] - expected[:nx], self.catch.sample)
            square += self.tube**2 * learning.strain(kept)
        if not square <= self.tube**2 or not abs(given[0]) <= self.rail:
            return np.zeros_like(u), np.concatenate([z, kept])
        pushed = np.clip(u - gains @ z[:nx], self.catch.low, self.catch.high)
        return pushed, np.concatenate([self.observer.following(self._weights(t), z, pushed - u, self.catch.sample), kept])

    def running(self, sensor: Callable[[Vector], Vector] | None = None) -> Callable[[float, ArrayLike], Vector]:
        """A law with an observer and its memory, for `simulate(..., u=law.running(), sample=law.catch.sample)`.

        Args:
            sensor: What the positions (nq,) look like to the law: their rounding, their noise; as they are unless given.
        """
        memory: list[Vector] = []

        def law(t: float, x: ArrayLike) -> Vector:
            y = np.asarray(x, dtype=float)[: self.measured]
            y = y if sensor is None else np.asarray(sensor(y), dtype=float)
            u, following = self.step(memory.pop() if memory else self.reset(y), t, y)
            memory.append(following)
            return u

        return law

    def __call__(self, t: float, x: ArrayLike) -> Vector:
        """u (nu,) at a state (nx,) that is known, so that `simulate(..., u=law)` takes the record itself."""
        reference, u, gains = self.reference(t)
        away = less_turns(np.asarray(x, dtype=float) - reference, self.catch.wraps)
        off = float(np.sum(away[np.array(self.catch.wraps)] ** 2))
        if not off <= self.tube**2 or not abs(np.asarray(x)[0]) <= self.rail:
            return np.zeros_like(u)
        return np.clip(u - gains @ away, self.catch.low, self.catch.high)

    def __str__(self) -> str:
        return (
            f"{self.name}: law along a trajectory of {self.duration:g} s, {len(self.states)} knots of {self.states.shape[1]} states, "
            f"{self.inputs.shape[1]} input(s) and gains, {self.numbers} numbers{', read by an observer' if self.observer else ''}"
        )

    def to_npz(self, path: Path | str) -> Path:
        """Write the whole record; `from_npz` reads it back."""
        catch = {"catch_gains" if name == "gains" else name: np.array(getattr(self.catch, name)) for name in _catch_names()}
        arrays: dict[str, Any] = {name: getattr(self, name) for name in _TABLES} | catch
        if self.observer:
            arrays |= {name: getattr(self.observer, name) for name in _OBSERVER}
            arrays |= {name: getattr(self.observer.learning, name) for name in _LEARNING} if self.observer.learning else {}
        meta = {name: getattr(self.catch, name) for name in (*_WORDS, "sample")}
        meta |= {name: getattr(self, name) for name in ("interval", "tube", "note")}
        meta["learned_names"] = list(self.observer.learning.names) if self.observer and self.observer.learning else []
        # JSON knows no infinity.
        return write_npz(path, arrays, meta | {"rail": self.rail if np.isfinite(self.rail) else 0.0, "kind": _SCHEMA.kind})

    @classmethod
    def from_npz(cls, path: Path | str) -> TrajectoryLaw:
        """Read what `to_npz` wrote.

        Raises:
            OutputError: The file is missing, holds no TrajectoryLaw, or one that does not fit together.
        """

        def made(arrays: dict[str, Any], said: dict[str, Any]) -> TrajectoryLaw:
            seen: dict[str, Any] = {name: arrays.pop(name) for name in _OBSERVER if name in arrays}
            learned = {name: arrays.pop(name) for name in _LEARNING if name in arrays}
            if learned:
                seen["learning"] = Learning(**learned, names=tuple(said["learned_names"]))
            tables = {name: arrays.pop(name) for name in _TABLES}
            catch = {"gains" if name == "catch_gains" else name: array for name, array in arrays.items()}
            catch |= {name: said[name] for name in (*_WORDS, "sample")}
            return cls(
                StateFeedback(**catch), said["interval"], **tables, tube=said["tube"], rail=said["rail"] or float("inf"), note=said["note"],
                observer=ObserverAlong(**seen) if seen else None,
            )  # fmt: skip

        return read_law(path, _SCHEMA, made)


def _catch_names() -> list[str]:
    """The arrays of the regulator."""
    return [field.name for field in fields(StateFeedback) if field.name not in (*_WORDS, "sample")]
