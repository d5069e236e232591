"""study: a task at every point of a grid or of samples, what is known already read from the store."""

from __future__ import annotations

import os
import shutil
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from phichain._version import __version__
from phichain.errors import StudyError
from phichain.studies.document import load_plan, plan_of
from phichain.studies.engine import Engine, batches_of, engine_of, split
from phichain.studies.plan import Plan, size_words
from phichain.studies.store import Store
from phichain.studies.task import DONE, FAILED, PENDING
from phichain.studies.worker import Batch, Finished, system_of
from phichain.system.arrays import whole

if TYPE_CHECKING:
    import xarray as xr

Progress = Callable[[int, int, int], Any]
"""Told how many tasks are done, how many have failed, and how many there are."""
_RETRIES: Final = 1


@dataclass(frozen=True)
class Studied:
    """What a study found, and what it took.

    Attributes:
        plan: The study.
        path: Its store.
        found: Tasks whose results were there already.
        kept: Tasks that failed in an earlier run and were not tried again.
        computed: Tasks computed by this run.
        failures: Why tasks failed, by their number in the study.
        seconds: Wall time of the computing.
        busy: Seconds that workers computed, all together.
        workers: How many there were.
        status: "complete" or "interrupted".
    """

    plan: Plan
    path: Path
    found: int
    kept: int
    computed: int
    failures: Mapping[int, str] = field(repr=False)
    seconds: float
    busy: float
    workers: int
    status: str

    @property
    def overhead(self) -> float:
        """Seconds a task that workers did not compute in: handing out, waiting, writing; NaN where nothing was computed."""
        return (self.seconds * self.workers - self.busy) / self.computed if self.computed else float("nan")

    def dataset(self) -> xr.Dataset:
        """The results, in memory.

        Raises:
            StudyError: A chunk of the store cannot be read.
        """
        from phichain.studies.dataset import open_study

        return open_study(self.path, self.plan)

    def __str__(self) -> str:
        left = self.plan.count - self.found - self.computed - self.kept
        lines = [f"{self.plan.name}: {self.status}, {self.plan.count} tasks of {self.plan.task.name}: {self.found} found in the store"]
        lines[0] += f", {self.computed} computed{f', {left} left' if left else ''}, {len(self.failures)} failed"
        if self.computed:
            lines.append(
                f"  {self.seconds:.1f} s on {self.workers} worker(s), {1e3 * self.busy / self.computed:.3g} ms of computing "
                f"and {1e3 * self.overhead:.2g} ms of everything else a task"
            )
        lines += [f"  task {number}: {text}" for number, text in list(self.failures.items())[:3]]
        return "\n".join(lines)


def study(
    plan: Plan | Mapping[str, Any] | str | PathLike[str],
    out: str | PathLike[str] | None = None,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    batch: int | None = None,
    retry: bool = False,
    progress: Progress | None = None,
) -> Studied:
    """Compute a study into its store; what the store holds already is not computed again.

    Ctrl-C ends it with the status "interrupted"; the same call goes on where it was. In a script, call it under
    ``if __name__ == "__main__":``, as everything that starts processes.

    Args:
        plan: A Plan, its tables, or the TOML file of one (docs/studies.md).
        out: The store, a Zarr group; NAME.zarr unless given.
        workers: Processes of a local Dask cluster; one per core unless given, 0 computes in this process.
        scheduler: Address of a Dask scheduler whose workers compute instead, such as "tcp://host:8786".
        batch: Points sent to a worker at a time; by the task and the number of workers unless given.
        retry: Compute tasks again that failed in an earlier run.
        progress: Told (done, failed, total) after every batch.

    Returns:
        Studied; its `dataset()` holds the results.

    Raises:
        StudyError: The study cannot be planned, the store holds another one or is in use, the scheduler does not answer.
        SceneError: A value of an axis makes no chain.
        OutputError: The store cannot be written.
    """
    plan = given_plan(plan)
    path = Path(fspath(out)) if out is not None else Path(f"{plan.name.replace(os.sep, '_')}.zarr")
    size = None if batch is None else whole("batch", batch, 1, 2**20, "give the points of a batch", StudyError)
    if workers is not None:
        whole("workers", workers, 0, 4096, "give the number of processes, 0 for this one", StudyError)
    demand_room(plan, path)
    keys, values = plan.point_keys(), list(plan.values(range(plan.count)))
    with _locked(path):
        store = Store.opened(path, plan)
        rows = store.register(keys, values, plan.keys)
        store.mend(rows)
        store.say(plan)
        wanted = np.flatnonzero((store.status[rows] == PENDING) | (retry & (store.status[rows] == FAILED)))
        # A point that the axes name twice has one row and is computed once.
        wanted = wanted[np.unique(rows[wanted], return_index=True)[1]]
        found = int(np.sum(store.status[rows] == DONE))
        failed_before = int(np.sum(store.status[rows] == FAILED))
        told = _Told(store, rows, found, plan.count, progress)
        status, seconds, busy, many = "complete", 0.0, 0.0, 0
        if len(wanted):
            with engine_of(workers, scheduler) as engine:
                if scheduler is None:
                    _build_first(plan)
                began, many = time.perf_counter(), engine.workers
                try:
                    busy = _compute(plan, store, rows[wanted], [values[k] for k in wanted], engine, size, told)
                except KeyboardInterrupt:
                    status, busy = "interrupted", told.busy
                seconds = time.perf_counter() - began
        kept = 0 if retry else failed_before
        return Studied(plan, path, found, kept, told.computed, store.failures(rows), seconds, busy, many, status)


