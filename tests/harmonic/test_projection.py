"""Phi in closed form against quadrature of its integral, the printed (21)-(22), and known limits."""

from __future__ import annotations

import random
from typing import Any

import numpy as np
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st
from mpmath import mp

from phichain.errors import UnsupportedError
from phichain.harmonic import (
    OMEGA,
    amplitude_symbols,
    kernels,
    phi_expressions,
    phi_latex,
    phi_text,
    printed_equations,
)
from phichain.harmonic.series import COSINE, SINE_SQUARED, cosine_of, sine_of
from phichain.mechanics import derive, with_symbols
from phichain.mechanics.coordinates import angle_map
from phichain.mechanics.linearization import linearize
from phichain.reference import reference
from phichain.scene import Scene, standard_scene
from tests.reference_cases import relative_error

J0, J1, J2, J3 = (lambda z, n=n: sympy.besselj(n, z) for n in range(4))


def evaluated(scene: Scene, amplitude: list[float], omega: float) -> list[Any]:
    """Return Phi at numbers, through the symbolic expressions, in 30 digits."""
    point = dict(zip(amplitude_symbols(scene), map(sympy.Float, amplitude), strict=True)) | {
        OMEGA: sympy.Float(omega)
    }
    return [mp.mpf(row.xreplace(point).evalf(25)) for row in phi_expressions(scene)]


@pytest.mark.long
@pytest.mark.parametrize("angles", ["relative", "absolute", "adjacent"])
@pytest.mark.parametrize("links", range(1, 9))
def test_closed_form_is_the_projection_integral(links: int, angles: str) -> None:
    draw = random.Random(links)
    numbers = {name: [draw.uniform(0.2, 1) for _ in range(links)] for name in ("mass", "length")}
    com = [entry * draw.uniform(0.1, 1) for entry in numbers["length"]]
    scene = Scene("a", links, **numbers, com=com, angles=angles)
    amplitude = [draw.uniform(-1.2, 1.2) for _ in range(links)]
    expected = reference(scene, "phi", {"amplitude": amplitude, "omega": 4.25}, digits=20)["phi"]
    assert relative_error(evaluated(scene, amplitude, 4.25), expected) < 1e-14


@settings(max_examples=12, deadline=None)
@given(
    links=st.integers(1, 3),
    angles=st.sampled_from(["relative", "absolute", "adjacent"]),
    amplitude=st.lists(st.floats(-3, 3), min_size=4, max_size=4),
    omega=st.floats(0.1, 20),
    stiffness=st.sampled_from([None, 0.7]),
    cart=st.sampled_from([{}, {"base": "cart", "cart_mass": 0.8}]),
)
def test_springs_and_a_cart_belong_to_the_projection(
    links: int,
    angles: str,
    amplitude: list[float],
    omega: float,
    stiffness: float | None,
    cart: dict[str, Any],
) -> None:
    scene = Scene("a", links, mass=0.7, length=0.6, com=0.4, angles=angles, stiffness=stiffness, **cart)
    point = amplitude[: scene.nq]
    expected = reference(scene, "phi", {"amplitude": point, "omega": omega}, digits=20)["phi"]
    found = evaluated(scene, point, omega)
    scale = max(map(abs, expected)) + omega**2
    assert max(abs(a - b) for a, b in zip(found, expected, strict=True)) <= 1e-13 * scale


def test_kernels_are_their_closed_forms_and_higher_harmonics_do_not_reach_them() -> None:
    k = kernels()
    D, B = k.difference, k.amplitude
    assert k.acceleration == J0(D) - J2(D)
    assert sympy.expand(k.centripetal - (J1(D) + J3(D)) / 2) == 0
    assert k.gravity == 2 * J1(B)
    assert (cosine_of(D, 9) * COSINE).harmonic(1) == k.acceleration
    assert (sine_of(D, 9) * SINE_SQUARED).harmonic(1) == k.centripetal


def terms(expression: sympy.Expr) -> dict[sympy.Expr, sympy.Expr]:
    """Return an expression as coefficients of its products of Bessel functions, g and omega^2."""
    bessel = sorted(expression.atoms(sympy.besselj), key=str)
    polynomial = sympy.Poly(sympy.expand(expression), *bessel, OMEGA, sympy.Symbol("g", positive=True))
    return {sympy.Mul(*[x**p for x, p in zip(polynomial.gens, powers, strict=True)]): value
            for powers, value in polynomial.terms()}  # fmt: skip


