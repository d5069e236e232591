"""What NAME.h says of the Taylor flow: the workspace it asks for, its prototype and its documentation."""

from __future__ import annotations

from math import prod
from typing import Final

from phichain.contract.flows import EVENT, FLOW, PROPAGATE
from phichain.contract.functions import ROWS
from phichain.emit.flow.columns import workspace as columns_workspace
from phichain.emit.flow.declared import arguments, documented, outcome_lines, scalar_constants, struct_lines
from phichain.emit.render import render
from phichain.scene import Scene
from phichain.transform.lanes import LEFT, RIGHT, Jets

#: Highest order of the Taylor series. Near round-off higher ones only make longer steps, over which larger terms cancel:
#: 28 lost half a digit against 22 on a pendulum that whirls, in the same time.
HIGHEST: Final = {"double": 22, "float": 14}
#: Lanes come in whole vectors, so that no lane is left to scalar code.
LANES: Final = 8
#: Largest workspace that may lie on the stack, bytes.
ON_STACK: Final = 2**18

#: What the header says where a workspace is small enough for the stack, and where it is not.
_STACK_FACTS: Final = {
    "workspace": "; never returned by this scene", "work": "NULL to work on the stack", "bytes": "",
}  # fmt: skip
_MEMORY_FACTS: Final = {
    "workspace": ", and a workspace is too large for the stack", "work": "never NULL here, too large for a stack",
    "bytes": "; bytes of a workspace where none is given",
}  # fmt: skip


def declarations(scene: Scene, recurrences: Jets) -> str:
    """Types and prototype."""
    facts = _STACK_FACTS if on_stack(scene, recurrences) else _MEMORY_FACTS
    return render(
        "flow.h.j2", name=scene.name, doc=ROWS["propagate"].doc, outcomes=outcome_lines(PROPAGATE, scene, facts), scalars=scalar_constants(PROPAGATE, scene),
        event=struct_lines(EVENT, scene), flow=struct_lines(FLOW, scene, facts), returns=PROPAGATE.returns,
        prototype=", ".join(arguments(PROPAGATE, scene, definition=False)), arguments=documented(PROPAGATE, scene),
        size=scene.nq + scene.nv, columns=scene.variational, planar=scene.is_planar,
        workspace=[(array, "".join(f"[{extent}]" for extent in extents)) for array, extents in workspace(scene, recurrences)],
        workspace_bytes=_bytes(scene, recurrences),
    )  # fmt: skip


def padded(count: int) -> int:
    """Lanes in whole vectors, at least one."""
    return -(-max(count, 1) // LANES) * LANES


def turns(scene: Scene) -> bool:
    """Whether all forces repeat every turn of an angle: springs do not."""
    return scene.is_planar and scene.stiffness is None


def workspace(scene: Scene, recurrences: Jets) -> list[tuple[str, tuple[int, ...]]]:
    """Names and extents of the arrays that a propagation works on."""
    highest, lanes, size = HIGHEST[scene.real], padded(recurrences.products), scene.nq + scene.nv
    others = {LEFT, RIGHT, "a", "q_dot"}
    held = [(array.name, (array.size,)) for array in recurrences.start.outputs if array.name not in others]
    rows = -(-highest // 4) * 4  # the sums of derivatives run in fours
    own = [
        ("left", (rows, lanes)),
        ("right", (rows, lanes)),
        ("sum", (lanes,)),
        ("next_sum", (lanes,)),
        ("x", (highest + 1, size)),
    ]
    own += [("slope", (size,)), ("increment", (size,))]
    counted = [("turns", (scene.nq,))] if turns(scene) else []
    return (
        own + held + counted + (columns_workspace(scene, recurrences, highest) if scene.variational else [])
    )


def _bytes(scene: Scene, recurrences: Jets) -> int:
    size = 8 if scene.real == "double" else 4
    return size * sum(prod(extents) for _, extents in workspace(scene, recurrences))


def on_stack(scene: Scene, recurrences: Jets) -> bool:
    """Whether a workspace is small enough for the stack."""
    return _bytes(scene, recurrences) <= ON_STACK
