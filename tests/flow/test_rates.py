"""The fastest linear mode against closed forms, and the bounds that stand in for it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from phichain.ir.evaluate import evaluate
from phichain.lowering.rates import fastest_rate, reach, scales_program
from phichain.mechanics import derive
from phichain.scene import Scene
from tests.flow.flows import planar, scene


def rate(chain: Scene) -> float:
    found = fastest_rate(chain)
    assert found is not None
    return float(found)


def test_one_link_swings_like_a_pendulum() -> None:
    assert rate(planar(1)) == pytest.approx(math.sqrt(9.81 / 0.5), rel=6e-3)
    assert rate(planar(1)) >= math.sqrt(9.81 / 0.5)


def test_two_equal_links() -> None:
    """omega^2 = (2 + sqrt 2) g / l of the double pendulum with equal masses at the tips."""
    chain = scene("two_equal", "planar", "fixed", links=2, mass=1, length=1)
    assert rate(chain) == pytest.approx(math.sqrt((2 + math.sqrt(2)) * 9.81), rel=6e-3)


def test_a_pendulum_on_a_free_cart() -> None:
    chain = scene("carted", "planar", "cart", links=1, mass=1, length=1, cart_mass=0.5)
    assert rate(chain) == pytest.approx(math.sqrt(9.81 * 3), rel=6e-3)


def test_a_stiff_joint_is_the_fastest() -> None:
    chain = planar(1, "stiff", joints={"stiffness": 1e6})
    assert rate(chain) == pytest.approx(math.sqrt(1e6) / 0.5, rel=6e-3)


@pytest.mark.parametrize("links", [1, 3, 16, 64])
@pytest.mark.parametrize("half_way", [True, False])
def test_the_bound_for_runtime_parameters_is_above_and_not_far(links: int, half_way: bool) -> None:
    names = ("mass", "length", "com")[: 2 + half_way]
    given = scene("given", "planar", "fixed", links=links, **dict.fromkeys(names, "runtime"))
    folded = (
        planar(links) if half_way else scene("tips", "planar", "fixed", links=links, mass=1, length=1 / links)
    )
    assert fastest_rate(given) is None and reach(given) is None
    numbers = {"mass": 1 / links, "length": 1 / links, "com": 0.5 / links}
    bound, length = evaluate(scales_program(derive(given)), {name: np.full(links, numbers[name]) for name in names})[
        "scales"
    ]
    assert length == pytest.approx(1.0)
    assert rate(folded) <= 1.01 * bound <= 6 * rate(folded)


def test_masses_that_spread_beyond_double_precision_still_have_a_bound() -> None:
    masses = [10.0 ** (8 * (-1) ** k) for k in range(32)]
    chain = scene(
        "spread", "planar", "fixed", links=32, mass=masses, length=[1e4 if k % 2 else 1e-4 for k in range(32)]
    )
    assert math.isfinite(rate(chain)) and rate(chain) > 1.0
