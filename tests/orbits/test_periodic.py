"""Orbits that never stand still, and orbits over a whole period: found beyond the events of brake orbits, closed by another integrator."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from phichain.continuation import Branch, Engine, Options, Special, follow, start_on
from phichain.errors import UnsupportedError
from phichain.orbits import (
    half_problem,
    linear_modes,
    quarter_problem,
    reversible_problem,
    trace,
    whole_problem,
)
from phichain.orbits.closed.canonical import frame
from phichain.orbits.closed.states import energy_of, field, gradient
from phichain.system import rhs
from tests.handmade import paper_b
from tests.orbits.shot import uniform

SIZE = 0.4
"""How far from the orbit at rest the branch is entered, rad/s: where it opens, it is as good as singular."""
ENGINE = Engine(options=Options(step=0.01, step_max=0.1, tol=1e-9, max_points=12))


@pytest.fixture(scope="module")
def events() -> Branch:
    return trace(uniform(2), until="theta_1=-1.7")


def beyond(event: Special, make, columns: slice, sign: float, share: float) -> Branch:
    """The branch that a perturbation of the start of an orbit opens: the one that comes back with the sign, and is not the flow."""
    system = uniform(2)
    rest, omega = np.concatenate([event.z[:-1], np.zeros(2)]), event.z[-1]
    map_ = system.propagate(rest[:2], rest[2:], 0.0, share * 2 * np.pi / omega, 1e-16, transition=np.eye(4)).transition
    _, _, vectors = np.linalg.svd((map_ - sign * np.eye(4))[:, columns])
    field = rhs(system)(0.0, rest)
    # Of two null vectors the one across the flow.
    near = vectors[-2:] if columns.start == 2 and sign < 0 else vectors[-1:]
    own = near.T @ np.linalg.svd(np.atleast_2d(field[columns] @ near.T))[2][-1]
    direction = np.zeros(6)
    direction[columns] = own / np.max(np.abs(own))
    # The reference has to move: a little later on the orbit.
    problem = make(system, omega=omega, near=rest + SIZE * direction[:4])
    start = start_on(problem, np.append(rest, [0.0, omega]) + SIZE * direction, direction, ENGINE, fixed=True)
    return follow(problem, start, ENGINE, [])


def closes(z: np.ndarray, share: float, sign: float) -> float:
    field = rhs(uniform(2))
    end = solve_ivp(field, (0, share * 2 * np.pi / z[-1]), z[:4], method="DOP853", rtol=1e-13, atol=1e-13).y[:, -1]
    return float(np.max(np.abs(end - sign * z[:4])))


def test_beyond_the_loss_of_the_brake_orbits_never_stand_still(events: Branch) -> None:
    event = events.located("brake loss")[-1]
    branch = beyond(event, half_problem, slice(2, 4), -1.0, 0.5)
    assert len(branch) == 12 and np.max(np.abs(branch.column("unfolding"))) < 1e-11
    for z in branch.points[::4]:
        assert closes(z, 0.5, -1.0) < 1e-10
        times = np.linspace(0, np.pi / z[-1], 200)
        flow = uniform(2).propagate(z[:2], z[2:4], 0.0, times[-1], 1e-15, times=times)
        slowest = np.min(np.max(np.abs(flow.v_at), axis=1))
        assert slowest > 0.5 * np.max(np.abs(z[2:4]))
    # A pitchfork: omega leaves with the square of the rates.
    rates = np.max(np.abs(branch.points[:, 2:4]), axis=1)
    shift = np.abs(branch.column("omega") - event.z[-1])
    assert np.all(shift[:4] < 2 * rates[:4] ** 2) and np.all(np.diff(rates) > 0)


def test_beyond_the_loss_of_symmetry_the_whole_period_is_needed(events: Branch) -> None:
    branch = beyond(events.located("odd loss")[0], whole_problem, slice(2, 4), 1.0, 0.5)
    assert len(branch) == 12 and np.max(np.abs(branch.column("unfolding"))) < 1e-11
    for z in branch.points[1::4]:
        assert closes(z, 1.0, 1.0) < 1e-9
        assert closes(z, 0.5, -1.0) > 0.1


def test_a_start_at_rest_unfolds_nothing(events: Branch) -> None:
    """A damper does nothing there: such orbits are taken up where they move."""
    z = events.located("unequal brakes")[0].z
    problem = whole_problem(uniform(2), near=np.append(z[:-1], [0.0, 0.0]), omega=z[-1])
    assert not np.any(problem.evaluate(np.append(z[:-1], [0.0, 0.0, 0.0, z[-1]])).jacobian[:, 4])


@pytest.mark.parametrize(("make", "share"), [(half_problem, 0.5), (whole_problem, 1.0)])
def test_a_brake_orbit_is_one_of_these_with_the_same_stability(make, share: float) -> None:
    """Taken up where it hangs straight, with kappa over T/2, and 2 kappa^2 - 1 over T."""
    system = uniform(2)
    branch = trace(system, 1, until="theta_1=0.7")
    z = branch.points[-1]
    end = system.propagate(z[:2], np.zeros(2), 0.0, np.pi / (2 * z[-1]), 1e-16)
    state = np.concatenate([end.q, end.v])
    problem = make(system, near=state, omega=z[-1])
    residual, jacobian, extra = problem.evaluate(np.concatenate([state, [0.0, z[-1]]]))
    assert np.max(np.abs(residual)) < 3e-13
    kappa = branch.multipliers[-1]
    assert extra.multipliers == pytest.approx(kappa if share == 0.5 else 2 * kappa**2 - 1, abs=1e-7)
    assert np.linalg.matrix_rank(jacobian) == 5
    for k in range(6):
        step = 1e-5 * np.eye(6)[k]
        at = np.concatenate([state + 0.01, [0.02, z[-1]]])
        slope = (problem.evaluate(at + step).residual - problem.evaluate(at - step).residual) / 2e-5
        assert problem.evaluate(at).jacobian[:, k] == pytest.approx(slope, abs=2e-6)


def test_energy_is_counted_from_the_hanging_rest() -> None:
    system = uniform(2)
    z = np.array([0.3, -0.2, 0.5, 1.0, 0.0, 4.0])
    problem = half_problem(system, near=z[:4], omega=4.0)
    modes = linear_modes(system)
    rest = quarter_problem(system, omega=modes.omega[0], shape=modes.shapes[:, 0])
    assert problem.energy(np.array([0.3, -0.2, 0.0, 0.0, 0.0, 4.0])) == pytest.approx(rest.energy(np.array([0.3, -0.2, 4.0])))
    assert problem.energy(z) > rest.energy(np.array([0.3, -0.2, 4.0]))


def test_what_has_no_such_orbits_is_refused() -> None:
    with pytest.raises(UnsupportedError, match="equilibrium"):
        whole_problem(uniform(2), near=np.zeros(4), omega=1.0)
    for make in (half_problem, whole_problem):
        with pytest.raises(UnsupportedError, match="space"):
            make(paper_b(), omega=1.0)


@pytest.mark.long
@pytest.mark.parametrize("base", ["fixed", "cart"])
def test_brake_orbits_solve_every_problem_with_fewer_symmetries(base: str) -> None:
    """Three links, with all their kappa: those of P over T/2, and 2 kappa^2 - 1 over T, whatever closes them."""
    more = {"base": "cart", "cart_mass": 0.4} if base == "cart" else {}
    system = uniform(3, **more)
    branch = trace(system, 2, until="amplitude=0.35")
    z, n = branch.points[-1], system.nq
    omega, kappa = z[-1], branch.multipliers[-1]
    end = system.propagate(z[:-1], np.zeros(n), 0.0, np.pi / (2 * omega), 1e-16)
    straight = np.concatenate([end.q, end.v, [0.0, omega]])
    for problem, orbit, wanted in (
        (half_problem(system, omega=omega), straight, kappa),
        (whole_problem(system, omega=omega), straight, 2 * kappa**2 - 1),
        (reversible_problem(system, rests=True, omega=omega), z, 2 * kappa**2 - 1),
        (reversible_problem(system, rests=False, omega=omega), np.append(end.v, omega), 2 * kappa**2 - 1),
    ):
        residual, jacobian, extra = problem.evaluate(orbit)
        assert np.max(np.abs(residual)) < 1e-13
        assert np.sort(extra.multipliers.real) == pytest.approx(np.sort(wanted.real), abs=1e-12)
        assert np.linalg.matrix_rank(jacobian) == len(residual)
        at = orbit + 0.01
        for k, h in enumerate(1e-5 * np.eye(len(orbit))):
            slope = (problem.evaluate(at + h).residual - problem.evaluate(at - h).residual) / 2e-5
            assert problem.evaluate(at).jacobian[:, k] == pytest.approx(slope, abs=2e-6, rel=1e-7)


def test_the_frame_is_canonical_where_the_chain_moves() -> None:
    """A flow between canonical coordinates is symplectic, and the energy's gradient is -J times the flow."""
    system = uniform(2, base="cart", cart_mass=0.4)
    mass = system.mass_matrix(np.array([0.1, 0.5, -0.3]))
    rates = np.array([1.3, -2.1])
    q, v = np.array([0.1, 0.5, -0.3]), np.append(-mass[0, 1:] @ rates / mass[0, 0], rates)
    found = system.propagate(q, v, 0.0, 0.8, 1e-16, transition=np.eye(6))
    out, own = frame(system, None, q, v)
    back = frame(system, None, found.q, found.v)[1]
    map_ = back @ found.transition @ out
    turn = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.eye(2), np.zeros((2, 2))]])
    assert map_.T @ turn @ map_ == pytest.approx(turn, abs=1e-12)
    assert own @ out == pytest.approx(np.eye(4), abs=1e-13)
    slope = gradient(own @ field(system, None, q, v)) @ own @ out
    energy = energy_of(system)
    for k, column in enumerate(out.T):
        ahead, behind = (energy(q + s * column[:3], v + s * column[3:]) for s in (1e-5, -1e-5))
        assert slope[k] == pytest.approx((ahead - behind) / 2e-5, abs=1e-6)
