"""How results leave memory: CSV for people and spreadsheets, NPZ for exact round trips.

A result record is a frozen dataclass of arrays, numbers and strings. CSV takes its table with 17 significant
digits, so every double survives; comments before it, in the form of ECSV 1.0, give the unit of every column and where the table comes
from. NPZ takes all of a record, the small fields as one JSON text, and needs no pickle; `phichain.archive` reads it back.
Files appear whole or not at all (`phichain.files`).
"""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from phichain._version import __version__
from phichain.archive import LARGEST, META
from phichain.errors import OutputError
from phichain.files import write_file
from phichain.held import Held, Later, Rest, Valued, frozen, held, thawed
from phichain.origin import WROTE, origin, plain
from phichain.units import unit_of

__all__ = ["Held", "Later", "Rest", "Shown", "Valued", "columns_of", "frozen", "held", "thawed", "write_csv", "write_json", "write_npz"]


def write_csv(path: Path | str, columns: Mapping[str, ArrayLike], record: object) -> Path:
    """Write equally long columns under one header row, and above it, as comments, their units and where they come from.

    The comments are those of ECSV 1.0 (Enhanced Character Separated Values), so that `astropy.table.Table.read` returns a table with units;
    `pandas.read_csv(path, comment="#")` and spreadsheets read what follows them.

    Args:
        path: The file to write.
        columns: Column name -> values; numbers are written so that they read back exactly.
        record: The record that the table is of; its fields that are texts and numbers tell where the table comes from.

    Returns:
        The path written.

    Raises:
        OutputError: The file cannot be written.
    """
    text = io.StringIO()
    table = {name: np.asarray(column) for name, column in columns.items()}
    text.writelines(f"# {line}\n" for line in _above(table, record))
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(table)
    writer.writerows(zip(*([_cell(value) for value in column] for column in table.values()), strict=True))
    return write_file(path, text.getvalue())


def _above(table: Mapping[str, np.ndarray], record: object) -> Iterator[str]:
    """The lines of ECSV before a table: YAML, written as JSON, which is YAML."""
    yield from ("%ECSV 1.0", "---", 'delimiter: ","', "datatype:")
    for name, column in table.items():
        known = {"unit": unit_of(name)} if unit_of(name) else {}
        kind = "string" if column.dtype.kind in "UO" else column.dtype.name
        yield f"- {json.dumps({'name': name, **known, 'datatype': kind}, ensure_ascii=False)}"
    yield from (f"meta: {json.dumps(origin(record), ensure_ascii=False)}", "schema: astropy-2.0")


def _cell(value: Any) -> str:
    return repr(float(value)) if isinstance(value, np.floating) else str(value)


def write_npz(path: Path | str, arrays: Mapping[str, ArrayLike], meta: Mapping[str, Any]) -> Path:
    """Write arrays and, as one JSON text beside them, the small fields of a record and the version that wrote it.

    Raises:
        OutputError: The file cannot be written, or would be too large to be read back.
    """
    buffer = io.BytesIO()
    payload = {name: np.asarray(value) for name, value in arrays.items()}
    size = sum(array.nbytes for array in payload.values())
    if size > LARGEST // 2:
        raise OutputError(
            "path", str(path), f"would hold {size} bytes, more than the {LARGEST // 2} of a record", "write fewer points"
        )
    payload[META] = np.asarray(json.dumps({**meta, WROTE: __version__}, sort_keys=True, default=thawed))
    np.savez_compressed(buffer, allow_pickle=False, **payload)
    return write_file(path, buffer.getvalue())


def write_json(path: Path | str, kind: str, document: Mapping[str, Any]) -> Path:
    """Write {"phichain": the version, "kind": KIND, ...}, 17 digits.

    Raises:
        OutputError: The file cannot be written.
    """
    text = json.dumps({WROTE: __version__, "kind": kind, **document}, indent=1, allow_nan=False, default=thawed)
    return write_file(path, f"{text}\n")


class Shown(Valued):
    """Base of results that show themselves: in one line, as a picture, in motion, in a notebook, as named arrays.

    Numerics draw nothing. How a record is shown is looked up by name in `phichain.report.shown`, the first time that it is, so that nothing below the
    report imports it.
    """

    def __repr__(self) -> str:
        """The first line of what it prints."""
        return f"<{type(self).__name__} {str(self).partition(chr(10))[0]}>"

    def plot(self, ax: Any = None, **words: Any) -> Any:
        """Draw it.

        Args:
            ax: Matplotlib axes to draw one panel on; a whole figure of its own unless given.
            **words: As `phichain.report.shown` says for this kind of record.

        Returns:
            The axes, or the figure.

        Raises:
            UnsupportedError: matplotlib is not installed, or nothing draws such a record.
        """
        return _shown().plot(self, ax, **words)

    def animate(self, path: Path | str, **words: Any) -> Path:
        """Write it in motion: .gif, .html that plays by itself, or .mp4 where ffmpeg is installed.

        Args:
            path: The file.
            **words: `seconds`, how long it plays (as long as it lasted unless given), and `fps`, frames a second.

        Returns:
            The file.

        Raises:
            OutputError: Its name does not say which, or it cannot be written.
            UnsupportedError: matplotlib or ffmpeg is not installed, or nothing of such a record moves.
        """
        found: Path = _shown().animate(self, path, **words)
        return found

    def to_json(self, path: Path | str) -> Path:
        """Write where it comes from and all of its numbers for programs of other kinds, 17 digits; `to_npz` writes what is read back.

        Complex numbers are pairs, and what is no number is null.

        Raises:
            OutputError: The file cannot be written.
        """
        tables = {item.name: plain(value) for item in fields(self) if isinstance(value := getattr(self, item.name), np.ndarray | tuple)}
        return write_json(path, type(self).__name__.lower(), {**origin(self), **tables})

    def to_xarray(self) -> Any:
        """An xarray Dataset: named axes, units, where it comes from.

        Raises:
            UnsupportedError: xarray is not installed, or there is none of such a record.
        """
        return _shown().to_xarray(self)

    def _repr_html_(self) -> str:
        found: str = _shown().html(self)
        return found


def _shown() -> Any:
    """The one place that draws."""
    return import_module("phichain.report.shown")


def columns_of(names: Sequence[str], values: np.ndarray | None) -> dict[str, np.ndarray]:
    """The columns of a two-dimensional array under their names; nothing for None."""
    if values is None:
        return {}
    return {name: values[:, k] for k, name in enumerate(names)}
