"""The unit of time of planar sweeps whose forces would leave the range of their type (docs/theory.md, section 5).

In a light link's own units, m r^2 / l^2 of mass, what is beyond it is large, and forces times inertias are larger: past the range of
single precision from r / l = 1e-8 on. Forces go by 1 / s^2, and accelerations with them: in a shorter second, a power of two, they
fit, and no digit changes.
"""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from itertools import pairwise
from math import ceil, inf
from typing import Any, Final

from phichain.lowering.chain.body import is_folded, moments
from phichain.scene import Scene

#: Powers of two up to which products may come by the bound below; what is left of a type's range is for faster motions and for sums.
_LARGEST: Final = {"float": 96, "double": 992}
#: Power of two of the squared rates of a moderate motion, rad^2/s^2.
_SQUARED_RATE: Final = 4


def time_unit(scene: Scene) -> Fraction:
    """The unit of time, s; 1 where forces stay in range anyway, and where masses or lengths come at run time.

    Args:
        scene: a planar chain without rotors.
    """
    if not is_folded(scene):
        return Fraction(1)
    beyond = _largest(scene) - _LARGEST[scene.real]
    return Fraction(1, 2 ** ceil(beyond / 2)) if beyond > 0 else Fraction(1)


def _largest(scene: Scene) -> float:
    """The power of two of the largest product of a force and an inertia in a link's own units, up to the number of terms."""
    length, torques = _powers(scene.length), _torques(scene)
    first, second, mass = _moments(scene)
    largest, beyond, pull = -inf, -inf, -inf
    for k in range(scene.links - 1, -1, -1):
        leverage = first[k] + length[k] - second[k]
        inertia = max(0.0, 2 * leverage, beyond - (second[k] - 2 * length[k]))
        force = max(_SQUARED_RATE, pull + length[k] - second[k], torques[k] - second[k])
        largest = max(largest, inertia + force)
        beyond = max(beyond, mass[k])
        pull = max(pull, _SQUARED_RATE + beyond + length[k], torques[k] + first[k] - second[k])
    return largest


def _moments(scene: Scene) -> tuple[list[float], list[float], list[float]]:
    """Powers of two of m r, m r^2 and m, or of what stands for them in rigid links."""
    if scene.inertia is not None:
        found = moments(scene)
        first, second = _powers(found.first), _powers(found.second)
        return first, second, [2 * a - b for a, b in zip(first, second, strict=True)]
    mass, com = _powers(scene.mass), _powers(scene.length if scene.com is None else scene.com)
    return (
        [m + r for m, r in zip(mass, com, strict=True)],
        [m + 2 * r for m, r in zip(mass, com, strict=True)],
        mass,
    )


def _torques(scene: Scene) -> list[float]:
    """Powers of two of the torques that links may feel; inputs, and what is not known, are some N m."""
    given = [scene.damping, scene.friction, scene.stiffness]
    joints = [0.0 if scene.actuated_joints or "runtime" in given else -inf] * (scene.links + 1)
    for values in given:
        if values is not None and values != "runtime":
            joints[:-1] = map(max, joints, _powers(values))
    return [max(pair) for pair in pairwise(joints)]


def _powers(values: Iterable[Any]) -> list[float]:
    return [_power(abs(Fraction(value))) for value in values]


def _power(value: Fraction) -> float:
    """The logarithm to base two within a sixteenth, from whole numbers' bits: libm's would be a processor's own."""
    if not value:
        return -inf
    return ((value.numerator**16).bit_length() - (value.denominator**16).bit_length()) / 16
