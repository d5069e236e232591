"""What the code takes: the manifest's bounds against measurements, and ceilings that nobody may raise unnoticed (points 10, 15 to 19)."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from typing import Final

from benchmarks.firmware.accuracy import worst_error, worst_spatial_error
from benchmarks.firmware.points.objects import source_of, stack_usage
from benchmarks.firmware.points.runs import on
from benchmarks.firmware.scenes import Generated
from benchmarks.firmware.targets import M4F
from benchmarks.firmware.tools import run

#: Ceilings at -Os on the M4F: text with what it calls, stack and instructions, just above what was measured when they were set.
CEILINGS: Final = {
    ("fw_flows", "forward_dynamics"): (590, 56, 158),
    ("fw_planar4", "forward_dynamics"): (1010, 128, 365),
    ("fw_planar4", "dynamics_and_jacobian"): (3900, 290, 1090),
    ("fw_planar4_libm", "forward_dynamics"): (680, 160, None),
    ("fw_planar4_loops", "dynamics_and_jacobian"): (1326, 600, 2830),
    ("fw_planar10", "forward_dynamics"): (870, 380, 1450),
    ("fw_planar10", "dynamics_and_jacobian"): (2430, 1190, 6650),
    ("fw_spatial2", "forward_dynamics"): (400, 40, 130),
    ("fw_spatial5", "state_jacobian"): (4300, 1120, 4300),
}
#: Errors of the forward dynamics, max norm over max norm.
WORST: Final = {"fw_planar4": 6e-7, "fw_planar10": 6e-7, "fw_spatial5": 1e-6}
#: What sines and cosines are called where a compiler leaves them functions of their own.
_KERNELS: Final = {"sincos", "sincos_pairs", "far"}
#: -O0 over -Os, in instructions.
UNOPTIMISED: Final = 2.5


def text_of(made: Generated, level: str = "-Os") -> dict[str, int]:
    """Bytes of each function of an object for the M4F."""
    told = run("arm-none-eabi-nm", "-S", M4F.compile(made.source, level, "-fno-math-errno"))
    rows = [line.split() for line in told.splitlines()]
    return {words[3].split(".")[0].removeprefix(f"{made.scene.name}_"): int(words[1], 16) for words in rows if len(words) == 4}


def bounds(folders: Mapping[str, Generated]) -> Iterator[str]:
    """10: what manifest and header say is at most, and not more than needed by a factor of three."""
    for name, made in folders.items():
        known = json.loads((made.folder / "manifest.json").read_text())["functions"]
        small, fast, frames = text_of(made), text_of(made, "-O2"), stack_usage(made)
        seen = on(made, M4F, "-Os")[1]
        record = json.loads((made.folder / "manifest.json").read_text())
        for function, row in known.items():
            # What a compiler puts in place, it counts with the function.
            inlined = 0 if _KERNELS & set(small) else record["sincos_flash_at_most"]
            most = {what: value + (inlined if what.startswith("flash") and value else 0) if value is not None else None for what, value in row["cortex_m4f_at_most"].items()}
            found = {
                "flash_Os": small[function], "flash_O2": fast[function], "stack": frames[f"{name}_{function}"],
                "instructions_Os": 0 if made.scene.trig in ("libm", "hook") or function.startswith("phi") else seen[function].most,
            }  # fmt: skip
            for what, value in found.items():
                if most[what] is not None and value > most[what]:
                    yield f"{name}: {function} takes {value}, {what} says at most {most[what]}"
            if most["flash_Os"] > 3 * small[function] + 200:
                yield f"{name}: {function} takes {small[function]} bytes and is said to take {most['flash_Os']}"


def flow_bounds(folders: Mapping[str, Generated]) -> Iterator[str]:
    """10: what header and manifest say of flows is at most, and not more than needed by a factor of three."""
    for name, made in folders.items():
        record = json.loads((made.folder / "manifest.json").read_text())
        alone = len(record["flows"]) == 1
        for flow, row in record["flows"].items():
            most, seen = row["cortex_m4f_at_most"], on(made, M4F, "-Os")[1][flow]
            if not 0 < seen.stack <= most["stack"]:
                yield f"{name}: {flow} takes {seen.stack} bytes of stack and is said to take {most['stack']}"
            for level, what in (("-Os", "flash_Os"), ("-O2", "flash_O2")):
                parts = text_of(made, level)
                functions = [*record["functions"], *(_KERNELS if _KERNELS & set(parts) else [])]
                found = sum(size for part, size in parts.items() if part not in functions)
                room = most[what] + (0 if _KERNELS & set(parts) else record["sincos_flash_at_most"])
                if alone and found > room:
                    yield f"{name}: {flow} takes {found} bytes at {level} and is said to take {room}"
                if alone and level == "-Os" and most[what] > 3 * found + 200:
                    yield f"{name}: {flow} takes {found} bytes and is said to take {most[what]}"


def shape(folders: Mapping[str, Generated]) -> Iterator[str]:
    """15: powers are products, one division a pivot; what -O0 costs."""
    for name, made in folders.items():
        if re.search(r"\bpow[fl]?\s*\(", source_of(made.source)):
            yield f"{name}: calls pow"
    made = folders["fw_planar4"]
    divisions = json.loads((made.folder / "manifest.json").read_text())["functions"]["forward_dynamics"]["operations"].get("div", 0)
    if divisions > made.scene.links:
        yield f"{divisions} divisions for {made.scene.links} links"
    for name, function in CEILINGS:
        plain, small = (on(folders[name], M4F, level)[1][function].most for level in ("-O0", "-Os"))
        if plain > UNOPTIMISED * small:
            yield f"{name}: {function} takes {plain} instructions at -O0, {small} at -Os"


def errors(folders: Mapping[str, Generated]) -> Iterator[str]:
    """19: the worst single-precision error over the states stays below what the best peer leaves by a factor of ten."""
    for name, most in WORST.items():
        made = folders[name]
        found = (worst_error if made.scene.is_planar else worst_spatial_error)(made.folder, made.scene.links)
        if found > most:
            yield f"{name}: the forward dynamics is {found:.1e} off, the ceiling is {most:.0e}"


def ceilings(folders: Mapping[str, Generated]) -> Iterator[str]:
    """16 to 18: text, stack and instructions of the kinds of code stay below what they were."""
    for (name, function), (text, stack, instructions) in CEILINGS.items():
        made = folders[name]
        parts, seen = text_of(made), on(made, M4F, "-Os")[1][function]
        total = parts[function] + sum(parts.get(kernel, 0) for kernel in _KERNELS)
        for what, value, most in (("text", total, text), ("stack", seen.stack, stack), ("instructions", seen.most, instructions)):
            if most is not None and value > most:
                yield f"{name}: {function} takes {value} of {what}, the ceiling is {most}"
