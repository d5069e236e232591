"""Programs as the functions of one C file: each printed once, with what a caller, a header and a manifest say of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from textwrap import wrap
from types import MappingProxyType

from phichain.contract.functions import ROWS
from phichain.emit.c.comment import Comments
from phichain.emit.c.function import CFunction, c_function
from phichain.emit.c.layout import WIDTH, laid_out
from phichain.emit.c.names import CNames
from phichain.emit.c.parts import declaration, words
from phichain.emit.c.sincos import sets_pairs
from phichain.emit.c.storage import own_storage, shared_storage
from phichain.ir.nodes import Program
from phichain.ir.passes import count_operations
from phichain.scene import Scene

Tables = dict[tuple[str, tuple[Fraction, ...]], str]


@dataclass(frozen=True)
class PrintedFunction:
    """One Program as C.

    Attributes:
        program: what was printed.
        symbol: its name in C.
        comment: what stands above its definition: its doc and the named quantities of its body.
        is_static: whether it is seen in its file alone.
        prototype: its declaration.
        definition: its arguments as they stand above its body.
        arguments: what a header says of each, as lines of a comment.
        counts: operations by kind.
        cost: what a header says of its cost.
        lines: its body.
        uses: kernels that it leans on: "sincos", "sincos_pairs", "bessel", "math".
        ignored: arguments of the contract that it has no use for.
    """

    program: Program
    symbol: str
    comment: tuple[str, ...]
    is_static: bool
    prototype: str
    definition: str
    arguments: tuple[str, ...]
    counts: Mapping[str, int]
    cost: str
    lines: tuple[str, ...]
    uses: frozenset[str]
    ignored: tuple[str, ...]

    @property
    def name(self) -> str:
        """Its name in the contract."""
        return self.program.name

    @property
    def doc(self) -> str:
        """What it computes, in one line."""
        return self.program.doc

    @property
    def operations(self) -> int:
        """How many operations one call takes."""
        return sum(self.counts.values())

    @property
    def form(self) -> str:
        """How its code runs."""
        return "straight-line code" if self.program.is_straight_line else "loops"


@dataclass(frozen=True)
class PrintedPrograms:
    """Some Programs of a scene as C.

    Attributes:
        functions: one a Program, callees first.
        tables: the lines that define their constants.
        uses: kernels that they lean on.
    """

    functions: tuple[PrintedFunction, ...]
    tables: tuple[str, ...]
    uses: frozenset[str]


def print_programs(scene: Scene, helpers: Mapping[str, Program], wanted: Mapping[str, Program]) -> PrintedPrograms:
    """Print Programs.

    Args:
        scene: whose they are.
        helpers: those that are seen in their file alone; they come first, so that each is known before it is called.
        wanted: those that a header declares.
    """
    programs = {**helpers, **wanted}
    names = CNames(scene.name, scene.real, _tables(scene, programs), is_plain=scene.trig is not None, has_pairs=sets_pairs(scene))
    symbols, comments = {name: f"{scene.name}_{name}" for name in programs}, Comments(scene)
    functions = tuple(
        _function(scene, program, c_function(program, names, symbols), name in helpers, comments)
        for name, program in programs.items()
    )
    uses = frozenset[str]().union(*(function.uses for function in functions))
    return PrintedPrograms(functions, tuple(_table_lines(names)), uses)


def _tables(scene: Scene, programs: Mapping[str, Program]) -> Tables:
    """One file-scope name for each distinct table."""
    tables: Tables = {}
    for program in programs.values():
        for name, values in program.tables.items():
            if (name, values) not in tables:
                number = 1 + sum(name == other for other, _ in tables)
                tables[name, values] = f"{scene.name}_{name}_table{number if number > 1 else ''}"
    return tables


def _table_lines(names: CNames) -> list[str]:
    lines = []
    for (_, values), table in names.tables.items():
        numbers = ", ".join(names.number(value).text for value in values)
        lines += laid_out(f"static const {names.type} {table}[{len(values)}] = {{{numbers}}};")
    return lines


def _function(
    scene: Scene, program: Program, body: CFunction, is_static: bool, comments: Comments
) -> PrintedFunction:
    symbol, ignored, counts = f"{scene.name}_{program.name}", _ignored(program, body), count_operations(program)
    head = f"{'static ' if is_static else ''}void {symbol}("
    definition = "\n".join(laid_out(f"{head}{', '.join(_declared(scene, program, definition=True))})"))
    return PrintedFunction(
        program=program,
        symbol=symbol,
        comment=comments.above(program.name, program.doc, body.lines),
        is_static=is_static,
        prototype="\n".join(laid_out(f"void {symbol}({', '.join(_declared(scene, program, definition=False))});")),
        definition=definition.removeprefix(head).removesuffix(")"),
        arguments=_arguments(scene, program, ignored),
        counts=MappingProxyType(counts),
        cost=_cost(scene, program, sum(counts.values())),
        lines=body.lines,
        uses=body.uses,
        ignored=ignored,
    )


def _ignored(program: Program, body: CFunction) -> tuple[str, ...]:
    """Arguments of the contract that this scene's function has no use for."""
    names = [*(["p"] if program.params else []), *(array.name for array in program.inputs)]
    used = words("\n".join(body.lines))
    return tuple(name for name in names if name not in used)


def _declared(scene: Scene, program: Program, definition: bool) -> list[str]:
    declared = [f"const {scene.name}_params *p"] if program.params else []
    declared += [declaration(array, scene.name, False, definition) for array in program.inputs]
    declared += [declaration(array, scene.name, True, definition) for array in program.outputs]
    kept = f"{scene.name.upper()}_REGISTER " if definition and scene.trig is not None else ""
    return [f"{kept}{one}" for one in declared]


def _arguments(scene: Scene, program: Program, ignored: tuple[str, ...]) -> tuple[str, ...]:
    """What the header says about every argument."""
    known = ROWS[program.name].meanings(scene) if program.name in ROWS else {}
    explained = [("p", "in", "runtime parameters")] if program.params else []
    explained += [(array.name, "in", known.get(array.name, array.doc)) for array in program.inputs]
    explained += [(array.name, "out", known.get(array.name, array.doc)) for array in program.outputs]
    width = max(len(name) for name, _, _ in explained)
    rows = [
        (f"{name:{width}}  {direction:3}", text + (" (without influence)" if name in ignored else ""))
        for name, direction, text in explained
    ]
    return tuple(explained_rows(rows))


def explained_rows(rows: Sequence[tuple[str, str]]) -> list[str]:
    """Names and what they mean, as lines of a comment."""
    width = max(len(name) for name, _ in rows)
    lines: list[str] = []
    for name, text in rows:
        head = f"{name:{width}}  "
        lines += wrap(text, WIDTH - 5, initial_indent=head, subsequent_indent=" " * len(head), break_on_hyphens=False)
    return lines


def _cost(scene: Scene, program: Program, operations: int) -> str:
    stack = _work_bytes(scene, program)
    if program.is_straight_line:
        return f"{operations} operations, straight-line code."
    return f"{operations} operations in loops{f', {stack} bytes of arrays on the stack' if stack else ''}."


def _work_bytes(scene: Scene, program: Program) -> int:
    """Bytes of work arrays while the function or one that it calls runs."""
    own = (own_storage if scene.trig is None else shared_storage)(program).cells * (8 if scene.real == "double" else 4)
    return own + max((_work_bytes(scene, callee) for callee in program.callees.values()), default=0)
