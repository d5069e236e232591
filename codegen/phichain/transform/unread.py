"""Program -> Program: cells of work arrays that nothing reads are not written, and arrays end where they are last used."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

from phichain.ir.nodes import Affine, Array, Call, Cell, For, Op, Operand, Program, SinCos, Statement, Store
from phichain.ir.passes import prune

Span = tuple[int, int]
Hulls = Mapping[str, Span]
_NOTHING: Span = (1, 0)


@dataclass
class _Uses:
    """Indices between which each work array is read and written; arrays that something takes whole."""

    read: dict[str, Span] = field(default_factory=dict)
    written: dict[str, Span] = field(default_factory=dict)
    whole: set[str] = field(default_factory=set)


def without_unread_cells(program: Program) -> Program:
    """The same function without stores to cells that nothing reads; arrays are as long as their largest index wants."""
    uses, names = _uses(program.body), {array.name for array in program.work}
    read = {name: span for name, span in uses.read.items() if name in names - uses.whole}
    body = tuple(_kept(program.body, read, {}))
    uses = _uses(body)
    work = tuple(array if array.name in uses.whole else _shortened(array, uses) for array in program.work)
    return prune(replace(program, body=body, work=work))


def _shortened(array: Array, uses: _Uses) -> Array:
    last = max(uses.read.get(array.name, _NOTHING)[1], uses.written.get(array.name, _NOTHING)[1])
    return replace(array, shape=(max(last + 1, 1),))


def _uses(statements: tuple[Statement, ...]) -> _Uses:
    uses = _Uses()
    for statement, hulls in _walk(statements, {}):
        for operand, inside in _operands(statement, hulls):
            if isinstance(operand, Cell):
                _widen(uses.read, operand.array, _span(operand.index, inside))
        match statement:
            case Store(cell, _):
                _widen(uses.written, cell.array, _span(cell.index, hulls))
            case SinCos(sine, cosine, angle):
                uses.whole |= {sine, cosine, angle}
            case Call(_, inputs, outputs):
                uses.whole |= {*inputs, *outputs}
            case _:
                pass
    return uses


def _walk(statements: tuple[Statement, ...], hulls: Hulls) -> Iterator[tuple[Statement, Hulls]]:
    """Every statement, and between which values the variables of the loops around it lie."""
    for statement in statements:
        yield statement, hulls
        if isinstance(statement, For):
            yield from _walk(statement.body, {**hulls, statement.variable: statement.hull})


def _operands(statement: Statement, hulls: Hulls) -> Iterator[tuple[Operand, Hulls]]:
    """What a statement reads, and the variables of the loops around that."""
    match statement:
        case Op(args=args):
            yield from ((operand, hulls) for operand in args)
        case Store(value=value):
            yield value, hulls
        case For(carries=carries):
            for carry in carries:
                yield carry.initial, hulls
                yield carry.following, {**hulls, statement.variable: statement.hull}
        case _:
            pass


def _kept(statements: tuple[Statement, ...], read: Mapping[str, Span], hulls: Hulls) -> Iterator[Statement]:
    for statement in statements:
        match statement:
            case For():
                inside = {**hulls, statement.variable: statement.hull}
                yield replace(statement, body=tuple(_kept(statement.body, read, inside)))
            case Store(cell, _) if cell.array in read:
                (first, last), (least, most) = _span(cell.index, hulls), read[cell.array]
                if first <= most and last >= least:
                    yield statement
            case _:
                yield statement


def _span(index: Affine, hulls: Hulls) -> Span:
    """Between which values an index lies."""
    ends = [sorted((factor * hulls[variable][0], factor * hulls[variable][1])) for variable, factor in index.terms]
    return index.offset + sum(low for low, _ in ends), index.offset + sum(high for _, high in ends)


def _widen(spans: dict[str, Span], name: str, span: Span) -> None:
    least, most = spans.get(name, span)
    spans[name] = min(least, span[0]), max(most, span[1])
