"""Files that the command's results go to: named by what they hold, and refused before any work when the name does not say."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import typer

from phichain.errors import OutputError, printable


def figures() -> Any:
    """The module that draws, imported when something is drawn."""
    from phichain.report import figures as drawing

    return drawing


def named(files: list[Path] | None, kinds: tuple[str, ...] = (".csv", ".npz", ".png")) -> list[Path]:
    """The files to write, each named by one of the kinds that there are.

    Raises:
        OutputError: A name does not say what to write.
    """
    for path in files or []:
        if path.suffix not in kinds:
            remedy = f"name it {' or '.join(filter(None, (', '.join(kinds[:-1]), kinds[-1])))}"
            raise OutputError("out", str(path), "has no suffix that says what to write", remedy)
    return files or []


def write(
    record: Any, files: list[Path], draw: Callable[[], Any], others: Mapping[str, Callable[[Path], Any]] | None = None
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
        else:
            from phichain.report.style import save

            save(draw(), path)
        typer.echo(printable(f"wrote {path}"))
