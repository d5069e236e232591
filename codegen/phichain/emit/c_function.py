"""One Program as the body of one C99 function.

Values used once and without a name of their own are written where they are used; everything else becomes a `const`
variable. Sines and cosines of one generation are computed together, so that the kernel can run on vectors.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from fractions import Fraction

from phichain.emit.expressions import Text, double_literal, float_literal, infix
from phichain.program.nodes import (
    Array,
    Call,
    Cell,
    Const,
    For,
    Local,
    Op,
    Operand,
    Program,
    SinCos,
    Statement,
    Store,
)

#: Longest expression that is written in place instead of getting a variable.
_LONGEST = 96


@dataclass(frozen=True)
class CFunction:
    """The text of one function body and what it leans on."""

    lines: tuple[str, ...]
    uses: frozenset[str]


@dataclass(frozen=True)
class CNames:
    """How a scene's C is spelt.

    Attributes:
        prefix: the scene's name, before every external symbol.
        real: "double" or "float".
        tables: file-scope name of each table, by (name, values).
    """

    prefix: str
    real: str
    tables: dict[tuple[str, tuple[Fraction, ...]], str]

    def number(self, value: Fraction) -> Text:
        """A numeric literal of the scene's type."""
        return float_literal(value) if self.real == "float" else double_literal(value)

    def libm(self, name: str) -> str:
        """The C library's function for the scene's type."""
        return f"{name}f" if self.real == "float" else name


def c_function(program: Program, names: CNames, callees: dict[str, str]) -> CFunction:
    """Print a Program.

    Args:
        program: the function; straight-line or with loops.
        names: spelling.
        callees: C name of every Program that this one calls.
    """
    writer = _Writer(program, names, callees)
    writer.arrays()
    writer.block(program.body, 1)
    return CFunction(tuple(writer.lines), frozenset(writer.uses))


@dataclass
class _Scope:
    """Definitions of one block that wait to be written where they are used."""

    pending: dict[str, Op] = field(default_factory=dict)


