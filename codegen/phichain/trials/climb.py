"""Up a family of orbits, whole: from a saved Branch to a law, its C, and what becomes of it in trials."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from phichain.continuation import Branch
from phichain.emit.law.climb import climb_files, climb_name
from phichain.emit.law.loop import Called
from phichain.errors import ArrayError, ControlError
from phichain.orbits.climb import Climb, climb_law
from phichain.orbits.climb.design import NEEDED
from phichain.pipeline import build
from phichain.records import Held
from phichain.scene import Scene
from phichain.trials.loop import Vector
from phichain.trials.runs import Aim, Disturbed, Rigged, Runs

HOLD: Final = 5.0
"""How long the target must be held, s."""


@dataclass(frozen=True, eq=False)
class Climbed(Held):
    """A law along a family, and what became of it.

    Attributes:
        climb: The law, and what it was made of.
        runs: Trials.
        t: Times of the samples of one run without errors (m,), s.
        x: Its states (m, nx).
        u: Its input (m, 1).
        energy: Its energy (m,), J above the hanging chain.
    """

    climb: Climb
    runs: Runs
    t: Vector
    x: Vector
    u: Vector
    energy: Vector

    def __str__(self) -> str:
        law, share = self.climb.law, self.climb.law.limit / self.climb.torque
        return (
            f"{law}\nlimit {law.limit:.4g} N m, {share:.3g} of the gravity torque {self.climb.torque:.4g} N m; last brake "
            f"{np.max(np.abs(self.climb.ladder.states[-1, 0] - self.climb.ladder.target)):.2g} rad from the equilibrium\n{self.runs}"
        )


def climb(
    scene: Scene,
    branch: Branch,
    *,
    share: float = 0.05,
    joint: int | None = None,
    damping: Any = None,
    errors: Mapping[str, float] | None = None,
    spread: float = 0.05,
    runs: int = 20,
    seconds: float | None = None,
    real: str = "float",
    seed: int = 1,
    progress: Any = None,
    **settings: Any,
) -> Climbed:
    """Lead a weakly driven planar chain up along a traced family of brake orbits, and hold it where the family ends.

    Args:
        scene: The chain that the family was traced with.
        branch: The family.
        share: Limit of the torque, in gravity torques about the driven joint.
        joint: The driven joint, counted from 1; the only one that the scene drives, or the first, unless given.
        damping: Dampers that the rig has and the scene does not, one number or one a joint, N m s/rad.
        errors: Largest relative errors of parameters by name in the trials.
        spread: Largest error of every angle at their start, rad.
        runs: Trials.
        seconds: How long a trial is; from the number of rungs unless given.
        real: Type of the law's C, "float" or "double".
        seed: Of the trials.
        progress: Told how many trials are done, and of how many.
        settings: `rungs`, `nodes`, `sample`, `pace`, `rise`, `cost` of `climb_law`.

    Raises:
        ArrayError: The branch belongs to another scene, or a number is none.
        ControlError: The chain is not of that kind, or the limit too small for the damping.
        UnsupportedError: The family leads nowhere.
        ConvergenceError: It ends too far from its equilibrium.
    """
    one = driven_at(scene, joint)
    system = build(replace(one, want=NEEDED))
    made = climb_law(system, branch, share=share, digest=scene.digest, **settings)
    losses = np.broadcast_to(np.asarray(0.0 if damping is None else damping, dtype=float), (scene.links,))
    if not np.all((losses >= 0) & np.isfinite(losses)):
        raise ArrayError("damping", damping, "is no damping", f"give one number or {scene.links}, N m s/rad, none below zero")
    if np.any(losses):
        made.demand_room(losses)
        one = replace(one, damping=tuple(losses))
    catch = replace(made.law.catch, digest=scene.digest)
    law = replace(made.law, catch=catch)
    long = seconds or 20.0 + 3 * float(np.sum(np.maximum(1 / law.pace, law.periods / 2 / law.rises)))
    aim = Aim(
        np.zeros(system.nx), np.array(catch.target), catch.wraps, catch.state_names, catch.sample, long, HOLD, swing=float(law.weights[-1]) ** 0.5
    )
    name, files = climb_name(law), climb_files(law, real)
    sources = {file: files[file] for file in (f"{name}.h", f"{name}.c")}
    called = Called(name, "climb", system.nx)
    rigged = Rigged.of(one, called, sources, aim, Disturbed(errors or {}, spread=spread))
    every = max(1, round(0.02 / catch.sample))
    still = np.zeros((1, rigged.nominal.size)) + rigged.nominal
    *_, trace = rigged.loop.runs(rigged.task(catch.state_names, every), np.zeros((1, system.nx)), still, np.zeros(1), trace=True)
    assert trace is not None
    t: Vector = np.asarray(np.arange(len(trace)) * (every * catch.sample), dtype=float)
    x, half = trace[:, : system.nx], system.nq
    _, hanging = system.energy(np.zeros(half), np.zeros(half))
    energy = np.asarray(sum(system.energy(x[:, :half], x[:, half:]))) - float(hanging)
    tried = rigged.run(catch.state_names, runs, seed, progress)
    # What comes long after it has settled shows nothing.
    shown = t <= (float(np.max(tried.settled[tried.held == 1])) + HOLD if np.any(tried.held) else long)
    t, x, trace, energy = t[shown], x[shown], trace[shown], energy[shown]
    return Climbed(replace(made, law=law), tried, t, x, trace[:, system.nx :], energy)


def driven_at(scene: Scene, joint: int | None) -> Scene:
    """The chain driven at one joint alone, in double precision.

    Raises:
        ControlError: There is no such joint.
    """
    if not scene.is_planar or not scene.base_law.rests:
        raise ControlError("scene", scene.name, "is no planar chain on a fixed base", "climb with one, such as planar2")
    chosen = joint or (scene.actuated[0] if isinstance(scene.actuated, tuple) else 1)
    if not 1 <= chosen <= scene.links:
        raise ControlError("joint", chosen, "is no joint of this chain", f"name one of 1 .. {scene.links}")
    return replace(scene, actuated=(chosen,), real="double", variational=False, forced=None, axis=None)
