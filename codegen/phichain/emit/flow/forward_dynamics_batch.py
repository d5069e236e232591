"""The forward dynamics of many trajectories as C: ``NAME_forward_dynamics_batch``, on component-major arrays."""

from __future__ import annotations

from collections.abc import Collection
from fractions import Fraction
from typing import Final

from phichain.contract.flows import FORWARD_DYNAMICS_BATCH as CONTRACT
from phichain.contract.functions import ROWS
from phichain.emit.c.function import c_function
from phichain.emit.c.lanes import lane_function, lanes_kernel
from phichain.emit.c.layout import laid_out_text
from phichain.emit.c.names import CNames
from phichain.emit.c.parts import words
from phichain.emit.flow.declared import arguments, documented
from phichain.emit.flow.flows import FlowText, prints
from phichain.emit.render import render
from phichain.ir.inline import inline
from phichain.ir.nodes import Op, Program
from phichain.ir.passes import total_operations
from phichain.lowering.dynamics import form_of_many
from phichain.lowering.lower import lower_function
from phichain.mechanics import Model
from phichain.scene import Scene
from phichain.transform.prepared import PREPARED, prepared

#: Vector registers a value takes: sweeps are bound by latency, and this many do not wait for each other.
REGISTERS: Final = 4
#: Up to this many operations without sines, a value takes one: registers then hold nearly all, and what limits is the way to memory and back.
FEW_OPERATIONS: Final = 130
#: Up to this many operations `auto` takes straight-line code: there is no loop over links left to vectorise, and what a
#: link hands to the next stays in registers.
UNROLL_LIMIT: Final = 1200


@prints("forward_dynamics_batch")
def forward_dynamics_batch(model: Model, known: Collection[str] = ()) -> FlowText:
    """Print the batch form of the forward dynamics.

    Args:
        model: the scene's mechanics.
        known: functions of NAME.c that stand before; this one needs none of them.
    """
    scene, program = model.scene, _program(model)
    tables = table_names(scene, program)
    names = CNames(scene.name, scene.real, tables)
    stem = f"{scene.name}_batch"
    split = prepared(inline(program)) if program.params else None
    program = split.rest if split else program
    body = lane_function(program, names, stem, {PREPARED})
    first = c_function(split.first, names, {}) if split else None
    uses = body.uses | {"lanes_move"}
    used = words("\n".join(body.lines))
    inputs = [(array.name, array.size) for array in program.inputs if array.name != PREPARED]
    given = ["p"] if program.params else []
    text = render(
        "flow/forward_dynamics_batch.c.j2", name=scene.name, doc=ROWS["forward_dynamics_batch"].doc, stem=stem, kernel=lanes_kernel(scene, stem, uses, _registers(program)), real=f"{scene.name}_real", nv=scene.nv, inputs=inputs,
        tables=[(table, len(values), ", ".join(names.number(value).text for value in values)) for (_, values), table in tables.items()],
        parameter=f"const {scene.name}_params *p, " if program.params else "", lines=body.lines,
        pass_parameter="p, " if program.params else "", prepared=split.size if split else 0,
        prepare=first.lines if first else (),
        ignored=[name for name in given if name not in used],
        definition=", ".join(arguments(CONTRACT, scene, definition=True)),
    )  # fmt: skip
    return FlowText(
        declarations=laid_out_text(_declarations(scene)),
        definitions=laid_out_text(text),
        includes=("stddef.h", "string.h", *(("math.h",) if "math" in body.uses else ())),
        uses=uses,
    )


def _program(model: Model) -> Program:
    """The forward dynamics in the form that lanes run fastest."""
    scene = model.scene
    name = form_of_many(scene)
    program = lower_function(model, name, scene.code, keeps_tables=True)
    if scene.code == "auto" and not program.is_straight_line and total_operations(program) <= UNROLL_LIMIT:
        return lower_function(model, name, "unrolled")
    return program


def _registers(program: Program) -> int:
    """Vector registers that a value takes."""
    turns = any(isinstance(statement, Op) and statement.kind in ("sin", "cos") for statement in program.body)
    is_short = program.is_straight_line and not turns and total_operations(program) <= FEW_OPERATIONS
    return 1 if is_short else REGISTERS


def table_names(scene: Scene, program: Program) -> dict[tuple[str, tuple[Fraction, ...]], str]:
    """File-scope names of a Program's tables, apart from those of the scalar functions."""
    return {
        key: f"{scene.name}_lanes_{key[0]}_{number}" for number, key in enumerate(program.tables.items(), 1)
    }


def _declarations(scene: Scene) -> str:
    return render(
        "flow/forward_dynamics_batch.h.j2", name=scene.name, doc=ROWS["forward_dynamics_batch"].doc, returns=CONTRACT.returns, arguments=documented(CONTRACT, scene),
        prototype=", ".join(arguments(CONTRACT, scene, definition=False)),
    )  # fmt: skip
