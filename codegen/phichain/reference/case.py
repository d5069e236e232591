"""One evaluation of the reference, and which plain function evaluates which function of the contract."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final, TypeVar

from mpmath import mpf

from phichain.contract.registry import Registry
from phichain.reference.pose import Parameters, Pose, planar_pose, spatial_pose
from phichain.scene import Scene

Outputs = dict[str, Any]


@dataclass(frozen=True)
class Case:
    """One evaluation: the scene, its numbers and the inputs, all at the working precision."""

    scene: Scene
    values: Parameters
    inputs: Mapping[str, Any]

    def pose(self, ambient: bool = False) -> Pose:
        """Return the pose at the inputs q and v (v = 0 for a function that takes none)."""
        q = self.inputs["q"]
        v = self.inputs.get("v", [mpf(0)] * self.scene.nv)
        if self.scene.is_planar:
            return planar_pose(self.scene, q, v)
        return spatial_pose(self.scene, q, v, ambient)

    def at(self, **inputs: Any) -> Case:
        """Return the same case with some inputs replaced."""
        return Case(self.scene, self.values, {**self.inputs, **inputs})


Judge = TypeVar("Judge", bound=Callable[[Case], Outputs])

JUDGES: Final[Registry[Callable[[Case], Outputs]]] = Registry("phichain.reference", "reference")


def judges(name: str) -> Callable[[Judge], Judge]:
    """Register the reference of a function of the contract."""

    def register(judge: Judge) -> Judge:
        JUDGES.add(name, judge)
        return judge

    return register
