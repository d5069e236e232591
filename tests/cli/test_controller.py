"""`phichain controller`: every kind of controller from the command line, its self-test, and what it refuses in one line."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import pytest

from tests import tables
from tests.cli.conftest import Command

SCENE = """
name = "rig"
[chain]
links = 1
mass = 0.2
length = 0.4
base = "cart"
cart_mass = 0.5
[functions]
want = ["linearization", "forward_dynamics"]
[target]
real = "float"
"""


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "rig.toml"
    path.write_text(SCENE)
    return path


def selftest(folder: Path) -> int:
    sources = [str(path) for path in folder.glob("*.c")]
    subprocess.run(["cc", "-std=c99", "-O0", "-Wall", "-Werror", *sources, "-lm", "-o", str(folder / "t")], check=True)
    return subprocess.run([str(folder / "t")], check=False).returncode


@pytest.mark.long
@pytest.mark.parametrize(
    ("words", "kind", "said"),
    [
        (["--weight", "theta_1=100"], "controller", "regulator sampled every 0.005 s"),
        (["--poles", "-2,-3,-4+1j,-4-1j"], "controller", "slowest closed-loop eigenvalue -2.00000000"),
        (["--sample", "0.005", "--integral", "x", "--poles", "-2,-3,-4+1j,-4-1j,-5"], "controller", "slowest closed-loop eigenvalue -2 1/s"),
        (["--observer", "kalman", "--resolution", "theta_1=0.003", "--noise", "0.0001"], "controller", "kalman observer from x, theta_1"),
        (["--observer", "reduced", "--measured", "x", "--disturbance", "2"], "controller", "reduced observer from x,"),
        (["--observer", "kalman", "--integral", "x"], "controller", "integrals of x"),
        (["--table", "all", "--leave", "3", "--reach", "0.2"], "gain table", "s = [1]"),
        (["--table", "all", "--poles", "-2,-3,-4+1j,-4-1j"], "gain table", "slowest closed-loop eigenvalue -2.00000000"),
        (["--table", "all", "--observer", "kalman", "--integral", "x"], "output table", "a kalman observer that settles within"),
        (["--table", "all", "--integral", "x", "--poles", "-2,-3,-4+1j,-4-1j,-5"], "output table", "integrals of x"),
    ],
)
def test_controllers_of_every_kind(command: Command, scene: Path, words: list[str], kind: str, said: str) -> None:
    answer = command("controller", scene, "--sample", "0.005", "--limit", "15", *words, "--out", "made")
    assert answer.code == 0, answer.err
    assert said in answer.out and "wrote" in answer.out
    record = json.loads(Path("made/rig_controller/manifest.json").read_text())
    assert record["kind"] == kind and record["real"] == "float" and record["sample"] == 0.005
    assert selftest(Path("made/rig_controller")) == 0


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--observer", "kalman"], "sample: is what an observer needs"),
        (["--sample", "0.005", "--observer", "luenberger"], "observer: is no kind of observer"),
        (["--sample", "0.005", "--observer", "kalman", "--measured", "theta_1"], "measured: do not show the mode"),
        (["--sample", "0.005", "--observer", "kalman", "--noise", "theta_1"], "noise: is no number and no NAME=NUMBER"),
        (["--sample", "0.005", "--observer", "kalman", "--noise", "x=1", "--noise", "x=2"], "noise: names nothing, or something again"),
        (["--noise", "1"], "noise: says something of --observer"),
        (["--leave", "2"], "leave: says something of --table"),
        (["--integral", "x"], "sample: is what integral action needs"),
        (["--sample", "0.005", "--integral", "theta_1"], "integral: cannot be held by force"),
        (["--sample", "0.005", "--integral", "x=a"], "integral: is not NAME=NUMBER"),
        (["--integral", "x", "--table", "all"], "sample: is what integral action needs"),
        (["--sample", "0.005", "--table", "all", "--observer", "kalman", "--measured", "x"], "measured: do not tell"),
        (["--sample", "0.005", "--integral", "x", "--poles", "-1,-2,-3,-4"], "poles: are not as many as states: 5"),
        (["--table", "1;1"], "table: names no equilibrium, or one twice"),
        (["--table", "7"], "up: is no list of links from 1 to 1"),
        (["--poles", "-1,-2"], "poles: are not as many as states: 4"),
        (["--poles", "-1,x"], "poles: is not a list of numbers"),
        (["--weight", "theta_1=0", "--weight", "x=-1"], "Q: must be positive semidefinite"),
        (["--r", "0"], "R: must be positive definite"),
        (["--r", "1e300"], "Q, R: lie beyond what the Riccati equation can be solved for"),
        (["--q", "1e300"], "Q, R: lie beyond what the Riccati equation can be solved for"),
        (["--sample", "0.7"], "sample: is too long: between two samples the mode lambda"),
        (["--weight", "theta=1"], "weight: weighs nothing of this chain"),
    ],
)
def test_bad_words_are_refused_in_one_line(command: Command, scene: Path, words: list[str], said: str) -> None:
    answer = command("controller", scene, *words, "--out", "made")
    assert answer.code == 2 and said in answer.err and answer.err.count("\n") == 1
    assert not Path("made").exists()


def test_regions_of_attraction_and_a_map(command: Command, scene: Path) -> None:
    words = ("attraction", scene, "--sample", "0.005", "--limit", "8", "--t", "3", "--directions", "5")
    answer = command(*words, "--out", "regions.csv", "--out", "regions.npz")
    assert answer.code == 0 and answer.out.count("comes home from") == 2, answer.err
    assert tables.lines("regions.csv")[0] == "s,radius,beyond,usual,late,failed,share,runs"
    for more, said in (
        (["--map", "xi_1,xi_1"], "map: are not two turns"),
        (["--table", "all", "--map", "xi_1,xi_1"], "table: are several equilibria, and a map is of one"),
        (["--t", "0"], "t: must be positive and finite"),
        (["--out", "regions.txt"], "out: has no suffix"),
    ):
        table = [] if "--table" in more else ["--table", "1"]
        answer = command(*words, *table, *more)
        assert answer.code == 2 and said in answer.err and answer.err.count("\n") == 1, answer.err
