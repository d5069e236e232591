"""Single-harmonic families against closed forms, quadrature, linear theory and the true orbits."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.special import ellipj, ellipk, jn_zeros, jv

from phichain.continuation import Branch, Engine, Options, correctors, predictors
from phichain.errors import ArrayError, ToleranceError, UnsupportedError
from phichain.orbits import linear_modes, trace
from phichain.report import figures
from phichain.system import AbsentFunctionError
from tests.handmade import GRAVITY, paper_b, planar, uniform_planar

CYCLES = json.loads((Path(__file__).parents[2] / "data" / "limit_cycles.json").read_text())["points"]


@pytest.mark.parametrize("cart_mass", [None, 0.7])
@pytest.mark.parametrize("angles", ["relative", "absolute", "adjacent"])
def test_the_handmade_phi_is_the_projection_of_the_dynamics(cart_mass, angles) -> None:
    """Phi = (1/pi) int (M a + h + G + K q) cos(tau) dtau along theta = A cos(tau), by the trapezoidal rule."""
    system = planar(
        [0.3, 0.5, 0.2], [0.4, 0.3, 0.6], cart_mass=cart_mass, angles=angles, stiffness=[1, 0.5, 2]
    )
    rng = np.random.default_rng(1)
    amplitude, omega = rng.uniform(-1.5, 1.5, system.nq), 3.3
    total, points = np.zeros(system.nq), 64
    for tau in 2 * np.pi * np.arange(points) / points:
        q, v, a = (
            amplitude * np.cos(tau),
            -omega * amplitude * np.sin(tau),
            -(omega**2) * amplitude * np.cos(tau),
        )
        force = system.mass_matrix(q) @ (a - system.forward_dynamics(q, v))
        total += 2 / points * force * np.cos(tau)
    assert np.allclose(system.phi(amplitude, omega), total, rtol=0, atol=1e-11 * np.max(np.abs(total)))


def test_one_link_is_the_exact_bessel_curve() -> None:
    """omega^2 = 2 g J1(A) / (r A), up to a rotation of 3 rad; its energy is m g r (1 - cos A)."""
    branch = trace(planar([1.3], [0.9], [0.6]), amplitude_max=3.0)
    amplitude, omega = branch.points.T
    assert np.max(np.abs(omega**2 * 0.6 * amplitude / (2 * GRAVITY * jv(1, amplitude)) - 1)) < 2e-15
    assert np.allclose(branch.energy, 1.3 * GRAVITY * 0.6 * (1 - np.cos(amplitude)), rtol=1e-9)
    assert amplitude[0] == pytest.approx(1e-3, rel=1e-12) and amplitude[-1] == pytest.approx(3.0, abs=1e-13)
    assert [event.kind for event in branch.events] == ["amplitude_max"]


def test_one_link_ends_where_its_frequency_vanishes() -> None:
    """J1 vanishes at 3.8317: there one harmonic says omega = 0."""
    branch = trace(planar([1.0], [1.0]), amplitude_max=5.0)
    assert branch.events[-1].kind == "omega near zero"
    assert branch.points[-1, 0] == pytest.approx(jn_zeros(1, 1)[0], abs=1e-4)


@pytest.mark.parametrize("n", [2, 3, 4])
def test_every_point_is_at_round_off_and_newton_is_quick(n: int) -> None:
    system = uniform_planar(n)
    for mode in range(1, n + 1):
        branch = trace(system, mode)
        assert np.max(branch.residual) < 1e-15 and np.max(branch.iterations) <= 5
        assert branch.status == "event" and branch.events[-1].kind == "amplitude_max"
        kept = [np.max(np.abs(system.phi(z[:-1], z[-1]))) for z in branch.points]
        assert np.max(kept) < 1e-13


def test_starts_on_the_linear_modes_numbered_by_frequency() -> None:
    """The modes are those of the mass and gravity stiffness matrices at hanging, by another callable."""
    for system in (
        uniform_planar(4),
        planar([0.3, 0.5], [0.4, 0.3], angles="adjacent", stiffness=[2.0, 1.0]),
    ):
        mass, gravity = system.linearization(np.ones(system.links))
        squares, shapes = eigh(gravity, mass)
        modes = linear_modes(system)
        assert np.allclose(modes.omega, np.sqrt(squares), rtol=1e-12)
        for k in range(system.nq):
            expected = shapes[:, k] / np.max(np.abs(shapes[:, k])) * np.sign(shapes[0, k])
            assert np.allclose(modes.shapes[:, k], expected, atol=1e-10)
            branch = trace(system, k + 1, 0.01)
            assert branch.column("omega")[0] == pytest.approx(np.sqrt(squares[k]), rel=5e-5)
            assert np.allclose(branch.points[0, :-1] / 1e-3, expected, atol=1e-4)


def test_a_cart_is_along_and_its_free_translation_is_no_mode() -> None:
    """The horizontal momentum has no first harmonic: M00 X + 2 sum mu_k J1(B_k) = 0 on every point."""
    system = uniform_planar(2, cart_mass=0.5)
    modes = linear_modes(system)
    assert len(modes.omega) == 2 and modes.omega[0] > 1
    branch = trace(system, 1, 1.5)
    X, B = branch.points[:, 0], np.cumsum(branch.points[:, 1:3], axis=1)
    mu = np.array([0.5 * 0.25 + 0.25, 0.125])
    assert np.max(np.abs(1.5 * X + 2 * jv(1, B) @ mu)) < 1e-14
    assert branch.names == ("amplitude_x", "amplitude_theta_1", "amplitude_theta_2", "omega")


def test_small_orbits_are_those_of_the_whole_equations() -> None:
    """At 0.1 rad one harmonic is right to the square of the amplitude times the third harmonic's share."""
    for point in (p for p in CYCLES if float(p["theta0"][0]) == 0.1):
        n = int(point["N"])
        branch = trace(
            uniform_planar(n),
            int(point["mode"]),
            0.3,
            options=Options(step=0.005, step_max=0.01, max_points=2000),
        )
        theta_1 = branch.column("amplitude_theta_1")
        omega = np.interp(0.1, theta_1, branch.column("omega"))
        assert omega == pytest.approx(float(point["omega"]), rel=2e-4)
        energy = np.interp(0.1, theta_1, branch.energy)
        assert energy == pytest.approx(float(point["energy"]), rel=2e-2)


