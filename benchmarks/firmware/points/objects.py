"""What an object asks for and holds: imports, types of numbers, memory, recursion, frames (points 1, 2, 3, 5, 6)."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Final

from benchmarks.firmware.scenes import Generated
from benchmarks.firmware.targets import BOARD, M4F
from benchmarks.firmware.tools import run

#: A compiler for a processor without an operating system may ask for these whatever the C says (GCC manual, "Standards").
_COMPILERS_OWN: Final = {"memcpy", "memmove", "memset"}
#: What makes a square root one instruction where the processor has it.
_HARDWARE: Final = "-fno-math-errno"
#: Bytes of a frame beyond which memory is the caller's, and what long chains' functions take whose header says so.
_FRAME: Final = 1024
_STATED: Final = {"fw_planar10_dynamics_and_jacobian": 2400, "fw_spatial5_state_jacobian": 1100}


def imports(folders: Mapping[str, Generated]) -> Iterator[str]:
    """1: one .c and one .h; undefined symbols within {sinf, cosf}, none at all with bundled trigonometry."""
    for name, made in folders.items():
        files = sorted(path.name for path in made.folder.iterdir() if path.suffix in (".c", ".h") and path.stem.startswith(name))
        if files != [f"{name}.c", f"{name}.h"]:
            yield f"{name}: the product is {files}"
        for level in ("-Os", "-O2"):
            told = run("arm-none-eabi-nm", "-u", M4F.compile(made.source, level, _HARDWARE))
            undefined = {line.split()[-1] for line in told.splitlines() if line.strip()} - _COMPILERS_OWN
            known = {"libm": {"sinf", "cosf"}, "hook": {str(made.scene.trig_hook)}}.get(str(made.scene.trig), set())
            known |= {word for word in undefined if word.startswith("__aeabi_d")} if made.scene.real == "double" else set()
            if undefined - known:
                yield f"{name} {level}: asks for {sorted(undefined - known)}"


def numbers(folders: Mapping[str, Generated]) -> Iterator[str]:
    """2: single precision without a double; every literal of a number carries its F."""
    for name, made in folders.items():
        if made.scene.real == "double":
            continue
        M4F.compile(made.source, "-Os", "-Wdouble-promotion", "-Wfloat-conversion", "-Wunsuffixed-float-constants", "-Werror")
        code = re.sub(r"/\*.*?\*/", "", made.source.read_text(), flags=re.DOTALL)
        bare = re.findall(r"(?<![\w.])(?:\d+\.\d*|\.\d+)(?:[eE][+-]?\d+)?(?![\w.])", code)
        if bare or re.search(r"\bdouble\b", code):
            yield f"{name}: computes in double: {bare[:3]}"


def memory(folders: Mapping[str, Generated]) -> Iterator[str]:
    """3: no allocation, recursion, array of variable length or goto, no memory of its own that changes."""
    for name, made in folders.items():
        code = re.sub(r"/\*.*?\*/", "", made.source.read_text(), flags=re.DOTALL)
        for word in ("malloc", "calloc", "realloc", "free", "alloca", "goto", "setjmp", "longjmp"):
            if re.search(rf"\b{word}\b\s*[(;]?", code) and re.search(rf"\b{word}\s*\(", code) or re.search(r"\bgoto\b", code):
                yield f"{name}: has {word}"
        run("gcc", "-std=c99", "-Wvla", "-Werror", "-fsyntax-only", made.source)
        told = run("clang-tidy", "--quiet", "--checks=-*,misc-no-recursion", made.source, "--", "-std=c99")
        if "misc-no-recursion" in told:
            yield f"{name}: calls itself: {told[:300]}"
        made_object = M4F.compile(made.source, "-Os")
        _, data, bss, *_ = run("arm-none-eabi-size", made_object).splitlines()[1].split()
        if (data, bss) != ("0", "0"):
            yield f"{name}: {data} bytes of data and {bss} of bss"


def frames(folders: Mapping[str, Generated]) -> Iterator[str]:
    """5: nothing casts const away; aliasing is stated; frames stay below 1 KB, what is larger is the caller's."""
    for name, made in folders.items():
        run("gcc", "-std=c99", "-Wcast-qual", "-Wwrite-strings", "-Werror", "-fsyntax-only", made.source)
        if "Outputs must not overlap inputs" not in made.header.read_text():
            yield f"{name}: the header says nothing of aliasing"
        for function, size in stack_usage(made).items():
            if size > _STATED.get(function, _FRAME):
                yield f"{name}: {function} takes {size} bytes of stack"


def stack_usage(made: Generated, level: str = "-Os") -> dict[str, int]:
    """Bytes of each function's frame on the M4F."""
    compiled = M4F.compile(made.source, level, "-fstack-usage")
    rows = (line.split("\t") for line in compiled.with_suffix(".su").read_text().splitlines())
    return {place.rsplit(":", 1)[-1].split(".")[0]: int(size) for place, size, _ in rows}


def one_image(folders: Mapping[str, Generated]) -> Iterator[str]:
    """6: modules of both precisions in one image, each under its own prefix."""
    single, double = folders["fw_planar4"], folders["fw_planar4_double"]
    main = single.folder / "both.c"
    main.write_text(
        f'#include "{single.header}"\n#include "{double.header}"\n#include "board.h"\n'
        "int fw_planar4_selftest(void);\nint fw_planar4_double_selftest(void);\n"
        "int checked(void)\n{\n    return fw_planar4_selftest() + 16 * fw_planar4_double_selftest();\n}\n"
    )
    second = double.folder / "selftest_double.c"
    second.write_text(double.selftest.read_text())
    sources = [main, single.source, single.selftest, double.source, second]
    M4F.run(M4F.build(sources, single.folder / "both.elf", "-O2", single.without_main, double.without_main, f"-I{BOARD}"))
    for made in (single, double):
        told = run("arm-none-eabi-nm", "-g", "--defined-only", M4F.compile(made.source, "-Os"))
        for line in told.splitlines():
            if not line.split()[-1].startswith(f"{made.scene.name}_"):
                yield f"{made.scene.name}: exports {line.split()[-1]}"


def source_of(path: Path) -> str:
    """The text of a C file without its comments."""
    return re.sub(r"/\*.*?\*/", "", path.read_text(), flags=re.DOTALL)