class _Writer:
    def __init__(self, program: Program, names: CNames, callees: dict[str, str]) -> None:
        self.program, self.names, self.callees = program, names, callees
        self.lines: list[str] = []
        self.uses: set[str] = set()
        self.texts: dict[str, Text] = {}
        self.counts = _use_counts(program.body)
        self.deep = _used_deeper(program.body)
        self.scalars = {a.name for a in (*program.inputs, *program.params) if a.shape == ()}
        self.pointers = {a.name for a in program.outputs if a.shape == ()}
        self.params = {a.name for a in program.params}
        self.trig = _Trig(program.body)
        self.fresh = 0

    # --- declarations -----------------------------------------------------------------------------------------------

    def arrays(self) -> None:
        for array in self.program.work:
            self.line(1, f"{self.names.prefix}_real {array.name}[{array.size}];")

    def line(self, depth: int, text: str) -> None:
        self.lines.append("    " * depth + text)

    # --- statements -------------------------------------------------------------------------------------------------

    def block(self, statements: tuple[Statement, ...], depth: int) -> None:
        for statement in statements:
            match statement:
                case Op(result=result):
                    if result not in self.texts:
                        self.op(statement, depth)
                case Store(cell, value):
                    self.line(depth, f"{self.target(cell)} = {self.operand(value).text};")
                case SinCos():
                    self.sincos(statement, depth)
                case For():
                    self.loop(statement, depth)
                case Call(callee, inputs, outputs):
                    arguments = [*(["p"] if self.program.params else []), *map(self.argument, inputs), *outputs]
                    self.line(depth, f"{self.callees[callee]}({', '.join(arguments)});")
                    self.uses.add(callee)

    def op(self, op: Op, depth: int) -> None:
        if op.kind in ("sin", "cos"):
            self.trig_batch(op, depth)
            return
        if op.kind.startswith("besselj"):
            self.bessel(op, depth)
            return
        text = self.expression(op)
        anonymous = op.result.startswith("_")
        once = self.counts[op.result] == 1 and op.result not in self.deep
        if anonymous and once and len(text.text) <= _LONGEST:
            self.texts[op.result] = text
            return
        name = op.result
        if anonymous:
            self.fresh += 1
            name = f"t{self.fresh}"
        self.line(depth, f"const {self.names.prefix}_real {name} = {text.text};")
        self.texts[op.result] = Text(name)

    def expression(self, op: Op) -> Text:
        args = [self.operand(arg) for arg in op.args]
        text = infix(op.kind, args)
        if text is not None:
            return text
        self.uses.add("math")
        return Text(f"{self.names.libm(op.kind)}({args[0].text})")

    def loop(self, loop: For, depth: int) -> None:
        for carry in loop.carries:
            self.line(depth, f"{self.names.prefix}_real {carry.name} = {self.operand(carry.initial).text};")
            self.texts[carry.name] = Text(carry.name)
        if not loop.body:
            return
        variable, comparison, advance = loop.variable, "<" if loop.step > 0 else ">", "++" if loop.step > 0 else "--"
        head = f"for (int {variable} = {loop.start}; {variable} {comparison} {loop.stop}; {advance}{variable})"
        self.line(depth, f"{head} {{")
        self.block(loop.body, depth + 1)
        self.advance(loop, depth + 1)
        self.line(depth, "}")

    def advance(self, loop: For, depth: int) -> None:
        """Carried scalars move on together: what still needs an old value is put aside first."""
        carried = [carry.name for carry in loop.carries]
        moves = [(c.name, self.operand(c.following).text) for c in loop.carries if c.following != Local(c.name)]
        written: set[str] = set()
        for name, text in moves:
            written.add(name)
        for position, (name, text) in enumerate(moves):
            overwritten = {before for before, _ in moves[:position]}
            if overwritten & words(text) & set(carried):
                moves[position] = (name, f"next_{name}")
                self.line(depth, f"const {self.names.prefix}_real next_{name} = {text};")
        for name, text in moves:
            self.line(depth, f"{name} = {text};")

    def sincos(self, statement: SinCos, depth: int) -> None:
        self.uses.add("sincos")
        angle = statement.angle if not statement.offset else f"&{statement.angle}[{statement.offset}]"
        arguments = f"{statement.count}, {angle}, {statement.sine}, {statement.cosine}"
        self.line(depth, f"{self.names.prefix}_sincos({arguments});")

    # --- sines, cosines and Bessel functions of straight-line code ---------------------------------------------------

    def trig_batch(self, op: Op, depth: int) -> None:
        """Compute all sines and cosines of this operation's generation, once."""
        self.uses.add("sincos")
        batch = self.trig.batch_of(op)
        suffix = "" if batch.number == 0 else f"_{batch.number + 1}"
        count = len(batch.angles)
        angle = self.run_of_cells(batch.angles)
        if angle is None:
            angle = f"angle{suffix}"
            texts = [self.ensured(operand, depth).text for operand in batch.angles]
            self.line(depth, f"const {self.names.prefix}_real {angle}[{count}] = {{{', '.join(texts)}}};")
        self.line(depth, f"{self.names.prefix}_real sine{suffix}[{count}], cosine{suffix}[{count}];")
        self.line(depth, f"{self.names.prefix}_sincos({count}, {angle}, sine{suffix}, cosine{suffix});")
        for position, operand in enumerate(batch.angles):
            for result, kind in self.trig.results[operand]:
                array = "sine" if kind == "sin" else "cosine"
                self.texts[result] = Text(f"{array}{suffix}[{position}]")

    def run_of_cells(self, angles: list[Operand]) -> str | None:
        """The array where the angles lie side by side, if they do."""
        first = angles[0]
        if not isinstance(first, Cell) or first.array in self.scalars or first.array in self.params:
            return None
        for position, angle in enumerate(angles):
            if not isinstance(angle, Cell) or angle.array != first.array:
                return None
            if angle.index != first.index + position:
                return None
        start = first.index.offset
        return f"&{first.array}[{start}]" if start else first.array

    def ensured(self, operand: Operand, depth: int) -> Text:
        """An operand of a batch, computed now even when its turn comes later."""
        if isinstance(operand, Local) and operand.name not in self.texts:
            op = self.trig.definitions[operand.name]
            for arg in op.args:
                self.ensured(arg, depth)
            self.op(op, depth)
        return self.operand(operand)

    def bessel(self, op: Op, depth: int) -> None:
        """J_0 to J_4 of one argument come from one call."""
        self.uses.add("bessel")
        argument = self.operand(op.args[0]).text
        key = f"bessel of {argument}"
        if key not in self.texts:
            self.fresh += 1
            array = f"bessel_{self.fresh}"
            self.line(depth, f"{self.names.prefix}_real {array}[5];")
            self.line(depth, f"{self.names.prefix}_bessel({argument}, {array});")
            self.texts[key] = Text(array)
        self.texts[op.result] = Text(f"{self.texts[key].text}[{op.kind[-1]}]")

    # --- operands ---------------------------------------------------------------------------------------------------

    def operand(self, operand: Operand) -> Text:
        if isinstance(operand, Const):
            return self.names.number(operand.value)
        if isinstance(operand, Local):
            return self.texts[operand.name]
        return Text(self.target(operand))

    def target(self, cell: Cell) -> str:
        if cell.array in self.pointers:
            return f"*{cell.array}"
        owner = f"p->{cell.array}" if cell.array in self.params else cell.array
        if cell.array in self.program.tables:
            owner = self.names.tables[cell.array, self.program.tables[cell.array]]
        return owner if cell.array in self.scalars else f"{owner}[{cell.index}]"

    def argument(self, name: str) -> str:
        return f"p->{name}" if name in self.params else name


