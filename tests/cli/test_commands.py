"""Every command does what it says, leaves what it promises, and reads the same in a pipe."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import phichain
from phichain.app.cli import app
from phichain.contract.functions import FUNCTIONS, ROWS
from phichain.scene import Scene
from tests import tables
from tests.cli.conftest import Command

VERBS = [
    "show", "generate", "build", "prove", "functions", "simulate", "trace", "vary", "lqr", "controller", "fit", "tour", "info", "figure", "propagation",
    "response", "attraction", "study", "fmu", "schema", "orbit", "connect", "swingup", "climb", "montecarlo",
]  # fmt: skip


def test_help_names_every_command(command: Command) -> None:
    answer = command("--help")
    assert answer.code == 0
    assert [verb for verb in VERBS if f" {verb} " not in answer.out] == []
    assert sorted(info.name or info.callback.__name__ for info in app.registered_commands if info.callback) == sorted(VERBS)


@pytest.mark.parametrize("verb", VERBS)
def test_every_command_explains_itself(command: Command, verb: str) -> None:
    answer = command(verb, "--help")
    assert answer.code == 0
    assert answer.err == ""


def test_the_version_is_the_packages(command: Command) -> None:
    assert command("--version").out == f"phichain {phichain.__version__}\n"


def test_python_m_phichain_is_the_command() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "phichain", "--version"], capture_output=True, text=True, check=True
    )
    assert done.stdout == f"phichain {phichain.__version__}\n"


def test_info_names_compiler_cache_and_packages(command: Command, cache_folder: Path) -> None:
    answer = command("info")
    assert answer.code == 0
    for word in ("python", "numpy", "sympy", "casadi", "compiler", str(cache_folder), "paper_b"):
        assert word in answer.out


def test_info_says_so_when_there_is_no_compiler(command: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", "no-such-compiler")
    answer = command("info")
    assert answer.code == 0
    assert "there is no such C compiler" in answer.out


def test_show_prints_sketch_and_equations(command: Command) -> None:
    answer = command("show", "planar2")
    assert answer.code == 0
    for word in ("joint 2", "torque_2", "\nT = ", "\nV = ", "thetaddot_2", "mass matrix"):
        assert word in answer.out


def test_show_writes_long_chains_out_when_asked(command: Command) -> None:
    short, full = command("show", "planar4").out, command("show", "planar4", "--full").out
    assert "--full" in short and "thetaddot_4" not in short
    assert "thetaddot_4" in full and "\nT = " in full and "mass matrix" in full


def test_show_symbols_has_letters_for_numbers(command: Command) -> None:
    answer = command("show", "planar2", "--symbols")
    assert "l_1*m_2*r_2" in answer.out


def test_show_latex_is_latex(command: Command) -> None:
    answer = command("show", "paper_a_2", "--latex")
    assert answer.code == 0
    assert r"\ddot" in answer.out or r"\theta" in answer.out
    assert r"\cos" in answer.out


def test_show_phi_prints_the_bessel_functions_of_the_balance(command: Command) -> None:
    answer = command("show", "planar2", "--phi")
    assert answer.code == 0
    assert "Phi_2 = " in answer.out and "J1(" in answer.out


def test_show_program_lists_operations(command: Command) -> None:
    answer = command("show", "planar2", "--program", "energy")
    assert answer.code == 0
    assert "energy" in answer.out and "kinetic" in answer.out


def test_generate_writes_a_folder_that_stands_alone(command: Command, tmp_path: Path) -> None:
    answer = command("generate", "planar2", "--out", "some/where")
    folder = tmp_path / "some" / "where" / "planar2"
    assert answer.code == 0 and str(folder) in answer.out
    expected = {"planar2.h", "planar2.c", "planar2_casadi.py", "manifest.json", "README.md", "CMakeLists.txt", "selftest.c"}
    assert {path.name for path in folder.iterdir()} >= expected


def test_build_lists_the_functions_of_the_scene_and_no_others(command: Command) -> None:
    answer = command("build", "planar4_forward_only")
    assert answer.code == 0
    assert "forward_dynamics" in answer.out and "energy" not in answer.out


def test_functions_prints_the_table(command: Command) -> None:
    answer = command("functions")
    assert answer.code == 0
    rows = {line.split()[0]: line for line in answer.out.splitlines()}
    assert list(rows) == list(FUNCTIONS)
    for name, line in rows.items():
        assert line.endswith(f"  {ROWS[name].doc}"), name
    assert re.search(r"^forward_dynamics +q, v, \[u,\] a +all +Accel", rows["forward_dynamics"])
    assert re.search(r"^phi +amplitude, omega, out +planar, undamped +Res", rows["phi"])


def test_functions_of_a_scene_says_what_it_has_not_and_why(command: Command) -> None:
    answer = command("functions", "spatial5_cart_forward_only")
    states = {line.split()[0]: re.split("  +", line)[2] for line in answer.out.splitlines()}
    assert {name for name, state in states.items() if state == "wanted"} == {"forward_dynamics"}
    assert {name for name, state in states.items() if state == "absent"} == {"inverse_and_jacobian", "inverse_dynamics", "phi", "phi_jacobian", "prepare"}
    assert "since spatial joints are not actuated; use" in answer.out


def test_simulate_takes_inputs_over_time_from_a_file(command: Command, tmp_path: Path) -> None:
    (tmp_path / "push.csv").write_text("t,torque_1\n0,0.5\n0.4,-0.5\n1,0\n", encoding="utf-8-sig")  # as spreadsheets do
    held = command("simulate", "planar2", "--t", "1", "--points", "11", "--input", "push.csv", "--out", "m.csv")
    assert held.code == 0 and "energy balance kept to" in held.out and "energy drift" not in held.out
    table = tables.table(tmp_path / "m.csv")
    assert table["torque_1"].tolist() == [0.5] * 4 + [-0.5] * 6 + [0.0] and not table["torque_2"].any()
    assert table["work"][0] == 0.0 and table["work"][-1] != 0.0
    straight = command("simulate", "planar2", "--t", "1", "--points", "11", "--input", "push.csv", "--linear", "--out", "m.csv")
    assert straight.code == 0
    assert tables.table(tmp_path / "m.csv")["torque_1"][2] == pytest.approx(0.0)


@pytest.mark.parametrize(
    ("text", "more", "words"),
    [
        ("t,torque_1\n0,1\n0.5,1\n", (), "ends before the run"),
        ("t,torque_9\n0,1\n1,1\n", (), "is the name of no input"),
        ("time,torque_1\n0,1\n1,1\n", (), "is no header of inputs"),
        ("", (), "is no header of inputs"),
        ("t,torque_1\n0,1\n1\n", (), "does not hold 2 numbers in line 3"),
        ("t,torque_1\n0,1\n1,much\n", (), "does not hold numbers in line 3"),
        ("t,torque_1\n", (), "no list of times"),
        ("t,torque_1\n0,1\n1,1\n", ("--u", "0,0"), "are both given"),
        (None, (), "cannot be read"),
    ],
)
def test_a_file_of_inputs_that_will_not_do_is_one_line(command: Command, tmp_path: Path, text: str | None, more: tuple[str, ...], words: str) -> None:
    if text is not None:
        (tmp_path / "push.csv").write_text(text)
    before = sorted(tmp_path.iterdir())
    answer = command("simulate", "planar2", "--t", "1", "--input", "push.csv", "--out", "m.csv", "--out", "m.png", *more)
    assert answer.code == 2 and words in answer.err and len(answer.err.strip().splitlines()) == 1
    assert sorted(tmp_path.iterdir()) == before


def test_simulate_writes_what_its_files_are_called(command: Command, tmp_path: Path) -> None:
    answer = command(
        "simulate", "planar2", "--t", "1", "--points", "51", "--out", "m.csv", "--out", "m.npz", "--out", "m.png"
    )
    assert answer.code == 0 and "energy drift" in answer.out
    table = tables.table(tmp_path / "m.csv")
    assert table.shape == (51,) and table["theta_1"][0] == 0.5
    assert phichain.Trajectory.from_npz(tmp_path / "m.npz").t[-1] == 1.0
    assert (tmp_path / "m.png").read_bytes().startswith(b"\x89PNG")


def test_simulate_takes_runtime_parameters_and_a_start(command: Command, tmp_path: Path) -> None:
    """A double pendulum of one link's weight: with the second mass tiny, link 1 keeps the simple pendulum's period."""
    values = ("--set", "mass=1,1e-12", "--set", "length=1,1e-3", "--set", "com=1,1e-3", "--set", "gravity=9.81")
    answer = command(
        "simulate", "runtime_double_pendulum", *values, "--q", "1e-4,0", "--v", "0 0",
        "--t", 2.0060666807106474, "--points", 3, "--out", "m.csv",
    )  # fmt: skip
    assert answer.code == 0, answer.err
    table = tables.table(tmp_path / "m.csv")
    np.testing.assert_allclose(table["theta_1"], [1e-4, -1e-4, 1e-4], rtol=1e-6)


@pytest.mark.long
def test_trace_draws_a_family(command: Command, tmp_path: Path) -> None:
    answer = command("trace", "planar1", "--out", "f.csv", "--out", "f.png")
    assert answer.code == 0, answer.err
    assert (tmp_path / "f.png").stat().st_size > 10_000


@pytest.mark.long
def test_lqr_steadies_the_chain_of_paper_b(command: Command, tmp_path: Path) -> None:
    answer = command("lqr", "paper_b", "--up", "none", "--lean", 0.5, "--out", "c.csv", "--out", "c.png")
    assert answer.code == 0, answer.err
    assert "brought back" in answer.out and "not brought back" not in answer.out
    assert len(tables.lines(tmp_path / "c.csv")) == 1 + 2 * (2 + 2 * 5)
    assert (tmp_path / "c.png").stat().st_size > 10_000


@pytest.mark.long
def test_lqr_says_so_when_the_chain_is_too_far_off(command: Command) -> None:
    answer = command("lqr", "planar3_cart", "--lean", 2.5)
    assert answer.code == 0, answer.err
    assert "not brought back" in answer.out


@pytest.mark.long
def test_the_tour_leaves_code_and_a_report_with_all_its_figures(command: Command, tmp_path: Path) -> None:
    answer = command("tour", "--out", "left")
    assert answer.code == 0, answer.err
    report = tmp_path / "left" / "report"
    text = (report / "index.html").read_text()
    shown = re.findall(r'<img src="([^"]+)"', text)
    assert len(shown) == 6 and all((report / name).stat().st_size > 20_000 for name in shown)
    assert (report / "tour.png").stat().st_size > 20_000
    for heading in ("Paper A: four links", "Paper B: five links", "A family of limit cycles", "A controller"):
        assert heading in text and heading in answer.out
    for name in ("paper_a_4", "paper_b"):
        assert (tmp_path / "left" / name / f"{name}.c").exists()
    assert str(tmp_path) not in text


def test_a_scene_file_serves_like_a_bundled_scene(command: Command, tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text(Scene("mine", 1, mass=1.0, length=2.0).to_toml())
    answer = command("generate", "mine.toml")
    assert answer.code == 0
    assert (tmp_path / "generated" / "mine" / "mine.h").exists()
