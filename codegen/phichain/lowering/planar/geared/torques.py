"""Torques of a planar chain with those across its joints kept apart: behind a rotor most of one never reaches the link before.

A torque j_k across joint k acts on link k and, reversed, on link k - 1; the rotor there takes A_k (alpha_k - alpha_{k-1}) of it. What
link k - 1 feels is the difference, which is lost once j_k and j_{k+1} are summed to one torque a link (`substitution`).
"""

from __future__ import annotations

from dataclasses import dataclass

from phichain.ir.builder import ArrayRef, Builder
from phichain.lowering.chain.losses import ties_links
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.planar.joints import PlanarState, drive, input_couples, passive_torque
from phichain.scene import Scene


@dataclass(frozen=True)
class Torques:
    """What turns the links beside forces at their joints; None where nothing does.

    Attributes:
        link: torques on the links from elsewhere, conjugate to absolute angles, N cells.
        joint: torques across the joints, conjugate to relative angles, N cells.
    """

    link: ArrayRef | None = None
    joint: ArrayRef | None = None


def torques(builder: Builder, scene: Scene, parameters: Parameters, state: PlanarState | None, u: ArrayRef | None) -> Torques:
    """Those of all inputs, springs, dampers and dry friction.

    Args:
        builder: where the Program is recorded.
        scene: the chain.
        parameters: its numbers.
        state: angles and rates; None for the inputs alone.
        u: the inputs.
    """
    if scene.angles == "relative":
        link, driven = None, drive(builder, scene, parameters, u)
    else:
        link, driven = input_couples(builder, scene, parameters, u), None
    if state is None or not ties_links(scene):
        return Torques(link, driven)
    joint = builder.array("joint_torque", scene.links)
    with builder.loop("k", 0, scene.links) as loop:
        passive = passive_torque(scene, parameters, state, loop.index)
        assert passive is not None
        joint[loop.index] = passive if driven is None else driven[loop.index] + passive
    return Torques(link, joint)
