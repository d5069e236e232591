"""phichain orbit: an orbit of a saved family on the terminal, on file and in motion, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from tests import tables
from tests.cli.conftest import Command


@pytest.mark.long
def test_an_orbit_of_a_saved_family(command: Command, tmp_path: Path) -> None:
    assert command("trace", "planar1", "--until", "theta_1=2.5", "--out", "f.json", "--out", "f.csv", "--out", "f.png").code == 0
    answer = command("orbit", "f.json", "--at", "theta_1=1.5", *(f"--out=o{kind}" for kind in (".json", ".csv", ".npz", ".png", ".gif", ".html")))
    assert answer.code == 0, answer.err
    found = json.loads((tmp_path / "o.json").read_text())
    # planar1: one link of a metre, its mass in the middle; reference/limit_cycles.json.
    assert found["omega"] == pytest.approx(3.812018988865347, rel=1e-14) and found["start"]["q"] == [1.5]
    assert f"period       {found['period']:.15g} s" in answer.out and "energy       4.558034025819" in answer.out
    assert len(tables.lines(tmp_path / "o.csv")) == 242
    assert (tmp_path / "o.gif").read_bytes().startswith(b"GIF89a") and "<canvas" in (tmp_path / "o.html").read_text()
    for words, says in (
        (("--at", "theta_1=3"), "goes from"), (("--at", "event=1"), "events"), (("--out", "x.pdf"), "gif"),
        (("--scene", "planar2"), "digests differ"), (("--at", "theta_1"), "WHAT=VALUE"),
    ):  # fmt: skip
        refused = command("orbit", "f.json", *words)
        assert refused.code == 2 and refused.err.count("\n") == 1 and says in refused.err, refused.err
    assert command("orbit", "nothing.json").code == 2


def test_a_scene_of_ones_own_is_named(command: Command, tmp_path: Path) -> None:
    cone = '[chain]\nlinks = 1\nspace = "spatial"\nmass = 0.7\nlength = 0.5\n[functions]\nwant = ["forward_dynamics"]\n'
    (tmp_path / "cone.toml").write_text(f'name = "cone"\n{cone}')
    assert command("trace", "cone.toml", "--method", "conical", "--until", "theta_1=1", "--out", "f.json").code == 0
    assert "--scene" in command("orbit", "f.json").err
    answer = command("orbit", "f.json", "--scene", "cone.toml", "--out", "o.json", "--out", "o.gif")
    assert answer.code == 0, answer.err
    found = json.loads((tmp_path / "o.json").read_text())
    assert found["kappa"][0] == pytest.approx([np.cos(2 * np.pi * np.sqrt(1 + 3 * np.cos(1) ** 2)), 0.0], abs=1e-12)


def test_without_matplotlib_a_picture_is_refused_in_one_line(command: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    assert command("trace", "planar1", "--until", "theta_1=1", "--out", "f.json").code == 0
    monkeypatch.setitem(__import__("sys").modules, "matplotlib", None)
    for name in ("o.gif", "o.png"):
        answer = command("orbit", "f.json", "--out", name)
        assert answer.code == 2 and answer.err.count("\n") == 1 and "pip install 'phichain[plot]'" in answer.err
