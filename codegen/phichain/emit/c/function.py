"""One Program as the body of one C99 function.

Values used once and without a name of their own are written where they are used; everything else becomes a `const`
variable. Sines and cosines of one generation are computed together, so that the kernel can run on vectors.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from phichain.emit.c.handed_on import cells_handed_on
from phichain.emit.c.names import SIDE_BY_SIDE, CNames
from phichain.emit.c.parts import assignment, first_result, in_pieces, words
from phichain.emit.c.sheet import Sheet
from phichain.emit.c.trig_batches import TrigBatch, TrigBatches
from phichain.emit.c.turns import cells_read_again, rows
from phichain.emit.expressions import SUM, Text, infix
from phichain.emit.inlining import used_once
from phichain.ir.nodes import (
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
    walk,
)

#: Longest expression that is written in place instead of getting a variable (twice that where it is all there is).
_LONGEST = 96


@dataclass(frozen=True)
class CFunction:
    """The text of one function body and what it leans on."""

    lines: tuple[str, ...]
    uses: frozenset[str]


def c_function(
    program: Program, names: CNames, callees: dict[str, str], working: frozenset[str] = frozenset()
) -> CFunction:
    """Print a Program.

    Args:
        program: the function; straight-line or with loops.
        names: spelling.
        callees: C name of every Program that this one calls.
        working: Programs whose arrays stand in the struct that `work` points to, which they are given; see `emit.c.sheet.work_field`.
    """
    writer = Writer(program, names, callees, working)
    writer.arrays()
    writer.block(program.body, 1)
    return CFunction(tuple(writer.lines), frozenset(writer.uses))


class Writer(Sheet):
    """Prints one Program; `emit.c.lanes` prints the same for several trajectories at once."""

    def __init__(
        self, program: Program, names: CNames, callees: dict[str, str], working: frozenset[str] = frozenset()
    ) -> None:
        super().__init__(program, names, callees, working)
        #: The kernel for sines and cosines.
        self.sincos_symbol = f"{names.prefix}_sincos"
        self.in_place = used_once(program.body)
        self.stored = {s.value.name for s in walk(program.body) if isinstance(s, Store) and isinstance(s.value, Local)}
        self.results = first_result(program) if program.is_straight_line else None
        self.trig = TrigBatches(program.body)
        self.bessel_calls: dict[str, str] = {}

    # --- statements -------------------------------------------------------------------------------------------------

    def block(self, statements: tuple[Statement, ...], depth: int) -> None:
        outside, self.bessel_calls = self.bessel_calls, {}
        for statement in statements:
            if statement is self.results:
                self.gap(depth)
            self.statement(statement, depth)
        self.bessel_calls = outside

    def statement(self, statement: Statement, depth: int) -> None:
        match statement:
            case Op():
                if statement.result not in self.texts:
                    self.op(statement, depth)
            case Store(cell, value):
                self.line(depth, f"{self.target(cell)} = {self.given(cell.array, value)};")
            case SinCos():
                self.sincos(statement, depth)
            case For():
                self.loop(statement, depth)
            case Call(callee, inputs, outputs):
                arguments = [*(["p"] if self.program.params else []), *map(self.argument, inputs), *map(self.argument, outputs)]
                arguments += ["work"] if callee in self.working else []
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
        if op.result in self.in_place and len(text.text) <= _LONGEST * (2 if op.result in self.stored else 1):
            self.texts[op.result] = text
            return
        name = self.fresh("t") if op.result.startswith("_") else op.result
        self.texts[op.result] = self.variable(depth, name, text.text, self.kind(op.result))

    def expression(self, op: Op) -> Text:
        args = [self.operand(arg) for arg in op.args]
        text = infix(op.kind, args)
        if text is not None:
            return self.names.negated_last(text) if op.kind == "mul" and isinstance(op.args[0], Const) else text
        if op.kind == "select":
            a, b, below, above = (arg.within(SUM) for arg in args)
            return Text(f"({a} < {b} ? {below} : {above})")
        self.uses.add("math")
        return Text(f"{self.names.libm(op.kind)}({args[0].text})")

    # --- loops ------------------------------------------------------------------------------------------------------

    def loop(self, loop: For, depth: int) -> None:
        self.gap(depth)
        for carry in loop.carries:
            self.line(depth, f"{self.register}{self.kind(carry.name)} {carry.name} = {self.given(carry.name, carry.initial)};")
            self.texts[carry.name] = Text(carry.name)
        if not loop.body:
            return
        variable = loop.variable
        if loop.is_lanes:
            self.lanes_loop(depth)
        condition, advance = (f"< {loop.stop}", "++") if loop.step > 0 else (f">= {loop.stop + 1}", "--")
        self.line(depth, f"for ({self.register}int {variable} = {loop.start}; {variable} {condition}; {advance}{variable}) {{")
        with self.at_hand(loop, depth + 1):
            self.block(loop.body, depth + 1)
            self.advance(loop, depth + 1)
        self.line(depth, "}")
        self.gap(depth)

    def lanes_loop(self, depth: int) -> None:
        """What stands before a loop over lanes, so that the compiler makes a vector of its turns instead of a row of statements."""
        self.line(depth, f"{self.names.prefix.upper()}_LANES")

    @contextmanager
    def at_hand(self, loop: For, depth: int) -> Iterator[None]:
        """Within a turn: pointers to its records, and cells that it reads again; where a host's vectors are written for, nothing."""
        outside = self.rows_at, self.cells_at
        self.rows_at, self.cells_at = dict(self.rows_at), dict(self.cells_at)
        if self.register:
            apart = self.scalars | self.pointers
            for name, row in rows(loop, self.storage.fields, apart | set(self.pairs), self.rows_at).items():
                pointer = self.fresh(f"{row.array}_at_" if row.array else "at_")
                kind = self.kind(row.array) if row.array else f"struct {self.record_type}"
                first = self.target(Cell(row.array, row.start)) if row.array else f"{self.records}[{row.start}]"
                self.line(depth, f"{self.register}{'' if row.is_written else 'const '}{kind} *const {pointer} = &{first};")
                self.rows_at[name] = pointer, row.start.offset
            for cell in cells_read_again(loop, apart | {array for array, _ in self.rows_at}):
                self.cells_at[cell] = self.variable(depth, self.fresh(f"{self.named_after(cell)}_"), self.target(cell), self.kind(cell.array))
        for cell in cells_handed_on(loop, self.handed) if loop.is_lanes else ():
            self.cells_at[cell] = self.variable(depth, f"{cell.array}_before", self.target(cell), self.kind(cell.array))
        yield
        self.rows_at, self.cells_at = outside

    def advance(self, loop: For, depth: int) -> None:
        """Carried scalars move on together: what still needs an old value is put aside first."""
        moves = [(c.name, self.given(c.name, c.following)) for c in loop.carries if c.following != Local(c.name)]
        for position, (name, text) in enumerate(moves):
            if {before for before, _ in moves[:position]} & words(text):
                moves[position] = (name, self.variable(depth, f"next_{name}", text, self.kind(name)).text)
        for name, text in moves:
            self.line(depth, assignment(name, text))

    def sincos(self, statement: SinCos, depth: int) -> None:
        angle = self.argument(statement.angle) if not statement.offset else f"&{statement.angle}[{statement.offset}]"
        if statement.sine in self.pairs:
            self.uses.add("sincos_pairs")
            self.line(depth, f"{self.sincos_symbol}_pairs({statement.count}, {angle}, {self.pairs[statement.sine][0]});")
            return
        self.uses.add("sincos")
        arguments = f"{statement.count}, {angle}, {self.argument(statement.sine)}, {self.argument(statement.cosine)}"
        self.line(depth, f"{self.sincos_symbol}({arguments});")

    # --- sines, cosines and Bessel functions of straight-line code ---------------------------------------------------

    def trig_batch(self, op: Op, depth: int) -> None:
        """Compute all sines and cosines of this operation's generation, once."""
        batch = self.trig.batch_of(op)
        suffix = self.trig.suffix(batch)
        count, angle = len(batch.angles), self.angles(batch, suffix, depth)
        if self.names.has_pairs:
            self.paired_batch(batch, f"{SIDE_BY_SIDE}{suffix}", angle, depth)
            return
        self.uses.add("sincos")
        extent, address = (f"[{count}]", "") if count > 1 else ("", "&")
        self.line(depth, f"{self.element} sine{suffix}{extent}, cosine{suffix}{extent};")
        self.line(depth, f"{self.sincos_symbol}({count}, {angle}, {address}sine{suffix}, {address}cosine{suffix});")
        self.gap(depth)
        for position, operand in enumerate(batch.angles):
            cell = f"[{position}]" if count > 1 else ""
            for result, kind in self.trig.results[operand]:
                self.texts[result] = Text(f"{'sine' if kind == 'sin' else 'cosine'}{suffix}{cell}")

    def paired_batch(self, batch: TrigBatch, pairs: str, angle: str, depth: int) -> None:
        """The same by a kernel that sets sines and cosines side by side."""
        self.uses.add("sincos_pairs")
        self.line(depth, f"{self.element} {pairs}[{len(batch.angles)}][2];")
        self.line(depth, f"{self.sincos_symbol}_pairs({len(batch.angles)}, {angle}, {pairs});")
        self.gap(depth)
        for position, operand in enumerate(batch.angles):
            for result, kind in self.trig.results[operand]:
                self.texts[result] = Text(f"{pairs}[{position}][{int(kind == 'cos')}]")

    def angles(self, batch: TrigBatch, suffix: str, depth: int) -> str:
        """The array where the angles of a generation stand side by side."""
        angle = self.run_of_cells(batch.angles)
        if angle is None:
            angle = f"angle{suffix}"
            texts = [self.ensured(operand, depth).text for operand in batch.angles]
            if len(texts) == 1:
                self.line(depth, f"const {self.element} {angle} = {texts[0]};")
                return f"&{angle}"
            self.side_by_side(angle, texts, depth)
        return angle

    def side_by_side(self, array: str, texts: list[str], depth: int) -> None:
        """An array of values, written in pieces as wide as those it is read in."""
        self.line(depth, f"{self.element} {array}[{len(texts)}];")
        for statement, kernel in in_pieces(self.names.prefix, array, texts, (1,) if self.names.is_plain else (4, 2, 1)):
            self.line(depth, statement)
            self.uses |= kernel

    def run_of_cells(self, angles: list[Operand]) -> str | None:
        """The array where the angles lie side by side, if they do."""
        first = angles[0]
        if not isinstance(first, Cell) or first.array in (self.scalars | self.params | set(self.storage.fields)):
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
        waiting = [operand]
        while waiting:  # chains of operations may be longer than Python's stack
            last = waiting[-1]
            if not isinstance(last, Local) or last.name in self.texts:
                waiting.pop()
                continue
            op = self.trig.definitions[last.name]
            missing = [a for a in op.args if isinstance(a, Local) and a.name not in self.texts]
            if missing:
                waiting += reversed(missing)
            else:
                self.op(op, depth)
        return self.operand(operand)

    def bessel(self, op: Op, depth: int) -> None:
        """J_0 to J_4 of one argument come from one call a block."""
        self.uses.add("bessel")
        argument = self.operand(op.args[0]).text
        if argument not in self.bessel_calls:
            array = self.bessel_calls[argument] = self.fresh("bessel_")
            self.line(depth, f"{self.names.type} {array}[5];")
            self.line(depth, f"{self.names.prefix}_bessel({argument}, {array});")
        self.texts[op.result] = Text(f"{self.bessel_calls[argument]}[{op.kind[-1]}]")
