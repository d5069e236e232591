"""The three rigs of docs/rigs.md, held upright by a law that samples: ``python -m benchmarks.control.rigs`` draws docs/img/rig_*.png."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType

import numpy as np

IMAGES = Path(__file__).resolve().parents[2] / "docs" / "img"


@dataclass(frozen=True)
class Held:
    """How one rig is held.

    Attributes:
        sample: Seconds between samples; the input is held in between.
        weights: Q of the regulator, over q and v.
        limit: What the drive gives, in N, N m or m/s^2.
        lean: Released this far from upright, rad.
        seconds: For so long.
    """

    sample: float
    weights: tuple[float, ...]
    limit: float
    lean: float
    seconds: float


RIGS: Mapping[str, Held] = MappingProxyType(
    {
        "rig_cart_pole": Held(0.002, (100.0, 100.0, 1.0, 1.0), 8.0, 0.15, 6.0),
        "rig_stepped_double": Held(0.001, (100.0, 100.0, 100.0, 1.0, 1.0, 1.0), 25.0, 0.04, 8.0),
        "rig_acrobot": Held(0.002, (10.0, 10.0, 1.0, 1.0), 30.0, 0.02, 12.0),
    }
)


def draw(name: str, folder: Path = IMAGES) -> Path:
    """Builds one rig, holds it upright and draws its motion, what is left of the lean, and its input."""
    from phichain import build, simulate
    from phichain.control import errors, lqr
    from phichain.report import figures
    from phichain.report.style import save
    from phichain.scene.library import find_scene
    from phichain.system.starts import leaning

    rig = RIGS[name]
    scene = find_scene(name)
    system = build(scene)
    designed = system
    if scene.friction is not None:  # its slope at rest is a damper that is not there once the joint moves
        designed = build(replace(scene, name=f"{name}_smooth", friction=None, friction_speed=None))
    gains = lqr(designed, sample=rig.sample, Q=rig.weights)
    start = leaning(system, rig.lean, gains.s)
    grid = np.linspace(0.0, rig.seconds, 601)
    motion = simulate(system, start, grid, u=gains.law(limit=rig.limit), sample=rig.sample)
    path = folder / f"{name}.png"
    save(figures.closed_loop(system, motion, *errors(system, gains, motion.x)), path, of=[motion, gains])
    print(f"{path.name}: {motion.status}; largest input {np.max(np.abs(np.asarray(motion.u))):.3g}; {motion.energy_words}")
    return path


if __name__ == "__main__":
    for each in RIGS:
        draw(each)
