"""All that a rig can hold at once, against the dense Lagrangian by hand: masses and lengths over four decades, centres of mass down to 1e-8 of a link."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf

from phichain.ir import evaluate
from phichain.lowering import lower_function
from phichain.mechanics import derive
from phichain.scene import Scene
from tests.reference_cases import relative_error
from tests.rigs.dense import amplified, numbers, planar, spatial


def rig(rng: np.random.Generator, space: str) -> Scene:
    """A chain with some of everything."""
    n = int(rng.integers(2, 6))

    def over(low: float, high: float, unit: Any = 1.0) -> Any:
        return (unit * 10 ** rng.uniform(low, high, n)).tolist()

    length, mass = np.array(over(-2, 2)), np.array(over(-2, 2))
    turned = mass * length**2
    keys: dict[str, Any] = {"mass": mass.tolist(), "length": length.tolist(), "base": str(rng.choice(["fixed", "cart", "moving"]))}
    kind = rng.integers(3)
    keys["com"] = over(-8, 0, length) if kind else (length * rng.choice([0, 0.5, 1.5, 1e-8], n)).tolist()
    if kind < 2:
        keys["inertia"] = over(-3, 1, turned)
    for name, least, most in (("damping", -3, 1), ("friction", -3, 1), ("stiffness", -3, 2)):
        if rng.random() < 0.5:
            keys[name] = over(least, most, turned)
    if "friction" in keys:
        keys["friction_speed"] = float(10 ** rng.uniform(-2, 0))
    if space == "planar":
        keys |= {"angles": str(rng.choice(["relative", "absolute"])), "actuated": "all"}
        # A rotor may outweigh its link by 1e9 and more, as beside a point mass almost on its joint, and take up a damper to match.
        if rng.random() < 0.5:
            keys["armature"] = over(-4, 2, turned)
        if "stiffness" in keys:
            keys["rest_angle"] = rng.normal(size=n).tolist()
    if keys["base"] == "cart":
        keys["cart_mass"] = float(10 ** rng.uniform(-2, 2))
        more = [{"drive": "acceleration"}, {"cart_damping": 0.4, "cart_friction": 0.7, "cart_friction_speed": 0.05}]
        keys |= more[int(rng.random() < 0.5)]
    return Scene("dense", n, space, **keys)


def state(rng: np.random.Generator, chain: Scene) -> dict[str, np.ndarray]:
    q, v = rng.uniform(-3, 3, chain.nq), 2 * rng.normal(size=chain.nv)
    if not chain.is_planar:
        for k in range(2 * int(chain.has_cart), chain.nq, 3):
            q[k : k + 3] /= np.linalg.norm(q[k : k + 3])
            v[k : k + 3] -= q[k : k + 3] * (q[k : k + 3] @ v[k : k + 3])
    return {"q": q, "v": v, "u": 3 * rng.normal(size=chain.nu)}


@pytest.mark.long
@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("space", ["planar", "spatial"])
def test_accelerations_are_those_of_the_dense_lagrangian(space: str, seed: int) -> None:
    """1e-14, or ten times what half a unit in the last place of every number does."""
    rng = np.random.default_rng([seed, space == "planar"])
    chain = rig(rng, space)
    given, dense = state(rng, chain), planar if space == "planar" else spatial
    with mp.workdps(60):
        args, p = [[mpf(x) for x in given[name].tolist()] for name in "qvu"], numbers(chain)
        true = dense(chain, p, *args)
        moved = amplified(dense, chain, p, args, true, rng)
    program = lower_function(derive(chain), "forward_dynamics", ("loops", "unrolled")[seed % 2])
    found = evaluate(program, {array.name: given[array.name] for array in (*program.params, *program.inputs)})["a"]
    assert relative_error(found.tolist(), true) < max(1e-14, 10 * float(moved))
