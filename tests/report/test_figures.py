"""Figures show the data they were given: curves are read back from the axes and compared."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from phichain.errors import OutputError, UnsupportedError
from phichain.motion import Trajectory, simulate
from phichain.orbits import trace
from phichain.orbits.single_harmonic import energy_of_amplitude
from phichain.report import figures
from phichain.report.style import look, save
from phichain.system import Numbers, System
from phichain.system.starts import leaning
from tests.handmade import paper_b, uniform_planar

matplotlib = pytest.importorskip("matplotlib")


@pytest.fixture(scope="module")
def chain() -> System:
    return replace(uniform_planar(3), numbers=Numbers(length=[1 / 3] * 3))


@pytest.fixture(scope="module")
def swing(chain: System) -> Trajectory:
    return simulate(chain, leaning(chain, 0.4), np.linspace(0, 1, 41), tol=1e-6)


@pytest.fixture(scope="module")
def cart() -> System:
    return replace(paper_b(), numbers=Numbers(length=[0.1] * 5))


def curves(axes: object) -> dict[str, np.ndarray]:
    return {line.get_label(): line.get_xydata() for line in axes.get_lines()}  # type: ignore[attr-defined]


def test_a_motion_shows_angles_energy_and_the_chain(chain: System, swing: Trajectory) -> None:
    drawing = figures.motion(chain, swing)
    chain_axes, angle_axes, energy_axes = drawing.axes
    shown = curves(angle_axes)
    for k in range(3):
        expected = np.column_stack([swing.t, np.cumsum(swing.q, axis=1)[:, k]])
        np.testing.assert_allclose(shown[f"link {k + 1}"], expected)
    (error,) = energy_axes.get_lines()
    assert error.get_ydata().max() == pytest.approx(swing.energy_drift / np.max(np.abs(swing.energy)))
    tip = chain_axes.get_lines()[0].get_xydata()
    np.testing.assert_allclose(np.hypot(*tip[0]), 1.0)
    assert energy_axes.get_yscale() == "log"


def test_a_driven_motion_shows_its_balance(chain: System, swing: Trajectory) -> None:
    worked = replace(swing, work=np.linspace(0.0, 2.0, 41), loss=np.linspace(0.0, 0.5, 41))
    energy_axes = figures.motion(chain, worked).axes[2]
    (error,) = energy_axes.get_lines()
    off = swing.energy - swing.energy[0] - 1.5 * np.linspace(0.0, 1.0, 41)
    np.testing.assert_allclose(error.get_ydata(), np.abs(off[1:]) / np.max(np.abs(swing.energy)))
    assert energy_axes.get_ylabel() == "energy balance, relative"


def test_a_motion_without_energy_leaves_that_panel_out(chain: System, swing: Trajectory) -> None:
    drawing = figures.motion(chain, replace(swing, kinetic=None, potential=None))
    assert [axes.get_visible() for axes in drawing.axes] == [True, True, False]


def test_a_controlled_chain_shows_errors_cart_and_force(cart: System) -> None:
    motion = simulate(cart, leaning(cart, 0.1), np.linspace(0, 0.2, 11), tol=1e-5, u=[0.1, -0.2])
    falling = np.exp(-motion.t)
    drawing = figures.closed_loop(cart, motion, falling, 2 * falling)
    _, errors, place, force = drawing.axes
    np.testing.assert_allclose(curves(errors)["$e_q$"][:, 1], falling)
    np.testing.assert_allclose(curves(place)["x_2"][:, 1], motion.q[:, 1])
    np.testing.assert_allclose(curves(force)["force_2"][:, 1], -0.2)


def test_a_controlled_chain_on_a_fixed_base_has_no_cart_panel() -> None:
    fixed = replace(uniform_planar(2, actuated="all"), numbers=Numbers(length=[0.5] * 2))
    motion = simulate(fixed, leaning(fixed, 0.1), np.linspace(0, 0.2, 11), tol=1e-5, u=[0.1, -0.2])
    drawing = figures.closed_loop(fixed, motion, np.exp(-motion.t), np.exp(-motion.t))
    _, _, torque = drawing.axes
    np.testing.assert_allclose(curves(torque)[fixed.u_names[1]][:, 1], -0.2)


def test_a_family_is_drawn_over_every_links_amplitude() -> None:
    branch = trace(uniform_planar(2), amplitude_max=2.5)
    energy = energy_of_amplitude(uniform_planar(2))
    left, right, listed = figures.family(branch).axes
    shown = curves(left)
    for k in (1, 2):
        expected = np.column_stack([branch.column(f"amplitude_theta_{k}"), branch.column("omega")])
        np.testing.assert_allclose(shown[f"$A_{{{k}}}$"], expected)
    np.testing.assert_allclose(right.get_lines()[0].get_xdata(), branch.energy)
    events = branch.events[:-1]
    assert {"fold in omega", "energy extremum"} <= {event.kind for event in events}
    # Every event is marked on every link and on the energy, numbered, and named in the list.
    places = {(line.get_xdata()[0], line.get_ydata()[0]) for line in left.get_lines() if len(line.get_xdata()) == 1}
    assert places == {(event.z[k], event.z[-1]) for event in events for k in (0, 1)}
    assert sum(len(line.get_xdata()) == 1 for line in right.get_lines()) == len(events)
    numbers = {word for text in left.texts for word in text.get_text().split(",")}
    assert numbers == {str(k + 1) for k in range(len(events))}
    for k, event in enumerate(events):
        assert listed.texts[k].get_text().startswith(f"{k + 1}  {event.kind}: {event.z[-1]:.6g} rad/s")
        along = [line.get_xdata()[0] for line in right.get_lines() if len(line.get_xdata()) == 1][k]
        assert along == pytest.approx(energy(event.z), rel=1e-4, abs=1e-6)


def test_stable_orbits_are_drawn_thick() -> None:
    branch = trace(uniform_planar(1), amplitude_max=1.0)
    kappa = np.linspace(0.5, 1.5, len(branch))[:, None].astype(complex)
    axes = figures.family(replace(branch, method="shooting", multipliers=kappa)).axes[0]
    thick = next(line for line in axes.get_lines() if line.get_linewidth() > 2)
    assert np.array_equal(np.isfinite(thick.get_xdata()), kappa[:, 0].real <= 1)


def test_angles_beyond_pi_are_said_and_not_drawn() -> None:
    branch = trace(uniform_planar(1), amplitude_max=3.0)
    points = branch.points.copy()
    points[-3:, 0] = 3.3
    axes = figures.family(replace(branch, points=points)).axes[0]
    assert "not drawn beyond" in axes.get_xlabel() and np.nanmax(axes.get_lines()[0].get_xdata()) < np.pi


def test_a_family_without_energy_is_one_panel() -> None:
    branch = trace(uniform_planar(1, leave_out=["energy"]), amplitude_max=1.0)
    assert len(figures.family(branch).axes) == 1


def test_a_figure_is_written_whole_and_the_same_twice(chain: System, swing: Trajectory, tmp_path: Path) -> None:
    first = save(figures.motion(chain, swing), tmp_path / "deep" / "a.png")
    second = save(figures.motion(chain, swing), tmp_path / "b.png")
    assert first.read_bytes() == second.read_bytes()
    assert first.read_bytes().startswith(b"\x89PNG") and first.stat().st_size > 20_000
    assert sorted(path.name for path in tmp_path.iterdir()) == ["b.png", "deep"]


def test_a_figure_that_cannot_be_written_says_so(chain: System, swing: Trajectory, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(OutputError, match="cannot be written"):
        save(figures.motion(chain, swing), tmp_path / "file" / "a.png")


def test_without_matplotlib_the_message_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(UnsupportedError, match=r"pip install 'phichain\[plot\]'"), look():
        pass
