"""The Trajectory: what it holds, resampling, files, status and reasons."""

from __future__ import annotations

import csv
import dataclasses

import numpy as np
import pytest

from phichain.errors import ArrayError, ConvergenceError, OutputError
from phichain.motion import Event, Trajectory, simulate
from phichain.pipeline import build
from phichain.scene import Scene
from phichain.system import System
from tests import tables
from tests.handmade import paper_b, planar, spatial, uniform_planar

CONE = (np.array([0.6, 0.0, 0.8]), np.array([0.0, 3.0, 0.0]))


def test_a_trajectory_is_frozen_and_prints_itself() -> None:
    run = simulate(uniform_planar(2), [0.4, 0, 0, 0], 1.0)
    with pytest.raises(dataclasses.FrozenInstanceError):
        run.status = "other"  # type: ignore[misc]
    assert "DOP853" in str(run) and "not stiff" in str(run) and "energy drift" in str(run)


def test_accelerations_are_those_of_the_dynamics() -> None:
    system = uniform_planar(2)
    run = simulate(system, [0.4, 0.1, 0, 0], np.linspace(0, 1, 4))
    assert np.array_equal(run.a, system.forward_dynamics(run.q, run.v))


def test_without_energy_the_record_says_none() -> None:
    run = simulate(planar([1.0], [1.0], leave_out=["energy"]), [0.4, 0], 1.0)
    assert run.energy is None and np.isnan(run.energy_drift)


@pytest.mark.parametrize("kind", ["planar", "spatial"])
def test_resampling_own_steps_is_as_good_as_the_method(kind: str) -> None:
    system = uniform_planar(2) if kind == "planar" else spatial([0.4], [0.5])
    x0 = [0.4, -0.2, 0, 0] if kind == "planar" else np.concatenate(CONE)
    run = simulate(system, x0, [0, 2.0], tol=1e-10).resample(41)
    direct = simulate(system, x0, np.linspace(0, 2.0, 41), tol=1e-13)
    assert np.allclose(run.t, direct.t)
    assert np.max(np.abs(run.x - direct.x)) < 1e-9
    assert run.energy is not None and "resampled" in run.reason


@pytest.mark.parametrize(("kind", "order"), [("planar", 6), ("spatial", 4)])
def test_resampling_a_grid_converges_at_the_stated_order(kind: str, order: int) -> None:
    system = uniform_planar(2) if kind == "planar" else spatial([0.4], [0.5])
    x0 = [0.4, -0.2, 0, 0] if kind == "planar" else np.concatenate(CONE)
    exact = simulate(system, x0, np.linspace(0, 1.0, 151), tol=1e-13)
    errors = []
    for intervals in (40, 80):
        run = simulate(system, x0, np.linspace(0, 1.0, intervals + 1), tol=1e-13).resample(exact.t)
        part = "q" if kind == "planar" else "v"
        errors.append(np.max(np.abs(getattr(run, part) - getattr(exact, part))))
        assert run.energy is None
    assert np.log2(errors[0] / errors[1]) > order - 0.4


def test_resampling_outside_or_at_one_point_is_refused() -> None:
    run = simulate(uniform_planar(1), [0.4, 0], [0, 1.0])
    for times in (1, [0.5, 1.5], [np.nan]):
        with pytest.raises(ArrayError):
            run.resample(times)


def test_a_start_is_a_pair_however_it_is_written() -> None:
    q, v = [0.3, -0.2], [0.5, 0.1]
    right = simulate(uniform_planar(2), [*q, *v], 0.1).x
    for pair in ((q, v), [q, v], [np.array(q), tuple(v)]):
        assert np.array_equal(simulate(uniform_planar(2), pair, 0.1).x, right)
    for none in ([q, 1.0], [[q], [v, q]], [q, v, q]):
        with pytest.raises(ArrayError, match="^(x0|q, v): "):
            simulate(uniform_planar(2), none, 0.1)


def test_npz_round_trip_is_exact(tmp_path) -> None:
    run = simulate(paper_b(), (_hanging(5), _gentle(5)), [0, 0.2], u=[0.1, 0.0], events=lambda t, x: t - 0.1)
    copy = Trajectory.from_npz(run.to_npz(tmp_path / "run.npz"))
    for name in ("t", "q", "v", "a", "u", "kinetic", "potential", "length_error", "tangency_error"):
        assert np.array_equal(getattr(copy, name), getattr(run, name))
    for name in (
        "name",
        "space",
        "method",
        "status",
        "reason",
        "tol",
        "counts",
        "q_names",
        "v_names",
        "u_names",
    ):
        assert getattr(copy, name) == getattr(run, name)
    assert [c.t for c in copy.events] == [c.t for c in run.events] and len(copy.events) == 1
    assert np.max(np.abs(copy.resample(50).q - run.resample(50).q)) < 1e-4


def test_csv_reads_back_exactly(tmp_path) -> None:
    run = simulate(uniform_planar(2, actuated="all"), [0.4, 0, 0, 0], [0, 0.5], u=[0.1, -0.1])
    rows = list(csv.DictReader(tables.lines(run.to_csv(tmp_path / "run.csv"))))
    assert list(rows[0]) == [
        "t",
        "theta_1",
        "theta_2",
        "theta_1_dot",
        "theta_2_dot",
        "u_0",
        "u_1",
        "kinetic",
        "potential",
        "work",
        "loss",
        "error",
    ]
    assert np.array_equal([float(row["theta_2"]) for row in rows], run.q[:, 1])


