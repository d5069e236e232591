"""Fig. 7 of paper A: the families and what is drawn over them, each against another route."""

from __future__ import annotations

import json
from pathlib import Path

import mpmath
import numpy as np
import pytest
from scipy.special import jv

from phichain.motion import simulate
from phichain.orbits import conical_families, trace
from phichain.orbits.conical import NEEDED
from phichain.papers.families import exact_families, shooting_chain
from phichain.papers.figures import families, paper_a_chain, slowest_family
from phichain.pipeline import build
from phichain.report.orbits import plane
from phichain.report.papers.charts import charts, hanging_chain_frequency, known_orbits, pendulum_frequency
from phichain.scene import scene_from_dict

OMEGA_0 = np.sqrt(9.81 / 0.5)


@pytest.fixture(scope="module")
def short() -> dict:
    return {links: families(links) for links in (1, 2, 3)}


@pytest.mark.long
def test_one_link_is_paper_a_s_equation_21(short: dict) -> None:
    (family,) = short[1]
    amplitude, omega = family.column("amplitude_theta_1"), family.column("omega")
    assert amplitude[-1] > 3.14
    np.testing.assert_allclose(0.5 * omega**2 * amplitude, 2 * 9.81 * jv(1, amplitude), rtol=1e-12)


def test_families_start_at_the_linear_modes_and_go_to_large_swings(short: dict) -> None:
    for links, branches in short.items():
        assert len(branches) == links
        starts = [branch.column("omega")[0] for branch in branches]
        assert np.all(np.diff(starts) > 0)
        for branch in branches:
            assert np.abs(branch.points[:, :-1]).max() > 3.14 and branch.residual.max() < 1e-12


def test_the_exact_curve_is_the_pendulum_s() -> None:
    for amplitude in (1e-6, 0.1, 2.0, 3.1, np.pi - 1e-4):
        with mpmath.workdps(40):
            exact = mpmath.pi * OMEGA_0 / (2 * mpmath.ellipk(mpmath.sin(mpmath.mpf(amplitude) / 2) ** 2))
        assert pendulum_frequency(amplitude, OMEGA_0) == pytest.approx(float(exact), rel=1e-11)
    # One harmonic is true to the second order in A and wrong at pi.
    assert pendulum_frequency(0.1, OMEGA_0) == pytest.approx(np.sqrt(4 * 9.81 * jv(1, 0.1) / 0.1), rel=1e-6)


def test_the_orbits_are_the_reference_s() -> None:
    reference = json.loads((Path(__file__).parents[1] / "data/limit_cycles.json").read_text())["points"]
    assert len(known_orbits()) == len(reference) == 13
    for orbit, entry in zip(known_orbits(), reference, strict=True):
        assert (orbit.links, orbit.mode) == (entry["N"], entry["mode"])
        assert orbit.omega == float(entry["omega"]) and orbit.theta0 == tuple(map(float, entry["theta0"]))
        assert orbit.stable is (entry["linear_stability"] == "stable")


@pytest.mark.parametrize("orbit", [known_orbits()[k] for k in (3, 6, 9, 12)], ids=str)
def test_the_orbits_come_back(orbit) -> None:
    system = paper_a_chain(orbit.links)
    q, v = np.array(orbit.theta0), np.zeros(orbit.links)
    run = simulate(system, (q, v), [0.0, np.pi / orbit.omega, 2 * np.pi / orbit.omega], tol=1e-12)
    np.testing.assert_allclose(run.q[1:], [-q, q], rtol=0, atol=1e-9)


@pytest.mark.long
def test_the_slowest_mode_tends_to_the_hanging_chain() -> None:
    limit = hanging_chain_frequency()
    assert limit == pytest.approx(2.404825557695773 / 2 * np.sqrt(9.81), rel=1e-15)
    gaps = {links: slowest_family(links).column("omega")[0] - limit for links in (8, 16, 32)}
    assert gaps[8] / gaps[16] == pytest.approx(4, abs=0.1) and gaps[16] / gaps[32] == pytest.approx(
        4, abs=0.05
    )
    assert 0 < gaps[32] < 1e-3


