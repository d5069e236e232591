"""The fastest linear mode against closed forms, and the bounds that stand in for it."""

from __future__ import annotations

import math
import random
from typing import Any

import numpy as np
import pytest
import scipy.linalg

from phichain.ir.evaluate import evaluate
from phichain.lowering.rates import fastest_rate, reach, scales_program, weight_rate
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


@pytest.mark.parametrize("com", [0.0, 0.2, 0.9])
def test_a_rod_swings_as_its_moments_say(com: float) -> None:
    """omega^2 = (g m r + k) / (m r^2 + J), at run time within the bound's own looseness."""
    keys: dict[str, Any] = {"links": 1, "mass": 0.7, "length": 0.5, "com": com, "inertia": 0.03}
    square = (9.81 * 0.7 * com + 0.4) / (0.7 * com**2 + 0.03)
    assert rate(Scene("rod", stiffness=0.4, **keys)) == pytest.approx(math.sqrt(square), rel=6e-3)
    chain = Scene("rod", stiffness=0.4, **(keys | {"com": "runtime", "inertia": "runtime"}))
    given = {"com": [com], "inertia": [0.03]}
    bound = evaluate(scales_program(derive(chain)), {name: np.array(value) for name, value in given.items()})["scales"][0]
    assert math.sqrt(square) <= bound < 20 * math.sqrt(square)


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


@pytest.mark.parametrize("stiffness", [0.0, 0.4, 1e6])
def test_what_weight_gives_while_the_fastest_mode_moves(stiffness: float) -> None:
    """(g / r) / sqrt(g / r + k / (m r^2)) of one link, at run time within the bound's own looseness; nothing without weight."""
    keys: dict[str, Any] = {"links": 1, "mass": 0.7, "length": 0.5, "stiffness": stiffness}
    exact = (9.81 / 0.5) / math.sqrt(9.81 / 0.5 + stiffness / (0.7 * 0.5**2))
    assert float(weight_rate(Scene("hung", **keys))) == pytest.approx(exact, rel=2e-2)
    assert weight_rate(Scene("afloat", **keys, gravity=0.0)) == 0
    chain = Scene("hung", **(keys | {"stiffness": "runtime", "length": "runtime"}))
    bound = evaluate(scales_program(derive(chain)), {"stiffness": np.array([stiffness]), "length": np.array([0.5])})["scales"][2]
    assert exact <= 1.01 * bound <= 6 * exact


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


def dense_rate(chain: Scene) -> float:
    """The same by SciPy from the dense forms M_ij = l_min(i,j) mu_max(i,j), on a cart with its coordinate eliminated."""
    n, mass, length = chain.links, np.array(chain.mass), np.array(chain.length)
    com = length if chain.com is None else np.array(chain.com)
    arms = np.array([[length[k] if k < a else com[a] if k == a else 0.0 for k in range(n)] for a in range(n)])
    inertia, mu = arms.T @ np.diag(mass) @ arms, arms.T @ mass
    if chain.cart_mass is not None:
        inertia -= np.outer(mu, mu) / (chain.cart_mass + mass.sum())
    difference = np.eye(n) - np.eye(n, k=-1)
    springs = np.zeros(n) if chain.stiffness is None else np.array(chain.stiffness)
    stiff = np.diag(chain.gravity * mu) + difference.T @ np.diag(springs) @ difference
    return float(max(scipy.linalg.eigh(stiff, inertia, eigvals_only=True)[-1], 0.0) ** 0.5)


@pytest.mark.parametrize("seed", range(40))
def test_the_count_of_pivots_finds_what_a_dense_solver_finds(seed: int) -> None:
    """To three digits, half a unit of the third of 1000 added before."""
    source = random.Random(seed)
    links = source.randint(1, 12)

    def some() -> float:
        return 10 ** source.uniform(-1, 1)

    length = [some() for _ in range(links)]
    more: dict[str, Any] = {"com": [source.uniform(0.1, 1.0) * l for l in length]} if seed % 2 else {}
    more |= {"stiffness": [some() for _ in range(links)]} if seed % 3 else {}
    more |= {"base": "cart", "cart_mass": some()} if seed % 5 < 2 else {}
    more |= {"gravity": -some()} if seed % 7 == 0 else {}
    chain = Scene("drawn", links, mass=[some() for _ in range(links)], length=length, **more)
    assert rate(chain) == float(f"{dense_rate(chain) * 1.0005:.2e}")


def test_chains_of_any_size() -> None:
    for scale in (1e-150, 1e-30, 1e30, 1e150):
        chain = Scene("one", 1, mass=1.0, length=scale, gravity=scale, want=["forward_dynamics"])
        assert rate(chain) == pytest.approx(1.0, rel=6e-3)
    assert fastest_rate(Scene("up", 2, mass=1.0, length=1.0, gravity=-9.81, want=["forward_dynamics"])) == 0


@pytest.mark.parametrize("base", ["fixed", "cart"])
def test_without_gravity_and_springs_there_is_no_rate(base: str) -> None:
    cart = {} if base == "fixed" else {"base": "cart", "cart_mass": 1.0}
    free = {"mass": 1.0, "length": 1.0, "gravity": 0.0, "want": ["forward_dynamics"]}
    assert fastest_rate(Scene("floating", 2, **free, **cart)) == 0
    assert fastest_rate(Scene("sprung", 2, **free, **cart, stiffness=[4.0, 0.0])) > 0
    # A spring that holds the upright link exactly: the mode is neither slow nor fast, it rests anywhere.
    balanced = Scene("balanced", 1, mass=1.0, length=1.0, gravity=-2.0, stiffness=2.0, want=["forward_dynamics"])
    assert fastest_rate(balanced) == 0
