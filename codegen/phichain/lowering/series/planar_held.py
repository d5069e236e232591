"""Where the numbers of a planar step sit in `held` (lowering.series.planar)."""

from __future__ import annotations

from phichain.lowering.chain.body import is_folded
from phichain.lowering.planar.geared.elimination import layout_of as geared_layout
from phichain.lowering.planar.joint_state import loses_bends
from phichain.lowering.series.dry import runs as dry_runs
from phichain.lowering.series.held import Layout
from phichain.lowering.series.two_links.factor import runs as two_links_runs
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


def inverts(scene: Scene) -> bool:
    """Whether the matrix of a step is inverted as a whole: two links, neither a cart nor rotors beside them."""
    return scene.links == 2 and not scene.has_cart and scene.armature is None


def planar_layout(scene: Scene) -> Layout:
    """What is held of a scene's links, its base, inputs and joints."""
    links = scene.links
    runs = [(name, 0 if scene.tip_masses and name in ("q_yx", "q_yy", "skew", "pull_y") else links) for name in _PER_LINK]
    runs += [("base", 2), ("base_arm", 2 * scene.has_free_cart)]
    if inverts(scene):
        runs = list(two_links_runs())
    is_held = scene.inertia is not None and not is_folded(scene)
    if scene.armature is not None:
        runs, is_held = list(geared_layout(scene)), False
    runs += [
        ("drive", links * bool(scene.actuated_joints)), ("push", int(scene.has_force)),
        ("cart_damping", int(scene.has_free_cart and scene.cart_damping is not None)),
        ("stiffness", links * (scene.stiffness is not None)),
        ("damping", links * (scene.damping is not None)),
        ("rest", links * loses_bends(scene)),
        ("rest_angle", links * (scene.forced is not None and scene.rest_angle is not None)),
        *((name, links * is_held) for name in ("own_moment", "second_moment")), *dry_runs(scene),
    ]  # fmt: skip
    return Layout(runs)
