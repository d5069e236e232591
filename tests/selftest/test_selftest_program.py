"""The self-test that travels with the C: it passes, under sanitizers too, it fails where it should, and CMake builds it."""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from phichain.contract.chain import Sample
from phichain.contract.functions import ON_REQUEST, PLANAR_FUNCTIONS, TABLE
from phichain.scene import Scene
from tests.generated.compiling import COMMITTED, STRICT, committed, need, run, selftest_program
from tests.generated.reference_scenes import FOLDER, REFERENCE

SANITIZERS = (
    "-std=c99", "-g", "-O0", "-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-fno-omit-frame-pointer",
)  # fmt: skip

RUNTIME: dict[str, Any] = dict.fromkeys(("mass", "length", "com", "cart_mass", "gravity", "stiffness"), "runtime")
SPATIAL = tuple(row.name for row in TABLE if row.absence(Sample(False, runtime=("mass",))) is None)
SANITIZED = (
    Scene("planar3_full", 3, base="cart", actuated="all", want=(*PLANAR_FUNCTIONS, *ON_REQUEST), code="loops", **RUNTIME),
    committed("paper_a_2"),
    Scene(
        "spatial2_full", 2, space="spatial", base="cart", want=SPATIAL, code="loops", damping="runtime", **RUNTIME,
    ),
    committed("spatial5_cart_forward_only"),
    committed("firmware_cart_float"),
)  # fmt: skip
"""Everything a chain can have, with loops and without, in double and in single precision."""


def exit_code(program: Path) -> int:
    return subprocess.run([program], capture_output=True, check=False).returncode


def whole(generated: Path, folder: Path) -> Path:
    """A copy of a generated folder, to be compiled in."""
    return Path(shutil.copytree(generated, folder / generated.name))


def copied(name: str, folder: Path) -> Path:
    """A reference folder, to be spoilt."""
    return whole(FOLDER / name, folder)


def spoilt(path: Path, pattern: str, replacement: str) -> None:
    """Change one place of a file."""
    text, count = re.subn(pattern, replacement, path.read_text(), count=1)
    assert count == 1, pattern
    path.write_text(text)


@pytest.mark.long
@pytest.mark.parametrize("name", COMMITTED)
def test_committed_scenes_pass(name: str, generated_once: Callable[[Scene], Path], tmp_path: Path) -> None:
    scene = committed(name)
    program = selftest_program(whole(generated_once(scene), tmp_path), *STRICT, "-O0")
    *cases, last = run(program).splitlines()
    assert last == "all passed"
    assert {line.split()[0].rstrip(",") for line in cases} == set(scene.want)
    assert all(line.endswith("passed") for line in cases)


@pytest.mark.long
@pytest.mark.parametrize("name", REFERENCE)
@pytest.mark.parametrize("flags", [("-O3", "-ffp-contract=fast"), ("-O2", "-ffp-contract=off"), ("-Ofast",)], ids=" ".join)
def test_the_samples_pass_however_they_are_optimised(name: str, flags: tuple[str, ...], tmp_path: Path) -> None:
    """Fused multiply-adds, none, and sums in any order: the tolerances have room for each."""
    assert exit_code(selftest_program(copied(name, tmp_path), "-std=c99", *flags)) == 0


@pytest.fixture
def sanitizers(tmp_path: Path) -> tuple[str, ...]:
    """Flags of the address and undefined-behaviour sanitizers; skips where the compiler has none."""
    (tmp_path / "probe.c").write_text("int main(void) { return 0; }\n")
    command = ["cc", *SANITIZERS, "probe.c", "-o", "probe"]
    if subprocess.run(command, cwd=tmp_path, capture_output=True, check=False).returncode:
        pytest.skip("this compiler has no sanitizers")
    return SANITIZERS


@pytest.mark.long
@pytest.mark.parametrize("scene", SANITIZED, ids=lambda scene: scene.name)
def test_sanitizers_find_nothing(
    scene: Scene, sanitizers: tuple[str, ...], generated_once: Callable[[Scene], Path], tmp_path: Path
) -> None:
    assert run(selftest_program(whole(generated_once(scene), tmp_path), *sanitizers)).endswith("all passed\n")


def test_sanitizers_would_find_an_overrun(sanitizers: tuple[str, ...], tmp_path: Path) -> None:
    folder = copied("planar2", tmp_path)
    spoilt(folder / "planar2.c", r"    a\[1\] = ", "    a[2] = ")
    assert exit_code(selftest_program(folder, *sanitizers, "-w")) != 0


@pytest.mark.parametrize(
    ("name", "pattern", "replacement"),
    [
        ("planar2", r"(    a\[1\] = .*);", r"\1 + 1.0e-10;"),
        ("planar2", r"(    a\[0\] = .*);", r"\1 / 0.0 * 0.0;"),
        ("planar2", r"(    \*kinetic = )", r"\g<1>1.0000000001 * "),
        ("spatial2_cart", r"(    a\[0\] = .*);", r"\1 + 1.0e-10;"),
        ("cart1_float", r"(    v_next\[0\] = .*);", r"\1 + 1.0e-4F;"),
    ],
    ids=["one entry", "nan", "a factor", "loops", "float"],
)
def test_a_wrong_result_is_found(name: str, pattern: str, replacement: str, tmp_path: Path) -> None:
    folder = copied(name, tmp_path)
    spoilt(folder / f"{name}.c", pattern, replacement)
    assert exit_code(selftest_program(folder, "-std=c99", "-O0", "-w")) > 0


def test_cmake_builds_and_tests_a_folder(tmp_path: Path) -> None:
    need("cmake")
    folder = copied("cart1_float", tmp_path)
    run("cmake", "-S", folder, "-B", tmp_path / "build")
    run("cmake", "--build", tmp_path / "build")
    assert "100% tests passed" in run("ctest", cwd=tmp_path / "build")


def test_cmake_takes_a_folder_into_a_project_without_its_self_test(tmp_path: Path) -> None:
    need("cmake")
    copied("cart1_float", tmp_path)
    (tmp_path / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.10)\nproject(firmware C)\nadd_subdirectory(cart1_float)\n"
        "add_executable(firmware main.c)\ntarget_link_libraries(firmware cart1_float)\n"
    )
    (tmp_path / "main.c").write_text(
        '#include "cart1_float.h"\n'
        "int main(void)\n{\n    const float q[2] = {0.0f, 0.0f}, v[2] = {2.0f, 0.0f};\n    float kinetic, potential;\n"
        "    const cart1_float_params p = {.mass = {1.0f}, .length = {1.0f}, .com = {0.5f}, .cart_mass = 2.0f};\n"
        "    cart1_float_energy(&p, q, v, &kinetic, &potential);\n    return kinetic == 6.0f ? 0 : 1;\n}\n"
    )
    run("cmake", "-S", tmp_path, "-B", tmp_path / "build")
    run("cmake", "--build", tmp_path / "build")
    run(tmp_path / "build" / "firmware")
    assert not list((tmp_path / "build").rglob("*selftest*"))
