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
from phichain.report import figures, panels
from phichain.report.geometry import joints
from phichain.report.orbits import plane
from phichain.report.style import figure, look, save
from phichain.system import Numbers, System
from phichain.system.starts import leaning
from tests.handmade import paper_b, uniform_planar

matplotlib = pytest.importorskip("matplotlib")
from matplotlib.text import Text


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
    side, front, above, space, errors, place, force = drawing.axes
    # A chain in space is seen from three sides and in perspective; what is drawn last is its end.
    tip = np.array(joints(cart, motion.q))[-1] * [1, 1, -1]
    for axes, columns in ((side, [0, 2]), (front, [1, 2]), (above, [0, 1])):
        drawn = next(line for line in reversed(axes.get_lines()) if len(line.get_xdata()) == len(tip))
        np.testing.assert_allclose(drawn.get_xydata(), tip[:, columns])
    np.testing.assert_allclose(np.array(space.get_lines()[-1].get_data_3d()).T, tip)
    np.testing.assert_allclose(curves(errors)["$e_q$"][:, 1], falling)
    assert list(curves(errors)) == ["$e_q$", r"$e_\omega$ (rad/s)"]
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


def test_a_legend_of_two_rows_is_read_row_by_row() -> None:
    axes = figure().add_subplot()
    panels.against_time(axes, [0, 1], np.zeros((2, 7)), [f"link {k}" for k in range(1, 8)], "angle")
    read = [text.get_text() for text in axes.get_legend().get_texts()]
    # Matplotlib fills four columns of two, the last of one.
    rows = [read[0], read[2], read[4], read[6], read[1], read[3], read[5]]
    assert rows == [f"link {k}" for k in range(1, 8)]


@pytest.mark.parametrize(("holds", "words", "turned"), [(1.0, 1, 0.0), (1.8, 1, 90.0), (1.99, 0, None), (2.0, 0, None)])
def test_the_grey_of_a_run_says_what_it_means_where_words_have_room(holds: float, words: int, turned: float | None) -> None:
    axes = figure().add_subplot()
    axes.set_xlim(0, 2)
    panels.beyond(axes, holds, 2.0)
    assert [text.get_text() for text in axes.texts] == ["errors may be large"] * words
    assert [text.get_rotation() for text in axes.texts] == ([] if turned is None else [turned])
    assert len(axes.patches) == (holds < 2.0)


@pytest.mark.parametrize("way", (1, -1))
def test_labels_that_lay_on_one_another_do_not_any_more(way: int) -> None:
    drawing = figure()
    axes = drawing.subplots()
    axes.set(xlim=(0, 1), ylim=(0, 1))
    labels = [plane._label(axes, f"opens [{k}]", (0.5 + 0.01 * k, 0.5), (5, 5), "k") for k in range(4)]
    plane.set_apart(drawing, labels, way)
    boxes = [Text.get_window_extent(label) for label in labels]
    assert not [(a, b) for k, a in enumerate(boxes) for b in boxes[:k] if a.overlaps(b)]
    assert labels[0].xyann == (5, 5) and all(way * label.xyann[1] > way * 5 for label in labels[1:])


def test_the_picture_of_a_chain_of_64_has_no_dots_and_a_bar_of_colours() -> None:
    many = replace(uniform_planar(64), numbers=Numbers(length=[1 / 64] * 64))
    motion = simulate(many, leaning(many, 0.2), np.linspace(0, 0.01, 3), tol=1e-3, error_estimate=False)
    chain, *_, bar = figures.motion(many, motion).axes
    assert {line.get_marker() for line in chain.get_lines()} <= {"", "None"} and [text.get_text() for text in bar.get_yticklabels()] == ["link 1", "link 64"]
