"""Forward dynamics keeps its digits: the committed vectors, and chains whose numbers spread over many decades."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
import pytest

from phichain.ir import evaluate, evaluate_exactly
from phichain.lowering import lower_function
from phichain.mechanics import derive
from phichain.scene import Scene
from tests.lowering.hard_chains import PLACES, SPREADS, Hard, hard_chain
from tests.reference_cases import ReferenceCase, extreme, relative_error, vectors, vectors_more

FORMS = ("loops", "unrolled")


def accelerations(chain: Scene, inputs: dict[str, Any], code: str = "loops") -> np.ndarray:
    program = lower_function(derive(chain), "forward_dynamics", code)
    return evaluate(program, {array.name: inputs[array.name] for array in program.inputs})["a"]


@pytest.mark.long
@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("case", [*vectors(), *vectors_more()], ids=str)
def test_vectors(case: ReferenceCase, form: str) -> None:
    most = 1e-12 if case.scene.angles in ("absolute", "adjacent") else 1e-14
    found = accelerations(case.scene, case.inputs, form)
    assert relative_error(found.tolist(), case.expected["forward_dynamics"]["a"]) < most


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("case", extreme(), ids=str)
def test_extreme_cases(case: ReferenceCase, form: str) -> None:
    most = 1e-11 if str(case).startswith("A24") else 1e-14
    found = accelerations(case.scene, case.inputs, form)
    assert relative_error(found.tolist(), case.expected["forward_dynamics"]["a"]) < most


@pytest.mark.parametrize("case", [c for c in vectors_more() if not c.scene.is_planar], ids=str)
def test_rounding_off_the_sphere_is_not_amplified(case: ReferenceCase) -> None:
    """Directions in double precision are unit to 1e-16 only; the formulas, evaluated exactly, leave it at that."""
    program = lower_function(derive(case.scene), "forward_dynamics", "loops")
    given = {array.name: case.inputs[array.name] for array in program.inputs}
    exact = evaluate_exactly(program, given)["a"]
    assert relative_error(exact, case.expected["forward_dynamics"]["a"]) < 1e-15


def check(hard: Hard, slack: float = 20.0) -> None:
    """The error is 1e-14, or the attainable one but for a factor."""
    error = relative_error(accelerations(hard.scene, hard.inputs).tolist(), hard.truth())
    assert error < 1e-14 or error < slack * hard.attainable(), error


@pytest.mark.long
@pytest.mark.parametrize(("spread", "place"), list(product(SPREADS, PLACES)), ids=str)
@pytest.mark.parametrize(
    "more",
    [
        {"space": "planar"}, {"space": "planar", "base": "cart", "cart_mass": 1e-6}, {"space": "spatial"},
        {"space": "spatial", "base": "cart", "cart_mass": 1e-6},
    ],
    ids=["planar", "planar light cart", "spatial", "spatial light cart"],
)  # fmt: skip
def test_masses_and_lengths_over_many_decades(spread: str, place: str, more: dict[str, Any]) -> None:
    check(hard_chain(4, spread=spread, place=place, **more))


SHAPES = [
    {"folded": True}, {"straight": True}, {"fast": True}, {"base": "cart", "cart_mass": 1e6, "straight": True},
    {"base": "cart", "cart_mass": 1e6}, {"stiffness": 1e12, "damping": 1e6}, {"stiffness": 1.0, "damping": 0.1},
]  # fmt: skip


@pytest.mark.long
@pytest.mark.parametrize("more", SHAPES, ids=lambda more: "-".join(f"{k}={v}" for k, v in more.items()))
@pytest.mark.parametrize("place", ["at the end", "half way"])
@pytest.mark.parametrize("spread", ["alike", "heavy tip", "light with a tip"])
@pytest.mark.parametrize("space", ["planar", "spatial"])
def test_shapes_and_rates(space: str, spread: str, place: str, more: dict[str, Any]) -> None:
    check(hard_chain(5, space, spread, place, **more))


@pytest.mark.parametrize("space", ["planar", "spatial"])
@pytest.mark.parametrize("place", ["at the end", "half way"])
@pytest.mark.parametrize("spread", ["alike", "heavy tip", "light with a tip"])
def test_straight_chains_on_a_light_cart(space: str, place: str, spread: str) -> None:
    """The cart takes up what would stretch the chain; left is the rounding of cosines over sines of 1e-4."""
    hard = hard_chain(5, space, spread, place, base="cart", cart_mass=1e-6, straight=True)
    error = relative_error(accelerations(hard.scene, hard.inputs).tolist(), hard.truth())
    assert error < 1e-11 or error < 20 * hard.attainable()


@pytest.mark.parametrize("space", ["planar", "spatial"])
@pytest.mark.parametrize("place", ["at the end", "half way"])
def test_32_links(space: str, place: str) -> None:
    check(hard_chain(32 if space == "planar" else 12, space, "heavier outwards", place))


@pytest.mark.long
@pytest.mark.parametrize("space", ["planar", "spatial"])
@pytest.mark.parametrize("place", ["at the end", "half way"])
@pytest.mark.parametrize("spread", ["alike", "heavier outwards"])
def test_256_links(space: str, place: str, spread: str) -> None:
    """Against the same formulas in 50 digits: a dense reference of this size takes minutes."""
    hard = hard_chain(256, space, spread, place)
    program = lower_function(derive(hard.scene), "forward_dynamics", "loops")
    given = {array.name: hard.inputs[array.name] for array in program.inputs}
    assert relative_error(evaluate(program, given)["a"].tolist(), evaluate_exactly(program, given)["a"]) < 1e-13


@pytest.mark.parametrize(("space", "most"), [("planar", 1e-12), ("spatial", 1e-10)])
def test_heavy_and_short_beyond_light_and_long(space: str, most: float) -> None:
    """Sixteen decades of mass against eight of length: accelerations handed outwards cancel, some digits go."""
    hard = hard_chain(6, space, "alike", "half way")
    mass, length = np.logspace(-8, 8, 6), np.logspace(4, -4, 6)
    keys = {"mass": mass.tolist(), "length": length.tolist(), "com": (length / 2).tolist()}
    chain = Scene("hard", 6, space=space, actuated=hard.scene.actuated, **keys)
    extreme_chain = Hard(chain, hard.inputs)
    error = relative_error(accelerations(chain, hard.inputs).tolist(), extreme_chain.truth())
    assert error < most
