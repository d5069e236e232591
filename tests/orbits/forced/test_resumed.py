"""Responses that were broken off and gone on with: to the last bit what they would have been."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from phichain.errors import ArrayError, OutputError
from phichain.orbits import Response, respond
from phichain.orbits.forced import series
from phichain.orbits.harmonics.elimination import Harmonics
from tests.orbits.forced.test_beyond import UP, found, pendulum
from tests.orbits.forced.test_response import driven

ARRAYS = ("omega", "q", "v", "peak", "first", "multipliers", "error", "residual", "arclength")
SHORT = Harmonics(tail=1e-8, most=7)


def same(one: Response, other: Response) -> None:
    """Every number to the last bit, files among them."""
    for name in ARRAYS:
        assert np.array_equal(getattr(one, name), getattr(other, name), equal_nan=True), name
    assert [(event.kind, event.after, event.omega, event.q.tolist(), event.multipliers.tolist()) for event in one.events] == [
        (event.kind, event.after, event.omega, event.q.tolist(), event.multipliers.tolist()) for event in other.events
    ]
    assert (one.status, one.reason, one.name, one.method, one.periods, one.p) == (
        other.status, other.reason, other.name, other.method, other.periods, other.p,
    )  # fmt: skip


class Impatient:
    """Presses Ctrl-C at some point."""

    def __init__(self, after: int) -> None:
        self.left = after

    def __call__(self, point: object, step: float) -> None:
        self.left -= 1
        if self.left == 0:
            raise KeyboardInterrupt


@pytest.mark.long
@pytest.mark.parametrize("links", [1, 2])
@pytest.mark.parametrize("method", ["harmonics", "shooting"])
def test_a_run_that_was_broken_off_goes_on_to_the_last_bit(links: int, method: str, tmp_path: Path) -> None:
    """Before and behind a fold, after a single step, by Ctrl-C and by a limit, and twice in a row."""
    asked: Any = (driven(links), None, 0.1, (3.0, {1: 4.3, 2: 3.9}[links]))
    whole = respond(*asked, method=method)
    fold, other = (event.after for event in whole.located("fold"))
    for after in (1, fold + 1, other):
        part = respond(*asked, method=method, progress=Impatient(after))
        assert part.status == "interrupted" and len(part) == after + 1
        same(respond(*asked, method=method, resume=part.to_json(tmp_path / "part.json")), whole)
    part = respond(*asked, method=method, limits={"max_points": 7})
    assert part.status == "points"
    later = respond(*asked, method=method, resume=part, limits={"max_points": 6})
    assert later.status == "points" and len(later) == 12
    same(respond(*asked, method=method, resume=later.to_json(tmp_path / "part.json")), whole)
    # What has come to its end comes there again, and goes on to another one.
    same(respond(*asked, method=method, resume=whole), whole)
    short = respond(driven(links), None, 0.1, (3.0, 3.5), method=method)
    same(respond(*asked, method=method, resume=short.to_json(tmp_path / "short.json")), whole)


def test_control_c_within_a_step_leaves_nothing_of_it(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """What an unfinished step found would be guessed from."""
    asked: Any = (driven(2), None, 0.1, (3.0, 3.9))
    whole = respond(*asked)
    for call in (90, 91, 92, 93):
        own, left = series.balanced, [call]

        def broken(*given: Any, own: Any = own, left: list[int] = left) -> Any:
            left[0] -= 1
            if left[0] == 0:
                raise KeyboardInterrupt
            return own(*given)

        monkeypatch.setattr(series, "balanced", broken)
        part = respond(*asked)
        monkeypatch.setattr(series, "balanced", own)
        assert part.status == "interrupted" and 2 < len(part) < len(whole)
        same(respond(*asked, resume=part.to_json(tmp_path / "part.json")), whole)


def test_behind_the_seam_where_shooting_goes_on(tmp_path: Path) -> None:
    asked: Any = (driven(1), 1, 0.1, (3.0, 5.0))
    whole = respond(*asked, harmonics=SHORT)
    assert "behind that motions are shot" in whole.reason
    at = whole.checkpoint
    assert at is not None and 0 < at.before < len(whole) - 3
    for after in (at.before - 1, at.before + 1, at.before + 3):
        part = respond(*asked, harmonics=SHORT, progress=Impatient(after))
        assert part.status == "interrupted"
        same(respond(*asked, harmonics=SHORT, resume=part.to_json(tmp_path / "part.json")), whole)


def test_beyond_an_event(tmp_path: Path) -> None:
    """A branch that has lost a symmetry is gone on with as what it is: it ends where the whole one does."""
    first, whole = found()
    number = 1 + [event.kind for event in first.events].index("symmetry breaking")
    part = respond(pendulum(), 1, UP, (1.0, 0.64), beyond=(first, number), progress=Impatient(9))
    assert part.status == "interrupted" and len(part) == 10
    same(respond(pendulum(), 1, UP, (1.0, 0.64), resume=part.to_json(tmp_path / "part.json")), whole)


@pytest.fixture(scope="module")
def part(tmp_path_factory: pytest.TempPathFactory) -> Path:
    begun = respond(driven(1), None, 0.1, (3.2, 3.7), limits={"max_points": 6})
    return begun.to_json(tmp_path_factory.mktemp("part") / "part.json")


def test_what_cannot_be_gone_on_with_is_one_typed_error(part: Path, tmp_path: Path) -> None:
    asked = (3.2, 3.7)
    with pytest.raises(ArrayError, match="is the digest of that response"):
        respond(driven(2), None, 0.1, asked, resume=part)
    with pytest.raises(ArrayError, match="is the amplitude of that response, and 0.2 is wanted here"):
        respond(driven(1), None, 0.2, asked, resume=part)
    with pytest.raises(ArrayError, match="is the method of that response, and 'shooting' is wanted here"):
        respond(driven(1), None, 0.1, asked, method="shooting", resume=part)
    with pytest.raises(OutputError, match="missing.json"):
        respond(driven(1), None, 0.1, asked, resume=tmp_path / "missing.json")
    with pytest.raises(ArrayError, match="does not say where the run stands"):
        respond(driven(1), None, 0.1, asked, resume=Response.from_npz(Response.from_json(part).to_npz(tmp_path / "part.npz")))
    with pytest.raises(ArrayError, match="is no Response"):
        respond(driven(1), None, 0.1, asked, resume=3)
    with pytest.raises(ArrayError, match="is given, and so is resume"):
        respond(driven(1), None, 0.1, asked, resume=part, beyond=(Response.from_json(part), 1))


def test_a_file_that_was_cut_or_changed_is_one_typed_error(part: Path, tmp_path: Path) -> None:
    text, bad = part.read_text(), tmp_path / "bad.json"
    for size in (0, 1, len(text) // 3, len(text) // 2, len(text) - 2):
        bad.write_text(text[:size])
        with pytest.raises(OutputError, match="no response can be read there"):
            respond(driven(1), None, 0.1, (3.2, 3.7), resume=bad)
    for name, change in (
        ("a point fewer", lambda at: at["branch"]["points"].pop()),
        ("a series fewer", lambda at: at["series"].pop()),
        ("another number of harmonics", lambda at: at["memory"][0]["by_z"].pop()),
        ("a Jacobian of another shape", lambda at: at["solved"][0]["jacobian"].pop()),
        ("rows before the first", lambda at: at.update(before=-1)),
        ("a number that is none", lambda at: at["series"][0][0].__setitem__(0, "x")),
        ("nothing", lambda at: at.clear()),
    ):
        found = json.loads(text)
        change(found["checkpoint"])
        bad.write_text(json.dumps(found))
        with pytest.raises(OutputError):
            respond(driven(1), None, 0.1, (3.2, 3.7), resume=bad)
            pytest.fail(name)
