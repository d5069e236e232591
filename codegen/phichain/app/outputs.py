"""Files that the command's results go to: named by what they hold, and refused before any work when the name does not say."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final

import typer

from phichain.errors import OutputError, UnsupportedError, printable

_DRAWN: Final = (".png", ".svg", ".pdf", ".gif", ".mp4", ".html")


MOVING: Final = (".gif", ".html", ".mp4")
"""Kinds of files that show a motion."""


def out_option(what: str) -> Any:
    """The option --out of a command whose result goes to files named by what they hold: `what` says which."""
    return typer.Option("--out", "-o", metavar="FILE", help=f"{what}; repeatable.")


def figures() -> Any:
    """The module that draws, imported when something is drawn."""
    from phichain.report import figures as drawing

    return drawing


def named(files: list[Path] | None, kinds: tuple[str, ...] = (".csv", ".npz", ".json", ".png", ".svg", ".pdf")) -> list[Path]:
    """The files to write, each named by one of the kinds that there are, and each such as can be written.

    Raises:
        OutputError: A name does not say what to write, or its folder is not ours to write to.
        UnsupportedError: A picture is asked for, and nothing here draws.
    """
    for path in files or []:
        if path.suffix not in kinds:
            remedy = f"name it {' or '.join(filter(None, (', '.join(kinds[:-1]), kinds[-1])))}"
            raise OutputError("out", str(path), "has no suffix that says what to write", remedy)
        if path.suffix in _DRAWN and find_spec("matplotlib") is None:
            raise UnsupportedError("out", str(path), "needs matplotlib, which is not installed", "pip install 'phichain[plot]', or name it .csv")
        folder = path.absolute().parent
        while not folder.exists():
            folder = folder.parent
        if not os.access(folder, os.W_OK) or path.is_dir():
            raise OutputError("out", str(path), "cannot be written there", "name a file in a folder of your own")
    return files or []


def write(
    record: Any, files: list[Path], draw: Callable[[], Any], others: Mapping[str, Callable[[Path], Any]] | None = None,
    quiet: bool = False,
) -> None:
    """Write a record to each of the files: as a table, whole, drawn, or as `others` do it for suffixes of theirs."""
    for path in files:
        if others and path.suffix in others:
            others[path.suffix](path)
        elif path.suffix == ".csv":
            record.to_csv(path)
        elif path.suffix == ".npz":
            record.to_npz(path)
        elif path.suffix == ".json":
            record.to_json(path)
        elif path.suffix in MOVING:
            record.animate(path)
        else:
            from phichain.report.style import save

            save(draw(), path, of=record)
        if not quiet:
            typer.echo(printable(f"wrote {path}"))
