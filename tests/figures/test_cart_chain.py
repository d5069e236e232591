"""Figs 2 to 4 of paper B: the numbers that tell the right runs, and the panels that show them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchmarks.papers.paper_b_digits import pieces
from phichain.control import errors, lqr
from phichain.papers.figures import FIG_2, FIG_3, FIG_4
from phichain.report.papers.paper_b import chain_kinetic_energy, left_alone, steadied
from phichain.system import System, angular_velocities, unit_vectors
from tests.handmade import coefficients

ENERGY = 0.299285058894842


def test_the_starts_are_the_printed_ones() -> None:
    """(23) and the start of Fig. 4, entry by entry in degrees from the paper; its q_2 and q_3 with three entries, B6."""
    rad = math.radians
    folded = [[0, 0, -1], [0, 0, 1], [0, 0, -1], [0, 0, 1], [math.sin(rad(1)), 0, -math.cos(rad(1))]]
    up_4 = [0, -math.sin(rad(4)), -math.cos(rad(4))]
    aside = [math.sin(rad(5)) * math.cos(rad(4)), -math.sin(rad(5)) * math.sin(rad(4)), math.cos(rad(5))]
    leaning = [[-math.sin(rad(6)), 0, -math.cos(rad(6))], up_4, up_4, aside, [-math.sin(rad(35)), 0, math.cos(rad(35))]]
    for run, links in ((FIG_2, folded), (FIG_3, folded), (FIG_4, leaning)):
        q, v = run.start
        np.testing.assert_allclose(q, [0.2, 0.1, *np.ravel(links)], rtol=0, atol=1e-16)
        np.testing.assert_array_equal(v, [0, -0.1, *[0] * 15])
        np.testing.assert_allclose(np.linalg.norm(run.links, axis=1), 1.0, rtol=1e-15)


@pytest.mark.long
def test_figure_2_has_the_paper_s_energy_and_keeps_it(runs: dict) -> None:
    motion, gains = runs["B2"]
    assert gains is None and motion.t[-1] == 10.0
    # g sum n_k m l e_3 . (-q_k) and half the whole mass times the square of the cart's rate, by hand.
    by_hand = 0.0981 * (5 - 4 + 3 - 2 + math.cos(math.radians(1))) + 0.5 * 1.0 * 0.1**2
    assert pytest.approx(ENERGY, rel=0, abs=5e-16) == by_hand
    assert motion.energy[0] == pytest.approx(ENERGY, rel=0, abs=5e-16)
    assert motion.energy_drift < 1e-10 * ENERGY


def test_figure_2_stays_in_its_plane_and_the_cart_leaves_it_evenly(runs: dict, cart: System) -> None:
    # Links at rest across the plane have no momentum there, so the cart keeps its own: x_2 = 0.1 - 0.1 t, -0.9 m at 10 s.
    motion, _ = runs["B2"]
    assert np.all(unit_vectors(cart, motion.q)[..., 1] == 0) and np.all(motion.v[:, 1] == -0.1)
    np.testing.assert_allclose(motion.q[:, 1], 0.1 - 0.1 * motion.t, rtol=0, atol=1e-14)
    assert motion.q[-1, 1] == pytest.approx(-0.9, rel=0, abs=1e-14)
    spin = angular_velocities(cart, motion.v)
    assert np.all(spin[..., [0, 2]] == 0) and np.abs(spin[..., 1]).max() > 10


def test_figure_2_keeps_the_horizontal_momentum(runs: dict, cart: System) -> None:
    # No force acts along e_1: M00 x' + sum mu_k e_1 . q_k' keeps its first value, zero.
    motion, _ = runs["B2"]
    mu, _ = coefficients(np.full(5, 0.1), np.full(5, 0.1), np.full(5, 0.1))
    links, spin = unit_vectors(cart, motion.q), angular_velocities(cart, motion.v)
    momentum = motion.v[:, 0] + np.cross(spin, links)[..., 0] @ mu
    np.testing.assert_allclose(momentum, 0.0, rtol=0, atol=1e-11)


@pytest.mark.long
def test_figure_2_is_the_motion_of_thirty_digits_for_two_seconds(runs: dict) -> None:
    """Another form, another order, integers: `benchmarks.papers.paper_b_digits` shares nothing with phichain but (23)."""
    motion, _ = runs["B2"]
    exact = list(pieces(2.0, 10))
    for piece in exact:
        for t, x in zip(motion.t, motion.q[:, 0], strict=True):
            if piece.start <= t <= min(piece.start + piece.step, 2.0):
                assert x == pytest.approx(piece.at(t), rel=0, abs=2e-8)
    assert float(exact[-1].last) == pytest.approx(0.214762028211559, rel=0, abs=1e-14)


def test_figure_2_ranges_as_far_as_double_precision_knows(runs: dict) -> None:
    """The cart along e_1 in 40 and in 57 digits: 0.123791 .. 0.313735 m over 4 s, then 0.140689 m (docs/theory.md, B7)."""
    motion, _ = runs["B2"]
    x, t = motion.q[:, 0], motion.t
    ranges = {2.0: (0.123791, 0.284148), 4.0: (0.123791, 0.313735)}
    for end, (low, high) in ranges.items():
        # Samples 5 ms apart miss an extremum by up to 2e-4 m.
        assert x[t <= end].min() == pytest.approx(low, rel=0, abs=2e-4)
        assert x[t <= end].max() == pytest.approx(high, rel=0, abs=2e-4)
    assert x[t <= 4.0][-1] == pytest.approx(0.1406889, rel=0, abs=5e-3)


@pytest.mark.parametrize(("name", "e_q"), [("B3", 1.2234e-8), ("B4", 2.4525e-7)])
def test_figures_3_and_4_end_with_the_paper_s_error(name: str, e_q: float, runs: dict, cart: System) -> None:
    motion, gains = runs[name]
    ends = unit_vectors(cart, motion.q[-1])
    by_hand = sum(math.dist(end, (0.0, 0.0, s)) for end, s in zip(ends, gains.s, strict=True))
    assert by_hand == pytest.approx(e_q, rel=1e-3)
    assert errors(cart, gains, motion.x)[0][-1] == pytest.approx(by_hand, rel=1e-6)


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
        "off (deg)" in label for label in labels
    ) == 5
    curves = {line.get_label(): line.get_ydata() for axes in held.axes for line in axes.get_lines()}
    # A chord for every angle from upright or hanging: 6, 4, 4, 5 and 35 degrees.
    chords = sum(2 * np.sin(np.radians(angle) / 2) for angle in (6, 4, 4, 5, 35))
    assert curves["$e_q$"][0] == pytest.approx(chords)
    for k in (0, 1):
        np.testing.assert_array_equal(curves[f"$u_{k + 1}$"], runs["B4"][0].u[:, k])
