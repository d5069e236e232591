"""What a program that includes the header meets: dialects, mixed precisions, words, the same bytes (points 7, 8, 9, 11)."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator, Mapping
from typing import Final

from benchmarks.firmware.scenes import Generated
from benchmarks.firmware.targets import M4F
from benchmarks.firmware.tools import run

_DIALECTS: Final = (
    ("gcc", "-std=c90", "-pedantic-errors"), ("gcc", "-std=c99", "-pedantic-errors"), ("gcc", "-std=c11", "-pedantic-errors"),
    ("gcc", "-std=c17", "-pedantic-errors"), ("g++", "-std=c++11", "-pedantic-errors"), ("gcc", "-std=c99", "-fshort-enums"),
    ("gcc", "-std=c99", "-funsigned-char"), ("clang", "-std=c90", "-Wall"), ("clang", "-x", "c++", "-std=c++11"),
)  # fmt: skip
_WORDS: Final = ("SI units", "in ", "out", "stack", "flash", "relative to the largest entry")


def precision(folders: Mapping[str, Generated]) -> Iterator[str]:
    """7: numbers of the other precision do not compile, in C and in C++."""
    made = folders["fw_planar4"]
    for compiler, language in (("gcc", "c"), ("clang", "c"), ("g++", "c++"), ("arm-none-eabi-gcc", "c")):
        for real, is_right in (("float", True), ("double", False)):
            file = made.folder / "mixed.c"
            file.write_text(
                f'#include "{made.header.name}"\nvoid use({real} *x);\nvoid use({real} *x)\n{{\n'
                f"    {made.scene.name}_forward_dynamics(x, x + 4, x + 8, x + 12);\n}}\n"
            )
            done = subprocess.run(
                [compiler, "-x", language, "-fsyntax-only", file.name], cwd=made.folder, capture_output=True, check=False
            )
            if (done.returncode == 0) is not is_right:
                yield f"{compiler}: {real} passed to float functions {'is refused' if is_right else 'compiles'}"


def hooks(folders: Mapping[str, Generated]) -> Iterator[str]:
    """14: a hook of the other precision does not compile, and one that is missing does not link."""
    for made in folders.values():
        for hook in made.hook:
            wrong = made.folder / "wrong_hook.c"
            wrong.write_text(re.sub(rf"\b{made.scene.name}_real\b", "double", hook.read_text()))
            for compiler in ("gcc", "clang", "arm-none-eabi-gcc"):
                done = subprocess.run([compiler, "-fsyntax-only", wrong.name], cwd=made.folder, capture_output=True, check=False)
                if done.returncode == 0:
                    yield f"{made.scene.name}: {compiler} takes a hook of the other precision"
            done = subprocess.run(
                ["gcc", made.source.name, made.selftest.name, "-o", "unhooked", "-lm"], cwd=made.folder, capture_output=True, text=True, check=False
            )
            if done.returncode == 0 or str(made.scene.trig_hook) not in done.stderr:
                yield f"{made.scene.name}: links without its hook"


def headers(folders: Mapping[str, Generated]) -> Iterator[str]:
    """8: every dialect reads the header, and the source as C++ too; it says what a caller must know."""
    for name, made in folders.items():
        main = made.folder / "includes.c"
        main.write_text(f'#include "{name}.h"\n#include "{name}.h"\nint main(void)\n{{\n    return 0;\n}}\n')
        for compiler, *flags in _DIALECTS:
            run(compiler, *flags, "-Werror", "-fsyntax-only", main.name, cwd=made.folder)
        run("g++", "-x", "c++", "-std=c++11", "-fsyntax-only", made.source.name, cwd=made.folder)
        M4F.compile(made.source, "-O2", "-fshort-enums", "-funsigned-char", "-Werror")
        text = made.header.read_text()
        for word in _WORDS:
            if word not in text:
                yield f"{name}.h says nothing of: {word}"


def same_bytes(folders: Mapping[str, Generated]) -> Iterator[str]:
    """9: the same bytes under another hash seed, in another folder."""
    made = folders["fw_spatial2"]
    file = made.folder.parent / "fw_spatial2.toml"
    file.write_text(made.scene.to_toml())
    other = made.folder.parent / "elsewhere"
    subprocess.run(
        [sys.executable, "-m", "phichain", "generate", str(file), "--out", str(other), "--no-proof"],
        env={**os.environ, "PYTHONHASHSEED": "4711"}, check=True, capture_output=True,
    )  # fmt: skip
    for path in sorted((other / "fw_spatial2").iterdir()):
        if path.read_bytes() != (made.folder / path.name).read_bytes():
            yield f"{path.name} differs"
    again = subprocess.run(
        [sys.executable, "-m", "phichain", "generate", str(file), "--out", str(other), "--no-proof", "--check"], capture_output=True, check=False
    )
    if again.returncode != 0:
        yield f"11: --check finds drift where there is none: {again.stderr.decode()[:300]}"
    target = other / "fw_spatial2" / "fw_spatial2.c"
    target.write_text(target.read_text() + "/* edited */\n")
    drifted = subprocess.run(
        [sys.executable, "-m", "phichain", "generate", str(file), "--out", str(other), "--no-proof", "--check"], capture_output=True, check=False
    )
    if drifted.returncode != 1:
        yield f"11: --check ends with {drifted.returncode} where a file was edited"
