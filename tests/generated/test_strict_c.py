"""Emitted C bears the strictest warnings, its headers are C++ as well, its objects hold what was wanted and no more."""

from __future__ import annotations

import subprocess
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import pytest

from phichain.emit.c.text import header
from phichain.scene import Scene
from tests.generated.compiling import (
    COMMITTED,
    PLAIN,
    STRICT,
    committed,
    compiled,
    need,
    printed_scene,
    run,
    symbols,
    write_c,
)
from tests.offered import offered

#: What C files may ask of the C library: mathematics, and the copying and clearing of bits (which compilers do themselves).
LIBRARY = {
    f"{name}{suffix}"
    for name in ("sin", "cos", "sincos", "sqrt", "fabs", "exp", "log", "pow", "ceil", "floor", "fma", "frexp", "ldexp", "tanh")
    for suffix in ("", "f")
} | {"memcpy", "memset"}


def kinds_of_one_link() -> list[Scene]:
    """Chains of one link, where loops have no turns and sums no terms; every function each."""
    scenes = []
    for number, (space, base, com) in enumerate(
        product(("planar", "spatial"), ("fixed", "cart"), (None, 0.4))
    ):
        keys: dict[str, Any] = {"com": com, "mass": "runtime" if number % 3 == 1 else 0.3, "length": 0.7}
        keys |= {"cart_mass": 1.5} if base == "cart" else {}
        keys |= {"stiffness": 2.0} if number % 2 else {}
        keys |= {"damping": 0.1} if number % 4 == 2 else {}
        want = offered(space, "damping" in keys, flows=True)
        name = f"one_{space}_{base}_{'tip' if com is None else 'mid'}"
        scenes.append(Scene(name, 1, space=space, base=base, want=want, **keys))
    return scenes


@pytest.mark.long
@pytest.mark.parametrize("name", COMMITTED)
def test_a_committed_scene_compiles_to_what_it_wants_and_mathematics(name: str, tmp_path: Path) -> None:
    """No warning; every wanted function exported and nothing else; no state; no allocation, no input or output."""
    scene = committed(name)
    found = symbols(compiled(write_c(scene, tmp_path), *STRICT, *PLAIN, "-O1"))
    assert found.exported == {f"{scene.name}_{function}" for function in scene.want}
    assert found.imported <= LIBRARY
    assert found.writable == frozenset()


@pytest.mark.long
@pytest.mark.parametrize("code", ["loops", "unrolled"])
@pytest.mark.parametrize("name", sorted(set(COMMITTED) - {"spatial4_full"}))
def test_the_other_forms_of_committed_scenes_compile_without_a_warning(
    name: str, code: str, tmp_path: Path
) -> None:
    """Loops in single, straight-line code in double precision (that of spatial4_full has 20 000 lines)."""
    form: dict[str, Any] = {"code": code, "real": "float" if code == "loops" else "double"}
    compiled(write_c(replace(committed(name), **form), tmp_path), *STRICT, "-O0")


@pytest.mark.long
@pytest.mark.parametrize("scene", kinds_of_one_link(), ids=lambda scene: scene.name)
def test_one_link_compiles_without_a_warning_in_every_form(scene: Scene, tmp_path: Path) -> None:
    for code, real in product(("loops", "unrolled"), ("double", "float")):
        form: dict[str, Any] = {"name": f"{scene.name}_{code}_{real}", "code": code, "real": real}
        compiled(write_c(replace(scene, **form), tmp_path), *STRICT, "-O0")


@pytest.mark.parametrize("name", ["paper_a_2", "firmware_cart_float", "spatial5_cart_forward_only"])
def test_the_optimiser_finds_nothing_to_warn_of(name: str, tmp_path: Path) -> None:
    """What may be uninitialised, or is compared to no effect, shows only under optimisation."""
    compiled(
        write_c(committed(name), tmp_path),
        *STRICT,
        "-O2",
        "-Wfloat-equal",
        "-Wunreachable-code",
        "-Wcast-align",
    )


def test_warnings_are_found_at_all(tmp_path: Path) -> None:
    c_file = write_c(committed("planar4_forward_only"), tmp_path)
    c_file.write_text(c_file.read_text() + "\nstatic int narrowed(double x)\n{\n    return x;\n}\n")
    with pytest.raises(AssertionError, match="-Wfloat-conversion|-Wconversion"):
        compiled(c_file, *STRICT, "-O0")


# --- headers ---------------------------------------------------------------------------------------------------------


