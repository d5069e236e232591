"""Laws on file tried on wrong chains: against a simulation of our own, losses and delays that matter, files, what is refused."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from phichain import build, generate_controller, lqr
from phichain.app.cli import main
from phichain.control import estimator, gain_table, output_law, regulators
from phichain.errors import ArrayError, OutputError, SceneError
from phichain.scene import Scene
from phichain.trials import Disturbed, Runs, law_on_file, law_trials
from tests import tables

M0, M, L, G, T = 0.5, 0.1, 0.2, 9.81, 0.005
POLE = Scene("tried_pole", 1, base="cart", cart_mass=M0, mass=M, length=L, actuated="cart", want=("forward_dynamics", "linearization"))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return generate_controller(lqr(build(POLE), (-1,), sample=T).law(limit=5), tmp_path_factory.mktemp("law"), "double")


def pole(x: np.ndarray, u: float, m: float, c: float) -> list[float]:
    """A point mass on a rod on a cart, a damper in its joint, from the textbook."""
    s, cos = np.sin(x[1]), np.cos(x[1])
    A = np.array([[M0 + m, m * L * cos], [m * L * cos, m * L**2]])
    a = np.linalg.solve(A, [u + m * L * s * x[3] ** 2, -m * G * L * s - c * x[3]])
    return [x[2], x[3], *a]


def test_a_run_is_that_of_the_textbook(folder: Path) -> None:
    """Mass, damper, start, delay and encoder as the record says; the law by its formula; ends and the largest force agree."""
    law = law_on_file(folder)
    wrong = Disturbed({"mass": 0.3}, {"damping": 2e-3}, 0.1, 2 * T, {"theta_1": 0.01})
    found = law_trials(POLE, law, wrong, runs=3, seconds=0.4, hold=0.1, seed=3)
    assert found.error_names == ("mass_1", "damping_1") and np.all(found.errors[:, 1] >= 0) and set(found.late) <= {0, 1, 2}
    K = np.array(lqr(build(POLE), (-1,), sample=T).law(limit=5).gains[0])
    for k in range(3):
        x, queue, largest = found.starts[k].copy(), [0.0] * int(found.late[k]), 0.0
        m, c = M * (1 + found.errors[k, 0]), found.errors[k, 1]
        for _ in range(round(0.5 / T)):
            read = x.copy()
            read[1] = 0.01 * np.floor(x[1] / 0.01 + 0.5)
            queue.append(float(np.clip(-K @ (read - [0, np.pi, 0, 0]), -5, 5)))
            largest = max(largest, abs(queue[-1]))
            u = queue.pop(0)
            x = solve_ivp(lambda t, z, u=u, m=m, c=c: pole(z, u, m, c), (0, T), x, rtol=1e-9, atol=1e-11).y[:, -1]
        assert np.allclose(found.ends[k], x, atol=1e-5) and found.largest[k, 1] == pytest.approx(largest, abs=1e-4)


BALL = Scene("tried_ball", 1, space="spatial", base="cart", cart_mass=M0, mass=M, length=L, want=("forward_dynamics", "linearization"))


def ball(z: np.ndarray, u: np.ndarray, m: float) -> np.ndarray:
    """A point mass on a rod on a cart in the plane, by Newton and the rod's tension: z = (X, q, X', q'), q = e_3 hanging."""
    q, rate = z[2:5], z[7:]
    tension = (G * q[2] - q[:2] @ u / M0 + L * rate @ rate) / (1 / m + q[:2] @ q[:2] / M0)
    cart = (u + tension * q[:2]) / M0
    return np.concatenate([z[5:], cart, (G * np.array([0, 0, 1]) - tension * q / m - np.append(cart, 0)) / L])


@pytest.mark.parametrize("kind", ["state", "observed"])
def test_a_run_in_space_is_that_of_newton(kind: str, tmp_path: Path) -> None:
    """Mass, tilt and delay as the record says; ends agree with the rod's tension integrated by SciPy, and the law holds the ball up."""
    gains = lqr(build(BALL), (-1,), sample=T)
    made = gains.law(limit=5) if kind == "state" else output_law(gains, estimator(gains), limit=5)
    law = law_on_file(generate_controller(made, tmp_path, "double"))
    found = law_trials(BALL, law, Disturbed({"mass": 0.3}, {}, 0.1, 2 * T), runs=2, seconds=0.2, hold=0.1, seed=3)
    for k in range(2):
        x, call = found.starts[k], made if kind == "state" else made.running()
        assert np.all(x[2:4] != 0) and np.linalg.norm(x[2:5]) == pytest.approx(1, abs=1e-15) and x[4] < 0
        z, queue, m = np.concatenate([x[:5], np.zeros(5)]), [np.zeros(2)] * int(found.late[k]), M * (1 + found.errors[k, 0])
        for _ in range(round(0.3 / T)):
            queue.append(call(0.0, np.concatenate([z[:7], np.cross(z[2:5], z[7:])])))
            u = queue.pop(0)
            z = solve_ivp(lambda t, y, u=u, m=m: ball(y, u, m), (0, T), z, rtol=1e-9, atol=1e-11).y[:, -1]
        assert np.allclose(found.ends[k], np.concatenate([z[:7], np.cross(z[2:5], z[7:])]), atol=2e-5)
    long = law_trials(BALL, law, Disturbed({"mass": 0.1}, {}, 0.05, 0.0), runs=8, seconds=5)
    assert long.share == 1.0 and set(np.sign(long.ends[:, 4])) == {-1.0}


