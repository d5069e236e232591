"""Families on file: what they hold, and runs that go on from them to the last bit."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from phichain.continuation import Branch
from phichain.errors import ArrayError, OutputError
from phichain.orbits import trace
from tests import tables
from tests.orbits.shot import uniform

UNTIL = "theta_1=1.35"


@pytest.fixture(scope="module")
def whole() -> Branch:
    return trace(uniform(2), until=UNTIL)


def same(a: Branch, b: Branch) -> None:
    for name in ("points", "arclength", "tangent", "residual", "iterations", "energy", "multipliers", "error", "scale"):
        assert np.array_equal(getattr(a, name), getattr(b, name)), name
    assert (a.names, a.status, a.reason, a.regular, a.step, a.mode, a.digest) == (
        b.names, b.status, b.reason, b.regular, b.step, b.mode, b.digest,
    )  # fmt: skip
    assert [event.kind for event in a.events] == [event.kind for event in b.events]
    for one, other in zip(a.events, b.events, strict=True):
        assert np.array_equal(one.z, other.z) and one.index == other.index and one.breaks == other.breaks


@pytest.mark.long
def test_a_family_file_says_what_it_promises(whole: Branch, tmp_path: Path) -> None:
    found = json.loads(whole.to_json(tmp_path / "family.json").read_text())
    assert (found["kind"], found["scene"], found["mode"], found["digest"]) == ("branch", "shot2", 1, uniform(2).digest)
    assert found["status"] == "event" and "theta_1 = 1.35" in found["reason"]
    last = found["points"][-1]
    assert last["start"] == {"q": whole.points[-1, :-1].tolist(), "v": [0.0, 0.0]} and last["start"]["q"][0] == 1.35
    assert last["omega"] == whole.points[-1, -1] and last["energy"] == whole.energy[-1] and last["error"] == whole.error[-1]
    assert last["kappa"] == [[whole.multipliers[-1, 0].real, whole.multipliers[-1, 0].imag]]
    assert [event["kind"] for event in found["events"]] == ["fold amplitude 2", "fold amplitude 2", "odd loss"]
    assert all(event.keys() >= {"breaks", "start", "omega", "kappa", "continues"} for event in found["events"])


def test_files_read_back(whole: Branch, tmp_path: Path) -> None:
    same(Branch.from_json(whole.to_json(tmp_path / "family.json")), whole)
    same(Branch.from_npz(whole.to_npz(tmp_path / "family.npz")), whole)


@pytest.mark.parametrize("name", ["scene", "digest", "method", "name", "reason"])
def test_texts_are_texts(whole: Branch, tmp_path: Path, name: str) -> None:
    path = whole.to_json(tmp_path / "family.json")
    found = json.loads(path.read_text())
    for value in (None, -1, [], ["a"], {}, True):
        path.write_text(json.dumps(found | {name: value}))
        with pytest.raises(OutputError, match=f"its {name} is no text"):
            Branch.from_json(path)


def test_events_are_a_table_of_their_own(whole: Branch, tmp_path: Path) -> None:
    """One row an event in CSV, read back to the last bit, and one in a notebook."""
    rows = list(csv.DictReader(tables.lines(whole.events_to_csv(tmp_path / "events.csv"))))
    assert [row["kind"] for row in rows] == [event.kind for event in whole.events]
    for row, event in zip(rows, whole.events, strict=True):
        assert [float(row[name]) for name in whole.names] == event.z.tolist() and float(row["arclength"]) == event.arclength
        assert (row["breaks"], row["continues"]) == (event.breaks, event.continues)
        assert complex(float(row["multiplier_1_re"]), float(row["multiplier_1_im"])) == event.multipliers[0]
    page = whole._repr_html_()
    assert page.count("<tr>") == 1 + len(whole.events) and "odd loss" in page and f"{whole.events[0].z[0]:.10g}" in page


def test_a_run_goes_on_as_if_it_had_not_ended(whole: Branch, tmp_path: Path) -> None:
    """Cut by its number of points, by a target on the way, and by Ctrl-C: what comes out is the same to the last bit."""
    first = trace(uniform(2), until=UNTIL, limits={"max_points": 12})
    assert first.status == "points" and len(first) == 12 and "was not reached" in first.reason
    same(trace(uniform(2), until=UNTIL, resume=first.to_json(tmp_path / "a.json")), whole)
    shorter = trace(uniform(2), until="theta_1=1.03")
    assert shorter.points[-1, 0] == 1.03
    same(trace(uniform(2), until=UNTIL, resume=shorter), whole)


def test_control_c_leaves_what_there_is(whole: Branch) -> None:
    count = 0

    def impatient(point, step) -> None:
        nonlocal count
        count += 1
        if count == 9:
            raise KeyboardInterrupt

    first = trace(uniform(2), until=UNTIL, progress=impatient)
    assert first.status == "interrupted" and len(first) == 10
    same(trace(uniform(2), until=UNTIL, resume=first), whole)


@pytest.mark.long
def test_gaps_survive_files(tmp_path: Path) -> None:
    branch = trace(uniform(4), 1, until="theta_1=0.4", through=1e-4)
    found = json.loads(branch.to_json(tmp_path / "family.json").read_text())
    (gap,) = found["passages"]
    assert gap["at"] == pytest.approx(0.3363, abs=1e-4) and gap["crossed"] is True
    for copy in (Branch.from_json(tmp_path / "family.json"), Branch.from_npz(branch.to_npz(tmp_path / "family.npz"))):
        assert copy.passages[0].width == branch.passages[0].width and copy.passages[0].is_crossed
        assert np.array_equal(copy.passages[0].z, branch.passages[0].z)


@pytest.mark.long
def test_what_cannot_be_gone_on_with_is_refused(whole: Branch, tmp_path: Path) -> None:
    path = whole.to_json(tmp_path / "family.json")
    text = path.read_text()
    with pytest.raises(ArrayError, match="digest.*of the scene differ its name shot2 there, shot1 here; its coordinates theta_1 and theta_2 there, theta_1 here"):
        trace(uniform(1), resume=path)
    with pytest.raises(ArrayError, match="the scene has that name, but other numbers"):
        trace(replace(uniform(2), digest="another"), resume=path)
    with pytest.raises(ArrayError, match="mode"):
        trace(uniform(2), 2, resume=path)
    with pytest.raises(ArrayError, match="method"):
        trace(uniform(2), method="one harmonic", resume=path)
    for broken in (text[:600], text[:-3], "", "[]", '{"kind": "branch"}', text.replace('"omega"', '"omeg"'), text.replace("1.35", '"x"')):
        path.write_text(broken)
        with pytest.raises(OutputError, match="no branch can be read there") as caught:
            trace(uniform(2), resume=path)
        assert "\n" not in str(caught.value)
    with pytest.raises(OutputError):
        trace(uniform(2), resume=tmp_path / "missing.json")


@pytest.mark.parametrize("until", ["theta_3=1", "height=2", "theta_1", "theta_1=x", "amplitude=-1", {"omega": 0.0}, ("omega",), 3.0])
def test_targets_that_are_none_are_one_typed_error(until) -> None:
    with pytest.raises(ArrayError, match="^until: ") as caught:
        trace(uniform(2), until=until)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("until", "value"),
    [("omega=4.2", lambda b: b.points[-1, -1] - 4.2), ({"energy": 0.5}, lambda b: b.energy[-1] - 0.5), ("amplitude=0.6", None)],
)
def test_the_last_point_lies_on_the_target(until, value) -> None:
    branch = trace(uniform(1), until=until)
    off = branch.points[-1, 0] - 0.6 if value is None else value(branch)
    assert off == 0 if value is None or "omega" in until else abs(off) < 1e-15


def test_a_target_below_the_usual_start_is_reached_from_below() -> None:
    branch = trace(uniform(2), until="theta_1=0.004")
    assert branch.points[-1, 0] == 0.004 and branch.points[0, 0] == 0.002 and len(branch) < 40
