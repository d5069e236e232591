"""Reference of (15), paper B's equations in the unit vectors: Lagrange multipliers, nothing of angular velocities.

The links' directions are treated as free vectors of R^3 held to their spheres by multipliers Lambda_k,

    M00 x'' + sum_k mu_k C^T q_k'' = u,    sum_a m_a lever_ak (r_a'' - g e_3) = Lambda_k q_k + couple_k x q_k,
    q_k . q_k'' = -|q_k'|^2,    r_a'' = C x'' + sum_k lever_ak q_k'',

one dense linear system of size 2 + 4 N for [x'', q'', Lambda]. Multiplying the rows of a link by I - q_k q_k^T gives the printed
(15); here they stay as they come from the positions, so that neither (15) nor (16) is assumed.
"""

from __future__ import annotations

from mpmath import fdot, mpf

from phichain.reference import dense
from phichain.reference.algebra import Matrix, Vector, cross, solve, unit
from phichain.reference.case import Case, Outputs, judges
from phichain.reference.pose import Pose, cart_axes, project, spatial_pose


@judges("direction_dynamics")
def direction_dynamics(case: Case) -> Outputs:
    """Solve for q'' = [x'', q_k''] at the exact state nearest to (q, q')."""
    pose = _pose(case)
    carts, links = cart_axes(case.scene), case.scene.links
    columns = _free_columns(case, carts)
    matrix = dense.mass_matrix(case.scene, case.values, columns)
    size = len(matrix)
    held = [
        [mpf(0)] * (carts + 3 * k) + link + [mpf(0)] * 3 * (links - k - 1)
        for k, link in enumerate(pose.direction)
    ]
    rows = [row + [-constraint[i] for constraint in held] for i, row in enumerate(matrix)]
    rows += [constraint + [mpf(0)] * links for constraint in held]
    push = [fdot(row, case.inputs["u"]) for row in dense.input_matrix(case.scene, size)]
    weight = dense.conjugate(case.values, columns, dense.anti_gravity(case.values, pose))
    forces = [a - b + c for a, b, c in zip(push, weight, _couple_force(case, pose, carts), strict=True)]
    bound = [-fdot(rate, rate) for rate in pose.rate]
    return {"q_ddot": solve(rows, [forces + bound])[0][:size]}


def _pose(case: Case) -> Pose:
    """The pose of (q, q'); q_k' is made tangent as omega_k is elsewhere."""
    carts = cart_axes(case.scene)
    q, q_dot = project(case.scene, case.inputs["q"], case.inputs["q_dot"])
    turning = [cross(q[k : k + 3], q_dot[k : k + 3]) for k in range(carts, len(q), 3)]
    return spatial_pose(
        case.scene, q, q_dot[:carts] + [entry for omega in turning for entry in omega], ambient=True
    )


def _free_columns(case: Case, carts: int) -> Matrix:
    """dr/d[x, q_1, ..], each the N positions stacked: the links' vectors unconstrained."""
    levers = case.values.levers()
    cart = [unit(3, axis) * case.scene.links for axis in range(carts)]
    axes = [unit(3, axis) for axis in range(3)]
    return cart + [
        [arm[k] * entry for arm in levers for entry in axis] for k in range(case.scene.links) for axis in axes
    ]


def _couple_force(case: Case, pose: Pose, carts: int) -> Vector:
    """couple_k x q_k of springs and dampers: the force on q_k that works as the couple does, couple.xi = force.(xi x q_k)."""
    couples = dense.joint_force(case.scene, case.values, pose)[carts:]
    forces = [cross(couples[3 * k : 3 * k + 3], link) for k, link in enumerate(pose.direction)]
    return [mpf(0)] * carts + [entry for force in forces for entry in force]
