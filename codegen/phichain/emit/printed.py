"""What is printed of a scene: every Program as C once, and whatever header, source, manifest and README say of it."""

from __future__ import annotations

from dataclasses import dataclass

from phichain.emit.c.programs import PrintedFunction, PrintedPrograms, print_programs
from phichain.emit.flow.flows import PrintedFlow, print_flows
from phichain.ir.nodes import Array
from phichain.lowering.lower import Lowered
from phichain.mechanics import Model
from phichain.scene import Scene


@dataclass(frozen=True)
class Printed:
    """A scene's C, piece by piece.

    Attributes:
        model: the scene's mechanics.
        params: fields of its struct of runtime parameters.
        programs: its Programs, helpers first.
        flows: what runs over many steps.
    """

    model: Model
    params: tuple[Array, ...]
    programs: PrintedPrograms
    flows: tuple[PrintedFlow, ...]

    @property
    def scene(self) -> Scene:
        """The scene."""
        return self.model.scene

    @property
    def wanted(self) -> tuple[PrintedFunction, ...]:
        """The functions that the scene asks for."""
        return tuple(function for function in self.programs.functions if not function.is_static)

    @property
    def helpers(self) -> tuple[PrintedFunction, ...]:
        """What those call."""
        return tuple(function for function in self.programs.functions if function.is_static)


def print_scene(scene: Scene, lowered: Lowered) -> Printed:
    """Print a scene's Programs, each once.

    Args:
        scene: the scene.
        lowered: its Programs.
    """
    known = frozenset({*lowered.wanted, *lowered.helpers})
    programs = print_programs(scene, lowered.helpers, lowered.wanted)
    return Printed(lowered.model, lowered.params, programs, print_flows(lowered.model, known))
