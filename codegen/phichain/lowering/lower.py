"""Model -> Programs: every wanted function through its writer, as loops or as straight-line code."""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from math import prod
from types import MappingProxyType
from typing import Literal

from phichain.contract.function import Derivative, Function
from phichain.contract.functions import FLOWS, ROWS
from phichain.ir.builder import Builder
from phichain.ir.nodes import Array, Program
from phichain.ir.passes import prune, total_operations, unroll
from phichain.ir.short_loops import without_short_loops
from phichain.lowering.agreement import check_model
from phichain.lowering.chain.body import point_masses
from phichain.lowering.chain.losses import ties_links
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.chain.room import saves_memory, saves_text
from phichain.lowering.writers import WRITERS, Writer, declared
from phichain.mechanics import Model
from phichain.scene import Scene
from phichain.transform.blocks import Block
from phichain.transform.by_need import in_order_of_need
from phichain.transform.fused import with_fused_loops
from phichain.transform.in_place import with_products_in_place
from phichain.transform.tangent import jacobian
from phichain.transform.twins import without_twins
from phichain.transform.unread import without_unread_cells

Code = Literal["auto", "unrolled", "loops"]

#: Above this many operations `auto` keeps loops: beyond it compilers do better with loops that they can vectorise.
UNROLL_LIMIT = 600
#: The same for Jacobians: straight-line code leaves out the zeros that loops compute, but takes longer to compile.
JACOBIAN_UNROLL_LIMIT = 2500
#: The same where loops are written out: they are little more work than straight-line code, and vectors serve them.
WRITTEN_JACOBIAN_UNROLL_LIMIT = 1600
#: And from here on, where loops take at most a third more: what they save of text and of a target's memory is worth that.
SPARSE_LOOPS_FROM, SPARSE_LOOPS = 1000, Fraction(4, 3)
#: Up to so many links with couples on them products of runtime parameters are formed in the sweep's loops.
_LONGEST_COUPLED = 12


@dataclass(frozen=True)
class Lowered:
    """The Programs of a Model: the wanted functions, the helpers they call, and the runtime parameters of all.

    What runs over many steps (`FLOWS`) is no Program: `emit.flow` writes it around Programs of its own.
    """

    model: Model
    wanted: MappingProxyType[str, Program]
    helpers: MappingProxyType[str, Program]
    params: tuple[Array, ...]

    def __str__(self) -> str:
        return "\n\n".join(str(program) for program in (*self.wanted.values(), *self.helpers.values()))


def lower(model: Model, code: Code | None = None) -> Lowered:
    """Lower every wanted function, and what those call.

    Args:
        model: the mechanics of a scene.
        code: "auto", "unrolled" or "loops" instead of what the scene says.

    Raises:
        DerivationError: What is given is no `Model`, or its Lagrangian is not the one that the Programs' forms serve.
        ContractError: A wanted function has no writer.
    """
    check_model(model)
    lowering = _Lowering(model, code)
    wanted = {name: lowering.program(name) for name in model.scene.want if name not in FLOWS}
    called = {callee for program in wanted.values() for callee in program.callees}
    helpers = {name: lowering.program(name) for name in sorted(called - set(wanted))}
    return Lowered(model, MappingProxyType(wanted), MappingProxyType(helpers), lowering.params)


def lower_function(model: Model, name: str, code: Code = "auto", keeps_tables: bool = False) -> Program:
    """One function alone.

    Args:
        model: the mechanics of a scene.
        name: the function.
        code: "auto", "unrolled" or "loops".
        keeps_tables: whether all that runtime parameters alone determine stands in tables, for who computes these once.

    Raises:
        DerivationError: See `lower`.
        ContractError: It has no writer.
    """
    check_model(model)
    return _Lowering(model, code, keeps_tables).program(name)


