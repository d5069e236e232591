"""Program -> Program: unrolling, pruning to what the outputs need, and counting operations."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import replace
from fractions import Fraction

from phichain.ir.builder import Builder, Expr
from phichain.ir.interpret import Algebra, run
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
)


def unroll(program: Program) -> Program:
    """The same function as straight-line code: loops run out, calls put in place, constants folded, values shared."""
    builder = Builder(program.name, program.doc)
    arguments: dict[str, list[Expr]] = {}
    for declare, arrays in ((builder.param, program.params), (builder.input, program.inputs)):
        for array in arrays:
            ref = declare(array.name, array.shape, array.doc)
            arguments[array.name] = [ref[i] for i in range(ref.size)]
    outputs = {array.name: builder.output(array.name, array.shape, array.doc) for array in program.outputs}

    def constant(value: Fraction) -> Expr:
        return builder.lift(value)

    def apply(kind: str, args: Iterable[Expr], label: str) -> Expr:
        return builder.apply(kind, *args, label=label)

    results = run(program, Algebra(constant, apply), arguments)
    for name, values in results.items():
        for i, value in enumerate(values):
            outputs[name][i] = value
    return prune(builder.finish())


def prune(program: Program) -> Program:
    """Drop what no output needs: operations, carried scalars, stores to work arrays, whole loops, tables and arrays."""
    live = {array.name for array in program.outputs}
    while True:
        marked = set(live)
        body = _live_statements(program.body, marked)
        if marked == live or program.is_straight_line:  # read backwards, that is all there is
            live = marked
            break
        live = marked
    used = live | {name for statement in body for name in _arrays_of(statement)}
    return replace(
        program, body=body, work=tuple(array for array in program.work if array.name in used),
        tables={name: values for name, values in program.tables.items() if name in used},
    )  # fmt: skip


def _live_statements(statements: tuple[Statement, ...], live: set[str]) -> tuple[Statement, ...]:
    """The statements that reach a live name, read backwards; marks what they use (locals and arrays share one set)."""
    kept: list[Statement] = []
    for statement in reversed(statements):
        match statement:
            case Op(result, _, args):
                if result in live:
                    _mark(args, live)
                    kept.append(statement)
            case Store(cell, value):
                if cell.array in live:
                    _mark((value,), live)
                    kept.append(statement)
            case SinCos(sine, cosine, angle):
                if sine in live or cosine in live:
                    live.add(angle)
                    kept.append(statement)
            case Call(_, inputs, outputs):
                if live.intersection(outputs):
                    live.update(inputs)
                    kept.append(statement)
            case For():
                body = _live_loop(statement, live)
                if body is not None:
                    kept.append(body)
    return tuple(reversed(kept))


def _live_loop(loop: For, live: set[str]) -> For | None:
    low, high = loop.hull
    if high < low:
        still = tuple(Carry(carry.name, carry.initial, Local(carry.name)) for carry in loop.carries)
        loop = replace(loop, body=(), carries=still)
    while True:
        before = len(live)
        carries = tuple(carry for carry in loop.carries if carry.name in live)
        for carry in carries:
            _mark((carry.initial, carry.following), live)
        body = _live_statements(loop.body, live)
        if len(live) == before:
            break
    return replace(loop, carries=carries, body=body) if body or carries else None


def _mark(operands: Iterable[Operand], live: set[str]) -> None:
    for operand in operands:
        if isinstance(operand, Local):
            live.add(operand.name)
        elif isinstance(operand, Cell):
            live.add(operand.array)


def _arrays_of(statement: Statement) -> Iterable[str]:
    match statement:
        case SinCos(sine, cosine):
            yield from (sine, cosine)
        case Call(_, inputs, outputs):
            yield from (*inputs, *outputs)
        case For(body=body):
            for inner in body:
                yield from _arrays_of(inner)
        case _:
            pass


def count_operations(program: Program) -> Counter[str]:
    """How often each kind of operation runs in one call: + - * / sqrt tanh one each, a sine and a cosine one each."""
    counts: Counter[str] = Counter()
    _count(program, program.body, {}, counts)
    return counts


def total_operations(program: Program) -> int:
    """All operations of one call."""
    return sum(count_operations(program).values())


def _count(program: Program, statements: tuple[Statement, ...], indices: dict[str, int], into: Counter[str]) -> None:
    for statement in statements:
        match statement:
            case Op(kind=kind):
                into[kind] += 1
            case SinCos(count=count):
                into["sin"] += count
                into["cos"] += count
            case Call(callee):
                into.update(count_operations(program.callees[callee]))
            case For(variable=variable, body=body):
                _count_loop(program, statement, body, indices, variable, into)
            case _:
                pass


def _count_loop(
    program: Program, loop: For, body: tuple[Statement, ...], indices: dict[str, int], variable: str, into: Counter[str]
) -> None:
    turns = loop.range(indices)
    if not any(isinstance(inner, For) and _depends(inner, variable) for inner in body):
        inside: Counter[str] = Counter()
        _count(program, body, {**indices, variable: turns.start}, inside)
        into.update({kind: n * len(turns) for kind, n in inside.items()})
        return
    for index in turns:
        _count(program, body, {**indices, variable: index}, into)


def _depends(loop: For, variable: str) -> bool:
    def uses(bound: Affine) -> bool:
        return any(name == variable for name, _ in bound.terms)

    return uses(loop.start) or uses(loop.stop)
