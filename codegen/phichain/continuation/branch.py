"""Branch: the frozen record of one continuation run."""

from __future__ import annotations

import html
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from phichain.archive import (
    COUNT,
    NUMBER,
    TEXT,
    VALUES,
    Schema,
    complex_numbers,
    names,
    read_archive,
    real,
    whole,
    word,
)
from phichain.continuation.document import POSSIBLE, read_document, write_document
from phichain.continuation.met.specials import STATUS, Passage, Special
from phichain.continuation.problem import Multipliers
from phichain.errors import ArrayError
from phichain.records import Shown, columns_of, write_csv, write_npz
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
    "error": real("m", optional=True),
    "momentum": real("m", optional=True),
    "states": real("m", "nx", optional=True),
}
_EVENTS = {
    "index": whole("events"),
    "z": real("events", "unknowns"),
    "arclength": real("events"),
    "value": real("events"),
    "multipliers": complex_numbers("events", "exponents", optional=True),
    "state": real("events", "nx", optional=True),
}
_PASSAGES = {
    "z": real("passages", "unknowns", optional=True),
    "arclength": real("passages", optional=True),
    "width": real("passages", optional=True),
    "is_crossed": real("passages", optional=True),
}
_PLAIN = {
    "name": TEXT,
    "names": names("unknowns"),
    "status": word(*STATUS),
    "reason": TEXT,
}
_ABOUT = {
    "scene": replace(TEXT, default=""),
    "digest": replace(TEXT, default=""),
    "method": replace(TEXT, default=""),
    "closing": replace(TEXT, default=""),
    "mode": replace(COUNT, default=0),
    "regular": replace(COUNT, default=0),
    "step": replace(NUMBER, default=0.0),
    "tol": replace(NUMBER, default=0.0),
    "p": VALUES,
}
_SCHEMA = Schema(
    "Branch",
    {
        **_ARRAYS,
        **{f"event_{name}": array for name, array in _EVENTS.items()},
        **{f"passage_{name}": array for name, array in _PASSAGES.items()},
    },
    {
        **_PLAIN,
        **_ABOUT,
        "event_kinds": names("events", counted=True),
        "event_breaks": replace(names("events"), default=[]),
        "event_continues": replace(names("events"), default=[]),
    },
    filled=("m", "unknowns"),
)


