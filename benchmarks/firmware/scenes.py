"""The scenes that the checks generate: every kind of code once, small."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from benchmarks.firmware.accuracy import SPATIAL_CART
from benchmarks.firmware.probe import probe
from phichain.files import write_folder
from phichain.scene import Scene
from phichain.scratch import folder_texts

HOOK: Final = "hook.c"
"""Where a hook is defined, beside what calls it."""
_HOOK: Final = """\
#include "{name}.h"
#include <math.h>

void {hook}({name}_real angle, {name}_real *sine, {name}_real *cosine)
{{
    *sine = sinf(angle);
    *cosine = cosf(angle);
}}
"""
_PLANAR: Final[dict[str, Any]] = {"actuated": "all", "real": "float", "trig": "bundled"}


def chain(name: str, links: int, want: tuple[str, ...], **more: Any) -> Scene:
    """Paper A's chain of so many links."""
    own = {"mass": 1 / links, "length": 1 / links, "com": 0.5 / links, **_PLANAR, **more}
    return Scene(name, links, want=want, **own)


def spatial(name: str, links: int, want: tuple[str, ...], **more: Any) -> Scene:
    """A chain of so many links with masses at their ends on a cart."""
    own = {"mass": 1 / links, "length": 1 / links, "cart_mass": SPATIAL_CART, "real": "float", "trig": "bundled", **more}
    return Scene(name, links, space="spatial", base="cart", want=want, **own)


SCENES: Final[tuple[Scene, ...]] = (
    chain("fw_planar4", 4, ("forward_dynamics", "energy", "state_jacobian", "dynamics_and_jacobian", "step")),
    chain("fw_planar4_loops", 4, ("dynamics_and_jacobian",), code="loops"),
    chain("fw_planar4_libm", 4, ("forward_dynamics",), trig="libm"),
    chain("fw_planar4_double", 4, ("forward_dynamics",), real="double"),
    chain("fw_planar10", 10, ("forward_dynamics", "dynamics_and_jacobian"), code="loops"),
    chain("fw_flows", 2, ("forward_dynamics", "phi", "phi_jacobian", "propagate", "propagate_stiff"), actuated="none"),
    chain("fw_forced", 2, ("propagate",), actuated="none", forced=1),
    chain("fw_hook", 2, ("forward_dynamics", "propagate"), actuated="none", forced=1, trig="hook", trig_hook="board_sincosf"),
    chain("fw_flow6", 6, ("propagate",), actuated="none", code="loops"),
    Scene(
        "fw_spatial2", 2, space="spatial", base="cart", mass=0.1, length=0.2, cart_mass=0.5,
        want=("forward_dynamics", "energy", "step"), real="float", trig="bundled",
    ),
    spatial("fw_spatial5", 5, ("forward_dynamics", "state_jacobian")),
)  # fmt: skip
"""What is generated; those of bundled trigonometry in single precision must agree to the last bit everywhere."""


@dataclass(frozen=True)
class Generated:
    """A generated folder.

    Attributes:
        scene: what was generated.
        folder: where.
    """

    scene: Scene
    folder: Path

    @property
    def source(self) -> Path:
        """NAME.c."""
        return self.folder / f"{self.scene.name}.c"

    @property
    def header(self) -> Path:
        """NAME.h."""
        return self.folder / f"{self.scene.name}.h"

    @property
    def selftest(self) -> Path:
        """selftest.c."""
        return self.folder / "selftest.c"

    @property
    def hook(self) -> list[Path]:
        """The file with the user's sines and cosines, where the scene leaves them to the user."""
        return [self.folder / HOOK] if self.scene.trig == "hook" else []

    @property
    def without_main(self) -> str:
        """What leaves the self-test's main out."""
        return f"-D{self.scene.name.upper()}_NO_MAIN"


def generated(root: Path) -> Mapping[str, Generated]:
    """Generate all scenes, by name. Nothing is proven here: the tests prove."""
    made = {
        scene.name: Generated(scene, write_folder(root / scene.name, folder_texts(scene, False, False)))
        for scene in SCENES
    }
    for one in made.values():
        probe(one.folder)
        for path in one.hook:
            path.write_text(_HOOK.format(name=one.scene.name, hook=one.scene.trig_hook))
    return made
