"""Functions of NAME_casadi.c inside expressions and optimisers, and called from C as CasADi calls them."""

from __future__ import annotations

import ctypes
import shutil
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from phichain.ir.evaluate import evaluate
from phichain.lowering.lower import Lowered
from tests.emit.casadi_scenes import relative_error
from tests.emit.external_scenes import Built

casadi = pytest.importorskip("casadi")
pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler")


def test_functions_work_inside_mx_expressions(build: Callable[[str], Built]) -> None:
    """The gradient of a cost over three steps, by CasADi's reverse mode through our Jacobians."""
    built = build("planar")
    step, energy = built.external("step"), built.external("energy")
    u, start = casadi.MX.sym("u", 6), [0.4, -0.2]
    q, v = casadi.MX(start), casadi.MX.zeros(2)
    for k in range(3):
        q, v = step(0.05, q, v, u[2 * k : 2 * k + 2])
    kinetic, potential = energy(q, v)
    cost = kinetic + potential + 1e-3 * casadi.sumsqr(u)
    gradient = casadi.Function("gradient", [u], [casadi.gradient(cost, u)])
    at = np.linspace(-0.5, 0.7, 6)
    assert relative_error(gradient(at).full().ravel(), _rollout_gradient(built.lowered, at)) < 1e-12


def _rollout_gradient(lowered: Lowered, at: NDArray[np.float64]) -> NDArray[np.float64]:
    u = at + 1e-100j * np.eye(6)
    state: dict[str, Any] = {"q_next": np.array([0.4, -0.2]), "v_next": np.zeros(2)}
    for k in range(3):
        arguments = {"h": 0.05, "q": state["q_next"], "v": state["v_next"], "u": u[:, 2 * k : 2 * k + 2]}
        state = evaluate(lowered.wanted["step"], arguments)
    energy = evaluate(lowered.wanted["energy"], {"q": state["q_next"], "v": state["v_next"]})
    cost = energy["kinetic"] + energy["potential"] + 1e-3 * np.sum(u**2, axis=-1)
    return np.asarray(cost.imag / 1e-100)


def test_an_optimiser_finds_the_torques_that_hold_a_pose(build: Callable[[str], Built]) -> None:
    """A nonlinear program with forward_dynamics as constraint; the answer is the gravity torque."""
    built = build("planar")
    u, pose = casadi.MX.sym("u", 2), [0.7, -1.1]
    acceleration = built.external("forward_dynamics")(pose, [0.0, 0.0], u)
    problem = {"x": u, "f": casadi.sumsqr(u), "g": acceleration}
    quiet = {"print_time": False, "ipopt.print_level": 0, "ipopt.sb": "yes", "ipopt.tol": 1e-12}
    solver = casadi.nlpsol(
        "hold", "ipopt", problem, {**quiet, "ipopt.hessian_approximation": "limited-memory"}
    )
    found = solver(x0=[0.0, 0.0], lbg=0.0, ubg=0.0)["x"].full().ravel()
    assert solver.stats()["success"]
    expected = evaluate(built.lowered.wanted["gravity_torque"], {"q": np.array(pose)})["out"]
    assert relative_error(found, expected) < 1e-9


def test_null_arguments_are_zeros_and_null_results_are_not_written(build: Callable[[str], Built]) -> None:
    built = build("planar")
    library = ctypes.CDLL(str(built.library))
    pointers, real = ctypes.POINTER(ctypes.c_double), ctypes.c_double
    work = (real * 200)()
    for symbol, results in (("planar2_casadi_energy", 2), ("jac_planar2_casadi_energy", 4)):
        function = getattr(library, symbol)
        nothing = (pointers * 4)()
        assert function(nothing, (pointers * results)(), None, work, 0) == 0
    kinetic, potential = real(9.0), real(9.0)
    wanted = (pointers * 2)(None, ctypes.pointer(potential))
    assert library.planar2_casadi_energy((pointers * 2)(), wanted, None, work, 0) == 0
    expected = evaluate(built.lowered.wanted["energy"], {"q": np.zeros(2), "v": np.zeros(2)})
    assert potential.value == pytest.approx(float(expected["potential"]), rel=1e-15)
    assert kinetic.value == 9.0
