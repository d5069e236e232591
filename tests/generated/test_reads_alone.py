"""The emitted C as something to read: lines above definitions, explained quantities, one word for restrict, C++ as well."""

from __future__ import annotations

import re
from itertools import product
from pathlib import Path
from typing import Any

import pytest

from phichain.contract.functions import ROWS
from phichain.contract.quantities import TABLE, quantities_of
from phichain.emit.c.text import header, source
from phichain.ir.nodes import For, Op, walk
from phichain.lowering import lower
from phichain.mechanics import derive
from phichain.scene import Scene
from tests.generated.compiling import committed, need, printed_scene, run, write_c
from tests.offered import offered

#: Sweeps of every kind: by tensions and articulated, planar and spatial, with flows, in float, with runtime parameters.
READ = (
    "firmware_cart_float", "paper_a_2", "planar3_cart", "planar4_tip_masses_forward_only", "runtime_double_pendulum",
    "spatial4_fixed_forward_only", "spatial5_cart_forward_only",
)  # fmt: skip

#: Functions that scenes can want but for steps and flows: whose names are looked for in Programs here.
WANTED = frozenset(name for name, row in ROWS.items() if not row.flow and not name.startswith("step_"))

#: A definition at file scope, with the line before it.
DEFINITION = re.compile(r"^(?P<before>.*)\n(?P<head>(?:static )?(?:\w+ )+\*?(?P<name>\w+)\([^;{]*\))\n\{\n", re.MULTILINE)
ROW = re.compile(r"^ \*   (\w+(?:, \w+)*)  +\S", re.MULTILINE)


def definitions(text: str) -> list[tuple[str, str, str]]:
    """(name, comment above, body) of every function."""
    found = []
    for match in DEFINITION.finditer(text):
        above = text[: match.end("before")]
        comment = above[above.rindex("/*") :] if match["before"].endswith("*/") else ""
        body = text[match.end() : text.index("\n}\n", match.end())]
        found.append((match["name"], comment, body))
    return found


def first_line(comment: str) -> str:
    return comment.splitlines()[0].removeprefix("/*").removesuffix("*/").strip()


@pytest.mark.parametrize("name", READ)
def test_every_definition_has_its_line_and_what_the_header_declares_the_header_s(name: str) -> None:
    printed = printed_scene(committed(name))
    declared = dict(
        (function, comment)
        for comment, function in re.findall(rf"(/\*[^/]*?\*/)\n(?:void|int|size_t) ({name}_\w+)\(", header(printed, {}))
    )
    defined = definitions(source(printed))
    assert set(declared) <= {function for function, _, _ in defined}
    for function, comment, _ in defined:
        assert comment, function
        if function in declared:
            assert first_line(comment) == first_line(declared[function])


@pytest.mark.parametrize("name", READ)
def test_every_explained_quantity_is_in_the_body_and_explained_once(name: str) -> None:
    scene = committed(name)
    explained: list[str] = []
    for function, comment, body in definitions(source(printed_scene(scene))):
        if function.removeprefix(f"{scene.name}_") not in scene.want:
            continue
        for row in ROW.findall(comment):
            for quantity in row.split(", "):
                stem = r"d_\w+" if quantity == "d_NAME" else rf"{quantity}(?:_\d+|_[ijk]|_at|_end)*"
                assert re.search(rf"\b{stem}\b", body), (function, quantity)
        rows = comment.splitlines()
        explained += [line for line in rows if ROW.match(line) and "d_NAME" not in line]
        for other in re.findall(r"named as in (.*)\.$", comment, re.MULTILINE):
            assert set(other.split(", ")) <= set(scene.want)
    assert explained and len(explained) == len(set(explained))


def test_units_are_those_that_the_sweep_computes_in() -> None:
    """A chain of equal links measures in them; one of unequal links in SI."""
    equal = Scene("alike", 3, mass=0.5, length=0.2, want=["forward_dynamics"])
    unequal = Scene("unlike", 3, mass=[0.5, 0.5, 0.4], length=0.2, want=["forward_dynamics"])
    assert re.search(r"tension +L/s\^2 ", source(printed_scene(equal)))
    assert re.search(r"tension +m/s\^2 ", source(printed_scene(unequal)))


def names_of(scene: Scene) -> dict[str, set[str]]:
    """The stems of all names in the Programs of a scene, by function."""
    found = {}
    for function, program in lower(derive(scene)).wanted.items():
        names = {array.name for array in program.work} | set(program.tables)
        for statement in walk(program.body):
            names |= {statement.result} if isinstance(statement, Op) else set()
            names |= {statement.variable, *(carry.name for carry in statement.carries)} if isinstance(statement, For) else set()
        found[function] = {re.sub(r"(_(\d+|[ijk]|lane|at|end))+$", "", name) for name in names}
    return found


