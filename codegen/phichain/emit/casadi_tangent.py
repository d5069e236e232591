"""The exact Jacobians that CasADi asks of a function: one block per result and argument, parameters stacked in p."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

from phichain.program.inline import inline
from phichain.program.lower import JACOBIAN_UNROLL_LIMIT, lower_function
from phichain.program.nodes import Array, Program
from phichain.program.passes import total_operations, unroll
from phichain.program.pattern import jacobian_pattern
from phichain.program.tangent import Block, jacobian, sparsity
from phichain.scene import Scene

Cells = tuple[tuple[int, int], ...]

#: Functions that are derivatives already; the loop form of the tangent pass does not serve them once more.
_SECOND = frozenset({"state_jacobian", "phi_jacobian"})

#: Operations beyond which straight-line code is not even tried.
_LONG = 4 * JACOBIAN_UNROLL_LIMIT


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


def make_tangent(scene: Scene, function: str) -> Tangent | None:
    """Differentiate one function of a scene with respect to all its arguments.

    Returns:
        Its Jacobians; None for second derivatives (those of state_jacobian and phi_jacobian) of long chains.
    """
    program = inline(lower_function(replace(scene, code="loops"), function, "loops"))
    cells = _pattern(program)
    blocks = [block for block in _blocks(program) if cells[block.name]]
    if not blocks:
        return Tangent(None, MappingProxyType(cells))
    name, doc = f"casadi_{function}_tangent", f"Exact derivatives of {function}."
    if function in _SECOND:
        return _straight_line(jacobian(unroll(program), name, doc, blocks), cells) if _is_short(program) else None
    looped = jacobian(program, name, doc, blocks)
    if scene.code != "unrolled" and (scene.code == "loops" or total_operations(looped) > _LONG):
        return Tangent(looped, MappingProxyType(cells))
    flat = jacobian(unroll(program), name, doc, blocks)
    if scene.code == "auto" and total_operations(flat) > JACOBIAN_UNROLL_LIMIT:
        return Tangent(looped, MappingProxyType(cells))
    return _straight_line(flat, cells)


def _is_short(program: Program) -> bool:
    """Whether its straight-line tangent, at most all operations once for each direction, stays short."""
    if total_operations(program) > _LONG:
        return False
    directions = sum(array.size for array in (*program.params, *program.inputs))
    return total_operations(unroll(program)) * directions <= _LONG


def _straight_line(tangent: Program, cells: Mapping[str, Cells]) -> Tangent:
    """Straight-line code also knows the terms that cancel, so its pattern is the sharper one."""
    widths = {array.name: array.shape[1] for array in tangent.outputs}
    sharper = {key: tuple(divmod(i, widths[key]) for i in found) for key, found in sparsity(tangent).items()}
    return Tangent(tangent, MappingProxyType({**cells, **sharper}))


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
