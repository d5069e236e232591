"""The functions of a scene that run over many steps or states: what C each is made of, and who prints which."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass, field
from typing import Final, TypeVar

from phichain.contract.functions import FLOWS, ROWS
from phichain.contract.registry import Registry
from phichain.mechanics import Model


@dataclass(frozen=True)
class FlowText:
    """A flow as text.

    Attributes:
        declarations: types and prototype, for NAME.h after its own types.
        definitions: for NAME.c, after the kernels and the functions that were named as known.
        includes: standard headers that the definitions want.
        uses: kernels that the definitions lean on: "sincos", "math".
        beside: what a compiled System has behind NAME.c, and no generated folder: the flow once more, with its errors.
    """

    declarations: str
    definitions: str
    includes: tuple[str, ...]
    uses: frozenset[str]
    beside: str = field(default="", kw_only=True)


@dataclass(frozen=True)
class PrintedFlow:
    """One flow of a scene: its name in the contract, its symbol in C, one line about it, its text."""

    name: str
    symbol: str
    doc: str
    text: FlowText


Print = TypeVar("Print", bound=Callable[..., FlowText])

PRINTERS: Final[Registry[Callable[[Model, Collection[str]], FlowText]]] = Registry("phichain.emit.flow", "printer")


def prints(name: str) -> Callable[[Print], Print]:
    """Register what prints a flow of the contract."""

    def register(printer: Print) -> Print:
        PRINTERS.add(name, printer)
        return printer

    return register


def print_flows(model: Model, known: Collection[str]) -> tuple[PrintedFlow, ...]:
    """Print the flows that a scene wants, in the contract's order.

    Args:
        model: the scene's mechanics.
        known: its functions that stand before them in NAME.c and that they may call.
    """
    scene = model.scene
    return tuple(
        PrintedFlow(name, f"{scene.name}_{name}", ROWS[name].doc, PRINTERS.of(name)(model, known))
        for name in scene.want
        if name in FLOWS
    )