RICH = (
    ("planar", None, "fixed", None, "loops, known lengths"), ("spatial", None, "cart", None, "loops, tied"),
    ("planar", 0.2, "cart", 0.1, "loops, rigid"), ("spatial", None, "cart", 0.1, "loops, rigid"),
    ("planar", 0.2, "fixed", None, "loops, known lengths"), ("planar", 0.2, "fixed", 0.1, "loops"),
    ("spatial", None, "cart", None, "loops"), ("planar", None, "fixed", 0.1, "auto"), ("spatial", 0.2, "fixed", 0.1, "auto"),
    ("spatial", None, "fixed", 0.1, "loops"), ("spatial", 0.2, "fixed", None, "loops, tied"),
    ("planar", 0.2, "fixed", None, "loops, by columns"), ("planar", 0.2, "cart", None, "loops, lanes"),
)  # fmt: skip
"""Kinds of chains that between them have nearly every name: looked at before the others, which are then seldom needed."""


@pytest.mark.long
def test_the_table_s_names_are_names_of_programs() -> None:
    """No row is about a name that no function has: each is found in a Program of some chain."""
    missing = {row.name for group in TABLE for row in group.rows if group.functions & WANTED and "flow_order" not in group.functions}
    kinds = product(("planar", "spatial"), (None, 0.2), ("fixed", "cart"), (0.1, None), ("loops", "auto", "loops, known lengths", "loops, rigid", "loops, tied"))
    for space, com, base, damping, code in (*RICH, *kinds):
        keys: dict[str, Any] = {"com": com, "stiffness": 2.0, "cart_mass": 1.0 if base == "cart" else None}
        keys |= {"mass": [5, 4, 3, 2, 1, 2, 3] if code == "auto" else "runtime", "length": 0.5 if code == "auto" else "runtime"}
        if code == "loops" and com:
            keys["com"] = "runtime"
        if code == "loops, known lengths":
            keys |= {"mass": [5e3, 4, 3, 2, 1, 2, 3], "length": [0.5, 0.6, 0.7, 0.5, 0.6, 0.7, 0.5]}
        if code == "loops, rigid":
            keys["inertia"] = "runtime"
        if code == "loops, tied":
            keys |= {"mass": [5, 4, 3, 2, 1, 2, 3], "length": 0.5, "stiffness": None, "cart_mass": 10.0 if base == "cart" else None}
            damping = None
        if code == "loops, lanes":
            keys |= {"mass": [1.0 + k for k in range(17)], "length": 0.5}
        links, angles = 17 if code == "loops, lanes" else 7, "adjacent" if code != "auto" else "relative"
        if code == "loops, by columns":
            links, angles = 4, "relative"
            keys |= {"mass": [5, 4, 3, 2], "length": 0.5, "stiffness": None, "trig": "bundled"}
        code = code.partition(",")[0]
        keys |= {"angles": angles, "actuated": "all"} if space == "planar" else {}
        if damping is not None:
            keys |= {"friction": 0.3, "friction_speed": 0.5, "cart_friction": 0.4 if base == "cart" else None}
        want = [name for name in offered(space, damping is not None, on_request=True) if not name.startswith("step_")]
        scene = Scene("names", links, space=space, base=base, damping=damping, code=code, want=want, **keys)
        for function, names in names_of(scene).items():
            missing -= {row.name for _, row in quantities_of(function, scene)} & names
        if not missing:
            break
    assert missing == set()


# --- restrict, and other compilers ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", READ)
def test_restrict_stands_in_one_macro_alone(name: str) -> None:
    """MSVC and C++ know neither `a[restrict 4]` nor `a[static 4]`: the keyword is in the macro's definition alone."""
    text = source(printed_scene(committed(name)))
    code = re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL)
    assert re.findall(r".*\brestrict\b.*", code) == [f"#define {name.upper()}_RESTRICT restrict"]
    assert not re.search(r"\[\s*(restrict|static)\b", code)
    assert code.count(f"{name.upper()}_RESTRICT ") > 1
    assert "_RESTRICT" not in header(printed_scene(committed(name)), {})


@pytest.mark.parametrize("name", ["firmware_cart_float", "paper_a_2", "spatial5_cart_forward_only"])
def test_the_c_is_c_plus_plus_as_well(name: str, tmp_path: Path) -> None:
    need("c++")
    c_file = write_c(committed(name), tmp_path)
    run("c++", "-x", "c++", "-Wall", "-Wextra", "-pedantic-errors", "-Werror", "-fsyntax-only", c_file)


def test_who_wants_no_restrict_defines_it_as_nothing(tmp_path: Path) -> None:
    c_file = write_c(committed("planar4_forward_only"), tmp_path)
    seen = run("cc", "-std=c99", "-E", "-P", "-DPLANAR4_FORWARD_ONLY_RESTRICT=", c_file)
    assert "restrict" not in re.sub(r"__restrict\w*", "", seen.split("planar4_forward_only_real")[-1])
    ours = [line for line in seen.splitlines() if "planar4_forward_only" in line]
    assert ours and not any("restrict" in line for line in ours)
    with_it = run("cc", "-std=c99", "-E", "-P", c_file)
    assert any("a[restrict 4]" in line for line in with_it.splitlines())


def test_the_kind_is_spelt_one_way(tmp_path: Path) -> None:
    """Inside the functions numbers are of the type that NAME.h defines, and of no other."""
    for name in ("firmware_cart_float", "planar3_cart"):
        code = re.sub(r"/\*.*?\*/", "", source(printed_scene(committed(name))), flags=re.DOTALL)
        assert not re.search(r"\b(double|float)\b", code.replace("float.h", "")), name
