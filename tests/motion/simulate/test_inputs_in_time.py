"""Inputs in time against exact solutions and chains of flows made by hand: tables, names, limits, laws that sample."""

from __future__ import annotations

import re
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from phichain.control import feedback, lqr
from phichain.motion import Event, Table, simulate
from tests.handmade import planar
from tests.motion.rigs import cart_pole, pair, pendulum, single_cart_pole

ROUND_OFF = 2.0**-52
TORQUES = Table([0.0, 0.25, 0.4, 1.0, 1.5], [0.5, -1.0, 0.3, 2.0, 0.0])
SWING = np.array([0.4, 0.1])
UPRIGHT = np.array([0.0, np.pi - 0.2, 0.0, 0.0])


def chained(u_of: Callable[[float, np.ndarray], float], stops: list[float], x: np.ndarray, system=None) -> np.ndarray:
    """The Taylor flow from stop to stop, what rounding took carried along; u_of is asked at every stop."""
    system = system or pendulum()
    nq, lost = system.nq, None
    for t0, t1 in pairwise(stops):
        found = system.propagate(x[:nq], x[nq:], t0, t1, ROUND_OFF, u=[u_of(t0, x)], lost=lost)
        x, lost = np.concatenate([found.q, found.v]), found.lost
    return x


def balancing() -> Callable[[float, np.ndarray], np.ndarray]:
    return feedback(cart_pole(), lqr(cart_pole(), [-1], np.diag([20.0, 10, 1, 1]), np.eye(1)))


def momentum(run) -> np.ndarray:
    """Of a cart of 1.1 kg with 0.3 kg on 0.5 m: its rate is the force, whatever the link does."""
    return 1.4 * run.v[:, 0] + 0.15 * np.cos(run.q[:, 1]) * run.v[:, 1]


def cart():
    return planar([0.3], [0.5], cart_mass=1.1, actuated="cart")


@pytest.mark.parametrize("method", ["DOP853", "RK45", "Radau", "LSODA"])
def test_a_ramp_gives_a_parabola_of_momentum(method: str) -> None:
    """Force 3 t until 0.7 s, then down to -1 at 2 s: the slope's jump is met exactly, so no step sees it."""
    ramp = Table([0.0, 0.7, 2.0], [0.0, 2.1, -1.0], "linear")
    run = simulate(cart(), [0.0, 0.4, 0.0, 0.0], [0.0, 2.0], method, 1e-9, u=ramp)
    t, late = run.t, np.maximum(run.t - 0.7, 0.0)
    exact = np.where(t < 0.7, 1.5 * t**2, 0.735 + 2.1 * late - 3.1 / 1.3 * late**2 / 2)
    assert 0.7 in t.tolist()
    assert np.max(np.abs(momentum(run) - exact)) < 1e-7
    assert np.allclose(run.u[:, 0], np.where(t < 0.7, 3 * t, 2.1 - 3.1 / 1.3 * late), atol=1e-14)


def test_a_held_table_is_a_chain_of_flows_bit_for_bit() -> None:
    rows = dict(zip(TORQUES.times.tolist(), TORQUES.values[:, 0].tolist(), strict=True))
    exact = chained(lambda t, x: rows[t], TORQUES.times.tolist(), SWING)
    inside = np.linspace(0.0, 1.5, 8)
    for outputs in ([0.0, 1.5], inside):
        run = simulate(pendulum(), SWING, outputs, u=TORQUES)
        assert run.method == "taylor" and np.array_equal(run.x[-1], exact)
    watched = simulate(pendulum(), SWING, inside, u=TORQUES, events=lambda t, x: x[0] + 9.0)
    assert np.max(np.abs(watched.x[-1] - exact)) < 1e-15
    assert run.u[:, 0].tolist() == [rows[TORQUES.times[np.searchsorted(TORQUES.times, t, "right") - 1]] for t in inside]


@pytest.mark.parametrize("method", ["DOP853", "Radau", "rosenbrock", "cvodes", "step"])
def test_other_methods_break_where_the_table_does(method: str) -> None:
    if method == "cvodes":
        pytest.importorskip("casadi")
    exact = simulate(pendulum(), SWING, [0.0, 1.5], u=TORQUES).x[-1]
    run = simulate(pendulum(), SWING, np.linspace(0.0, 1.5, 4), method, 1e-8, u=TORQUES, h=2e-3)
    assert np.max(np.abs(run.x[-1] - exact)) < 1e-6


