"""Which results of a Program can depend on which arguments: the sparsity of its Jacobians, loops or not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from phichain.ir.interpret import Algebra, run
from phichain.ir.nodes import Program

#: Functions that are zero at zero, so that structural zeros pass through them.
_ODD = frozenset({"neg", "sqrt", "sin", "tanh", "besselj1", "besselj2", "besselj3", "besselj4"})


@dataclass(frozen=True, slots=True)
class _Reach:
    """The argument cells a value depends on, one bit each, and whether it is structurally zero."""

    cells: int
    is_zero: bool = False


def jacobian_pattern(program: Program) -> dict[tuple[str, str], tuple[tuple[int, int], ...]]:
    """Cells of every Jacobian that are not structurally zero.

    Returns:
        By (output, argument), parameters included: sorted pairs of flat indices (into the output, into the argument).
    """
    arguments: dict[str, list[_Reach]] = {}
    places: list[tuple[str, int]] = []
    for array in (*program.params, *program.inputs):
        arguments[array.name] = [_Reach(1 << len(places) + i) for i in range(array.size)]
        places += [(array.name, i) for i in range(array.size)]
    algebra = Algebra(
        lambda value: _Reach(0, value == Fraction(0)), lambda kind, args, label: _reach(kind, args)
    )
    found: dict[tuple[str, str], list[tuple[int, int]]] = {
        (output.name, argument): [] for output in program.outputs for argument in arguments
    }
    for output, values in run(program, algebra, arguments).items():
        for row, value in enumerate(values):
            for name, column in _members(value.cells, places):
                found[output, name].append((row, column))
    return {key: tuple(cells) for key, cells in found.items()}


def _reach(kind: str, args: Sequence[_Reach]) -> _Reach:
    zeros = [arg.is_zero for arg in args]
    if (kind == "mul" and any(zeros)) or (kind in ("add", "sub") and all(zeros)):
        return _Reach(0, True)
    if (kind == "div" or kind in _ODD) and zeros[0]:
        return _Reach(0, True)
    if kind == "select" and all(zeros[2:]):
        return _Reach(0, True)
    cells = 0
    # What is compared decides, and moves nothing; a whole number does not move at all.
    for arg in {"select": args[2:], "floor": ()}.get(kind, args):
        cells |= arg.cells
    return _Reach(cells)


def _members(cells: int, places: list[tuple[str, int]]) -> list[tuple[str, int]]:
    members = []
    while cells:
        lowest = cells & -cells
        members.append(places[lowest.bit_length() - 1])
        cells ^= lowest
    return members