def test_the_sheet_shows_families_orbits_and_the_exact_curve(short: dict) -> None:
    long = {links: short[links][0] for links in (1, 2)}
    sheet = charts(short, long, OMEGA_0)
    first, second = sheet.axes[0], sheet.axes[1]
    shown = [line.get_xydata() for line in first.get_lines()]
    family = short[1][0]
    np.testing.assert_array_equal(
        shown[0], np.column_stack([family.column("amplitude_theta_1"), family.column("omega")])
    )
    points = [data[0] for data in shown if len(data) == 1]
    assert len(points) == 4 and points[0][1] == pytest.approx(
        pendulum_frequency(points[0][0], OMEGA_0), rel=1e-12
    )
    assert any(line.get_linestyle() == "--" for line in first.get_lines())
    # Two angles of three orbits, one of them unstable, so hollow.
    orbits = [line for line in second.get_lines() if len(line.get_xdata()) == 1]
    assert len(orbits) == 6 and sum(line.get_markerfacecolor() == "white" for line in orbits) == 2


@pytest.mark.long
def test_the_exact_families_are_drawn_over_one_harmonic(short: dict) -> None:
    exact = {links: exact_families(links) for links in (1, 2)}
    sheet = charts({links: short[links] for links in (1, 2)}, {1: short[1][0]}, OMEGA_0, exact)
    dotted = [line.get_xydata() for line in sheet.axes[1].get_lines() if line.get_linestyle() == ":"]
    family = exact[2][0]
    for k, data in enumerate(dotted):
        np.testing.assert_array_equal(data, np.column_stack([family.column(f"theta_{k + 1}"), family.column("omega")]))
    assert len(dotted) == 2
    # The hollow and full dots of the reference lie on them.
    for line in sheet.axes[1].get_lines():
        if len(line.get_xdata()) == 1:
            at = line.get_xydata()[0]
            assert min(np.min(np.hypot(*(data - at).T)) for data in dotted) < 0.06


def test_several_families_in_one_picture_have_all_their_events() -> None:
    exact = exact_families(2)
    sheet = plane.energies(exact, "two")
    (axes,) = sheet.axes
    marks = [line for line in axes.get_lines() if len(line.get_xdata()) == 1]
    assert len(marks) == sum(len(branch.own_events) for branch in exact)
    assert "3 of mode 2" in {text.get_text() for text in axes.texts}
    kinds = {event.kind.split(" of ")[0].rstrip("0123456789 ") for branch in exact for event in branch.own_events}
    assert kinds | {"mode 1", "mode 2"} == {text.get_text() for text in axes.get_legend().get_texts()}


def test_a_network_says_what_hangs_on_what() -> None:
    system = shooting_chain(2)
    found = trace(system, 1, until="theta_1=1.2", switch=True, generations=1, limits={"max_points": 60})
    (axes,) = plane.network(found).axes
    said = " ".join(text.get_text() for text in axes.texts)
    for link in found.links:
        assert link.to < 0 or f"{link.how} [{link.to}]" in said
    assert len(axes.get_legend().get_texts()) == len(found) > 1


def test_conical_families_are_drawn_over_angular_momentum() -> None:
    scene = {"name": "cone1", "chain": {"links": 1, "space": "spatial", "mass": 0.7, "length": 0.5}, "functions": {"want": list(NEEDED)}}
    families = conical_families(build(scene_from_dict(scene)))
    angles, momentum = plane.conical(families).axes
    np.testing.assert_array_equal(momentum.get_lines()[0].get_xydata(), np.column_stack([families[0].momentum, families[0].energy]))
    assert np.isfinite(momentum.get_lines()[1].get_xdata()).all() and len(angles.get_lines()) >= 2
