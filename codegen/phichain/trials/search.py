"""One start of the search, whole: plan, gains, C, trials; in a process of its own, and remembered when it was solved before."""

from __future__ import annotations

import hashlib
import json
import tempfile
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, Final

import numpy as np

from phichain._version import __version__
from phichain.control.rig.observer import Sensors, resolutions
from phichain.control.swing_up import Chain, Design, Left, Plan, Start, Task, law_along, planned
from phichain.control.swing_up.transcription import Problem
from phichain.laws import TrajectoryLaw
from phichain.native import default_cache, recalled
from phichain.pipeline import build
from phichain.scene import Scene, scene_from_dict
from phichain.system import System
from phichain.trials.loop import Vector
from phichain.trials.monte_carlo import led, monte_carlo

DESIGNS: Final = (Design(0.25, 3e-4), Design(0.07, 1e-4), Design(0.7, 3e-4))
"""Weights that are tried on every plan, until one law holds in all runs."""

_FORMAT: Final = "phichain swing-up 9"


@dataclass(frozen=True, eq=False)
class Search:
    """What all starts of a search share; plain enough to cross into another process. Equal are those that plan the same.

    Attributes:
        scene: The chain as tables, whose parameters with errors are left to run time.
        values: Their values by name.
        task: The task's keyword arguments.
        sizes: Largest relative errors of the runtime parameters, flat.
        spread: Largest error of the angles at the start, rad.
        runs: Runs that judge a law.
        real: Type of the law's C.
        stride: Samples from knot to knot.
        solver: Which solver plans.
        most: Its largest number of iterations.
        sensors: How positions are measured, for a law that reads them alone; None for one that reads the state.
    """

    scene: Mapping[str, Any]
    values: Mapping[str, Any]
    task: Mapping[str, Any]
    sizes: tuple[float, ...]
    spread: float
    runs: int
    real: str
    stride: int
    solver: str
    most: int
    sensors: Sensors | None = None

    @property
    def key(self) -> str:
        """One text for one search's plans: what is planned does not depend on how laws are judged."""
        shared = {name: getattr(self, name) for name in ("scene", "values", "task", "stride", "solver", "most")}
        return json.dumps(shared, sort_keys=True, default=lambda value: np.asarray(value).tolist())

    def __hash__(self) -> int:
        return hash(self.key)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Search) and self.key == other.key


@dataclass(frozen=True)
class Tried:
    """What one start led to.

    Attributes:
        start: The start.
        left: What the solver said.
        plan: The plan; None where the chain could not be led along what the solver left.
        law: The best law along it; None without one.
        share: Share of the runs in which it holds the target.
        again: Whether the plan was found before and remembered.
    """

    start: Start
    left: Left
    plan: Plan | None
    law: TrajectoryLaw | None
    share: float
    again: bool

    def __str__(self) -> str:
        verdict = "the chain cannot be led along it" if self.plan is None else f"{self.share:.1%} hold"
        again = ", remembered" if self.again else ""
        way = f"route {self.start.route}, " if self.start.route else ""
        return f"{way}{self.start.seconds:.3g} s, seed {self.start.seed}, calm {self.start.calm:g}: {self.left}; {verdict}{again}"


@dataclass(frozen=True)
class Rig:
    """The chain of a search, built."""

    scene: Scene
    system: System
    texts: Mapping[str, str]
    chain: Chain
    task: Task


@cache
def rig(search: Search) -> Rig:
    """Build the chain of a search, once a process."""
    scene = scene_from_dict(search.scene)
    system = replace(build(scene), params=dict(search.values) or None)
    texts = recalled(scene, default_cache())
    if texts is None:
        from phichain.scratch import library_texts

        texts = library_texts(scene, True, default_cache())
    chain = Chain(system)
    return Rig(scene, system, texts, chain, Task.of(system, **search.task))


@cache
def _problem(search: Search) -> Problem:
    made = rig(search)
    return Problem(made.chain, made.task, search.solver, search.most)


def tried(search: Search, start: Start) -> Tried:
    """Follow one start to its end."""
    made = rig(search)
    known = _remembered(search, start)
    plan, left = known or planned(made.chain, made.task, _problem(search), start, search.stride)
    if known is None:
        _remember(search, start, plan, left)
    if plan is None:
        return Tried(start, left, None, None, 0.0, known is not None)
    best, share = None, -1.0
    for design in DESIGNS:
        law = law_along(made.chain, made.task, plan, design, np.array(search.sizes), search.spread, search.stride, sensors=search.sensors)
        found = judged(search, law, search.runs, seed=2)
        if found > share:
            best, share = law, found
        if share == 1.0 or (not any(search.sizes) and share > 0):
            break
    return Tried(start, left, plan, best, share, known is not None)


def judged(search: Search, law: TrajectoryLaw, runs: int, seed: int) -> float:
    """Share of the runs that hold the target."""
    return trials_of(search, law, runs, seed).share


def trials_of(search: Search, law: TrajectoryLaw, runs: int, seed: int, sizes: Vector | None = None, spread: float | None = None) -> Any:
    """Trials of a law on the chain of the search, by its own errors unless others are given."""
    made = rig(search)
    loop = led(made.scene, made.texts, law, search.real)
    return monte_carlo(
        loop, law, made.chain.parameters, np.array(search.sizes) if sizes is None else sizes, made.task.swing, runs=runs,
        spread=search.spread if spread is None else spread, seed=seed, resolution=_resolution(made.system, search.sensors),
    )  # fmt: skip


def _resolution(system: System, sensors: Sensors | None) -> Vector | None:
    """Steps of what the law reads (nq,); None where it reads the state."""
    if sensors is None:
        return None
    return resolutions(sensors, system.q_names, tuple("m" if i < system.cart_size else "rad" for i in range(system.nq)))


def _key(search: Search, start: Start) -> str:
    text = json.dumps([_FORMAT, __version__, search.key, asdict(start)], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()


def _remembered(search: Search, start: Start) -> tuple[Plan | None, Left] | None:
    """What the start led to before; None where that is not known."""
    key = _key(search, start)
    stored = default_cache().fetch(key)
    if stored is None:
        return None
    said, _, payload = stored.removeprefix(key.encode()).partition(b"\n")
    left = Left(**json.loads(said))
    if not payload:
        return None, left
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "plan.npz"
        path.write_bytes(payload)
        return Plan.from_npz(path), left


def _remember(search: Search, start: Start, plan: Plan | None, left: Left) -> None:
    """Keep it under its key and beginning with it, as the cache demands; without a plan where it led to none."""
    key = _key(search, start)
    with tempfile.TemporaryDirectory() as folder:
        payload = b"" if plan is None else plan.to_npz(Path(folder) / "plan.npz").read_bytes()
    default_cache().store(key, f"{key}{json.dumps(asdict(left))}\n".encode() + payload)