def test_files_that_cannot_be_written_or_read_are_output_errors(tmp_path) -> None:
    run = simulate(uniform_planar(1), [0.4, 0], [0, 0.1])
    (tmp_path / "other.npz").write_bytes(b"no archive")
    with pytest.raises(OutputError, match="cannot be written"):
        run.to_csv(tmp_path / "other.npz" / "run.csv")
    for name in ("other.npz", "absent.npz"):
        with pytest.raises(OutputError, match="no Trajectory can be read"):
            Trajectory.from_npz(tmp_path / name)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["other.npz"]


@pytest.mark.parametrize("t", [[0, 10.0], np.linspace(0, 10, 30)])
def test_the_budget_returns_what_there_is(t) -> None:
    run = simulate(uniform_planar(2), [0.4, 0, 0, 0], t, max_steps=25)
    assert run.status == "step budget" and "25 steps" in run.reason
    assert 0 < run.t[-1] < 10 and np.all(np.isfinite(run.x))
    whole = simulate(uniform_planar(2), [0.4, 0, 0, 0], run.t if len(run.t) > 2 else [0, 10.0])
    assert np.max(np.abs(whole.x[len(run.t) - 1] - run.x[-1])) < 1e-7


@pytest.mark.parametrize("method", ["auto", "RK45", "Radau", "BDF", "LSODA", "step"])
def test_a_finite_time_blow_up_is_one_message_with_the_time(method: str) -> None:
    """v' = v^2 from v = 1 ends at t = 1."""
    functions = {"forward_dynamics": lambda q, v: v**2, "step": lambda h, q, v: (q + h * v, v + h * v**2)}
    system = System("blow", "planar", "fixed", 1, 1, 1, 0, functions=functions)
    with (
        np.errstate(all="ignore"),
        pytest.raises(ConvergenceError, match="leaves every bound at t = ") as failure,
    ):
        simulate(system, [0.0, 1.0], [0, 2.0], method, 1e-6, h=0.01)
    reached = failure.value.trajectory
    assert failure.value.status == "blow-up"
    assert abs(failure.value.t - 1) < (0.2 if method == "step" else 1e-4)
    assert reached.t[-1] == failure.value.t and np.all(np.isfinite(reached.x))


def test_a_field_of_nan_is_a_blow_up_at_the_start() -> None:
    system = System(
        "nan",
        "planar",
        "fixed",
        1,
        1,
        1,
        0,
        functions={"forward_dynamics": lambda q, v: v * np.nan, "step": lambda h, q, v: (q, v * np.nan)},
    )
    for method in ("auto", "RK45", "Radau", "BDF", "step"):
        with pytest.raises(ConvergenceError, match="t = 0 s"):
            simulate(system, [0.0, 1.0], [0, 2.0], method, h=0.1)


def test_progress_rises_to_one() -> None:
    seen: list[tuple[float, float]] = []
    simulate(uniform_planar(2), [0.4, 0, 0, 0], [1.0, 4.0], progress=lambda done, t: seen.append((done, t)))
    done = [fraction for fraction, _ in seen]
    assert done == sorted(done) and done[-1] == 1 and 5 < len(done) <= 101
    assert seen[-1][1] == 4.0


@pytest.mark.parametrize("method", ["taylor", "RK45"])
def test_progress_is_told_after_every_thousand_steps_however_little_it_is(method: str) -> None:
    seen: list[float] = []
    run = simulate(build(Scene("swinging", 1, mass=1.0, length=1.0, want=("forward_dynamics", "propagate")), prove=False), [0.4, 0.0], [0.0, 1e6], method, max_steps=3000, progress=lambda done, t: seen.append(done))
    assert run.status == "step budget" and len(seen) == 3 and 0 < seen[0] < seen[1] < seen[2] < 0.01


def test_projection_of_outputs_is_asked_for_and_said() -> None:
    x0 = np.concatenate(CONE)
    system = spatial([0.4], [0.5])
    raw = simulate(system, x0, np.linspace(0, 3, 7), "RK45", 1e-5)
    put_back = simulate(system, x0, np.linspace(0, 3, 7), "RK45", 1e-5, project=True)
    assert np.max(np.abs(raw.length_error)) > 1e-9
    assert np.array_equal(raw.length_error, put_back.length_error)
    assert np.max(np.abs(np.linalg.norm(put_back.q, axis=1) - 1)) < 1e-15
    assert np.max(np.abs(np.sum(put_back.q * put_back.v, axis=1))) < 1e-14
    assert "projected on the manifold" in put_back.reason and "projected" not in raw.reason


def test_a_plane_stays_a_plane_exactly() -> None:
    """Started in the e1-e3 plane, nothing ever leaves it, to the last bit (Fig. 2 of the chain on a cart)."""
    run = simulate(paper_b(), (_hanging(5, 0.3), _gentle(5)), [0, 1.0])
    directions, rates = run.q[:, 2:].reshape(-1, 5, 3), run.v[:, 2:].reshape(-1, 5, 3)
    assert np.max(np.abs(run.q[:, 1])) == 0 and np.max(np.abs(directions[..., 1])) == 0
    assert np.max(np.abs(rates[..., [0, 2]])) == 0
    assert run.energy_drift < 1e-10 * abs(run.energy[0])


def test_event_records_are_validated() -> None:
    with pytest.raises(ArrayError, match="direction"):
        Event("e", lambda t, x: t, direction=2)
    with pytest.raises(ArrayError, match="cannot be called"):
        Event("e", 3.0)  # type: ignore[arg-type]


def _hanging(n: int, angle: float = 0.2) -> np.ndarray:
    return np.concatenate([[0, 0], np.tile([np.sin(angle), 0, np.cos(angle)], n)])


def _gentle(n: int) -> np.ndarray:
    return np.concatenate([[0, 0], np.tile([0, 0.5, 0], n)])
