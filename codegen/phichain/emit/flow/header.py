"""What NAME.h says of the Taylor flow: the workspace it asks for, its prototype and its documentation."""

from __future__ import annotations

from math import prod

from phichain.contract.flows import EVENT, FLOW, PROPAGATE
from phichain.contract.functions import ROWS
from phichain.emit.flow.columns import workspace as columns_workspace
from phichain.emit.flow.declared import arguments, documented, outcome_lines, scalar_constants, struct_lines
from phichain.emit.flow.instance import turns
from phichain.emit.render import render
from phichain.lowering.series.series import HIGHEST, Series
from phichain.scene import Scene

Arrays = list[tuple[str, tuple[int, ...]]]


def declarations(scene: Scene, made: Series) -> str:
    """Types and prototype."""
    return render(
        "flow/flow.h.j2", name=scene.name, upper=scene.name.upper(), doc=ROWS["propagate"].doc, outcomes=outcome_lines(PROPAGATE, scene), scalars=scalar_constants(PROPAGATE, scene),
        event=struct_lines(EVENT, scene), flow=struct_lines(FLOW, scene), returns=PROPAGATE.returns,
        prototype=", ".join(arguments(PROPAGATE, scene, definition=False)), arguments=documented(PROPAGATE, scene),
        size=scene.nq + scene.nv, columns=scene.variational, varied=bool(scene.varied), planar=scene.is_planar,
        start=_declared(_start(scene, made)), workspace=_declared(_workspace(scene, made)), columns_first=_declared(_columns(scene, made)),
        workspace_bytes=workspace_bytes(scene, made),
    )  # fmt: skip


def _declared(arrays: Arrays) -> list[tuple[str, str]]:
    return [(array, "".join(f"[{extent}]" for extent in extents)) for array, extents in arrays]


def _start(scene: Scene, made: Series) -> Arrays:
    """Names and extents of what a step starts from."""
    return [
        ("unit", (2,)), ("held", (made.held,)), ("slope", (2 * scene.nq,)), ("left", (2, made.width)),
        ("right", (2, made.rights * made.lanes)), *([("later", (made.held,)), ("drive", (2,))] if made.is_forced else []),
        *([("rubs", (HIGHEST[scene.real] + 2, made.rubs))] if made.rubs else []),
    ]  # fmt: skip


def _workspace(scene: Scene, made: Series) -> Arrays:
    """Names and extents of the other arrays that a propagation works on."""
    highest, size = HIGHEST[scene.real], 2 * scene.nq
    own: Arrays = [
        ("x", (highest + 1, size)), ("left", (highest + 1, made.width)),
        ("right", (highest + 1, made.rights * made.lanes)), ("sums", (4, made.sums)),
        ("state", (size,)), ("lost", (size,)), ("moved", (size,)), ("moved_lost", (size,)),
    ]  # fmt: skip
    if scene.nu:
        own.append(("u", (scene.nu,)))
    if made.is_forced:
        own += [(name, ()) for name in ("t", "t_lost", "amplitude", "omega")]
    if turns(scene):
        own.append(("turns", (scene.nq,)))
    if made.rubs:
        own.append(("powers", (highest, highest, made.rubs)))
    return own


def _columns(scene: Scene, made: Series) -> Arrays:
    """The arrays of derivatives, which come first: a workspace on a cache line has their vectors on one."""
    return columns_workspace(scene, made, HIGHEST[scene.real]) if made.columns is not None else []


def workspace_bytes(scene: Scene, made: Series) -> int:
    """Bytes of a workspace."""
    numbers = [prod(extents) for _, extents in (*_columns(scene, made), *_start(scene, made), *_start(scene, made), *_workspace(scene, made))]
    return (8 if scene.real == "double" else 4) * sum(numbers)
