"""Response: the frozen record of a chain's periodic motions under A cos(omega t), point by point along omega, with files and numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from phichain.archive import (
    COUNT,
    NUMBER,
    TEXT,
    VALUES,
    Part,
    Possible,
    Schema,
    complex_numbers,
    names,
    read_archive,
    real,
    whole,
    word,
)
from phichain.continuation.document import pairs, reading_document, values_of
from phichain.continuation.met.specials import STATUS
from phichain.errors import ArrayError
from phichain.orbits.forced.checkpoint import Checkpoint, checkpoint_of
from phichain.reading import text_of
from phichain.records import Held, Shown, columns_of, write_csv, write_json, write_npz
from phichain.system import Vector

_ARRAYS: Final = {
    "omega": real("m"),
    "q": real("m", "n"),
    "v": real("m", "n"),
    "peak": real("m", "n"),
    "first": complex_numbers("m", "n"),
    "multipliers": complex_numbers("m", "k"),
    "error": real("m"),
    "residual": real("m"),
    "arclength": real("m"),
}
_EVENTS: Final = {
    "after": whole("events"),
    "omega": real("events"),
    "q": real("events", "n"),
    "v": real("events", "n"),
    "peak": real("events", "n"),
    "multipliers": complex_numbers("events", "k"),
}
_TEXTS: Final = ("name", "scene", "digest", "forced", "place", "unit", "method", "status", "reason")
_SCHEMA: Final = Schema(
    "Response",
    {**_ARRAYS, **{f"event_{name}": array for name, array in _EVENTS.items()}},
    {
        **{name: TEXT for name in _TEXTS if name != "status"}, "status": word(*STATUS), "amplitude": NUMBER, "periods": replace(COUNT, default=1), "names": names("n"), "p": VALUES, "tol": replace(NUMBER, default=0.0),
        "event_kinds": names("events", counted=True), "event_breaks": names("events"), "event_continues": names("events"),
    },
    filled=("m", "n"),
)  # fmt: skip
_SAID: Final = ("amplitude", "periods", "tol", "p")
_MET: Final = (("positive", "omega"), ("finite", "q"), ("finite", "v"), ("finite", "peak"))
_POSSIBLE: Final = Possible(
    ("q", "v", "peak", "first", "arclength", "amplitude"), ("omega", "periods"), ("residual", "tol"),
    more=lambda found: ((rule, Part(f"events[{k}].{name}", getattr(event, name))) for k, event in enumerate(found.events) for rule, name in _MET),
)  # fmt: skip
_STABLE: Final = 1e-9
"""How far beyond 1 rounding may put a multiplier."""


@dataclass(frozen=True, eq=False)
class ResponseEvent(Held):
    """A located event of a response.

    Attributes:
        kind: "fold", "symmetry breaking", "period doubling", "neimark-sacker", "branch point", or what ended the run.
        after: It lies between the points `after` and `after + 1`.
        omega: rad/s.
        q: Configuration at phase zero (n,).
        v: Rates there (n,).
        peak: Largest |q_k - mean| over the period (n,).
        multipliers: Those of the period (k,).
        breaks: What it breaks, in words.
        continues: What goes on beyond it, in words.
    """

    kind: str
    after: int
    omega: float
    q: Vector
    v: Vector
    peak: Vector
    multipliers: np.ndarray
    breaks: str = ""
    continues: str = ""


@dataclass(frozen=True, eq=False, repr=False)
class Response(Shown):
    """The periodic motions of a driven chain along the forcing's frequency.

    Attributes:
        name: What was followed.
        scene: Name of the scene.
        digest: The scene's digest.
        forced: The joint, "cart" or "base".
        place: The same in words.
        unit: Unit of the forcing's amplitude.
        amplitude: A of A cos(omega t).
        method: "harmonics" or "shooting".
        names: Names of the coordinates (n,).
        omega: Frequency of the forcing (m,), rad/s.
        q: Configuration at phase zero (m, n).
        v: Rates there (m, n).
        peak: Largest |q_k - mean| over the period (m, n).
        first: First harmonic of every coordinate (m, n): q_k = Re(first e^(i omega t)) + ..; its angle is the phase against the forcing.
        multipliers: Floquet multipliers of the period (m, k); a cart's place has none.
        error: What the method believes to be wrong (m,): the tail of the spectrum, or Newton's last correction of shooting.
        residual: Relative residual (m,).
        arclength: Along the branch (m,).
        events: Located events in order; the last one is what ended the run where status is "event".
        status: As of a Branch.
        reason: The same in words.
        periods: How many periods of the forcing a motion takes to come back: 2, 4, .. beyond period doublings.
        tol: Newton's tolerance; 0 in files from before it was kept.
        checkpoint: Where the run stands, to be gone on with; None of what was read from .npz.
    """

    name: str
    scene: str
    digest: str
    forced: str
    place: str
    unit: str
    amplitude: float
    method: str
    names: tuple[str, ...]
    omega: Vector
    q: Vector
    v: Vector
    peak: Vector
    first: np.ndarray
    multipliers: np.ndarray
    error: Vector
    residual: Vector
    arclength: Vector
    events: tuple[ResponseEvent, ...]
    status: str
    reason: str
    periods: int = 1
    tol: float = 0.0
    checkpoint: Checkpoint | None = None

    def __len__(self) -> int:
        return len(self.omega)

    def __str__(self) -> str:
        stable = int(np.sum(self.stable))
        lines = [f"{self.name}: {len(self)} points, {stable} of them stable; {self.reason}"]
        for event in self.events:
            peaks = ", ".join(f"peak {name} = {value:.9g}" for name, value in zip(self.names, event.peak, strict=True))
            lines.append(f"  {event.kind} at omega = {event.omega:.12g}: {peaks}")
        return "\n".join(lines)

    @property
    def stable(self) -> np.ndarray:
        """Whether no multiplier lies outside the unit circle (m,)."""
        return np.asarray(np.max(np.abs(self.multipliers), axis=1, initial=0.0) <= 1 + _STABLE)

    def located(self, kind: str) -> tuple[ResponseEvent, ...]:
        """The events of one kind, in order."""
        return tuple(event for event in self.events if event.kind == kind)

    def column(self, name: str) -> Vector:
        """The peaks (m,) of one coordinate.

        Raises:
            ArrayError: No coordinate has that name.
        """
        if name not in self.names:
            raise ArrayError("name", name, "is no coordinate of this response", f"use one of {', '.join(self.names)}")
        return self.peak[:, self.names.index(name)]

    def to_csv(self, path: Path | str) -> Path:
        """One row per point: omega, peaks, first harmonics with their phases, stability, errors; 17 digits."""
        columns: dict[str, Any] = {
            "omega": self.omega, **columns_of([f"peak_{name}" for name in self.names], self.peak),
            **columns_of([f"first_{name}" for name in self.names], np.abs(self.first)),
            **columns_of([f"phase_{name}" for name in self.names], np.angle(self.first)),
            **columns_of([f"{name}_0" for name in self.names], self.q), **columns_of([f"{name}_dot_0" for name in self.names], self.v),
            "stable": self.stable.astype(int), "error": self.error, "residual": self.residual, "arclength": self.arclength,
        }  # fmt: skip
        for k, values in enumerate(self.multipliers.T, 1):
            columns |= {f"multiplier_{k}_re": values.real, f"multiplier_{k}_im": values.imag}
        return write_csv(path, columns, self)

    def to_npz(self, path: Path | str) -> Path:
        """The whole record; `from_npz` reads it back."""
        arrays: dict[str, Any] = {name: getattr(self, name) for name in _ARRAYS}
        for name, wanted in _EVENTS.items():
            shape = (0, *arrays[name].shape[1:]) if name in arrays else (0,)
            values = [getattr(event, name) for event in self.events]
            arrays[f"event_{name}"] = np.array(values, wanted.dtype) if values else np.zeros(shape, wanted.dtype)
        return write_npz(path, arrays, self._said() | {"kind": _SCHEMA.kind})

    @classmethod
    def from_npz(cls, path: Path | str) -> Response:
        """Read what `to_npz` wrote.

        Raises:
            OutputError: The file is missing or holds no Response, or not a whole one.
        """
        arrays, meta = read_archive(path, _SCHEMA)
        rows = zip(meta["event_kinds"], *(arrays[f"event_{name}"] for name in _EVENTS), meta["event_breaks"], meta["event_continues"], strict=True)
        events = tuple(
            ResponseEvent(kind, int(after), float(omega), q, v, peak, multipliers, breaks, continues)
            for kind, after, omega, q, v, peak, multipliers, breaks, continues in rows
        )
        held: dict[str, Any] = {name: meta[name] for name in _TEXTS} | {name: arrays[name] for name in _ARRAYS}
        held |= {"amplitude": float(meta["amplitude"]), "periods": int(meta["periods"]), "names": tuple(meta["names"]), "p": meta["p"], "tol": meta["tol"]}
        return _POSSIBLE.demand(path, cls(**held, events=events))

    def _said(self) -> dict[str, Any]:
        return {
            **{name: getattr(self, name) for name in (*_TEXTS, *_SAID)}, "names": list(self.names), "event_kinds": [event.kind for event in self.events], "event_breaks": [event.breaks for event in self.events],
            "event_continues": [event.continues for event in self.events],
        }  # fmt: skip

    def to_json(self, path: Path | str) -> Path:
        """What programs of other kinds read, 17 digits; `from_json` reads it back, and runs go on from it."""
        points = [
            {
                "start": {"q": self.q[k].tolist(), "v": self.v[k].tolist()}, "omega": float(self.omega[k]), "peak": self.peak[k].tolist(),
                "first": pairs(self.first[k]), "multipliers": pairs(self.multipliers[k]), "stable": bool(self.stable[k]),
                "error": float(self.error[k]) if math.isfinite(self.error[k]) else None, "residual": float(self.residual[k]),
                "arclength": float(self.arclength[k]),
            }
            for k in range(len(self))
        ]  # fmt: skip
        events = [
            {
                "kind": event.kind, "breaks": event.breaks, "start": {"q": event.q.tolist(), "v": event.v.tolist()}, "omega": event.omega,
                "peak": event.peak.tolist(), "multipliers": pairs(event.multipliers), "continues": event.continues, "after": event.after,
            }
            for event in self.events
        ]  # fmt: skip
        said = {name: getattr(self, name) for name in (*_TEXTS, *_SAID)}
        stands = {} if self.checkpoint is None else {"checkpoint": self.checkpoint.document()}
        return write_json(path, "response", {**said, "names": list(self.names), "points": points, "events": events, **stands})

    @classmethod
    def from_json(cls, path: Path | str) -> Response:
        """Read what `to_json` wrote.

        Raises:
            OutputError: The file is missing, cut short, or holds no Response.
        """
        return _POSSIBLE.demand(path, cls(**reading_document(path, "response", lambda found: _fields(found, path))))


def _fields(found: Mapping[str, Any], path: Path | str) -> dict[str, Any]:
    rows, m, n = found["points"], len(found["points"]), len(found["names"])
    if not rows or found["status"] not in STATUS:
        raise ValueError("it has no points, or another status than a run ends with")

    def table(values: list[Any], *shape: int) -> Vector:
        array = np.array(values, dtype=float)
        if array.shape == shape:
            return array
        raise ValueError(f"an array has the shape {array.shape} instead of {shape}")

    events = tuple(
        ResponseEvent(
            text_of(row, "kind"), int(row["after"]), float(row["omega"]), table(row["start"]["q"], n), table(row["start"]["v"], n),
            table(row["peak"], n), _numbers(row["multipliers"]), text_of(row, "breaks"), text_of(row, "continues"),
        )
        for row in found["events"]
    )  # fmt: skip
    return {
        **{name: text_of(found, name) for name in _TEXTS}, "amplitude": float(found["amplitude"]), "periods": int(found.get("periods", 1)), "tol": float(found.get("tol", 0.0)), "p": values_of(found), "names": tuple(map(str, found["names"])),
        **{name: table([row[name] for row in rows], m) for name in ("omega", "residual", "arclength")},
        "error": np.array([math.nan if row["error"] is None else row["error"] for row in rows], float),
        "q": table([row["start"]["q"] for row in rows], m, n), "v": table([row["start"]["v"] for row in rows], m, n),
        "peak": table([row["peak"] for row in rows], m, n), "first": np.array([_numbers(row["first"]) for row in rows]),
        "multipliers": np.array([_numbers(row["multipliers"]) for row in rows]), "events": events,
        "checkpoint": checkpoint_of(found.get("checkpoint"), path, m, len(events)),
    }  # fmt: skip


def _numbers(rows: list[Any]) -> np.ndarray:
    return np.array([complex(real, imaginary) for real, imaginary in rows], dtype=complex)
