"""Torques that large rotors take up: what little of them reaches the link before keeps its digits, on every road of the elimination."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf

from phichain.ir import evaluate
from phichain.lowering import lower_function
from phichain.lowering.series import series
from phichain.lowering.series.run import expand
from phichain.mechanics import derive
from phichain.scene import Scene
from tests.lowering.taylor_oracle import DOUBLES, EXACT, gap
from tests.reference_cases import relative_error
from tests.rigs.dense import amplified, numbers, planar

BASES: dict[str, dict[str, Any]] = {
    "fixed": {}, "cart": {"base": "cart", "cart_mass": 0.8, "cart_damping": 0.3}, "moving": {"base": "moving"},
    "driven": {"base": "cart", "drive": "acceleration"},
}  # fmt: skip


def chain(seed: int, base: str, **more: Any) -> Scene:
    """Links alike, rotors of 1e6 to 1e12 times their inertia behind the first joint, and joints' torques as large."""
    rng = np.random.default_rng(seed)
    links = 2 + seed % 3
    large = 10 ** rng.uniform(6, 12, links) * (np.arange(links) > 0)
    keys: dict[str, Any] = {"mass": rng.uniform(0.3, 2, links).tolist(), "length": rng.uniform(0.3, 2, links).tolist()}
    keys |= {"com": (0.6 * np.array(keys["length"])).tolist(), "armature": large.tolist(), "damping": (0.1 + large).tolist()}
    if seed % 2:
        keys |= {"stiffness": large.tolist(), "rest_angle": 0.3, "friction": (0.7 * large).tolist(), "friction_speed": 0.4}
    return Scene("taken_up", links, **keys | {"angles": ("relative", "absolute", "adjacent")[seed % 3], "actuated": "all"} | BASES[base] | more)


def arguments(scene: Scene, seed: int) -> dict[str, np.ndarray]:
    """Joints are driven with torques as large as their dampers', where an input is one of a joint."""
    rng = np.random.default_rng(1000 + seed)
    u = rng.normal(size=scene.nu)
    if scene.angles == "relative":
        u[scene.nu - scene.links :] *= 1 + np.array(scene.damping, dtype=float)
    return {"q": rng.normal(size=scene.nq), "v": rng.normal(size=scene.nv), "u": u}


def exactly(given: dict[str, np.ndarray]) -> list[list[Any]]:
    return [[mpf(x) for x in given[name].tolist()] for name in "qvu"]


def in_own_angles(scene: Scene) -> bool:
    """Whether the dense form by hand knows the scene's angles."""
    return scene.angles != "adjacent"


CASES = [seed for seed in range(8) if seed % 3 != 2]


@pytest.mark.parametrize("base", BASES)
@pytest.mark.parametrize("seed", CASES)
def test_accelerations(seed: int, base: str) -> None:
    """Summed to torques of the links these leave an error of up to 1e-5."""
    scene, rng = chain(seed, base), np.random.default_rng(seed)
    given = arguments(scene, seed)
    with mp.workdps(60):
        args, p = exactly(given), numbers(scene)
        true = planar(scene, p, *args)
        moved = amplified(planar, scene, p, args, true, rng)
    for made in (scene, replace(scene, damping="runtime", armature="runtime")):
        program = lower_function(derive(made), "forward_dynamics", "loops")
        values = given | {"damping": np.array(scene.damping), "armature": np.array(scene.armature)}
        found = evaluate(program, {array.name: values[array.name] for array in (*program.params, *program.inputs)})["a"]
        assert relative_error(found.tolist(), true) < max(1e-14, 10 * float(moved))


def slopes(f: Callable[..., list[Any]], args: list[list[Any]], which: int) -> list[list[Any]]:
    """Derivatives by central differences in many digits."""
    step, columns = mpf(10) ** -25, []
    for i in range(len(args[which])):
        ends = []
        for sign in (1, -1):
            moved = [list(row) for row in args]
            moved[which][i] += sign * step
            ends.append(f(*moved))
        columns.append([(a - b) / (2 * step) for a, b in zip(*ends, strict=True)])
    return [list(row) for row in zip(*columns, strict=True)]


@pytest.mark.parametrize("base", ["fixed", "cart"])
@pytest.mark.parametrize("seed", CASES)
def test_derivatives(seed: int, base: str) -> None:
    """All columns, of the accelerations' largest slope each."""
    scene = chain(seed, base, want=["state_jacobian"])
    given = arguments(scene, seed)
    program = lower_function(derive(scene), "state_jacobian", "loops")
    found = evaluate(program, {array.name: given[array.name] for array in (*program.params, *program.inputs)})
    with mp.workdps(80):
        p = numbers(scene)
        for which, name in enumerate("qvu"):
            true = slopes(lambda *args: planar(scene, p, *args), exactly(given), which)
            for own, exact in zip(found[f"dad{name}"].T.tolist(), zip(*true, strict=True), strict=True):
                assert relative_error(own, list(exact)) < 3e-14


@pytest.mark.parametrize("base", ["fixed", "cart"])
@pytest.mark.parametrize("seed", range(6))
def test_orders_of_a_series(seed: int, base: str) -> None:
    """In doubles against 60 digits of the same, proven recurrences."""
    scene = chain(seed, base)
    given, made = arguments(scene, seed), series(derive(scene))
    rows = {name: values.tolist() for name, values in given.items()}
    found = expand(made, DOUBLES, 5, **rows)
    with mp.workdps(60):
        true = expand(made, EXACT, 5, **{name: [mpf(x) for x in row] for name, row in rows.items()})
    for one, other in zip(found.state, true.state, strict=True):
        assert gap([one[scene.nq :]], [other[scene.nq :]]) < 5e-13
