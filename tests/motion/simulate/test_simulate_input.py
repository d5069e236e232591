"""Bad input: one clear typed error each; repairable input: repaired and said."""

from __future__ import annotations

import numpy as np
import pytest

from phichain.errors import ArrayError, ToleranceError, UnsupportedError
from phichain.motion import simulate
from phichain.motion.choose import choose, measure
from phichain.system import AbsentFunctionError, System
from tests.handmade import planar, spatial, uniform_planar

PAIR = uniform_planar(2, actuated="all")


@pytest.mark.parametrize(
    ("arguments", "error", "words"),
    [
        ({"x0": [0.4, 0, 0]}, ArrayError, "x0"),
        ({"x0": [[0.4, 0, 0, 0]]}, ArrayError, "x0"),
        ({"x0": [0.4, np.nan, 0, 0]}, ArrayError, "not finite"),
        ({"x0": [0.4, np.inf, 0, 0]}, ArrayError, "not finite"),
        ({"t": [0.0]}, ArrayError, "no span"),
        ({"t": 0.0}, ArrayError, "monotone"),
        ({"t": [0, 1, 1, 2]}, ArrayError, "monotone"),
        ({"t": [0, 2, 1]}, ArrayError, "monotone"),
        ({"t": [0, np.nan]}, ArrayError, "not finite"),
        ({"tol": 0}, ToleranceError, "positive"),
        ({"tol": -1e-9}, ToleranceError, "positive"),
        ({"tol": np.nan}, ToleranceError, "positive"),
        ({"atol": 0.0}, ToleranceError, "atol"),
        ({"max_steps": 0}, ToleranceError, "max_steps"),
        ({"method": "step"}, ToleranceError, "h: is missing"),
        ({"method": "step", "h": -0.1}, ToleranceError, "h: must be positive"),
        ({"method": "euler"}, UnsupportedError, "DOP853"),
        ({"method": "cvodes"}, UnsupportedError, "no CasADi function"),
        ({"u": [1.0]}, ArrayError, "nu = 2"),
        ({"u": 1.0}, ArrayError, "nu = 2"),
        ({"u": [1.0, np.nan]}, ArrayError, "not finite"),
        ({"u": lambda t, x: np.zeros(3)}, ArrayError, "nu = 2"),
    ],
)
def test_bad_input_is_one_typed_error(arguments, error, words) -> None:
    call = {"x0": [0.4, 0, 0, 0], "t": [0, 1.0], **arguments}
    with pytest.raises(error, match=words) as caught:
        simulate(PAIR, call.pop("x0"), call.pop("t"), **call)
    assert "\n" not in str(caught.value)


def test_input_to_a_chain_without_actuators_is_refused() -> None:
    with pytest.raises(ArrayError, match="no input"):
        simulate(uniform_planar(2), [0.4, 0, 0, 0], 1.0, u=[0.0, 0.0])


def test_a_system_without_dynamics_says_what_to_add() -> None:
    with pytest.raises(AbsentFunctionError, match="forward_dynamics"):
        simulate(uniform_planar(2, leave_out=["forward_dynamics"]), [0.4, 0, 0, 0], 1.0)


def test_a_control_law_is_refused_by_sundials_with_the_way_out() -> None:
    pytest.importorskip("casadi")
    with pytest.raises(UnsupportedError, match="control law.*DOP853"):
        simulate(PAIR, [0.4, 0, 0, 0], 1.0, "cvodes", u=lambda t, x: np.zeros(2))


def test_a_tolerance_below_round_off_is_raised_and_said() -> None:
    run = simulate(uniform_planar(1), [0.4, 0], [0, 0.5], tol=1e-18)
    assert run.tol == pytest.approx(2.2e-14, rel=0.02) and "round-off floor of DOP853" in run.reason
    assert "round-off" not in simulate(uniform_planar(1), [0.4, 0], [0, 0.5], tol=1e-9).reason


BALL = spatial([0.4], [0.5])


@pytest.mark.parametrize(
    ("q", "omega", "words"),
    [
        ([0.0, 0, 0], [0.0, 0, 0], "length 0"),
        ([0.0, 0, 1.00001], [0.0, 0, 0], "no unit vector"),
        ([0.0, 0, 1.0], [1.0, 0, 1e-3], "not tangent"),
    ],
)
def test_states_off_the_manifold_are_refused(q, omega, words) -> None:
    with pytest.raises(ArrayError, match=words):
        simulate(BALL, np.concatenate([q, omega]), 1.0)


def test_states_almost_on_the_manifold_are_projected_and_said() -> None:
    run = simulate(BALL, np.array([0, 0, 1 + 5e-7, 1.0, 0, 4e-7]), 0.1)
    assert run.q[0].tolist() == [0, 0, 1] and run.v[0].tolist() == [1, 0, 0]
    assert "unit vectors were normalised" in run.reason and "projected on the tangent" in run.reason


def test_states_on_the_manifold_are_left_alone() -> None:
    run = simulate(BALL, np.array([0.6, 0, 0.8, 0, 1.0, 0]), 0.1)
    assert "normalised" not in run.reason and np.array_equal(run.x[0], [0.6, 0, 0.8, 0, 1.0, 0])


