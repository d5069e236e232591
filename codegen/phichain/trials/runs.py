"""Any compiled law tried on chains with wrong parameters, late inputs and sensors that read in steps: how many runs end at the target and stay."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from phichain.archive import COUNT, NUMBER, TEXT, VALUES, Schema, names, read_archive, real, whole
from phichain.emit.law.loop import LATEST, Called
from phichain.errors import ArrayError, UnsupportedError
from phichain.native import default_cache
from phichain.records import Valued, columns_of, write_csv, write_npz
from phichain.scene import Scene
from phichain.trials.loop import Loop, Task, Vector
from phichain.trials.monte_carlo import sizes_of
from phichain.trials.share import interval_of

SLOW: Final = 0.05
"""Rate over which dry friction turns about, rad/s (m/s), where a scene has none of its own."""
ADDED: Final = ("damping", "friction", "cart_damping", "cart_friction")
"""Losses that may be added to a chain without them."""
CHUNK: Final = 4
"""Runs of one call, after which Ctrl-C is heard."""

_ARRAYS: Final = {
    "errors": real("n", "np"), "starts": real("n", "nx"), "ends": real("n", "nx"), "largest": real("n", "extremes"), "late": whole("n"),
    "settled": real("n"), "held": whole("n"),
}  # fmt: skip
_SCHEMA: Final = Schema(
    "Runs", _ARRAYS, {"name": TEXT, "digest": TEXT, "law": TEXT, "error_names": names("np"), "seconds": NUMBER, "hold": NUMBER, "seed": COUNT, "p": VALUES},
    filled=("n", "nx"),
)  # fmt: skip


def wanted(scene: Scene) -> tuple[str, ...]:
    """What a chain is stepped by: its accelerations, or in space, where states stay on a sphere, its own step."""
    return ("forward_dynamics",) if scene.is_planar else ("step",)


@dataclass(frozen=True)
class Disturbed:
    """What is wrong with the chain and its rig, each at most so much, drawn evenly for every run.

    Attributes:
        errors: Relative errors of parameters by name.
        added: Dampers and dry friction beyond those of the scene, by name, from none to so much; N m s/rad, N m.
        spread: Error of every angle at the start, rad; in space of either horizontal part of a link's direction, the sine of a tilt.
        late: Time by which inputs come late, s, in whole samples.
        resolution: Steps in which entries of the state are read, by name, the same in every run.
    """

    errors: Mapping[str, float] = field(default_factory=dict)
    added: Mapping[str, float] = field(default_factory=dict)
    spread: float = 0.05
    late: float = 0.0
    resolution: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Aim:
    """What a law is tried for.

    Attributes:
        start: Where runs begin but for their spread (nx,).
        target: Where they are to end (nx,).
        wraps: Entries whose deviation counts modulo a full turn.
        reads: Names of what the law measures (ny,).
        sample: From one call to the next, s.
        seconds: How long a run is.
        hold: How long the target must have been held at its end, s.
        near: How near every angle must be, rad (m), and in a swing time every rate; in space every part of a direction.
        swing: Swing time of the chain, s.
    """

    start: Vector
    target: Vector
    wraps: tuple[bool, ...]
    reads: tuple[str, ...]
    sample: float
    seconds: float
    hold: float = 2.0
    near: float = 0.05
    swing: float = 0.1


@dataclass(frozen=True, eq=False)
class Runs(Valued):
    """What became of every run.

    Attributes:
        name: The chain.
        digest: Its scene's digest.
        law: The law's function.
        error_names: Names of the numbers that were wrong (np,).
        errors: By how much, run by run (n, np): relative, or absolute of added losses.
        starts: Where they began (n, nx).
        ends: Where they ended (n, nx).
        largest: Largest distance of the first coordinate from 0 and of every input (n, 1 + nu).
        late: Samples by which inputs came late (n,).
        settled: When the target was reached and not left any more (n,), s; `seconds` where it never was.
        held: 1 where that was long enough before the end (n,).
        seconds: How long a run was.
        hold: How long before the end.
        seed: Of the draws.
    """

    name: str
    digest: str
    law: str
    error_names: tuple[str, ...]
    errors: Vector
    starts: Vector
    ends: Vector
    largest: Vector
    late: NDArray[np.int64]
    settled: Vector
    held: NDArray[np.int64]
    seconds: float
    hold: float
    seed: int

    @property
    def share(self) -> float:
        """Share of the runs that held the target."""
        return float(np.mean(self.held))

    @property
    def interval(self) -> tuple[float, float]:
        """95 % confidence interval of the share (Clopper and Pearson)."""
        return interval_of(self.held)

    def __str__(self) -> str:
        low, high = self.interval
        count, total = int(np.sum(self.held)), len(self.held)
        text = f"{self.law}: {count} of {total} runs reach and hold the target ({self.share:.1%}, 95 % interval {low:.1%} to {high:.1%})"
        if count:
            times = self.settled[self.held == 1]
            text += f"; settled after {np.median(times):.3g} s (median), {np.max(times):.3g} s at the latest"
        return text

    def to_csv(self, path: Path | str) -> Path:
        """Write one row a run."""
        columns = columns_of([f"error_{name}" for name in self.error_names], self.errors)
        columns |= columns_of(["farthest", *(f"largest_u_{k + 1}" for k in range(self.largest.shape[1] - 1))], self.largest)
        return write_csv(path, {**columns, "late": self.late, "settled": self.settled, "held": self.held}, self)

    def to_npz(self, path: Path | str) -> Path:
        """Write the whole record; `from_npz` reads it back."""
        meta = {"name": self.name, "digest": self.digest, "law": self.law, "error_names": list(self.error_names), "seconds": self.seconds,
                "hold": self.hold, "seed": self.seed, "p": self.p}  # fmt: skip
        return write_npz(path, {name: getattr(self, name) for name in _ARRAYS}, meta | {"kind": _SCHEMA.kind})

    @classmethod
    def from_npz(cls, path: Path | str) -> Runs:
        """Read what `to_npz` wrote.

        Raises:
            OutputError: The file is missing, or holds no Runs, or not a whole one.
        """
        arrays, meta = read_archive(path, _SCHEMA)
        known: dict[str, Any] = {**arrays, **meta, "error_names": tuple(meta["error_names"])}
        return cls(**{name: known[name] for name in cls.__dataclass_fields__})


@dataclass(frozen=True)
class Rigged:
    """A law on a chain whose parameters are open, compiled.

    Attributes:
        loop: Both.
        scene: The chain as it is meant.
        aim: What the law is tried for.
        names: Names of what is drawn, one for each number of the struct.
        nominal: The numbers (np,).
        scale: What a draw between -1 and 1 is multiplied by, relative errors of the nominal numbers (np,).
        added: Largest added losses (np,).
        disturbed: What is wrong.
    """

    loop: Loop
    scene: Scene
    aim: Aim
    names: tuple[str, ...]
    nominal: Vector
    scale: Vector
    added: Vector
    disturbed: Disturbed

    @classmethod
    def of(cls, scene: Scene, law: Called, sources: Mapping[str, str], aim: Aim, disturbed: Disturbed) -> Rigged:
        """Compile a law together with a chain whose wrong parameters are open.

        Raises:
            UnsupportedError: A chain with runtime parameters.
            SceneError: A name is no parameter, or an error is none.
            ArrayError: A delay is too long, a name is nothing that is measured, or a number is none.
        """
        if scene.runtime:
            raise UnsupportedError("scene", scene.name, "has numbers that are known at run time alone", "write them into the scene")
        values: dict[str, Any] = {}
        for name in {**disturbed.errors, **disturbed.added}:
            given = getattr(scene, name, None) if name in Scene.__dataclass_fields__ else None
            if given is None and name in disturbed.added:
                given = 0.0 if name.startswith("cart") else (0.0,) * scene.links
            if isinstance(given, float | int | tuple) and not isinstance(given, bool):
                values[name] = given
        speeds = {speed: SLOW for name, speed in (("friction", "friction_speed"), ("cart_friction", "cart_friction_speed"))
                  if name in values and getattr(scene, speed) is None}  # fmt: skip
        changes: dict[str, Any] = {**dict.fromkeys(values, "runtime"), **speeds}
        opened = replace(scene, real="double", want=wanted(scene), variational=False, **changes)
        scale = sizes_of(opened, disturbed.errors)
        for name, size in disturbed.added.items():
            if name not in ADDED or not 0 <= size < np.inf:
                raise ArrayError("added", {name: size}, "is no loss that can be added", f"name one of {', '.join(ADDED)}, with a number")
        nominal, added, labels = [], [], []
        for name, shape in opened.runtime_shapes.items():
            row = np.broadcast_to(np.asarray(values[name], dtype=float), shape).ravel()
            nominal.append(row)
            added.append(np.full(row.size, disturbed.added.get(name, 0.0)))
            labels += [name] if not shape else [f"{name}_{k + 1}" for k in range(row.size)]
        if not 0 <= disturbed.late / aim.sample <= LATEST or not 0 <= disturbed.spread < np.pi:
            raise ArrayError("late, spread", (disturbed.late, disturbed.spread), "are no delay and no error of an angle",
                             f"give at most {LATEST} samples, and radians")  # fmt: skip
        from phichain.scratch import library_texts

        loop = Loop.of(opened, library_texts(opened, False, default_cache()), law, sources)
        none = [np.zeros(0)]
        return cls(loop, scene, aim, tuple(labels), np.concatenate(none + nominal), scale, np.concatenate(none + added), disturbed)

    def _starts(self, drawn: Vector) -> Vector:
        """States at rest around the start (n, nx), from numbers between -1 and 1 (n, nx)."""
        start, spread = self.aim.start, self.disturbed.spread
        if self.scene.is_planar:
            return np.asarray(start + spread * np.array(self.aim.wraps) * drawn)
        cart = len(start) // 2 - 3 * self.scene.links
        x = np.tile(start, (len(drawn), 1))
        q = x[:, cart : len(start) // 2].reshape(len(x), -1, 3)
        tilts = spread * drawn[:, cart : len(start) // 2].reshape(q.shape)[..., :2]
        # No more than level.
        tilts /= np.maximum(1.0, np.linalg.norm(tilts, axis=-1, keepdims=True))
        upright = np.sign(q[..., 2]) * np.sqrt(np.maximum(0.0, 1 - np.sum(tilts**2, axis=-1)))
        x[:, cart : len(start) // 2] = np.concatenate([tilts, upright[..., None]], axis=-1).reshape(len(x), -1)
        return x

    def task(self, state_names: tuple[str, ...], every: int = 1) -> Task:
        """What all runs share.

        Raises:
            ArrayError: A name is nothing that the law measures.
        """
        aim, half = self.aim, len(self.aim.target) // 2
        unknown = [name for name in (*aim.reads, *self.disturbed.resolution) if name not in state_names]
        unknown += [name for name in self.disturbed.resolution if name not in aim.reads]
        if unknown:
            raise ArrayError("resolution", unknown[0], "is nothing that the law measures", f"name one of {', '.join(aim.reads)}")
        if bad := [f"{name}={step:g}" for name, step in self.disturbed.resolution.items() if not 0 <= step < np.inf]:
            raise ArrayError("resolution", bad[0], "is no step in which something is read", "give a step above zero, or 0 for none")
        near = np.full(2 * half, aim.near)
        near[half:] /= aim.swing
        resolution = np.array([self.disturbed.resolution.get(name, 0.0) for name in aim.reads])
        reads = tuple(state_names.index(name) for name in aim.reads)
        return Task(aim.sample, round(aim.seconds / aim.sample), aim.target, aim.wraps, near, reads, resolution, every)

    def run(self, state_names: tuple[str, ...], runs: int, seed: int, progress: Any = None) -> Runs:
        """Draw what is wrong, and let the law run.

        Args:
            state_names: Names of the chain's state.
            runs: How many.
            seed: Of the draws.
            progress: Told how many are done, and of how many.

        Raises:
            ArrayError: No runs, or a name is nothing that the law measures.
        """
        if runs < 1:
            raise ArrayError("runs", runs, "is no number of runs", "give 1 or more")
        draw, aim, task = np.random.default_rng(seed), self.aim, self.task(state_names)
        relative = self.scale * draw.uniform(-1, 1, (runs, self.scale.size))
        more = self.added * draw.uniform(0, 1, (runs, self.added.size))
        starts = self._starts(draw.uniform(-1, 1, (runs, len(aim.start))))
        late = np.round(self.disturbed.late / aim.sample * draw.uniform(0, 1, runs)).astype(np.int64)
        parts = []
        for at in range(0, runs, CHUNK):
            part = slice(at, at + CHUNK)
            parts.append(self.loop.runs(task, starts[part], self.nominal * (1 + relative[part]) + more[part], late[part])[:3])
            if progress is not None:
                progress(min(at + CHUNK, runs), runs)
        ends, largest, since = (np.concatenate(rows) for rows in zip(*parts, strict=True))
        settled = since * aim.sample
        held = np.isfinite(ends).all(axis=1) & (settled <= aim.seconds - aim.hold)
        return Runs(
            self.scene.name, self.scene.digest, self.loop.law.name, self.names, relative + more, starts, ends, largest, late, settled,
            held.astype(np.int64), float(aim.seconds), float(aim.hold), seed,
        )  # fmt: skip
