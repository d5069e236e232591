"""Feedback with a memory: an observer in front of the gains, integrals of what must not stay off, or both."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from phichain.archive import NUMBER, TEXT, VALUES, Array, Schema, names, real, whole
from phichain.errors import ArrayError
from phichain.laws.numbers import Matrix, Row, as_numbers, less_turns, read_law
from phichain.laws.observer import Observer
from phichain.records import Valued, write_npz

Vector = NDArray[np.float64]
Sensor = Callable[[Vector], Vector]

_FRAME = {
    "offsets": real("ny"), "rest": real("nu"), "gains": real("nu", "n"), "low": real("nu"), "high": real("nu"),
    "integral_gains": real("nu", "ni"),
}  # fmt: skip
_OBSERVER = {
    "advance": real("n", "n"), "drive": real("n", "nu"), "seen": real("ny", "n"), "correction": real("n", "ny"),
    "start": real("n", "ny"),
}  # fmt: skip
_WHOLE = {"reads": whole("ny"), "integrated": whole("ni")}
_TRUTHS = {"wraps": Array(np.bool_, ("ny",)), "turns": Array(np.bool_, ("n",))}
_WORDS = {
    "name": TEXT, "digest": TEXT, "p": VALUES, "measured_names": names("ny"), "measured_units": names("ny"), "input_names": names("nu"),
    "input_units": names("nu"), "deviation_names": names("n"),
}  # fmt: skip
_OPTIONAL = {name: Array(np.float64, array.shape, True) for name, array in _OBSERVER.items()}
_SCHEMA: Final = Schema(
    "OutputFeedback",
    {**_FRAME, **_WHOLE, **_TRUTHS, **_OPTIONAL},
    {**_WORDS, "sample": NUMBER, "observer": TEXT},
    filled=("ny", "nu", "n"),
)


@dataclass(frozen=True)
class OutputFeedback(Valued):
    """u = clip(u_0 - K w(z) - K_i I, low, high), called once every `sample` seconds, the inputs held in between.

    z is the deviation from the target: what the observer makes of the measurement y, or without one w(y - y_0) itself. I holds
    integrals of some w(y_i - y_0i); one grows by `sample` times that at each call, unless an input that it acts on is at its
    limit and would only be driven further beyond (so that nothing winds up). w takes whole turns from angles.

    `lowering.laws.output_feedback` writes it as a Program whose memory its caller keeps.

    Attributes:
        name: The scene it belongs to.
        digest: That scene's canonical digest; empty for a chain that was made by hand.
        measured_names: Names of what is measured, ny of them.
        measured_units: Their units.
        reads: Where each of them stands in the scene's x = (q, v).
        offsets: y_0 (ny,), what is measured at the target.
        wraps: Which measurements are angles.
        deviation_names: Names of z, n of them.
        turns: Which entries of z are angles.
        input_names: Names of u, nu of them.
        input_units: Their units.
        rest: u_0 (nu,), the input that keeps the chain at the target.
        gains: K (nu, n), row by row.
        low: Least inputs (nu,); -inf for one without a limit.
        high: Largest inputs (nu,); inf for one without a limit.
        sample: Time between two calls, s.
        observer: Where z comes from; None where it is measured.
        integrated: Which measurements are integrated, ni of them.
        integral_gains: K_i (nu, ni).

    Raises:
        ArrayError: Shapes that do not fit, numbers that are not finite, no time between calls, or limits that leave nothing.
    """

    name: str
    digest: str
    measured_names: tuple[str, ...]
    measured_units: tuple[str, ...]
    reads: tuple[int, ...]
    offsets: Row
    wraps: tuple[bool, ...]
    deviation_names: tuple[str, ...]
    turns: tuple[bool, ...]
    input_names: tuple[str, ...]
    input_units: tuple[str, ...]
    rest: Row
    gains: Matrix
    low: Row
    high: Row
    sample: float
    observer: Observer | None = None
    integrated: tuple[int, ...] = ()
    integral_gains: Matrix = field(default=())

    def __post_init__(self) -> None:
        super().__post_init__()
        ny, nu, n, ni = len(self.measured_names), len(self.input_names), len(self.deviation_names), len(self.integrated)
        if not len(self.integral_gains):
            object.__setattr__(self, "integral_gains", ((),) * nu)
        shapes = {
            "offsets": (ny,), "rest": (nu,), "gains": (nu, n), "low": (nu,), "high": (nu,), "integral_gains": (nu, ni),
        }  # fmt: skip
        for name, shape in shapes.items():
            infinite = name in ("low", "high")
            object.__setattr__(self, name, as_numbers(f"law.{name}", getattr(self, name), shape, infinite))
        sizes = {"measured_units": ny, "reads": ny, "wraps": ny, "turns": n, "input_units": nu}
        for name, size in sizes.items():
            if len(getattr(self, name)) != size:
                raise ArrayError(f"law.{name}", getattr(self, name), f"must hold {size} entries", "give one for each")
        for name, kind in (("wraps", bool), ("turns", bool), ("reads", int), ("integrated", int)):
            object.__setattr__(self, name, tuple(map(kind, getattr(self, name))))
        if not 0 < self.sample < np.inf:
            raise ArrayError("law.sample", self.sample, "is no time between two calls", "give seconds")
        if not all(0 <= k < ny for k in self.integrated):
            raise ArrayError("law.integrated", self.integrated, "are not all measured", f"give numbers below {ny}")
        for name, low, high in zip(self.input_names, self.low, self.high, strict=True):
            if not low < high:
                raise ArrayError(
                    "law.low, law.high", (low, high), f"leave nothing for {name}", "give a lower limit below the upper one"
                )
        self._demand_source(n, ny, nu)

    def _demand_source(self, n: int, ny: int, nu: int) -> None:
        """z comes from an observer of that size, or is what is measured."""
        sizes = (n, n, nu) if self.observer is None else tuple(map(len, (self.observer.advance, self.observer.start, self.gains)))
        if sizes != (n, n, nu) or (self.observer is None and n != ny) or (self.observer and len(self.observer.seen) != ny):
            raise ArrayError("law.observer", sizes, f"does not lead from {ny} measurements to {n} deviations", "give one that does")

    @property
    def memory(self) -> dict[str, int]:
        """What is kept from one call to the next, by name and number of entries."""
        kept = {"expected": len(self.deviation_names) if self.observer else 0, "integral": len(self.integrated)}
        return {name: size for name, size in kept.items() if size}

    def __str__(self) -> str:
        parts = [f"{self.name}: output feedback every {self.sample:g} s from {', '.join(self.measured_names)}"]
        parts += [f"a {self.observer.kind} observer of {len(self.turns)} quantities"] if self.observer else []
        parts += [f"integrals of {', '.join(self.measured_names[k] for k in self.integrated)}"] if self.integrated else []
        return ", ".join(parts)

    def running(self, sensor: Sensor | None = None) -> Callable[[float, ArrayLike], Vector]:
        """The law with a memory of its own, for `simulate(..., u=law.running(), sample=law.sample)`; it starts at its first call.

        Args:
            sensor: What the measurement (ny,) looks like to the law: its rounding, its noise; as it is unless given.
        """
        memory: dict[str, Vector] = {}

        def law(t: float, x: ArrayLike) -> Vector:
            y = np.asarray(x, dtype=float)[list(self.reads)]
            y = y if sensor is None else np.asarray(sensor(y), dtype=float)
            if not memory:
                memory.update(self.reset(y))
            u, following = self.step(memory, y)
            memory.update(following)
            return u

        return law

    def reset(self, y: ArrayLike) -> dict[str, Vector]:
        """The memory at the first measurement y (ny,): the least deviation that shows it, at rest, and integrals of zero."""
        memory = {"integral": np.zeros(len(self.integrated))}
        if self.observer:
            memory["expected"] = np.array(self.observer.start) @ _finite(self._away(np.asarray(y, dtype=float)))
        return memory

    def step(self, memory: dict[str, Vector], y: ArrayLike) -> tuple[Vector, dict[str, Vector]]:
        """One call: the inputs u (nu,) at a measurement y (ny,), and the memory for the next one."""
        off = self._away(np.asarray(y, dtype=float))
        z, following = off, {"integral": memory["integral"]}
        if self.observer:
            innovation = _finite(_turned(off - np.array(self.observer.seen) @ memory["expected"], self.wraps))
            z = _turned(memory["expected"] + np.array(self.observer.correction) @ innovation, self.turns)
        K, K_i = np.array(self.gains), np.array(self.integral_gains)
        wanted = np.array(self.rest) - K @ z - K_i @ memory["integral"]
        u = np.clip(wanted, self.low, self.high)
        if self.observer:
            pushed = np.array(self.observer.drive) @ (u - np.array(self.rest))
            following["expected"] = np.array(self.observer.advance) @ z + pushed
        if self.integrated:
            growing = self.sample * _finite(off[list(self.integrated)])
            # Beyond its limit an input holds what would only drive it further.
            beyond = (wanted - u)[:, None] * K_i * growing
            following["integral"] = memory["integral"] + np.where(np.any(beyond < 0, axis=0), 0.0, growing)
        return u, following

    def _away(self, y: Vector) -> Vector:
        return _turned(y - np.array(self.offsets), self.wraps)

    def to_npz(self, path: Path | str) -> Path:
        """Write the whole record; `from_npz` reads it back."""
        arrays: dict[str, Any] = {name: np.array(getattr(self, name), dtype=float) for name in _FRAME}
        arrays["integral_gains"] = arrays["integral_gains"].reshape(len(self.input_names), len(self.integrated))
        arrays |= {name: np.array(getattr(self, name), dtype=np.int64) for name in _WHOLE}
        arrays |= {name: np.array(getattr(self, name), dtype=bool) for name in _TRUTHS}
        if self.observer:
            arrays |= {name: np.array(getattr(self.observer, name)) for name in _OBSERVER}
        meta = {name: getattr(self, name) for name in (*_WORDS, "sample")}
        return write_npz(path, arrays, meta | {"kind": _SCHEMA.kind, "observer": self.observer.kind if self.observer else ""})

    @classmethod
    def from_npz(cls, path: Path | str) -> OutputFeedback:
        """Read what `to_npz` wrote.

        Raises:
            OutputError: The file is missing, holds no OutputFeedback, or one that does not fit together.
        """

        def made(arrays: dict[str, Any], said: dict[str, Any]) -> OutputFeedback:
            kind, kept = said.pop("observer"), {name: arrays.pop(name) for name in _OBSERVER if name in arrays}
            return cls(**arrays, **said, observer=Observer(kind, **kept) if kind else None)

        return read_law(path, _SCHEMA, made)


def _turned(away: Vector, wraps: tuple[bool, ...]) -> Vector:
    """Deviations less whole turns, where they are angles, in [-pi, pi)."""
    with np.errstate(invalid="ignore"):
        return less_turns(away, wraps)


def _finite(values: Vector) -> Vector:
    """Zero for what is not finite."""
    return np.where(np.isfinite(values), values, 0.0)
