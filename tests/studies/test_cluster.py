"""A scheduler and two workers, each a process of its own on loopback: one worker is killed on the way, and no result is lost."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from phichain import study
from phichain.errors import StudyError
from phichain.studies import engine
from phichain.studies.worker import Batch, Finished
from tests.studies.conftest import tables

ROOT = Path(__file__).parents[2]
POINTS = {"grid": {"gravity": [9.81, 1.62], "task.lean": {"from": 0.1, "to": 1.0, "count": 60}}}


def started(*words: str) -> subprocess.Popen[str]:
    environment = {**os.environ, "PYTHONPATH": f"{ROOT / 'codegen'}{os.pathsep}{ROOT}", "DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED": "False"}
    return subprocess.Popen([sys.executable, "-m", "distributed.cli." + words[0], *words[1:]], env=environment, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)  # fmt: skip


@pytest.fixture(scope="module")
def scheduler(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[str, list[subprocess.Popen[str]]]]:
    """Address of a scheduler, and its workers."""
    folder = tmp_path_factory.mktemp("dask")
    found = folder / "scheduler.json"
    processes = [started("dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", str(found))]
    worker = ("dask_worker", "--scheduler-file", str(found), "--nthreads", "1", "--no-nanny", "--no-dashboard", "--local-directory", str(folder))
    processes += [started(*worker) for _ in range(2)]
    try:
        assert processes[0].stderr is not None
        address = next(line.split("at:")[1].strip() for line in processes[0].stderr if "Scheduler at:" in line)
        yield address, processes[1:]
    finally:
        for process in reversed(processes):
            process.kill()
            process.wait()
            assert process.stderr is not None
            process.stderr.close()


@pytest.mark.long
def test_a_killed_worker_costs_no_result(scheduler: tuple[str, list[subprocess.Popen[str]]]) -> None:
    address, workers = scheduler
    alone = study(tables(**POINTS), "alone.zarr", workers=0).dataset()
    seen: list[int] = []

    def kill(done: int, failed: int, total: int) -> None:
        if not seen:
            os.kill(workers[0].pid, signal.SIGKILL)
        seen.append(done)

    found = study(tables(**POINTS), "far.zarr", scheduler=address, batch=2, progress=kill)
    assert workers[0].wait(timeout=30) == -signal.SIGKILL
    assert found.status == "complete" and found.computed == 120 and not found.failures
    assert found.dataset().identical(alone)
    assert study(tables(**POINTS), "far.zarr", scheduler=address).computed == 0


def test_a_batch_that_kills_workers_is_taken_apart() -> None:
    """Point by point: what does it is recorded, and the others are computed."""
    from distributed.scheduler import KilledWorker

    class Future:
        def __init__(self, batch: Batch) -> None:
            self.batch = batch

        def result(self) -> Finished:
            if ("deadly",) in self.batch.values:
                raise KilledWorker("task", None, 3)
            return Finished([{"t": value[0]} for value in self.batch.values], 1.0, 1)

    class Client:
        def submit(self, function: Any, batch: Batch, pure: bool) -> Future:
            return Future(batch)

    batch = Batch(None, ("task.lean",), ((1.0,), ("deadly",), (3.0,)), "", 0)  # type: ignore[arg-type]
    results = engine.Cluster(Client())._result(Future(batch), batch).results  # type: ignore[arg-type]
    assert results[0] == {"t": 1.0} and results[2] == {"t": 3.0}
    assert "died of it" in results[1].text and not results[1].is_final  # type: ignore[union-attr]


def test_a_scheduler_that_does_not_answer_is_one_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(engine, "PATIENCE", 1)
    with pytest.raises(StudyError, match=r"scheduler: does not answer \(got 'tcp://127.0.0.1:1'\)"):
        study(tables(), "far.zarr", scheduler="tcp://127.0.0.1:1")


@pytest.mark.long
def test_batches_keep_to_the_chunks_of_the_store() -> None:
    rows = [*range(5, 20), 40, 41, 7 * 8]
    parts = list(engine.split(rows, 8, 4))
    assert [k for part in parts for k in part] == list(range(len(rows)))
    assert all(len({rows[k] // 8 for k in part}) == 1 and len(part) <= 4 for part in parts)
    assert engine.batches_of(10_000, 256, 2, None) == 256 and engine.batches_of(10, 256, 2, None) == 2 and engine.batches_of(10, 256, 2, 5) == 5
    assert np.sum([len(part) for part in parts]) == len(rows)
