"""The records behind `flows`: what the C functions that run over many steps or states take, carry and return."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from phichain.contract.chain import Chain, Words, always


@dataclass(frozen=True)
class Field:
    """One field of a struct.

    Attributes:
        name: its name in C.
        type: "real", "int", "unsigned long", or the name of a struct.
        doc: what the header says beside it; empty for nothing.
        extent: number of entries of an array, None for a single value or a pointer.
        is_pointer: whether it points to such values.
        present: on which chains the struct has it.
    """

    name: str
    type: str
    doc: Words = ""
    extent: Callable[[Chain], int] | None = None
    is_pointer: bool = False
    present: Callable[[Chain], bool] = always


@dataclass(frozen=True)
class Struct:
    """A struct NAME_name.

    Attributes:
        name: the ending of its name.
        fields: its fields, in the order of the C.
        remarks_at: columns that plain types leave free for the field's name before the remark beside it.
    """

    name: str
    fields: tuple[Field, ...]
    remarks_at: int

    def fields_of(self, chain: Chain) -> tuple[Field, ...]:
        """The fields that it has on a chain."""
        return tuple(field for field in self.fields if field.present(chain))


@dataclass(frozen=True)
class Passed:
    """One argument of a flow.

    Attributes:
        name: its name in C.
        type: "real", "unsigned long", "size_t", or the name of a struct.
        direction: "in", "in, out", "out", or "-" for memory that it only works on; what is "in" alone is const in C.
        doc: what the header says of it; empty where another argument's line says it.
        form: by value, as a pointer, or as an array of that many entries.
        extent: number of entries of an array; None where the C says none.
        is_restrict: whether a definition promises that nothing else points there.
        heading: what the header's line begins with, where it speaks of several arguments.
        present: on which chains the flow has it.
    """

    name: str
    type: str
    direction: Literal["in", "in, out", "out", "-"]
    doc: Words
    form: Literal["value", "pointer", "array"] = "value"
    extent: Callable[[Chain], int] | None = None
    is_restrict: bool = False
    heading: str = ""
    present: Callable[[Chain], bool] = always


@dataclass(frozen=True)
class Outcome:
    """One value that a flow returns, or leaves for each of its trajectories.

    Attributes:
        name: in Python; its words joined by underscores end the C constant.
        doc: what the header says of it.
    """

    name: str
    number: int
    doc: str


@dataclass(frozen=True)
class Flow:
    """What a C function takes and returns that runs over many steps or states.

    Attributes:
        arguments: its arguments, in the order of the C.
        returns: the C type of its result.
        carries: the struct that goes on from call to call; None for a flow that has none.
        event: the struct that says where to stop; None for a flow that cannot.
        prefix: what its constants begin with, behind NAME_.
        outcomes: how it, or each of its trajectories, can end.
    """

    arguments: tuple[Passed, ...]
    returns: Literal["int", "size_t", "void"]
    carries: Struct | None = None
    event: Struct | None = None
    prefix: str = ""
    outcomes: tuple[Outcome, ...] = ()

    def arguments_of(self, chain: Chain) -> tuple[Passed, ...]:
        """The arguments that it has on a chain."""
        return tuple(argument for argument in self.arguments if argument.present(chain))
