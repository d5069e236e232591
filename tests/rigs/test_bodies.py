"""Bodies against sums over many small points, links against cutting them up, and each bad number in one sentence."""

from __future__ import annotations

from dataclasses import FrozenInstanceError
from math import pi, sqrt

import numpy as np
import pytest

from phichain import rigs
from phichain.errors import SceneError
from phichain.scene import Scene


def quadrature(length: float, start: float, breadth: tuple[float, float], is_round: bool) -> tuple[float, float]:
    """(place of the centre, J / m) of a body of unit density by Gauss's points along it and across, axis across the link.

    Of a round body the section between the radii `breadth`; of a bar the section is `breadth[1]` wide.
    """
    nodes, weights = np.polynomial.legendre.leggauss(12)
    along = start + length * (nodes + 1) / 2
    inner, outer = breadth
    across = inner + (outer - inner) * (nodes + 1) / 2
    if is_round:  # <y^2> over a ring of radius s is s^2 / 2, its weight s
        share, height = weights * across, across**2 / 2
    else:
        across = outer * nodes / 2
        share, height = weights, across**2
    centre = float(along @ weights / weights.sum())
    spread = float((along - centre) ** 2 @ weights / weights.sum())
    return centre, spread + float(height @ share / share.sum())


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        (rigs.rod(0.3, 0.8, start=-0.1), quadrature(0.8, -0.1, (0.0, 1e-9), True)),
        (rigs.tube(0.3, 0.8, 0.06, 0.04, start=0.05), quadrature(0.8, 0.05, (0.02, 0.03), True)),
        (rigs.cylinder(0.3, 0.02, 0.1), quadrature(0.02, 0.0, (0.0, 0.05), True)),
        (rigs.box(0.3, 0.5, 0.2, start=0.1), quadrature(0.5, 0.1, (0.0, 0.2), False)),
    ],
    ids=["rod", "tube", "cylinder", "box"],
)
def test_a_body_is_the_sum_of_its_parts(body: rigs.Body, expected: tuple[float, float]) -> None:
    assert body.mass == 0.3
    assert abs(body.place - expected[0]) < 1e-15
    assert abs(body.inertia - 0.3 * expected[1]) < 1e-14 * body.inertia + 1e-18


def test_a_disc_is_the_sum_of_its_rings() -> None:
    ring = rigs.disc(0.3, 0.2, 0.4, inner_diameter=0.1)
    radii = np.linspace(0.05, 0.1, 20001)
    assert abs(ring.inertia - 0.3 * np.trapezoid(radii**3, radii) / np.trapezoid(radii, radii)) < 1e-9
    assert rigs.disc(0.3, 0.2, 0.4).inertia == 0.3 * 0.1**2 / 2


def test_a_link_is_the_same_cut_or_whole() -> None:
    """Parallel axes: a rod in three pieces, and in many points."""
    whole = rigs.link(0.9, rigs.rod(0.6, 0.9))
    cut = rigs.link(0.9, rigs.rod(0.2, 0.3), rigs.rod(0.1, 0.15, 0.3), rigs.rod(0.3, 0.45, 0.45))
    places = (np.arange(3000) + 0.5) * 0.9 / 3000
    points = rigs.link(0.9, *(rigs.point(0.6 / 3000, float(place)) for place in places))
    for name, close in (("mass", 1e-15), ("com", 1e-15), ("inertia", 1e-14), ("about_joint", 1e-14)):
        assert abs(getattr(cut, name) - getattr(whole, name)) < close
        assert abs(getattr(points, name) - getattr(whole, name)) < 1e-7
    assert abs(whole.about_joint - 0.6 * 0.9**2 / 3) < 1e-15


def test_a_counterweight_moves_the_centre_inwards() -> None:
    balanced = rigs.link(1.0, rigs.rod(0.5, 1.0), rigs.point(0.5, -0.5))
    assert abs(balanced.com) < 1e-16
    assert abs(balanced.inertia - (0.5 / 12 + 0.5 * 0.25 + 0.5 * 0.25)) < 1e-15
    with pytest.raises(SceneError, match=r"^com: puts the centre of mass behind the base joint \(got -0\.\d+\); turn the link round"):
        rigs.link(1.0, rigs.rod(0.5, 1.0), rigs.point(0.6, -0.5))


def test_a_swing_tells_the_inertia() -> None:
    """A uniform rod swings with T = 2 pi sqrt(2 L / 3 g)."""
    found = rigs.swung(0.8, 0.4, 0.4, 2 * pi * sqrt(2 * 0.8 / (3 * 9.81)))
    assert abs(found.inertia - 0.4 * 0.8**2 / 12) < 1e-15
    assert abs(rigs.swung(1.0, 2.0, 0.3, 2 * pi * sqrt(0.3 / 1.62), gravity=1.62).inertia) < 1e-15
    with pytest.raises(SceneError, match=r"^period: is shorter than that of a point at the centre of mass, 1\.26\d+ \(got 1\.2\)"):
        rigs.swung(0.8, 0.4, 0.4, 1.2)


def test_links_are_the_keys_of_a_scene() -> None:
    upper = rigs.link(0.3, rigs.tube(0.05, 0.3, 0.02, 0.018), rigs.disc(0.04, 0.03, 0.3))
    lower = rigs.link(0.2, rigs.rod(0.03, 0.2))
    scene = Scene("pair", 2, **rigs.links(upper, lower))  # type: ignore[arg-type]
    assert scene.mass == (upper.mass, 0.03) and scene.inertia == (upper.inertia, lower.inertia)
    assert scene.com == (upper.com, 0.1) and scene.length == (0.3, 0.2)
    with pytest.raises(FrozenInstanceError):
        upper.mass = 1.0  # type: ignore[misc]
    with pytest.raises(TypeError):
        rigs.links(upper)["mass"] = [1.0]  # type: ignore[index]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: rigs.rod(0, 1), "mass: is not positive (got 0); give a number above zero, kg"),
        (lambda: rigs.rod(1, -1), "length: is not positive (got -1); give a number above zero, m"),
        (lambda: rigs.rod(True, 1), "mass: is not a number (got True); give a number, kg"),
        (lambda: rigs.rod(1, "1 m"), "length: is not a number (got '1 m'); give a number, m"),
        (lambda: rigs.rod(1, 10**400), "length: is not finite (got " + f"{10**400!r}"[:56] + " ... " + "0" * 18 + "); give a finite number, m"),
        (lambda: rigs.point(1, float("nan")), "place: is not finite (got nan); give a finite number, m"),
        (
            lambda: rigs.tube(1, 1, 0.02, 0.03),
            "inner_diameter: is wider than the outer diameter 0.02 (got 0.03); give the diameter of the hole, m",
        ),
        (lambda: rigs.link(1.0), "bodies: has nothing with a mass (got ()); give at least one body, such as rod(mass, length)"),
        (lambda: rigs.link(1.0, 0.3), "bodies: is not a Body (got 0.3); make it by rod, tube, cylinder, box, disc or point"),
        (lambda: rigs.links(), "links: is a chain without links (got ()); give its links from the base on"),
        (
            lambda: rigs.links(rigs.rod(1, 1)),
            (
                "links: is not a Link (got Body(mass=1.0, place=0.5, inertia=0.08333333333333333)); "
                "make it by link(length, body, ...), or by swung"
            ),
        ),
    ],
)
def test_bad_numbers_are_refused(make, message):
    with pytest.raises(SceneError) as caught:
        make()
    assert str(caught.value) == message
