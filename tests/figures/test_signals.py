"""Figs 3 to 6 of paper A: the surfaces against closed forms at their ends, and the page that shows them."""

from __future__ import annotations

import base64
import json
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from phichain.errors import UnsupportedError
from phichain.fractional import Propagation
from phichain.motion import simulate
from phichain.papers import figures
from phichain.papers.figures import START
from phichain.papers.signals import draw_signals, released, signal_system, write_sheets, write_viewer
from phichain.report.signals.propagation import Wave, paths, plain_names, size_of_orders, surfaces
from phichain.report.signals.viewer import pack, viewer
from phichain.scene import Scene
from phichain.scene.library import find_scene
from phichain.system import System

Case = tuple[System, Propagation]


def motion(case: Case) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """theta, theta' and theta'' of the same release, by a tighter run."""
    system, wave = case
    start = (START * np.eye(system.nq)[0], np.zeros(system.nv))
    run = simulate(system, start, wave.time, tol=1e-12)
    return run.q, run.v, run.a


def test_the_motions_start_as_printed(wave: Case, single: Case) -> None:
    """Figs 3 to 6: theta = (0.4, 0, ..., 0) at rest, m_k = l_k = 1/N, r_k = l_k/2."""
    for system, found in (wave, single):
        links = system.links
        chain = system.scene["chain"]
        sizes = [np.broadcast_to(np.asarray(chain[key], dtype=float), links) for key in ("mass", "length", "com")]
        np.testing.assert_allclose(sizes, [[1 / links] * links, [1 / links] * links, [0.5 / links] * links], rtol=1e-15)
        q, v, _ = motion((system, found))
        np.testing.assert_array_equal(q[0], [0.4, *[0] * (links - 1)])
        assert not v[0].any()
        # -G by hand: in the relative reading the chain is straight, so joint k carries what is beyond it at one angle.
        if system.scene["joints"]["angles"] == "relative":
            arm = [sum((j - k + 0.5) / links**2 for j in range(k, links)) for k in range(links)]
            np.testing.assert_allclose(found.surface("theta_p", 0)[0, 0], -9.81 * arm[0] * np.sin(0.4), rtol=1e-12)


def test_the_signal_starts_as_the_force_and_becomes_the_acceleration(wave: Case) -> None:
    system, found = wave
    q, v, a = motion(wave)
    force = -system.coriolis(q, v) - system.gravity_torque(q)
    for k in range(system.links):
        surface = found.surface("theta_p", k)
        np.testing.assert_allclose(surface[:, 0], force[:, k], rtol=0, atol=1e-7 * np.abs(force).max())
        np.testing.assert_allclose(surface[:, -1], a[:, k], rtol=0, atol=1e-7 * np.abs(a).max())


def test_the_signal_ends_as_the_angle(wave: Case) -> None:
    system, found = wave
    q, v, a = motion(wave)
    for k in range(system.links):
        psi = found.surface("psi", k)
        np.testing.assert_allclose(psi[:, -1], a[:, k], rtol=0, atol=1e-7 * np.abs(a).max())
        np.testing.assert_allclose(psi[1:, 30], v[1:, k], rtol=0, atol=1e-5 * np.abs(v).max())
        np.testing.assert_allclose(psi[1:, 0], q[1:, k], rtol=0, atol=1e-5 * np.abs(q).max())
        # What the paper draws lacks the initial terms: D^-2 theta'' misses theta(0).
        bare = found.surface("psi", k, "feedback")
        np.testing.assert_allclose(bare[1:, 0], q[1:, k] - q[0, k], rtol=0, atol=1e-5 * np.abs(q).max())


def test_one_link_is_a_power_of_a_number(single: Case) -> None:
    _, found = single
    theta = motion(single)[0][:, 0]
    force = -9.81 * 0.5 * np.sin(theta)
    # I = m r^2 = 1/4.
    expected = force[:, None] * 4.0**found.p
    np.testing.assert_allclose(found.surface("theta_p", 0), expected, rtol=0, atol=1e-8)
    assert np.all(found.surface("theta_p", 0, "coriolis") == 0)


def test_the_parts_of_the_feedback_add_up(wave: Case) -> None:
    system, found = wave
    for kind in ("theta_p", "psi"):
        for k in range(system.links):
            parts = found.surface(kind, k, "coriolis") + found.surface(kind, k, "gravity")
            joined = found.surface(kind, k, "feedback")
            np.testing.assert_allclose(parts, joined, rtol=0, atol=1e-9 * np.abs(joined).max())


def test_sizes_leave_the_unbounded_start_out() -> None:
    time = np.linspace(0, 1, 101)
    surface = np.stack([np.cos(9 * time), np.where(time < 0.04, np.nan, 0.0), np.r_[1e9, time[1:]]], axis=1)
    np.testing.assert_allclose(size_of_orders(time, surface), [np.abs(np.cos(9 * time[5:])).max(), 1.0, 1.0])


def test_the_sheets_show_every_coordinate_and_part(single: Case) -> None:
    _, found = single
    sheet, parts = surfaces(found, "title"), paths(found, "title")
    assert len(sheet.axes) == 6 and len(parts.axes) == 2 * 3
    # The map of the first wave: its mesh holds theta_p over the size of every order.
    first = Wave.of(found, 0)
    mesh = sheet.axes[2].collections[0].get_array()
    np.testing.assert_allclose(mesh, (first.theta_p / first.sizes[0]).T)
    assert np.abs(mesh).max() == pytest.approx(1.0, abs=0.3)


