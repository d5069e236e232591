"""The factorisation of a step of a planar chain whose joints carry rotors (lowering.planar.geared)."""

from __future__ import annotations

from phichain.ir.builder import ArrayRef
from phichain.lowering.planar.geared.elimination import Elimination
from phichain.lowering.planar.geared.torques import torques
from phichain.lowering.series.planar_factor import Factor, directions


class GearedFactor(Factor):
    """The elimination with rotors; springs, dampers and what pushes a cart are those of any planar chain."""

    def write(self, q: ArrayRef, lost: ArrayRef, u: ArrayRef | None) -> None:
        """All numbers of `held`."""
        offset = int(self.scene.has_cart)
        joints = directions(self.builder, self.scene, q.shifted(offset), lost.shifted(offset))
        elimination = Elimination(self.builder, self.scene, self.parameters, joints, self.keep)
        elimination.base(elimination.run(), tuple(self.square * entry for entry in self.parameters.fall))
        self.hold_moments()
        self.inputs(u)
        if "rest" in self.layout:
            self.rests(q, lost)

    def driven(self, u: ArrayRef | None) -> ArrayRef | None:
        """What inputs do: torques on the links, or across the joints where angles are relative."""
        acting = torques(self.builder, self.scene, self.parameters, None, u)
        return acting.joint if acting.link is None else acting.link
