"""Output feedback about several equilibria, and a supervisor that says from measurements alone which of them is near."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from phichain.archive import NUMBER, TEXT, VALUES, Array, Schema, names, real, whole
from phichain.errors import ArrayError
from phichain.laws.numbers import Matrix, Row, as_numbers, less_turns, read_law
from phichain.laws.observer import Observer
from phichain.laws.output_feedback import OutputFeedback
from phichain.laws.table_memory import TableMemory
from phichain.records import write_npz

Vector = NDArray[np.float64]
Sensor = Callable[[Vector], Vector]

_EACH: Final = {
    "offsets": real("count", "ny"), "rest": real("count", "nu"), "gains": real("count", "nu", "n"), "integral_gains": real("count", "nu", "ni"),
    "shapes": real("count", "rows", "n"), "begins": real("count", "ni", "n"), "take": real("count"), "leave": real("count"),
}  # fmt: skip
_SEEN: Final = {
    "advance": real("count", "n", "n"), "drive": real("count", "n", "nu"), "seen": real("count", "ny", "n"),
    "correction": real("count", "n", "ny"), "start": real("count", "n", "ny"),
}  # fmt: skip
_LIMITS: Final = {"low": real("nu"), "high": real("nu")}
_WHOLE: Final = {
    "reads": whole("ny"), "integrated": whole("ni"), "signs": whole("count", "links"), "compared": whole("told"), "settle": whole("count"),
}  # fmt: skip
_TRUTHS: Final = {"wraps": Array(np.bool_, ("ny",)), "turns": Array(np.bool_, ("n",))}
_WORDS: Final = {
    "name": TEXT, "digest": TEXT, "p": VALUES, "measured_names": names("ny"), "measured_units": names("ny"), "input_names": names("nu"),
    "input_units": names("nu"), "deviation_names": names("n"),
}  # fmt: skip
_SCHEMA: Final = Schema(
    "OutputTable",
    {**_EACH, **_LIMITS, **_WHOLE, **_TRUTHS, **{name: Array(np.float64, array.shape, True) for name, array in _SEEN.items()}},
    {**_WORDS, "sample": NUMBER, "observer": TEXT},
    filled=("count", "ny", "nu", "n", "rows", "links", "told"),
)
_SHARED: Final = (
    "name", "digest", "p", "measured_names", "measured_units", "reads", "wraps", "deviation_names", "turns", "input_names", "input_units",
    "low", "high", "sample", "integrated",
)  # fmt: skip
"""What all laws of a table have in common."""


@dataclass(frozen=True)
class OutputTable:
    """An `OutputFeedback` for each of several equilibria, of which a supervisor holds at most one.

    The equilibrium whose links are closest to what is measured is watched: its observer runs, from rest where it was not watched
    before. Its level is |W z|^2 of the estimated deviation z. It is taken up after more than `settle` calls in a row with a level of
    at most `take`, as many as an estimate needs to forget nine tenths of its error, and let go where the level passes `leave`.
    Integrals start at I = B z, where the cost to go is least. While none is held the inputs are zero within their limits.

    Attributes:
        laws: One for each equilibrium; what is measured, limits and period are the same for all.
        signs: The equilibria: +1 hanging, -1 upright, per link.
        shapes: W of each (rows, n).
        begins: B of each (ni, n).
        compared: Entries of y that say which equilibrium is close.
        settle: Calls of each that are waited for; 0 where the whole state is measured.
        take: Level of each at which it may be taken up: 1, and more where sensors alone make a level of an estimate.
        leave: Level of each above which it is let go, no less.

    Raises:
        ArrayError: Shapes that do not fit, numbers that are not finite, laws that do not belong together, or no law.
    """

    laws: tuple[OutputFeedback, ...]
    signs: tuple[tuple[int, ...], ...]
    shapes: tuple[Matrix, ...]
    begins: tuple[Matrix, ...]
    compared: tuple[int, ...]
    settle: tuple[int, ...]
    take: Row
    leave: Row

    def __post_init__(self) -> None:
        count = len(self.laws)
        signs = tuple(tuple(int(sign) for sign in row) for row in self.signs)
        if not count or len(signs) != count or len(set(signs)) < count:
            raise ArrayError("table.signs", signs, "hold no equilibrium, or one twice", "give each once, with its law")
        first = self.laws[0]
        for field in _SHARED:
            if any(getattr(law, field) != getattr(first, field) for law in self.laws):
                raise ArrayError("table.laws", field, "is not the same for all", "make the laws of one chain with the same sensors")
        if len({None if law.observer is None else law.observer.kind for law in self.laws}) > 1:
            raise ArrayError("table.laws", "observer", "is not the same for all", "make the laws of one chain with the same sensors")
        n, ni = len(first.deviation_names), len(first.integrated)
        rows = len(self.shapes[0]) if len(self.shapes) else 0
        sizes = {"shapes": (count, rows, n), "begins": (count, ni, n)}
        for field, shape in sizes.items():
            given = getattr(self, field) if ni or field == "shapes" else np.zeros(shape)
            object.__setattr__(self, field, as_numbers(f"table.{field}", given, shape))
        object.__setattr__(self, "signs", signs)
        for field in ("compared", "settle"):
            object.__setattr__(self, field, tuple(map(int, getattr(self, field))))
        if not len(self.compared) or not all(0 <= k < len(first.reads) for k in self.compared):
            raise ArrayError("table.compared", self.compared, "are not all measured", f"give numbers below {len(first.reads)}")
        if len(self.settle) != count or min(self.settle) < 0:
            raise ArrayError("table.settle", self.settle, "does not say of each how many calls it takes", f"give {count} whole numbers")
        for field in ("take", "leave"):
            object.__setattr__(self, field, as_numbers(f"table.{field}", getattr(self, field), (count,)))
        if not all(0 < take <= leave for take, leave in zip(self.take, self.leave, strict=True)):
            raise ArrayError("table.leave", self.leave, "lets go before it takes up", "give levels that are no less than those of take")

    @property
    def name(self) -> str:
        """The scene it belongs to."""
        return self.laws[0].name

    @property
    def digest(self) -> str:
        """That scene's canonical digest."""
        return self.laws[0].digest

    @property
    def p(self) -> Mapping[str, Any]:
        """The runtime parameters that it was made for."""
        return self.laws[0].p

    @property
    def kind(self) -> str:
        """The kind of observer; empty where the whole state is measured."""
        observer = self.laws[0].observer
        return observer.kind if observer else ""

    @property
    def sample(self) -> float:
        """Time between two calls, s."""
        return self.laws[0].sample

    def of_scene(self, name: str, digest: str) -> OutputTable:
        """The same table as that of another scene, of the same chain."""
        return replace(self, laws=tuple(replace(law, name=name, digest=digest) for law in self.laws))

    def __str__(self) -> str:
        first = self.laws[0]
        parts = [f"{self.name}: output feedback about {len(self.laws)} equilibria every {self.sample:g} s from {', '.join(first.measured_names)}"]
        parts += [f"a {self.kind} observer that settles within {max(self.settle)} calls"] if self.kind else []
        parts += [f"integrals of {', '.join(first.measured_names[k] for k in first.integrated)}"] if first.integrated else []
        return ", ".join(parts)

    def reset(self) -> TableMemory:
        """The memory before the first call: nothing is held or watched."""
        first = self.laws[0]
        return TableMemory(-1, -1, 0, 0.0, np.zeros(len(first.deviation_names)), np.zeros(len(first.integrated)))

    def level(self, which: int, z: ArrayLike) -> float:
        """|W z|^2 of a deviation (n,) from one equilibrium."""
        return float(np.sum((np.array(self.shapes[which]) @ np.asarray(z, dtype=float)) ** 2))

    def closest(self, y: ArrayLike) -> int:
        """The equilibrium that is closest to what is measured (ny,); -1 where what tells them apart is not finite."""
        measured, at = np.asarray(y, dtype=float), list(self.compared)
        apart = [float(np.sum(self._off(which, measured)[at] ** 2)) for which in range(len(self.laws))]
        return int(np.argmin(apart)) if np.all(np.isfinite(apart)) else -1

    def supervise(self, memory: TableMemory, y: ArrayLike) -> TableMemory:
        """The supervisor's part of a call at a measurement y (ny,): what is watched and held, and its deviation."""
        measured = np.asarray(y, dtype=float)
        looked = memory
        if memory.held >= 0:
            looked = self._estimated(memory, memory.held, measured)
            if looked.level <= self.leave[memory.held]:
                return looked
            looked = replace(looked, held=-1, calls=0)
        near = self.closest(measured)
        if near < 0:
            return replace(looked, near=-1, calls=0)
        if near != looked.near:
            looked = self._started(looked, near, measured)
        elif memory.held < 0:
            looked = self._estimated(looked, near, measured)
        calls = looked.calls + 1 if looked.level <= self.take[near] else 0
        if calls <= self.settle[near]:
            return replace(looked, calls=calls)
        return replace(looked, calls=calls, held=near, integral=np.array(self.begins[near]).reshape(-1, len(looked.deviation)) @ looked.deviation)

    def inputs(self, memory: TableMemory) -> Vector:
        """u (nu,) of what is held; zero within limits for none."""
        low, high = np.array(self.laws[0].low), np.array(self.laws[0].high)
        return np.clip(np.zeros(len(low)) if memory.held < 0 else self._wanted(memory), low, high)

    def follow(self, memory: TableMemory, y: ArrayLike, u: ArrayLike) -> TableMemory:
        """The memory for the next call, after a measurement y (ny,) and with the inputs u (nu,) that act until then."""
        if memory.near < 0:
            return memory
        law = self.laws[memory.near]
        deviation, integral = memory.deviation, memory.integral
        if law.observer:
            pushed = np.array(law.observer.drive) @ (np.asarray(u, dtype=float) - np.array(law.rest))
            deviation = np.array(law.observer.advance) @ deviation + pushed
        if law.integrated and memory.held >= 0:
            off = self._off(memory.near, np.asarray(y, dtype=float))[list(law.integrated)]
            growing = law.sample * np.where(np.isfinite(off), off, 0.0)
            wanted = self._wanted(memory)
            beyond = (wanted - np.clip(wanted, law.low, law.high))[:, None] * np.array(law.integral_gains) * growing
            integral = integral + np.where(np.any(beyond < 0, axis=0), 0.0, growing)
        return replace(memory, deviation=deviation, integral=integral)

    def step(self, memory: TableMemory, y: ArrayLike) -> tuple[Vector, TableMemory]:
        """One call: the inputs u (nu,) at a measurement y (ny,), and the memory for the next one."""
        looked = self.supervise(memory, y)
        u = self.inputs(looked)
        return u, self.follow(looked, y, u)

    def running(self, sensor: Sensor | None = None) -> Callable[[float, ArrayLike], Vector]:
        """The law with a memory of its own, for `simulate(..., u=table.running(), sample=table.sample)`.

        Args:
            sensor: What the measurement (ny,) looks like to the law: its rounding, its noise; as it is unless given.
        """
        memory = [self.reset()]

        def law(t: float, x: ArrayLike) -> Vector:
            y = np.asarray(x, dtype=float)[list(self.laws[0].reads)]
            u, memory[0] = self.step(memory[0], y if sensor is None else sensor(y))
            return u

        return law

    def _wanted(self, memory: TableMemory) -> Vector:
        law = self.laws[memory.held]
        return np.array(law.rest) - np.array(law.gains) @ memory.deviation - np.array(law.integral_gains) @ memory.integral

    def _off(self, which: int, y: Vector) -> Vector:
        with np.errstate(invalid="ignore"):
            return less_turns(y - np.array(self.laws[which].offsets), self.laws[which].wraps)

    def _started(self, memory: TableMemory, which: int, y: Vector) -> TableMemory:
        law, off = self.laws[which], self._off(which, y)
        z = off if law.observer is None else np.array(law.observer.start) @ np.where(np.isfinite(off), off, 0.0)
        return replace(memory, near=which, calls=0, deviation=z, level=self.level(which, z))

    def _estimated(self, memory: TableMemory, which: int, y: Vector) -> TableMemory:
        law, z = self.laws[which], self._off(which, y)
        if law.observer:
            with np.errstate(invalid="ignore"):
                innovation = less_turns(z - np.array(law.observer.seen) @ memory.deviation, law.wraps)
            innovation = np.where(np.isfinite(innovation), innovation, 0.0)
            z = less_turns(memory.deviation + np.array(law.observer.correction) @ innovation, law.turns)
        return replace(memory, deviation=z, level=self.level(which, z))

    def to_npz(self, path: Path | str) -> Path:
        """Write the whole record; `from_npz` reads it back."""
        first, count = self.laws[0], len(self.laws)
        n, nu, ni = len(first.deviation_names), len(first.input_names), len(first.integrated)
        arrays: dict[str, Any] = {name: np.array([getattr(law, name) for law in self.laws], dtype=float) for name in ("offsets", "rest", "gains")}
        arrays["integral_gains"] = np.array([law.integral_gains for law in self.laws], dtype=float).reshape(count, nu, ni)
        arrays |= {"take": np.array(self.take), "leave": np.array(self.leave), "shapes": np.array(self.shapes), "begins": np.array(self.begins, dtype=float).reshape(count, ni, n)}
        arrays |= {name: np.array(getattr(first, name), dtype=float) for name in _LIMITS}
        arrays |= {name: np.array(getattr(self if name in ("signs", "compared", "settle") else first, name), dtype=np.int64) for name in _WHOLE}
        arrays |= {name: np.array(getattr(first, name), dtype=bool) for name in _TRUTHS}
        if self.kind:
            arrays |= {name: np.array([getattr(law.observer, name) for law in self.laws]) for name in _SEEN}
        meta = {name: getattr(first, name) for name in (*_WORDS, "sample")}
        return write_npz(path, arrays, meta | {"kind": _SCHEMA.kind, "observer": self.kind})

    @classmethod
    def from_npz(cls, path: Path | str) -> OutputTable:
        """Read what `to_npz` wrote.

        Raises:
            OutputError: The file is missing, holds no OutputTable, or one that does not fit together.
        """
        return read_law(path, _SCHEMA, _unpacked)


def _unpacked(arrays: dict[str, Any], said: dict[str, Any]) -> OutputTable:
    kind = said.pop("observer")
    own = {field.name for field in fields(OutputTable)} & set(arrays)
    mine = {name: arrays.pop(name) for name in own}
    each = {name: arrays.pop(name) for name in (*_EACH, *_SEEN) if name in arrays}

    def law(which: int) -> OutputFeedback:
        parts = {name: values[which] for name, values in each.items() if name not in _SEEN}
        observer = Observer(kind, **{name: each[name][which] for name in _SEEN}) if kind else None
        return OutputFeedback(**arrays, **said, **parts, observer=observer)

    return OutputTable(tuple(law(which) for which in range(len(mine["signs"]))), **mine)
