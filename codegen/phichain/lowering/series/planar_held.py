"""Where the numbers of a planar step sit in `held` (lowering.series.planar)."""

from __future__ import annotations

from phichain.ir.builder import ArrayRef
from phichain.scene import Scene

_PER_LINK = (
    "q_xx", "q_xy", "q_yx", "q_yy",  # Q
    "axial", "skew",  # what C'' adds to p'
    "gain_x", "gain_y",  # U / D
    "inverse", "lag",  # 1 / D, l^2 A_yy / D
    "arm_x", "arm_y",  # l s / D, l c / D
    "pull_x", "pull_y",  # force along the link before for an acceleration of the joint at the link's base
    "sine", "cosine",  # of the joint at the link's base
)  # fmt: skip
"""What is kept of each link; Q, arms and so on belong to the link and the joint at its tip."""


class Layout:
    """Where each number sits in `held`; what a scene does not need has no place."""

    def __init__(self, scene: Scene) -> None:
        links = scene.links
        names = [name for name in _PER_LINK if not (scene.tip_masses and name in ("q_yx", "q_yy", "skew", "pull_y"))]
        self.offsets = {name: links * i for i, name in enumerate(names)}
        self.size = links * len(names)
        for name, present, count in (
            ("base", True, 2), ("base_arm", scene.has_cart, 2), ("drive", bool(scene.actuated_joints), links),
            ("push", scene.has_force, 1), ("stiffness", scene.stiffness is not None, links),
            ("damping", scene.damping is not None, links),
        ):  # fmt: skip
            if present:
                self.offsets[name] = self.size
                self.size += count

    def of(self, held: ArrayRef, name: str) -> ArrayRef | None:
        """Where a quantity's numbers begin, or None."""
        return held.shifted(self.offsets[name]) if name in self.offsets else None
