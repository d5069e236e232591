"""Who computes the batches: this process, a local Dask cluster, or the workers of a scheduler elsewhere."""

from __future__ import annotations

import logging
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from multiprocessing import parent_process
from typing import TYPE_CHECKING, Any, Final, Protocol

from phichain.errors import StudyError
from phichain.studies.task import Failure
from phichain.studies.worker import Batch, Finished, run_batch
from phichain.system.threads import available_cores

if TYPE_CHECKING:
    from distributed import Client, Future

AHEAD: Final = 4
"""Batches that wait at every worker: enough that none idles, few enough that a study of any length fits the scheduler."""
PATIENCE: Final = 15
"""Seconds to wait for a scheduler."""
_DIED: Final = "the worker died of it, every time it was tried"

Take = Callable[[int, Finished], None]


class Engine(Protocol):
    """Computes batches and hands each over as it is done."""

    @property
    def workers(self) -> int:
        """How many batches it computes at a time."""

    def run(self, batches: Iterator[Batch], take: Take) -> None:
        """Compute the batches; `take` gets the number of each, in any order, and its results."""


class Here:
    """This process, one batch after the other."""

    workers = 1

    def run(self, batches: Iterator[Batch], take: Take) -> None:
        """Compute them in order."""
        for number, batch in enumerate(batches):
            take(number, run_batch(batch))


class Cluster:
    """The workers of a Dask scheduler."""

    def __init__(self, client: Client) -> None:
        """Take a connected client."""
        self.client = client

    @property
    def workers(self) -> int:
        """Threads of all workers."""
        return max(1, sum(self.client.nthreads().values()))

    def run(self, batches: Iterator[Batch], take: Take) -> None:
        """Keep every worker busy; a batch whose worker dies is computed by another one, and taken apart when that goes on."""
        from distributed import as_completed

        waiting = enumerate(batches)
        sent: dict[str, tuple[int, Batch]] = {}
        coming: Any = as_completed()

        def send() -> None:
            for number, batch in waiting:
                future = self.client.submit(run_batch, batch, pure=False)
                sent[str(future.key)] = number, batch
                coming.add(future)
                return

        for _ in range(AHEAD * self.workers):
            send()
        for future in coming:
            number, batch = sent.pop(str(future.key))
            take(number, self._result(future, batch))
            future.release()
            send()

    def _result(self, future: Future, batch: Batch) -> Finished:
        """The results of a batch, whatever became of it.

        Raises:
            StudyError: The scheduler is gone, or its workers run another phichain.
        """
        from distributed.client import FutureCancelledError
        from distributed.scheduler import KilledWorker

        try:
            found: Finished = future.result()
            return found
        except StudyError:
            raise
        except FutureCancelledError as error:
            raise StudyError("scheduler", _address(self.client), "is gone", "start it, and run the study again: it goes on where it was") from error
        except KilledWorker:
            return self._apart(batch)
        except Exception as error:  # noqa: BLE001 - what a worker's machine makes of a batch, such as a missing package
            failure = Failure(f"{type(error).__name__}: {error}"[:400], False)
            return Finished([failure] * len(batch.values), 0.0, 0)

    def _apart(self, batch: Batch) -> Finished:
        """A batch that kills workers, point by point, so that what does it is known and the others are computed."""
        from dataclasses import replace

        if len(batch.values) == 1:
            return Finished([Failure(_DIED, False)], 0.0, 0)
        alone = [replace(batch, values=(values,)) for values in batch.values]
        futures = [self.client.submit(run_batch, one, pure=False) for one in alone]
        parts = [self._result(future, one) for future, one in zip(futures, alone, strict=True)]
        return Finished([part.results[0] for part in parts], sum(part.busy for part in parts), 0)


@contextmanager
def engine_of(workers: int | None, scheduler: str | None) -> Iterator[Engine]:
    """Who computes: 0 workers is this process, a scheduler's address its workers, else a local cluster.

    Raises:
        StudyError: Dask is not installed, or the scheduler does not answer.
    """
    if workers == 0 and scheduler is None:
        yield Here()
        return
    try:
        import dask
        from distributed import Client, LocalCluster
    except ImportError as error:
        raise StudyError("study", "distributed", "is not installed", "say pip install 'phichain[study]', or compute here with workers = 0") from error
    if scheduler is not None:
        with dask.config.set({"distributed.comm.timeouts.connect": f"{PATIENCE}s"}):
            client = _connected(Client, scheduler)
        try:
            yield Cluster(client)
        finally:
            client.close()
        return
    quiet = {"distributed.worker.memory.terminate": False, "distributed.admin.tick.limit": "60s"}
    with dask.config.set(quiet), _local(LocalCluster, workers) as cluster, Client(cluster) as client:
        yield Cluster(client)


def _local(cluster: Any, workers: int | None) -> Any:
    """A cluster of this machine, one process a core.

    Raises:
        StudyError: Its processes do not start, as those of a script that starts a study whenever it is imported.
    """
    remedy = 'in a script, call study under if __name__ == "__main__":, or compute here with workers = 0'
    if parent_process() is not None and "__mp_main__" in sys.modules:
        raise StudyError("study", "a script", "is called again by every worker that starts", remedy)
    try:
        return cluster(
            n_workers=workers or available_cores(), threads_per_worker=1, processes=True, host="127.0.0.1", dashboard_address=None,
            silence_logs=logging.CRITICAL,
        )  # fmt: skip
    except RuntimeError as error:
        raise StudyError("workers", workers or available_cores(), "do not start", remedy) from error


def _connected(client: Any, address: str) -> Any:
    """A client of a scheduler that has workers.

    Raises:
        StudyError: It does not answer, or has none.
    """
    try:
        found = client(address, timeout=PATIENCE)
    except (OSError, TimeoutError, ValueError, KeyError) as error:
        raise StudyError("scheduler", address, "does not answer", "start it with dask scheduler, and give its address, such as tcp://HOST:8786") from error
    try:
        found.wait_for_workers(1, timeout=PATIENCE)
    except (OSError, TimeoutError) as error:
        found.close()
        raise StudyError("scheduler", address, "has no workers", f"start some with dask worker {address}") from error
    return found


def _address(client: Any) -> str:
    return str(client.scheduler.address) if client.scheduler else "none"


def batches_of(total: int, chunk: int, workers: int, asked: int | None) -> int:
    """Points of a batch: what was asked, else a chunk, or less where workers would else wait for one another."""
    if asked is not None:
        return asked
    return max(1, min(chunk, -(-total // (AHEAD * max(1, workers)))))


def split(rows: Sequence[int], chunk: int, most: int) -> Iterator[list[int]]:
    """Places of rows in batches of at most `most`, none across two chunks of the store."""
    part: list[int] = []
    for place, row in enumerate(rows):
        if part and (len(part) == most or row // chunk != rows[part[0]] // chunk):
            yield part
            part = []
        part.append(place)
    if part:
        yield part
