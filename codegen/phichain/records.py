"""How results leave memory: CSV for people and spreadsheets, NPZ for exact round trips.

A result record is a frozen dataclass of arrays, numbers and strings. CSV takes its table with 17 significant
digits, so every double survives; NPZ takes all of it, the small fields as one JSON text, and needs no pickle;
`phichain.archive` reads it back.
Files appear whole or not at all (`phichain.files`).
"""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from phichain.archive import LARGEST, META
from phichain.errors import OutputError
from phichain.files import write_file


def write_csv(path: Path | str, columns: Mapping[str, ArrayLike]) -> Path:
    """Write equally long columns under one header row.

    Args:
        path: The file to write.
        columns: Column name -> values; numbers are written so that they read back exactly.

    Returns:
        The path written.

    Raises:
        OutputError: The file cannot be written.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(
        zip(*([_cell(value) for value in np.asarray(column)] for column in columns.values()), strict=True)
    )
    return write_file(path, text.getvalue())


def _cell(value: Any) -> str:
    return repr(float(value)) if isinstance(value, np.floating) else str(value)


def write_npz(path: Path | str, arrays: Mapping[str, ArrayLike], meta: Mapping[str, Any]) -> Path:
    """Write arrays and, as one JSON text beside them, the small fields of a record.

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
    payload[META] = np.asarray(json.dumps(meta, sort_keys=True))
    np.savez_compressed(buffer, allow_pickle=False, **payload)
    return write_file(path, buffer.getvalue())


def columns_of(names: Sequence[str], values: np.ndarray | None) -> dict[str, np.ndarray]:
    """The columns of a two-dimensional array under their names; nothing for None."""
    if values is None:
        return {}
    return {name: values[:, k] for k, name in enumerate(names)}
