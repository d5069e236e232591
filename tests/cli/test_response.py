"""phichain response: driven chains on file and in pictures, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from phichain.orbits import Response
from phichain.scene.library import find_scene
from tests.cli.conftest import Command

PENDULUM = """name = "one"
[chain]
links = 1
mass = 2.0
length = 0.5
gravity = "runtime"
[joints]
damping = 0.05
[functions]
want = ["forward_dynamics"]
"""
ASKED = ("response", "one.toml", "--set", "gravity=9.81", "--at", 1, "--amplitude", 0.15, "--from", 3.5, "--to", 5)


def test_a_response_by_both_methods(command: Command, tmp_path: Path) -> None:
    (tmp_path / "one.toml").write_text(PENDULUM)
    answer = command(*ASKED, "--out", "r.json", "--out", "r.csv", "--out", "r.png")
    assert answer.code == 0, answer.err
    assert "0.15 N m cos(omega t): the torque at joint 1, harmonics" in answer.out and "fold at omega = " in answer.out
    found = json.loads((tmp_path / "r.json").read_text())
    assert found["kind"] == "response" and found["points"][-1]["omega"] == 5 and found["digest"] == find_scene("one.toml").digest
    assert (found["p"], found["tol"]) == ({"gravity": 9.81}, 1e-9)
    assert (tmp_path / "r.png").stat().st_size > 10_000
    assert command(*ASKED, "--method", "shooting", "--out", "s.json").code == 0
    series, shot = (Response.from_json(tmp_path / name).located("fold") for name in ("r.json", "s.json"))
    assert [event.omega for event in series] == pytest.approx([event.omega for event in shot], rel=1e-9)


def test_a_family_by_harmonics(command: Command, tmp_path: Path) -> None:
    answer = command("trace", "planar1", "--method", "harmonics", "--until", "theta_1=1.5", "--out", "f.json")
    assert answer.code == 0, answer.err
    found = json.loads((tmp_path / "f.json").read_text())
    # reference/limit_cycles.json: the frequency of a pendulum of half a metre at 1.5 rad.
    assert found["points"][-1]["omega"] == pytest.approx(3.812018988865347, rel=1e-12) and found["method"] == "harmonics"


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("response", "planar1", "--amplitude", 1), "omega: is missing"),
        (("response", "planar1", "--from", 2, "--to", 3), "amplitude: is missing"),
        (("response", "planar1", "--amplitude", 1, "--from", 2, "--to", 3), "forced: is missing"),
        (("response", "planar1", "--at", 2, "--amplitude", 1, "--from", 2, "--to", 3), "use a joint from 1 to 1"),
        (("response", "paper_b", "--at", "cart", "--amplitude", 1, "--from", 2, "--to", 3), "is spatial"),
        (("trace", "planar1", "--method", "harmonics", "--harmonics", 8), "is even"),
    ],
)
def test_bad_input_is_one_sentence(command: Command, words: tuple[object, ...], told: str) -> None:
    answer = command(*words)
    assert answer.code != 0 and told in answer.err and "Traceback" not in answer.err
