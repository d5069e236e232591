"""Accelerations of chains with rotors keep their digits, whatever the gear ratios and the masses are: dense, in 40 digits."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from phichain.ir import evaluate
from phichain.lowering import lower_function
from phichain.mechanics import derive
from phichain.reference import reference
from phichain.reference.nudge import SIZE_BITS, Nudge
from phichain.scene import Scene
from tests.reference_cases import relative_error

FIXED: dict[str, Any] = {}
CARTS = {"fixed": FIXED, "cart": {"base": "cart", "cart_mass": 0.3}, "light cart": {"base": "cart", "cart_mass": 1e-4}}
PLACES = {"at the end": None, "half way": 0.5, "near the joint": 1e-8, "near the end": 1 - 1e-8}


def random_chain(seed: int, place: str, cart: str, **more: Any) -> Scene:
    """Masses and lengths over four decades, rotors from 1e-8 to 1e8 times m l^2, some joints without any."""
    rng = np.random.default_rng(seed)
    links = 1 + seed % 6
    mass, length = 10.0 ** rng.uniform(-2, 2, links), 10.0 ** rng.uniform(-2, 2, links)
    armature = mass * length**2 * 10.0 ** rng.uniform(-8, 8, links) * (rng.random(links) > 0.3)
    armature[0] += not armature.any()
    com = None if PLACES[place] is None else (PLACES[place] * length).tolist()
    keys = {"angles": ("relative", "absolute", "adjacent")[seed % 3], "actuated": "all", **CARTS[cart], **more}
    numbers = {"mass": mass.tolist(), "length": length.tolist(), "com": com, "armature": armature.tolist()}
    return Scene("geared", links, **numbers | keys)


def arguments(chain: Scene, seed: int) -> dict[str, list[float]]:
    rng = np.random.default_rng(1000 + seed)
    return {"q": rng.normal(size=chain.nq).tolist(), "v": rng.normal(size=chain.nv).tolist(), "u": rng.normal(size=chain.nu).tolist()}


def check(chain: Scene, given: dict[str, Any], values: dict[str, Any] | None = None) -> None:
    """The error is 1e-14, or ten times what the problem itself makes of half a unit in the last place of every number."""
    program = lower_function(derive(chain), "forward_dynamics", "loops")
    found = evaluate(program, {name: np.asarray(x) for name, x in (given | (values or {})).items()})["a"]
    true = reference(chain, "forward_dynamics", given, digits=40, params=values)["a"]
    error = relative_error(found.tolist(), true)
    if error > 1e-14:
        moved = [
            relative_error(reference(chain, "forward_dynamics", given, 40, values, Nudge(seed))["a"], true) for seed in "abc"
        ]
        assert error < 10 * max(moved) * 2.0 ** (SIZE_BITS - 53), (chain, error)


@pytest.mark.long
@pytest.mark.parametrize("cart", CARTS)
@pytest.mark.parametrize("place", PLACES)
def test_gear_ratios_over_sixteen_decades(place: str, cart: str) -> None:
    for seed in range(12):
        chain = random_chain(seed, place, cart)
        check(chain, arguments(chain, seed))


@pytest.mark.parametrize("place", ["at the end", "half way"])
def test_rotors_that_come_at_run_time(place: str) -> None:
    for seed in range(6):
        known = random_chain(seed, place, "fixed")
        chain = random_chain(seed, place, "fixed", armature="runtime", mass="runtime")
        check(chain, arguments(chain, seed), {"armature": list(known.armature or ()), "mass": list(known.mass)})


@pytest.mark.parametrize("place", [0.0, 0.5, 1.5])
@pytest.mark.parametrize("kind", ["numbers", "runtime"])
def test_rigid_links_with_rotors(kind: str, place: float) -> None:
    """Centres of mass at the joint, half-way and beyond the link; folded numbers and moments alike."""
    for seed in range(6):
        known, rng = random_chain(seed, "half way", ("fixed", "cart")[seed % 2]), np.random.default_rng(seed)
        com = (place * np.array(known.length)).tolist()
        inertia = (np.array(known.mass) * np.array(known.length) ** 2 * 10.0 ** rng.uniform(-2, 1, known.links)).tolist()
        values = {"inertia": inertia, "armature": list(known.armature or ())}
        rest: dict[str, Any] = {} if kind == "numbers" else {"inertia": "runtime", "armature": "runtime"}
        chain = replace(known, com=com, **(values | rest))
        check(chain, arguments(chain, seed), values if rest else None)


@pytest.mark.parametrize("shape", ["straight", "folded"])
@pytest.mark.parametrize("spread", [(1.0, 1.0), (1e-8, 1.0), (1.0, 1e8)], ids=["alike", "light with a tip", "heavy tip"])
def test_straight_and_folded_chains_with_uneven_masses(shape: str, spread: tuple[float, float]) -> None:
    light, tip = spread
    mass = [light, light, light, tip]
    for name, place in PLACES.items():
        for gear in (1e-6, 1.0, 1e6):
            if light < 1 and name == "near the joint" and shape == "folded":
                continue  # all of the inertia about joint 2 is what folding leaves of the tip's: six digits of it cancel
            com = None if place is None else [place] * 4
            chain = Scene("geared", 4, mass=mass, length=1.0, com=com, armature=[gear * x for x in (1.0, 0.0, 2.0, 0.5)], actuated="all")
            given = arguments(chain, 3)
            given["q"][1:] = [1e-4, -2e-4, 3e-4] if shape == "straight" else [np.pi - 1e-3, np.pi + 2e-3, -np.pi + 1e-3]
            check(chain, given)


def test_256_links() -> None:
    chain = Scene("geared", 256, mass=1.0, length=0.1, com=0.05, armature=[0.01 * (k % 3) for k in range(256)], actuated="all")
    check(chain, arguments(chain, 1))


@pytest.mark.parametrize("angles", ["relative", "absolute", "adjacent"])
def test_large_rotors_round_no_other_entry_of_the_inertia(angles: str) -> None:
    """Entry by entry: what a rotor of 1e8 has no part in keeps all its digits."""
    numbers = {"mass": [1.0, 0.3, 0.2], "length": [0.5, 0.4, 0.3], "com": [0.2, 0.3, 0.1], "armature": [0.1, 1e8, 0.0]}
    chain = Scene("geared", 3, **numbers, angles=angles, want=("mass_matrix", "linearization"))
    for function, given, output, name in (
        ("mass_matrix", {"q": [0.3, -0.2, 0.9]}, "out", "M"), ("linearization", {"s": [1, -1, -1]}, "M", "M"),
    ):  # fmt: skip
        program = lower_function(derive(chain), function, "loops")
        found = np.asarray(evaluate(program, {key: np.asarray(x, dtype=float) for key, x in given.items()})[output])
        true = np.array(reference(chain, function, given)[name], dtype=float)
        assert found.reshape(3, 3) == pytest.approx(true, rel=1e-14)
