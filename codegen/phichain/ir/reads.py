"""Program -> Program: what is read, read elsewhere."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from phichain.ir.nodes import Call, Carry, For, Op, Operand, Program, Statement, Store

Read = Callable[[Operand], Operand]


def reading(program: Program, read: Read) -> Program:
    """The same statements with every operand replaced; arrays whose runs of cells are read as a whole are not among them.

    Args:
        program: without calls.
        read: what stands for an operand.
    """
    return replace(program, body=tuple(read_in(statement, read) for statement in program.body))


def read_in(statement: Statement, read: Read) -> Statement:
    """A statement with every operand replaced, those of loops within it too."""
    match statement:
        case Op():
            return replace(statement, args=tuple(map(read, statement.args)))
        case Store():
            return replace(statement, value=read(statement.value))
        case For():
            carries = tuple(Carry(carry.name, read(carry.initial), read(carry.following)) for carry in statement.carries)
            return replace(statement, carries=carries, body=tuple(read_in(inner, read) for inner in statement.body))
        case Call():
            raise AssertionError("calls are put in place before what a Program reads is replaced")
    return statement
