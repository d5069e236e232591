"""Program -> Program: the derivative of its results along one direction of its arguments, d f = J d x, without J."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from phichain.ir.builder import ArrayRef, Builder, Expr
from phichain.ir.interpret import Algebra, run
from phichain.ir.nodes import Program
from phichain.ir.passes import prune
from phichain.ir.short_loops import without_short_loops
from phichain.transform.derivatives import directional
from phichain.transform.tangent_loops import loop_direction


@dataclass(frozen=True)
class _Dual:
    """A value and its derivative, None where that is structurally zero."""

    value: Expr
    slope: Expr | None


def along(program: Program, name: str, doc: str, moving: Sequence[str], results: Sequence[str]) -> Program:
    """The derivatives of some results where some arguments move, straight-line exactly when `program` is.

    Args:
        program: the function, without calls.
        name: of the new Program.
        doc: its one-line description.
        moving: inputs and parameters that move; how each moves is one more input, `d_NAME`, behind all others in this order.
        results: outputs whose derivatives `d_NAME` are wanted.
    """
    builder = Builder(name, doc)
    for declare, arrays in ((builder.param, program.params), (builder.input, program.inputs)):
        for array in arrays:
            declare(array.name, array.shape, array.doc)
    known = {array.name: array for array in (*program.params, *program.inputs, *program.outputs)}
    for argument in moving:
        builder.input(f"d_{argument}", (known[argument].size,), f"how {argument} moves")
    for result in results:
        builder.output(f"d_{result}", known[result].shape, f"how {result} moves")
    if program.is_straight_line:
        return prune(_straight(builder, program, moving, results))
    return without_short_loops(prune(loop_direction(builder, program, moving, results)))


def _straight(builder: Builder, program: Program, moving: Sequence[str], results: Sequence[str]) -> Program:
    arguments = {}
    for array in (*program.params, *program.inputs):
        slopes = ArrayRef(builder, f"d_{array.name}", array.size) if array.name in moving else None
        arguments[array.name] = [
            _Dual(builder.read(array.name, i), None if slopes is None else slopes[i]) for i in range(array.size)
        ]

    def apply(kind: str, args: Sequence[_Dual], label: str) -> _Dual:
        values = [arg.value for arg in args]
        result = builder.apply(kind, *values, label=label)
        return _Dual(result, directional(builder, kind, values, result, [arg.slope for arg in args]))

    def constant(value: Fraction) -> _Dual:
        return _Dual(builder.lift(value), None)

    outputs = run(program, Algebra(constant, apply), arguments)
    for name in results:
        for i, dual in enumerate(outputs[name]):
            builder.write(f"d_{name}", i, builder.lift(0) if dual.slope is None else dual.slope)
    return builder.finish()
