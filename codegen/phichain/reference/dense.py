"""The chain's dense mechanics: positions, their Jacobians and d'Alembert's principle, nothing clever.

This is the ground the reference stands on. It shares no formula with the lowered programs: no mu_k, no c_ij,
no tension, no sweep. Every quantity comes from the positions r_a of the point masses (theory section 1)

    r_a = C x + sum_{k<a} l_k q_k + com_a q_a,

their Jacobians J_a with respect to the rates, and sum_a J_a^T m_a (r_a'' - g e_d) = generalised force.
"""

from __future__ import annotations

from mpmath import fdot, mpf

from phichain.reference.algebra import Matrix, Vector, product, transposed, unit
from phichain.reference.pose import Parameters, Pose, angle_map, cart_axes
from phichain.scene import Scene


def jacobian(scene: Scene, values: Parameters, pose: Pose) -> Matrix:
    """Return the columns of dr/d(rates), each the N positions stacked (m): the cart's, then the links'.

    Planar columns are those of the scene's own angles theta, by J_theta = J_phi S.
    """
    size = len(pose.direction[0])
    levers = values.levers()
    cart = [unit(size, axis) * scene.links for axis in range(cart_axes(scene))]
    links = [
        [arm[k] * entry for arm in levers for entry in turn]
        for k, own in enumerate(pose.turning)
        for turn in own
    ]
    return cart + (product(transposed(angle_map(scene)), links) if scene.is_planar else links)


def mass_matrix(scene: Scene, values: Parameters, columns: Matrix) -> Matrix:
    """Return sum_a m_a J_a^T J_a, with m_0 on the cart's diagonal."""
    heavy = [weighted(values, column) for column in columns]
    matrix = [[mpf(0)] * len(columns) for _ in columns]
    for i, row in enumerate(heavy):
        for j in range(i + 1):
            matrix[i][j] = matrix[j][i] = fdot(row, columns[j])
    for axis in range(cart_axes(scene)):
        matrix[axis][axis] += values.cart_mass
    return matrix


def conjugate(values: Parameters, columns: Matrix, acceleration: Vector) -> Vector:
    """Return sum_a J_a^T m_a r_a'' for stacked accelerations r_a'' (m/s^2)."""
    force = weighted(values, acceleration)
    return [fdot(column, force) for column in columns]


def weighted(values: Parameters, column: Vector) -> Vector:
    """Return the entries of N stacked vectors times their mass m_a."""
    size = len(column) // len(values.mass)
    return [values.mass[i // size] * entry for i, entry in enumerate(column)]


def stacked(values: Parameters, links: Matrix) -> Vector:
    """Return sum_k lever_ak w_k for every mass a, stacked, for one vector w_k per link."""
    return [fdot(arm, axis) for arm in values.levers() for axis in transposed(links)]


def centripetal(values: Parameters, pose: Pose) -> Vector:
    """Return r_a'' at vanishing rates' rates, stacked (m/s^2): -sum_k lever_ak |q_k'|^2 q_k."""
    inward = [
        [-fdot(rate, rate) * entry for entry in link]
        for rate, link in zip(pose.rate, pose.direction, strict=True)
    ]
    return stacked(values, inward)


def anti_gravity(values: Parameters, pose: Pose) -> Vector:
    """Return -g e_d for every mass, stacked (m/s^2)."""
    size = len(pose.direction[0])
    return [-values.gravity * entry for entry in unit(size, size - 1)] * len(values.mass)


def joint_force(scene: Scene, values: Parameters, pose: Pose) -> Vector:
    """Return the generalised force of springs and dampers (N m; N for the cart, always 0).

    Joint k loads its outer link with -k_k bend_k - d_k (spin_k - spin_{k-1}) and its inner one with the
    opposite.
    """
    zero = [mpf(0)] * len(pose.spin[0])
    moments = [
        [-k * angle - d * (outer - inner) for angle, outer, inner in zip(bend, spin, before, strict=True)]
        for k, d, bend, spin, before in zip(
            values.stiffness, values.damping, pose.bend, pose.spin, [zero, *pose.spin], strict=False
        )
    ]
    couples = [
        [own - beyond for own, beyond in zip(moment, after, strict=True)]
        for moment, after in zip(moments, [*moments[1:], zero], strict=True)
    ]
    force = [fdot(axis, couple) for own, couple in zip(pose.axes, couples, strict=True) for axis in own]
    if scene.is_planar:
        force = [fdot(column, force) for column in transposed(angle_map(scene))]
    return [mpf(0)] * cart_axes(scene) + force


def input_matrix(scene: Scene, size: int) -> Matrix:
    """Return B, size x nu: the force on the cart's axes, then the scene's own angles that are actuated."""
    carts = cart_axes(scene)
    driven = list(range(carts)) if scene.has_force else []
    driven += [carts + joint - 1 for joint in scene.actuated_joints]
    return [[mpf(int(row == target)) for target in driven] for row in range(size)]
