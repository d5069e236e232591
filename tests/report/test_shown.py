"""Records show themselves: in a line, as a picture, in motion, in a notebook, as named arrays."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from phichain.control import lqr
from phichain.errors import OutputError, PhichainError, UnsupportedError
from phichain.motion import Trajectory, simulate
from phichain.orbits import trace
from phichain.records import Shown
from phichain.report import moving, shown
from phichain.report.geometry import joints, outline
from phichain.report.style import figure, look, save
from phichain.system import Numbers
from phichain.system.starts import leaning
from tests.handmade import paper_b, uniform_planar

matplotlib = pytest.importorskip("matplotlib")

CHAIN = replace(uniform_planar(2), numbers=Numbers(length=[0.5] * 2))


@pytest.fixture(scope="module")
def swing() -> Trajectory:
    return simulate(CHAIN, leaning(CHAIN, 0.4), np.linspace(0, 1, 21), tol=1e-6)


def test_a_record_is_one_line_where_it_is_looked_at(swing: Trajectory) -> None:
    assert repr(swing).startswith("<Trajectory ") and "\n" not in repr(swing) and len(repr(swing)) < 300
    assert repr(lqr(paper_b())).startswith("<Gains ")


def test_a_motion_knows_its_chain_also_from_a_file(swing: Trajectory, tmp_path: Path) -> None:
    read = Trajectory.from_npz(swing.to_npz(tmp_path / "swing.npz"))
    for motion in (swing, read):
        assert np.array_equal(joints(outline(motion), motion.q), joints(CHAIN, swing.q))
    assert np.array_equal(read.plot(figure().add_subplot()).get_lines()[1].get_ydata(), swing.plot(figure().add_subplot()).get_lines()[1].get_ydata())
    with pytest.raises(PhichainError, match="is not known of this Trajectory"):
        replace(swing, lengths=None).plot()


@pytest.mark.parametrize("of", ["angles", "chain"])
def test_panels_are_drawn_on_given_axes(swing: Trajectory, of: str) -> None:
    with look():
        axes = figure().add_subplot()
        assert swing.plot(axes, of=of) is axes and axes.get_lines()
    with pytest.raises(UnsupportedError, match="use one of angles, chain, energy"):
        swing.plot(axes, of="phase")


def test_more_links_than_a_legend_holds_get_a_bar() -> None:
    many = replace(uniform_planar(12), numbers=Numbers(length=[0.1] * 12))
    motion = simulate(many, leaning(many, 0.2), np.linspace(0, 0.02, 3), tol=1e-4, error_estimate=False)
    axes = motion.plot(figure().add_subplot())
    labels = [text.get_text() for other in axes.figure.axes if other is not axes for text in other.get_yticklabels()]
    assert labels == ["link 1", "link 12"] and axes.get_legend() is None


@pytest.mark.parametrize("kind", [".gif", ".html", ".mp4"])
def test_a_motion_moves(swing: Trajectory, kind: str, tmp_path: Path) -> None:
    if kind == ".mp4" and shutil.which("ffmpeg") is None:
        with pytest.raises(UnsupportedError, match="needs ffmpeg"):
            swing.animate(tmp_path / "swing.mp4")
        return
    path = swing.animate(tmp_path / f"swing{kind}", seconds=1.0, fps=4)
    assert path.stat().st_size > 3000 and [file.name for file in tmp_path.iterdir()] == [path.name]
    if kind == ".html":
        assert "://" not in path.read_text().replace("http://www.w3.org", ""), "it plays without a network"
    if kind == ".gif":
        from PIL import Image

        with Image.open(path) as picture:
            assert picture.n_frames == 4  # type: ignore[attr-defined]


def test_a_chain_in_space_has_four_views() -> None:
    cart = replace(paper_b(), numbers=Numbers(length=[0.1] * 5))
    motion = simulate(cart, leaning(cart, 0.3), np.linspace(0, 0.05, 3), tol=1e-4, error_estimate=False)
    drawing = figure()
    panels = moving._panels(drawing, outline(motion), joints(cart, motion.q))
    assert len(panels) == len(drawing.axes) == 4
    panels[0].at(2)
    assert np.allclose(panels[0].chain.get_data(), [joints(cart, motion.q)[2, :, 0], -joints(cart, motion.q)[2, :, 2]])


@pytest.mark.parametrize(("name", "words", "said"), [("a.avi", {}, "name it .gif, .html or .mp4"), ("a.gif", {"fps": 0}, "1 to 60"), ("a.gif", {"seconds": 1e4}, "fewer seconds")])
def test_what_cannot_be_animated_is_one_sentence(swing: Trajectory, name: str, words: dict[str, float], said: str, tmp_path: Path) -> None:
    with pytest.raises(PhichainError, match=said):
        swing.animate(tmp_path / name, **words)
    assert not list(tmp_path.iterdir())


def test_what_does_not_move_or_is_not_drawn_says_so(tmp_path: Path) -> None:
    with pytest.raises(UnsupportedError, match="holds no motion"):
        lqr(paper_b()).animate(tmp_path / "gains.gif")
    with pytest.raises(UnsupportedError, match="has no picture"):
        Shown().plot()
    with pytest.raises(UnsupportedError, match="no form with named axes"):
        Shown().to_xarray()


def test_a_notebook_gets_words_and_a_picture_and_words_alone_without_one(swing: Trajectory) -> None:
    assert swing._repr_html_().startswith("<pre>") and "data:image/png;base64," in swing._repr_html_()
    assert swing.plot()._repr_png_().startswith(b"\x89PNG"), "its picture needs no pyplot"
    assert "<img" not in shown.html(replace(swing, lengths=None)) and "&lt;" in shown.html(replace(swing, name="<b>"))


def test_named_arrays_are_the_records(swing: Trajectory) -> None:
    data = swing.to_xarray()
    assert np.array_equal(data.q.sel(q_name="theta_2"), swing.q[:, 1]) and data.t.attrs["units"] == "s"
    branch = trace(uniform_planar(1), 1, 0.2, method="one harmonic")
    assert np.array_equal(branch.to_xarray()["omega"], branch.column("omega"))
    gains = lqr(paper_b())
    assert np.array_equal(gains.to_xarray().K, gains.K)
    for record in (branch, gains):
        axes = figure().add_subplot()
        assert record.plot(axes) is axes and axes.get_lines()


def test_pictures_in_lines_are_the_same_file_twice(swing: Trajectory, tmp_path: Path) -> None:
    for kind in (".svg",):
        first, second = (save(swing.plot(), tmp_path / f"{name}{kind}").read_bytes() for name in "ab")
        assert first == second and len(first) > 1000


def test_a_file_of_another_kind_is_refused(swing: Trajectory, tmp_path: Path) -> None:
    with pytest.raises(OutputError):
        swing.animate(tmp_path / "folder")