@pytest.mark.long
def test_figures_5_and_6_show_link_1_alone(wave: Case, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert len(surfaces(wave[1], "title", 1).axes) == 6 and len(surfaces(wave[1], "title").axes) == 18
    shown = {}
    monkeypatch.setattr(figures, "paper_a_wave", lambda system: wave[1])
    monkeypatch.setattr(figures, "write_viewer", lambda *words: tmp_path)
    monkeypatch.setattr(figures, "write_sheets", lambda stem, *words: shown.setdefault(stem, words[-1]) and [])
    for name in ("A3", "A4", "A5", "A6"):
        figures.draw(name, tmp_path)
    assert shown == {"A3": 1, "A4": 2, "A5": 1, "A6": 1}


def unpacked(text: str) -> np.ndarray:
    whole = np.frombuffer(base64.b64decode(text), dtype="<i2").astype(float)
    return np.where(whole == -32768, np.nan, whole / (32767 / 2))


def test_packed_samples_come_back() -> None:
    values = np.array([0.0, 0.5, -1.0, 3.0, np.nan])
    np.testing.assert_allclose(unpacked(pack(values)), [0.0, 0.5, -1.0, 2.0, np.nan], atol=4e-5)


def test_the_page_holds_the_surfaces_and_needs_nothing_else(wave: Case) -> None:
    system, found = wave
    page = viewer("Signals <b>", "A & B", {"a </script> chain": found})
    assert "Signals &lt;b&gt;" in page and "A &amp; B" in page
    assert not re.search(r"https?:|src=|@import|url\(", page)
    assert page.count("<script") == page.count("</script>") == 3
    data = json.loads(re.search(r'id="data">(.*?)</script>', page, re.DOTALL)[1])
    (stored,) = data["motions"]
    assert stored["coordinates"] == plain_names(found) == [f"\u03b8{k + 1}" for k in range(system.links)]
    assert stored["orders"][0] == 0 and stored["orders"][-1] == 3 and np.all(np.diff(stored["orders"]) > 0)
    wave_of = Wave.of(found, 0)
    kept = stored["waves"]["total"][0]
    values = (
        unpacked(kept["values"]).reshape(len(stored["orders"]), stored["times"])
        * np.array(kept["sizes"])[:, None]
    )
    np.testing.assert_allclose(values[30], wave_of.theta_p[:, -1], atol=1e-4 * kept["sizes"][30])
    np.testing.assert_allclose(values[-1], wave_of.psi[:, 0], atol=1e-4 * kept["sizes"][-1])


@pytest.mark.skipif(shutil.which("node") is None, reason="no JavaScript engine here")
def test_the_script_is_well_formed() -> None:
    script = Path(__file__).parents[2] / "codegen/phichain/report/signals/viewer.js"
    subprocess.run(["node", "--check", str(script)], check=True)


@pytest.mark.skipif(shutil.which("node") is None, reason="no JavaScript engine here")
def test_the_page_works_without_a_server(wave: Case, single: Case, tmp_path: Path) -> None:
    """Its script alone, in a document of stubs: every control is worked, and what is drawn is finite."""
    page = tmp_path / "page.html"
    page.write_text(viewer("title", "lead", {"three": wave[1], "one": single[1]}))
    run = subprocess.run(
        ["node", str(Path(__file__).with_name("viewer_dom.js")), str(page)],
        check=True,
        capture_output=True,
        text=True,
    )
    seen = json.loads(run.stdout)
    assert seen["bad"] == [] and all(count > 0 for count in seen["strokes"].values())
    first, last, *_, clicked, played = seen["readings"]
    assert (
        first.startswith("θ1 at p = 0.000")
        and last.startswith("θ1 at α = -2.000")
        and "initial terms" in last
    )
    assert clicked != played and all(reading.endswith("in SI units") for reading in seen["readings"])


@pytest.mark.long
def test_any_planar_scene_can_be_followed(tmp_path: Path) -> None:
    scene = Scene(
        "sprung",
        1,
        base="cart",
        mass="runtime",
        length=0.5,
        cart_mass=1.0,
        stiffness=2.0,
        damping=0.1,
        real="float",
    )
    system = signal_system(scene, {"mass": np.array([0.4])})
    found = released(system, 0.2, 41, u=[0.3])
    assert list(found.forces) == ["total", "coriolis", "gravity", "feedback", "input", "joints"]
    assert system.real == "double" and plain_names(found) == ["cart", "\u03b81"]
    np.testing.assert_allclose(found.surface("theta_p", 0, "input")[:, 0], 0.3)
    # The spring alone at the start: -k theta at rest.
    assert found.forces["joints"][0, 1] == pytest.approx(-2.0 * 0.5)
    written = draw_signals(scene, found, tmp_path)
    assert [path.suffix for path in written] == [".png", ".png", ".html"]
    assert all(path.stat().st_size > 20_000 for path in written)


def test_the_same_signals_are_the_same_files(single: Case, tmp_path: Path) -> None:
    _, found = single
    for name in ("a", "b"):
        write_sheets("A3", "", "title", found, tmp_path / name)
        write_viewer("A3", "title", "lead", {"chain": found}, tmp_path / name)
    first, second = (sorted((tmp_path / name).iterdir()) for name in ("a", "b"))
    assert len(first) == 3 and [path.read_bytes() for path in first] == [path.read_bytes() for path in second]


def test_a_spatial_scene_is_refused_before_anything_is_built() -> None:
    with pytest.raises(UnsupportedError, match="no signal propagation.*second integral"):
        signal_system(find_scene("paper_b"))
