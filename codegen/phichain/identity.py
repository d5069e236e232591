"""Which generator this is: its version, and in a checkout the very state of its sources and templates."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from phichain._version import __version__

_PACKAGE = Path(__file__).resolve().parent


def beside(folder: str) -> Path:
    """`templates` or `stencils`: inside the package in a wheel, at the top of a checkout."""
    inside = _PACKAGE / folder
    return inside if inside.is_dir() else _PACKAGE.parents[1] / folder


@cache
def generator() -> str:
    """SHA-256 over the version and over name, size and time of every source, template and stencil, in hexadecimal.

    What one generator wrote another one need not write: a version says so between releases, and nothing but the files
    themselves while one is worked on. They are looked at once per process and not read: that costs 2 ms where reading costs 30.
    """
    lines = [__version__]
    for folder in (_PACKAGE, beside("templates"), beside("stencils")):
        lines += sorted(f"{name} {size} {time}" for name, size, time in _listed(folder, ""))
    return hashlib.sha256("\n".join(lines).encode()).hexdigest()


def _listed(folder: Path | str, within: str) -> Iterator[tuple[str, int, int]]:
    with os.scandir(folder) as entries:
        for entry in entries:
            name = f"{within}/{entry.name}"
            if entry.is_dir():
                if entry.name != "__pycache__":
                    yield from _listed(entry.path, name)
            elif entry.name.endswith((".py", ".j2", ".c", ".h")):
                found = entry.stat()
                yield name, found.st_size, found.st_mtime_ns
