"""What a compiler makes of one C file: bytes of code, external symbols."""

from __future__ import annotations

import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

from benchmarks.harness import C_FLAGS, run_compiler


@dataclass(frozen=True)
class Object:
    """A compiled C file.

    Attributes:
        text: bytes of machine code (all sections named .text*), tables of constants not counted.
        symbols: names it exports, sorted.
    """

    text: int
    symbols: tuple[str, ...]


def inspect(source: Path, flags: tuple[str, ...] = C_FLAGS) -> Object:
    """Compiles a C file by itself and reads the object."""
    with tempfile.TemporaryDirectory(prefix="phichain-bench-") as scratch:
        path = Path(scratch) / "object.o"
        run_compiler(["cc", "-std=c99", *flags, "-c", str(source), "-o", str(path)])
        sections = [line.split() for line in _output("size", "-A", str(path))]
        text = sum(int(words[1]) for words in sections if words and words[0].startswith(".text"))
        names = [
            line.split()[-1] for line in _output("nm", "--extern-only", "--defined-only", str(path)) if line
        ]
        return Object(text, tuple(sorted(names)))


def _output(*command: str) -> list[str]:
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()
