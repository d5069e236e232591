"""Packages of firmware ecosystems: what each expects is there, builds, and says what it holds."""

from __future__ import annotations

import hashlib
import json
import re
import subprocess
from pathlib import Path

import pytest

from phichain.errors import UnsupportedError
from phichain.firmware.packages import KINDS, semantic
from phichain.pipeline import check_folder, generate
from phichain.scene import Scene
from tests.generated.compiling import need, run

CHAIN = Scene("boxed", 1, mass=1.0, length=0.5, real="float", trig="bundled")

LAYOUTS = {
    "cmake": {"CMakeLists.txt", "src/boxed.c", "include/boxed.h", "test/selftest.c"},
    "zephyr": {"zephyr/module.yml", "zephyr/Kconfig", "zephyr/CMakeLists.txt", "src/boxed.c", "include/boxed.h", "test/selftest.c"},
    "platformio": {"library.json", "src/boxed.c", "include/boxed.h", "examples/selftest/selftest.c"},
    "arduino": {
        "library.properties", "src/boxed.c", "src/boxed.h", "src/boxed_selftest.c", "examples/boxed_selftest/boxed_selftest.ino",
    },
}  # fmt: skip


@pytest.fixture(scope="module")
def packages(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    return {kind: generate(CHAIN, tmp_path_factory.mktemp(kind), prove=False, package=kind) for kind in KINDS}


@pytest.mark.parametrize("kind", LAYOUTS)
def test_each_kind_has_its_layout_and_nothing_else(kind: str, packages: dict[str, Path]) -> None:
    folder = packages[kind]
    found = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
    assert found == LAYOUTS[kind] | {"README.md", "manifest.json", "boxed.cdx.json"}


@pytest.mark.parametrize("kind", LAYOUTS)
def test_the_bill_of_materials_names_every_file_by_its_hash(kind: str, packages: dict[str, Path]) -> None:
    folder = packages[kind]
    bill = json.loads((folder / "boxed.cdx.json").read_text())
    assert (bill["bomFormat"], bill["specVersion"], bill["version"]) == ("CycloneDX", "1.5", 1)
    assert re.fullmatch(r"urn:uuid:[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}", bill["serialNumber"])
    stated = {one["name"]: one["hashes"][0]["content"] for one in bill["components"]}
    assert stated == {name: hashlib.sha256((folder / name).read_bytes()).hexdigest() for name in LAYOUTS[kind] | {"README.md"}}
    references = {one["bom-ref"] for one in bill["components"]} | {bill["metadata"]["component"]["bom-ref"]}
    assert all({one["ref"], *one["dependsOn"]} <= references for one in bill["dependencies"])
    assert "timestamp" not in json.dumps(bill)


@pytest.mark.parametrize("kind", LAYOUTS)
def test_a_package_is_checked_like_a_folder(kind: str, packages: dict[str, Path]) -> None:
    assert not check_folder(CHAIN, packages[kind].parent, prove=False, package=kind)
    other = "cmake" if kind != "cmake" else "arduino"
    assert check_folder(CHAIN, packages[kind].parent, prove=False, package=other)


def test_cmake_builds_tests_installs_and_is_found(packages: dict[str, Path], tmp_path: Path) -> None:
    need("cmake")
    run("cmake", "-S", packages["cmake"], "-B", tmp_path / "build", f"-DCMAKE_INSTALL_PREFIX={tmp_path / 'there'}")
    run("cmake", "--build", tmp_path / "build")
    run("ctest", "--test-dir", tmp_path / "build", "--output-on-failure")
    run("cmake", "--install", tmp_path / "build")
    user = tmp_path / "user"
    user.mkdir()
    (user / "main.c").write_text(
        '#include "boxed.h"\nint main(void)\n{\n    const float q[1] = {0.0F}, v[1] = {0.0F};\n    float a[1];\n'
        "    boxed_forward_dynamics(q, v, a);\n    return a[0] < 0.0F;\n}\n"
    )
    (user / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.15)\nproject(user C)\nfind_package(boxed REQUIRED)\n"
        "add_executable(user main.c)\ntarget_link_libraries(user boxed::boxed)\n"
    )
    run("cmake", "-S", user, "-B", user / "build", f"-DCMAKE_PREFIX_PATH={tmp_path / 'there'}")
    run("cmake", "--build", user / "build")
    run(user / "build" / "user")


@pytest.mark.long
@pytest.mark.parametrize("package", [None, "cmake"])
def test_a_scene_with_a_hook_builds_and_runs_its_own_self_test(package: str | None, tmp_path: Path) -> None:
    """By the C library where nothing is said, and by what the user names."""
    need("cmake")
    scene = Scene("hooked", 1, mass=1.0, length=0.5, real="float", want=("forward_dynamics",), trig="hook", trig_hook="board_sincosf")
    folder = generate(scene, tmp_path, prove=False, package=package)
    own = next(folder.rglob("selftest_hook.c")).read_text()
    wrong = tmp_path / "wrong.c"
    wrong.write_text(own.replace("= cosf(", "= 0.5F * cosf(").replace("= sinf(", "= 0.5F * sinf("))
    for build, more in (("own", ()), ("wrong", (f"-DHOOKED_HOOK={wrong}",))):
        run("cmake", "-S", folder, "-B", tmp_path / build, *more)
        run("cmake", "--build", tmp_path / build)
        ended = subprocess.run([tmp_path / build / "hooked_selftest"], capture_output=True, check=False).returncode
        assert (ended == 0) == (build == "own")


