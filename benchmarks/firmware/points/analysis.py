"""What other compilers and analysers say (point 20)."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Final

from benchmarks.firmware.scenes import Generated
from benchmarks.firmware.targets import BOARD
from benchmarks.firmware.tools import run

STRICT: Final = (
    "-std=c99", "-pedantic-errors", "-Wall", "-Wextra", "-Wconversion", "-Wsign-conversion", "-Wdouble-promotion", "-Wshadow",
    "-Wstrict-prototypes", "-Wmissing-prototypes", "-Wcast-qual", "-Wcast-align", "-Wundef", "-Wvla", "-Wfloat-equal", "-Wswitch-default",
    "-Wunused-macros", "-Wredundant-decls", "-Werror",
)  # fmt: skip
#: clang's own words that contradict C99 or say how padding falls.
_CLANG: Final = ("-Weverything", "-Wno-declaration-after-statement", "-Wno-padded", "-Wno-unknown-warning-option", "-Wno-unsafe-buffer-usage")
_TIDY: Final = "-*,cert-*,bugprone-*,-bugprone-easily-swappable-parameters,-bugprone-implicit-widening-of-multiplication-result"
#: Scenes whose code is of a kind that another one has.
_ALIKE: Final = ("fw_flow6", "fw_planar4_libm", "fw_hook")
#: What cppcheck says of a loop over one lane, of a workspace that needs no initial values, and of dialects left to others.
_NOT_FAULTS: Final = ("objectIndex", "ctuuninitvar", "toomanyconfigs")
_DEVIATIONS: Final = Path(__file__).parents[1] / "misra.txt"
_MSVC: Final = Path(__file__).parents[1] / "msvc"


def deviations() -> dict[str, str]:
    """The rules of MISRA C:2012 that generated code deviates from, and why, as committed."""
    rows = (line.split(maxsplit=1) for line in _DEVIATIONS.read_text().splitlines() if line and not line.startswith("#"))
    return {rule: reason for rule, reason in rows}


def compilers(folders: Mapping[str, Generated]) -> Iterator[str]:
    """20: no word from gcc and clang at their strictest, nor from clang's front end for MSVC."""
    for name, made in folders.items():
        for words in (
            ("gcc", *STRICT, "-O2", "-c", "-o", "/dev/null"), ("clang", "-std=c99", *_CLANG, "-Werror", "-fsyntax-only"),
            ("clang", "--target=x86_64-pc-windows-msvc", "-fms-compatibility", f"-I{_MSVC}", "-Werror", "-fsyntax-only"),
            ("clang", "--target=x86_64-pc-windows-msvc", "-fms-compatibility", f"-I{_MSVC}", "-x", "c++", "-std=c++17", "-fsyntax-only"),
        ):  # fmt: skip
            done = subprocess.run([*words, made.source.name], cwd=made.folder, capture_output=True, text=True, check=False)
            if done.returncode or done.stderr:
                yield f"{name}: {' '.join(words[:3])}: {done.stderr[:600]}"


def analysers(folders: Mapping[str, Generated]) -> Iterator[str]:
    """20: clang-tidy's cert and bugprone checks find nothing, cppcheck's MISRA rules nothing but the committed deviations."""
    known = deviations()
    for name, made in folders.items():
        if name in _ALIKE:
            continue
        told = run("clang-tidy", "--quiet", f"--checks={_TIDY}", made.source.name, "--", "-std=c99", cwd=made.folder, expected=(0, 1))
        found = sorted(set(re.findall(r"\[((?:cert|bugprone)-[\w.-]+)", told)))
        if found:
            yield f"{name}: clang-tidy: {found}: {told[:400]}"
        told = run(
            "cppcheck", "--addon=misra", "--std=c99", "--quiet", "--template={id} {file}:{line}", "--suppress=missingIncludeSystem", "--max-configs=2",
            made.source.name, cwd=made.folder,
        )  # fmt: skip
        for rule in sorted(set(re.findall(r"misra-c2012-([\d.]+)", told)) - set(known)):
            where = next(line for line in told.splitlines() if f"c2012-{rule} " in line)
            yield f"{name}: MISRA rule {rule}, which no deviation covers: {where}"
        for line in told.splitlines():
            if line and "misra" not in line and not line.startswith("Checking") and line.split()[0] not in _NOT_FAULTS:
                yield f"{name}: cppcheck: {line}"


def sanitizers(folders: Mapping[str, Generated]) -> Iterator[str]:
    """20: address and undefined-behaviour sanitizers say nothing, in 64 and 32 bits."""
    for name, made in folders.items():
        for bits in ("-m64", "-m32"):
            program = made.folder / f"sanitized{bits}"
            run(
                "gcc", "-std=c99", bits, "-msse2", "-mfpmath=sse", "-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all",
                f"-I{BOARD}", made.source, made.selftest, *made.hook, "-o", program, "-lm", cwd=made.folder,
            )  # fmt: skip
            done = subprocess.run([program], capture_output=True, text=True, check=False)
            if done.returncode:
                yield f"{name} {bits}: {(done.stdout + done.stderr)[-400:]}"
