"""Trajectory: the frozen record of one simulation."""

from __future__ import annotations

import copy
import dataclasses
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import BPoly

from phichain.archive import COUNTS, NUMBER, TEXT, VALUES, Schema, names, read_archive, real, word
from phichain.errors import ArrayError
from phichain.motion.events import Crossing, marked
from phichain.records import Later, Shown, columns_of, write_csv, write_npz
from phichain.system import Vector
from phichain.system.arrays import reals

_NONE = type(None)
"""Makes the default of a field that may be computed later: a default in the class would stand in its way."""
_ARRAYS = {
    "t": real("m"),
    "q": real("m", "nq"),
    "v": real("m", "nv"),
    "a": real("m", "nv"),
    "u": real("m", "nu", optional=True),
    "kinetic": real("m", optional=True),
    "potential": real("m", optional=True),
    "length_error": real("m", "links", optional=True),
    "tangency_error": real("m", "links", optional=True),
    "work": real("m", optional=True),
    "loss": real("m", optional=True),
    "error": real("m", optional=True),
    "lengths": real("nq", optional=True),
}
_PLAIN = {
    "name": TEXT,
    "space": word("planar", "spatial"),
    "method": TEXT,
    "status": TEXT,
    "reason": TEXT,
    "tol": NUMBER,
    "q_names": names("nq"),
    "v_names": names("nv"),
    "u_names": names("nu"),
    "holds_until": dataclasses.replace(NUMBER, default=math.nan),
    "angles": dataclasses.replace(word("", "relative", "absolute", "adjacent"), default=""),
    "digest": dataclasses.replace(TEXT, default=""),
    "p": VALUES,
}
_SCHEMA = Schema(
    "Trajectory",
    {**_ARRAYS, "event_t": real("events"), "event_x": real("events", "nq+nv")},
    {**_PLAIN, "counts": COUNTS, "event_names": names("events", counted=True)},
    filled=("m",),
)


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory(Later, Shown):
    """What a simulation found, and how.

    Accelerations, energies and the verdict (status, reason, error, holds_until, events; perhaps by a second run) are computed when first read.

    Attributes:
        name: Name of the system.
        space: "planar" or "spatial".
        t: Times (m,), s.
        q: Configurations (m, nq).
        v: Rates (m, nv).
        a: Accelerations v' (m, nv).
        u: Inputs (m, nu), or None without inputs.
        kinetic: Kinetic energy (m,), J, or None when the system has no `energy`.
        potential: Potential energy (m,), J, zero as in section 1 of docs/theory.md, or None.
        length_error: Spatial: |q_k| - 1, (m, N); else None. Recorded before any projection.
        tangency_error: Spatial: omega_k . q_k, rad/s, (m, N); else None. Recorded before any projection.
        events: Located crossings in order.
        method: The method that ran.
        status: "complete", "doubtful" (complete, but see `reason`), "event" (a terminal event ended it), "step budget"; an error
            carries "blow-up" or "stalled".
        reason: Why this method, what was done to the arguments, why it ended.
        tol: Relative tolerance used; NaN for fixed steps.
        counts: Accepted steps, evaluations of the right-hand side and of its Jacobian, as far as the method counts.
        q_names, v_names, u_names: Column names.
        work: What the inputs did on the chain from the start (m,), J; None where nothing is done or lost, or no energy known.
        loss: What dampers took from it from the start (m,), J; None likewise.
        error: Estimated error of the state (m,): the max norm of the error of q over what |q| reaches, one at most, or of v over
            what |v| reaches, if that is larger. Twice what a more accurate run says, or what rounding makes of the Taylor flow at
            round-off; once half as large as the motion it only says how far the motion has come by then. None for laws that sample, or unasked.
        holds_until: The last of t up to which no error is above what was asked lets expect: four times the tolerance of `auto`; 1e4
            times that of a named method, 1e-2 at most; 1e-4 of the Taylor flow at round-off; 1e-2 of fixed steps. NaN without `error`.
        lengths: Length of the link that each entry of q belongs to (nq,), m, 0 for a cart's: by these a chain is drawn. None where unknown.
        angles: What planar angles are measured from, by the same token; empty in space.
        digest: Canonical digest of the system's scene; empty for a system that was made by hand.
        refine: Builds the Trajectory of the same run at other times from the method's own interpolant; only when
            the outputs were the method's own steps, and kept neither in files nor in pickles.
    """

    name: str
    space: str
    t: Vector
    q: Vector
    v: Vector
    a: Vector
    u: Vector | None
    kinetic: Vector | None
    potential: Vector | None
    length_error: Vector | None
    tangency_error: Vector | None
    events: tuple[Crossing, ...]
    method: str
    status: str
    reason: str
    tol: float
    counts: Mapping[str, int]
    q_names: tuple[str, ...] = ()
    v_names: tuple[str, ...] = ()
    u_names: tuple[str, ...] = ()
    work: Vector | None = field(default_factory=_NONE)
    loss: Vector | None = field(default_factory=_NONE)
    error: Vector | None = field(default_factory=_NONE)
    holds_until: float = field(default_factory=lambda: math.nan)
    lengths: Vector | None = field(default_factory=_NONE)
    angles: str = ""
    digest: str = ""
    refine: Callable[[Vector], Trajectory] | None = field(default=None, repr=False)

    def __getstate__(self) -> dict[str, Any]:
        # The interpolant is a method's own, made of callables; files leave it out as well.
        return {**super().__getstate__(), "refine": None}

    def __deepcopy__(self, memo: dict[int, Any]) -> Trajectory:
        return dataclasses.replace(self, **{name: copy.deepcopy(getattr(self, name), memo) for name in _ARRAYS})

    def __str__(self) -> str:
        counts = ", ".join(f"{value} {name}" for name, value in self.counts.items())
        off = "" if self.error is None else f", estimated error {self.error[-1]:.1e}, holds until t = {self.holds_until:g} s"
        drift = "" if self.energy is None else f", {self.energy_words}"
        return (
            f"{self.name}: {self.status}, t = {self.t[0]:g} .. {self.t[-1]:g} s in {len(self.t)} points by "
            f"{self.method} ({counts}){drift}{off}\n  {self.reason}"
        )

    @property
    def x(self) -> Vector:
        """States (q, v), shape (m, nq + nv)."""
        return np.concatenate([self.q, self.v], axis=1)

    @property
    def energy(self) -> Vector | None:
        """Total energy (m,), J, or None."""
        return None if self.kinetic is None or self.potential is None else self.kinetic + self.potential

    @property
    def energy_drift(self) -> float:
        """Largest departure of the total energy from its first value, J; NaN when no energy was recorded."""
        return float("nan") if self.energy is None else float(np.max(np.abs(self.energy - self.energy[0])))

    @property
    def balance(self) -> Vector | None:
        """E(t) - E(0) - work + loss (m,), J: what an exact integration leaves at zero; None when no energy was recorded."""
        if self.energy is None:
            return None
        moved = self.energy - self.energy[0]
        return moved if self.work is None or self.loss is None else moved - (self.work - self.work[0]) + (self.loss - self.loss[0])

    @property
    def balance_error(self) -> float:
        """Largest departure of the balance from zero, J; NaN when no energy was recorded."""
        return float("nan") if self.balance is None else float(np.max(np.abs(self.balance)))

    @property
    def energy_words(self) -> str:
        """How well the energy's books were kept, in words: by its drift where nothing is done or lost, else by the balance."""
        if self.work is None or self.loss is None:
            return f"energy drift {self.energy_drift:.2e} J"
        return f"energy balance kept to {self.balance_error:.2e} J (work {self.work[-1]:.3g} J, loss {self.loss[-1]:.3g} J)"

    def resample(self, times: int | ArrayLike) -> Trajectory:
        """The same motion at other times, for tools that need a uniform grid.

        With the method's own interpolant at hand (outputs were its own steps) everything is evaluated anew from
        it. Else q is interpolated by quintics through (q, q', q'') and v by cubics through (v, a), which hold to
        the sixth and fourth power of the spacing; inputs and energies between samples are then not known (None).

        Args:
            times: A number of equally spaced points from start to end, or the times themselves.

        Raises:
            ArrayError: Fewer than two points, or times outside the trajectory.
        """
        grid = self._grid(times)
        if self.refine is not None:
            return self.refine(grid)
        q_dot, q_ddot = self._rates()
        order = np.argsort(self.t)
        quintic = BPoly.from_derivatives(self.t[order], np.stack([self.q, q_dot, q_ddot], axis=1)[order])
        cubic = BPoly.from_derivatives(self.t[order], np.stack([self.v, self.a], axis=1)[order])
        q, planar = quintic(grid), self.space == "planar"
        return dataclasses.replace(
            self,
            t=grid,
            q=q,
            v=quintic(grid, 1) if planar else cubic(grid),
            a=quintic(grid, 2) if planar else cubic(grid, 1),
            u=None,
            kinetic=None,
            potential=None,
            length_error=None,
            tangency_error=None,
            work=None,
            loss=None,
            error=None if self.error is None else between(grid, self.t, self.error),
            reason=f"{self.reason}; resampled by quintic (q) and cubic (v) Hermite pieces between {len(self.t)} outputs",
        )

    def _grid(self, times: int | ArrayLike) -> Vector:
        if isinstance(times, int | np.integer):
            if times < 2:
                raise ArrayError("times", times, "a trajectory needs two points", "ask for two or more")
            return np.linspace(self.t[0], self.t[-1], int(times))
        grid = np.atleast_1d(reals("times", times, "give times in s"))
        if grid.ndim != 1 or not grid.size:
            raise ArrayError("times", grid.shape, "is no list of times", "give them one after the other")
        low, high = min(self.t[0], self.t[-1]), max(self.t[0], self.t[-1])
        if not np.all((grid >= low) & (grid <= high)):
            raise ArrayError(
                "times", grid, f"leave the trajectory's span {low:g} .. {high:g} s", "stay within it"
            )
        return grid

    def _rates(self) -> tuple[Vector, Vector]:
        """q' and q'' at the outputs."""
        if self.space == "planar":
            return self.v, self.a
        links = 3 * (self.q.shape[1] // 3)
        cart = self.q.shape[1] - links

        def triples(stacked: Vector) -> Vector:
            return stacked[:, cart:].reshape(len(stacked), -1, 3)

        directions, rates = triples(self.q), triples(self.v)
        moving = np.cross(rates, directions)
        turning = np.cross(triples(self.a), directions) + np.cross(rates, moving)
        flat = (len(self.t), links)
        q_dot = np.concatenate([self.v[:, :cart], moving.reshape(flat)], axis=1)
        return q_dot, np.concatenate([self.a[:, :cart], turning.reshape(flat)], axis=1)

    def to_csv(self, path: Path | str) -> Path:
        """Write one row per output: t, q, v, u, energies, largest constraint violations, estimated error; 17 digits."""
        columns: dict[str, Any] = {"t": self.t, **columns_of(self.q_names, self.q), **columns_of(self.v_names, self.v)}
        columns |= columns_of(self.u_names, self.u)
        columns |= {
            name: getattr(self, name) for name in ("kinetic", "potential", "work", "loss") if getattr(self, name) is not None
        }
        for name in ("length_error", "tangency_error"):
            if getattr(self, name) is not None:
                columns[name] = np.max(np.abs(getattr(self, name)), axis=1)
        if self.error is not None:
            columns["error"] = self.error
        return write_csv(path, columns, self)

    def to_npz(self, path: Path | str) -> Path:
        """Write everything but `refine`; `from_npz` reads it back."""
        arrays = {name: getattr(self, name) for name in _ARRAYS if getattr(self, name) is not None}
        arrays["event_t"] = np.array([crossing.t for crossing in self.events])
        arrays["event_x"] = np.array([crossing.x for crossing in self.events])
        meta = {name: getattr(self, name) for name in _PLAIN}
        meta |= {
            "kind": _SCHEMA.kind,
            "counts": dict(self.counts),
            "event_names": [crossing.name for crossing in self.events],
        }
        return write_npz(path, arrays, meta)

    @classmethod
    def from_npz(cls, path: Path | str) -> Trajectory:
        """Read what `to_npz` wrote.

        Raises:
            OutputError: The file is missing or holds no Trajectory, or not a whole one.
        """
        arrays, meta = read_archive(path, _SCHEMA)
        found = zip(meta.pop("event_names"), arrays.pop("event_t"), arrays.pop("event_x"), strict=True)
        events = marked((Crossing(name, float(t), x) for name, t, x in found), arrays["t"], meta["holds_until"])
        columns: dict[str, Any] = {key: tuple(meta.pop(key)) for key in ("q_names", "v_names", "u_names")}
        held: dict[str, Any] = {name: arrays.get(name) for name in _ARRAYS}
        return cls(**held, events=events, **columns, **meta)


def between(times: Vector, t: Vector, values: Vector) -> Vector:
    """Values at other times, on straight lines between those at t, which may run backwards."""
    way = 1 if t[-1] >= t[0] else -1
    found: Vector = np.interp(way * times, way * t, values)
    return found
