"""Program -> Program: calls replaced by the statements of what they call, loops kept."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from phichain.ir.nodes import (
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
    walk,
)


def inline(program: Program) -> Program:
    """The same function without calls, so that passes which know loops but no calls can read it."""
    if not program.callees:
        return program
    callees = {name: inline(callee) for name, callee in program.callees.items()}
    taken = set(_names(program))
    body: list[Statement] = []
    work, tables = [*program.work], dict(program.tables)
    for statement in program.body:
        if not isinstance(statement, Call):
            body.append(statement)
            continue
        callee = callees[statement.callee]
        renamed = _Renaming(callee, statement, taken)
        body += (renamed.statement(inner) for inner in callee.body)
        work += (Array(renamed.names[array.name], array.shape, array.doc) for array in callee.work)
        tables |= {renamed.names[name]: values for name, values in callee.tables.items()}
    return replace(program, body=tuple(body), work=tuple(work), tables=tables, callees={})


def _names(program: Program) -> Iterator[str]:
    """Every name that has a meaning inside a Program."""
    yield from (array.name for array in (*program.params, *program.inputs, *program.outputs, *program.work))
    yield from program.tables
    for statement in walk(program.body):
        match statement:
            case Op(result=result):
                yield result
            case For(carries=carries):
                yield from (carry.name for carry in carries)
            case _:
                pass


class _Renaming:
    """A callee's names in its caller: arguments are the caller's arrays, everything else gets a name of its own."""

    def __init__(self, callee: Program, call: Call, taken: set[str]) -> None:
        self.names = {array.name: array.name for array in callee.params}
        self.names |= {array.name: name for array, name in zip(callee.inputs, call.inputs, strict=True)}
        self.names |= {array.name: name for array, name in zip(callee.outputs, call.outputs, strict=True)}
        for name in _names(callee):
            if name not in self.names:
                self.names[name] = _unused(name, taken)
                taken.add(self.names[name])

    def statement(self, statement: Statement) -> Statement:
        match statement:
            case Op(result, kind, args):
                return Op(self.names[result], kind, tuple(map(self.operand, args)))
            case Store(Cell(array, index), value):
                return Store(Cell(self.names[array], index), self.operand(value))
            case SinCos(sine, cosine, angle, offset, count):
                return SinCos(self.names[sine], self.names[cosine], self.names[angle], offset, count)
            case For():
                body = tuple(map(self.statement, statement.body))
                return replace(statement, carries=tuple(map(self.carry, statement.carries)), body=body)
            case Call():
                raise AssertionError("callees are inlined before their callers")

    def carry(self, carry: Carry) -> Carry:
        return Carry(self.names[carry.name], self.operand(carry.initial), self.operand(carry.following))

    def operand(self, operand: Operand) -> Operand:
        match operand:
            case Const():
                return operand
            case Local(name):
                return Local(self.names[name])
            case Cell(array, index):
                return Cell(self.names[array], index)


def _unused(name: str, taken: set[str]) -> str:
    """The name itself, or with the first number that makes it a new one."""
    unused, number = name, 2
    while unused in taken:
        unused, number = f"{name}_{number}", number + 1
    return unused
