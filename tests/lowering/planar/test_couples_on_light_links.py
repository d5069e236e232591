"""Couples on light links before heavy ones keep their digits: the form of the accelerations is chosen by the folded masses."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from phichain.lowering.planar import tension
from phichain.scene import Scene
from tests.lowering.hard_chains import Hard
from tests.lowering.test_rigid_links import forward
from tests.reference_cases import relative_error

Keys = dict[str, Any]
BASES: dict[str, Keys] = {
    "wall": {}, "cart": {"base": "cart", "cart_mass": 1.0}, "moving": {"base": "moving"}, "driven": {"base": "cart", "drive": "acceleration"},
}  # fmt: skip
COUPLES: dict[str, Keys] = {"driven": {"actuated": "all"}, "sprung": {"stiffness": 1.0, "damping": 0.1}}
ANGLES = ("absolute", "relative", "adjacent")
#: A light, short link before a heavy, long one, and with the lengths the other way round.
LIGHT_FIRST: dict[str, Keys] = {"short": {"mass": [0.075, 13.3], "length": [0.045, 11.5]}, "long": {"mass": [0.075, 13.3], "length": [11.5, 0.045]}}


def hard(seed: int, **keys: Any) -> Hard:
    """The chain in a random state."""
    chain = Scene("unlike", len(keys["mass"]), angles=ANGLES[seed % 3], **keys)
    rng = np.random.default_rng(seed)
    given = {"q": rng.uniform(-np.pi, np.pi, chain.nq).tolist(), "v": (2 * rng.normal(size=chain.nv)).tolist()}
    if chain.nu:
        given["u"] = rng.normal(size=chain.nu).tolist()
    return Hard(chain, given)


def missed(found: Hard) -> float:
    """The error over what is asked: 1e-14, or ten times what arguments off by half a unit in the last place leave attainable."""
    error = relative_error(forward(found.scene, found.inputs).tolist(), found.truth())
    return error / 1e-14 if error <= 1e-14 else error / max(1e-14, 10 * found.attainable())


@pytest.mark.parametrize("couples", COUPLES)
@pytest.mark.parametrize("base", BASES)
@pytest.mark.parametrize("links", LIGHT_FIRST)
def test_light_links_before_heavy_ones(links: str, base: str, couples: str) -> None:
    assert max(missed(hard(seed, **LIGHT_FIRST[links], **BASES[base], **COUPLES[couples])) for seed in range(6)) <= 1


@pytest.mark.parametrize("couples", COUPLES)
@pytest.mark.parametrize("base", BASES)
def test_whatever_tensions_serve_over_four_decades(base: str, couples: str) -> None:
    rng, served = np.random.default_rng(7), 0
    for seed in range(15):
        links = 2 + seed % 3
        keys = {"mass": (10 ** rng.uniform(-2, 2, links)).tolist(), "length": (10 ** rng.uniform(-2, 2, links)).tolist()}
        found = hard(seed, **keys, **BASES[base], **COUPLES[couples])
        if tension.suits(found.scene):
            served += 1
            assert missed(found) <= 1, found.scene
    assert served >= 3


def test_which_chains_tensions_serve() -> None:
    """Heavy before light however unlike, nothing much heavier than what is before it, a cart included; anything where no couple acts."""
    light_first, heavy_first = {"mass": [0.075, 13.3], "length": 1.0}, {"mass": [13.3, 0.075], "length": 1.0}
    assert not tension.suits(Scene("a", 2, **light_first, actuated="all"))
    assert not tension.suits(Scene("a", 2, **light_first, stiffness=1.0))
    assert tension.suits(Scene("a", 2, **light_first))
    assert tension.suits(Scene("a", 2, **heavy_first, actuated="all"))
    assert tension.suits(Scene("a", 3, mass=[1e4, 2.0, 1.0], length=1.0, damping=0.1))
    assert not tension.suits(Scene("a", 2, **heavy_first, actuated="all", base="cart", cart_mass=0.1))
    assert not tension.suits(Scene("a", 2, mass="runtime", length=1.0, actuated="all"))
