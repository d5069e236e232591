"""The states that self-tests are made at: moderate, drawn from a seeded source, rounded once to the scene's type."""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from mpmath import mp

from phichain.ir.nodes import Array
from phichain.ir.rounded import nearest
from phichain.reference import reference
from phichain.scene import Scene

#: [s]
_LONGEST_STEP = 1 / 2**14
#: Bound of h^2 |a| for one step and for motions.
_MODERATE = 1 / 2**14
#: A spatial step's stages leave the sphere by O(h^2), and the reference's do not: below this bound of h^2 |a| the two ends, which
#: differ by about its power 5/2, are the same to round-off.
_SAME_ENDS = {"double": 1 / 2**22, "float": _MODERATE}


def draw_parameter(scene: Scene, array: Array, source: random.Random) -> list[float]:
    """Moderate values; com stays below length."""
    if array.name in ("com", "length"):
        low, high = (0.25, 0.5) if array.name == "com" else (0.5, 1.0)
        return [rounded(scene, source.uniform(low, high)) for _ in range(array.size)]
    return [rounded(scene, source.uniform(0.5, 2.0)) for _ in range(array.size)]


def draw_inputs(scene: Scene, arrays: Sequence[Array], source: random.Random) -> dict[str, list[float]]:
    """A value for every input: unit vectors, tangent rates, signs, steps and frequencies where those belong."""
    inputs = {}
    for array in arrays:
        draw: Callable[[], float] = lambda: source.uniform(-2.0, 2.0)
        if array.name == "s":
            draw = lambda: source.choice((-1.0, 1.0))
        elif array.name == "h":
            draw = lambda: _LONGEST_STEP
        elif array.name == "omega":
            draw = lambda: source.uniform(1.0, 4.0)
        inputs[array.name] = [rounded(scene, draw()) for _ in range(array.size)]
    if not scene.is_planar and "q" in inputs:
        _on_sphere(scene, inputs)
    return inputs


def slowed(scene: Scene, inputs: dict[str, list[float]], source: random.Random) -> dict[str, list[float]]:
    """Half of the states with dry friction, moving so slowly that it shows its slope; the others have it at full strength."""
    speeds = [speed for speed in (scene.friction_speed, scene.cart_friction_speed) if speed is not None]
    if not speeds or "v" not in inputs or source.random() < 0.5:
        return inputs
    return {**inputs, "v": [rounded(scene, min(*speeds, 1.0) * rate) for rate in inputs["v"]]}


def motion_step(scene: Scene, params: Mapping[str, list[float]], inputs: Mapping[str, list[float]]) -> float:
    """A step h [s] in whose units a motion is measured, well within the stability of RK4: see `step_length`."""
    return _shortened(scene, params, inputs, _MODERATE)


def step_length(
    scene: Scene, params: Mapping[str, list[float]], inputs: Mapping[str, list[float]], is_differentiated: bool = False
) -> float:
    """A step h [s], a power of two: h^2 |a| <= 2^-14, in space 2^-22 (double), and h |a| <= 2^-5 max(1, |v|).

    Beyond it a light link's joint makes the step grow without bound, and its result says nothing about the code. In space stages leave the
    spheres by h^2, beyond which reference and sweep are different functions: that is h^3 of the ends, and of their derivatives by u, which are of
    size h themselves, so that a step that is differentiated is an eighth as long.
    """
    h = _shortened(scene, params, inputs, _MODERATE if scene.is_planar else _SAME_ENDS[scene.real])
    return h / 8 if is_differentiated and not scene.is_planar else h


def _shortened(
    scene: Scene, params: Mapping[str, list[float]], inputs: Mapping[str, list[float]], most: float
) -> float:
    state = {name: inputs[name] for name in ("q", "v", "u") if name in inputs}
    acceleration = max(
        map(abs, reference(scene, "forward_dynamics", state, params=by_shape(scene, params))["a"])
    )
    fastest = max(1.0, *map(abs, inputs["v"]))
    h = _LONGEST_STEP
    while h * h * acceleration > most or h * acceleration > fastest / 2**5:
        h /= 2.0
    return h


def _on_sphere(scene: Scene, inputs: dict[str, list[float]]) -> None:
    """Unit vectors and tangent rates, each rounded once."""
    first = 2 if scene.has_cart else 0
    for start in range(first, scene.nq, 3):
        q = inputs["q"][start : start + 3]
        with mp.workdps(50):
            norm = mp.sqrt(mp.fsum(mp.mpf(x) ** 2 for x in q))
            unit = [mp.mpf(x) / norm for x in q]
        inputs["q"][start : start + 3] = [rounded(scene, x) for x in unit]
        for name in ("v", "q_dot"):
            if name not in inputs:
                continue
            rate = inputs[name][start : start + 3]
            with mp.workdps(50):
                along = mp.fsum(a * b for a, b in zip(unit, rate, strict=True))
                rate = [rounded(scene, w - along * x) for w, x in zip(rate, unit, strict=True)]
            inputs[name][start : start + 3] = rate


def shaped(arrays: Sequence[Array], values: Mapping[str, list[float]]) -> dict[str, Any]:
    """Values as the reference takes them: lists for arrays, numbers for scalars."""
    return {array.name: values[array.name] if array.shape else values[array.name][0] for array in arrays}


def by_shape(scene: Scene, values: Mapping[str, list[float]]) -> dict[str, Any]:
    """The same for values of runtime parameters."""
    return {name: given if scene.runtime_shapes[name] else given[0] for name, given in values.items()}


def rounded(scene: Scene, value: Any) -> float:
    """The nearest number of the scene's type."""
    return nearest(scene.real, value)