@pytest.mark.parametrize("method", ["taylor", "rosenbrock"])
def test_a_push_from_the_hanging_rest(method: str) -> None:
    """Where the whole state is zero an error relative to it has no scale; a link with torque 0.5 N m is an exact quadrature."""
    for outputs in ([0.0, 1.0], np.linspace(0.0, 1.0, 5)):
        run = simulate(pendulum(), [0.0, 0.0], outputs, method, 1e-10, u=[0.5])
        energy = 0.8 * 0.6**2 / 2 * run.v[:, 0] ** 2 + 0.8 * 9.81 * 0.6 * (1 - np.cos(run.q[:, 0]))
        assert np.max(np.abs(energy - 0.5 * run.q[:, 0])) < 1e-10 and run.q[-1, 0] > 0.1
    rest = simulate(pendulum(), [0.0, 0.0], [0.0, 1.0], method, 1e-10, u=[0.0])
    assert not rest.x.any()


def test_backwards_through_a_table_returns_to_the_start() -> None:
    there = simulate(pendulum(), SWING, [0.0, 1.5], u=TORQUES)
    back = simulate(pendulum(), there.x[-1], [1.5, 0.0], u=TORQUES)
    assert np.max(np.abs(back.x[-1] - SWING)) < 1e-12


def test_resampling_goes_through_the_breaks() -> None:
    run = simulate(pendulum(), SWING, [0.0, 1.5], u=TORQUES)
    fine = np.linspace(0.0, 1.5, 40)
    direct = simulate(pendulum(), SWING, fine, u=TORQUES)
    again = run.resample(fine)
    assert np.max(np.abs(again.x - direct.x)) < 1e-14 and np.array_equal(again.u, direct.u)
    assert np.allclose(again.work, direct.work, atol=1e-14)


def test_inputs_by_name_are_the_same_as_together() -> None:
    first, second = Table([0.0, 0.3, 1.0], [1.0, -1.0, 0.0]), Table([0.0, 0.6, 1.0], [0.2, 0.5, 0.0])
    together = Table([0.0, 0.3, 0.6, 1.0], [[1.0, 0.2], [-1.0, 0.2], [-1.0, 0.5], [0.0, 0.0]])
    names = pair().u_names
    x0 = [0.3, -0.1, 0.0, 0.2]
    one = simulate(pair(), x0, [0.0, 1.0], u={names[0]: first, names[1]: second})
    other = simulate(pair(), x0, [0.0, 1.0], u=together)
    assert one.method == "taylor" and np.array_equal(one.x, other.x)
    law = simulate(pair(), x0, [0.0, 1.0], "DOP853", 1e-11, u={names[1]: lambda t, x: 0.2 if t < 2 else 9.0, names[0]: 1.0})
    assert np.max(np.abs(law.x[-1] - simulate(pair(), x0, [0.0, 1.0], u=[1.0, 0.2]).x[-1])) < 1e-8
    only = simulate(pair(), x0, [0.0, 1.0], u={names[1]: 0.2})
    assert np.array_equal(only.x, simulate(pair(), x0, [0.0, 1.0], u=[0.0, 0.2]).x)


def test_a_table_may_be_given_as_a_plain_tuple() -> None:
    plain = (TORQUES.times, TORQUES.values)
    assert np.array_equal(simulate(pendulum(), SWING, 1.5, u=plain).x, simulate(pendulum(), SWING, 1.5, u=TORQUES).x)
    straight = simulate(pendulum(), SWING, 1.5, u=(*plain, "linear"))
    assert straight.method == "DOP853" and straight.u[-1] == 0.0


