"""Scenes compiled with their NAME_casadi.c, for casadi.external."""

from __future__ import annotations

import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from phichain.emit.c.text import header, source
from phichain.emit.casadi.external import casadi_external
from phichain.emit.printed import print_scene
from phichain.ir.nodes import Program
from phichain.lowering.lower import Lowered
from phichain.scene import Scene, standard_scene
from tests.emit.casadi_scenes import make_scene
from tests.offered import DERIVATIVES

STRICT = [
    "-std=c99",
    "-pedantic-errors",
    "-Wall",
    "-Wextra",
    "-Wconversion",
    "-Wsign-conversion",
    "-Wdouble-promotion",
    "-Wfloat-conversion",
    "-Wshadow",
    "-Wstrict-prototypes",
    "-Wmissing-prototypes",
    "-Wcast-qual",
    "-Wundef",
    "-Wvla",
    "-Werror",
]
KINDS = {
    "planar": standard_scene(2),
    "planar_cart": make_scene(
        "hoist",
        2,
        base="cart",
        com="runtime",
        mass="runtime",
        cart_mass="runtime",
        gravity="runtime",
        stiffness="runtime",
        damping="runtime",
        actuated="all",
    ),
    "spatial_loops": make_scene("rope", 2, "spatial", "cart", code="loops", stiffness=2.0),
    "planar_loops": make_scene("swing", 3, code="loops", angles="absolute", actuated="all", length="runtime"),
    "one_link": make_scene("pendulum", 1, want=("forward_dynamics", "mass_matrix", "positions")),
}


@dataclass(frozen=True)
class Built:
    """A compiled scene."""

    scene: Scene
    lowered: Lowered
    folder: Path

    @property
    def library(self) -> Path:
        return self.folder / f"{self.scene.name}.so"

    @property
    def differentiable(self) -> dict[str, Program]:
        """The functions that come with Jacobians: those that are no derivatives themselves."""
        return {
            name: program for name, program in self.lowered.wanted.items() if name not in DERIVATIVES
        }

    def external(self, function: str) -> Any:
        import casadi

        return casadi.external(f"{self.scene.name}_casadi_{function}", str(self.library))


def write(scene: Scene, lowered: Lowered, folder: Path) -> list[str]:
    """Write a scene's C files; returns the names of those to compile."""
    printed = print_scene(scene, lowered)
    texts = {
        f"{scene.name}.h": header(printed, {}),
        f"{scene.name}.c": source(printed),
        f"{scene.name}_casadi.c": casadi_external(printed),
    }
    for name, text in texts.items():
        (folder / name).write_text(text)
    return [name for name in texts if name.endswith(".c")]


def run(folder: Path, *command: str) -> str:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[:4000]
    return done.stdout