@dataclass(frozen=True, eq=False, repr=False)
class Branch(Shown):
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
        status: "event" (a terminal one), "closed", "points", "step" (it needed a step below step_min) or "interrupted".
        reason: The same in words.
        error: What the method believes to be wrong with every point (m,), relative; None where it cannot say.
        passages: The avoided crossings it met, in order.
        scene: Name of the scene that it belongs to.
        digest: The scene's digest.
        method: How it was traced.
        closing: Which kind of orbits it is of, where it was traced by shooting: "quarter" (brake orbits), "unequal", "odd", "half" or "whole"
            (`orbits.closed.kinds`); it says what the unknowns of a start are.
        mode: Number of the linear mode it started from; 0 for none.
        regular: How many of the points are the run's own; what follows them is where it was cut by a terminal event.
        step: The step that the run would have tried from the last of its own points.
        tol: Newton's tolerance (`Options.tol`); 0 in files from before it was kept.
        momentum: Angular momentum about the vertical (m,), kg m^2/s; None where it is not conserved or zero all along.
        states: States (q, v) (m, nx) that the unknowns stand for; None where they are a configuration at rest, and omega.
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
    error: Vector | None = None
    passages: tuple[Passage, ...] = ()
    scene: str = ""
    digest: str = ""
    method: str = ""
    closing: str = ""
    mode: int = 0
    regular: int = 0
    step: float = 0.0
    momentum: Vector | None = None
    states: Vector | None = None
    tol: float = 0.0

    def __len__(self) -> int:
        return len(self.points)

    def __str__(self) -> str:
        lines = [f"{self.name}: {len(self)} points, arclength {self.arclength[-1]:.6g}; {self.reason}"]
        lines += [
            f"  {event.kind} at s = {event.arclength:.6g}: "
            + ", ".join(f"{name} = {value:.9g}" for name, value in zip(self.names, event.z, strict=True))
            for event in self.events
        ]
        lines += [
            f"  gap {'crossed' if gap.is_crossed else 'followed'} at s = {gap.arclength:.6g}, half width {gap.width:.3g}: "
            + ", ".join(f"{name} = {value:.9g}" for name, value in zip(self.names, gap.z, strict=True))
            for gap in self.passages
        ]
        return "\n".join(lines)

    @property
    def own_events(self) -> tuple[Special, ...]:
        """The events of the family itself, without the one that ended the run."""
        return self.events[:-1] if self.status == "event" else self.events

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
        if self.momentum is not None:
            columns["momentum"] = self.momentum
        if self.error is not None:
            columns["error"] = self.error
        columns |= {"residual": self.residual, "iterations": self.iterations}
        for k, values in enumerate(self.multipliers.T, 1):
            columns |= {f"multiplier_{k}_re": values.real, f"multiplier_{k}_im": values.imag}
        return write_csv(path, columns, self)

    def events_to_csv(self, path: Path | str) -> Path:
        """Write one row per event: kind, arclength, the unknowns, what it breaks, what continues, multipliers; 17 digits."""
        columns: dict[str, Any] = {"kind": [event.kind for event in self.events], "arclength": [event.arclength for event in self.events]}
        columns |= columns_of(self.names, np.array([event.z for event in self.events]).reshape(-1, len(self.names)))
        columns |= {name: [getattr(event, name) for event in self.events] for name in ("breaks", "continues")}
        for k in range(self.multipliers.shape[1]):
            values = np.array([event.multipliers[k] for event in self.events], complex)
            columns |= {f"multiplier_{k + 1}_re": values.real, f"multiplier_{k + 1}_im": values.imag}
        return write_csv(path, columns, self)

    def _repr_html_(self) -> str:
        """What a notebook shows: the run in a line, its events as a table."""
        head = "".join(f"<th>{html.escape(name)}</th>" for name in ("", "event", *self.names, "breaks", "continues"))
        rows = ""
        for number, event in enumerate(self.events, 1):
            cells = (str(number), event.kind, *(f"{value:.10g}" for value in event.z), event.breaks, event.continues)
            rows += f"<tr>{''.join(f'<td>{html.escape(cell)}</td>' for cell in cells)}</tr>"
        said = html.escape(f"{self.name}: {len(self)} points, arclength {self.arclength[-1]:.6g}; {self.reason}")
        return f"<p>{said}</p><table><tr>{head}</tr>{rows}</table>"

    def to_npz(self, path: Path | str) -> Path:
        """Write the whole record; `from_npz` reads it back."""
        arrays = {name: getattr(self, name) for name in _ARRAYS if getattr(self, name) is not None}
        for name, wanted in _EVENTS.items():
            values = [getattr(event, name) for event in self.events]
            if not (wanted.is_optional and (not values or any(value is None for value in values))):
                arrays[f"event_{name}"] = np.array(values, wanted.dtype)
        for name, wanted in _PASSAGES.items():
            if self.passages:
                arrays[f"passage_{name}"] = np.array([getattr(gap, name) for gap in self.passages], wanted.dtype)
        meta = {name: getattr(self, name) for name in _PLAIN} | {"event_kinds": [event.kind for event in self.events]}
        said = {name: getattr(self, name) for name in _ABOUT}
        for name in ("breaks", "continues"):
            words = [getattr(event, name) for event in self.events]
            said[f"event_{name}"] = words if any(words) else []
        # What a method does not say is not written.
        meta |= {name: value for name, value in said.items() if value}
        return write_npz(path, arrays, meta | {"kind": _SCHEMA.kind})

    def to_json(self, path: Path | str) -> Path:
        """Write what programs of other kinds read (`document`), 17 digits; `from_json` reads it, and runs go on from it."""
        return write_document(self, path)

    @classmethod
    def from_json(cls, path: Path | str) -> Branch:
        """Read what `to_json` wrote.

        Raises:
            OutputError: The file is missing, cut short, or holds no Branch, or numbers that none can have.
        """
        return POSSIBLE.demand(path, cls(**read_document(path)))

    @classmethod
    def from_npz(cls, path: Path | str) -> Branch:
        """Read what `to_npz` wrote.

        Raises:
            OutputError: The file is missing or holds no Branch, not a whole one, or numbers that none can have.
        """
        arrays, meta = read_archive(path, _SCHEMA)
        for name, count in (("multipliers", len(arrays["points"])), ("event_multipliers", len(meta["event_kinds"]))):
            arrays.setdefault(name, np.zeros((count, 0), complex))  # files from before there were any hold none
        parts = [arrays[f"event_{name}"] for name in _EVENTS if name != "state"]
        states = arrays.get("event_state", [None] * len(meta["event_kinds"]))
        # Files from before events said what they break say nothing.
        words = ([*meta[name], *[""] * (len(meta["event_kinds"]) - len(meta[name]))] for name in ("event_breaks", "event_continues"))
        events = tuple(
            Special(kind, int(index), z, float(s), float(value), multipliers, *said)
            for kind, index, z, s, value, multipliers, *said in zip(meta["event_kinds"], *parts, *words, states, strict=True)
        )
        gaps = zip(*(arrays.get(f"passage_{name}", ()) for name in _PASSAGES), strict=True)
        passages = tuple(Passage(z, float(s), float(width), bool(crossed)) for z, s, width, crossed in gaps)
        plain = {name: meta[name] for name in (*_PLAIN, *_ABOUT)} | {"names": tuple(meta["names"])}
        held: dict[str, Any] = {name: arrays.get(name) for name in _ARRAYS}
        return POSSIBLE.demand(path, cls(**plain, **held, events=events, passages=passages))
