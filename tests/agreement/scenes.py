"""Scenes that between them hold every kind of chain, joint, angle, actuation, code form and number, and states for them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phichain.contract.chain import Sample
from phichain.contract.functions import FLOWS, ON_REQUEST, ROWS
from phichain.ir.nodes import Array, Program
from phichain.scene import Scene
from tests.offered import offered

Arguments = dict[str, NDArray[np.float64]]


LOSSES = {"damping", "friction", "cart_damping", "cart_friction"}
STEPS = tuple(name for name in ON_REQUEST if name not in FLOWS)


def make(name: str, links: int, space: str, base: str, more: Sequence[str] = (), **keys: Any) -> Scene:
    """A scene with every Program it can have, those on request as given, and uneven numbers where none are given."""
    numbers: dict[str, Any] = {
        "mass": [0.7 + 0.3 * (k % 4) for k in range(links)],
        "length": [1.1 - 0.2 * (k % 3) for k in range(links)],
    }
    driven = keys.get("drive") == "acceleration"
    if base == "cart" and not driven:
        numbers["cart_mass"] = 1.9
    want = offered(space, bool(LOSSES & keys.keys()), driven=driven)
    there = [step for step in more if ROWS[step].absence(Sample(space == "planar")) is None]
    return Scene(name, links, space=space, base=base, want=[*want, *there], **(numbers | keys))


def _mid(links: int) -> list[float]:
    return [0.3 + 0.1 * (k % 3) for k in range(links)]


def _joint(links: int, first: float) -> list[float]:
    return [first / (k + 1) for k in range(links)]


_ALL_RUNTIME = {"mass": "runtime", "length": "runtime", "com": "runtime", "gravity": "runtime"}

_BRAKED = {
    "stiffness": _joint(3, 1.5), "rest_angle": [0.5, -0.25, 0.0], "damping": _joint(3, 0.25), "friction": _joint(3, 0.5),
    "friction_speed": 0.75,
}  # fmt: skip

SCENES = (
    make("planar_tip", 4, "planar", "fixed", angles="relative", code="loops"),
    make("planar_uniform", 3, "planar", "fixed", mass=0.3, length=0.4, com=0.2, actuated="all", code="unrolled"),
    make("planar_runtime", 3, "planar", "fixed", angles="absolute", stiffness="runtime", actuated="all", code="loops",
         **_ALL_RUNTIME),
    make("planar_cart_tip", 3, "planar", "cart", STEPS, angles="adjacent", damping=_joint(3, 0.4), actuated="all",
         code="loops"),
    make("planar_cart_mid", 3, "planar", "cart", STEPS, angles="absolute", com=_mid(3), code="unrolled"),
    make("planar_cart_passive", 3, "planar", "cart", com=_mid(3), stiffness=_joint(3, 2.0), damping=_joint(3, 0.3),
         actuated=[1, 3], code="loops"),
    make("planar_cart_runtime", 2, "planar", "cart", mass="runtime", length="runtime", cart_mass="runtime",
         angles="adjacent", stiffness=_joint(2, 1.5), code="unrolled"),
    make("planar_rigid", 5, "planar", "cart", STEPS, com=_mid(5), inertia=_joint(5, 0.2), actuated="all", code="unrolled"),
    make("planar_rigid_runtime", 2, "planar", "cart", com="runtime", inertia="runtime", stiffness=_joint(2, 1.5), code="loops"),
    make("planar_geared", 3, "planar", "fixed", com=_mid(3), armature="runtime", actuated="all", code="loops"),
    make("planar_cart_geared", 2, "planar", "cart", ("step_variational",), armature=[0.0, 0.6], stiffness=_joint(2, 2.0), damping=_joint(2, 0.3),
         angles="absolute", code="unrolled"),
    make("planar_braked", 3, "planar", "cart", STEPS, angles="absolute", actuated="all", code="loops", **_BRAKED,
         cart_damping=0.4, cart_friction=0.9, cart_friction_speed=1.5),
    make("planar_braked_runtime", 2, "planar", "cart", com=_mid(2), code="unrolled", stiffness=1.5, friction="runtime",
         rest_angle="runtime", cart_damping="runtime", cart_friction="runtime", friction_speed=0.7),
    make("spatial_braked", 2, "spatial", "cart", STEPS, com=_mid(2), cart_damping="runtime", cart_friction=0.9, cart_friction_speed=1.5,
         friction="runtime", friction_speed=0.75, code="loops"),
    make("spatial_tip", 3, "spatial", "fixed", STEPS, code="loops"),
    make("spatial_rigid", 3, "spatial", "cart", STEPS, com=[0.3, 1.2, 0.0], inertia=_joint(3, 0.2), code="loops"),
    make("spatial_rigid_runtime", 2, "spatial", "fixed", mass="runtime", com=_mid(2), inertia="runtime", code="unrolled"),
    make("spatial_runtime", 2, "spatial", "fixed", stiffness="runtime", damping="runtime", code="unrolled", **_ALL_RUNTIME),
    make("spatial_cart_tip", 5, "spatial", "cart", code="loops"),
    make("spatial_cart_springs", 4, "spatial", "cart", mass="runtime", length="runtime", cart_mass="runtime",
         stiffness=_joint(4, 2.0), code="loops"),
    make("spatial_cart_mid", 2, "spatial", "cart", STEPS, com=_mid(2), damping=_joint(2, 0.3), code="loops"),
    make("planar_driven", 3, "planar", "cart", STEPS, drive="acceleration", com=_mid(3), actuated="all", code="loops"),
    make("planar_moving", 3, "planar", "moving", STEPS, damping=_joint(3, 0.4), angles="adjacent", actuated="all", code="unrolled"),
    make("spatial_driven", 2, "spatial", "cart", STEPS, drive="acceleration", cart_mass="runtime", code="loops"),
    make("spatial_moving", 2, "spatial", "moving", STEPS, com=_mid(2), gravity="runtime", code="loops"),
)  # fmt: skip
"""In double precision."""

FLOAT_SCENES = (
    make("float_planar", 2, "planar", "fixed", STEPS, com=_mid(2), actuated="all", code="loops", real="float"),
    make("float_planar_cart", 2, "planar", "cart", stiffness="runtime", damping="runtime", cart_mass="runtime",
         code="unrolled", real="float", **_ALL_RUNTIME),
    make("float_rigid", 3, "planar", "cart", com=[0.3, 0.4, 0.0], inertia=_joint(3, 0.2), actuated="all", code="loops", real="float"),
    make("float_geared", 2, "planar", "fixed", ("step_variational",), com=_mid(2), armature=_joint(2, 0.4), actuated="all", real="float"),
    make("float_planar_braked", 3, "planar", "cart", code="unrolled", real="float", **_BRAKED, cart_friction=0.9,
         cart_friction_speed=1.5),
    make("float_spatial_cart", 3, "spatial", "cart", code="unrolled", real="float", friction=0.5, friction_speed=0.75),
)  # fmt: skip
"""In single precision."""


def random_states(scene: Scene, programs: dict[str, Program], count: int, seed: int) -> Arguments:
    """Parameters once and every input `count` times, by name: directions unit, rates tangent to them."""
    rng = np.random.default_rng(seed)
    arrays = {a.name: a for program in programs.values() for a in program.inputs}
    states = {name: _rounded(scene, _drawn(array, count, rng)) for name, array in arrays.items()}
    if scene.space == "spatial":
        _onto_spheres(states, 2 if scene.has_cart else 0)
    params = next(iter(programs.values())).params
    return states | {array.name: _rounded(scene, _parameter(array, rng)) for array in params}


def _drawn(array: Array, count: int, rng: np.random.Generator) -> NDArray[np.float64]:
    shape = (count, *array.shape)
    match array.name:
        case "s":
            return rng.choice([-1.0, 1.0], shape)
        case "h":
            return rng.uniform(0.001, 0.01, shape)
        case "omega":
            return rng.uniform(0.5, 4.0, shape)
    return rng.normal(scale=2.0, size=shape)


def _parameter(array: Array, rng: np.random.Generator) -> NDArray[np.float64]:
    low, high = {"com": (0.2, 0.5), "length": (0.5, 1.0)}.get(array.name, (0.5, 1.5))
    return rng.uniform(low, high, array.shape)


def _onto_spheres(states: Arguments, cart: int) -> None:
    q = states["q"][:, cart:].reshape(len(states["q"]), -1, 3)
    q /= np.linalg.norm(q, axis=-1, keepdims=True)
    for name in states.keys() & {"v", "q_dot"}:
        rate = states[name][:, cart:].reshape(q.shape)
        rate -= q * np.sum(q * rate, axis=-1, keepdims=True)


def _rounded(scene: Scene, values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Values that the scene's type holds exactly."""
    return values.astype(np.float32).astype(float) if scene.real == "float" else values
