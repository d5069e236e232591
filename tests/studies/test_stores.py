"""What is kept: results equal to the functions' own, resumed exactly, extended by what is new, mended where damaged."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from phichain import build, open_study, simulate, study
from phichain.errors import StudyError
from phichain.scene.load import with_functions
from phichain.studies import plan_of, run, store, write_netcdf
from phichain.studies.store import StudyWarning
from phichain.studies.task import Failure
from tests.studies.conftest import SCENE, tables


def here(**changes: Any) -> Any:
    return study(tables(**changes), "kept.zarr", workers=0)


def test_results_are_those_of_simulate_by_the_names_of_the_axes() -> None:
    found = here()
    data = found.dataset()
    system = build(with_functions(SCENE, ("forward_dynamics",)))
    for gravity in (9.81, 1.62):
        motion = simulate(system, (np.array([0.2]), np.zeros(1)), 0.5, tol=1e-8, p={"gravity": gravity}, error_estimate=False)
        one = data.sel({"chain.gravity": gravity, "task.lean": 0.2})
        assert one.q.item() == motion.q[-1, 0] and one.v.item() == motion.v[-1, 0] and one.steps.item() == motion.counts["steps"]
    assert data.t.attrs["units"] == "s" and data.q_name.item() == "theta_1"
    assert data.outcome.attrs["flag_meanings"].split()[int(data.outcome[0, 0])] == "complete"
    assert "scene studied" in data.attrs["phichain"]
    assert open_study("kept.zarr").identical(data), "the store knows its study by itself"


def test_what_is_there_is_not_computed_again_and_more_is_added(monkeypatch: pytest.MonkeyPatch) -> None:
    first = here()
    assert (first.found, first.computed) == (0, 6)
    with monkeypatch.context() as patched:
        patched.setattr(run, "system_of", None)  # nothing is built where nothing is computed
        assert (here().found, here().computed) == (6, 0)
    more = here(grid={"gravity": [1.62, 3.7], "task.lean": [0.1, 0.2, 0.3, 0.4]})
    assert (more.found, more.computed) == (3, 5)
    old, new = first.dataset().sel({"chain.gravity": 1.62}), more.dataset().sel({"chain.gravity": 1.62, "task.lean": [0.1, 0.2, 0.3]})
    assert np.array_equal(old.q, new.q)


def test_an_interrupted_study_goes_on_to_the_same_results(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = study(tables(), "whole.zarr", workers=0).dataset()

    def stop(done: int, failed: int, total: int) -> None:
        if done == 2:
            raise KeyboardInterrupt

    broken = study(tables(), "kept.zarr", workers=0, batch=1, progress=stop)
    assert broken.status == "interrupted" and "4 left" in str(broken)
    put, calls = store._put, []

    def dies(array: Any, rows: Any, values: Any) -> None:
        calls.append(array.path)
        if len(calls) == 5:
            raise MemoryError  # in the midst of the results of a batch
        put(array, rows, values)

    with monkeypatch.context() as patched, pytest.raises(MemoryError):
        patched.setattr(store, "_put", dies)
        study(tables(), "kept.zarr", workers=0, batch=2)
    assert "status" not in calls, "results are written before their status"
    again = here()
    assert (again.found, again.computed) == (2, 4) and again.dataset().identical(whole)


def test_a_failed_task_leaves_its_reason_and_the_others_alone() -> None:
    leans = {"task.lean": [0.1, 0.2], "task.method": ["auto", "no_such"]}
    found = here(grid=leans)
    assert sorted(found.failures) == [1, 3] and "no_such" in found.failures[1]
    data = found.dataset()
    assert np.isfinite(data.q.sel({"task.method": "auto"})).all() and np.isnan(data.q.sel({"task.method": "no_such"})).all()
    assert here(grid=leans).computed == 0
    assert study(tables(grid=leans), "kept.zarr", workers=0, retry=True).computed == 2


def test_what_fails_by_chance_is_tried_again(monkeypatch: pytest.MonkeyPatch) -> None:
    from phichain.studies import worker

    tried: list[int] = []

    def chance(resolver: Any, points: Any) -> list[Any]:
        tried.append(len(points))
        if len(tried) == 1:
            return [*worker_computed(resolver, points[1:]), Failure("OSError: a hiccup", False)][::-1]
        return worker_computed(resolver, points)

    worker_computed = worker.computed
    monkeypatch.setattr(worker, "computed", chance)
    assert not here(grid={"task.lean": [0.1, 0.2]}).failures
    assert tried == [1, 1, 1] or tried[1:] == [1]


def test_a_damaged_chunk_is_one_sentence_and_mended_by_the_next_run() -> None:
    whole = here().dataset()
    chunk = next(path for path in Path("kept.zarr/q/c").rglob("*") if path.is_file())
    text = bytearray(chunk.read_bytes())
    text[len(text) // 2] ^= 1
    chunk.write_bytes(text)
    with pytest.raises(StudyError, match="has a chunk of 'q' that cannot be read"):
        open_study("kept.zarr")
    with pytest.warns(StudyWarning, match="6 results that cannot be read"):
        again = here()
    assert again.computed == 6 and again.dataset().identical(whole)


def test_a_store_of_something_else_is_refused(tmp_path: Path) -> None:
    here()
    with pytest.raises(StudyError, match="holds another study, whose study is 'six'"):
        here(name="seven")
    (tmp_path / "other").mkdir()
    for call in (lambda: study(tables(), "other", workers=0), lambda: open_study("other"), lambda: open_study("nowhere")):
        with pytest.raises(StudyError, match="holds no study"):
            call()
    with run._locked(Path("kept.zarr")), pytest.raises(StudyError, match="is written to by another run"):
        here()


def test_a_study_larger_than_the_disk_is_refused_before_it_starts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run.shutil, "disk_usage", lambda path: type("Usage", (), {"free": 100}))
    with pytest.raises(StudyError, match="leaves .* and 100 B are free"):
        here()
    assert not Path("kept.zarr").exists()


def test_netcdf_holds_the_same_numbers(tmp_path: Path) -> None:
    import xarray as xr

    data = here().dataset()
    with xr.open_dataset(write_netcdf(data, tmp_path / "six.nc"), engine="scipy") as read:
        assert np.array_equal(read.q, data.q) and np.array_equal(read.chain_gravity, data["chain.gravity"])


@pytest.mark.long
def test_every_task_agrees_with_its_function() -> None:
    """propagate in one batch, lqr and trace, each against the function called alone."""
    from phichain import lqr, trace
    from phichain.orbits.shooting import NEEDED

    flow = study({"scene": SCENE, "name": "flow", "parameters": {"gravity": 9.81}, "task": {"run": "propagate", "t": 1.0, "points": 3}, "grid": {"task.lean": [0.5, 1.0]}}, workers=0)  # fmt: skip
    data = flow.dataset()
    system = build(with_functions(SCENE, ("propagate_batch",)))
    alone = system.propagate_batch([[1.0]], [[0.0]], 0.0, 1.0, 1e-15, times=[0.0, 0.5, 1.0], p={"gravity": 9.81})
    assert np.array_equal(data.q.sel({"task.lean": 1.0}), alone.q[0]) and np.array_equal(data.q_at.sel({"task.lean": 1.0}), alone.q_at[0])

    family = study({"scene": SCENE, "name": "family", "parameters": {"gravity": 9.81}, "task": {"run": "trace", "amplitude_max": 1.0, "max_points": 40}}, workers=0)
    found = family.dataset()
    branch = trace(build(with_functions(SCENE, NEEDED, True)), 1, 1.0, p={"gravity": 9.81}, limits={"max_points": 40})
    assert int(found["count"]) == len(branch) and np.array_equal(found.omega[: len(branch)], branch.column("omega"))

    pushed = {"name": "pushed", "scene": {**SCENE.to_dict(), "joints": {"actuated": "all"}}, "parameters": {"gravity": 9.81}, "task": {"run": "lqr"}}
    gains = study({**pushed, "grid": {"task.input_weight": [1.0, 4.0]}}, workers=0).dataset()
    scene = plan_of(pushed).scenes[0]
    assert np.array_equal(gains.K.sel({"task.input_weight": 4.0}), lqr(build(scene), [-1], 1.0, 4.0, p={"gravity": 9.81}).K)
