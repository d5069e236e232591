"""What commands say: for people, as JSON, or nothing; the exit status of a run that ends early; refusals before the work."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from phichain.app import outputs, said
from phichain.origin import plain
from phichain.pipeline import build
from phichain.scene import Scene
from tests.cli.conftest import Command


def test_a_simulation_says_its_end_as_json(command: Command) -> None:
    answer = command("simulate", "planar2", "--t", 1, "--json")
    found = json.loads(answer.out)
    assert answer.code == 0 and found["status"] == "complete" and found["t"] == 1.0
    assert set(found["q"]) == {"theta_1", "theta_2"} and found["holds_until"] == 1.0 and found["counts"]["steps"] > 0
    assert json.loads(command("lqr", "planar2", "--json", "--t", 0.1).out)["K"]["torque_1"]


def test_quiet_is_quiet(command: Command, tmp_path: Path) -> None:
    answer = command("simulate", "planar2", "--t", 1, "--quiet", "--out", "motion.csv")
    assert (answer.code, answer.out, answer.err) == (0, "", "") and (tmp_path / "motion.csv").exists()
    assert command("lqr", "planar2", "--t", 0.1, "--quiet").out == ""


def test_a_run_that_ends_early_has_a_status_of_its_own(command: Command, tmp_path: Path) -> None:
    answer = command("simulate", "planar2", "--t", 100, "--max-steps", 10, "--out", "motion.csv")
    assert answer.code == said.NOT_THERE == 3 and "step budget" in answer.out and "raise --max-steps" in answer.err
    assert (tmp_path / "motion.csv").exists(), "what there is is written"


def test_what_cannot_be_drawn_or_written_is_refused_before_the_work(command: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "motion.csv").mkdir()
    answer = command("simulate", "no_such_scene", "--out", "motion.csv")
    assert answer.code == 2 and "cannot be written there" in answer.err
    monkeypatch.setattr(outputs, "find_spec", lambda name: None)
    answer = command("simulate", "no_such_scene", "--out", "motion.png")
    assert answer.code == 2 and "phichain[plot]" in answer.err


def test_a_bar_is_for_terminals_and_for_what_takes_long(monkeypatch: pytest.MonkeyPatch) -> None:
    with said.bar("run") as tell:
        assert tell is None
    monkeypatch.setattr(said.sys.stderr, "isatty", lambda: True, raising=False)
    monkeypatch.setattr(said, "_PATIENCE", -1.0)
    with said.bar("run") as tell:
        assert tell is not None
        tell(0.5, 1.0)
    with said.bar("run", quiet=True) as tell:
        assert tell is None


def test_numbers_that_are_none_are_null() -> None:
    assert plain({"a": [float("nan"), 1.0], "b": (float("inf"),), "c": 1 + 2j}) == {"a": [None, 1.0], "b": [None], "c": [1.0, 2.0]}


def test_a_family_says_its_events_as_json_and_is_quiet_when_asked(command: Command, tmp_path: Path) -> None:
    answer = command("trace", "planar2", "--until", "theta_1=-1", "--json", "--out", "family.json")
    found = json.loads(answer.out)
    assert answer.code == 0 and found["record"] == "Branch" and found["points"] == len(json.loads((tmp_path / "family.json").read_text())["points"])
    assert found["last"]["theta_1"] == pytest.approx(-1.0, abs=1e-12) and "omega" in found["first"]
    assert all({"kind", "omega", "breaks", "continues"} <= set(event) for event in found["events"])
    assert command("trace", "planar2", "--until", "theta_1=-0.2", "--quiet").out == ""


def test_a_network_says_its_branches_as_json(command: Command) -> None:
    found = json.loads(command("trace", "planar2", "--switch", "--until", "theta_1=-0.3", "--json").out)
    assert found["record"] == "Network" and found["branches"][0]["record"] == "Branch" and found["status"]


def test_a_search_that_is_to_be_quiet_says_nothing_of_its_starts(capsys: pytest.CaptureFixture[str]) -> None:
    from types import SimpleNamespace

    from phichain.app.commands.swingup import progress

    class One(SimpleNamespace):
        def __str__(self) -> str:
            return "start 1: held"

    for quiet in (False, True):
        with progress(2, quiet) as tell:
            tell(One(share=0.5))  # type: ignore[arg-type]
        assert ("start 1: held" in capsys.readouterr().err) is not quiet
    with said.counted("runs", quiet=True) as told:
        told(1, 2)
    assert capsys.readouterr().err == ""


def test_who_waits_is_told_why_and_how_long_at_most(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """In a pipe, too; what is quick says nothing, and nor does what is to be quiet."""
    from threading import Event

    from phichain.app.commands.simulate import _still

    told = Event()
    with said.explained(lambda: "quick"):
        pass
    monkeypatch.setattr(said, "_LONG", 0.0)
    with said.explained(lambda: "quiet", quiet=True):
        pass
    words = lambda: [_still(build(Scene("slow", 1, mass=1.0, length=9.81, want=("forward_dynamics",)), prove=False), ([0.0], [0.0]), 10.0, 500), told.set()][0]
    with said.explained(words):
        assert told.wait(60.0)
    assert capsys.readouterr().err == (
        "phichain: slow is still on its way: its fastest motion at the start is 1 rad/s, 1.6 turns in 10 s, each of which takes steps; "
        "it ends after 500 steps at most (--max-steps), or with Ctrl-C\n"
    )
