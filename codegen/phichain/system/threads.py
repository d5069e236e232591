"""Who computes on how many threads: C, NumPy and SciPy's FFT release the interpreter while they run."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Sequence
from threading import Event, Thread
from typing import Final

from phichain.errors import ArrayError

VARIABLE: Final = "PHICHAIN_WORKERS"


def run(tasks: Sequence[Callable[[], None]], workers: int | None, most: int | None = None) -> None:
    """Run the tasks, on this thread and on others; what they compute must not depend on the order.

    Ctrl-C ends it at once: a task that runs on another thread then runs out unheeded, and no other one is begun.

    Args:
        tasks: Functions without arguments.
        workers: Threads; None takes $PHICHAIN_WORKERS, or else one per core this process may use.
        most: How many tasks the memory bears at once, at least one; None bears all.

    Raises:
        ArrayError: Fewer than one worker.
    """
    if len(tasks) == 1 and workers is None:
        tasks[0]()
        return
    threads = min(worker_count(workers), len(tasks), len(tasks) if most is None else max(1, most))
    waiting, stopped = deque(tasks), Event()
    failures: list[BaseException] = []

    def work() -> None:
        while not stopped.is_set():
            try:
                task = waiting.popleft()
            except IndexError:
                return
            task()

    def help_out() -> None:
        try:
            work()
        except BaseException as failure:  # noqa: BLE001, raised again on the thread that asked
            failures.append(failure)
            stopped.set()

    helpers = [Thread(target=help_out, daemon=True) for _ in range(threads - 1)]
    for helper in helpers:
        helper.start()
    try:
        work()
        for helper in helpers:
            helper.join()
    finally:
        stopped.set()
    if failures:
        raise failures[0]


def worker_count(workers: int | None) -> int:
    """How many threads are meant.

    Raises:
        ArrayError: Fewer than one, or no whole number.
    """
    field, given = ("workers", workers) if workers is not None else (VARIABLE, os.environ.get(VARIABLE) or available_cores())
    count = int(given) if isinstance(given, str) and given.isdecimal() else given
    if not isinstance(count, int) or count < 1:
        raise ArrayError(field, given, "must be at least 1", "leave it out to use every core")
    return count


def available_cores() -> int:
    """Cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else (os.cpu_count() or 1)


def pieces(count: int, least: int, workers: int | None) -> list[slice]:
    """Consecutive pieces of a batch for `run`: whole multiples of `least` but the last, some for each worker; one for a small batch.

    Args:
        count: Length of the batch.
        least: The smallest piece that is worth a thread.
        workers: As of `run`.

    Raises:
        ArrayError: Fewer than one worker.
    """
    threads = 1 if workers is None and count < 2 * least else worker_count(workers)
    if threads == 1 or count < 2 * least:
        return [slice(0, count)]
    share = -(-count // (_SHARES * threads))
    size = -(-share // least) * least
    return [slice(first, min(first + size, count)) for first in range(0, count, size)]


_SHARES: Final = 4
"""Pieces for each thread: who is done early takes another one."""
