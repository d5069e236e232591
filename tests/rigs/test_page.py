"""docs/rigs.md: what its pieces of Python make, and the numbers that it says of them."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from phichain import rigs
from phichain.scene import Scene

PAGE = (Path(__file__).parents[2] / "docs" / "rigs.md").read_text()


@pytest.fixture(scope="module")
def made() -> dict[str, dict[str, Any]]:
    """The names after every piece of Python of the page, which are run one after the other, by the scene that it makes."""
    names: dict[str, Any] = {}
    after: dict[str, dict[str, Any]] = {}
    for piece in re.findall(r"^```python\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL):
        if "rigs." in piece:
            exec(piece, names)  # noqa: S102  our own page
            after[names["scene"].name] = dict(names)
    return after


def test_every_piece_makes_a_scene(made: dict[str, dict[str, Any]]) -> None:
    assert list(made) == ["pair", "arm", "cart_pole", "stepped"]
    assert made["arm"]["scene"].actuated == (1,)
    assert made["stepped"]["scene"].drive == "acceleration" and made["stepped"]["scene"].cart_mass is None


def test_the_cart_of_the_page_weighs_what_it_says(made: dict[str, dict[str, Any]]) -> None:
    cart = made["cart_pole"]["cart"]
    assert f"{cart.cart_mass:.3f} kg of which {cart.cart_mass - 0.94:.3f} kg" in PAGE
    assert f"{cart.force_per_input:.2f} N/V, and {cart.cart_damping - 5.4:.1f} N s/m" in PAGE


def test_every_function_is_on_the_page() -> None:
    for name in rigs.__all__:
        if name[0].islower():
            assert f"`rigs.{name}`" in PAGE or f"`{name}" in PAGE or f"rigs.{name}(" in PAGE, name


@pytest.mark.parametrize("links", [1, 2, 5])
def test_points_that_move_like_rigid_links(links: int) -> None:
    """The recipe of the page against mu_k and c_kk of the links, which with the lengths are all that T and V know."""
    chain = [rigs.link(0.3, rigs.rod(0.2 + 0.1 * k, 0.3), rigs.point(0.05, 0.1)) for k in range(links)]
    beyond = equivalent = 0.0
    for one in reversed(chain):
        mu = one.mass * one.com + one.length * beyond
        c = one.about_joint + one.length**2 * beyond
        a, b = mu - one.length * equivalent, c - one.length**2 * equivalent
        com, mass = b / a, a**2 / b
        assert np.isclose(mass * com + one.length * equivalent, mu, rtol=1e-15)
        assert np.isclose(mass * com**2 + one.length**2 * equivalent, c, rtol=1e-15)
        beyond, equivalent = beyond + one.mass, equivalent + mass
    rod = rigs.link(0.3, rigs.rod(0.2, 0.3))
    assert np.isclose(rod.about_joint / (rod.mass * rod.com), 0.2) and np.isclose((rod.mass * rod.com) ** 2 / rod.about_joint, 0.15)


def test_frictions_that_a_swing_tells() -> None:
    """Small swings of one link: d = 2 (J + m com^2) ln(A_1 / A_2) / T, and m g com (A_1 - A_2) / 4, by the exact linear motions."""
    one = rigs.link(0.5, rigs.rod(0.4, 0.5))
    about, weight = one.about_joint, one.mass * 9.81 * one.com
    damping = 0.01
    rate = np.sqrt(weight / about - (damping / (2 * about)) ** 2)
    period = 2 * np.pi / rate
    ratio = np.exp(damping / (2 * about) * period)
    assert np.isclose(2 * about * np.log(ratio) / period, damping)
    friction, amplitude = 0.02, 0.3
    after = amplitude
    for _ in range(2):  # each half swing is about the place where the friction is balanced
        after = after - 2 * friction / weight
    assert np.isclose(weight * (amplitude - after) / 4, friction)
    assert Scene("one", 1, friction=friction, friction_speed=0.01, **rigs.links(one)).friction == (friction,)  # type: ignore[arg-type]
