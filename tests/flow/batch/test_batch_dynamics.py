"""The batch form of the forward dynamics, lane by lane: the scalar one to the last bit, whatever is left over."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from phichain.errors import ArrayError
from phichain.pipeline import build
from phichain.scene import scene_from_dict
from tests.flow.batch.batches import CHAINS, EXACT, dynamics, given, one_by_one, states
from tests.flow.flows import planar


@pytest.mark.long
@pytest.mark.parametrize("name", CHAINS)
@pytest.mark.parametrize("portable", [False, True], ids=["vectors", "portable"])
def test_accelerations_are_the_scalar_ones_to_the_last_bit(name: str, portable: bool) -> None:
    chain = CHAINS[name]
    batch, scalar = dynamics(chain, EXACT, portable)
    for n in (1, 7, 8, 9, 33):
        inputs = states(chain, n, seed=n)
        assert np.array_equal(batch(*inputs, **given(chain)), one_by_one(chain, scalar, inputs))


@pytest.mark.parametrize("name", ["unrolled", "spatial"])
def test_contraction_moves_the_last_digits_alone(name: str) -> None:
    chain = CHAINS[name]
    batch, scalar = dynamics(
        chain, ("-std=c99", "-O3", "-march=native", "-ffp-contract=fast", "-fno-math-errno")
    )
    inputs = states(chain, 100)
    expected = one_by_one(chain, scalar, inputs)
    scale = np.max(np.abs(expected), axis=1)
    assert np.max(np.max(np.abs(batch(*inputs) - expected), axis=1) / scale) < 2e-14


def test_angles_beyond_the_kernel_go_to_the_library() -> None:
    """In one lane alone: the others are not disturbed, NaN stays where it is."""
    chain = CHAINS["cart"]
    batch, scalar = dynamics(chain, EXACT)
    inputs = states(chain, 40)
    inputs[0][3, 1], inputs[0][9, 2], inputs[0][35, 1] = 1e9, -4.1e5, np.nan
    found, expected = batch(*inputs), one_by_one(chain, scalar, inputs)
    assert np.array_equal(found, expected, equal_nan=True)
    assert np.isnan(found[35]).any() and not np.isnan(np.delete(found, 35, axis=0)).any()


def test_a_system_has_the_batch_form_beside_the_scalar_one() -> None:
    table: dict[str, Any] = {
        "links": 2,
        "space": "planar",
        "base": "fixed",
        "mass": 1,
        "length": 1,
        "gravity": "runtime",
    }
    want = ["forward_dynamics", "forward_dynamics_batch", "propagate", "propagate_batch"]
    system = build(scene_from_dict({"name": "both", "chain": table, "functions": {"want": want}}))
    q, v = (np.random.default_rng(3).normal(size=(20, 2)) for _ in range(2))
    p = {"gravity": 9.81}
    assert np.allclose(
        system.forward_dynamics_batch(q, v, p=p), system.forward_dynamics(q, v, p=p), rtol=1e-13
    )
    found = system.propagate_batch(q, v, 0, 1, 1e-12, p=p)
    for k in (0, 19):
        assert np.max(np.abs(found[k].q - system.propagate(q[k], v[k], 0, 1, 1e-12, p=p).q)) < 1e-11


@pytest.mark.parametrize(
    ("values", "field"),
    [
        ([np.zeros((2, 2))], "forward_dynamics_batch"),
        ([np.zeros((2, 2)), np.zeros((3, 2))], "v"),
        ([np.zeros(2)] * 2, "q"),
    ],
)
def test_bad_states_are_refused(values: list[Any], field: str) -> None:
    batch, _ = dynamics(planar(2))
    with pytest.raises(ArrayError, match=field):
        batch(*values)
