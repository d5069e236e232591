"""What the commands print: aligned columns of plain text that read the same on a terminal and in a pipe."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from phichain.system import System


def columns(rows: Sequence[Sequence[str]]) -> str:
    """Rows of text with every column but the last as wide as its widest entry."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = ("  ".join(f"{cell:<{width}}" for cell, width in zip(row, widths, strict=True)) for row in rows)
    return "\n".join(line.rstrip() for line in lines)


def functions(system: System) -> str:
    """The callables of a System, each with its arguments and what it was made from."""
    rows = []
    for name, call in system.functions.items():
        first = (call.__doc__ or "").strip().partition("\n")[0]
        # A compiled callable's first line reads "f(q, v) -> a, compiled from NAME_f."; others say what they like.
        head, found, source = first.partition(", compiled from ")
        if first:
            rows.append((head, source.rstrip(".")) if found else (name, first))
    return columns(rows)


def versions(names: Iterable[str]) -> Mapping[str, str]:
    """Versions of installed packages by name; "not installed" for the others."""
    from importlib.metadata import PackageNotFoundError, version

    found: dict[str, str] = {}
    for name in names:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "not installed"
    return found