def test_printed_21_and_22_term_by_term() -> None:
    """One and two links written out by hand in the paper's letters."""
    A_1, A_2 = sympy.symbols("A_1 A_2", real=True)
    m_1, m_2, l_1, r_1, r_2, g = sympy.symbols("m_1 m_2 l_1 r_1 r_2 g", positive=True)
    w2 = OMEGA**2
    (one,) = printed_equations(1)
    assert terms(one) == terms(2 * g * J1(A_1) - r_1 * w2 * A_1)
    first = (
        2 * w2 * (m_1 * r_1**2 + m_2 * l_1**2 + m_2 * r_2**2) * A_1
        + 2 * w2 * m_2 * r_2**2 * A_2
        + 2 * w2 * m_2 * l_1 * r_2 * (2 * A_1 + A_2) * (J0(A_2) - J2(A_2))
        + w2 * m_2 * l_1 * r_2 * (2 * A_1 * A_2 + A_2**2) * (J1(A_2) + J3(A_2))
        - 4 * g * (m_1 * r_1 + m_2 * l_1) * J1(A_1)
        - 4 * g * m_2 * r_2 * J1(A_1 + A_2)
    )
    second = (
        -2 * w2 * r_2 * (A_1 + A_2)
        - 2 * w2 * l_1 * A_1 * (J0(A_2) - J2(A_2))
        + w2 * l_1 * A_1**2 * (J1(A_2) + J3(A_2))
        + 4 * g * J1(A_1 + A_2)
    )
    assert [terms(row) for row in printed_equations(2)] == [terms(first), terms(second)]
    phi = phi_expressions(with_symbols(standard_scene(2)))
    assert terms(-2 * phi[0]) == terms(first)
    assert terms(2 / (m_2 * r_2) * phi[1]) == terms(second)


@pytest.mark.parametrize("angles", ["relative", "absolute", "adjacent"])
def test_small_amplitudes_give_the_linear_chain(angles: str) -> None:
    """Phi = (G - omega^2 M) A + O(A^3)."""
    scene = Scene(
        "a",
        3,
        mass=[0.7, 1.1, 0.4],
        length=0.5,
        com=0.3,
        angles=angles,
        base="cart",
        cart_mass=0.9,
        stiffness=0.4,
    )
    linear = linearize(derive(scene), (1, 1, 1))
    M, G = (np.array(matrix, dtype=float) for matrix in (linear.M, linear.G))
    amplitude, omega = np.array([1e-6, 2e-6, -3e-6, 1.5e-6]), 2.5
    found = np.array([float(row) for row in evaluated(scene, list(amplitude), omega)])
    np.testing.assert_allclose(found, (G - omega**2 * M) @ amplitude, rtol=1e-10)


def test_the_map_of_angles_carries_phi_over() -> None:
    """Phi(theta) = S^T Phi(phi) at B = S A for all three kinds of angles."""
    amplitude = [0.4, -0.7, 1.1, 0.2]
    for kind in ("relative", "adjacent"):
        S = np.array(angle_map(kind, 4))
        absolute = Scene("a", 4, mass=0.5, length=0.5, com=0.3, angles="absolute")
        own = Scene("a", 4, mass=0.5, length=0.5, com=0.3, angles=kind)
        base = np.array([float(x) for x in evaluated(absolute, [float(b) for b in S @ amplitude], 3.0)])
        np.testing.assert_allclose([float(x) for x in evaluated(own, amplitude, 3.0)], S.T @ base, rtol=1e-12)


def test_the_lowest_frequency_tends_to_that_of_the_hanging_chain() -> None:
    """(j_01 / 2) sqrt(g / L) as N grows, halving the gap as the links halve."""
    limit = float(mp.besseljzero(0, 1)) / 2 * np.sqrt(9.81)
    gaps = []
    for links in (8, 16, 32):
        linear = linearize(derive(standard_scene(links)), (1,) * links)
        M, G = (np.array(matrix, dtype=float) for matrix in (linear.M, linear.G))
        gaps.append(np.sqrt(np.linalg.eigvals(np.linalg.solve(M, G)).real.min()) - limit)
    assert abs(gaps[2]) < 0.01 * limit
    assert abs(gaps[0] / gaps[1]) > 1.9 and abs(gaps[1] / gaps[2]) > 1.9


def test_negative_arguments_are_not_rewritten_in_powers() -> None:
    """J_n(-z) as (-z)^n z^-n J_n(z) would be 0/0 where two amplitudes meet."""
    scene = Scene("a", 4, mass=0.5, length=0.5, angles="absolute")
    for row in phi_expressions(scene):
        assert all(not power.exp.is_negative for power in row.atoms(sympy.Pow))
    assert all(mp.isfinite(value) for value in evaluated(scene, [0.5, 0.5, 0.5, 0.5], 2.0))


def test_text_and_latex() -> None:
    text = phi_text(standard_scene(2))
    assert "Phi_2 = " in text and "besselj" not in text
    assert text.splitlines()[-1].startswith("(22) 0 = ")
    assert phi_text(standard_scene(1)).splitlines()[-1] == "(21) 0 = -A_1*omega**2*r_1 + 2*g*J1(A_1)"
    long = phi_text(Scene("a", 9, mass=1.0, length=1.0, base="cart", cart_mass=1.0, stiffness=1.0))
    assert len(long.splitlines()) == 4 and "x = X cos(omega t)" in long
    assert phi_latex(standard_scene(1)).startswith("\\begin{aligned}") and "J_{1}" in phi_latex(
        standard_scene(1)
    )


def test_scenes_without_an_in_phase_motion_are_refused() -> None:
    with pytest.raises(UnsupportedError, match="no scalar amplitude per link.*periodic orbits"):
        phi_expressions(Scene("a", 2, "spatial", mass=1.0, length=1.0))
    with pytest.raises(UnsupportedError, match="no in-phase periodic motion.*simulate"):
        phi_text(Scene("a", 2, mass=1.0, length=1.0, damping=0.1))
    with pytest.raises(UnsupportedError, match="takes any N"):
        printed_equations(3)