def test_the_lowest_frequency_tends_to_the_hanging_chain() -> None:
    """(j_{0,1} / 2) sqrt(g / L) for N -> infinity, approached at first order in 1/N or better."""
    limit = jn_zeros(0, 1)[0] / 2 * np.sqrt(GRAVITY)
    gaps = [linear_modes(uniform_planar(n)).omega[0] / limit - 1 for n in (8, 16, 32)]
    assert 0 < gaps[2] < gaps[1] < gaps[0] < 4e-3 and gaps[1] / gaps[2] > 1.9


def test_folds_do_not_depend_on_the_steps_or_the_parts() -> None:
    system = uniform_planar(2)
    reference = trace(system)
    kinds = [event.kind for event in reference.events]
    assert "fold in omega" in kinds and "fold in amplitude_theta_1" in kinds and "energy extremum" in kinds
    for engine in (
        Engine(options=Options(step=0.003, step_max=0.02, max_points=5000)),
        Engine(predictors.cubic, correctors.moore_penrose, Options(step_max=0.1)),
        Engine(predictors.secant, options=Options(step_max=0.05)),
    ):
        other = trace(system, engine=engine)
        assert [event.kind for event in other.events] == kinds
        for a, b in zip(reference.events, other.events, strict=True):
            tolerance = 1e-6 if a.kind == "energy extremum" else 1e-11
            assert a.z == pytest.approx(b.z, abs=tolerance)


