"""Writes Programs: arithmetic on handles records operations, simplified and shared as they are made.

    b = Builder("energy", doc)
    q = b.input("q", (4,)); out = b.output("out", (4,))
    with b.loop("k", 0, 4) as loop:
        total = loop.carry("total", 0)
        loop.follow(total, b.let("partial", total + q[loop.index]))
        out[loop.index] = total
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from fractions import Fraction

from phichain.ir.algebra import canonical, simplify
from phichain.ir.handles import ArrayRef, Expr, Index, Loop, Number
from phichain.ir.nodes import (
    Affine,
    Array,
    Call,
    Carry,
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


class _Block:
    """Statements under construction, and the values visible there."""

    def __init__(self) -> None:
        self.statements: list[Statement] = []
        self.shared: dict[tuple[str, tuple[Operand, ...] | frozenset[Operand]], Operand] = {}


class Builder:
    """Records the statements of one Program."""

    def __init__(self, name: str, doc: str) -> None:
        self.name, self.doc = name, doc
        self.params: list[Array] = []
        self.inputs: list[Array] = []
        self.outputs: list[Array] = []
        self.work: list[Array] = []
        self.tables: dict[str, tuple[Fraction, ...]] = {}
        self.callees: dict[str, Program] = {}
        self._blocks = [_Block(), _Block()]  # what is computed first of all, then the body
        self._open_loops: dict[str, tuple[int, int]] = {}
        self._ops: dict[str, Op] = {}
        self._names: dict[str, int] = {}
        self._renamed: dict[Operand, Operand] = {}  # for handles taken before `let` named their value

    # --- arguments and arrays ---------------------------------------------------------------------------------------

    def param(self, name: str, shape: tuple[int, ...], doc: str = "") -> ArrayRef:
        """A runtime parameter of the scene (a field of the params struct)."""
        return self._declare(self.params, name, shape, doc)

    def input(self, name: str, shape: tuple[int, ...], doc: str = "") -> ArrayRef:
        """An input argument."""
        return self._declare(self.inputs, name, shape, doc)

    def output(self, name: str, shape: tuple[int, ...], doc: str = "") -> ArrayRef:
        """An output argument."""
        return self._declare(self.outputs, name, shape, doc)

    def array(self, name: str, size: int) -> ArrayRef:
        """A work array; each cell is written once and only then read."""
        return self._declare(self.work, self.fresh(name), (size,), "")

    def _declare(self, group: list[Array], name: str, shape: tuple[int, ...], doc: str) -> ArrayRef:
        self._names.setdefault(name, 0)
        group.append(Array(name, shape, doc))
        return ArrayRef(self, name, group[-1].size)

    def table(self, name: str, count: int, entry: Callable[[Index], Expr | Number]) -> ArrayRef:
        """`entry(k)` for k below count: exact constants where they are known, else computed once per call."""
        values = self.known(count, entry)
        if values is not None:
            return self.constants(name, values)
        cells = self.array(name, count)
        with self.loop("k", 0, count) as loop:
            cells[loop.index] = entry(loop.index)
        return cells

    def constants(self, name: str, values: Iterable[Fraction]) -> ArrayRef:
        """A table of exact constants."""
        unique = self.fresh(name)
        self.tables[unique] = tuple(values)
        return ArrayRef(self, unique, len(self.tables[unique]))

    def known(self, count: int, entry: Callable[[Index], Expr | Number]) -> tuple[Fraction, ...] | None:
        """`entry(k)` for k below count as exact numbers; None, and nothing recorded, when one depends on a runtime parameter."""
        self._blocks.append(_Block())
        values = []
        for k in range(count):
            value = self.lift(entry(k)).constant
            if value is None:
                break
            values.append(value)
        self._blocks.pop()
        return tuple(values) if len(values) == count else None

    # --- values -----------------------------------------------------------------------------------------------------

    def lift(self, value: Expr | Number) -> Expr:
        """A number as a handle (floats exactly, as the binary fraction they are)."""
        return Expr(self, self._operand(value))

    def _operand(self, value: Expr | Number) -> Operand:
        if isinstance(value, Expr):
            return self._renamed.get(value.operand, value.operand) if isinstance(value.operand, Local) else value.operand
        return Const(Fraction(value))

    def read(self, array: str, index: Index) -> Expr:
        """The value of a cell; entries of tables whose value is known are numbers at once."""
        affine = Affine(index) if isinstance(index, int) else index
        if array in self.tables:
            values = self.tables[array]
            if not affine.terms:
                return Expr(self, Const(values[affine.offset]))
            if len(set(values)) == 1:
                return Expr(self, Const(values[0]))
        return Expr(self, Cell(array, affine))

    def write(self, array: str, index: Index, value: Expr | Number) -> None:
        """Store a value into a cell."""
        affine = Affine(index) if isinstance(index, int) else index
        self._blocks[-1].statements.append(Store(Cell(array, affine), self.lift(value).operand))

    def apply(self, kind: str, *args: Expr | Number, label: str = "") -> Expr:
        """One operation, simplified and shared."""
        return Expr(self, self._emit(kind, tuple([self._operand(arg) for arg in args]), label))

    def let(self, label: str, value: Expr) -> Expr:
        """Give an intermediate quantity its name, before anything uses it (the first name given stays)."""
        operand, block = self.lift(value).operand, self._blocks[-1]
        if not isinstance(operand, Local) or not operand.name.startswith("_"):
            return value
        for position in range(len(block.statements) - 1, -1, -1):
            statement = block.statements[position]
            if not isinstance(statement, Op) or operand in statement.args:
                return value
            if statement.result == operand.name:
                named = Local(self.fresh(self._own_name(label)))
                block.statements[position] = self._ops[named.name] = Op(named.name, statement.kind, statement.args)
                del self._ops[operand.name]
                self._renamed[operand] = named
                block.shared[(statement.kind, canonical(statement.kind, statement.args))] = named
                return Expr(self, named)
        return value

    def _own_name(self, label: str) -> str:
        """The label; where it is taken, `rate_k` in a loop over k, and beside an array `rate_end`."""
        if label not in self._names:
            return label
        is_array = any(array.name == label for array in (*self.work, *self.outputs, *self.inputs))
        return "_".join([label, *(self._open_loops or (["end"] if is_array else []))])

    def sin(self, x: Expr) -> Expr:
        """Sine of one value; use `sincos` for a run of cells."""
        return self.apply("sin", x)

    def cos(self, x: Expr) -> Expr:
        """Cosine of one value."""
        return self.apply("cos", x)

    def sqrt(self, x: Expr) -> Expr:
        """Square root."""
        return self.apply("sqrt", x)

    def sincos(self, angle: ArrayRef, count: int, padding: int = 0) -> tuple[ArrayRef, ArrayRef]:
        """Work arrays with the sines and cosines of the first `count` cells, and room for `padding` more."""
        sine, cosine = self.array("sine", count + padding), self.array("cosine", count + padding)
        self.sincos_into(sine, cosine, angle, count)
        return sine, cosine

    def sincos_into(self, sine: ArrayRef, cosine: ArrayRef, angle: ArrayRef, count: int) -> None:
        """Fill the first `count` cells of two work arrays with the sines and cosines of a run of cells."""
        assert isinstance(angle.offset, int) and angle.stride == 1
        self._blocks[-1].statements.append(SinCos(sine.name, cosine.name, angle.name, angle.offset, count))

    def call(self, callee: Program, inputs: list[ArrayRef], sizes: dict[str, int]) -> list[ArrayRef]:
        """Apply another Program of the scene; returns work arrays that hold its outputs."""
        self.callees[callee.name] = callee
        outputs = [self.array(name, size) for name, size in sizes.items()]
        names = tuple(ref.name for ref in inputs)
        self._blocks[-1].statements.append(Call(callee.name, names, tuple(ref.name for ref in outputs)))
        return outputs

    # --- control ----------------------------------------------------------------------------------------------------

    @contextmanager
    def loop(self, variable: str, start: Index, stop: Index, step: int = 1, is_lanes: bool = False) -> Iterator[Loop]:
        """A counted loop; everything recorded inside is its body, done for all lanes at once where it can be."""
        unique = variable
        while unique in self._open_loops:
            unique += "_inner"
        first = Affine(start) if isinstance(start, int) else start
        end = Affine(stop) if isinstance(stop, int) else stop
        hull = self._hull(first, end, step)
        self._open_loops[unique] = hull
        loop = Loop(self, unique)
        self._blocks.append(_Block())
        yield loop
        block = self._blocks.pop()
        del self._open_loops[unique]
        carries = tuple(
            Carry(name, initial, self._renamed.get(following, following))
            for name, (initial, following) in loop.carries.items()
        )
        self._blocks[-1].statements.append(For(unique, first, end, step, carries, tuple(block.statements), hull, is_lanes))

    def _hull(self, start: Affine, stop: Affine, step: int) -> tuple[int, int]:
        """Least and greatest value of a loop's variable over all turns of the loops around it."""

        def extremes(bound: Affine) -> tuple[int, int]:
            ends = [sorted(c * end for end in self._open_loops[v]) for v, c in bound.terms]
            return bound.offset + sum(low for low, _ in ends), bound.offset + sum(high for _, high in ends)

        (first, last), (least, most) = extremes(start), extremes(stop)
        return (first, most - 1) if step > 0 else (least + 1, last)

    @contextmanager
    def first_of_all(self) -> Iterator[None]:
        """Record ahead of everything else, wherever the writer stands: what depends on runtime parameters alone."""
        blocks, loops = self._blocks, self._open_loops
        self._blocks, self._open_loops = blocks[:1], {}
        yield
        self._blocks, self._open_loops = blocks, loops

    def hoist(self, operand: Operand) -> None:
        """Move the computation of a loop's initial value out of the loop that is being written."""
        inner, outer = self._blocks[-1], self._blocks[-2]
        op = self._definition(operand)
        if op is None or op not in inner.statements:
            return
        for arg in op.args:
            self.hoist(arg)
        inner.statements.remove(op)
        outer.statements.append(op)
        key = (op.kind, canonical(op.kind, op.args))
        outer.shared[key] = inner.shared.pop(key)

    def fresh(self, name: str) -> str:
        """A name not used before in this Program."""
        count = self._names.get(name)
        self._names[name] = 0 if count is None else count + 1
        if count is None:
            return name
        candidate = f"{name}_{count + 2}" if name else ""
        if candidate in self._names:
            return self.fresh(candidate)
        self._names[candidate] = 0
        return candidate

    def finish(self) -> Program:
        """The finished, immutable Program."""
        return Program(
            name=self.name, doc=self.doc, params=tuple(self.params), inputs=tuple(self.inputs),
            outputs=tuple(self.outputs), work=tuple(self.work), tables=dict(self.tables),
            body=tuple(self._blocks[0].statements + self._blocks[1].statements), callees=dict(self.callees),
        )  # fmt: skip

    # --- recording --------------------------------------------------------------------------------------------------

    def _definition(self, operand: Operand) -> Op | None:
        return self._ops.get(operand.name) if isinstance(operand, Local) else None

    def _emit(self, kind: str, args: tuple[Operand, ...], label: str = "") -> Operand:
        simpler = simplify(kind, args, self._definition, self._emit)
        if simpler is not None:
            return simpler
        if kind == "mul" and isinstance(args[1], Const):
            args = (args[1], args[0])
        key = (kind, canonical(kind, args))
        for block in self._blocks:
            if (known := block.shared.get(key)) is not None:
                return known
        result = Local(self.fresh(label) if label else self._anonymous())
        self._ops[result.name] = op = Op(result.name, kind, args)
        self._blocks[-1].statements.append(op)
        self._blocks[-1].shared[key] = result
        return result

    def _anonymous(self) -> str:
        self._names["_"] = number = self._names.get("_", 0) + 1
        return f"_{number}"


__all__ = ["ArrayRef", "Builder", "Expr", "Index", "Loop", "Number"]
