"""The programs that the firmware checks run, and the packages of Debian and Ubuntu that have them."""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Final

#: Package of each command.
PACKAGES: Final = {
    "gcc": "gcc", "g++": "g++", "cmake": "cmake", "clang": "clang", "clang-tidy": "clang-tidy", "cppcheck": "cppcheck",
    "arm-none-eabi-gcc": "gcc-arm-none-eabi libnewlib-arm-none-eabi", "qemu-system-arm": "qemu-system-arm",
    "riscv64-unknown-elf-gcc": "gcc-riscv64-unknown-elf picolibc-riscv64-unknown-elf", "qemu-system-riscv32": "qemu-system-misc",
}  # fmt: skip
#: Packages that bring no command of their own, by a file that only they have.
LIBRARIES: Final = {
    "libnewlib-arm-none-eabi": "arm-none-eabi-gcc -print-file-name=libc.a",
    "picolibc-riscv64-unknown-elf": "riscv64-unknown-elf-gcc -print-file-name=picolibc.specs",
    "gcc-multilib": "gcc -m32 -print-file-name=libgcc.a",
}


#: Packages of PyPI that judge the packages, by the modules they bring: extra `firmware`.
MODULES: Final = {"platformio": "platformio", "kconfiglib": "kconfiglib", "cyclonedx": "cyclonedx-python-lib[json-validation]"}


class Missing(Exception):
    """Programs that are not installed."""


def missing(packages: dict[str, str] = PACKAGES, libraries: dict[str, str] = LIBRARIES) -> list[str]:
    """The packages to install, each once; empty where everything is there."""
    wanted = [word for command, words in packages.items() if shutil.which(command) is None for word in words.split()]
    wanted += [package for package, question in libraries.items() if not _is_there(question)]
    return list(dict.fromkeys(wanted))


def missing_modules(modules: dict[str, str] = MODULES) -> list[str]:
    """What pip installs, by the modules that are not there."""
    return [f"'{package}'" for module, package in modules.items() if find_spec(module) is None]


def demand() -> None:
    """Go on only where every tool is installed.

    Raises:
        Missing: some are not; the message is the command that installs them.
    """
    wanted = missing()
    if wanted:
        raise Missing(f"the firmware checks need packages that are not installed: apt-get install {' '.join(wanted)}")
    modules = missing_modules()
    if modules:
        raise Missing(f"the firmware checks need packages in .venv: {sys.executable} -m pip install {' '.join(modules)}")


def _is_there(question: str) -> bool:
    """Whether a compiler knows where a file is, which it then says in full."""
    words = question.split()
    if shutil.which(words[0]) is None:
        return False
    told = subprocess.run(words, capture_output=True, text=True, check=False).stdout.strip()
    return Path(told).is_absolute() and Path(told).exists()


def run(*words: str | Path, cwd: Path | None = None, expected: Sequence[int] = (0,), timeout: float = 300.0) -> str:
    """What a command prints, on both streams.

    Raises:
        RuntimeError: its exit code is another than those expected, or it hangs.
    """
    try:
        done = subprocess.run(
            [str(word) for word in words], cwd=cwd, capture_output=True, text=True, check=False, timeout=timeout
        )
    except subprocess.TimeoutExpired as error:
        raise RuntimeError(f"{' '.join(map(str, words))}: not done after {timeout:g} s") from error
    told = done.stdout + done.stderr
    if done.returncode not in expected:
        raise RuntimeError(f"{' '.join(map(str, words))}: exit code {done.returncode}\n{told[-3000:]}")
    return told


if __name__ == "__main__":
    print(" ".join(missing()))
