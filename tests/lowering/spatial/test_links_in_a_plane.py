"""Chains in space whose outermost links lie almost in one plane and hold the third near its joint: what is left across it keeps its digits."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf

from phichain.ir import evaluate
from phichain.lowering import lower, lower_function
from phichain.lowering.spatial.units import squares_loss
from phichain.mechanics import derive
from phichain.proof import prove
from phichain.scene import Scene
from tests.reference_cases import relative_error
from tests.rigs.dense import amplified, numbers, spatial

BASES: dict[str, dict[str, Any]] = {"fixed": {}, "cart": {"base": "cart", "cart_mass": 0.7}, "moving": {"base": "moving"}}


def chain(links: int, **more: Any) -> Scene:
    """Its third link from the tip has its mass at 1e-4 of its length."""
    place = np.full(links, 0.4)
    if links > 2:
        place[links - 3] = 1e-4
    keys: dict[str, Any] = {"mass": [1.0, 0.8, 0.6, 0.9, 0.7][:links], "length": [0.5, 0.7, 0.4, 0.6, 0.3][:links]}
    return Scene("flat", links, "spatial", **keys | {"com": (place * np.array(keys["length"])).tolist()} | more)


def given(scene: Scene, seed: int, off: float, plane: np.ndarray | None = None) -> dict[str, np.ndarray]:
    """Links in a plane, one of any, but for `off`, at any rates."""
    rng, carts = np.random.default_rng(seed), 2 * int(scene.has_cart)
    q, v = rng.normal(size=scene.nq), rng.normal(size=scene.nv)
    plane = rng.normal(size=(2, 3)) if plane is None else plane
    for k in range(carts, scene.nq, 3):
        q[k : k + 3] = rng.normal(size=2) @ plane + off * q[k : k + 3]
        q[k : k + 3] /= np.linalg.norm(q[k : k + 3])
        v[k : k + 3] -= q[k : k + 3] * (q[k : k + 3] @ v[k : k + 3])
    return {"q": q, "v": v, "u": rng.normal(size=scene.nu)}


@pytest.mark.long
@pytest.mark.parametrize("base", BASES)
@pytest.mark.parametrize("links", [3, 4, 5])
def test_accelerations(links: int, base: str) -> None:
    """Ten times the problem's own amplification; a dyad that is rounded as a matrix leaves up to 300 times it."""
    for code in ("loops", "unrolled"):
        scene = chain(links, **BASES[base], damping=0.1 if links == 4 else None)
        assert squares_loss(scene)
        program = lower_function(derive(scene), "forward_dynamics", code)
        for seed, off in enumerate((0.1, 1e-2, 1e-3)):
            args, rng = given(scene, seed, off), np.random.default_rng(seed)
            with mp.workdps(60):
                exact, p = [[mpf(x) for x in args[name].tolist()] for name in "qvu"], numbers(scene)
                true = spatial(scene, p, *exact)
                moved = amplified(spatial, scene, p, exact, true, rng)
            found = evaluate(program, {array.name: args[array.name] for array in program.inputs})["a"]
            assert relative_error(found.tolist(), true) < max(1e-14, 10 * float(moved))


@pytest.mark.parametrize("mass", [1e-3, 1e-6, 1e-8])
def test_a_light_cart_is_held_by_two_links(mass: float) -> None:
    """It takes the place of the third link, with a plane that stands upright: a dyad rounded as a matrix leaves 160 times the amplification of these."""
    scene = chain(2, com=[0.2, 0.28], base="cart", cart_mass=mass)
    assert squares_loss(scene)
    program = lower_function(derive(scene), "forward_dynamics", "loops")
    upright = np.array([[np.cos(1.0), np.sin(1.0), 0.0], [0.0, 0.0, 1.0]])
    for seed, off in enumerate((0.1, 1e-2, 1e-3, 1e-4)):
        args, rng = given(scene, seed, off, upright), np.random.default_rng(seed)
        with mp.workdps(60):
            exact, p = [[mpf(x) for x in args[name].tolist()] for name in "qvu"], numbers(scene)
            true = spatial(scene, p, *exact)
            moved = amplified(spatial, scene, p, exact, true, rng)
        found = evaluate(program, {array.name: args[array.name] for array in program.inputs})["a"]
        assert relative_error(found.tolist(), true) < max(1e-14, 10 * float(moved))


CHAINS: list[Scene] = [chain(4, base="cart", cart_mass=0.7), chain(2, com=[0.2, 0.28], base="cart", cart_mass=1e-6)]


@pytest.mark.parametrize("made", CHAINS, ids=["links", "cart"])
def test_it_is_proven(made: Scene) -> None:
    """With tensions, which come of the same sweep."""
    model = derive(replace(made, want=("forward_dynamics", "direction_dynamics", "tensions"), code="loops"))
    prove(model, lower(model))


def test_links_held_by_themselves_are_left_as_they_were() -> None:
    """The tip's dyad counts where the third link is much lighter about its joint, and where all of it is known."""
    assert not squares_loss(Scene("even", 5, "spatial", mass=0.1, length=0.1, com=0.02))
    assert not squares_loss(chain(4, mass="runtime"))
    assert not squares_loss(Scene("two", 2, "spatial", mass=0.1, length=0.1, com=1e-6))
    for cart in ("runtime", 0.5):
        assert not squares_loss(chain(2, com=[0.2, 0.28], base="cart", cart_mass=cart))
