"""Factors kept once: the same coefficients in fewer cells."""

from __future__ import annotations

import numpy as np
import pytest

from phichain.ir.evaluate import evaluate
from phichain.ir.passes import unroll
from phichain.lowering.field import vector_field
from phichain.mechanics import derive
from phichain.scene import Scene
from phichain.transform.factors import FACTORS, factored
from phichain.transform.jets import jets
from phichain.transform.lanes import FIRST, INVERSE_ORDER, LEFT, ORDER, RIGHT
from tests.flow.flows import planar, scene

BALL = scene("ball", "spatial", "cart", links=2, mass=1, length=1, cart_mass=1)


@pytest.mark.parametrize("chain", [planar(3, "arms"), BALL], ids=lambda chain: chain.name)
def test_factors_kept_once_are_the_lanes_factors(chain: Scene) -> None:
    """Order 0 and order 1 of every product's two factors, from fewer cells than there are lanes."""
    made, stride = jets(unroll(vector_field(derive(chain)))), 1
    shared = factored(made, stride)
    assert shared.left is not None and shared.right is not None and shared.count < 2 * made.products
    random = np.random.default_rng(5)
    inputs = {array.name: random.normal(size=array.shape) for array in made.start.inputs}
    order_0 = evaluate(made.start, inputs), evaluate(shared.start, inputs)
    given = {array.name: random.normal(size=array.shape) for array in made.follow.inputs}
    given |= {name + FIRST: order_0[0][name] for name in (LEFT, RIGHT)}
    given |= {FACTORS + FIRST: order_0[1][FACTORS], ORDER: np.array(1.0), INVERSE_ORDER: np.array(1.0)}
    given |= {array.name: order_0[0][array.name] for array in made.start.outputs if array.name in given}
    order_1 = tuple(
        evaluate(program, {array.name: given[array.name] for array in program.inputs})
        for program in (made.follow, shared.follow)
    )
    for lanes, factors in (order_0, order_1):
        for name, places in ((LEFT, shared.left), (RIGHT, shared.right)):
            assert np.array_equal(lanes[name], factors[FACTORS][np.array(places) * stride])


def test_loops_keep_a_row_for_each_factor() -> None:
    made = jets(vector_field(derive(planar(8))))
    shared = factored(made, 2)
    assert shared.left is None and shared.right is None
    assert shared.count == 2 * made.products
