"""phichain trace: families on file, targets, runs that go on, and what is refused."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.special import ellipk

from phichain.app.commands.orbits import trace as traced
from phichain.app.commands.orbits.options import amplitude, frequency, progress_line
from phichain.app.commands.orbits.trace import carrying
from phichain.continuation import Branch, Reached
from phichain.orbits import Network, trace
from phichain.pipeline import build
from phichain.scene.library import find_scene
from tests.cli.conftest import Command

PENDULUM = """name = "one"
[chain]
links = 1
mass = 2.0
length = 0.5
gravity = "runtime"
[functions]
want = ["forward_dynamics"]
"""


def test_a_family_ends_on_its_target(command: Command, tmp_path: Path) -> None:
    (tmp_path / "one.toml").write_text(PENDULUM)
    answer = command("trace", "one.toml", "--set", "gravity=9.81", "--until", "theta_1=1.5", "--out", "f.json", "--out", "f.csv", "--out", "f.png")
    assert answer.code == 0, answer.err
    found = json.loads((tmp_path / "f.json").read_text())
    assert found["points"][-1]["start"]["q"] == [1.5] and found["method"] == "shooting"
    # reference/limit_cycles.json: the frequency of a pendulum of half a metre at 1.5 rad.
    assert found["points"][-1]["omega"] == pytest.approx(3.812018988865347, rel=1e-15)
    assert found["digest"] == find_scene("one.toml").digest and found["p"] == {"gravity": 9.81}
    assert (tmp_path / "f.png").stat().st_size > 10_000


def test_a_run_goes_on_where_another_ended(command: Command, tmp_path: Path) -> None:
    straight = command("trace", "planar1", "--until", "omega=4", "--out", "whole.json")
    assert straight.code == 0, straight.err
    assert command("trace", "planar1", "--until", "omega=4", "--max-points", 8, "--out", "part.json").code == 0
    assert command("trace", "planar1", "--until", "omega=4", "--resume", "part.json", "--out", "rest.json").code == 0
    assert (tmp_path / "rest.json").read_text() == (tmp_path / "whole.json").read_text()


@pytest.mark.parametrize("mode", [0, -1, 2])
def test_a_mode_that_does_not_exist_is_refused_with_those_that_do(command: Command, mode: int) -> None:
    answer = command("trace", "planar1", "--mode", mode)
    assert answer.code == 2 and answer.err.count("\n") == 1 and "this chain has the modes 1 .. 1" in answer.err and "Usage" not in answer.err


def test_a_target_never_reached_is_no_failure(command: Command) -> None:
    answer = command("trace", "planar1", "--until", "omega=9", "--max-points", 10)
    assert answer.code == 0 and "omega = 9.0 was not reached" in answer.out


def test_one_harmonic_says_how_far_it_is_off(command: Command, tmp_path: Path) -> None:
    answer = command("trace", "planar1", "--method", "one harmonic", "--until", "amplitude=2", "--out", "f.json")
    assert answer.code == 0, answer.err
    found = json.loads((tmp_path / "f.json").read_text())
    assert found["method"] == "one harmonic" and found["points"][-1]["kappa"] == []
    assert 1e-3 < found["points"][-1]["error"] < 0.1 and found["points"][0]["error"] < 1e-6


CONE = """name = "cone"
[chain]
links = 1
space = "spatial"
mass = 0.7
length = 0.5
[functions]
want = ["forward_dynamics"]
"""


def test_a_spatial_chain_turns_about_the_vertical(command: Command, tmp_path: Path) -> None:
    (tmp_path / "cone.toml").write_text(CONE)
    answer = command("trace", "cone.toml", "--method", "conical", "--until", "theta_1=1", "--out", "f.json")
    assert answer.code == 0, answer.err
    found = json.loads((tmp_path / "f.json").read_text())
    last = found["points"][-1]
    assert found["method"] == "conical" and last["start"]["q"] == pytest.approx([np.sin(1), 0, np.cos(1)], abs=1e-15)
    assert last["omega"] == pytest.approx(np.sqrt(9.81 / (0.5 * np.cos(1))), rel=1e-14)
    assert last["start"]["v"] == pytest.approx(last["omega"] * np.array([-np.sin(1) * np.cos(1), 0, np.sin(1) ** 2]), rel=1e-14)
    refused = command("trace", "planar1", "--method", "conical")
    assert refused.code == 2 and "spatial" in refused.err and refused.err.count("\n") == 1


def test_a_spatial_chain_comes_back_turned(command: Command, tmp_path: Path) -> None:
    """From a conical orbit on, its energy held, to where it swings in a plane: twice as often as a pendulum of that energy."""
    (tmp_path / "cone.toml").write_text(CONE)
    assert command("trace", "cone.toml", "--method", "conical", "--until", "theta_1=0.8", "--out", "f.json").code == 0
    words = ("trace", "cone.toml", "--method", "whirling", "--start", "f.json", "--hold", "energy", "--out", "w.json", "--out", "w.png")
    answer = command(*words)
    assert answer.code == 0, answer.err
    found = json.loads((tmp_path / "w.json").read_text())
    assert found["method"] == "whirling" and found["closing"] == "energy held" and "in a plane at" in answer.out
    amplitude = np.arccos(1 - found["points"][-1]["energy"] / (0.7 * 9.81 * 0.5))
    assert found["points"][-1]["omega"] == pytest.approx(np.pi * np.sqrt(9.81 / 0.5) / ellipk(np.sin(amplitude / 2) ** 2), rel=1e-12)
    orbit = command("orbit", "w.json", "--scene", "cone.toml", "--at", "omega=8.2", "--out", "o.gif")
    assert orbit.code == 0 and "rad about the vertical" in orbit.out, orbit.err
    for more, says in ((("--start", "f.json:99"), "no point"), (("--start", "f.json:event=9"), "events"), ((), "begin at")):
        refused = command("trace", "cone.toml", "--method", "whirling", *more)
        assert refused.code == 2 and refused.err.count("\n") == 1 and says in refused.err, refused.err


def test_control_c_leaves_a_file_to_go_on_from(command: Command, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    told = []

    def impatient(quiet: bool):
        def tell(point, step) -> None:
            told.append(point)
            if len(told) == 5:
                raise KeyboardInterrupt

        return tell

    monkeypatch.setattr(traced, "progress_line", impatient)
    answer = command("trace", "planar1", "--until", "theta_1=1", "--out", "f.json")
    assert answer.code == 130 and "interrupted" in answer.out
    branch = Branch.from_json(tmp_path / "f.json")
    assert branch.status == "interrupted" and len(branch) == 6 and branch.regular == 6


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (("--mode", 3), "mode"),
        (("--method", "guessing"), "method"),
        (("--until", "theta_7=1"), "theta_1"),
        (("--until", "amplitude=1", "--amplitude-max", 2), "amplitude_max"),
        (("--through", -1), "through"),
        (("--resume", "nothing.json"), "nothing.json"),
        (("--start", "q=1; v=0; period=0.1"), "relative residual"),
        (("--start", "q=1; v=0; period=0.1"), "come back more nearly"),
        (("--out", "f.pdf"), "json"),
        (("--step-max", 0), "step_max"),
    ],
)
def test_what_is_refused_is_one_line(command: Command, options: tuple, says: str) -> None:
    answer = command("trace", "planar1", *options)
    assert answer.code == 2 and answer.err.count("\n") == 1 and says in answer.err


def test_a_damped_scene_is_told_what_there_is(command: Command, tmp_path: Path) -> None:
    (tmp_path / "damped.toml").write_text(PENDULUM.replace('"runtime"', "9.81") + "[joints]\ndamping = 0.1\n")
    answer = command("trace", "damped.toml")
    assert answer.code == 2 and "come to rest" in answer.err and answer.err.count("\n") == 1


@pytest.mark.long
def test_a_single_precision_scene_is_followed_in_double(command: Command, tmp_path: Path) -> None:
    """It is said, memory limits of a controller do not count, and the file is that scene's: its orbits are those of its twin."""
    chain = 'links = 2\nmass = [0.75, 0.375]\nlength = [0.625, 0.3125]\ninertia = [0.015625, 0.0]\n[functions]\nwant = ["forward_dynamics"]\n'
    (tmp_path / "small.toml").write_text(f'name = "small"\n[chain]\n{chain}[target]\nreal = "float"\nstack_max = 400\n')
    (tmp_path / "twin.toml").write_text(f'name = "twin"\n[chain]\n{chain}')
    for name in ("small", "twin"):
        answer = command("trace", f"{name}.toml", "--mode", 2, "--until", "amplitude=0.7", "--out", f"{name}.json")
        assert answer.code == 0 and ("single precision" in answer.err) == (name == "small") and answer.err.count("\n") == (name == "small")
    small, twin = (Branch.from_json(tmp_path / f"{name}.json") for name in ("small", "twin"))
    assert small.scene == "small" and small.points.tolist() == twin.points.tolist()
    answer = command("orbit", "small.json", "--scene", "small.toml", "--json")
    assert answer.code == 0 and json.loads(answer.out)
    answer = command("vary", "small.toml", "--parameter", "length[1]", "--at", "amplitude=0.3", "--until", 0.65)
    assert answer.code == 0 and "in double precision" in answer.err
    assert command("trace", "small.toml", "--until", "amplitude=0.1", "--quiet").err == ""


