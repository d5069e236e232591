"""A weakly driven double pendulum on its way up a family of orbits: the figure U2."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from phichain.continuation import Branch
from phichain.orbits import trace
from phichain.pipeline import build
from phichain.report.laws.climb import climbing
from phichain.report.style import save
from phichain.scene.library import find_scene
from phichain.trials.climb import climb

_UP = 9.808
"""Energy at which the family of mode 2 is 0.025 rad from the upright chain, 9.81 J."""
_SHOT = ("mass_matrix", "energy", "forward_dynamics", "propagate")


def climbed(out: Path) -> list[Path]:
    """Draw one climb at a twentieth of the gravity torque into a folder."""
    scene = find_scene("planar2")
    system = build(replace(scene, want=_SHOT, variational=True, actuated="none"))
    branch = trace(replace(system, digest=scene.digest), 2, until=f"energy={_UP}")
    assert isinstance(branch, Branch)
    found = climb(scene, branch, share=0.05, runs=1, seconds=75.0)
    return [save(climbing(found.climb.law, found.t, found.x, found.u, found.energy), out / "U2.png", of=[found.climb.law, found.runs])]
