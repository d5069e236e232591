"""phichain: from a Lagrangian to firmware, for pendulum chains.

    from phichain import build, simulate, standard_scene

    system = build(standard_scene(4))              # derived, emitted as C, compiled
    motion = simulate(system, x0, t)               # x0 = (q, v)

A scene says which chain; `generate` writes its C and CasADi folder, `build` compiles it into a `System` of
callables, and `simulate`, `trace` and `lqr` take that System. Names are imported when first used, so that
`import phichain` costs nothing.
"""

from __future__ import annotations

import sys
from importlib import import_module
from typing import TYPE_CHECKING, Any

from phichain._version import __version__ as __version__

if sys.platform == "win32":
    raise ImportError(
        "phichain runs on Linux and macOS and not on Windows, since it locks files and ends processes the POSIX way; install it within WSL, the Linux of Windows"
    )

if TYPE_CHECKING:
    from phichain.continuation import Branch as Branch
    from phichain.control import lqr as lqr
    from phichain.errors import PhichainError as PhichainError
    from phichain.identification import fit as fit
    from phichain.lowering import lower as lower
    from phichain.mechanics import derive as derive
    from phichain.motion import Trajectory as Trajectory
    from phichain.motion import simulate as simulate
    from phichain.orbits import Network as Network
    from phichain.orbits import respond as respond
    from phichain.orbits import trace as trace
    from phichain.pipeline import build as build
    from phichain.pipeline import generate as generate
    from phichain.pipeline import generate_climb as generate_climb
    from phichain.pipeline import generate_controller as generate_controller
    from phichain.pipeline import generate_swingup as generate_swingup
    from phichain.proof import prove as prove
    from phichain.scene import Scene as Scene
    from phichain.scene import load_scene as load_scene
    from phichain.scene import standard_scene as standard_scene
    from phichain.studies import open_study as open_study
    from phichain.studies import study as study
    from phichain.system import System as System
    from phichain.trials import climb as climb
    from phichain.trials import swing_up as swing_up

_HOME = {
    "Scene": "phichain.scene",
    "load_scene": "phichain.scene",
    "standard_scene": "phichain.scene",
    "derive": "phichain.mechanics",
    "lower": "phichain.lowering",
    "prove": "phichain.proof",
    "generate": "phichain.pipeline",
    "generate_climb": "phichain.pipeline",
    "generate_controller": "phichain.pipeline",
    "generate_swingup": "phichain.pipeline",
    "build": "phichain.pipeline",
    "System": "phichain.system",
    "simulate": "phichain.motion",
    "Trajectory": "phichain.motion",
    "trace": "phichain.orbits",
    "respond": "phichain.orbits",
    "Branch": "phichain.continuation",
    "Network": "phichain.orbits",
    "lqr": "phichain.control",
    "fit": "phichain.identification",
    "climb": "phichain.trials",
    "swing_up": "phichain.trials",
    "study": "phichain.studies",
    "open_study": "phichain.studies",
    "PhichainError": "phichain.errors",
}

__all__ = list(_HOME)


def __getattr__(name: str) -> Any:
    if name in _HOME:
        return getattr(import_module(_HOME[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
