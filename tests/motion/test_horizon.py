"""Forty chaotic runs of 60 s: what they say of their errors, beside the errors that they have.

The references are in binary128, by another library on the dense closed form (`benchmarks/horizon/make_references.py`); the table
of `python -m benchmarks.horizon` has more methods.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from benchmarks.horizon.cases import CASES, TIMES, Case
from benchmarks.horizon.judge import LOOSE, run
from phichain.motion import simulate
from phichain.motion.error import neighbours, rounding, second
from phichain.motion.methods.emitted_flow import EmittedFlow
from phichain.pipeline import build

WAYS = (("taylor", None), ("taylor", LOOSE), ("DOP853", None), ("DOP853", LOOSE))


@pytest.mark.long
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
@pytest.mark.parametrize(("method", "tol"), WAYS, ids=lambda word: str(word))
def test_an_estimate_is_no_less_than_a_tenth_of_the_error_and_no_more_than_a_hundredfold(case: Case, method: str, tol: float | None) -> None:
    found = run(case, method, tol)
    assert np.count_nonzero(found.counts) >= 3
    assert np.min(found.ratio) >= 0.1 and np.max(found.ratio) <= 100
    assert found.unmarked < 1e-2
    assert (found.status == "doubtful") == (found.holds_until < 60.0)


@pytest.fixture
def without_neighbours(monkeypatch: pytest.MonkeyPatch) -> None:
    """Runs as those of a generated folder, whose flow has nothing beside it."""
    monkeypatch.setattr(EmittedFlow, "watch", lambda flow: None)


@pytest.mark.usefixtures("without_neighbours")
@pytest.mark.parametrize("case", CASES[::3], ids=lambda case: case.name)
def test_second_runs_keep_the_bounds_where_no_neighbours_fly_along(case: Case) -> None:
    for tol in (None, LOOSE):
        found = run(case, "taylor", tol)
        assert np.min(found.ratio) >= 0.1 and np.max(found.ratio) <= 100 and found.unmarked < 1e-2


@pytest.mark.parametrize(("method", "tol"), [("taylor", None), ("taylor", 1e-9), ("taylor", LOOSE)], ids=str)
def test_neighbours_alone_judge_the_taylor_flow(method: str, tol: float | None, monkeypatch: pytest.MonkeyPatch) -> None:
    """No second run is flown."""
    monkeypatch.setattr(second, "flown", None)
    monkeypatch.setattr(neighbours, "flown", None)
    assert "by neighbours of its steps" in simulate(build(CASES[0].scene()), CASES[0].x0, TIMES, method, tol).reason


@pytest.mark.usefixtures("without_neighbours")
@pytest.mark.parametrize(("tol", "share"), [(None, 0.75), (LOOSE, 0.75)], ids=["default", "loose"])
def test_a_lost_run_is_not_followed_to_its_end(tol: float | None, share: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Beyond the time where two runs have nothing to do with each other no second one costs anything."""
    flown, spans = second.flown, []

    def watched(problem: Any, t: Any, x: Any, tol: float, budget: int) -> Any:
        spans.append((tol, float(t[-1])))
        return flown(problem, t, x, tol, budget)

    for module in (second, rounding, neighbours):
        monkeypatch.setattr(module, "flown", watched)
    lost = [case for case in CASES if case.name == "uneven_triple"]
    found = run(lost[0], "taylor", tol)
    finest = min(tolerance for tolerance, _ in spans)
    assert 0 < max(end for tolerance, end in spans if tolerance == finest) < share * 60.0
    assert found.holds_until < 20.0 and np.all(found.estimated[-3:] >= 0.5)


def test_directions_are_lines() -> None:
    """What grows most does so either way: neighbours that point against each other have turned into one line."""
    way: Any = type("Way", (), {"measure": staticmethod(lambda off: float(np.max(np.abs(off))))})
    one = np.array([0.6, -0.8])
    assert neighbours._apart(way, one, -one) == neighbours._apart(way, one, one) == 0.0
    assert neighbours._apart(way, one, np.array([0.6, 0.8])) == pytest.approx(1.2)