def test_a_symmetric_branch_point_is_found() -> None:
    """Two equal pendulums that do not feel each other: their joint family crosses the single ones at every point;
    with a weak spring between them the in-phase family keeps one branch point of its own."""
    system = uniform_planar(2)

    def single(a: float) -> float:
        return 2 * GRAVITY * float(jv(1, a))

    def phi(amplitude: np.ndarray, omega: float) -> np.ndarray:
        a, b = amplitude
        bend = 0.4 * (a - b)
        return np.array([single(a) - omega**2 * a + bend, single(b) - omega**2 * b - bend])

    def slope(amplitude: np.ndarray, omega: float) -> np.ndarray:
        a, b = amplitude
        own = [GRAVITY * float(jv(0, x) - jv(2, x)) - omega**2 + 0.4 for x in (a, b)]
        return np.array([[own[0], -0.4, -2 * omega * a], [-0.4, own[1], -2 * omega * b]])

    functions = {"phi": phi, "phi_jacobian": slope}
    pair = type(system)("pair", "planar", "fixed", 2, 2, 2, 0, functions=functions)
    branch = trace(pair, 1, 2.5)
    assert np.allclose(branch.points[:, 0], branch.points[:, 1])
    (at,) = branch.located("branch point")
    # Symmetry breaks where the antisymmetric perturbation is free: 2 g J1'(a) + 0.8 = 2 g J1(a) / a.
    a = at.z[0]
    assert GRAVITY * (jv(0, a) - jv(2, a)) + 0.8 == pytest.approx(2 * GRAVITY * jv(1, a) / a, abs=1e-7)


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (lambda: trace(uniform_planar(2), 3), ArrayError, "modes 1 .. 2"),
        (lambda: trace(uniform_planar(2), 0), ArrayError, "modes 1 .. 2"),
        (lambda: trace(uniform_planar(2), amplitude_max=-1.0), ToleranceError, "positive"),
        (lambda: trace(uniform_planar(2), amplitude_max=np.nan), ToleranceError, "amplitude_max: must be positive and finite"),
        (lambda: trace(uniform_planar(2), amplitude_start=4.0), ToleranceError, "rising"),
        (lambda: trace(paper_b(), method="shooting"), UnsupportedError, "no scalar amplitudes"),
        (lambda: trace(uniform_planar(2, damping=[1, 1])), UnsupportedError, "damping"),
        (lambda: trace(uniform_planar(2, leave_out=["phi"])), AbsentFunctionError, "phi"),
    ],
)
def test_bad_input_is_one_typed_error(call, error, words) -> None:
    with pytest.raises(error, match=words) as caught:
        call()
    assert "\n" not in str(caught.value)


def test_without_energy_the_branch_says_none() -> None:
    branch = trace(uniform_planar(1, leave_out=["energy"]), amplitude_max=0.5)
    assert branch.energy is None


def test_one_harmonic_has_no_multipliers(tmp_path) -> None:
    """It satisfies no equation of motion to linearise: nothing stands where the multipliers of an orbit would."""
    branch = trace(planar([1.0], [1.0]), amplitude_max=0.5)
    assert branch.multipliers.shape == (len(branch), 0)
    assert all(event.multipliers.shape == (0,) for event in branch.events)
    copy = Branch.from_npz(branch.to_npz(tmp_path / "family.npz"))
    assert copy.multipliers.shape == branch.multipliers.shape


def test_the_first_omitted_harmonic_is_that_of_the_true_motion() -> None:
    """For one link theta = A cos + A_3 cos 3: A_3 / A of the exact swing, sn(K k) squared away, is A^2 / 192 for small A."""
    branch = trace(planar([1.0], [0.5]), amplitude_max=2.9)
    amplitude = branch.column("amplitude_theta_1")
    small = amplitude < 0.2
    assert branch.error[small] == pytest.approx(amplitude[small] ** 2 / 192, rel=5e-3)
    # What Fourier quadrature finds of the swing from 2 rad: sin(theta / 2) = k sn(K + w t).
    k = np.sin(1.0)
    phase = 2 * np.pi * np.arange(256) / 256
    swing = 2 * np.arcsin(k * ellipj(ellipk(k**2) * (1 + 2 * phase / np.pi), k**2)[0])
    third = abs(2 * np.mean(swing * np.cos(3 * phase))) / abs(2 * np.mean(swing * np.cos(phase)))
    assert np.interp(2.0, amplitude, branch.error) == pytest.approx(third, rel=0.5)
    assert "one harmonic is no longer true" in branch.reason and "from the amplitude 2.3" in branch.reason


def test_amplitudes_beyond_pi_are_said_and_not_drawn() -> None:
    branch = trace(planar([1.0], [1.0]), amplitude_max=3.5)
    assert "amplitudes beyond pi" in branch.reason
    assert "beyond pi" not in trace(planar([1.0], [1.0]), amplitude_max=3.1).reason
    axes = figures.family(branch).axes[0]
    drawn = axes.get_lines()[0].get_xdata()
    assert np.nanmax(drawn) <= np.pi and np.isnan(drawn[-1])