@pytest.mark.parametrize("leave_out", [[], ["state_jacobian"]])
def test_single_precision_is_neither_stiff_nor_asked_for_digits_it_has_not(leave_out) -> None:
    plain = uniform_planar(2, leave_out=leave_out)
    single = {
        **plain.functions,
        "forward_dynamics": lambda q, v: np.float32(plain.forward_dynamics(np.float32(q), np.float32(v))),
    }
    run = simulate(
        System(**{**plain.__dict__, "functions": single, "real": "float"}), [0.4, 0, 0, 0], [0, 2.0]
    )
    assert run.method == "DOP853" and run.tol == 2e-6 and "floor of single precision" in run.reason
    exact = simulate(plain, [0.4, 0, 0, 0], run.t)
    assert np.max(np.abs(run.q - exact.q)) < 1e-4 and run.counts["steps"] < 200


def test_auto_tells_stiff_from_fast() -> None:
    """Overdamped joints are stiff; an undamped spring of the same rate is only fast; both are said."""
    slow = planar([1.0], [1.0], damping=[1e6])
    stiff = simulate(slow, [0.5, 0.0], [0, 10.0], tol=1e-7)
    assert stiff.method == "Radau" and ": stiff" in stiff.reason and stiff.counts["steps"] < 200
    # theta' = -(g/l) sin(theta) / (d/(m l^2)) once the fast transient of 1 us is over.
    assert stiff.q[-1, 0] == pytest.approx(2 * np.arctan(np.tan(0.25) * np.exp(-9.81e-6 * 10.0)), abs=1e-6)
    fast = simulate(planar([1.0], [1.0], stiffness=[1e4]), [0.5, 0.0], [0, 1.0])
    assert fast.method == "DOP853" and "not stiff" in fast.reason
    assert simulate(slow, [0.5, 0.0], [0, 10.0], tol=1e-2).method == "BDF"
    assert simulate(uniform_planar(2), [0.4, 0, 0, 0], [0, 1.0], tol=1e-2).method == "RK45"


def test_stiffness_without_a_jacobian_is_measured_by_differences() -> None:
    run = simulate(
        planar([1.0], [1.0], damping=[1e4], leave_out=["state_jacobian"]), [0.5, 0.0], [0, 10.0], tol=1e-6
    )
    assert run.method == "Radau" and "differenced Jacobian" in run.reason


def test_auto_takes_cvodes_when_there_is_a_casadi_function() -> None:
    casadi = pytest.importorskip("casadi")
    q, v = casadi.SX.sym("q"), casadi.SX.sym("v")
    graph = casadi.Function("f", [q, v], [-9.81 * casadi.sin(q) - 1e6 * v], ["q", "v"], ["a"])
    plain = planar([1.0], [1.0], damping=[1e6])
    system = System(**{**plain.__dict__, "functions": {**plain.functions, "casadi": lambda: graph}})
    run = simulate(system, [0.5, 0.0], np.linspace(0, 10, 5), tol=1e-9)
    assert run.method == "cvodes" and run.counts["steps"] < 1000
    tight = simulate(plain, [0.5, 0.0], np.linspace(0, 10, 5), "Radau", tol=1e-11)
    assert np.max(np.abs(run.q - tight.q)) < 1e-8


def test_cvodes_with_a_short_budget_brings_back_what_there_is() -> None:
    casadi = pytest.importorskip("casadi")
    q, v, g = casadi.SX.sym("q"), casadi.SX.sym("v"), casadi.SX.sym("gravity")
    graph = casadi.Function("f", [q, v, g], [-g * casadi.sin(q)], ["q", "v", "gravity"], ["a"])
    functions = {"forward_dynamics": lambda q, v, p: -p["gravity"] * np.sin(q), "casadi": graph}
    system = System("c", "planar", "fixed", 1, 1, 1, 0, functions=functions)
    times = np.array([0.0, 1e-3, 2e-3, 10.0])
    run = simulate(system, [0.5, 0.0], times, "cvodes", 1e-12, p={"gravity": 9.81}, max_steps=100)
    assert run.status == "step budget" and "100 steps" in run.reason
    assert run.t.tolist() == [0.0, 1e-3, 2e-3]
    with pytest.raises(UnsupportedError, match="runtime parameter 'gravity'"):
        simulate(system, [0.5, 0.0], times, "cvodes", p={})


def test_measure_sees_the_motion_itself() -> None:
    from phichain.motion.problem import Problem, bind

    system = planar([1.0], [1.0])
    for rate in (0.0, 50.0):
        x0 = np.array([0.1, rate])
        field, jacobian, control, held = bind(system, None, None, 0.0, x0)
        problem = Problem(
            system,
            field,
            jacobian,
            control,
            held,
            None,
            x0,
            np.array([0, 1.0]),
            1e-9,
            1e-11,
            None,
            (),
            10,
            None,
        )
        assert measure(problem).rate == pytest.approx(max(rate, np.sqrt(9.81 * np.cos(0.1))))
        assert choose(problem)[0] == "DOP853"
