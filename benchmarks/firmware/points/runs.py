"""What targets compute: instructions, the self-test, and the same bits everywhere (points 4, 12, 13)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from threading import Lock
from typing import Final

from benchmarks.firmware.probe import Seen, failing_case, read
from benchmarks.firmware.scenes import HOOK, Generated
from benchmarks.firmware.targets import HOST, M4F, TARGETS, Target

#: The clock of the emulated boards ticks 1.6 times an instruction.
_QUANTUM: Final = 1
_LEVELS: Final = {"m4f": ("-Os", "-O2")}


@cache
def _lock(folder: Path, target: Target, level: str) -> Lock:
    return Lock()


@cache
def _seen(name: str, folder: Path, target: Target, level: str, flag: str) -> tuple[int, dict[str, Seen]]:
    """The failing case of the self-test, and what the probe told of each function."""
    program = folder / f"probe_{target.name}{level}.elf"
    hook = [path for path in (folder / HOOK,) if path.exists()]
    target.build([folder / f"{name}.c", folder / "selftest.c", folder / "probe.c", *hook], program, level, flag)
    told = target.run(program)
    return failing_case(told), read(told, target.ticks)


def on(made: Generated, target: Target, level: str = "-O2") -> tuple[int, dict[str, Seen]]:
    """The same of a generated folder."""
    with _lock(made.folder, target, level):  # checks run side by side, and want the same runs
        return _seen(made.scene.name, made.folder, target, level, made.without_main)


def instructions(folders: Mapping[str, Generated]) -> Iterator[str]:
    """4: every state takes the same instructions with bundled trigonometry."""
    for name, made in folders.items():
        if made.scene.trig != "bundled" or made.scene.real == "double":
            continue
        for function, row in on(made, M4F, "-Os")[1].items():
            if function not in made.scene.want or function.startswith("propagate"):
                continue
            if row.most - row.least > _QUANTUM and not function.startswith("phi"):
                yield f"{name}: {function} takes {row.least} to {row.most} instructions"


def motions(folders: Mapping[str, Generated]) -> Iterator[str]:
    """Flows on the targets: ordinary motions in single precision, at 1e-3 and 1e-6, none refused."""
    for name, made in folders.items():
        for flow in ("propagate", "propagate_stiff"):
            if flow not in made.scene.want:
                continue
            for target in TARGETS:
                row = on(made, target)[1][flow]
                if row.ending:
                    yield f"{name}: {flow} ends with {row.ending} on {target.name}"


def selftests(folders: Mapping[str, Generated]) -> Iterator[str]:
    """12: the self-test passes on the host, the M4F and RV32, and names the case where one digit of the code is wrong."""
    for name, made in folders.items():
        for target in TARGETS:
            if target.name in ("x86_64", "m4f", "rv32"):
                case, _ = on(made, target)
                if case:
                    yield f"{name}: case {case} fails on {target.name}"
    made = folders["fw_planar4"]
    wrong = made.folder / "wrong.c"
    wrong.write_text(made.source.read_text().replace("1.0F / (", "1.0001F / (", 1))
    main = made.folder / "told.c"
    main.write_text(
        '#include "board.h"\nint fw_planar4_selftest(void);\nint checked(void)\n{\n    return fw_planar4_selftest() == 1 ? 0 : 1;\n}\n'
    )
    try:
        M4F.run(M4F.build([wrong, made.selftest, main], made.folder / "wrong.elf", "-O2", made.without_main))
    except RuntimeError:
        yield "a wrong digit is not found, or not in the first case"


def bits(folders: Mapping[str, Generated]) -> Iterator[str]:
    """13: the same bits in single precision on x86-64, M0, M3, M4F, M7 and RV32."""
    for name, made in folders.items():
        if made.scene.trig != "bundled" or made.scene.real == "double":
            continue
        expected = {function: row.bits for function, row in on(made, HOST)[1].items()}
        for target in TARGETS:
            for level in _LEVELS.get(target.name, ("-O2",)):
                found = {function: row.bits for function, row in on(made, target, level)[1].items()}
                apart = sorted(function for function in expected if found.get(function) != expected[function])
                if apart:
                    yield f"{name}: {', '.join(apart)} differ on {target.name} {level}"
