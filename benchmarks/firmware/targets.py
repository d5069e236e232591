"""The targets: a compiler, its flags, and the machine that runs what it makes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from threading import Lock
from typing import Final

from benchmarks.firmware.tools import run

BOARD: Final = Path(__file__).parent / "board"
#: What every target compiles with: one rounding an operation, so that all agree to the last bit.
COMMON: Final = ("-std=c99", "-ffp-contract=off", "-ffunction-sections", "-fdata-sections")


_LOCK: Final = Lock()
_LOCKS: Final[dict[tuple[str, Path, tuple[str, ...]], Lock]] = {}


@dataclass(frozen=True)
class Target:
    """One kind of processor.

    Attributes:
        name: what reports call it.
        prefix: before gcc, size and nm.
        flags: what selects the processor.
        link: what links a program of it.
        board: the file that starts it.
        machine: the command that runs a program, to which its path is added; empty for the host.
        ticks: ticks of its clock an instruction; 0 where it has none.
    """

    name: str
    prefix: str
    flags: tuple[str, ...]
    link: tuple[str, ...]
    board: str
    machine: tuple[str, ...]
    ticks: float = 0.0

    def compile(self, source: Path, *flags: str) -> Path:
        """An object beside its source, its flags in its name; made once."""
        with _LOCK:
            lock = _LOCKS.setdefault((self.name, source, flags), Lock())
        with lock:  # checks run side by side, and want the same objects
            made = source.with_suffix(f".{self.name}{''.join(flags).replace('/', '')}.o")
            if not made.exists():
                run(f"{self.prefix}gcc", *self.flags, *COMMON, *flags, "-c", source, "-o", made, cwd=source.parent)
            return made

    def build(self, sources: Sequence[Path], program: Path, *flags: str) -> Path:
        """A program of these sources and the board."""
        files = [*sources, BOARD / self.board, BOARD / "common.c"]
        run(f"{self.prefix}gcc", *self.flags, *COMMON, *flags, f"-I{BOARD}", *files, "-o", program, *self.link, cwd=program.parent)
        return program

    def run(self, program: Path) -> str:
        """What a program says; it must end with the exit code 0."""
        return run(*self.machine, program, cwd=program.parent)

    def text(self, made: Path) -> int:
        """Bytes of code and constants of an object."""
        return int(run(f"{self.prefix}size", made).splitlines()[1].split()[0])


def _cortex(name: str, machine: str, flags: Sequence[str], ram: str = "64K", ticks: float = 1.6) -> Target:
    has_fpu = any(flag.startswith("-mfpu") for flag in flags)
    return Target(
        name, "arm-none-eabi-", ("-mthumb", *flags, *(("-DBOARD_FPU",) if has_fpu else ())),
        ("-nostartfiles", "--specs=nosys.specs", f"-Wl,--defsym=RAM_SIZE={ram}", "-T", str(BOARD / "cortex_m.ld"), "-Wl,--gc-sections", "-lm"),
        "cortex_m.c",
        (
            "qemu-system-arm", "-M", machine, "-nographic", "-monitor", "none", "-serial", "null", "-semihosting-config",
            "enable=on,target=native", "-icount", "shift=6", "-kernel",
        ), ticks,
    )  # fmt: skip


M4F: Final = _cortex("m4f", "mps2-an386", ("-mcpu=cortex-m4", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"))
HOST: Final = Target("x86_64", "", (), ("-lm",), "host.c", ())
TARGETS: Final = (
    HOST,
    _cortex("m0", "microbit", ("-mcpu=cortex-m0",), ram="16K", ticks=0.0),
    _cortex("m3", "mps2-an385", ("-mcpu=cortex-m3",)),
    M4F,
    _cortex("m7", "mps2-an500", ("-mcpu=cortex-m7", "-mfloat-abi=hard", "-mfpu=fpv5-sp-d16")),
    Target(
        "rv32", "riscv64-unknown-elf-", ("-march=rv32imafc", "-mabi=ilp32f", "--specs=picolibc.specs"),
        ("-nostartfiles", "-T", str(BOARD / "rv32.ld"), "-Wl,--gc-sections", "-lm"), "rv32.c",
        ("qemu-system-riscv32", "-M", "virt", "-bios", "none", "-nographic", "-monitor", "none", "-icount", "shift=0", "-kernel"),
        1.0,
    ),
)  # fmt: skip
