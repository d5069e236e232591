"""Figs 2 to 4 of paper B: the numbers that tell the right runs, and the panels that show them."""

from __future__ import annotations

import numpy as np
import pytest

from phichain.control import errors, lqr
from phichain.papers.figures import FIG_2, FIG_3, FIG_4
from phichain.report.paper_b import chain_kinetic_energy, left_alone, steadied
from phichain.system import System, angular_velocities, unit_vectors
from tests.handmade import coefficients

ENERGY = 0.299285058894842


def test_figure_2_has_the_paper_s_energy_and_keeps_it(runs: dict) -> None:
    motion, gains = runs["B2"]
    assert gains is None and motion.t[-1] == 10.0
    assert motion.energy[0] == pytest.approx(ENERGY, rel=0, abs=5e-16)
    assert motion.energy_drift < 1e-10 * ENERGY


def test_figure_2_stays_in_its_plane_exactly(runs: dict, cart: System) -> None:
    motion, _ = runs["B2"]
    assert np.all(motion.q[:, 1] == 0) and np.all(unit_vectors(cart, motion.q)[..., 1] == 0)
    spin = angular_velocities(cart, motion.v)
    assert np.all(spin[..., [0, 2]] == 0) and np.abs(spin[..., 1]).max() > 10


def test_figure_2_keeps_the_horizontal_momentum(runs: dict, cart: System) -> None:
    # No force acts along e_1: M00 x' + sum mu_k e_1 . q_k' keeps its first value, 0.1 kg m/s.
    motion, _ = runs["B2"]
    mu, _ = coefficients(np.full(5, 0.1), np.full(5, 0.1), np.full(5, 0.1))
    links, spin = unit_vectors(cart, motion.q), angular_velocities(cart, motion.v)
    momentum = motion.v[:, 0] + np.cross(spin, links)[..., 0] @ mu
    np.testing.assert_allclose(momentum, 0.1, rtol=0, atol=1e-11)


@pytest.mark.parametrize(("name", "run", "slowest"), [("B3", FIG_3, -1.07782602), ("B4", FIG_4, -0.77136540)])
def test_figures_3_and_4_have_the_paper_s_spectrum_and_settle(
    name, run, slowest, runs: dict, cart: System
) -> None:
    motion, gains = runs[name]
    assert gains.s == run.s
    assert gains.poles.real.max() == pytest.approx(slowest, abs=5e-9)
    direction, rate = errors(cart, gains, motion.x)
    assert motion.t[-1] == 20.0 and direction[-1] < 1e-6 and rate[-1] < 1e-5
    # The last seconds decay as the slowest eigenvalue says (its pair turns, so peaks are compared).
    half = len(direction) // 2
    early, late = direction[half : half + half // 2].max(), direction[half + half // 2 :].max()
    assert np.log(late / early) / 5.0 == pytest.approx(slowest, abs=0.2)


def test_links_2_and_3_of_figure_4_are_the_corrected_ones() -> None:
    expected = (0.0, -np.sin(np.radians(4)), -np.cos(np.radians(4)))
    assert FIG_4.links[1] == FIG_4.links[2] == pytest.approx(expected)
    for run in (FIG_2, FIG_3, FIG_4):
        np.testing.assert_allclose(np.linalg.norm(run.links, axis=1), 1.0, rtol=1e-15)


def test_the_weights_decide_the_spectrum(cart: System) -> None:
    # With Q the identity the same equilibrium has another slowest eigenvalue: the check above can fail.
    assert abs(lqr(cart, FIG_3.s).poles.real.max() + 1.07782602) > 0.1


def test_the_chain_s_share_of_the_kinetic_energy(runs: dict, cart: System) -> None:
    # (10): T_q = 1/2 sum c_ij q_i' . q_j'.
    motion, _ = runs["B2"]
    _, c = coefficients(np.full(5, 0.1), np.full(5, 0.1), np.full(5, 0.1))
    rates = np.cross(angular_velocities(cart, motion.v), unit_vectors(cart, motion.q))
    expected = 0.5 * np.einsum("ij,tik,tjk->t", c, rates, rates)
    np.testing.assert_allclose(chain_kinetic_energy(cart, motion), expected, rtol=1e-9, atol=1e-12)


def test_the_sheets_have_the_paper_s_panels(runs: dict, cart: System) -> None:
    alone = left_alone(cart, runs["B2"][0], "title", FIG_2.moments)
    labels = [axes.get_ylabel() for axes in alone.axes]
    assert sum("e_3" in label for label in labels) == 5
    assert {"height (m)", "cart (m)", "energy (J)", "error of $T + V$"} <= set(labels)
    held = steadied(cart, *runs["B4"], "title", FIG_4.moments)
    labels = [axes.get_ylabel() for axes in held.axes]
    assert {"cart (m)", "energy (J)", "force (N)"} <= set(labels) and sum(
        "off" in label for label in labels
    ) == 5
    curves = {line.get_label(): line.get_ydata() for axes in held.axes for line in axes.get_lines()}
    assert curves["$e_q$"][0] == pytest.approx(4 * np.sin(np.radians(2)))
    np.testing.assert_array_equal(curves["$u_2$"], runs["B4"][0].u[:, 1])
    assert np.abs(curves["$u_1$"]).max() < 1e-20
