"""Runs work in processes of their own, a few at a time, each with a limit of processor time it cannot ignore."""

from __future__ import annotations

import math
import multiprocessing
import resource
import signal
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Any, Generic, TypeVar

Key = TypeVar("Key")
TIME_LIMIT = "time limit"
_POLL = 0.01
_PATIENCE = 6.0  # wall time over processor time, on a busy machine


@dataclass(frozen=True)
class Done(Generic[Key]):
    """What came of one piece of work.

    Attributes:
        key: its name.
        result: what it returned; None when it did not finish.
        failure: why not: "time limit", or how the process ended.
        seconds: processor time.
    """

    key: Key
    result: Any
    failure: str
    seconds: float


def run_apart(
    work: Sequence[tuple[Key, Callable[[], Any]]], seconds: float, jobs: int
) -> Iterator[Done[Key]]:
    """Run every piece of work, in forked processes, and yield what came of it in the order of finishing."""
    context = multiprocessing.get_context("fork")
    waiting, running = list(reversed(work)), []
    while waiting or running:
        while waiting and len(running) < jobs:
            key, function = waiting.pop()
            ours, theirs = context.Pipe(duplex=False)
            process = context.Process(target=_child, args=(function, theirs, seconds), daemon=True)
            process.start()
            theirs.close()
            running.append((key, process, ours, time.perf_counter()))
        for entry in list(running):
            key, process, pipe, begin = entry
            spent = time.perf_counter() - begin
            if pipe.poll():
                yield _received(key, process, pipe, spent)
            elif spent > _PATIENCE * seconds:
                process.kill()
                yield Done(key, None, TIME_LIMIT, spent)
            else:
                continue
            process.join()
            pipe.close()
            running.remove(entry)
        time.sleep(_POLL)


def _received(key: Any, process: Any, pipe: Connection, spent: float) -> Done[Any]:
    try:
        result, seconds = pipe.recv()
    except EOFError:
        process.join()
        out_of_time = process.exitcode in (-signal.SIGXCPU, -signal.SIGKILL)
        return Done(
            key, None, TIME_LIMIT if out_of_time else f"its process ended with {process.exitcode}", spent
        )
    if isinstance(result, BaseException):
        return Done(key, None, str(result), spent)
    return Done(key, result, "", seconds)


def _child(function: Callable[[], Any], pipe: Connection, seconds: float) -> None:
    limit = math.ceil(seconds)
    resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 2))
    begin = time.process_time()
    try:
        result = function()
    except Exception as failure:  # noqa: BLE001 - whatever a method throws is its answer
        result = RuntimeError(f"{type(failure).__name__}: {failure}")
    pipe.send((result, time.process_time() - begin))
