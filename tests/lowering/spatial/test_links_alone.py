"""Links in space that hardly feel each other's turning, as balanced wheels on rods: however fast they turn, what moves them keeps its digits."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf

from phichain.ir import evaluate, total_operations
from phichain.lowering import lower_function
from phichain.lowering.chain.body import point_masses
from phichain.lowering.spatial import mobilities
from phichain.lowering.spatial.units import turns_alone
from phichain.mechanics import derive
from phichain.scene import Scene
from tests.reference_cases import relative_error
from tests.rigs.dense import amplified, numbers, spatial

WHEEL: dict[str, Any] = {"mass": [1.0, 0.5], "length": [1.0, 0.3], "com": [0.5, 1e-4], "inertia": [0.08, 0.01]}
RIGS: dict[str, dict[str, Any]] = {
    "wheel": WHEEL,
    "wheel on a damper": WHEEL | {"damping": [1e-4, 1e-4], "stiffness": [1e-3, 1e-5]},
    "wheel on a heavy cart": WHEEL | {"base": "cart", "cart_mass": 1e4},
    "flywheel": {"mass": [2.67, 1.09], "length": [77.4, 0.309], "com": [0.0573, 6.71e-08], "inertia": [22.1, 0.478]},
    "long light tip": {"mass": [1.0, 1e-6], "length": [0.01, 10.0], "com": [0.005, 5.0]},
}


def rig(name: str) -> Scene:
    numbers = RIGS[name]
    return Scene("alone", len(numbers["mass"]), "spatial", **numbers)


@pytest.mark.parametrize("name", RIGS)
def test_however_fast(name: str) -> None:
    """Without the part of the tension that turns nothing: with it 1e-14 to 1e-11 are left at a hundred times these rates."""
    scene = rig(name)
    assert mobilities.suits(point_masses(scene)) and turns_alone(point_masses(scene))
    program, carts = lower_function(derive(scene), "forward_dynamics", "loops"), 2 * int(scene.has_cart)
    for seed in range(4):
        rng = np.random.default_rng(seed)
        q, v = rng.normal(size=scene.nq), 2 * rng.normal(size=scene.nv)
        for k in range(carts, scene.nq, 3):
            q[k : k + 3] /= np.linalg.norm(q[k : k + 3])
            v[k : k + 3] -= q[k : k + 3] * (q[k : k + 3] @ v[k : k + 3])
        for fast in (1.0, 10.0, 100.0):
            given = {"q": q, "v": fast * v, "u": rng.normal(size=scene.nu)}
            with mp.workdps(60):
                args, p = [[mpf(x) for x in given[key].tolist()] for key in "qvu"], numbers(scene)
                true = spatial(scene, p, *args)
                moved = amplified(spatial, scene, p, args, true, rng)
            found = evaluate(program, {array.name: given[array.name] for array in program.inputs})["a"]
            assert relative_error(found.tolist(), true) < max(1e-15, 5 * float(moved))


@pytest.mark.parametrize("base", [{}, {"base": "cart", "cart_mass": 0.5}], ids=["fixed", "cart"])
@pytest.mark.parametrize("links", [2, 3, 5])
def test_links_alike_feel_each_other(links: int, base: dict[str, Any]) -> None:
    """They are left as they were: not an operation more."""
    alike = Scene("alike", links, "spatial", mass=0.1, length=0.1, com=0.05, **base)
    assert not turns_alone(alike)
    rods = Scene("rods", links, "spatial", mass=0.1, length=0.1, com=0.05, inertia=0.1 * 0.1**2 / 12, **base)
    assert not turns_alone(point_masses(rods))


def test_what_it_costs() -> None:
    """Two products across more, and a sum."""
    alone, felt = (Scene("w", 2, "spatial", **(WHEEL | {"com": [0.5, com], "inertia": [0.08, 0.01]})) for com in (1e-4, 0.2))
    counts = [total_operations(lower_function(derive(scene), "forward_dynamics", "loops")) for scene in (alone, felt)]
    assert counts[0] == counts[1] + 18
