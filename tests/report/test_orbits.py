"""Single orbits drawn and in motion: what the pictures hold, and that they are the same file twice."""

from __future__ import annotations

import itertools
import json
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from phichain.orbits import Orbit, pick, trace
from phichain.report import figures
from phichain.report.geometry import joints
from phichain.report.orbits import animation
from phichain.system import System
from tests.orbits.shot import uniform


@pytest.fixture(scope="module")
def system() -> System:
    return uniform(2)


@pytest.fixture(scope="module")
def found(system: System) -> Orbit:
    return pick(system, trace(system, 1, until="theta_1=1.2"))


def test_an_orbit_is_drawn_with_its_multipliers(system: System, found: Orbit) -> None:
    chain, angles, circle = figures.orbit(system, found).axes
    np.testing.assert_allclose(angles.get_lines()[1].get_ydata(), found.q.sum(axis=1))
    assert circle.get_title("left") == "unstable" and chain.get_title("left").startswith(f"T = {found.period:.6g}")
    dots = circle.get_lines()[1]
    # One far out is drawn at two, in its direction, and its size is written beside it.
    assert sorted(dots.get_xdata()) == pytest.approx([np.min(found.multipliers.real), 2.0])
    assert circle.texts[0].get_text() == f"{np.max(np.abs(found.multipliers)):.3g}"


def test_a_gif_shows_one_period_and_is_the_same_twice(system: System, found: Orbit, tmp_path: Path) -> None:
    first, second = (animation.write_gif(system, found, tmp_path / name) for name in ("a.gif", "b.gif"))
    assert first.read_bytes() == second.read_bytes()
    with Image.open(first) as picture:
        assert picture.n_frames == animation.FRAMES and picture.info["loop"] == 0
        assert picture.n_frames * picture.info["duration"] == pytest.approx(1000 * found.period, rel=0.05)
        pixels = []
        for frame in range(0, picture.n_frames, 15):
            picture.seek(frame)
            pixels.append(np.asarray(picture.convert("L")))
    assert all(np.count_nonzero(one != other) > 100 for one, other in itertools.pairwise(pixels))


def test_a_page_carries_the_motion_and_needs_nothing(system: System, found: Orbit) -> None:
    page = animation.page(system, found)
    data = json.loads(re.search(r"const data = (\{.*\});", page)[1])
    points = joints(system, found.q)
    np.testing.assert_allclose(data["points"], np.stack([points[..., 0], -points[..., 1]], axis=-1), atol=1e-5)
    assert data["seconds"] == pytest.approx(found.period)
    assert "http" not in page and "@" not in re.sub(r"@media", "", page) and "unstable" in page
