"""Small scenes of every kind with every function they have, and random states for them."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phichain.ir.nodes import Program
from phichain.scene import Scene
from tests.offered import offered

_ANGLES = ("relative", "absolute", "adjacent")


def make_scene(name: str, links: int, space: str = "planar", base: str = "fixed", **keys: Any) -> Scene:
    """A scene with uneven numbers wherever none are given."""
    numbers: dict[str, Any] = {
        "mass": [0.7 + 0.4 * k for k in range(links)],
        "length": [1.1 - 0.2 * k for k in range(links)],
    }
    if base == "cart":
        numbers["cart_mass"] = 1.9
    keys.setdefault("want", offered(space, "damping" in keys))
    return Scene(name, links, space=space, base=base, **(numbers | keys))


def _kind(number: int, space: str, base: str, com: bool, runtime: bool) -> Scene:
    """One kind of scene; angles, springs, dampers and actuation change from one to the next."""
    links = 2 if com and space == "spatial" else 3
    keys: dict[str, Any] = {}
    if com:
        keys["com"] = "runtime" if runtime else [0.4 + 0.1 * k for k in range(links)]
    if runtime:
        keys |= {"mass": "runtime", "length": "runtime", "gravity": "runtime"}
        keys |= {"cart_mass": "runtime"} if base == "cart" else {}
    if number % 2:
        keys["stiffness"] = "runtime" if runtime else [2.5 - 0.5 * k for k in range(links)]
    if number % 4 >= 2:
        keys["damping"] = "runtime" if runtime else [0.3 + 0.1 * k for k in range(links)]
    if space == "planar":
        keys["angles"] = _ANGLES[number % 3]
        keys["actuated"] = "all" if number % 3 else ("cart" if base == "cart" else "none")
    parts = [space, base, "com" if com else "tip", "runtime" if runtime else "fixed_numbers"]
    return make_scene("_".join(parts), links, space, base, **keys)


SCENES = tuple(
    _kind(number, *kind)
    for number, kind in enumerate(
        product(("planar", "spatial"), ("fixed", "cart"), (False, True), (False, True))
    )
)
"""One scene of each kind: space x base x centres of mass x runtime parameters."""

SINGLE = (
    make_scene("one_planar", 1),
    make_scene("one_spatial", 1, "spatial"),
    make_scene("one_cart", 1, base="cart"),
)
"""Chains of one link, where loops have no turns and matrices are constant."""


def random_arguments(
    program: Program, rng: np.random.Generator, space: str
) -> dict[str, NDArray[np.float64]]:
    """Arguments of a Program in which nothing is special; directions are unit, rates tangent."""
    arguments = {array.name: rng.uniform(0.5, 1.5, array.shape) for array in program.params}
    if {"com", "length"} <= arguments.keys():
        arguments["com"] = arguments["length"] * rng.uniform(0.2, 0.9, arguments["com"].shape)
    for array in program.inputs:
        arguments[array.name] = rng.normal(size=array.shape)
    if "omega" in arguments:
        arguments["omega"] = rng.uniform(0.5, 5.0, ())
    if "h" in arguments:  # a step of seconds would carry rounding errors far
        arguments["h"] = rng.uniform(0.001, 0.02, ())
    if "s" in arguments:
        arguments["s"] = np.sign(arguments["s"])
    if space == "spatial" and "q" in arguments:
        _make_tangent(arguments)
    return arguments


def _make_tangent(arguments: dict[str, NDArray[np.float64]]) -> None:
    cart = arguments["q"].size % 3
    q = arguments["q"][cart:].reshape(-1, 3)
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    for name in arguments.keys() & {"v", "q_dot"}:
        rate = arguments[name][cart:].reshape(-1, 3)
        rate -= q * np.sum(q * rate, axis=1, keepdims=True)


def random_batch(
    program: Program, states: int, space: str, seed: int = 20260101
) -> tuple[list[dict[str, NDArray[np.float64]]], dict[str, NDArray[np.float64]]]:
    """Random arguments, state by state and all together with the states first."""
    rng = np.random.default_rng(seed)
    single = [random_arguments(program, rng, space) for _ in range(states)]
    return single, {name: np.stack([one[name] for one in single]) for name in single[0]}


def stacked(program: Program, arguments: dict[str, Any]) -> list[Any]:
    """The arguments as CasADi takes them: p first, which stacks the runtime parameters."""
    params = [np.ravel(arguments[array.name]) for array in program.params]
    return [
        *([np.concatenate(params)] if params else []),
        *(arguments[array.name] for array in program.inputs),
    ]


def relative_error(actual: Any, expected: Any) -> float:
    """Max norm of the difference over max norm of the expected values; absolute where those are rounding errors."""
    actual, expected = np.asarray(actual, dtype=float), np.asarray(expected, dtype=float)
    assert actual.size == expected.size
    scale = np.max(np.abs(expected), initial=0.0)
    error = np.max(np.abs(actual.reshape(expected.shape) - expected), initial=0.0)
    return float(error / scale if scale > 1e-14 else error)
