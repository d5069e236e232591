"""Branch: the frozen record of one continuation run."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from phichain.archive import TEXT, Schema, complex_numbers, names, read_archive, real, whole, word
from phichain.continuation.problem import Multipliers
from phichain.errors import ArrayError
from phichain.records import Held, columns_of, write_csv, write_npz
from phichain.system import Vector

_ARRAYS = {
    "points": real("m", "unknowns"),
    "arclength": real("m"),
    "tangent": real("m", "unknowns"),
    "residual": real("m"),
    "iterations": whole("m"),
    "scale": real("unknowns"),
    "energy": real("m", optional=True),
    "multipliers": complex_numbers("m", "exponents", optional=True),
}
_EVENTS = {
    "index": whole("events"),
    "z": real("events", "unknowns"),
    "arclength": real("events"),
    "value": real("events"),
    "multipliers": complex_numbers("events", "exponents", optional=True),
}
_PLAIN = {
    "name": TEXT,
    "names": names("unknowns"),
    "status": word("event", "closed", "points", "step"),
    "reason": TEXT,
}
_SCHEMA = Schema(
    "Branch",
    {**_ARRAYS, **{f"event_{name}": array for name, array in _EVENTS.items()}},
    {**_PLAIN, "event_kinds": names("events", counted=True)},
    filled=("m", "unknowns"),
)


@dataclass(frozen=True, eq=False)
class Special(Held):
    """A located event.

    Attributes:
        kind: Name of its test function.
        index: It lies between the points `index` and `index + 1` of the branch.
        z: The unknowns there (n + 1,).
        arclength: s there.
        value: What is left of the test function; how well it is located.
        multipliers: Those of the solution there (k,); empty where the method computes none.
    """

    kind: str
    index: int
    z: Vector
    arclength: float
    value: float
    multipliers: Multipliers


@dataclass(frozen=True, eq=False)
class Branch(Held):
    """A curve of solutions, point by point.

    Attributes:
        name: What was continued.
        names: Names of the unknowns.
        points: Unknowns (m, n + 1).
        arclength: s (m,), measured in unknowns over `scale`.
        tangent: dz/ds (m, n + 1).
        residual: Relative residual (m,): |F_i| over the size of its terms, largest i.
        iterations: Newton iterations (m,).
        scale: Typical sizes of the unknowns (n + 1,).
        energy: Recorded scalar (m,), J, or None.
        multipliers: Complex numbers (m, k) that tell the stability of every point, in the form that the method states
            (`Extra`); (m, 0) where it computes none, as with one harmonic.
        events: Located events in order.
        status: "event" (a terminal one), "closed", "points", or "step" (it needed a step below step_min).
        reason: The same in words.
    """

    name: str
    names: tuple[str, ...]
    points: Vector
    arclength: Vector
    tangent: Vector
    residual: Vector
    iterations: Vector
    scale: Vector
    energy: Vector | None
    multipliers: Multipliers
    events: tuple[Special, ...]
    status: str
    reason: str

    def __len__(self) -> int:
        return len(self.points)

    def __str__(self) -> str:
        lines = [f"{self.name}: {len(self)} points, arclength {self.arclength[-1]:.6g}; {self.reason}"]
        lines += [
            f"  {event.kind} at s = {event.arclength:.6g}: "
            + ", ".join(f"{name} = {value:.9g}" for name, value in zip(self.names, event.z, strict=True))
            for event in self.events
        ]
        return "\n".join(lines)

    def column(self, name: str) -> Vector:
        """The values (m,) of one unknown.

        Raises:
            ArrayError: No unknown has that name.
        """
        if name not in self.names:
            raise ArrayError(
                "name", name, "is no unknown of this branch", f"use one of {', '.join(self.names)}"
            )
        return self.points[:, self.names.index(name)]

    def located(self, kind: str) -> tuple[Special, ...]:
        """The events of one kind, in order."""
        return tuple(event for event in self.events if event.kind == kind)

    def to_csv(self, path: Path | str) -> Path:
        """Write one row per point: arclength, the unknowns, energy, residual, iterations, multipliers; 17 digits."""
        columns: dict[str, Any] = {"arclength": self.arclength, **columns_of(self.names, self.points)}
        if self.energy is not None:
            columns["energy"] = self.energy
        columns |= {"residual": self.residual, "iterations": self.iterations}
        for k, values in enumerate(self.multipliers.T, 1):
            columns |= {f"multiplier_{k}_re": values.real, f"multiplier_{k}_im": values.imag}
        return write_csv(path, columns)

    def to_npz(self, path: Path | str) -> Path:
        """Write the whole record; `from_npz` reads it back."""
        arrays = {name: getattr(self, name) for name in _ARRAYS if getattr(self, name) is not None}
        for name, wanted in _EVENTS.items():
            arrays[f"event_{name}"] = np.array([getattr(event, name) for event in self.events], wanted.dtype)
        meta = {name: getattr(self, name) for name in _PLAIN}
        return write_npz(
            path, arrays, meta | {"kind": _SCHEMA.kind, "event_kinds": [event.kind for event in self.events]}
        )

    @classmethod
    def from_npz(cls, path: Path | str) -> Branch:
        """Read what `to_npz` wrote.

        Raises:
            OutputError: The file is missing or holds no Branch, or not a whole one.
        """
        arrays, meta = read_archive(path, _SCHEMA)
        for name, count in (("multipliers", len(arrays["points"])), ("event_multipliers", len(meta["event_kinds"]))):
            arrays.setdefault(name, np.zeros((count, 0), complex))  # files from before there were any hold none
        parts = (arrays[f"event_{name}"] for name in _EVENTS)
        events = tuple(
            Special(kind, int(index), z, float(s), float(value), multipliers)
            for kind, index, z, s, value, multipliers in zip(meta["event_kinds"], *parts, strict=True)
        )
        plain = {name: meta[name] for name in _PLAIN} | {"names": tuple(meta["names"])}
        held: dict[str, Any] = {name: arrays.get(name) for name in _ARRAYS}
        return cls(**plain, **held, events=events)
