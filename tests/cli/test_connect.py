"""`phichain connect`: what it writes, and what it refuses in one sentence."""

from __future__ import annotations

from pathlib import Path

import pytest

from phichain.orbits.connections import Connection
from phichain.scene.library import find_scene
from tests import tables
from tests.cli.conftest import Command


def test_it_writes_what_its_files_are_called(command: Command, tmp_path: Path) -> None:
    answer = command("connect", "planar1", "--out", "one.png", "--out", "one.csv", "--out", "one.npz")
    assert answer.code == 0 and "link 1 +1 turn" in answer.out and answer.out.count("wrote") == 3
    assert (tmp_path / "one.png").read_bytes().startswith(b"\x89PNG")
    assert tables.table(tmp_path / "one.csv")["t"][0] < 0
    assert Connection.from_npz(tmp_path / "one.npz").digest == find_scene("planar1").digest


@pytest.mark.long
def test_a_single_precision_scene_is_searched_in_double(command: Command, tmp_path: Path) -> None:
    """Link by link the motion of its twin, and on file the scene that was given."""
    chain = '[chain]\nlinks = 1\nmass = 0.75\nlength = 0.625\n[functions]\nwant = ["forward_dynamics"]\n'
    (tmp_path / "small.toml").write_text(f'name = "small"\n{chain}[target]\nreal = "float"\nflash_max = 300\n')
    (tmp_path / "twin.toml").write_text(f'name = "twin"\n{chain}')
    for name in ("small", "twin"):
        answer = command("connect", f"{name}.toml", "--out", f"{name}.npz")
        assert answer.code == 0 and answer.err.count("in double precision") == answer.err.count("\n") == (name == "small")
    small, twin = (Connection.from_npz(tmp_path / f"{name}.npz") for name in ("small", "twin"))
    assert small.digest == find_scene("small.toml").digest and small.q.tolist() == twin.q.tolist()


@pytest.mark.long
@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("planar3",), "searched for one and two links"),
        (("planar2", "--turns", "1"), "does not say how far every link turns"),
        (("planar2", "--turns", "a,b"), "is no list of whole numbers"),
        (("planar4_damped_springs",), "one and two links"),
        (("paper_b",), "use"),
        (("planar1", "--out", "one.txt"), "has no suffix that says what to write"),
        (("planar1", "--out", "one.json"), "has no suffix that says what to write"),
    ],
)
def test_what_has_none_is_one_line(command: Command, words: tuple[str, ...], said: str) -> None:
    answer = command("connect", *words)
    assert answer.code == 2 and said in answer.err and len(answer.err.strip().splitlines()) == 1
