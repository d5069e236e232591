"""Two links in space whose pivot is made of their cosine: which chains, and no digit less in line, folded and anywhere."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from phichain.ir import evaluate, total_operations
from phichain.lowering import lower_function
from phichain.lowering.spatial.tension import by_cosines
from phichain.mechanics import derive
from phichain.reference import reference
from phichain.scene import Scene
from tests.reference_cases import relative_error

LIKE: list[dict[str, Any]] = [
    {"base": "cart", "cart_mass": 0.5}, {}, {"mass": [0.1, 0.12]}, {"mass": [0.1, 1e-3]}, {"base": "cart", "cart_mass": 0.5, "stiffness": 0.3, "damping": 0.1},
]  # fmt: skip
UNLIKE: list[dict[str, Any]] = [
    {"mass": [0.1, 0.3]}, {"base": "cart", "cart_mass": 0.1}, {"base": "cart", "cart_mass": 1e-3}, {"mass": "runtime"}, {"base": "cart", "cart_mass": "runtime"}, {"links": 3},
]  # fmt: skip


def chain(**more: Any) -> Scene:
    keys: dict[str, Any] = {"links": 2, "mass": 0.1, "length": 0.1} | more
    return Scene("two", keys.pop("links"), space="spatial", **keys)


def state(scene: Scene, aside: float, sense: int, seed: int) -> dict[str, Any]:
    """Links that are off one line by about `aside`, the second turned back where `sense` is -1; a large `aside` is anywhere."""
    some, carts = np.random.default_rng(seed), 2 * scene.has_cart
    q = np.array([0.0, 0.0, 1.0]) + aside * some.standard_normal((2, 3))
    q /= np.linalg.norm(q, axis=1)[:, None]
    q[1] *= sense
    w = some.standard_normal((2, 3))
    w -= q * np.sum(q * w, axis=1)[:, None]
    given = {"q": np.append(some.normal(size=carts), q), "v": np.append(some.normal(size=carts), w)}
    return given | ({"u": some.normal(size=scene.nu)} if scene.nu else {})


@pytest.mark.parametrize("more", LIKE, ids=str)
def test_like_masses_lose_nothing(more: dict[str, Any]) -> None:
    """Five roundings of the pivot at most, and a few of what it divides: in line 1 - c^2 is all but zero, and the pivot is not."""
    scene = chain(**more)
    assert by_cosines(scene)
    program, worst = lower_function(derive(scene), "forward_dynamics"), 0.0
    for aside in (1e-8, 1e-3, 3.0):
        for sense in (1, -1):
            for seed in range(4):
                given = state(scene, aside, sense, seed)
                worst = max(worst, relative_error(evaluate(program, given)["a"], reference(scene, "forward_dynamics", given, digits=40)["a"]))
    assert worst < 1.5e-15


@pytest.mark.parametrize("more", UNLIKE, ids=str)
def test_others_take_their_sines(more: dict[str, Any]) -> None:
    """Where the second mass, or the first beside the cart, is heavy, the difference would cost digits."""
    assert not by_cosines(chain(**more))


def test_it_is_the_shorter_way() -> None:
    like, unlike = ({"base": "cart", "cart_mass": 0.5, "mass": [0.1, second]} for second in (0.1000001, 0.3))
    counts = [total_operations(lower_function(derive(chain(**more)), "forward_dynamics")) for more in (like, unlike)]
    assert counts[0] < counts[1]
