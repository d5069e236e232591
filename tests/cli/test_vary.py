"""phichain vary: the family on the way to its first orbit, where that ends too early or is ended."""

from __future__ import annotations

from pathlib import Path

import pytest

from phichain.app.commands.orbits import vary as varied
from tests.cli.conftest import Command

CHAIN = 'name = "ending"\n[chain]\nlinks = 1\nmass = 0.75\nlength = 0.625\n[functions]\nwant = ["forward_dynamics"]\n'
ASKED = ("vary", "ending.toml", "--parameter", "gravity", "--until", 8, "--out", "v.json")


@pytest.mark.long
def test_an_orbit_that_the_family_does_not_reach_is_not_replaced(command: Command, tmp_path: Path) -> None:
    """A pendulum is nowhere faster than at rest: its last orbit, at pi, is none of 9 rad/s to hold."""
    (tmp_path / "ending.toml").write_text(CHAIN)
    answer = command(*ASKED, "--at", "omega=9", "--max-points", 20)
    assert answer.code == 2 and answer.err.count("\n") == 1 and "omega = 9.0 was not reached" in answer.err
    assert not (tmp_path / "v.json").exists()


def test_control_c_on_the_way_to_the_orbit_ends_it_all(command: Command, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Where the family was interrupted is not the orbit that was asked for, so that nothing is followed from there."""
    (tmp_path / "ending.toml").write_text(CHAIN)
    told = []

    def impatient(quiet: bool):
        def tell(point, step) -> None:
            told.append(point)
            if len(told) == 5:
                raise KeyboardInterrupt

        return tell

    monkeypatch.setattr(varied, "progress_line", impatient)
    answer = command(*ASKED, "--at", "amplitude=1.25")
    assert answer.code == 130 and "interrupted" in answer.out and "gravity" not in answer.out and len(told) == 5
    assert not (tmp_path / "v.json").exists()