def test_a_sampled_law_ends_where_it_should() -> None:
    """A closure that remembers its last sample ended at x = -165 m with status "complete"; held by `sample` it stands."""
    law = balancing()
    run = simulate(cart_pole(), UPRIGHT, [0.0, 5.0], u=law, sample=0.01)
    assert run.method == "taylor" and run.status == "complete"
    assert run.q[-1].tolist() == pytest.approx([-0.004603, 3.141726], abs=5e-7)
    x = UPRIGHT
    for k in range(500):
        u = law(0.01 * k, x)
        field = lambda t, y, u=u: np.concatenate([y[2:], cart_pole().forward_dynamics(y[:2], y[2:], u)])
        x = solve_ivp(field, (0.0, 0.01), x, "DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
    assert np.max(np.abs(run.x[-1] - x)) < 1e-8
    stops = [0.0 + k * 0.01 for k in range(501)]
    assert np.array_equal(run.x[-1], chained(lambda t, y: law(t, y)[0], stops, UPRIGHT, cart_pole()))
    other = simulate(cart_pole(), UPRIGHT, np.linspace(0.0, 5.0, 3), "DOP853", 1e-11, u=law, sample=0.01)
    assert np.max(np.abs(other.x[-1] - x)) < 1e-8


@pytest.mark.parametrize(("delay", "whole", "part"), [(0.02, 1, 0.0), (0.06, 3, 0.0), (0.013, 0, 0.013), (0.05, 2, 0.01), (9.0, 500, 0)])
def test_a_delay_is_a_chain_of_flows_by_hand(delay: float, whole: int, part: float) -> None:
    """u_k acts from t_k + delay to t_(k+1) + delay; before the first arrives it is zero."""
    period, law = 0.02, balancing()
    x, lost, taken, acting, stops = UPRIGHT, None, [], 0.0, 25
    for k in range(stops):
        start, stop = k * period, (k + 1) * period
        taken.append(float(law(start, x)[0]))
        before, after = acting, taken[k - whole] if k >= whole else 0.0
        for u, t0, t1 in ((before, start, start + part), (after, start + part, stop)):
            if t1 > t0:
                found = cart_pole().propagate(x[:2], x[2:], t0, t1, ROUND_OFF, u=[u], lost=lost)
                x, lost = np.concatenate([found.q, found.v]), found.lost
        acting = after
    run = simulate(cart_pole(), UPRIGHT, [0.0, stops * period], u=law, sample=period, delay=delay)
    assert np.max(np.abs(run.x[-1] - x)) < 1e-14
    until = np.flatnonzero(run.t < delay * (1 - 1e-9))
    assert f"u was sampled every 0.02 s and held, acting {delay:g} s later ([0.0] until then)" in run.reason
    assert np.all(run.u[until] == 0.0) and (delay > 1 or run.u[until[-1] + 1, 0] == pytest.approx(taken[0], rel=1e-12))


def test_a_sampled_law_is_asked_once_a_sample_in_order_and_may_remember() -> None:
    asked: list[float] = []

    def integral(t: float, x: np.ndarray) -> float:
        asked.append(t)
        return [0.01 * len(asked)]

    run = simulate(pendulum(), SWING, np.linspace(0.0, 1.0, 5), u=integral, sample=0.1, events=lambda t, x: x[1])
    assert asked == [0.0 + k * 0.1 for k in range(10)]
    assert run.u[:, 0].tolist() == pytest.approx([0.01, 0.03, 0.06, 0.08, 0.1]) and run.status == "complete"


@pytest.mark.parametrize("method", ["taylor", "rosenbrock", "DOP853"])
def test_single_precision_samples_at_times_that_it_cannot_hold(method: str) -> None:
    law = balancing()
    exact = simulate(cart_pole(), UPRIGHT, [0.0, 0.7], u=law, sample=0.01)
    for outputs, events in ((np.linspace(0.0, 0.7, 8), None), ([0.0, 0.7], None), ([0.0, 0.7], lambda t, x: x[0] - 9.0)):
        run = simulate(single_cart_pole(), UPRIGHT, outputs, method, u=law, sample=0.01, events=events)
        assert run.t[-1] == 0.7 and len(np.unique(run.t)) == len(run.t)
        assert np.max(np.abs(run.x[-1] - exact.x[-1])) < 1e-3 and run.balance_error < 1e-4


def test_limits_saturate_every_kind_of_input() -> None:
    names = pair().u_names
    x0 = [0.3, -0.1, 0.0, 0.2]
    cut = simulate(pair(), x0, 0.5, u=[1.0, -0.3])
    assert np.array_equal(simulate(pair(), x0, 0.5, u=[5.0, -0.3], limit=1.0).x, cut.x)
    assert np.array_equal(simulate(pair(), x0, 0.5, u=[5.0, -2.0], limit=([-1, -0.3], [1.0, 2.0])).x, cut.x)
    by_name = simulate(pair(), x0, 0.5, u=[5.0, -2.0], limit={names[0]: 1.0, names[1]: (-0.3, np.inf)})
    assert np.array_equal(by_name.x, cut.x)
    table = Table([0.0, 1.0], [[5.0, -0.3], [0.0, 0.0]])
    assert np.array_equal(simulate(pair(), x0, 0.5, u=table, limit=1.0).x, cut.x)
    sampled = simulate(pair(), x0, [0.0, 0.5], u=lambda t, x: [7.0, -0.3], sample=0.5, limit=1.0)
    assert np.array_equal(sampled.x[-1], cut.x[-1])
    law = simulate(pair(), x0, 0.5, "DOP853", 1e-11, u=lambda t, x: [7.0, -0.3], limit=1.0)
    assert np.max(np.abs(law.x[-1] - cut.x[-1])) < 1e-8
    assert np.all(law.u == [1.0, -0.3])


def test_a_line_through_a_limit_breaks_where_it_meets_it() -> None:
    """4 t cut at 1: the momentum is 2 t^2 until 0.25 s and grows by 1 a second after."""
    run = simulate(cart(), [0.0, 0.4, 0.0, 0.0], [0.0, 1.0], u=Table([0.0, 1.0], [0.0, 4.0], "linear"), limit=1.0, tol=1e-11)
    assert 0.25 in run.t.tolist()
    assert momentum(run)[-1] == pytest.approx(0.125 + 0.75, abs=1e-10)


def test_before_the_first_sample_arrives_the_input_is_as_near_to_zero_as_limits_let_it() -> None:
    run = simulate(pendulum(), SWING, [0.0, 0.3], u=lambda t, x: [0.7], sample=0.1, delay=0.1, limit=(0.5, 0.6))
    assert run.u[0, 0] == 0.5 and run.u[-1, 0] == 0.6


@pytest.mark.parametrize("method", ["taylor", "DOP853", "step"])
def test_events_across_breaks_are_found_once(method: str) -> None:
    at_break = Event("at a break", lambda t, x: t - 0.4)
    beside = Event("beside it", lambda t, x: t - 0.4 - 1e-9)
    turned = Event("turned", lambda t, x: x[1])
    run = simulate(pendulum(), SWING, [0.0, 1.5], method, 1e-11, u=TORQUES, events=[at_break, beside, turned], h=1e-3)
    assert [crossing.t for crossing in run.events if crossing.name != "turned"] == pytest.approx([0.4, 0.4 + 1e-9], abs=1e-15)
    fine = simulate(pendulum(), SWING, np.linspace(0.0, 1.5, 40001), u=TORQUES)
    turns = np.flatnonzero(fine.v[:-1, 0] * fine.v[1:, 0] < 0)
    found = [crossing.t for crossing in run.events if crossing.name == "turned"]
    assert len(found) == len(turns) > 1
    assert np.all((fine.t[turns] - 1e-4 < found) & (found < fine.t[turns + 1] + 1e-4))


def test_a_terminal_event_in_a_later_leg_ends_the_run() -> None:
    def later(t: float, x: np.ndarray) -> float:
        return t - 0.73

    later.terminal = True
    run = simulate(pendulum(), SWING, [0.0, 1.5], u=TORQUES, events=later)
    assert run.status == "event" and run.t[-1] == pytest.approx(0.73, abs=1e-14) and run.u[-1, 0] == 0.3


def test_the_step_budget_counts_over_all_legs() -> None:
    run = simulate(pendulum(), SWING, np.linspace(0.0, 1.5, 4), u=lambda t, x: [0.1], sample=0.01, max_steps=40)
    assert run.status == "step budget" and run.counts["steps"] == 40 and run.t[-1] == pytest.approx(0.4)


def test_progress_over_legs_rises_to_one() -> None:
    seen: list[float] = []
    simulate(pendulum(), SWING, [0.0, 1.5], u=TORQUES, progress=lambda done, t: seen.append(done))
    assert seen == sorted(seen) and seen[-1] == 1.0


def test_the_page_on_inputs_works(capsys: pytest.CaptureFixture[str]) -> None:
    page = (Path(__file__).parents[3] / "docs" / "inputs.md").read_text()
    (code,) = re.findall(r"^```python\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    exec(compile(code, "inputs.md", "exec"), {})  # noqa: S102 - our own page
    assert capsys.readouterr().out.count("energy balance kept to") == 2
