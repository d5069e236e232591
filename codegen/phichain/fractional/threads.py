"""Independent pieces of array work on several threads: NumPy and SciPy's FFT release the interpreter while they run."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor

from phichain.errors import ArrayError


def run(tasks: Sequence[Callable[[], None]], workers: int | None) -> None:
    """Run the tasks; what they compute must not depend on the order.

    Args:
        tasks: Functions without arguments.
        workers: Threads; None takes one per core this process may use.

    Raises:
        ArrayError: Fewer than one worker.
    """
    if workers is not None and workers < 1:
        raise ArrayError("workers", workers, "must be at least 1", "leave it out to use every core")
    threads = min(workers or available_cores(), len(tasks))
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
