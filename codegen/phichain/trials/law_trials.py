"""Monte Carlo of a law on file: the very C of its folder on the compiled chain, with whatever is said to be wrong."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np

from phichain.errors import ArrayError
from phichain.pipeline import build
from phichain.scene import Scene
from phichain.system import System
from phichain.system.vertical import configuration
from phichain.trials.climb import driven_at
from phichain.trials.on_file import LawOnFile
from phichain.trials.runs import Aim, Disturbed, Rigged, Runs, wanted

SETTLING: Final = 12.0
"""How long a law may take to settle behind its motion, in swing times, and 5 s at least."""
LONGEST: Final = 1e-3
"""Time between two calls of a law that is made to be called all the time, s."""
CLIMBING: Final = 150.0
"""How long a climb may take unless said, s."""


def law_trials(
    scene: Scene, law: LawOnFile, disturbed: Disturbed, *, up: Sequence[int] | None = None, seconds: float | None = None, hold: float = 2.0,
    near: float = 0.05, runs: int = 200, seed: int = 1, progress: Any = None,
) -> Runs:  # fmt: skip
    """Let a law run on chains that are wrong in many ways.

    Args:
        scene: The chain that the law was made for.
        law: The law.
        disturbed: What is wrong, at most.
        up: Of a table of gains which equilibrium is tried, +1 hanging, -1 upright; its last one unless given. Of a chain in space whose
            law does not measure which way up a link is: which way that is; every link upright unless given.
        seconds: How long a run is; by the law unless given.
        hold: How long the target must have been held at its end, s.
        near: How near every angle must be, rad.
        runs: How many.
        seed: Of the draws.
        progress: Told how many are done, and of how many.

    Raises:
        ArrayError: The law belongs to another scene, or a number is none.
        UnsupportedError: A chain with runtime parameters.
        SceneError: A name is no parameter of the chain.
    """
    if law.digest != scene.digest:
        raise ArrayError("law", law.scene, f"is the scene of that law, and '{scene.name}' is another one", "name the scene that it was made for")
    if not 0 < hold < np.inf or not 0 < near < np.pi:
        raise ArrayError("hold, near", (hold, near), "are no time and no angle", "give seconds, and radians")
    if seconds is not None and not 0 <= seconds < np.inf:
        raise ArrayError("time", seconds, "is no time", "give seconds")
    if law.kind == "climb":
        scene = driven_at(scene, int(law.inputs[0].rpartition("_")[2]))
    system = build(replace(scene, real="double", variational=False, want=wanted(scene)))
    # A law that measures the whole state names it, in its order.
    names = law.measured if len(law.measured) == system.nx else (*system.q_names, *system.v_names)
    swing, target = swing_time(system), _target(system, law, up, names)
    start = target if law.start is None else law.start
    usual = CLIMBING if law.kind == "climb" else law.duration + max(5.0, SETTLING * swing)
    wraps = tuple(system.is_planar and system.cart_size <= k < system.nq for k in range(system.nx))
    aim = Aim(start, target, wraps, law.measured, law.sample or LONGEST, hold + (usual if seconds is None else seconds), hold, near, swing)
    found = Rigged.of(scene, law.called, law.sources, aim, disturbed).run(names, runs, seed, progress)
    return replace(found, digest=law.digest)


def swing_time(system: System) -> float:
    """sqrt(sum l / g), s: what rates are measured by."""
    gravity = abs(float(system.number("gravity"))) or 1.0
    return float(np.sqrt(np.sum(np.asarray(system.number("length"), dtype=float)) / gravity))


def _target(system: System, law: LawOnFile, up: Sequence[int] | None, names: tuple[str, ...]) -> Any:
    """Where the law leads, the whole state of it."""
    if law.signs:
        signs = tuple(law.signs[-1] if up is None else up)
        if signs not in law.signs:
            raise ArrayError("up", list(signs), "is no equilibrium of that table", f"name one of {', '.join(map(str, law.signs))}")
        row = law.targets[law.signs.index(signs)]
    else:
        row = law.targets[0]
    target = np.zeros(system.nx)
    if not system.is_planar:
        target[: system.nq] = configuration(system, (-1,) * system.links if up is None else up)
    for name, value in zip(law.measured, row, strict=True):
        if name not in names:
            raise ArrayError("law", name, "is measured by that law, and nothing of this chain", f"it has {', '.join(names)}")
        target[names.index(name)] = value
    return target
