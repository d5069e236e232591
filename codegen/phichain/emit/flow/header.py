"""What NAME.h says of the Taylor flow: the workspace it asks for, its prototype and its documentation."""

from __future__ import annotations

from math import prod
from typing import Final

from phichain.emit.flow.columns import workspace as columns_workspace
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


def declarations(scene: Scene, recurrences: Jets) -> str:
    """Types and prototype."""
    return render(
        "flow.h.j2", name=scene.name, upper=scene.name.upper(), prototype=", ".join(arguments(scene, False)),
        arguments=_documented(scene), size=scene.nq + scene.nv, columns=scene.variational, planar=scene.is_planar,
        workspace=[(array, "".join(f"[{extent}]" for extent in extents)) for array, extents in workspace(scene, recurrences)],
        workspace_bytes=_bytes(scene, recurrences), on_stack=on_stack(scene, recurrences),
    )  # fmt: skip


def arguments(scene: Scene, definition: bool) -> list[str]:
    """The arguments of NAME_propagate as they are declared, or defined."""
    real, restrict = f"{scene.name}_real", "restrict " if definition else ""
    return [
        *([f"const {scene.name}_params *p"] if scene.runtime else []),
        f"{scene.name}_flow *flow",
        f"{real} t_end",
        "unsigned long max_steps",
        *([f"const {real} u[{scene.nu}]"] if scene.nu else []),
        f"{real} q[{restrict}{scene.nq}]",
        f"{real} v[{restrict}{scene.nv}]",
        f"const {scene.name}_event *event",
        "unsigned long count",
        f"const {real} *times",
        f"{real} *q_out",
        f"{real} *v_out",
    ]


def _documented(scene: Scene) -> list[tuple[str, str, str]]:
    rows = [
        ("p", "in", "parameters") if scene.runtime else None,
        ("flow", "in, out", "start time and tolerance; what was done"),
        ("t_end", "in", "final time, s"),
        ("max_steps", "in", "step budget; called again, it goes on from where it stopped"),
        ("u", "in", "inputs, held constant") if scene.nu else None,
        ("q, v", "in, out", "state"),
        ("event", "in", "where to stop, or NULL"),
        ("count", "in", "number of times"),
        ("times", "in", "times on the way, in its order, at which the state is wanted, or NULL"),
        ("q_out", "out", f"configurations there, count x {scene.nq}, or NULL"),
        ("v_out", "out", f"rates there, count x {scene.nv}, or NULL"),
    ]
    return [row for row in rows if row is not None]


def words_of(declarations: list[str]) -> list[str]:
    """The names of declared arguments."""
    return [declaration.split("[")[0].split()[-1].lstrip("*") for declaration in declarations]


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