def test_what_is_wrong_matters_and_the_interval_is_that_of_the_count(folder: Path) -> None:
    law = law_on_file(folder)
    right = law_trials(POLE, law, Disturbed(spread=0.05), runs=8, seconds=4)
    late = law_trials(POLE, law, Disturbed(spread=0.05, late=60 * T), runs=8, seconds=4)
    assert right.share == 1.0 and late.share < 1.0
    assert right.interval == pytest.approx((0.025 ** (1 / 8), 1.0), rel=1e-9)
    assert np.all(right.settled <= 4.0) and right.digest == POLE.digest and "8 of 8 runs" in str(right)


def test_laws_with_a_memory_and_tables_are_called_as_they_want(tmp_path: Path) -> None:
    system = build(POLE)
    observed = generate_controller(output_law(lqr(system, (-1,), sample=T), estimator(lqr(system, (-1,), sample=T)), limit=5), tmp_path / "a")
    table = generate_controller(gain_table(regulators(system, sample=T), limit=5), tmp_path / "b")
    assert law_trials(POLE, law_on_file(observed), Disturbed(spread=0.02), runs=4, seconds=5).share == 1.0
    hanging = law_trials(POLE, law_on_file(table), Disturbed(spread=0.02), up=(1,), runs=4, seconds=6)
    standing = law_trials(POLE, law_on_file(table), Disturbed(spread=0.002), up=(-1,), runs=4, seconds=5)
    assert abs(np.mean(hanging.starts[:, 1])) < 0.05 and abs(np.mean(standing.starts[:, 1]) - np.pi) < 0.05
    assert standing.share == 1.0
    with pytest.raises(ArrayError, match="no equilibrium of that table"):
        law_trials(POLE, law_on_file(table), Disturbed(), up=(0,), runs=1)


def test_records_files_and_refusals(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene = tmp_path / "tried_pole.toml"
    scene.write_text(POLE.to_toml(), encoding="utf-8")
    files = [str(tmp_path / f"runs.{kind}") for kind in ("csv", "npz", "png")]
    words = ["montecarlo", str(scene), str(folder), "--runs", "6", "--error", "mass=0.1", "--time", "1"]
    with pytest.raises(SystemExit) as ended:
        main([*words, *(word for file in files for word in ("--out", file))])
    assert ended.value.code == 0
    assert "95 % interval" in capsys.readouterr().out
    again = Runs.from_npz(files[1])
    assert len(again.held) == 6 and again.error_names == ("mass_1",) and len(tables.lines(files[0])) == 7
    law = law_on_file(folder)
    with pytest.raises(ArrayError, match="another one"):
        law_trials(replace(POLE, mass=0.2), law, Disturbed(), runs=1)
    with pytest.raises(SceneError, match="no parameter"):
        law_trials(POLE, law, Disturbed({"weight": 0.1}), runs=1)
    with pytest.raises(ArrayError, match="nothing that the law measures"):
        law_trials(POLE, law, Disturbed(resolution={"theta_7": 0.1}), runs=1)
    with pytest.raises(ArrayError, match="is no step in which something is read"):
        law_trials(POLE, law, Disturbed(resolution={"theta_1": -0.1}), runs=1)
    with pytest.raises(ArrayError, match="is no time"):
        law_trials(POLE, law, Disturbed(), seconds=-1.0, runs=1)
    with pytest.raises(ArrayError, match="no delay"):
        law_trials(POLE, law, Disturbed(late=1e3), runs=1)
    with pytest.raises(OutputError, match="no law can be read there"):
        law_on_file(tmp_path)
    edited = tmp_path / "edited"
    edited.mkdir()
    for file in folder.iterdir():
        (edited / file.name).write_bytes(file.read_bytes())
    (edited / "tried_pole_controller.c").write_text("int x;\n")
    with pytest.raises(OutputError, match="was edited"):
        law_on_file(edited)
