"""A chain under its law from many starts at once: the compiled closed loop as a callable."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phichain.native.cache import default_cache
from phichain.native.library import load_library, shared_object

Vector = NDArray[np.float64]


class _Run(ctypes.Structure):
    """NAME_controller_run of the emitted file."""

    _fields_ = [
        ("starts", ctypes.c_long), ("calls", ctypes.c_long), ("steps", ctypes.c_long), ("step", ctypes.c_double), ("near", ctypes.c_double),
        ("far", ctypes.c_double),
    ]  # fmt: skip


@dataclass(frozen=True)
class ClosedLoop:
    """A chain under the laws of a table.

    Attributes:
        name: The chain.
        nx: Entries of its state.
        period: Seconds from one call of the law to the next.
        steps: Steps of the chain in between.
        rows: The table's rows, one array for each field in the order of the C.
    """

    name: str
    nx: int
    period: float
    steps: int
    rows: tuple[tuple[Vector, ...], ...]
    _run: Any = field(repr=False)

    def __call__(self, which: int, x: Vector, calls: int, near: float, far: float) -> tuple[Vector, Vector]:
        """Lead states on until they come near, fly off, or `calls` are over.

        Args:
            which: The equilibrium whose law leads.
            x: The states at first (count, nx); they are left as they are.
            calls: Most calls of the law.
            near: Level at which a start has come near.
            far: Level at which it has flown off.

        Returns:
            Verdicts (count,), 1 near, 0 flown off, -1 neither, and the calls until then (count,).
        """
        states = np.array(x, dtype=np.float64, order="C").reshape(-1, self.nx)
        came, verdict = np.zeros(len(states), dtype=ctypes.c_long), np.zeros(len(states), dtype=ctypes.c_int)
        run = _Run(len(states), calls, self.steps, self.period / self.steps, near, far)
        row = [ctypes.c_void_p(part.ctypes.data) for part in self.rows[which]]
        memory = [ctypes.c_void_p(array.ctypes.data) for array in (states, came, verdict)]
        self._run(ctypes.byref(run), *row, *memory)
        return verdict, came


def load_closed_loop(
    name: str, sources: Mapping[str, str], nx: int, rhythm: tuple[float, int], rows: Sequence[Mapping[str, Sequence[float]]]
) -> ClosedLoop:
    """Compile a closed loop, or find it compiled.

    Args:
        name: The chain.
        sources: NAME.h, NAME.c and NAME_closed_loop.c by file name.
        nx: Entries of its state.
        rhythm: The law's period, s, and the steps of the chain in each.
        rows: The table's rows by field.

    Raises:
        CompilerError: The compiler is missing, failed or hung.
        CacheError: The cache's folder is not the owner's alone, or the system cannot load from it.
    """
    texts = {file: text.encode() for file, text in sources.items()}
    library = load_library(shared_object(name, texts, default_cache()))
    function = library[f"{name}_controller_closed_loop"]
    function.restype = None
    arrays = tuple(tuple(np.array(values, dtype=np.float64) for values in row.values()) for row in rows)
    return ClosedLoop(name, nx, rhythm[0], rhythm[1], arrays, function)