def test_all_headers_together_are_c_plus_plus(tmp_path: Path) -> None:
    """No name of one header is a name of another, or a keyword of C++."""
    need("c++")
    scenes = [*map(committed, COMMITTED), *kinds_of_one_link()]
    for scene in scenes:
        (tmp_path / f"{scene.name}.h").write_text(header(printed_scene(scene), {}))
    text = "".join(f'#include "{scene.name}.h"\n' for scene in (*scenes, scenes[0]))
    (tmp_path / "all.cpp").write_text(f"{text}int main() {{ return 0; }}\n")
    run(
        "c++",
        "-std=c++11",
        "-Wall",
        "-Wextra",
        "-pedantic-errors",
        "-Werror",
        "-fsyntax-only",
        "all.cpp",
        cwd=tmp_path,
    )


def test_a_c_plus_plus_program_links_the_c(tmp_path: Path) -> None:
    need("c++")
    compiled(write_c(committed("firmware_cart_float"), tmp_path), "-std=c99", "-O1")
    (tmp_path / "main.cpp").write_text(
        '#include "firmware_cart_float.h"\n'
        "int main()\n{\n"
        "    const float q[FIRMWARE_CART_FLOAT_NQ] = {}, v[FIRMWARE_CART_FLOAT_NV] = {}, u[FIRMWARE_CART_FLOAT_NU] = {};\n"
        "    firmware_cart_float_real a[FIRMWARE_CART_FLOAT_NV] = {1.0f, 1.0f, 1.0f};\n"
        "    firmware_cart_float_forward_dynamics(q, v, u, a);\n"
        "    return a[0] == 0.0f && a[1] == 0.0f && a[2] == 0.0f ? 0 : 1;\n}\n"
    )
    run("c++", "-std=c++11", "main.cpp", "firmware_cart_float.o", "-o", "main", cwd=tmp_path)
    run(tmp_path / "main")


# --- objects ---------------------------------------------------------------------------------------------------------


def test_a_scene_of_one_function_holds_that_function_alone(tmp_path: Path) -> None:
    """A planar chain on a fixed base, no input: its forward dynamics and the sine-cosine kernel, nothing of a cart or phi."""
    c_file = write_c(committed("planar4_forward_only"), tmp_path)
    found = symbols(compiled(c_file, *PLAIN, "-O1"))
    assert found.exported == {"planar4_forward_only_forward_dynamics"}
    assert found.imported <= {"sin", "cos", "sincos"}
    for absent in ("cart", "bessel", "energy", "params", "malloc", "selftest"):
        assert absent not in c_file.read_text(), absent


def test_unit_vectors_need_no_library_at_all(tmp_path: Path) -> None:
    found = symbols(compiled(write_c(committed("spatial5_cart_forward_only"), tmp_path), *PLAIN, "-O1"))
    assert found.imported == frozenset()


def test_no_name_at_file_scope_lacks_the_prefix(tmp_path: Path) -> None:
    """Two scenes compiled as one file do not meet, static names and tables included."""
    parts = []
    for name in ("planar3_cart", "paper_a_4", "spatial4_full"):
        scene = replace(committed(name), code="loops")
        parts.append(write_c(scene, tmp_path).name)
    (tmp_path / "unity.c").write_text("".join(f'#include "{part}"\n' for part in parts))
    compiled(tmp_path / "unity.c", *STRICT, "-O0")


def test_float_code_computes_in_float_alone_on_a_single_precision_unit(tmp_path: Path) -> None:
    """Where a processor has no double unit, one double operation would call the run-time library."""
    need("arm-none-eabi-gcc")
    cortex_m4 = ("-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16")
    c_file = write_c(committed("firmware_cart_float"), tmp_path)
    done = subprocess.run(
        ["arm-none-eabi-gcc", *cortex_m4, *STRICT, "-O2", "-c", c_file.name, "-o", "arm.o"],
        cwd=tmp_path, capture_output=True, text=True, check=False,
    )  # fmt: skip
    if "No such file or directory" in done.stderr:
        pytest.skip("arm-none-eabi-gcc has no C library")
    assert done.returncode == 0, done.stderr
    undefined = run("arm-none-eabi-nm", "--undefined-only", tmp_path / "arm.o")
    assert {line.split()[-1] for line in undefined.splitlines()} <= {"sinf", "cosf"}


def test_state_and_allocation_would_be_seen(tmp_path: Path) -> None:
    (tmp_path / "careless.c").write_text(
        "#include <stdlib.h>\nstatic int calls;\nint table[2] = {1, 2};\n"
        "void *careless(void);\nvoid *careless(void)\n{\n    calls += table[1];\n    return malloc((size_t)calls);\n}\n"
    )
    found = symbols(compiled(tmp_path / "careless.c", *PLAIN, "-O1"))
    assert found.exported == {"careless", "table"}
    assert found.imported == {"malloc"}
    assert found.writable == {"calls", "table"}
