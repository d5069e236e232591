"""A Program whose memory is a struct of its caller's: cells that come in and cells that go out are the same fields."""

from __future__ import annotations

from phichain.emit.c.function import CFunction, Writer
from phichain.emit.c.names import CNames
from phichain.emit.c.parts import declaration
from phichain.ir.nodes import Cell, Program
from phichain.lowering.laws import NEXT


class _MemoryWriter(Writer):
    """Reads NAME and writes NAME_next as `state->NAME`."""

    def __init__(self, program: Program, names: CNames, fields: frozenset[str]) -> None:
        super().__init__(program, names, {})
        self.fields = {name: f"state->{name}" for name in fields} | {f"{name}{NEXT}": f"state->{name}" for name in fields}
        self.taken |= {"state"}

    def target(self, cell: Cell) -> str:
        field = self.fields.get(cell.array)
        return super().target(cell) if field is None else f"{field}[{cell.index}]"


def function_with_memory(program: Program, names: CNames, fields: frozenset[str]) -> CFunction:
    """The body of one function.

    Args:
        program: the function, all of whose stores stand behind all that it computes, each from a named value.
        names: spelling.
        fields: names of the memory's fields.
    """
    writer = _MemoryWriter(program, names, fields)
    writer.arrays()
    writer.block(program.body, 1)
    return CFunction(tuple(writer.lines), frozenset(writer.uses))


def declared_with_memory(name: str, program: Program, fields: frozenset[str], prefix: str, definition: bool) -> str:
    """How that function is declared: the state first, then what the Program takes and gives beside it."""
    hidden = fields | {f"{field}{NEXT}" for field in fields}
    arguments = [f"{prefix}_state *state"]
    arguments += [declaration(array, prefix, False, definition) for array in program.inputs if array.name not in hidden]
    arguments += [declaration(array, prefix, True, definition) for array in program.outputs if array.name not in hidden]
    return f"void {name}({', '.join(arguments)})"