class _Lowering:
    """The Programs of one Model, each made once, in the form that its scene asks for."""

    def __init__(self, model: Model, code: Code | None, keeps_tables: bool = False) -> None:
        self.model, self.keeps_tables = model, keeps_tables
        self.scene = replace(model.scene, code=code) if code else model.scene
        self._made: dict[str, Program] = {}

    @property
    def params(self) -> tuple[Array, ...]:
        """Fields of the struct of runtime parameters, the same for every function."""
        builder = Builder("params", "")
        Parameters(builder, self.model)
        return builder.finish().params

    def program(self, name: str) -> Program:
        """A function, or what functions call."""
        if name not in self._made:
            row = ROWS.get(name)
            derivative = row.derivative if row else None
            self._made[name] = self._derived(row, derivative) if row and derivative else self._shaped(name)
        return self._made[name]

    def _shaped(self, name: str) -> Program:
        """Straight-line code or loops, by wish or by operation count."""
        code, loops = self.scene.code, self._loops(name)
        if code == "loops" or (code == "auto" and total_operations(loops) > 2 * UNROLL_LIMIT):
            return self._without_tables(name, self._in_loops(loops))
        flat = self._in_line(unroll(loops))
        is_flat = code == "unrolled" or total_operations(flat) <= UNROLL_LIMIT
        return flat if is_flat else self._without_tables(name, self._in_loops(loops))

    def _without_tables(self, name: str, program: Program) -> Program:
        """The accelerations of runtime parameters with products of these where loops that wait for their last turn have time for them."""
        if self.keeps_tables or name != "forward_dynamics" or not _has_time(self.scene):
            return program
        return with_products_in_place(program)

    def _derived(self, row: Function, derivative: Derivative) -> Program:
        """The same for the Jacobian of another function: that function differentiated, or written out where that is less work."""
        code, loops, blocks = self.scene.code, self._loops(derivative.function), self._blocks(row, derivative)
        written = self._loops(row.name) if self._is_written(row.name) else None
        looped = self._in_loops(jacobian(without_short_loops(loops), row.name, row.doc, blocks, derivative.keeps))
        differentiated, looped = looped, _less(looped, None if written is None else self._in_loops(written))
        is_differentiated = looped is differentiated
        if code == "loops" or (code == "auto" and total_operations(looped) > 4 * JACOBIAN_UNROLL_LIMIT):
            return looped
        flat = jacobian(unroll(loops), row.name, row.doc, blocks, derivative.keeps)
        flat = _less(flat, None if written is None else unroll(written))
        limit = JACOBIAN_UNROLL_LIMIT if is_differentiated else _limit_of_written(flat, looped)
        return self._in_line(flat) if code == "unrolled" or total_operations(flat) <= limit else looped

    def _in_line(self, program: Program) -> Program:
        """Straight-line code as it is printed: where memory is dear in the order that keeps the fewest values."""
        return in_order_of_need(program) if saves_memory(self.scene) else program

    def _in_loops(self, program: Program) -> Program:
        """A Program as it is printed in loops: none of a single turn, and where memory is dear nothing written in vain or twice."""
        short = without_short_loops(program)
        if not saves_memory(self.scene):
            return short
        read = without_unread_cells(short)
        if not read.callees:
            read = without_unread_cells(without_twins(read))
            read = without_unread_cells(with_fused_loops(read)) if saves_text(self.scene) else read
        return without_short_loops(read)

    def _is_written(self, name: str) -> bool:
        if not WRITERS.has(name, self.scene.space):
            return False
        writer = WRITERS.of(name, self.scene.space)
        return writer.suits(self._given(writer))

    def _given(self, writer: Writer) -> Scene:
        """The chain as a writer is given it: with links as they are, or as the point masses that move alike."""
        return point_masses(self.scene) if writer.lumped else self.scene

    def _blocks(self, row: Function, derivative: Derivative) -> list[Block]:
        """Where the derivative by each argument goes: into a result of its own, or beside the others into the only one."""
        arguments = {argument.name: argument for argument in row.arguments_of(self.scene)}
        by = [name for name in derivative.by if name in arguments]
        results = row.outputs_of(self.scene)[int(derivative.keeps) :]
        if len(results) == len(by):
            pairs = zip(by, results, strict=True)
            return [Block(derivative.output, name, result.name) for name, result in pairs]
        (result,), blocks, column = results, [], 0
        width = result.shape(self.scene)[1]
        for name in by:
            blocks.append(Block(derivative.output, name, result.name, column, width))
            column += prod(arguments[name].shape(self.scene))
        return blocks

    def _loops(self, name: str) -> Program:
        """The structured form of a function."""
        writer = WRITERS.of(name, self.scene.space)
        builder = Builder(name, writer.doc or ROWS[name].doc)
        scene = self._given(writer)
        parameters = Parameters(builder, self.model, writer.units(scene), scene)
        callees = [self.program(callee) for callee in writer.calls]
        writer.write(builder, scene, parameters, *callees, **declared(builder, self.scene, name))
        return prune(builder.finish())


def _has_time(scene: Scene) -> bool:
    """Whether products of runtime parameters take less in a planar sweep's loops than as tables. With couples on the links, which are
    eliminated from the tip alone, the loops of more than twelve take as long (1.00 to 1.05 of the time).
    """
    if not scene.is_planar or not scene.runtime or saves_memory(scene):
        return False
    return scene.links <= _LONGEST_COUPLED or not (ties_links(scene) or scene.actuated_joints)


def _limit_of_written(flat: Program, looped: Program) -> int:
    """Up to how many operations straight-line code is better than loops that are written out."""
    is_sparse = total_operations(looped) <= SPARSE_LOOPS * total_operations(flat)
    return SPARSE_LOOPS_FROM if is_sparse else WRITTEN_JACOBIAN_UNROLL_LIMIT


def _less(one: Program, other: Program | None) -> Program:
    """The one of two Programs of the same function that takes fewer operations."""
    return one if other is None or total_operations(one) <= total_operations(other) else other
