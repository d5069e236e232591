"""Which plain function writes which Program: each one registers in the file where its formula lives.

    @writes("energy", space="planar")
    def energy(builder, scene, parameters, q, v, kinetic, potential): ...

A writer is given the Builder, the Scene, its Parameters, the Programs it `calls` in that order, and by name the arguments
that the contract's row declares; those that a chain does not have are left out.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Final, TypeVar

from phichain.contract.functions import ROWS
from phichain.contract.registry import ANY, Registry
from phichain.ir.builder import ArrayRef, Builder
from phichain.lowering.chain.units import Units, si
from phichain.scene import Scene

Write = TypeVar("Write", bound=Callable[..., None])


@dataclass(frozen=True)
class Writer:
    """How one Program is written.

    Attributes:
        write: records its operations.
        doc: its one-line description, where no row of the contract has one.
        calls: names of the Programs that it calls.
        units: what it computes in (`Parameters`).
        suits: for a function that another one's derivative can stand for, on which scenes it keeps as many digits as that.
        lumped: whether it is given the point masses that rigid links move like, where there are such (`body`).
    """

    write: Callable[..., None]
    doc: str
    calls: tuple[str, ...]
    units: Callable[[Scene], Units]
    suits: Callable[[Scene], bool]
    lumped: bool = False


WRITERS: Final[Registry[Writer]] = Registry("phichain.lowering", "writer")


def _everywhere(scene: Scene) -> bool:
    return True


def writes(
    name: str, *, space: str = ANY, calls: tuple[str, ...] = (), units: Callable[[Scene], Units] = si,
    suits: Callable[[Scene], bool] = _everywhere, lumped: bool = False,
) -> Callable[[Write], Write]:  # fmt: skip
    """Register the writer of a function of the contract.

    Args:
        name: the function.
        space: "planar" or "spatial" for a writer that serves such scenes alone.
        calls: the Programs that it calls, handed to it behind the parameters.
        units: what it computes in; it converts inputs and results by `parameters.units`.
        suits: see `Writer`.
        lumped: see `Writer`.
    """
    return _registered(name, Writer(_nothing, "", calls, units, suits, lumped), space, True)


def helps(
    name: str, doc: str, calls: tuple[str, ...] = (), *, units: Callable[[Scene], Units] = si, lumped: bool = False
) -> Callable[[Write], Write]:
    """Register the writer of a Program that others call and no scene wants; it declares its own arguments."""
    return _registered(name, Writer(_nothing, doc, calls, units, _everywhere, lumped), ANY, False)


def _nothing() -> None:
    """In the place of a writer that is about to be registered."""


def _registered(name: str, how: Writer, space: str, needs_row: bool) -> Callable[[Write], Write]:
    def register(write: Write) -> Write:
        WRITERS.add(name, replace(how, write=write), space, needs_row)
        return write

    return register


def declared(builder: Builder, scene: Scene, name: str) -> dict[str, Any]:
    """The arguments of a function of the contract, declared in the order of the C; none for what others call."""
    arguments: dict[str, ArrayRef] = {}
    for argument in ROWS[name].arguments_of(scene) if name in ROWS else ():
        declare = builder.input if argument.direction == "in" else builder.output
        arguments[argument.name] = declare(argument.name, argument.shape(scene), argument.doc)
    return arguments