@dataclass(frozen=True)
class _Batch:
    number: int
    angles: list[Operand]


class _Trig:
    """Sines and cosines of straight-line code, grouped by how many sines lie beneath their angle."""

    def __init__(self, statements: tuple[Statement, ...]) -> None:
        self.definitions = {s.result: s for s in statements if isinstance(s, Op)}
        self.results: dict[Operand, list[tuple[str, str]]] = {}
        generation: dict[str, int] = {}
        self.batches: dict[int, _Batch] = {}
        for op in self.definitions.values():
            below = max((generation[a.name] for a in op.args if isinstance(a, Local) and a.name in generation), default=0)
            if op.kind not in ("sin", "cos"):
                generation[op.result] = below
                continue
            generation[op.result] = below + 1
            batch = self.batches.setdefault(below, _Batch(len(self.batches), []))
            if op.args[0] not in self.results:
                batch.angles.append(op.args[0])
            self.results.setdefault(op.args[0], []).append((op.result, op.kind))

    def batch_of(self, op: Op) -> _Batch:
        return next(batch for batch in self.batches.values() if op.args[0] in batch.angles)


def _use_counts(statements: tuple[Statement, ...]) -> Counter[str]:
    counts: Counter[str] = Counter()

    def count(operands: Iterable[Operand]) -> None:
        counts.update(operand.name for operand in operands if isinstance(operand, Local))

    for statement in statements:
        match statement:
            case Op(args=args):
                count(args)
            case Store(value=value):
                count((value,))
            case For(carries=carries, body=body):
                for carry in carries:
                    count((carry.initial, carry.following))
                counts.update(_use_counts(body))
            case _:
                pass
    return counts


def _used_deeper(statements: tuple[Statement, ...]) -> set[str]:
    """Values defined in one block and used inside a loop below it: computed once, outside."""
    used: set[str] = set()
    for statement in statements:
        if isinstance(statement, For):
            used |= set(_use_counts(statement.body)) | _used_deeper(statement.body)
            used |= {c.following.name for c in statement.carries if isinstance(c.following, Local)}
    local = {s.result for s in statements if isinstance(s, Op)}
    inner = set().union(*(_used_deeper(s.body) for s in statements if isinstance(s, For))) if statements else set()
    return (used & local) | inner


def words(text: str) -> set[str]:
    """The identifiers in a piece of C."""
    cleaned = "".join(c if c.isalnum() or c == "_" else " " for c in text)
    return set(cleaned.split())


def declaration(array: Array, prefix: str, is_output: bool, definition: bool) -> str:
    """How an argument is declared: scalars by value or pointer, arrays with their extent."""
    qualifier = "" if is_output else "const "
    if array.shape == ():
        star = "*" if is_output else ""
        return f"{qualifier}{prefix}_real {star}{array.name}"
    restrict = "restrict " if definition and is_output else ""
    return f"{qualifier}{prefix}_real {array.name}[{restrict}{array.size}]"
