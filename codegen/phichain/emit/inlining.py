"""Which intermediate results a backend may write where they are used, instead of giving each a variable."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

from phichain.ir.nodes import For, Local, Op, Operand, Statement, Store


def used_once(statements: tuple[Statement, ...]) -> frozenset[str]:
    """Results without a name of their own that are used once, and in the block that computes them.

    A result used in a deeper block is not among them: written there, it would be computed again every turn.
    """
    everywhere: Counter[str] = Counter()
    nearby: set[str] = set()
    for block in _blocks(statements, ()):
        uses = Counter(operand.name for operand in block.operands if isinstance(operand, Local))
        everywhere += uses
        nearby |= {name for name in block.results if name.startswith("_") and uses[name] == 1}
    return frozenset(name for name in nearby if everywhere[name] == 1)


class _Block:
    """What one block, without the loops inside it, computes and uses."""

    def __init__(self, statements: tuple[Statement, ...], following: tuple[Operand, ...]) -> None:
        self.results = [statement.result for statement in statements if isinstance(statement, Op)]
        self.operands = [*following]
        for statement in statements:
            match statement:
                case Op(args=args):
                    self.operands += args
                case Store(value=value):
                    self.operands.append(value)
                case For(carries=carries):
                    self.operands += (carry.initial for carry in carries)
                case _:
                    pass


def _blocks(statements: tuple[Statement, ...], following: tuple[Operand, ...]) -> Iterator[_Block]:
    """The block of these statements, then those of the loops in it; a loop's next values belong to its body."""
    yield _Block(statements, following)
    for statement in statements:
        if isinstance(statement, For):
            yield from _blocks(statement.body, tuple(carry.following for carry in statement.carries))
