"""The rows of `contract.flows` as C: structs, constants, arguments and what a header says of each."""

from __future__ import annotations

from typing import Final

from phichain.contract.chain import Chain, worded
from phichain.contract.flow import Field, Flow, Passed, Struct
from phichain.contract.flows import SCALARS

_PLAIN: Final = ("int", "unsigned long", "size_t")
#: Columns that numbers of the scene's type leave free for the field's name before the remark beside it.
_REMARKS_AT: Final = 10


def struct_lines(struct: Struct, chain: Chain) -> list[str]:
    """The fields of a struct, one a line.

    Args:
        struct: the struct.
        chain: whose it is.
    """
    return [_field(field, chain, struct.remarks_at) for field in struct.fields_of(chain)]


def _field(field: Field, chain: Chain, remarks_at: int) -> str:
    kind = _c_type(field.type, chain)
    star, extent = "*" if field.is_pointer else "", f"[{field.extent(chain)}]" if field.extent else ""
    name = f"{star}{field.name}{extent};"
    remark = worded(field.doc, chain)
    if not remark:
        return f"{kind} {name}"
    if field.type == "real":
        name = f"{name:{_REMARKS_AT}}"
    line = f"{kind} {name}"
    return f"{line:{remarks_at if field.type in _PLAIN else 0}} /* {remark} */"


def outcome_lines(flow: Flow, chain: Chain) -> list[str]:
    """The constants that say how a flow ended, one a line."""
    endings = [
        f"{outcome.name.upper().replace(' ', '_')} = {outcome.number}{',' if outcome is not flow.outcomes[-1] else ''}"
        for outcome in flow.outcomes
    ]
    width = max(map(len, endings))
    prefix = f"{chain.name.upper()}_{flow.prefix}"
    return [
        f"{prefix}{ending:{width}} /* {outcome.doc} */"
        for ending, outcome in zip(endings, flow.outcomes, strict=True)
    ]


def scalar_constants(flow: Flow, chain: Chain) -> str:
    """The constants that say which scalar an event looks at."""
    prefix = f"{chain.name.upper()}_{flow.prefix}"
    return ", ".join(f"{prefix}OF_{name.upper()} = {number}" for number, name in enumerate(SCALARS))


def arguments(flow: Flow, chain: Chain, definition: bool) -> list[str]:
    """The arguments as they are declared, or defined."""
    return [_argument(argument, chain, definition) for argument in flow.arguments_of(chain)]


def _argument(argument: Passed, chain: Chain, definition: bool) -> str:
    kind = _c_type(argument.type, chain)
    if argument.form == "value":
        return f"{kind} {argument.name}"
    const = "const " if argument.direction == "in" else ""
    if argument.form == "pointer":
        return f"{const}{kind} *{argument.name}"
    extent = str(argument.extent(chain)) if argument.extent else ""
    promise = f"{chain.name.upper()}_RESTRICT " if definition and argument.is_restrict else ""
    return f"{const}{kind} {argument.name}[{f'{promise}{extent}'.strip()}]"


def documented(flow: Flow, chain: Chain) -> list[tuple[str, str, str]]:
    """What a header says of the arguments: (name, direction, meaning)."""
    return [
        (argument.heading or argument.name, argument.direction, worded(argument.doc, chain))
        for argument in flow.arguments_of(chain)
        if argument.doc
    ]


def passed_on(flow: Flow, chain: Chain) -> str:
    """All arguments, handed to another function that takes them."""
    return ", ".join(argument.name for argument in flow.arguments_of(chain))


def _c_type(name: str, chain: Chain) -> str:
    """A type as a scene's C spells it."""
    return name if name in _PLAIN else f"{chain.name}_{name}"
