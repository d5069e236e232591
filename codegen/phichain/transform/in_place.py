"""Program -> Program: products of runtime parameters are formed where they are read instead of being kept in tables.

A function of runtime parameters begins with tables of them. Those of quotients, and what these are made of, pay for themselves. A
product or two of what other tables hold does not: it is written in vectors and read one by one, and a loop that waits for its own
last turn has time for it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import count

from phichain.ir.nodes import (
    Affine,
    Call,
    Carry,
    Cell,
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
from phichain.ir.passes import prune

_CHEAP = frozenset({"mul", "add", "sub", "neg"})


def with_products_in_place(program: Program) -> Program:
    """The same function with every product of parameters where it is read, once a block."""
    tables = _products(program)
    return prune(replace(program, body=tuple(_Placing(tables).block(program.body, {})))) if tables else program


def _products(program: Program) -> dict[str, For]:
    """Tables that hold a product at every index, and that no other table reads which stays: array -> loop."""
    stores = Counter(s.cell.array for s in walk(program.body) if isinstance(s, Store))
    whole = {name for s in walk(program.body) for name in _whole(s)}
    still, loops, others = {array.name for array in program.params} | set(program.tables), dict[str, For](), list[Statement]()
    for statement in program.body:
        read = {operand.array for s in walk((statement,)) for operand in _operands(s) if isinstance(operand, Cell)}
        if _whole_reads(statement) or not read <= still or not isinstance(statement, For | Store):
            continue
        written = {s.cell.array for s in walk((statement,)) if isinstance(s, Store)}
        if not written:
            continue  # a sum alone, carried
        still |= written
        (name, *more) = written
        if isinstance(statement, For) and not more and stores[name] == 1 and name not in whole and _is_product(statement):
            loops[name] = statement
        else:
            others.append(statement)
    while True:
        wanted = {operand.array for s in walk(tuple(others)) for operand in _operands(s) if isinstance(operand, Cell)} & set(loops)
        if not wanted:
            return loops
        others += [loops.pop(name) for name in wanted]


def _is_product(loop: For) -> bool:
    """Whether a loop writes cell k of an array at its turn k, by operations that are no divisions, and does nothing else."""
    *ops, last = loop.body
    if loop.carries or loop.step != 1 or loop.start.terms or loop.stop.terms or not isinstance(last, Store):
        return False
    return last.cell.index == Affine(0, ((loop.variable, 1),)) and all(isinstance(op, Op) and op.kind in _CHEAP for op in ops)


def _operands(statement: Statement) -> Iterator[Operand]:
    match statement:
        case Op(args=args):
            yield from args
        case Store(value=value):
            yield value
        case For(carries=carries):
            for carry in carries:
                yield from (carry.initial, carry.following)
        case _:
            pass


def _whole(statement: Statement) -> tuple[str, ...]:
    """Arrays that a statement is given as they are."""
    match statement:
        case SinCos(sine, cosine, angle):
            return sine, cosine, angle
        case Call(_, inputs, outputs):
            return *inputs, *outputs
        case _:
            return ()


def _whole_reads(statement: Statement) -> bool:
    return any(_whole(s) for s in walk((statement,)))


@dataclass
class _Placing:
    """Writes blocks anew; what a block or one around it has formed is known by its cell, or by its operation."""

    tables: dict[str, For]

    def __post_init__(self) -> None:
        self.numbers = count()

    def block(self, statements: tuple[Statement, ...], known: Mapping[object, Operand]) -> Iterator[Statement]:
        """The statements, each behind the products that it reads."""
        formed = dict(known)
        for statement in statements:
            before: list[Statement] = []
            match statement:
                case Op(_, _, args):
                    statement = replace(statement, args=tuple(self._read(arg, formed, before) for arg in args))
                case Store(_, value):
                    statement = replace(statement, value=self._read(value, formed, before))
                case For():
                    statement = self._loop(statement, formed, before)
                case _:
                    pass
            yield from (*before, statement)

    def _loop(self, loop: For, formed: dict[object, Operand], before: list[Statement]) -> For:
        initial = [self._read(carry.initial, formed, before) for carry in loop.carries]
        body = list(self.block(loop.body, formed))
        last: list[Statement] = []
        following = [self._read(carry.following, {}, last) for carry in loop.carries]
        carries = tuple(Carry(c.name, i, f) for c, i, f in zip(loop.carries, initial, following, strict=True))
        return replace(loop, carries=carries, body=(*body, *last))

    def _read(self, operand: Operand, formed: dict[object, Operand], before: list[Statement]) -> Operand:
        """An operand; where it is a cell of a table in place, the product that it held."""
        if not isinstance(operand, Cell) or operand.array not in self.tables:
            return operand
        table = self.tables[operand.array]
        if operand not in formed:
            formed[operand] = self._formed(table, operand.index, formed, before)
        return formed[operand]

    def _formed(self, table: For, at: Affine, formed: dict[object, Operand], before: list[Statement]) -> Operand:
        values: dict[Operand, Operand] = {}

        def here(operand: Operand) -> Operand:
            if isinstance(operand, Cell):
                operand = Cell(operand.array, _substituted(operand.index, table.variable, at))
                return self._read(operand, formed, before)
            return values.get(operand, operand)

        *ops, last = table.body
        for op in ops:
            assert isinstance(op, Op)
            key = op.kind, tuple(map(here, op.args))
            if key not in formed:
                formed[key] = Local(f"_in_place_{next(self.numbers)}")
                before.append(Op(formed[key].name, *key))  # type: ignore[union-attr]
            values[Local(op.result)] = formed[key]
        assert isinstance(last, Store)
        return here(last.value)


def _substituted(index: Affine, variable: str, at: Affine) -> Affine:
    factor = dict(index.terms).get(variable, 0)
    return Affine(index.offset, tuple(term for term in index.terms if term[0] != variable)) + at * factor
