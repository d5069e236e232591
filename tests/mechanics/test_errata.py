"""Every slip of the two papers that docs/theory.md lists, shown: the print fails, the right form holds."""

from __future__ import annotations

import math

import numpy as np
import pytest
import sympy
from mpmath import mp

from phichain.mechanics import derive
from phichain.mechanics.coordinates import absolute_angles, joint_angles
from phichain.mechanics.linearization import QUARTER_TURN, linearize
from phichain.reference import reference
from phichain.scene import Scene

CHAIN = Scene("b", 3, "spatial", "cart", mass=[0.1, 0.3, 0.2], length=[0.4, 0.1, 0.25], cart_mass=0.5)


def test_a_below_14_the_angle_from_the_previous_link_is_the_cumulative_one() -> None:
    """Joint 3 bends by theta_3 under the cumulative sum, by theta_3 - theta_1 under the printed formula."""
    theta = sympy.symbols("theta_1:4")
    for kind, third in (("relative", theta[2]), ("adjacent", theta[2] - theta[0])):
        phi = absolute_angles(kind, theta)
        assert sympy.expand(phi[2] - phi[1]) == third == joint_angles(kind, theta)[2]
        assert sympy.expand(phi[1] - phi[0]) == theta[1]


def test_a_18_19_hold_for_a_sine() -> None:
    """At tau = 0 cos(z cos tau) is cos z and cos(z sin tau) is 1: the sum without (-1)^n is the latter."""
    z = mp.mpf("1.7")
    printed = mp.besselj(0, z) + 2 * mp.fsum(mp.besselj(n, z) for n in range(2, 60, 2))
    right = mp.besselj(0, z) + 2 * mp.fsum((-1) ** (n // 2) * mp.besselj(n, z) for n in range(2, 60, 2))
    assert abs(printed - 1) < 1e-14 and abs(right - mp.cos(z)) < 1e-14


def gruenwald_letnikov(alpha: float, end: float, bound_step: float, sample_step: float) -> float:
    """Return (2) for x(t) = t at t = end, sum up to end / bound_step over samples sample_step apart."""
    weight, total = 1.0, 0.0
    for k in range(round(end / bound_step) + 1):
        total += weight * max(end - k * sample_step, 0.0)
        weight *= (k - alpha) / (k + 1)
    return total / sample_step**alpha


def test_a_2_needs_one_step() -> None:
    """D^alpha t = t^(1-alpha)/Gamma(2-alpha) with one step; a sum that stops early forgets the rest."""
    exact = 1 / math.gamma(1.5)
    one = [abs(gruenwald_letnikov(0.5, 1.0, h, h) - exact) for h in (1e-2, 5e-3)]
    assert one[0] / one[1] == pytest.approx(2, abs=0.05)
    two = [abs(gruenwald_letnikov(0.5, 1.0, 2 * h, h) - exact) for h in (1e-2, 5e-3)]
    assert min(two) > 10 * max(one) and two[0] / two[1] < 1.1


@pytest.mark.parametrize(("alpha", "delta"), [(0.2, 0.1), (0.5, 0.01), (1.5, 0.01)])
def test_a_4_the_memory_length_is_sharp_for_a_constant(alpha: float, delta: float) -> None:
    """A constant history before t - L contributes L^-alpha / |Gamma(1 - alpha)|: delta at the bound."""
    bound = (1 / (delta * abs(math.gamma(1 - alpha)))) ** (1 / alpha)
    # int_L^inf s^(-alpha-1) ds / Gamma(-alpha), with s = exp y
    tail = mp.quad(lambda y: mp.exp(-alpha * y), [mp.log(bound), mp.inf]) / mp.gamma(-alpha)
    assert float(abs(tail)) == pytest.approx(delta, rel=1e-9)


def test_a_4_the_printed_length_can_fall_short_and_an_integral_has_none() -> None:
    alpha, delta = 0.2, 0.1
    printed = 1 / (delta**2 * math.gamma(alpha))
    assert printed**-alpha / math.gamma(1 - alpha) > 4 * delta
    half_integral = [mp.quad(lambda s: s**-0.5, [1, end]) / mp.gamma(0.5) for end in (1e2, 1e4, 1e6)]
    assert half_integral[2] > 50 * half_integral[0]


def test_a_8_11_the_power_of_section_4_is_p() -> None:
    """(I^-1)^p runs from the identity at p = 0 to the inverse at p = 1; exponent 1/p does not."""
    inertia = np.array([[2.0, 0.5], [0.5, 1.0]])
    values, vectors = np.linalg.eigh(np.linalg.inv(inertia))
    power = {p: (vectors * values**p) @ vectors.T for p in (0.0, 0.5, 1.0, 2.0)}
    np.testing.assert_allclose(power[0.0], np.eye(2), atol=1e-15)
    np.testing.assert_allclose(power[1.0] @ inertia, np.eye(2), atol=1e-15)
    np.testing.assert_allclose(power[0.5] @ power[0.5], power[1.0], atol=1e-15)
    # A^(1/p) of (8)-(11) at p = 1/2 is the square, not the square root.
    assert not np.allclose(power[2.0], power[0.5], rtol=0.1)


def test_a_section_4_two_integrals_give_theta_less_its_initial_terms() -> None:
    t, s = sympy.symbols("t s", positive=True)
    theta = sympy.exp(-t) * sympy.cos(3 * t) + 2
    double_integral = sympy.integrate((t - s) * theta.diff(t, 2).subs(t, s), (s, 0, t))
    initial = theta.subs(t, 0) + theta.diff(t).subs(t, 0) * t
    assert initial != 0
    difference = sympy.lambdify(t, double_integral - (theta - initial), "mpmath")
    assert max(abs(difference(x)) for x in (0.3, 1.1, 2.7)) < 1e-13


def test_b_20_the_stiffness_multiplies_the_state() -> None:
    """M_qq x_q'' + G_qq x_q = -M_qx x'' is the lower row of (19), and what (16) does near an equilibrium."""
    linear = linearize(derive(CHAIN), (1, -1, 1))
    M, G = (np.array(matrix, dtype=float) for matrix in (linear.M, linear.G))
    rest = [entry for s in (1, -1, 1) for entry in (0.0, 0.0, float(s))]
    eps = 1e-7
    turned = np.array([0.0, 0.0, *rest])
    turned[3] = eps  # xi_1 = -eps e_1 moves q_1 = e_3 by xi_1 x e_3 = eps e_2
    a = reference(CHAIN, "forward_dynamics", {"q": turned, "v": [0.0] * 11, "u": [0.0, 0.0]})["a"]
    horizontal = np.array([float(a[i]) for i in (0, 1, 2, 3, 5, 6, 8, 9)])
    x_q = np.array([-eps, 0, 0, 0, 0, 0])
    lower = M[2:, :2] @ horizontal[:2] + M[2:, 2:] @ horizontal[2:]
    np.testing.assert_allclose(lower, -G[2:, 2:] @ x_q, atol=1e-12)
    assert np.abs(lower).max() > 1e-9
    np.testing.assert_array_equal(M[2:4, :2] / float(derive(CHAIN).mu[0]), QUARTER_TURN)


def test_b_g_qq_weighs_the_outer_masses_with_the_own_length() -> None:
    """Turning link 1 curves V by (sum m_a) g l_1; the printed sum of m_a g l_a is another number."""
    eps = 1e-3
    q = [[0.0, 0.0, math.sin(x), 0.0, math.cos(x), 0.0, 0.0, 1.0, 0.0, 0.0, 1.0] for x in (-eps, 0.0, eps)]
    V = [reference(CHAIN, "energy", {"q": entry, "v": [0.0] * 11})["potential"] for entry in q]
    curvature = float((V[0] - 2 * V[1] + V[2]) / eps**2)
    m, lengths = CHAIN.mass, CHAIN.length
    right, printed = sum(m) * 9.81 * lengths[0], sum(a * b for a, b in zip(m, lengths, strict=True)) * 9.81
    assert curvature == pytest.approx(right, rel=1e-6)
    assert float(linearize(derive(CHAIN), (1, 1, 1)).G[2, 2]) == pytest.approx(right, rel=1e-14)
    assert abs(printed / right - 1) > 0.3


def test_b_e_q_vanishes_at_the_equilibrium_with_e_3_alone() -> None:
    signs, basis = (1, -1, 1), np.eye(3)
    links = [s * basis[2] for s in signs]
    assert sum(np.linalg.norm(q - s * basis[2]) for s, q in zip(signs, links, strict=True)) == 0
    assert (
        sum(np.linalg.norm(q - s * basis[i]) for i, (s, q) in enumerate(zip(signs, links, strict=True))) > 1
    )


def test_b_appendix_a_the_second_hat_is_that_of_the_rate() -> None:
    """delta q' = d/dt (xi x q) = xi' x q + xi x q', so p.delta q' = xi'.(q x p) + xi.(q' x p)."""
    t = sympy.Symbol("t")
    q, xi = (sympy.Matrix([sympy.Function(f"{name}_{i}")(t) for i in range(3)]) for name in ("q", "xi"))
    p = sympy.Matrix(sympy.symbols("p_1:4"))
    pairing = p.dot(xi.cross(q).diff(t))
    right = xi.diff(t).dot(q.cross(p)) + xi.dot(q.diff(t).cross(p))
    printed = xi.diff(t).dot(q.cross(p)) + xi.dot(q.cross(p))
    assert sympy.expand(pairing - right) == 0
    assert sympy.expand(pairing - printed) != 0


def test_b_appendix_b_upwards_is_against_e_3() -> None:
    """V = -g mu e_3.q is largest, and the linear stiffness negative, at q = -e_3."""
    one = Scene("b", 1, "spatial", mass=1.0, length=1.0)
    V = {s: reference(one, "energy", {"q": [0.0, 0.0, s], "v": [0.0] * 3})["potential"] for s in (1.0, -1.0)}
    assert V[-1.0] > V[1.0]
    assert linearize(derive(one), (-1,)).G[0, 0] < 0 < linearize(derive(one), (1,)).G[0, 0]


def test_b_figure_4_starts_are_unit_vectors_of_three_entries() -> None:
    start = -np.array([0.0, math.sin(math.radians(4)), math.cos(math.radians(4))])
    assert start.shape == (3,) and np.linalg.norm(start) == pytest.approx(1, abs=1e-15)
    assert start[2] < -0.99
