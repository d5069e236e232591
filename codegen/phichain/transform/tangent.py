"""The tangent pass: exact Jacobians of a Program with respect to any of its inputs and runtime parameters.

Straight-line code is differentiated sparsely: every value carries the derivatives it has, so structural zeros never become
operations and the sparsity of the result is known (`sparsity`). Code with loops is differentiated one direction at a time
inside one more loop over directions; values of the original that derivatives need are kept in work arrays.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from phichain.ir.builder import Builder, Expr
from phichain.ir.interpret import Algebra, run
from phichain.ir.nodes import Program, Store
from phichain.ir.passes import prune
from phichain.transform.blocks import Block
from phichain.transform.derivatives import directional
from phichain.transform.tangent_loops import loop_jacobian

__all__ = ["jacobian", "sparsity"]


@dataclass(frozen=True)
class _Dual:
    """A value and its derivatives by seed number."""

    value: Expr
    slope: dict[int, Expr]


def jacobian(program: Program, name: str, doc: str, blocks: Sequence[Block], keep_outputs: bool = False) -> Program:
    """The Program that computes the given Jacobians, straight-line exactly when `program` is.

    Args:
        program: the function to differentiate.
        name: name of the new Program.
        doc: its one-line description.
        blocks: which derivatives, in the order of the new Program's outputs.
        keep_outputs: also return the original outputs, first.
    """
    make = _straight_jacobian if program.is_straight_line else loop_jacobian
    builder = Builder(name, doc)
    for declare, arrays in ((builder.param, program.params), (builder.input, program.inputs)):
        for array in arrays:
            declare(array.name, array.shape, array.doc)
    for array in program.outputs if keep_outputs else ():
        builder.output(array.name, array.shape, array.doc)
    for block_name, shape in _shapes(program, blocks).items():
        builder.output(block_name, shape)
    return prune(make(builder, program, blocks, keep_outputs))


def sparsity(program: Program) -> dict[str, tuple[int, ...]]:
    """Flat indices of the cells of each output of a straight-line Program that are not structurally zero."""
    nonzero: dict[str, list[int]] = {array.name: [] for array in program.outputs}
    builder = Builder("", "")
    for statement in program.body:
        if isinstance(statement, Store) and statement.cell.array in nonzero and not Expr(builder, statement.value).is_zero:
            nonzero[statement.cell.array].append(statement.cell.index.offset)
    return {name: tuple(sorted(cells)) for name, cells in nonzero.items()}


def _shapes(program: Program, blocks: Sequence[Block]) -> dict[str, tuple[int, int]]:
    sizes = {array.name: array for array in (*program.params, *program.inputs, *program.outputs)}
    return {b.name: (sizes[b.output].size, b.columns or sizes[b.argument].size) for b in blocks}


def _straight_jacobian(builder: Builder, program: Program, blocks: Sequence[Block], keep_outputs: bool) -> Program:
    seeds = _seeds(program, blocks)
    arguments = {}
    for array in (*program.params, *program.inputs):
        first = seeds.get(array.name)
        arguments[array.name] = [
            _Dual(builder.read(array.name, i), {} if first is None else {first + i: builder.lift(1)})
            for i in range(array.size)
        ]

    def apply(kind: str, args: Sequence[_Dual], label: str) -> _Dual:
        values = [arg.value for arg in args]
        result = builder.apply(kind, *values, label=label)
        slope = {}
        for seed in sorted({seed for arg in args for seed in arg.slope}):
            derivative = directional(builder, kind, values, result, [arg.slope.get(seed) for arg in args])
            if derivative is not None:
                slope[seed] = derivative
        return _Dual(result, slope)

    def constant(value: Fraction) -> _Dual:
        return _Dual(builder.lift(value), {})

    outputs = run(program, Algebra(constant, apply), arguments)
    for array in program.outputs if keep_outputs else ():
        for i, dual in enumerate(outputs[array.name]):
            builder.write(array.name, i, dual.value)
    sizes = {array.name: array.size for array in (*program.params, *program.inputs)}
    for block in blocks:
        width = sizes[block.argument]
        for row, dual in enumerate(outputs[block.output]):
            for column in range(width):
                slope = dual.slope.get(seeds[block.argument] + column, builder.lift(0))
                builder.write(block.name, row * (block.columns or width) + block.column + column, slope)
    return builder.finish()


def _seeds(program: Program, blocks: Sequence[Block]) -> dict[str, int]:
    """First seed number of every argument that is differentiated."""
    wanted = {block.argument for block in blocks}
    seeds: dict[str, int] = {}
    total = 0
    for array in (*program.params, *program.inputs):
        if array.name in wanted:
            seeds[array.name] = total
            total += array.size
    return seeds


