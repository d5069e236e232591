"""Emitted C under the system's compiler: objects, their symbols and sections, programs."""

from __future__ import annotations

import shutil
import subprocess
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import pytest

from phichain.emit import folder_files
from phichain.emit.c.text import header, source
from phichain.emit.printed import Printed, print_scene
from phichain.files import write_folder
from phichain.lowering import lower
from phichain.mechanics import derive
from phichain.scene import Scene, load_scene

SCENES_FOLDER = Path(__file__).parents[2] / "scenes"
COMMITTED = tuple(sorted(path.stem for path in SCENES_FOLDER.glob("*.toml")))

STRICT = (
    "-std=c99", "-pedantic-errors", "-Wall", "-Wextra", "-Wconversion", "-Wsign-conversion", "-Wdouble-promotion",
    "-Wfloat-conversion", "-Wshadow", "-Wstrict-prototypes", "-Wmissing-prototypes", "-Wcast-qual", "-Wundef", "-Wvla",
    "-Werror",
)  # fmt: skip
"""The flags that emitted C must bear without a word."""

# What distributions switch on by default would add imports of its own.
PLAIN = ("-std=c99", "-fno-stack-protector", "-U_FORTIFY_SOURCE")


def committed(name: str) -> Scene:
    """A scene of the folder scenes/."""
    return load_scene(SCENES_FOLDER / f"{name}.toml")


@cache
def printed_scene(scene: Scene) -> Printed:
    """The C of a scene, printed once for all tests of a file."""
    return print_scene(scene, lower(derive(scene)))


def write_c(scene: Scene, folder: Path) -> Path:
    """NAME.h and NAME.c alone, without the self-test that takes most of the time; returns NAME.c."""
    (folder / f"{scene.name}.h").write_text(header(printed_scene(scene), {}))
    (folder / f"{scene.name}.c").write_text(source(printed_scene(scene)))
    return folder / f"{scene.name}.c"


def write_all(scene: Scene, folder: Path) -> Path:
    """The whole generated folder, its self-test with it."""
    return write_folder(folder / scene.name, folder_files(scene, lower(derive(scene))))


def run(*words: str | Path, cwd: Path | None = None) -> str:
    """Run a command that must succeed without a word on stderr; returns what it prints."""
    done = subprocess.run([str(word) for word in words], cwd=cwd, capture_output=True, text=True, check=False)
    assert done.returncode == 0 and not done.stderr, f"{words}\n{done.stdout[-2000:]}\n{done.stderr[:4000]}"
    return done.stdout


def compiled(c_file: Path, *flags: str) -> Path:
    """Compile one file without linking."""
    target = c_file.with_suffix(".o")
    run("cc", *flags, "-c", c_file, "-o", target)
    return target


def selftest_program(folder: Path, *flags: str) -> Path:
    """Compile and link the self-test of a generated folder."""
    name = folder.name
    run("cc", *flags, f"{name}.c", "selftest.c", "-o", "selftest", "-lm", cwd=folder)
    return folder / "selftest"


@dataclass(frozen=True)
class Symbols:
    """The symbols of an object, by what they are to a linker."""

    exported: frozenset[str]
    imported: frozenset[str]
    writable: frozenset[str]


def symbols(target: Path) -> Symbols:
    """Read an object with nm."""
    need("nm")
    rows = [line.split() for line in run("nm", target).splitlines()]
    named = [(words[-2], words[-1].split("@")[0]) for words in rows]
    return Symbols(
        frozenset(name for kind, name in named if kind in "TRDBCGSVW"),
        frozenset(name for kind, name in named if kind in "Uvw"),
        frozenset(name for kind, name in named if kind in "DdBbCcSsGg"),
    )


def bytes_of_functions(target: Path) -> dict[str, int]:
    """Bytes of machine code of each exported function."""
    need("nm")
    rows = [line.split() for line in run("nm", "--print-size", target).splitlines()]
    return {words[3]: int(words[1], 16) for words in rows if len(words) == 4 and words[2] == "T"}


def need(tool: str) -> None:
    """Skip the test where a tool is missing that phichain itself does without."""
    if shutil.which(tool) is None:
        pytest.skip(f"{tool} is not installed")
