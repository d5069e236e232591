"""Bad input is answered by one line on stderr and exit code 2, and leaves nothing behind."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from phichain.app.cli import app, main
from tests.cli.conftest import Answer, Command

TABLES = {
    "links": 'name = "a"\n[chain]\nlinks = {}\nmass = 1.0\nlength = 1.0\n',
    "name": 'name = "{}"\n[chain]\nlinks = 1\nmass = 1.0\nlength = 1.0\n',
    "key": 'name = "a"\n[chain]\nlinks = 1\nmass = 1.0\nlength = 1.0\n{} = 1\n',
    "mass": 'name = "a"\n[chain]\nlinks = 2\nmass = {}\nlength = 1.0\n',
    "com": 'name = "a"\n[chain]\nlinks = 2\nmass = 1.0\nlength = 1.0\ncom = {}\n',
    "want": 'name = "a"\n[chain]\nlinks = 2\nmass = 1.0\nlength = 1.0\n[functions]\nwant = ["{}"]\n',
}


def assert_one_line(answer: Answer, says: str) -> None:
    assert answer.code == 2
    assert answer.out == ""
    assert answer.err.startswith("phichain: ") and answer.err.count("\n") == 1, answer.err
    assert "Traceback" not in answer.err
    assert says in answer.err


@pytest.mark.long
@pytest.mark.parametrize(
    ("table", "value", "says"),
    [
        ("links", "0", "links"),
        ("links", "-1", "links"),
        ("links", "2.5", "whole number"),
        ("links", "1000000000", "links"),
        ("name", "9lives", "name"),
        ("name", "while", "name"),
        ("name", "../up", "name"),
        ("name", "a; int main", "name"),
        ("key", "lenght", '"length"'),
        ("mass", "-1.0", "mass"),
        ("mass", "nan", "mass"),
        ("mass", "[1.0]", "mass"),
        ("com", "2.0", "com"),
        ("com", "0.0", "com"),
        ("want", "forward_dynamic", '"forward_dynamics"'),
    ],
)
@pytest.mark.parametrize("verb", ["show", "generate", "build"])
def test_a_bad_scene_is_one_line(command: Command, tmp_path: Path, verb: str, table: str, value: str, says: str) -> None:
    (tmp_path / "bad.toml").write_text(TABLES[table].format(value))
    assert_one_line(command(verb, "bad.toml"), says)
    assert [path.name for path in tmp_path.iterdir()] == ["bad.toml"]


CHAIN = 'name = "a"\n[chain]\nlinks = 2\nmass = 1.0\nlength = 1.0\n'


@pytest.mark.parametrize(
    ("keys", "field", "remedy"),
    [
        ("inertia = [0.1, -0.1]", "chain.inertia: entry 2 is negative (got -0.1)", "use zero or a number above it"),
        ("com = 0", "chain.com: is not positive (got 0)", "a link with inertia may have zero"),
        ("com = [0, 0.5]\ninertia = [0, 0.1]", "chain.com: puts the mass of link 1 on its joint", "give the link an inertia"),
        ('space = "spatial"\n[joints]\narmature = 0.1', "joints.armature: is the inertia of a motor at a joint", 'set space = "planar"'),
        ("[joints]\nfriction = 0.1", "joints.friction: needs the speed v_0", "give joints.friction_speed"),
        ('base = "cart"\ncart_mass = 1.0\ncart_friction = 0.1', "chain.cart_friction: needs the speed v_0", "give joints.friction_speed"),
        ('drive = "acceleration"', "chain.drive: needs a cart, and the base is fixed (got 'acceleration')", 'set base = "cart"'),
        ('base = "moving"\ndrive = "force"', "chain.drive: needs a cart, and the base is moving (got 'force')", 'set base = "cart"'),
        ('base = "moving"\ncart_mass = 1.0', "chain.cart_mass: needs a cart, and the base is moving (got 1.0)", 'set base = "cart"'),
        ('base = "moving"\ncart_damping = 0.1', "chain.cart_damping: needs a cart, and the base is moving (got 0.1)", 'set base = "cart"'),
    ],
)
@pytest.mark.parametrize("words", [("show", "bad.toml"), ("generate", "bad.toml", "--out", "out"), ("simulate", "bad.toml", "--out", "m.csv")], ids=lambda words: words[0])
def test_a_rig_that_cannot_be_is_one_line(command: Command, tmp_path: Path, words: tuple[str, ...], keys: str, field: str, remedy: str) -> None:
    (tmp_path / "bad.toml").write_text(f"{CHAIN}{keys}\n")
    answer = command(*words)
    assert_one_line(answer, field)
    assert remedy in answer.err
    assert [path.name for path in tmp_path.iterdir()] == ["bad.toml"]


def test_an_unknown_scene_names_the_nearest(command: Command) -> None:
    assert_one_line(command("generate", "paper_c"), "did you mean")


def test_an_output_folder_that_is_a_file(command: Command, tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("mine")
    assert_one_line(command("generate", "planar1", "--out", "taken"), "output")
    assert (tmp_path / "taken").read_text() == "mine"


def test_a_missing_compiler(command: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", "no-such-compiler")
    assert_one_line(command("build", "planar1"), "no such C compiler")


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("--q", "1"), "x0"),
        (("--q", "1,two"), "q"),
        (("--v", "0,nan"), "finite"),
        (("--u", "1,2,3"), "u"),
        (("--tol", "0"), "tol"),
        (("--tol", "-1"), "tol"),
        (("--method", "euler"), "method"),
        (("--set", "mass"), "set"),
        (("--t", "nan"), "t"),
        (("--t", "inf"), "t"),
        (("--t", "0"), "t"),
    ],
)
def test_bad_words_for_a_simulation(command: Command, words: tuple[str, str], says: str) -> None:
    answer = command("simulate", "planar2", *words)
    assert_one_line(answer, says)


def test_a_result_with_an_unknown_suffix_is_refused_before_any_work(command: Command, tmp_path: Path) -> None:
    assert_one_line(command("simulate", "planar2", "--out", "motion.xls"), ".csv, .npz, .json, .png")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("scene", ["paper_b", "planar4_damped_springs"])
def test_phi_where_there_is_none(command: Command, scene: str) -> None:
    assert_one_line(command("show", scene, "--phi"), "phi")


def test_a_function_the_scene_does_not_want(command: Command) -> None:
    assert_one_line(command("show", "planar4_forward_only", "--program", "energy"), "energy")


def test_lqr_of_a_scene_that_does_not_want_its_linearization(command: Command) -> None:
    assert_one_line(command("lqr", "planar4_forward_only"), "linearization")


def test_lqr_of_a_chain_without_inputs(command: Command, tmp_path: Path) -> None:
    (tmp_path / "free.toml").write_text(TABLES["want"].format("linearization"))
    assert_one_line(command("lqr", "free.toml"), "input")


@pytest.mark.parametrize("up", ["6", "0", "1,x", "1.5", "some"])
def test_lqr_of_links_that_are_not_there(command: Command, up: str) -> None:
    assert_one_line(command("lqr", "paper_b", "--up", up), "up")


@pytest.mark.parametrize(("option", "value", "says"), [("--q", "-1", "Q"), ("--r", "0", "R"), ("--r", "nan", "R")])
def test_lqr_with_weights_that_are_not_positive(command: Command, option: str, value: str, says: str) -> None:
    assert_one_line(command("lqr", "paper_b", option, value), says)


def test_trace_of_a_mode_that_is_not_there(command: Command) -> None:
    assert_one_line(command("trace", "planar2", "--mode", 3), "mode")


def test_trace_of_a_spatial_chain(command: Command) -> None:
    answer = command("trace", "paper_b", "--method", "shooting")
    assert answer.code == 2 and answer.err.count("\n") == 1 and 'method = "conical"' in answer.err


def test_a_fault_of_ours_keeps_its_traceback(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(word: str) -> None:
        raise RuntimeError("a fault")

    monkeypatch.setattr("phichain.scene.library.find_scene", broken)
    with pytest.raises(RuntimeError, match="a fault"):
        main(["generate", "planar1"])


def test_no_command_hides_its_errors_from_the_shell(tmp_path: Path) -> None:
    environment = {**os.environ, "PHICHAIN_CACHE": str(tmp_path / "cache")}
    done = subprocess.run(
        [sys.executable, "-m", "phichain", "generate", "nowhere.toml"],
        cwd=tmp_path, env=environment, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.count("\n") == 1
    assert app.pretty_exceptions_enable is False