def test_zephyr_finds_a_module(packages: dict[str, Path]) -> None:
    """module.yml by the keys of Zephyr's schema (scripts/zephyr_module.py), whose paths must be there; Kconfig and CMake agree."""
    folder = packages["zephyr"]
    lines = (folder / "zephyr/module.yml").read_text().splitlines()
    module: dict[str, object] = {key: value for key, value in (line.split(": ") for line in lines if re.match(r"\w.*: ", line))}
    build = dict(line.strip().split(": ") for line in lines if line.startswith("  "))
    assert [line for line in lines if line.endswith(":")] == ["build:"] and len(lines) == 1 + len(module) + len(build)
    assert set(module) <= {"name", "build", "tests", "samples", "boards", "blobs", "security", "package-managers", "runners"}
    assert set(build) <= {"cmake", "kconfig", "cmake-ext", "kconfig-ext", "sysbuild-cmake", "sysbuild-kconfig", "depends", "settings"}
    assert module["name"] == "boxed" and (folder / build["cmake"] / "CMakeLists.txt").exists()
    symbols = set(re.findall(r"^config (\w+)$", (folder / build["kconfig"]).read_text(), re.MULTILINE))
    cmake = (folder / "zephyr/CMakeLists.txt").read_text()
    assert set(re.findall(r"CONFIG_(\w+)", cmake)) == symbols == {"BOXED", "BOXED_SELFTEST"}
    for path in re.findall(r"\.\./\S+?(?=\))", cmake):
        assert (folder / "zephyr" / path).exists(), path


def test_arduino_and_platformio_say_what_they_must(packages: dict[str, Path], tmp_path: Path) -> None:
    """The keys that their specifications require, and the Arduino folder compiled as Arduino does: all of src, the sketch as C++."""
    lines = (packages["arduino"] / "library.properties").read_text().splitlines()
    properties = dict(line.split("=", 1) for line in lines)
    required = {"name", "version", "author", "maintainer", "sentence", "paragraph", "category", "url", "architectures"}
    assert required <= set(properties) and re.fullmatch(r"\d+\.\d+\.\d+", properties["version"])
    assert properties["category"] == "Other" and re.fullmatch(r"[A-Za-z0-9][\w .-]{0,62}", properties["name"])
    library = json.loads((packages["platformio"] / "library.json").read_text())
    assert {"name", "version", "description", "keywords", "frameworks", "platforms"} <= set(library)
    need("c++")
    source = packages["arduino"] / "src"
    for file in sorted(source.glob("*.c")):
        run("cc", "-std=gnu11", "-Wall", "-Wextra", "-Werror", f"-I{source}", "-c", file, "-o", tmp_path / f"{file.stem}.o")
    (tmp_path / "Arduino.h").write_text(
        "#include <cstdio>\nstruct Port {\n    void begin(long) {}\n    explicit operator bool() const { return true; }\n"
        "    void print(const char *s) { std::printf(\"%s\", s); }\n    void println(const char *s) { std::printf(\"%s\\n\", s); }\n"
        "    void println(int k) { std::printf(\"%d\\n\", k); }\n};\nstatic Port Serial;\nvoid setup();\nvoid loop();\n"
    )
    sketch = next((packages["arduino"] / "examples").rglob("*.ino")).read_text()
    (tmp_path / "sketch.cpp").write_text(f'#include "Arduino.h"\n{sketch}\nint main()\n{{\n    setup();\n    loop();\n}}\n')
    objects = [tmp_path / "boxed.o", tmp_path / "boxed_selftest.o"]
    run("c++", "-std=gnu++11", f"-I{source}", tmp_path / "sketch.cpp", *objects, "-o", tmp_path / "sketch")
    assert subprocess.run([tmp_path / "sketch"], capture_output=True, text=True, check=True).stdout == "boxed: all passed\n"


def test_an_unknown_kind_is_one_clear_error(tmp_path: Path) -> None:
    with pytest.raises(UnsupportedError) as caught:
        generate(CHAIN, tmp_path, package="zefyr")
    assert str(caught.value) == (
        "package: is no kind of package (got 'zefyr'); use cmake, zephyr, platformio, arduino (did you mean \"zephyr\"?)"
    )
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(("version", "numbers"), [("0.1.0", "0.1.0"), ("1.2", "1.2.0"), ("3.4.5.dev6+abc", "3.4.5")])
def test_versions_have_three_numbers(version: str, numbers: str) -> None:
    assert semantic(version) == numbers
