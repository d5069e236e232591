"""Ratios, quartiles, skipped peers, and a run that goes on where it stopped."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest

from benchmarks import campaign, clock, contest
from benchmarks.harness import BenchmarkError
from benchmarks.peers import present
from benchmarks.table import Table, write


def samples() -> np.ndarray:
    """Ours takes half of the first peer's time in every round, though the machine slows down by ten on the way."""
    pace = np.array([1.0, 1.0, 10.0, 10.0, 1.0])
    return np.stack([0.5 * pace, pace, 3.0 * pace], axis=1)


def test_ratios_are_formed_round_by_round() -> None:
    ours, first, _ = contest.entries(["a", "b", "c"], ["ours", "peer", "peer"], samples(), [1e-15, 2e-15, 0.0])
    assert ours.ratio is not None and (ours.ratio.low, ours.ratio.median, ours.ratio.high) == (0.5, 0.5, 0.5)
    assert first.ratio is not None and first.ratio.median == 1.0


def test_a_formula_of_ours_in_a_peers_compiler_is_no_yardstick() -> None:
    kinds = ["peer", "hybrid", "ours"]
    found = contest.entries(["peer", "hybrid", "ours"], kinds, samples()[:, [1, 0, 2]], [0.0] * 3)
    assert [e.ratio.median for e in found if e.ratio] == [1.0, 0.5, 3.0]


def test_without_peers_there_is_a_time_and_no_ratio() -> None:
    (only,) = contest.entries(["a"], ["ours"], samples()[:, :1], [0.0])
    assert only.time is not None and only.ratio is None
    row = contest.summary("t", [contest.Work("w", (only,))]).rows[0]
    assert row[2] == "-" and row[3] == "-"


def test_a_larger_error_than_the_peers_is_said() -> None:
    entries = contest.entries(["a", "b"], ["ours", "peer"], samples()[:, :2], [1e-9, 1e-12])
    assert contest.summary("t", [contest.Work("w", tuple(entries))]).rows[0][-1] == "1e-12 (smaller)"


def test_quartiles_are_those_of_the_samples() -> None:
    found = clock.spread(np.arange(1.0, 102.0))
    assert (found.low, found.median, found.high) == (26.0, 51.0, 76.0)
    assert found.text() == "51 [26, 76]"


def test_who_cannot_take_part_is_named_with_the_remedy() -> None:
    def absent() -> contest.Runner:
        raise present.PeerAbsent("heyoka")

    def broken() -> contest.Runner:
        raise ZeroDivisionError

    runners, skipped = contest.gather([("heyoka", absent), ("ours", lambda: contest.Runner("ours", time.time, kind="ours"))])
    assert [r.who for r in runners] == ["ours"]
    assert "pip install heyoka" in skipped[0].note and skipped[0].who == "heyoka"
    assert "skipped" in contest.detail("t", [contest.Work("w", tuple(skipped))]).markdown()
    with pytest.raises(ZeroDivisionError):  # a fault of a bench is no missing peer
        contest.gather([("broken", broken)])


def test_a_missing_peer_says_what_to_install(no_peers: None) -> None:
    with pytest.raises(BenchmarkError, match="mujoco is not installed: pip install mujoco"):
        present.module("benchmarks.peers.mujoco_forward")
    with pytest.raises(BenchmarkError, match="pin is not installed: pip install pin"):
        present.module("pinocchio")
    with pytest.raises(ModuleNotFoundError):
        present.module("benchmarks.no_such_table")


def test_an_interrupted_run_goes_on_and_another_code_starts_anew(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    state = tmp_path / "deep" / "bench.json"
    run = campaign.kept(campaign.begun(False, state), "growth", 2.0, state)
    assert campaign.begun(False, state).seconds == {"growth": 2.0}
    assert campaign.begun(True, state).seconds == {}
    page = campaign.ended(campaign.kept(run, "flows", 3.4, state), ["flows", "growth"], state, tmp_path)
    assert "| [flows](flows.md) | 3 |" in page.read_text() and "| all | 5 |" in page.read_text()
    assert not state.exists()
    campaign.kept(run, "flows", 1.0, state)
    monkeypatch.setattr(campaign, "digest", lambda: "another")
    assert campaign.begun(False, state).seconds == {}


def test_the_head_of_a_file_says_when_with_what_and_how_long(tmp_path: Path) -> None:
    path = write("t", "A table", [Table("x", ("a", "b"), (("1", "2"),))], "make bench", tmp_path, 12.3)
    text = path.read_text()
    assert "by `make bench` in 12 s." in text and "numpy" in text and "heyoka" in text