def test_the_scene_that_is_shot_is_the_same_chain() -> None:
    scene = find_scene("planar2")
    other = carrying(scene)
    assert other.variational and {"propagate", "mass_matrix", "energy", *scene.want} == {*other.want}
    assert (other.mass, other.length, other.com, other.angles, other.name) == (
        scene.mass, scene.length, scene.com, scene.angles, scene.name,
    )  # fmt: skip


def test_progress_is_for_terminals(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    assert progress_line() is None
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    assert progress_line(quiet=True) is None
    tell = progress_line()
    assert tell is not None
    tell(Reached(("x", "theta_1", "theta_2", "theta_dot_1", "omega"), np.array([9.0, 0.5, -0.75, 8.0, 3.25]), 2.0), 0.01)
    assert capsys.readouterr().err.endswith("1 points, amplitude 0.7500 rad, omega 3.25 rad/s, arclength 2.0000, step 0.01")


@pytest.mark.long
@pytest.mark.parametrize("method", ["shooting", "one harmonic"])
def test_what_is_told_on_the_way_is_amplitude_and_frequency_in_their_units(method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Against the family itself, of a chain whose frequency is far from 1: unknowns are scaled while a run goes on."""
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    told: list[Reached] = []
    system = build(carrying(replace(find_scene("planar2"), gravity=981.0), method))
    branch = trace(system, 2, until="amplitude=0.5", method=method, progress=lambda point, step: told.append(point))
    assert len(told) == len(branch) - 1 and min(branch.points[:, -1]) > 60
    for point, z in zip(told, branch.points[1:], strict=True):
        assert point.z.tolist() == z.tolist()
        assert amplitude(point) + frequency(point) == f"amplitude {max(abs(z[:-1])):.4f} rad, omega {z[-1]:.5g} rad/s, "


@pytest.mark.long
def test_a_network_is_written_and_gone_on_with(command: Command, tmp_path: Path) -> None:
    """Two links up to a little beyond the odd loss; a family from a point of a file, and one from a state and a period."""
    answer = command("trace", "planar2", "--until", "theta_1=1.1", "--switch", "--max-points", 30, "--out", "n.json", "--out", "n.png")
    assert (tmp_path / "n.png").stat().st_size > 10_000
    assert answer.code == 0 and "opens [1]" in answer.out and "odd about T/4" in answer.out
    network = Network.from_json(tmp_path / "n.json")
    again = command("trace", "planar2", "--until", "theta_1=1.1", "--switch", "--max-points", 30, "--resume", "n.json", "--out", "m.json")
    assert again.code == 0 and (tmp_path / "m.json").read_text() == (tmp_path / "n.json").read_text()
    network.branches[1].to_json(tmp_path / "odd.json")
    started = command("trace", "planar2", "--start", "odd.json:9", "--max-points", 3)
    assert started.code == 0 and "odd about T/4, over a half period, from an orbit: 3 points" in started.out
    typed = command("trace", "planar2", "--start", "q=1,0.21; period=1.7", "--until", "theta_1=1.2", "--max-points", 30)
    assert typed.code == 0 and "theta_1 = 1.2" in typed.out


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (("--switch", "--out", "n.csv"), "no suffix"), (("--switch", "--method", "one harmonic"), "those of shooting"),
        (("--start", "none.json"), "no branch can be read"), (("--start", "q=1,2; period=x"), "not a list of numbers"),
        (("--start", "q=0.9; period=0.3"), "linear mode"), (("--start", "q=0; period=1"), "hangs still"),
    ],
)  # fmt: skip
def test_networks_and_starts_that_are_refused(command: Command, options: tuple, says: str) -> None:
    answer = command("trace", "planar1", *options)
    assert answer.code == 2 and answer.err.count("\n") == 1 and says in answer.err
