"""Commands as a user gives them: how long they take by the clock and by the processor, and what they say."""

from __future__ import annotations

import os
import subprocess
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median

from benchmarks.harness import BenchmarkError


@dataclass(frozen=True)
class Done:
    """A command that has ended well.

    Attributes:
        wall: s by the clock.
        user: s of user time, with what it started.
        said: What it printed, errors too.
    """

    wall: float
    user: float
    said: str


def clean(**more: str) -> dict[str, str]:
    """This environment without what would lead a command back to the checkout."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "PHICHAIN", "VIRTUAL_ENV", "MAKE", "MFLAGS"))}
    return kept | more


def run(words: Sequence[str | Path], cwd: Path, environment: Mapping[str, str]) -> Done:
    """Run a command to its end.

    Raises:
        BenchmarkError: It failed; with its last line.
    """
    begin = time.perf_counter()
    with tempfile.TemporaryFile("w+") as said:
        process = subprocess.Popen([str(word) for word in words], cwd=cwd, env=dict(environment), stdout=said, stderr=said, stdin=subprocess.DEVNULL)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        said.seek(0)
        text = said.read()
    if process.returncode:
        raise BenchmarkError(f"{' '.join(map(str, words))}: {(text.strip().splitlines() or ['said nothing'])[-1]}")
    return Done(time.perf_counter() - begin, usage.ru_utime, text)


def often(words: Sequence[str | Path], cwd: Path, environment: Mapping[str, str], count: int) -> float:
    """The median user time of a command, s; the first call is not counted."""
    return median([run(words, cwd, environment).user for _ in range(count + 1)][1:])


def megabytes(folder: Path) -> float:
    """What a folder takes, MB."""
    return sum(path.lstat().st_size for path in folder.rglob("*") if not path.is_dir()) / 1e6
