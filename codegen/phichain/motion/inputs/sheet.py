"""Inputs from a CSV file: a column `t` and one column for every input that moves, by its name."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from phichain.errors import ArrayError, OutputError, UnsupportedError
from phichain.motion.inputs.names import position
from phichain.motion.inputs.table import Table
from phichain.reading import MEBIBYTE, read_rows
from phichain.system import System

LARGEST = 256 * MEBIBYTE


def read_inputs(system: System, path: Path | str, between: str = "held") -> dict[str, Table]:
    """One table per column, for `simulate(..., u=read_inputs(system, path))`; an input without a column is zero.

    Args:
        system: The chain whose inputs the columns name.
        path: The file: a header, then rows of numbers; t in s, the inputs in N, N m, m/s^2.
        between: "held" or "linear", from one row to the next.

    Raises:
        OutputError: The file cannot be read.
        ArrayError: No column t, an unknown or repeated name, a row that is too short or holds no numbers, times that do not rise.
        UnsupportedError: The system has no input.
    """
    if system.nu == 0:
        raise UnsupportedError("input", str(path), f"system '{system.name}' has no input", "name joints in `actuated`")
    try:
        rows = read_rows(path, LARGEST)
    except (OSError, ValueError) as failure:
        raise OutputError("input", str(path), f"cannot be read: {failure}", "name a CSV file of inputs") from failure
    names = [name.strip() for name in rows[0]] if rows else []
    if "t" not in names or len(names) < 2 or len(set(names)) < len(names):
        raise ArrayError("input", names, "is no header of inputs in time", "head the columns t and the inputs' names, each once")
    columns = [name for name in names if name != "t"]
    for name in columns:
        position(system, "input", name)
    numbers = np.array([row_of_numbers("input", row, len(names), k) for k, row in enumerate(rows[1:], 2)]).reshape(-1, len(names))
    times = numbers[:, names.index("t")]
    return {name: Table(times, numbers[:, names.index(name)], between) for name in columns}


def row_of_numbers(field: str, row: list[str], size: int, line: int) -> list[float]:
    """The numbers of one row of a CSV file.

    Args:
        field: What the file is, for the error.
        row: Its cells.
        size: How many there must be.
        line: Where it stands.

    Raises:
        ArrayError: Too few, too many, or no numbers.
    """
    try:
        found = [float(cell) for cell in row]
    except ValueError:
        raise ArrayError(field, row, f"does not hold numbers in line {line}", "write numbers with a decimal point") from None
    if len(found) != size:
        raise ArrayError(field, row, f"does not hold {size} numbers in line {line}", "give one for every column")
    return found
