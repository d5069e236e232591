"""Program -> Program: straight-line code in the order in which its results need it, so that few values are alive at once.

A compiler that saves text (`-Os`) keeps the order it is given: what is computed long before its use takes a register meanwhile, and
each register that a function may not overwrite takes room on the stack.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from itertools import accumulate

from phichain.ir.nodes import Const, Local, Op, Operand, Program, Statement, Store

#: Up to so many angles nothing precedes their sines: what else the function reads is alive afterwards alone. Of more angles it is
#: read first, while the pointers to it are still in registers.
_FEW_ANGLES = 2


def in_order_of_need(program: Program) -> Program:
    """The same function with every operation right before the first one that uses it; sines of what is given, and results, as they were.

    A Program with loops, calls or work arrays is left as it is, and so is one that has fewer values in use at once.
    """
    operations = {statement.result: statement for statement in program.body if isinstance(statement, Op)}
    stores = [statement for statement in program.body if isinstance(statement, Store)]
    if program.work or len(operations) + len(stores) < len(program.body):
        return program
    turned = _first_sines(operations.values())
    few = len({op.args for op in turned}) <= _FEW_ANGLES
    first = turned if few or not turned else [*_before(program.body, turned[0]), *turned]
    ordered = tuple(_ordered([*first, *stores], operations))
    return replace(program, body=min(ordered, program.body, key=most_alive))


def _first_sines(operations: Iterable[Op]) -> list[Op]:
    """Sines and cosines of angles that need none, in their order: a backend computes them together."""
    found, above = list[Op](), set[str]()
    for op in operations:
        rests = any(isinstance(arg, Local) and arg.name in above for arg in op.args)
        if op.kind in ("sin", "cos") and not rests:
            found.append(op)
        if op.kind in ("sin", "cos") or rests:
            above.add(op.result)
    return found


def _before(body: tuple[Statement, ...], op: Op) -> list[Op]:
    """The operations that stand before this one."""
    return [statement for statement in body[: body.index(op)] if isinstance(statement, Op)]


def _ordered(roots: list[Op | Store], operations: dict[str, Op]) -> Iterable[Statement]:
    """The roots in their order, what each uses right before it, arguments from left to right."""
    done = set[str]()
    for root in roots:
        waiting: list[Op | Store] = [root]
        while waiting:  # chains of operations may be longer than Python's stack
            last = waiting[-1]
            args = last.args if isinstance(last, Op) else (last.value,)
            missing = [operations[arg.name] for arg in args if isinstance(arg, Local) and arg.name not in done]
            if missing:
                waiting.append(missing[0])
                continue
            waiting.pop()
            if isinstance(last, Op):
                if last.result not in done:
                    yield last
                done.add(last.result)
            else:
                yield last


def most_alive(body: tuple[Statement, ...]) -> int:
    """The most values that straight-line code has in use at once: results, and cells from their first use to their last."""
    used = [[arg for arg in _args(statement) if not isinstance(arg, Const)] for statement in body]
    first, last = dict[Operand, int](), dict[Operand, int]()
    for place, (statement, args) in enumerate(zip(body, used, strict=True)):
        for arg in args:
            first.setdefault(arg, place)
            last[arg] = place
        if isinstance(statement, Op):
            first[Local(statement.result)] = place
    change = [0] * (len(body) + 1)
    for value, place in last.items():
        change[first[value]] += 1
        change[place] -= 1
    return max(accumulate(change))


def _args(statement: Statement) -> tuple[Operand, ...]:
    match statement:
        case Op(args=args):
            return args
        case Store(value=value):
            return (value,)
        case _:
            return ()
