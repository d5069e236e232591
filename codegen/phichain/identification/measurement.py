"""What was measured: states and inputs over time, from arrays or from a CSV file, checked once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from phichain.contract.words import nearest
from phichain.errors import ArrayError, OutputError
from phichain.motion.inputs.sheet import row_of_numbers
from phichain.reading import MEBIBYTE, read_rows
from phichain.records import Held
from phichain.system import System, Vector
from phichain.system.arrays import reals

LARGEST: Final = 256 * MEBIBYTE
FEWEST: Final = 8
"""Rows below which no velocity can be read off the first of them."""


@dataclass(frozen=True, eq=False)
class Measurement(Held):
    """Measured columns y(t_i) and inputs u(t_i).

    Attributes:
        t: Times (m,), s, strictly rising.
        columns: Names of the measured entries of x = (q, v), in the order of the state.
        values: y (m, c); m, rad, m/s, rad/s as the entries are.
        inputs: Names of the inputs that were recorded; the others are zero.
        u: Their values (m, k); N, N m, m/s^2 as the inputs are.

    Raises:
        ArrayError: Too few rows, a shape that does not fit, a value that is not finite, times that do not rise, nothing measured.
    """

    t: Vector
    columns: tuple[str, ...]
    values: Vector
    inputs: tuple[str, ...] = ()
    u: Vector | None = None

    def __post_init__(self) -> None:
        t = reals("data.t", self.t, "give times in s").copy()
        size = len(t) if t.ndim == 1 else -1
        if size < FEWEST:
            raise ArrayError("data.t", t.shape, f"holds fewer than {FEWEST} rows", "measure longer")
        _demand_finite("t", t)
        if (np.diff(t) <= 0).any():
            row = int(np.argmax(np.diff(t) <= 0)) + 1
            raise ArrayError(
                "data.t", (float(t[row - 1]), float(t[row])), f"does not rise from row {row} to row {row + 1}",
                "sort the rows and drop repeated times",
            )  # fmt: skip
        kept = {"values": _table("values", self.values, size, self.columns)}
        if not self.columns:
            raise ArrayError("data", self.columns, "holds no measured column", "give at least one angle or rate by its name")
        kept["u"] = _table("u", np.empty((size, 0)) if self.u is None else self.u, size, self.inputs)
        for name, value in {"t": t, **kept}.items():
            object.__setattr__(self, name, value)
        super().__post_init__()


def _table(field: str, values: object, rows: int, names: Sequence[str]) -> Vector:
    table = reals(f"data.{field}", values, "give one column for every name").copy()
    if table.shape != (rows, len(names)):
        raise ArrayError(f"data.{field}", table.shape, f"must have shape {(rows, len(names))}", "give one column for every name")
    for name, column in zip(names, table.T, strict=True):
        _demand_finite(name, column)
    return table


def _demand_finite(name: str, column: Vector) -> None:
    bad = ~np.isfinite(column)
    if bad.any():
        row = int(np.argmax(bad))
        raise ArrayError(f"data.{name}", float(column[row]), f"is not finite in row {row + 1}", "leave such rows out")


def measured(system: System, columns: Mapping[str, object]) -> Measurement:
    """A measurement from columns by name: `t`, entries of the state, inputs.

    Args:
        system: The chain whose state and inputs the columns name.
        columns: Name -> values (m,).

    Raises:
        ArrayError: No column `t`, a name that is no entry of the state and no input, and as `Measurement` says.
    """
    states, known = (*system.q_names, *system.v_names), ("t", *system.q_names, *system.v_names, *system.u_names)
    for name in columns:
        if name not in known:
            best = nearest(name, known)
            guess = f'did you mean "{best}"? ' if best else ""
            raise ArrayError("data", name, "is no column of this chain", f"{guess}There are {', '.join(known)}; leave out the others")
    if "t" not in columns:
        raise ArrayError("data", tuple(columns), 'has no column "t"', "give the times in s under that name")
    found = {name: reals(f"data.{name}", values, "give real numbers") for name, values in columns.items()}
    if len({column.shape for column in found.values()}) > 1 or found["t"].ndim != 1:
        raise ArrayError("data", {name: c.shape for name, c in found.items()}, "holds columns of several lengths", "give one row for each time")
    there, pushed = ([name for name in names if name in found] for names in (states, system.u_names))

    def stacked(names: Sequence[str]) -> Vector:
        return np.column_stack([found[name] for name in names]) if names else np.empty((len(found["t"]), 0))

    return Measurement(found["t"], tuple(there), stacked(there), tuple(pushed), stacked(pushed))


def read_measurement(system: System, path: Path | str) -> Measurement:
    """A measurement from a CSV file: a header of names, then rows of numbers.

    Args:
        system: The chain whose state and inputs the columns name.
        path: The file: `t` in s, angles theta_k in rad (continuous over whole turns), rates theta_dot_k, a cart's x, inputs by name.

    Raises:
        OutputError: The file cannot be read.
        ArrayError: As `measured` says; a name that stands twice, a row that is too short or holds no numbers.
    """
    try:
        rows = read_rows(path, LARGEST)
    except (OSError, ValueError) as failure:
        raise OutputError("data", str(path), f"cannot be read: {failure}", "name a CSV file of measured columns") from failure
    names = [name.strip() for name in rows[0]] if rows else []
    if not names:
        raise ArrayError("data", str(path), 'is empty and has no column "t"', "head the columns t and what was measured")
    if len(set(names)) < len(names):
        raise ArrayError("data", names, "names a column twice", "head every column once")
    numbers = [row_of_numbers("data", row, len(names), k) for k, row in enumerate(rows[1:], 2)]
    table = np.array(numbers, dtype=float).reshape(-1, len(names))
    return measured(system, dict(zip(names, table.T, strict=True)))
