"""The inverse model before the direct one: closed forms, round-off tracking, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from phichain.control import computed_torque, in_phase, tracking_error
from phichain.errors import ArrayError, ControlError, UnsupportedError
from phichain.motion import simulate
from phichain.system import AbsentFunctionError, System
from tests.fractional.chains import chain as dense_chain
from tests.handmade import GRAVITY, paper_b, planar

GRID = np.linspace(0.0, 3.0, 61)


def chain(n: int, **more: object) -> System:
    """Paper A's chain with a torque at every joint and its inverse dynamics by dense formulas."""
    numbers = ([1 / n] * n, [1 / n] * n, [0.5 / n] * n)
    system = dense_chain(*numbers, actuated="all", **more)

    def inverse(q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        return system.mass_matrix(q) @ a + system.coriolis(q, v) + system.gravity_torque(q)

    energy = planar(*numbers, **more).energy
    functions = {**system.functions, "inverse_dynamics": inverse, "energy": energy}
    return System(**{**system.__dict__, "functions": functions})


def test_one_link_needs_the_torque_of_the_book() -> None:
    wanted = in_phase([0.8], 2.0)
    law = computed_torque(chain(1), wanted)
    for t in (0.0, 0.3, 1.7):
        angle, _, acceleration = wanted(t)
        assert law(t, np.zeros(2)) == pytest.approx(
            0.25 * acceleration + GRAVITY * 0.5 * np.sin(angle), rel=1e-15
        )


@pytest.mark.long
@pytest.mark.parametrize("rate", [None, 5.0])
@pytest.mark.parametrize("angles", ["relative", "absolute", "adjacent"])
def test_the_exact_model_follows_to_round_off(rate: float | None, angles: str) -> None:
    system, wanted = chain(3, angles=angles), in_phase([0.5, 0.3, -0.2], 3.0)
    run = simulate(system, wanted(0.0)[:2], GRID, tol=1e-12, u=computed_torque(system, wanted, rate))
    assert tracking_error(wanted, run.t, run.q).max() < 1e-13


def test_the_error_follows_the_tolerance() -> None:
    system, wanted = chain(2), in_phase([0.6, -0.4], 4.0)
    law = computed_torque(system, wanted, 5.0)
    for tol in (1e-5, 1e-8, 1e-11):
        run = simulate(system, wanted(0.0)[:2], GRID, tol=tol, u=law)
        assert tracking_error(wanted, run.t, run.q).max() < tol


def test_an_initial_error_dies_out_critically_damped() -> None:
    # e'' + 2 w e' + w^2 e = 0 from e(0), e'(0) = 0: e(0) (1 + w t) exp(-w t), in every coordinate.
    system, wanted, w = chain(2), in_phase([0.4, 0.3], 3.0), 4.0
    q, v, _ = wanted(0.0)
    off = np.array([0.3, -0.5])
    run = simulate(system, (q - off, v), GRID, tol=1e-12, u=computed_torque(system, wanted, w))
    errors = np.array([wanted(t)[0] for t in GRID]) - run.q
    expected = off * ((1 + w * GRID) * np.exp(-w * GRID))[:, None]
    np.testing.assert_allclose(errors, expected, rtol=0, atol=1e-12)


def test_fed_forward_alone_an_unstable_motion_is_lost_and_computed_torque_keeps_it() -> None:
    # Standing upright is a motion too: an error of 1e-6 rad grows with sqrt(g/r) unless the state is looked at.
    system, wanted = chain(1), in_phase([np.pi], 0.0)
    start = (np.array([np.pi + 1e-6]), np.zeros(1))
    lost = simulate(system, start, GRID, tol=1e-10, u=computed_torque(system, wanted))
    growth = tracking_error(wanted, lost.t, lost.q)
    assert growth[20] == pytest.approx(1e-6 * np.cosh(np.sqrt(GRAVITY / 0.5) * GRID[20]), rel=1e-6)
    kept = simulate(system, start, GRID, tol=1e-10, u=computed_torque(system, wanted, 5.0))
    assert np.all(np.diff(tracking_error(wanted, kept.t, kept.q)) < 0)


def test_the_torques_do_the_work_that_the_energy_shows() -> None:
    system, wanted = chain(2), in_phase([0.7, 0.5], 2.0)
    law = computed_torque(system, wanted)

    def energy(t: float) -> float:
        return float(np.sum(system.energy(*wanted(t)[:2])))

    def power(t: float, _: np.ndarray) -> np.ndarray:
        return np.atleast_1d(law(t, np.zeros(4)) @ wanted(t)[1])

    work = solve_ivp(power, (0.0, 1.0), [0.0], rtol=1e-11, atol=1e-12).y[0, -1]
    assert work == pytest.approx(energy(1.0) - energy(0.0), abs=1e-9)


def test_what_cannot_follow_is_refused() -> None:
    wanted = in_phase([0.1, 0.1], 1.0)
    with pytest.raises(UnsupportedError, match="no joint torques"):
        computed_torque(paper_b(), wanted)
    driven_once = dense_chain([1, 1], [1, 1], actuated=[1])
    with pytest.raises(ControlError, match="leaves 1 of 2 coordinates"):
        computed_torque(driven_once, wanted)
    with pytest.raises(AbsentFunctionError, match="inverse_dynamics"):
        computed_torque(planar([1, 1], [1, 1], actuated="all"), wanted)
    for rate in (0.0, -1.0, float("nan")):
        with pytest.raises(ControlError, match="positive"):
            computed_torque(chain(2), wanted, rate)
    with pytest.raises(ControlError, match="rate: does not hold real numbers"):
        computed_torque(chain(2), wanted, "fast")  # type: ignore[arg-type]
    with pytest.raises(ArrayError, match="no function of time"):
        computed_torque(chain(2), wanted(0.0))  # type: ignore[arg-type]
    for bad in (lambda t: 1.0, lambda t: (*wanted(t)[:2], "rest")):
        with pytest.raises(ArrayError, match="three finite vectors"):
            computed_torque(chain(2), bad)  # type: ignore[arg-type]
    for bad in (
        in_phase([0.1], 1.0),
        lambda t: (wanted(t)[0] * np.nan, *wanted(t)[1:]),
        lambda t: wanted(t)[:2],
    ):
        with pytest.raises(ArrayError, match="three finite vectors"):
            computed_torque(chain(2), bad)
