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
from types import ModuleType
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from phichain.continuation import Branch as Branch
    from phichain.continuation import trace as trace
    from phichain.control import lqr as lqr
    from phichain.errors import PhichainError as PhichainError
    from phichain.mechanics import derive as derive
    from phichain.pipeline import build as build
    from phichain.pipeline import generate as generate
    from phichain.program import lower as lower
    from phichain.scene import Scene as Scene
    from phichain.scene import load_scene as load_scene
    from phichain.scene import standard_scene as standard_scene
    from phichain.simulate import Trajectory as Trajectory
    from phichain.simulate import simulate as simulate
    from phichain.system import System as System

_HOME = {
    "Scene": "phichain.scene",
    "load_scene": "phichain.scene",
    "standard_scene": "phichain.scene",
    "derive": "phichain.mechanics",
    "lower": "phichain.program",
    "generate": "phichain.pipeline",
    "build": "phichain.pipeline",
    "System": "phichain.system",
    "simulate": "phichain.simulate",
    "Trajectory": "phichain.simulate",
    "trace": "phichain.continuation",
    "Branch": "phichain.continuation",
    "lqr": "phichain.control",
    "PhichainError": "phichain.errors",
}
_VERBS = ("build", "simulate")

__all__ = list(_HOME)


class _Verb(ModuleType):
    """A subpackage that shares its name with a public function answers to calls as that function."""

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        return _public(self.__name__.rpartition(".")[2])(*args, **kwargs)


class _Package(ModuleType):
    """Makes `phichain.simulate(...)` mean the function however the subpackage came to be imported."""

    def __setattr__(self, name: str, value: Any) -> None:
        if name in _VERBS and isinstance(value, ModuleType):
            value.__class__ = _Verb
        super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package


def _public(name: str) -> Any:
    return getattr(import_module(_HOME[name]), name)


def __getattr__(name: str) -> Any:
    if name in _VERBS:
        return import_module(f"{__name__}.{name}")
    if name in _HOME:
        return _public(name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
