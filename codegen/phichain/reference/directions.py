"""Reference of (15), paper B's equations in the unit vectors: Lagrange multipliers, nothing of angular velocities.

The links' directions are treated as free vectors of R^3 held to their spheres by multipliers Lambda_k,

    M00 x'' + sum_k mu_k C^T q_k'' = u,    sum_a m_a lever_ak (r_a'' - g e_3) = Lambda_k q_k + couple_k x q_k,
    q_k . q_k'' = -|q_k'|^2,    r_a'' = C x'' + sum_k lever_ak q_k'',

one linear system for [x'', q'', Lambda]. Multiplying the rows of a link by I - q_k q_k^T gives the printed
(15); here they stay as they come from the positions, so that neither (15) nor (16) is assumed.
"""

from __future__ import annotations

from dataclasses import replace

from mpmath import fdot, mpf

from phichain.reference import masses
from phichain.reference.algebra import Vector, cross
from phichain.reference.case import Case, Outputs, judges
from phichain.reference.inertia import Inertia
from phichain.reference.pose import Pose, cart_axes, project, spatial_pose


@judges("direction_dynamics")
def direction_dynamics(case: Case) -> Outputs:
    """Solve for q'' = [x'', q_k''] at the exact state nearest to (q, q')."""
    if case.scene.base_accelerations:
        return {"q_ddot": case.inputs["u"][: cart_axes(case.scene)] + direction_dynamics(case.links())["q_ddot"]}
    scene, values, pose = case.scene, case.values, _pose(case)
    carts = cart_axes(scene)
    free = replace(pose, turning=[pose.axes[0]] * scene.links)
    push = [*case.inputs["u"], *[mpf(0)] * (carts + 3 * scene.links - scene.nu)]
    weight = masses.conjugate(scene, values, free, masses.anti_gravity(values, pose, case.base))
    forces = [a - b + c for a, b, c in zip(push, weight, _couple_force(case, pose, carts), strict=True)]
    bound = [-fdot(rate, rate) for rate in pose.rate]
    (answer,) = Inertia(scene, values, free, normals=pose.direction).solve(forces + bound)
    return {"q_ddot": answer[: carts + 3 * scene.links]}


def _pose(case: Case) -> Pose:
    """The pose of (q, q'); q_k' is made tangent as omega_k is elsewhere."""
    carts = cart_axes(case.scene)
    q, q_dot = project(case.scene, case.inputs["q"], case.inputs["q_dot"])
    turning = [cross(q[k : k + 3], q_dot[k : k + 3]) for k in range(carts, len(q), 3)]
    return spatial_pose(
        case.scene, q, q_dot[:carts] + [entry for omega in turning for entry in omega], ambient=True
    )


def _couple_force(case: Case, pose: Pose, carts: int) -> Vector:
    """The cart's force, and couple_k x q_k of springs and dampers: the force on q_k that works as the couple does.

    couple.xi = force.(xi x q_k).
    """
    force = masses.joint_force(case.scene, case.values, pose)
    couples = force[carts:]
    forces = [cross(couples[3 * k : 3 * k + 3], link) for k, link in enumerate(pose.direction)]
    return force[:carts] + [entry for own in forces for entry in own]
