"""phichain response: driven chains on file and in pictures, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from phichain.app.commands.orbits import response as responded
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


def test_a_single_precision_scene_is_driven_in_double(command: Command, tmp_path: Path) -> None:
    """By both methods: the answers of its twin, and on file the scene that was given."""
    chain = PENDULUM.replace('"runtime"', "9.75").replace('name = "one"\n', "")
    (tmp_path / "small.toml").write_text(f'name = "small"\n{chain}[target]\nreal = "float"\nstack_max = 400\n')
    (tmp_path / "twin.toml").write_text(f'name = "twin"\n{chain}')
    for method in ("harmonics", "shooting"):
        for name in ("small", "twin"):
            words = ("--at", 1, "--amplitude", 0.15, "--from", 3, "--to", 3.4, "--method", method, "--out", f"{name}.json")
            answer = command("response", f"{name}.toml", *words)
            assert answer.code == 0 and answer.err.count("in double precision") == answer.err.count("\n") == (name == "small")
        small, twin = (Response.from_json(tmp_path / f"{name}.json") for name in ("small", "twin"))
        assert small.digest == find_scene("small.toml").digest and small.peak.tolist() == twin.peak.tolist()


def test_control_c_leaves_a_file_to_go_on_from_though_more_was_asked_for(command: Command, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """What an event opens is not looked for in a response that was ended before it."""
    (tmp_path / "one.toml").write_text(PENDULUM)
    told = []

    def impatient(said: object, quiet: bool):
        def tell(point: object, step: float) -> None:
            told.append(point)
            if len(told) == 5:
                raise KeyboardInterrupt

        return tell

    with monkeypatch.context() as patch:
        patch.setattr(responded, "ticking", impatient)
        answer = command(*ASKED, "--beyond", 1, "--out", "r.json")
    assert answer.code == 130 and "interrupted" in answer.out, answer.err
    found = Response.from_json(tmp_path / "r.json")
    assert found.status == "interrupted" and len(found) == 6
    assert command(*ASKED, "--out", "whole.json").code == 0
    answer = command(*ASKED, "--resume", "r.json", "--out", "rest.json")
    assert answer.code == 0, answer.err
    whole, rest = (Response.from_json(tmp_path / name) for name in ("whole.json", "rest.json"))
    assert [rest.omega.tolist(), rest.peak.tolist(), rest.multipliers.tolist()] == [whole.omega.tolist(), whole.peak.tolist(), whole.multipliers.tolist()]
    # Another chain's file, other parameters, and one that was cut short: one sentence each, and nothing is written.
    (tmp_path / "other.toml").write_text(PENDULUM.replace("0.05", "0.06"))
    (tmp_path / "cut.json").write_text((tmp_path / "r.json").read_text()[:-400])
    for words, told in (
        (("other.toml", *ASKED[2:], "--resume", "r.json"), "is the digest of that response"),
        ((*ASKED[1:], "--resume", "cut.json"), "no response can be read there"),
        ((*ASKED[1:3], "gravity=9.8", *ASKED[4:], "--resume", "r.json"), "is the gravity of that response"),
        ((*ASKED[1:], "--resume", "r.json", "--beyond", 9), "is none of the response's"),
    ):
        answer = command("response", *words, "--out", "never.json")
        assert answer.code == 2 and told in answer.err and answer.err.count("\n") == 1, answer.err
    assert not (tmp_path / "never.json").exists()


@pytest.mark.long
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
