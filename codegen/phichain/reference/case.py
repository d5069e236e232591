"""One evaluation of the reference, and which plain function evaluates which function of the contract."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, TypeVar

from mpmath import mpf

from phichain.contract.bases import FIXED
from phichain.contract.registry import Registry
from phichain.reference.pose import Parameters, Pose, cart_axes, planar_pose, spatial_pose
from phichain.scene import Scene

Outputs = dict[str, Any]


@dataclass(frozen=True)
class Case:
    """One evaluation: the scene, its numbers and the inputs, all at the working precision.

    Attributes:
        scene: the chain.
        values: its numbers.
        inputs: the arguments by name.
        base: acceleration of the place that positions are counted from, m/s^2; none where it rests.
    """

    scene: Scene
    values: Parameters
    inputs: Mapping[str, Any]
    base: Sequence[Any] = ()

    def pose(self, ambient: bool = False) -> Pose:
        """Return the pose at the inputs q and v (v = 0 for a function that takes none)."""
        q = self.inputs["q"]
        v = self.inputs.get("v", [mpf(0)] * self.scene.nv)
        if self.scene.is_planar:
            return planar_pose(self.scene, q, v)
        return spatial_pose(self.scene, q, v, ambient)

    def at(self, **inputs: Any) -> Case:
        """Return the same case with some inputs replaced."""
        return replace(self, inputs={**self.inputs, **inputs})

    def links(self) -> Case:
        """The links of a chain whose base is given its acceleration, seen from there: on a wall that has it."""
        scene, carts, u = self.scene, cart_axes(self.scene), self.inputs["u"]
        given, torques = u[: scene.base_accelerations], u[scene.base_accelerations :]
        wall = replace(
            scene, base=FIXED.base, drive=None, cart_mass=None, cart_damping=None, cart_friction=None, cart_friction_speed=None,
            actuated=scene.actuated if scene.actuated_joints else "none", want=("forward_dynamics",),
            variational=False, forced=None, axis=None,
        )  # fmt: skip
        own = {name: self.inputs[name][carts:] for name in ("q", "v", "q_dot") if name in self.inputs}
        return Case(wall, self.values, {**self.inputs, **own, "u": torques}, along_told(scene, given))


def along_told(scene: Scene, given: Sequence[Any]) -> list[Any]:
    """The acceleration of a base by its components along the axes that it is told; it has none along others."""
    known = dict(zip(scene.told_axes, given, strict=True))
    return [known.get(axis, mpf(0)) for axis in range(scene.dimensions)]


Judge = TypeVar("Judge", bound=Callable[[Case], Outputs])

JUDGES: Final[Registry[Callable[[Case], Outputs]]] = Registry("phichain.reference", "reference")


def judges(name: str) -> Callable[[Judge], Judge]:
    """Register the reference of a function of the contract."""

    def register(judge: Judge) -> Judge:
        JUDGES.add(name, judge)
        return judge

    return register
