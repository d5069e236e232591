"""Monte Carlo: how many runs of the compiled law reach the target and stay there, the parameters drawn around their values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from phichain.emit.law.loop import Called
from phichain.emit.law.trajectory import swingup_files, swingup_name
from phichain.errors import ArrayError, SceneError
from phichain.laws import TrajectoryLaw
from phichain.records import Valued, columns_of, write_csv
from phichain.scene import Scene
from phichain.scene.keys import PARAMETERS
from phichain.trials.loop import Loop, Task, Vector
from phichain.trials.share import interval_of

HOLDING: Final = 1
LOST: Final = 2
SETTLING = 12.0
"""How long the target is held before a run counts, in swing times and 2 s at least."""
NEAR = 0.05
"""How near the target every entry must be at the end, rad and rad per swing time (m likewise)."""
STEPPED: Final = 5.0
"""How many times as fast a chain may be that is measured in steps: where a count comes and goes an upright chain trembles about its place."""


@dataclass(frozen=True, eq=False)
class Trials(Valued):
    """What became of every run.

    Attributes:
        name: Name of the chain.
        errors: Relative errors of the runtime parameters, run by run (n, np).
        starts: Where the runs began (n, nx).
        ends: Where they ended (n, nx); where the law gave up, if it did.
        largest: Largest distance of the cart from 0, and of every input from 0 (n, 1 + nu).
        phases: Last phases (n,).
        held: Whether the target was reached and held, within the rail (n,).
        digest: Canonical digest of the chain's scene.
    """

    name: str
    errors: Vector
    starts: Vector
    ends: Vector
    largest: Vector
    phases: NDArray[np.intc]
    held: NDArray[np.bool_]
    digest: str = ""

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
        return (
            f"{self.name}: {int(np.sum(self.held))} of {len(self.held)} runs reach and hold the target ({self.share:.1%}, "
            f"95 % interval {low:.1%} to {high:.1%})"
        )

    def to_csv(self, path: object) -> object:
        """Write one row a run: errors, extremes, phase, whether it held."""
        columns = columns_of([f"error_{k + 1}" for k in range(self.errors.shape[1])], self.errors)
        columns |= columns_of(["farthest", *(f"largest_u_{k + 1}" for k in range(self.largest.shape[1] - 1))], self.largest)
        return write_csv(str(path), {**columns, "phase": self.phases, "held": self.held.astype(int)}, self)


def sizes_of(scene: Scene, errors: Mapping[str, float]) -> Vector:
    """Largest relative errors one behind the other (np,), as the struct has the parameters.

    Raises:
        SceneError: A name is no runtime parameter of the scene, or a size is none.
    """
    shapes = scene.runtime_shapes
    for name, size in errors.items():
        if name not in shapes:
            raise SceneError("error", name, "is no parameter that this chain has as numbers", f"name one of {', '.join(PARAMETERS)}")
        if not 0 <= size < 1:
            raise SceneError("error", size, f"is no relative error of {name}", f"write for example {name}=0.1 for ten per cent")
    return np.concatenate([np.zeros(0), *(np.full(int(np.prod(shape)), errors.get(name, 0.0)) for name, shape in shapes.items())])


def led(scene: Scene, texts: Mapping[str, str], law: TrajectoryLaw, real: str = "float") -> Loop:
    """A law along a trajectory and its chain, compiled together.

    Args:
        scene: The chain, in double precision.
        texts: The files that were generated of it.
        law: The law, of a chain of the same name.
        real: The type of the law's C.

    Raises:
        CompilerError: The compiler is missing or failed.
        EmissionError: A number of the law does not fit the type.
    """
    name, files = swingup_name(law), swingup_files(law, real)
    called = Called(name, "trajectory", law.measured, "&state, measured" if law.observer else "&state")
    return Loop.of(scene, texts, called, {file: files[file] for file in (f"{name}.h", f"{name}.c")})


def task_of(law: TrajectoryLaw, seconds: float, resolution: Vector | None = None) -> Task:
    """What runs of a law along a trajectory share: they end where it gives up, and what became of them is seen at their ends.

    Args:
        law: The law.
        seconds: How long a run is.
        resolution: Step of every entry that the law reads; all exact unless given.
    """
    catch = law.catch
    steps = np.zeros(law.measured) if resolution is None else np.array(np.broadcast_to(resolution, law.measured), dtype=float)
    target = np.array(catch.target)
    return Task(
        catch.sample, round(seconds / catch.sample), target, catch.wraps, np.full(len(target), np.inf), tuple(range(law.measured)), steps, lost=LOST
    )


def monte_carlo(
    loop: Loop, law: TrajectoryLaw, nominal: Vector, sizes: Vector, swing: float, *, runs: int = 200, spread: float = 0.05, seed: int = 1,
    resolution: Vector | None = None,
) -> Trials:  # fmt: skip
    """Draw parameters and starts uniformly within their bounds, and let the law run.

    Args:
        loop: The law on the chain, from `led`.
        law: The law.
        nominal: Runtime parameters as they are taken to be (np,).
        sizes: Their largest relative errors (np,).
        swing: Swing time of the chain, s.
        runs: How many.
        spread: Largest error of every angle at the start, rad.
        seed: Of the draws.
        resolution: Step of every entry that the law reads; all exact unless given.

    Raises:
        ArrayError: No runs.
    """
    if runs < 1:
        raise ArrayError("runs", runs, "is no number of runs", "give 1 or more")
    draw, nx, half = np.random.default_rng(seed), law.states.shape[1], law.states.shape[1] // 2
    errors = sizes * draw.uniform(-1, 1, (runs, sizes.size))
    wraps = np.array(law.catch.wraps)
    starts = law.states[0] + spread * wraps * draw.uniform(-1, 1, (runs, nx))
    seconds = law.duration + max(2.0, SETTLING * swing)
    ends, largest, _, phases, _ = loop.runs(task_of(law, seconds, resolution), starts, nominal * (1 + errors), np.zeros(runs))
    away = ends - np.array(law.catch.target)
    away[:, wraps] -= 2 * np.pi * np.floor(away[:, wraps] / (2 * np.pi) + 0.5)
    away[:, half:] *= swing
    away[:, half:] /= 1.0 if resolution is None else STEPPED
    held = (phases == HOLDING) & np.all(np.abs(away) < NEAR, axis=1)
    if np.isfinite(law.rail):
        held &= largest[:, 0] <= law.rail
    return Trials(law.name, errors, starts, ends, largest, phases, held, law.digest, p=law.p)