def given_plan(plan: Any) -> Plan:
    """The Plan that a caller means."""
    if isinstance(plan, Plan):
        return plan
    return plan_of(plan) if isinstance(plan, Mapping) else load_plan(plan)


class _Told:
    """Counts what is done and tells it."""

    def __init__(self, store: Store, rows: np.ndarray, found: int, total: int, progress: Progress | None) -> None:
        self.done, self.failed, self.computed, self.busy = found, int(np.sum(store.status[rows] == FAILED)), 0, 0.0
        self.total, self._progress = total, progress

    def add(self, finished: Finished) -> None:
        good = sum(isinstance(result, dict) for result in finished.results)
        self.done, self.failed = self.done + good, self.failed + len(finished.results) - good
        self.computed, self.busy = self.computed + len(finished.results), self.busy + finished.busy
        if self._progress is not None:
            self._progress(self.done, self.failed, self.total)


def _compute(plan: Plan, store: Store, rows: np.ndarray, values: list[Any], engine: Engine, size: int | None, told: _Told) -> float:
    """Hand the batches out and put what comes back in place; seconds that workers computed."""
    chunk = plan.task.chunk
    order = np.argsort(rows, kind="stable")
    rows, values = rows[order], [values[k] for k in order]
    parts: list[list[int]] = []

    def batches() -> Iterator[Batch]:
        for part in split(rows.tolist(), chunk, batches_of(len(rows), chunk, engine.workers, size)):
            parts.append(part)
            yield Batch(plan.base, plan.keys, tuple(values[k] for k in part), __version__, _RETRIES)

    def take(number: int, finished: Finished) -> None:
        store.write(rows[parts[number]], finished.results)
        told.add(finished)

    engine.run(batches(), take)
    return told.busy


def _build_first(plan: Plan) -> None:
    """Compile the first chain here, so that the workers of this machine find it instead of all compiling it at once."""
    values = next(iter(plan.values([0])))
    point = plan.resolver(values)
    try:
        system_of(point.scene, point.digest)
    except Exception:  # noqa: BLE001 - it fails again where its failure is recorded
        return


def demand_room(plan: Plan, path: Path) -> None:
    """Refuse a study that neither memory nor disk can hold.

    Raises:
        StudyError: It needs more than there is.
    """
    have = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    if plan.handled > have:
        raise StudyError("study", plan.count, f"takes {size_words(plan.handled)} of memory here, and there are {size_words(have)}", "split it (docs/studies.md)")
    above = path.absolute()
    while not above.exists():
        above = above.parent
    free = shutil.disk_usage(above).free
    if plan.size > free:
        raise StudyError("study", plan.count, f"leaves {size_words(plan.size)}, and {size_words(free)} are free there", "keep fewer points, or name another --out")


@contextmanager
def _locked(path: Path) -> Iterator[None]:
    """Nobody else writes to the store meanwhile.

    Raises:
        StudyError: Somebody does.
    """
    from filelock import FileLock, Timeout

    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with FileLock(f"{path}.lock", timeout=0):
            yield
    except Timeout as error:
        raise StudyError("out", str(path), "is written to by another run", "wait for it, or name another folder") from error
    except PermissionError as error:
        raise StudyError("out", str(path), f"cannot be written, {error.strerror}", "name a folder of your own") from error
