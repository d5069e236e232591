"""What runtime parameters alone determine as C: NAME_prepare, its struct, and the forward dynamics that goes on from there."""

from __future__ import annotations

from collections.abc import Collection

from phichain.contract.flow import Flow
from phichain.contract.flows import PREPARE, PREPARED_DYNAMICS
from phichain.contract.functions import ROWS
from phichain.emit.c.comment import Comments
from phichain.emit.c.function import c_function
from phichain.emit.c.layout import laid_out_text
from phichain.emit.c.parts import words
from phichain.emit.flow.declared import arguments, documented
from phichain.emit.flow.flows import FlowText, prints
from phichain.emit.flow.instance import c_names, table_rows
from phichain.emit.render import render
from phichain.lowering.preparation import VALUES, Preparation, preparation
from phichain.mechanics import Model
from phichain.scene import Scene

#: How header and source describe the second function.
DYNAMICS_DOC = "Accelerations: the equations of motion solved, with what the runtime parameters determine at hand."


@prints("prepare")
def prepare(model: Model, known: Collection[str] = ()) -> FlowText:
    """Print both parts of a scene's forward dynamics.

    Args:
        model: the scene's mechanics.
        known: functions of NAME.c that stand before; these need none of them.
    """
    scene, made = model.scene, preparation(model)
    before = made.split.first if made.split else None
    names = c_names(scene, f"{scene.name}_prepared", filter(None, (before, made.rest)))
    first, rest = c_function(before, names, {}) if before else None, c_function(made.rest, names, {})
    used = words("\n".join(rest.lines))
    uses = rest.uses | (first.uses if first else frozenset())
    definitions = render(
        "flow/prepare.c.j2", name=scene.name, real=f"{scene.name}_real", size=made.size, first=first.lines if first else (), lines=rest.lines,
        tables=table_rows(names),
        doc=ROWS["prepare"].doc, comment=Comments(scene).above("forward_dynamics", DYNAMICS_DOC, rest.lines),
        prepare=_declared(PREPARE, scene, True), dynamics=_declared(PREPARED_DYNAMICS, scene, True),
        takes_p="p" in used, takes_values=VALUES in used,
        ignored=[array.name for array in made.rest.inputs if array.name not in used | {VALUES}],
    )  # fmt: skip
    return FlowText(
        declarations=laid_out_text(_declarations(scene, made)), definitions=laid_out_text(definitions),
        includes=("math.h",) if "math" in uses else (), uses=uses,
    )  # fmt: skip


def _declarations(scene: Scene, made: Preparation) -> str:
    before, at_a_state = made.operations
    return render(
        "flow/prepare.h.j2", name=scene.name, real=f"{scene.name}_real", size=made.size, doc=ROWS["prepare"].doc, dynamics_doc=DYNAMICS_DOC,
        prepare=_declared(PREPARE, scene, False), dynamics=_declared(PREPARED_DYNAMICS, scene, False),
        arguments=documented(PREPARE, scene), dynamics_arguments=documented(PREPARED_DYNAMICS, scene),
        before=before, at_a_state=at_a_state, form=", straight-line code" if made.rest.is_straight_line else " in loops",
    )  # fmt: skip


def _declared(flow: Flow, scene: Scene, definition: bool) -> str:
    return ", ".join(arguments(flow, scene, definition=definition))
