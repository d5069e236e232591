"""The rows of the flows in C and in ctypes: fields lie where both say, constants have the numbers that Python knows."""

from __future__ import annotations

import ctypes
from pathlib import Path
from typing import Any

import pytest

from phichain.contract import flows
from phichain.contract.flow import Struct
from phichain.contract.functions import ROWS
from phichain.emit.c.text import header
from phichain.native.flows.structs import struct_type
from phichain.scene import Scene, scene_from_dict
from phichain.system.propagation import OUTCOMES, Stop
from tests.generated.compiling import need, printed_scene, run

STRUCTS = {
    "propagate": (flows.FLOW, flows.EVENT),
    "propagate_stiff": (flows.STIFF,),
    "propagate_batch": (flows.FLOW_BATCH, flows.BATCH_EVENT),
}
RUNTIME: dict[str, Any] = dict.fromkeys(("mass", "length"), "runtime")


def chain(name: str, **more: Any) -> Scene:
    """A scene with every flow."""
    keys = {"mass": 1.0, "length": 0.5} | {key: more.pop(key) for key in ("mass", "length", "base", "space", "cart_mass") if key in more}
    return scene_from_dict({"name": name, "chain": {"links": 3, **keys}, "functions": {"want": list(STRUCTS)}, **more})


SCENES = {
    scene.name: scene
    for scene in (
        chain("plain"),
        chain("carried", flow={"variational": True}),
        chain("small", target={"real": "float"}, flow={"variational": True}),
        chain("wagon", space="spatial", base="cart", cart_mass=1.0),
        chain("open", **RUNTIME, joints={"actuated": "all"}, target={"real": "float"}),
    )
}


def measured(scene: Scene, expressions: dict[str, str], folder: Path) -> dict[str, int]:
    """The values of C expressions behind NAME.h."""
    need("cc")
    (folder / f"{scene.name}.h").write_text(header(printed_scene(scene), {}))
    lines = "\n".join(f'    printf("%s %ld\\n", "{key}", (long)({text}));' for key, text in expressions.items())
    includes = "#include <stddef.h>\n#include <stdio.h>\n"
    (folder / "main.c").write_text(f'{includes}#include "{scene.name}.h"\nint main(void)\n{{\n{lines}\n    return 0;\n}}\n')
    run("cc", "-std=c99", "-Wall", "-Werror", "main.c", "-o", "main", cwd=folder)
    return {key: int(value) for key, value in (line.split() for line in run(folder / "main").splitlines())}


def layout_in_c(scene: Scene, struct: Struct) -> dict[str, str]:
    kind = f"{scene.name}_{struct.name}"
    expressions = {f"{struct.name}": f"sizeof({kind})"}
    for field in struct.fields_of(scene):
        expressions[f"{struct.name}.{field.name}"] = f"offsetof({kind}, {field.name})"
        expressions[f"{struct.name}.{field.name}.size"] = f"sizeof((({kind} *)0)->{field.name})"
    return expressions


def layout_in_python(scene: Scene, struct: Struct) -> dict[str, int]:
    kind = struct_type(struct, scene)
    known = {struct.name: ctypes.sizeof(kind)}
    for field in struct.fields_of(scene):
        place = getattr(kind, field.name)
        known |= {f"{struct.name}.{field.name}": place.offset, f"{struct.name}.{field.name}.size": place.size}
    return known


@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
def test_structs_lie_alike_in_c_and_in_python(scene: Scene, tmp_path: Path) -> None:
    structs = [struct for group in STRUCTS.values() for struct in group]
    expressions: dict[str, str] = {}
    expected: dict[str, int] = {}
    for struct in structs:
        expressions |= layout_in_c(scene, struct)
        expected |= layout_in_python(scene, struct)
    assert measured(scene, expressions, tmp_path) == expected


def test_constants_have_the_numbers_that_python_knows(tmp_path: Path) -> None:
    scene = SCENES["plain"]
    endings = [name.upper().replace(" ", "_") for name in OUTCOMES]
    expressions = {ending: f"PLAIN_{ending}" for ending in endings}
    expressions |= {f"BATCH_{ending}": f"PLAIN_BATCH_{ending}" for ending in endings}
    expressions |= {f"OF_{scalar.upper()}": f"PLAIN_OF_{scalar.upper()}" for scalar in ("q", "v", "depth")}
    expressions |= {f"STIFF_{ending}": f"PLAIN_STIFF_{ending}" for ending in ("DONE", "STEP_BUDGET", "NOT_FINITE")}
    found = measured(scene, expressions, tmp_path)
    for prefix in ("", "BATCH_"):
        assert [found[f"{prefix}{ending}"] for ending in endings] == [0, 1, 2, 3]
    assert [found[f"OF_{scalar.upper()}"] for scalar in ("q", "v", "depth")] == [
        Stop(scalar, 0).number for scalar in ("q", "v", "depth")
    ]
    assert [OUTCOMES[found[f"STIFF_{ending}"]] for ending in ("DONE", "STEP_BUDGET", "NOT_FINITE")] == [
        "done", "step budget", "not finite",
    ]  # fmt: skip


def test_every_struct_of_a_flow_is_compared() -> None:
    rows = {name: row.flow for name, row in ROWS.items() if row.flow and row.flow.carries}
    assert {name: tuple(s for s in (flow.carries, flow.event) if s) for name, flow in rows.items() if flow} == STRUCTS
