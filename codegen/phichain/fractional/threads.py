"""Who computes on how many threads: NumPy and SciPy's FFT release the interpreter while they run."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

from phichain.errors import ArrayError

Vector = NDArray[np.float64]

# OpenBLAS starts its own threads from about 2^20 multiplications on.
_ONE_THREAD = 2**19


def run(tasks: Sequence[Callable[[], None]], workers: int | None, most: int | None = None) -> None:
    """Run the tasks; what they compute must not depend on the order.

    Args:
        tasks: Functions without arguments.
        workers: Threads; None takes one per core this process may use.
        most: How many tasks the memory bears at once, at least one; None bears all.

    Raises:
        ArrayError: Fewer than one worker.
    """
    if workers is not None and workers < 1:
        raise ArrayError("workers", workers, "must be at least 1", "leave it out to use every core")
    threads = min(workers or available_cores(), len(tasks), len(tasks) if most is None else max(1, most))
    if threads <= 1:
        for task in tasks:
            task()
        return
    with ThreadPoolExecutor(threads) as pool:
        for running in [pool.submit(task) for task in tasks]:
            running.result()


def available_cores() -> int:
    """Cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else (os.cpu_count() or 1)


def product(left: Vector, right: Vector, out: Vector | None = None) -> Vector:
    """left @ right in pieces so small that BLAS keeps to the calling thread.

    Its own threads would compete with those of `run`, and they spin while they wait: on a busy machine a small product
    takes ten times as long with them.
    """
    if out is None:
        out = np.empty((left.shape[0], right.shape[1]))
    columns = max(1, _ONE_THREAD // max(1, left.size))
    for first in range(0, right.shape[1], columns):
        piece = slice(first, first + columns)
        np.matmul(left, right[:, piece], out=out[:, piece])
    return out
