"""Brake orbits by shooting, against elliptic integrals, quadrature, reference orbits and whole monodromy matrices."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import mpmath
import numpy as np
import pytest
from scipy.special import ellipkm1

from phichain.continuation import Options
from phichain.errors import UnsupportedError
from phichain.orbits import linear_modes, quarter_problem, trace
from tests.handmade import uniform_planar
from tests.orbits.shot import uniform

CYCLES = json.loads((Path(__file__).parents[1] / "data" / "limit_cycles.json").read_text())["points"]


def test_one_link_is_the_elliptic_integral_up_to_3_1_rad() -> None:
    """omega = pi omega_0 / (2 K(sin(A/2))) in 40 digits; the error that is printed holds."""
    branch = trace(uniform(1), until="theta_1=3.1")
    assert branch.method == "shooting" and branch.points[-1, 0] == 3.1
    with mpmath.workdps(40):
        exact = [
            mpmath.pi * mpmath.sqrt(mpmath.mpf(9.81) / 0.5) / (2 * mpmath.ellipk(mpmath.sin(mpmath.mpf(a) / 2) ** 2))
            for a in branch.points[:, 0].tolist()
        ]
        off = np.array([float(abs(mpmath.mpf(w) / e - 1)) for w, e in zip(branch.points[:, 1].tolist(), exact, strict=True)])
    assert np.max(off) < 4e-15 and np.all(off <= branch.error) and np.max(branch.error) < 1e-13
    assert branch.multipliers.shape == (len(branch), 0)


def test_a_family_ends_where_its_rest_is_an_equilibrium() -> None:
    """One link swings up to 4e-5 rad below the top, omega still the elliptic integral, and no event is seen on the way; a target beyond is said."""
    branch = trace(uniform(1), until="amplitude=4")
    assert [event.kind for event in branch.events] == ["rest at an equilibrium"] and branch.reason.endswith("amplitude = 4.0 was not reached")
    left = np.pi - branch.points[-1, 0]
    assert 2e-5 < left < 6e-5
    exact = np.pi * np.sqrt(9.81 / 0.5) / (2 * ellipkm1(np.sin(left / 2) ** 2))
    assert branch.points[-1, 1] == pytest.approx(exact, rel=1e-10)


@pytest.mark.long
def test_a_link_on_a_cart_is_a_quadrature() -> None:
    """With M x' + mu cos(theta) theta' = 0 the energy is one integral: T = 4 int sqrt((c - mu^2 cos^2 / M) / (2 (V(A) - V))) dtheta."""
    mass, length, cart = 0.7, 0.6, 1.3
    system = uniform(1, base="cart", mass=mass, length=length, com=None, cart_mass=cart)
    branch = trace(system, until="theta_1=1.2")
    assert branch.names == ("x", "theta_1", "omega")
    mu, whole = mass * length, mass + cart
    with mpmath.workdps(30):

        def slowness(s):
            """The integrand with sin(theta / 2) = k sin(s), k = sin(A / 2): nothing is singular where the link turns."""
            sine = mpmath.sin(mpmath.mpf(1.2) / 2) * mpmath.sin(s)
            inertia = mu * length - mu**2 * (1 - 2 * sine**2) ** 2 / whole
            return mpmath.sqrt(inertia / (mpmath.mpf(9.81) * mu)) / mpmath.sqrt(1 - sine**2)

        period = 4 * mpmath.quad(slowness, [0, 0.5, 1, 1.4, mpmath.pi / 2])
    assert branch.points[-1, 2] == pytest.approx(float(2 * mpmath.pi / period), rel=3e-15)
    # The centre of mass stays above the origin: M x + mu sin(theta) = 0 where both stand still.
    assert branch.points[:, 0] == pytest.approx(-mu * np.sin(branch.points[:, 1]) / whole, abs=1e-14)


@pytest.mark.long
@pytest.mark.parametrize("cycle", [c for c in CYCLES if c["N"] > 1], ids=lambda c: f"N{c['N']}-mode{c['mode']}-{c['theta0'][0][:4]}")
def test_reference_orbits_lie_on_their_families(cycle) -> None:
    theta, mode = np.array(cycle["theta0"], float), cycle["mode"]
    held = mode - 1
    branch = trace(uniform(cycle["N"]), mode, until=(f"theta_{held + 1}", theta[held]))
    z = branch.points[-1]
    assert z[held] == theta[held]
    assert z[:-1] == pytest.approx(theta, abs=3e-15) and z[-1] == pytest.approx(float(cycle["omega"]), rel=1e-15)
    assert branch.energy[-1] == pytest.approx(float(cycle["energy"]), rel=1e-11)
    # Multipliers pair as lambda, 1 / lambda with lambda + 1 / lambda = 4 kappa^2 - 2.
    pairs = np.sort((4 * branch.multipliers[-1] ** 2 - 2).real)
    known = np.sort([2 * float(re) if abs(float(im)) > 1e-9 else float(re) for re, im in cycle["floquet"]])
    wanted = known[::2] if cycle["linear_stability"] == "stable" else np.array([known.sum()])
    assert pairs == pytest.approx(wanted, abs=3e-13)


@pytest.mark.long
@pytest.mark.parametrize("base", ["fixed", "cart"])
def test_kappa_is_that_of_the_monodromy_over_the_whole_period(base) -> None:
    """The eigenvalues of one propagation over T, all of them, without symmetry and without momenta."""
    more = {"base": "cart", "cart_mass": 0.4} if base == "cart" else {}
    system = uniform(3, **more)
    branch = trace(system, 2, until="amplitude=0.35")
    start, nq = branch.points[-1, :-1], system.nq
    period = 2 * np.pi / branch.points[-1, -1]
    found = system.propagate(start, np.zeros(nq), 0.0, period, 1e-16, transition=np.eye(2 * nq))
    assert found.q == pytest.approx(start, abs=1e-13)
    eigenvalues = np.linalg.eigvals(found.transition)
    nontrivial = eigenvalues[np.abs(eigenvalues - 1) > 1e-3]
    assert len(nontrivial) == 4
    pairs = np.sort_complex(nontrivial + 1 / nontrivial)[::2]
    assert np.sort_complex(4 * branch.multipliers[-1] ** 2 - 2) == pytest.approx(pairs, abs=1e-9)


def test_the_jacobian_is_the_derivative() -> None:
    """Columns by central differences of the residual; the last by T(omega)."""
    system = uniform(2, base="cart", cart_mass=0.4)
    modes = linear_modes(system)
    problem = quarter_problem(system, omega=modes.omega[0], shape=modes.shapes[:, 0])
    z = np.array([-0.1, 0.5, 0.2, 3.7])
    _, jacobian, _ = problem.evaluate(z)
    for k, h in enumerate([1e-5] * 4):
        step = h * np.eye(4)[k]
        slope = (problem.evaluate(z + step).residual - problem.evaluate(z - step).residual) / (2 * h)
        assert jacobian[:, k] == pytest.approx(slope, abs=1e-8)


def test_evaluations_keep_to_themselves() -> None:
    """Multipliers that are asked for later are those of their own orbit, and nobody can write to what an evaluation holds."""
    system = uniform(2, base="cart", cart_mass=0.4)
    modes = linear_modes(system)
    problem, other = (quarter_problem(system, omega=modes.omega[0], shape=modes.shapes[:, 0]) for _ in range(2))
    z = np.array([-0.1, 0.5, 0.2, 3.7])
    first, apart = problem.evaluate(z), other.evaluate(z)
    problem.evaluate(0.9 * z)
    for own, its in ((first.residual, apart.residual), (first.jacobian, apart.jacobian), (first.extra.multipliers, apart.extra.multipliers)):
        assert own.tolist() == its.tolist()
    with pytest.raises(ValueError, match="read-only"):
        first.extra.found.a[0, 0] = 1.0


def test_every_mode_starts_a_family() -> None:
    system = uniform(4)
    modes = linear_modes(system)
    for mode in range(1, 5):
        branch = trace(system, mode, 0.02, amplitude_start=1e-3)
        assert branch.points[0, -1] == pytest.approx(modes.omega[mode - 1], rel=1e-4)
        assert branch.points[0, :-1] / 1e-3 == pytest.approx(modes.shapes[:, mode - 1], abs=2e-3)
        assert np.max(np.abs(branch.points[0, :-1])) == 1e-3


def test_a_sprung_link_is_a_quadrature() -> None:
    """T = 4 int sqrt(I / (2 (V(A) - V))) dtheta with theta = A cos(c), and V(A) - V free of cancellation."""
    mass, length, spring, largest = 0.7, 0.6, 3.5, 2.5
    branch = trace(uniform(1, mass=mass, length=length, com=None, stiffness=spring), until=("amplitude", largest))
    with mpmath.workdps(30):

        def slowness(c):
            end, theta = mpmath.mpf(largest), mpmath.mpf(largest) * mpmath.cos(c)
            left = 2 * end * mpmath.sin(c / 2) ** 2
            weight = 2 * mpmath.mpf(9.81) * mass * length * mpmath.sin((end + theta) / 2) * mpmath.sin(left / 2)
            drop = weight + mpmath.mpf(spring) / 2 * left * (end + theta)
            return mpmath.sqrt(mpmath.mpf(mass) * mpmath.mpf(length) ** 2 / (2 * drop)) * end * mpmath.sin(c)

        period = 4 * mpmath.quad(slowness, [0, 0.5, 1, mpmath.pi / 2], method="gauss-legendre")
    assert branch.points[-1, -1] == pytest.approx(float(2 * mpmath.pi / period), rel=2e-15)


def test_what_shooting_lacks_is_said_in_one_sentence() -> None:
    with pytest.raises(UnsupportedError, match="lacks the functions propagate.*variational = true"):
        trace(uniform_planar(2), method="shooting")
    bare = uniform(2, variational=False)
    with pytest.raises(UnsupportedError, match="lacks derivatives in its flow"):
        trace(bare, method="shooting")
    assert trace(bare, amplitude_max=0.3).method == "one harmonic"


def test_it_is_cheap_in_evaluations() -> None:
    """A family of one link up to 3 rad takes less than two hundred propagations."""
    branch = trace(uniform(1), until="theta_1=3", options=Options(step=0.05, step_max=0.2, tol=1e-9))
    assert np.sum(branch.iterations + 1) < 200


def test_a_family_with_its_events_is_cheap_in_flow_calls() -> None:
    """Two links to theta_1 = -2.5: 73 points and sixteen events, in 150 whole evaluations; the others are of the state alone, or rough."""
    system = uniform(2)
    flow, brakes = system.function("propagate"), []
    calls: list[list[float]] = []

    class Noted:
        def __init__(self, *words, **more):
            self._brake = flow.brake(*words, **more)
            brakes.append(self)

        def __getattr__(self, name):
            own = getattr(self._brake, name)
            if name not in ("at", "settled", "corrected", "ahead", "run", "zero"):
                return own

            def called(*words):
                found = own(*words)
                calls.extend(self._brake.asked)
                return found

            return called

    def plain(*words, **more):
        calls.append([1.0, 0.0])
        return flow(*words, **more)

    vars(plain)["brake"] = Noted
    branch = trace(replace(system, functions={**system.functions, "propagate": plain}), until="theta_1=-2.5")
    with_all, with_some = (sum(call[-1] in columns and call[-2] < 1e-10 for call in calls) for columns in ((4.0,), (0.0, 2.0, 4.0)))
    assert len(branch.events) == 16 and len(branch) < 80 and len(brakes) == 2
    assert with_all < 160 and with_some - with_all < 130 and len(calls) < 480


def test_the_blocks_are_those_of_a_symplectic_map() -> None:
    """a^T d - c^T b = 1, and the null vectors that energy and the flow give d, on a cart too."""
    system = uniform(3, base="cart", cart_mass=0.4)
    modes = linear_modes(system)
    branch = trace(system, 2, until="amplitude=0.35")
    problem = quarter_problem(system, omega=modes.omega[1], shape=modes.shapes[:, 1])
    found = problem.evaluate(branch.points[-1]).extra.found
    assert found.a.T @ found.d - found.c.T @ found.b == pytest.approx(np.eye(3), abs=1e-12)
    assert found.d @ found.force == pytest.approx(0, abs=1e-12) and found.rate @ found.d == pytest.approx(0, abs=1e-12)
    # dV by differences of the potential energy.
    q = branch.points[-1, :-1]
    slope = [np.diff([system.energy(q + h, np.zeros(4))[1] for h in (-step, step)])[0] / 2e-6 for step in 1e-6 * np.eye(4)[1:]]
    assert found.slope == pytest.approx(slope, abs=1e-8)
