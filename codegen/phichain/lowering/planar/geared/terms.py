"""What rotors at the joints add to the functions of a planar chain: T += 1/2 A_k slip_k^2, slip_k the rate of joint k."""

from __future__ import annotations

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.planar.geared.joint_form import with_joints
from phichain.lowering.planar.joints import congruence, difference
from phichain.scene import Scene


def couples(builder: Builder, scene: Scene, parameters: Parameters, name: str, own: ArrayRef) -> ArrayRef | None:
    """A_k slip_k - A_{k+1} slip_{k+1}, conjugate to absolute angles; None without rotors.

    `own` are rates, accelerations or amplitudes of the scene's own angles; slip those of the joints.
    """
    armature = parameters.armature
    if armature is None:
        return None
    slip, couple = difference(builder, scene, f"{name}_slip", own), builder.array(name, scene.links)
    with builder.loop("k", scene.links - 1, -1, -1) as loop:
        beyond = loop.carry("rotor_beyond", 0)
        moment = builder.let("rotor", armature[loop.index] * slip[loop.index])
        couple[loop.index] = moment - beyond
        loop.follow(beyond, moment)
    return couple


def added(value: Expr, couple: ArrayRef | None, k: Index) -> Expr:
    """A force on link k with the rotors' couple, if there is one."""
    return value if couple is None else value + couple[k]


def inertia(builder: Builder, scene: Scene, parameters: Parameters, inner: ArrayRef, out: ArrayRef) -> None:
    """Write the angles' block of a mass matrix: S^T M S of the links' inertia in absolute angles, and the rotors."""
    first, armature = int(scene.has_cart), parameters.armature
    if armature is None:
        congruence(builder, scene, inner, out.shifted(first * (scene.nv + 1)), scene.nv)
        return
    block = builder.array("links_inertia", scene.links * scene.links)
    congruence(builder, scene, inner, block, scene.links)
    with_joints(
        builder, scene, armature.__getitem__, block, out, lambda i, j: (i + first) * scene.nv + first + j
    )


def kinetic(parameters: Parameters, slip: ArrayRef, k: Index) -> Expr | None:
    """A_k slip_k^2, twice the energy of rotor k; None without rotors."""
    if parameters.armature is None:
        return None
    return parameters.armature[k] * (slip[k] * slip[k])
