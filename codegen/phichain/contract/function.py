"""The records of the contract's table: a function, its arguments, and why some chains have none of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from phichain.contract.chain import Chain, Kind, Words, always, worded
from phichain.contract.flow import Flow
from phichain.errors import ContractError

Shape = tuple[int, ...]

@dataclass(frozen=True)
class Argument:
    """One argument of a function.

    Attributes:
        name: its name in C, in CasADi and in Python.
        direction: "in" or "out".
        shape: its extents on a chain, () for a single number.
        doc: what it is in a few words, for the manifest.
        meaning: what it is and in which unit, for the header; empty where `doc` says all.
        present: on which chains the function has it.
        is_checked: whether the self-test compares it.
    """

    name: str
    direction: Literal["in", "out"]
    shape: Callable[[Chain], Shape]
    doc: str = ""
    meaning: Words = ""
    present: Callable[[Chain], bool] = always
    is_checked: bool = True

    def explained(self, chain: Chain) -> str:
        """One line for the header: extents of a matrix, what it is, in which unit."""
        text = worded(self.meaning or self.doc, chain)
        shape = self.shape(chain)
        return f"{shape[0]} x {shape[1]}, {text}" if len(shape) == 2 else text


@dataclass(frozen=True)
class Absence:
    """Some chains have no such function.

    Attributes:
        when: which chains.
        problem: why, as an error says it.
        remedy: what to use instead.
    """

    when: Callable[[Kind], bool]
    problem: str
    remedy: str


@dataclass(frozen=True)
class Derivative:
    """A function that holds the exact partial derivatives of another one.

    Attributes:
        function: the one that is differentiated.
        output: which of its outputs.
        by: with respect to which of its inputs; the results follow in this order, one each, or side by side in one.
        keeps: whether that output itself is returned, first and under its own name.
    """

    function: str
    output: str
    by: tuple[str, ...]
    keeps: bool = False


@dataclass(frozen=True)
class Function:
    """One row: a function that a scene can ask for.

    It is one Program, unless it is the `derivative` of another one (then a transform makes its Program) or a `flow`, which
    runs over many steps or states: C around Programs.

    Attributes:
        name: its name in `want`, and NAME_function in C.
        doc: what it computes, in one line.
        arguments: those of a Program in the order of the C, inputs first.
        absent: which chains have none of it, and why.
        derivative: what it is the derivative of.
        flow: what C takes that runs over many steps or states.
        on_request: why it is asked for by name and stands in no list of all functions; empty for one that does.
        is_missed: whether a generated folder without it says so.
        reference: what the reference calls the outputs, where it does not call them as the C does.
        longest_checked: beyond so many links its reference takes too long for the self-test.
    """

    name: str
    doc: str
    arguments: tuple[Argument, ...] = ()
    absent: tuple[Absence, ...] = ()
    derivative: Derivative | None = None
    flow: Flow | None = None
    on_request: str = ""
    is_missed: bool = True
    reference: tuple[str, ...] = ()
    longest_checked: int | None = None

    def absence(self, kind: Kind) -> Absence | None:
        """Why such a chain has no such function; None when it has it."""
        return next((reason for reason in self.absent if reason.when(kind)), None)

    def arguments_of(self, chain: Chain) -> tuple[Argument, ...]:
        """The arguments that it has on a chain."""
        return tuple(argument for argument in self.arguments if argument.present(chain))

    def outputs_of(self, chain: Chain) -> tuple[Argument, ...]:
        """The results that it has on a chain."""
        return tuple(argument for argument in self.arguments_of(chain) if argument.direction == "out")

    def outputs_in_reference(self, chain: Chain) -> dict[str, str]:
        """The reference's name of every result, by its name in C.

        Raises:
            ContractError: The row names more or fewer results than it has.
        """
        names = [argument.name for argument in self.outputs_of(chain)]
        if self.reference and len(self.reference) != len(names):
            problem = f"names {len(self.reference)} results of its reference and has {len(names)}"
            remedy = "name each of them, or leave the names away"
            raise ContractError("function", self.name, problem, remedy, missing="row")
        return dict(zip(names, self.reference or names, strict=True))

    def meanings(self, chain: Chain) -> dict[str, str]:
        """One line for the header on every argument, by its name."""
        return {argument.name: argument.explained(chain) for argument in self.arguments_of(chain)}
