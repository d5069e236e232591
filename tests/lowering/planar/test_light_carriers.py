"""Heavy, short links on light, long ones keep their digits, in the plane and in space: against dense Lagrangian equations in many digits."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from phichain.lowering.chain.body import point_masses
from phichain.lowering.chain.light_carriers import carries_lightly
from phichain.scene import Scene, load_scene
from tests.lowering.hard_chains import Hard
from tests.lowering.test_rigid_links import dumbbells, forward
from tests.reference_cases import relative_error

Keys = dict[str, Any]
SCENES = Path(__file__).parents[3] / "scenes"
#: Long and light, a little lighter, heavy and short.
BARS: Keys = {
    "mass": [0.012, 0.02, 52.6], "length": [36.0, 56.0, 0.22], "com": [21.0, 33.0, 0.023], "inertia": [1.1, 4.3, 0.18],
}  # fmt: skip
POINTS: Keys = {"mass": [0.012, 80.0, 52.6], "length": [36.0, 56.0, 0.22], "com": [21.0, 55.9, 0.2]}
#: Six links, most of them light.
LONG: Keys = {
    "mass": [0.02, 0.03, 0.01, 0.014, 0.01, 60.0], "length": [40.0, 47.0, 20.0, 27.0, 40.0, 0.5], "com": [20.0, 30.0, 11.0, 15.0, 22.0, 0.2],
    "inertia": [2.0, 2.0, 0.6, 0.5, 0.6, 1.2],
}  # fmt: skip
BASES: dict[str, Keys] = {
    "cart": {"base": "cart", "cart_mass": 0.7}, "light cart": {"base": "cart", "cart_mass": 1e-3}, "wall": {}, "moving": {"base": "moving"},
}  # fmt: skip
COUPLES: Keys = {"actuated": "all", "stiffness": 0.5, "damping": 0.1}


def hard(seed: int, bend: float | None = None, **keys: Any) -> Hard:
    """The chain in a random state, its last carriers in line but for `bend`, in absolute angles."""
    chain = Scene("light", len(keys["mass"]), **({"angles": "absolute"} | keys))
    rng = np.random.default_rng(seed)
    q, v = rng.uniform(-np.pi, np.pi, chain.nq), 2 * rng.normal(size=chain.nv)
    if bend is not None:
        q[-2] = q[-3] + bend
    given = {"q": q.tolist(), "v": v.tolist()}
    if chain.nu:
        given["u"] = rng.normal(size=chain.nu).tolist()
    return Hard(chain, given)


def error(found: Hard) -> float:
    return relative_error(forward(found.scene, found.inputs).tolist(), found.truth())


@pytest.mark.parametrize("base", BASES)
@pytest.mark.parametrize("links", [BARS, POINTS, LONG], ids=["bars", "points", "six"])
def test_every_digit(links: Keys, base: str) -> None:
    assert max(error(hard(seed, **links, **BASES[base])) for seed in range(4)) < 5e-15


@pytest.mark.parametrize("angles", ["absolute", "relative", "adjacent"])
def test_couples(angles: str) -> None:
    assert max(error(hard(seed, **BARS, **BASES["cart"], **COUPLES, angles=angles)) for seed in range(4)) < 5e-15


@pytest.mark.parametrize("bend", [0.013, 0.005])
@pytest.mark.parametrize("base", ["cart", "wall"])
def test_nearly_in_line(base: str, bend: float) -> None:
    """The stretch goes over a light link in line with the next as it is, and a heavy link beyond multiplies no difference by its mass."""
    assert max(error(hard(seed, bend, **LONG, **BASES[base])) for seed in range(8)) < 3e-15


@pytest.mark.parametrize("base", ["cart", "wall"])
def test_against_dumbbells(base: str) -> None:
    for seed in range(3):
        found = hard(seed, **BARS, **BASES[base], actuated="none")
        exact = dumbbells(found.scene, found.inputs["q"], found.inputs["v"])
        assert relative_error(forward(found.scene, found.inputs).tolist(), exact) < 5e-15


@pytest.mark.parametrize("decades", [2, 3, 4])
def test_ratios_grow(decades: int) -> None:
    """The tip heavier and shorter, up to eight decades of mass and four of length."""
    mass, length = [0.01, 0.02, 0.01 * 100.0**decades], [30.0, 50.0, 30 / 10.0**decades]
    com, inertia = [0.6 * l for l in length], [0.05 * m * l * l for m, l in zip(mass, length, strict=True)]
    assert max(error(hard(seed, mass=mass, length=length, com=com, inertia=inertia, **BASES["cart"])) for seed in range(6)) < 5e-15


@pytest.mark.parametrize("base", ["cart", "wall"])
@pytest.mark.parametrize("links", [BARS, POINTS], ids=["bars", "points"])
def test_in_space(links: Keys, base: str) -> None:
    chain = Scene("light", 3, space="spatial", **links, **BASES[base])
    for seed in range(6):
        rng = np.random.default_rng(seed)
        cart, q = np.zeros(2 * chain.has_cart), rng.normal(size=(3, 3))
        q /= np.linalg.norm(q, axis=1)[:, None]
        v = 2 * rng.normal(size=(3, 3))
        v -= q * np.sum(q * v, axis=1)[:, None]
        given = {"q": [*cart, *q.ravel()], "v": [*cart, *v.ravel()], "u": [0.3, -0.2][: chain.nu]}
        assert error(Hard(chain, given)) < 1e-14


def test_which_chains_are_served() -> None:
    """Heavy and short on light and long, on whatever carries them; no bundled scene, and none turned round."""
    assert carries_lightly(point_masses(Scene("a", 3, **BARS)))
    assert carries_lightly(Scene("a", 2, base="cart", cart_mass=0.01, mass=[1.0, 1.0], length=[20.0, 1.0], com=[10.0, 0.5]))
    assert not carries_lightly(Scene("a", 2, mass=[0.01, 1.0], length=[20.0, 1.0], com=[10.0, 0.5]))
    assert not carries_lightly(Scene("a", 3, mass=[60.0, 0.02, 0.01], length=[0.2, 50.0, 30.0], com=[0.1, 25.0, 15.0]))
    assert not any(carries_lightly(point_masses(load_scene(path))) for path in sorted(SCENES.glob("*.toml")))
