"""The closed-form Jacobian of Phi against the tangents of the loops of Phi, against the Lagrangian, and in operations."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from phichain.ir.evaluate import evaluate
from phichain.ir.passes import total_operations
from phichain.lowering.lower import lower, lower_function
from phichain.mechanics import derive
from phichain.proof import prove
from phichain.scene import Scene
from phichain.transform.blocks import Block
from phichain.transform.tangent import jacobian

KINDS: dict[str, dict[str, Any]] = {
    "relative": {},
    "absolute": {"angles": "absolute", "mass": [1.0, 1e-3, 2.0, 0.5]},
    "adjacent": {"angles": "adjacent", "com": [0.3, 0.7, 0.5, 1.0]},
    "cart": {"base": "cart", "cart_mass": 0.7},
    "springs": {"stiffness": [3.0, 0.0, 1e3, 2.0]},
    "springs and cart": {"stiffness": [3.0, 5.0, 1.0, 2.0], "base": "cart", "cart_mass": 2.0, "angles": "adjacent"},
    "runtime": {"mass": "runtime", "length": "runtime", "stiffness": "runtime", "angles": "absolute"},
}


def chain(links: int = 4, **more: Any) -> Scene:
    return Scene(
        "balance", links, **{"mass": 1.0, "length": 1.0, "actuated": "none", "want": ("phi", "phi_jacobian")} | more
    )


@pytest.mark.parametrize("kind", KINDS)
def test_the_loops_are_proven_from_the_lagrangian(kind: str) -> None:
    model = derive(chain(**KINDS[kind]))
    prove(model, lower(model, code="loops"))


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "runtime"])
@pytest.mark.parametrize("links", [1, 2, 4])
def test_the_loops_are_the_tangents_of_phi(kind: str, links: int) -> None:
    more = {key: value[:links] if isinstance(value, list) else value for key, value in KINDS[kind].items()}
    scene = chain(links, **more)
    model = derive(scene)
    loops = lower_function(model, "phi_jacobian", code="loops")
    size = scene.nv
    blocks = [Block("out", "amplitude", "out", 0, size + 1), Block("out", "omega", "out", size, size + 1)]
    tangents = jacobian(lower_function(model, "phi", code="unrolled"), "phi_jacobian", "", blocks)
    rng = np.random.default_rng(links)
    for _ in range(3):
        given = {"amplitude": rng.uniform(-3, 3, size), "omega": rng.uniform(1, 5, 1)}
        found, expected = (evaluate(program, given)["out"] for program in (loops, tangents))
        assert np.max(np.abs(found - expected)) < 1e-13 * np.max(np.abs(expected))
    upright = {"amplitude": np.zeros(size), "omega": np.array([2.0])}
    found, expected = (evaluate(program, upright)["out"] for program in (loops, tangents))
    assert np.max(np.abs(found - expected)) < 1e-14 * np.max(np.abs(expected))


def test_operations_grow_with_the_pairs_of_links() -> None:
    """Column by column they grew with the third power: 84 times those of Phi at N = 64."""
    counts = {}
    for links in (16, 32, 64):
        model = derive(chain(links))
        counts[links] = [total_operations(lower_function(model, name, "loops")) for name in ("phi", "phi_jacobian")]
    assert counts[64][1] < 3 * counts[64][0]
    assert counts[64][1] < 4.2 * counts[32][1]
