"""The functions of a scene that run over many steps: which module writes which, and what C each is made of."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Final, Protocol

from phichain.contract.functions import FLOWS
from phichain.emit.flow.forward_dynamics_batch import forward_dynamics_batch
from phichain.emit.flow.propagate import flow
from phichain.emit.flow.propagate_batch import flow_batch
from phichain.emit.flow.propagate_stiff import stiff
from phichain.lowering.lower import Lowered
from phichain.scene import Scene


class FlowText(Protocol):
    """What the writer of a flow returns."""

    @property
    def declarations(self) -> str:
        """Types and prototype, for NAME.h after its own types."""

    @property
    def definitions(self) -> str:
        """For NAME.c, after the kernels and the functions."""

    @property
    def includes(self) -> tuple[str, ...]:
        """Standard headers that the definitions want."""

    @property
    def uses(self) -> frozenset[str]:
        """Kernels that the definitions lean on: "sincos", "math"."""


@dataclass(frozen=True)
class NamedFlow:
    """One flow: its name in the contract, its symbol in C, one line about it, its text."""

    name: str
    symbol: str
    doc: str
    text: FlowText


_WRITERS: Final[Mapping[str, tuple[str, Callable[[Scene, Collection[str]], FlowText]]]] = {
    "forward_dynamics_batch": ("Accelerations of many states at once, on vectors.", forward_dynamics_batch),
    "propagate": ("Taylor flow: order and steps chosen from a tolerance, with dense output and an event.", flow),
    "propagate_stiff": ("Stiff flow: an L-stable Rosenbrock method of order 5, its steps chosen from a tolerance.", stiff),
    "propagate_batch": ("Taylor flow of many trajectories at once, on vectors, each with steps of its own.", flow_batch),
}


def flows(scene: Scene, lowered: Lowered) -> tuple[NamedFlow, ...]:
    """The flows that a scene wants, in the contract's order.

    Args:
        scene: the scene.
        lowered: its Programs, whose C the flows may call.
    """
    return _flows(scene, frozenset({*lowered.wanted, *lowered.helpers}))


@lru_cache(maxsize=8)
def _flows(scene: Scene, known: frozenset[str]) -> tuple[NamedFlow, ...]:
    # Header, source and manifest of one folder ask for the same text.
    return tuple(
        NamedFlow(name, f"{scene.name}_{name}", _WRITERS[name][0], _WRITERS[name][1](scene, known))
        for name in scene.want
        if name in FLOWS
    )
