"""The exact Jacobians that CasADi asks of a function: one block per result and argument, parameters stacked in p."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

from phichain.contract.functions import ROWS
from phichain.ir.inline import inline
from phichain.ir.nodes import Array, Program
from phichain.ir.passes import total_operations, unroll
from phichain.lowering.lower import JACOBIAN_UNROLL_LIMIT, lower_function
from phichain.mechanics import Model
from phichain.transform.blocks import Block
from phichain.transform.pattern import jacobian_pattern
from phichain.transform.tangent import jacobian, sparsity

Cells = tuple[tuple[int, int], ...]


@dataclass(frozen=True)
class Tangent:
    """All Jacobians of one function.

    Attributes:
        program: computes the blocks that are not structurally zero, each as a full row-major array jac_OUTPUT_ARGUMENT;
            None where every block is zero.
        cells: places (row, column) of the nonzeros of each block, in the flat row-major indices of its result.
    """

    program: Program | None
    cells: Mapping[str, Cells]


def stacked_inputs(program: Program) -> tuple[Array, ...]:
    """The arguments under CasADi: p, which stacks the runtime parameters, where there are any; then the inputs."""
    size = sum(array.size for array in program.params)
    return (*([Array("p", (size,), "parameters")] if size else []), *program.inputs)


def block_name(output: str, argument: str) -> str:
    """CasADi's name of d(output)/d(argument)."""
    return f"jac_{output}_{argument}"


def make_tangent(model: Model, function: str) -> Tangent | None:
    """Differentiate one function of a scene with respect to all its arguments.

    Returns:
        Its Jacobians; None for a function that is a derivative itself: second derivatives of long chains do not fit into a
        file of sources.
    """
    if ROWS[function].derivative is not None:
        return None
    program = inline(lower_function(model, function, "loops"))
    cells = _pattern(program)
    blocks = [block for block in _blocks(program) if cells[block.name]]
    if not blocks:
        return Tangent(None, MappingProxyType(cells))
    tangent = _shaped(model.scene.code, program, blocks)
    return Tangent(tangent, MappingProxyType(cells | _sharper_cells(tangent)))


def _shaped(code: str, program: Program, blocks: Sequence[Block]) -> Program:
    """The tangent as straight-line code or with loops, by the rule that also shapes state_jacobian."""
    name, doc = f"casadi_{program.name}_tangent", f"Exact derivatives of {program.name}."
    looped = jacobian(program, name, doc, blocks)
    if code == "loops" or (code == "auto" and total_operations(looped) > 4 * JACOBIAN_UNROLL_LIMIT):
        return looped
    flat = jacobian(unroll(program), name, doc, blocks)
    return looped if code == "auto" and total_operations(flat) > JACOBIAN_UNROLL_LIMIT else flat


def _sharper_cells(tangent: Program) -> dict[str, Cells]:
    """The nonzeros of a straight-line tangent, which also knows the terms that cancel; nothing of one with loops."""
    if not tangent.is_straight_line:
        return {}
    widths = {array.name: array.shape[1] for array in tangent.outputs}
    return {key: tuple(divmod(i, widths[key]) for i in found) for key, found in sparsity(tangent).items()}


def _blocks(program: Program) -> Iterator[Block]:
    """Every block; the parameters of a scene share one, side by side."""
    width = sum(array.size for array in program.params)
    for output in program.outputs:
        column = 0
        for array in program.params:
            yield Block(output.name, array.name, block_name(output.name, "p"), column, width)
            column += array.size
        for array in program.inputs:
            yield Block(output.name, array.name, block_name(output.name, array.name))


def _pattern(program: Program) -> dict[str, Cells]:
    """The structural nonzeros of every block."""
    found = jacobian_pattern(program)
    cells: dict[str, Cells] = {}
    for block in _blocks(program):
        moved = tuple((row, block.column + column) for row, column in found[block.output, block.argument])
        cells[block.name] = (*cells.get(block.name, ()), *moved)
    return cells
