"""Reference of the functions that are one evaluation of the mechanics: accelerations, forces, (19)."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from mpmath import fdot, mpf

from phichain.reference import masses
from phichain.reference.algebra import Matrix, Vector, transposed
from phichain.reference.case import Case, Outputs, along_told, judges
from phichain.reference.inertia import Inertia
from phichain.reference.pose import Pose, cart_axes, project, pulled_back, straight_pose
from phichain.scene import Scene


@judges("forward_dynamics")
def forward_dynamics(case: Case) -> Outputs:
    """Solve M a = B u - load; omega_k' is put together from the two tangent axes of its link.

    A base that is given its acceleration has no equation: r_a'' of every mass has it, and forces are those of the links.
    """
    if case.scene.base_accelerations:
        return {"a": case.inputs["u"][: cart_axes(case.scene)] + forward_dynamics(case.links())["a"]}
    pose = case.pose()
    push = masses.push(case.scene, case.inputs["u"])
    (rates,) = Inertia(case.scene, case.values, pose).solve([a - b for a, b in zip(push, load(case, pose), strict=True)])
    if case.scene.is_planar:
        return {"a": rates}
    carts = cart_axes(case.scene)
    return {"a": rates[:carts] + [entry for turn in masses.spun(pose, rates[carts:]) for entry in turn]}


def load(case: Case, pose: Pose) -> Vector:
    """Return coriolis + gravity - joint forces, conjugate to the rates of the pose."""
    scene, values = case.scene, case.values
    fall = [
        a + b
        for a, b in zip(masses.centripetal(values, pose), masses.anti_gravity(values, pose, case.base), strict=True)
    ]
    inertial = masses.conjugate(scene, values, pose, fall)
    return [a - b for a, b in zip(inertial, masses.joint_force(scene, values, pose), strict=True)]


@judges("inverse_dynamics")
def inverse_dynamics(case: Case) -> Outputs:
    """u = M a + coriolis + gravity + springs + dampers + dry friction, the full generalised force (planar).

    The accelerations of the masses are summed up link by link, without the inertia matrix.
    """
    if case.scene.is_moving:
        case = replace(case, base=along_told(case.scene, case.inputs["b"])) if "b" in case.inputs else case
    pose = case.pose()
    inertial = Inertia(case.scene, case.values, pose).times(case.inputs["a"])
    return {"u": [a + b for a, b in zip(inertial, load(case, pose), strict=True)]}


@judges("mass_matrix")
def mass_matrix(case: Case) -> Outputs:
    """I of (15), or the matrix of (16): J^T m J with c_kk q_k q_k^T added on the diagonal."""
    pose = case.pose(ambient=True)
    matrix = Inertia(case.scene, case.values, pose).written()
    if not case.scene.is_planar:
        for k, (link, moment) in enumerate(zip(pose.direction, case.values.moments(2), strict=True)):
            start = cart_axes(case.scene) + 3 * k
            for i in range(3):
                row = matrix[start + i]
                row[start : start + 3] = [
                    a + moment * link[i] * b for a, b in zip(row[start:], link, strict=False)
                ]
    return {"M": matrix}


@judges("coriolis")
def coriolis(case: Case) -> Outputs:
    """N of (15), or the velocity terms of (16)."""
    pose = case.pose(ambient=True)
    acceleration = masses.centripetal(case.values, pose)
    return {"N": masses.conjugate(case.scene, case.values, pose, acceleration)}


@judges("gravity_torque")
def gravity_torque(case: Case) -> Outputs:
    """G of (15), or the gravity terms of (16): gravity alone, without springs."""
    pose = case.pose(ambient=True)
    acceleration = masses.anti_gravity(case.values, pose)
    return {"G": masses.conjugate(case.scene, case.values, pose, acceleration)}


@judges("energy")
def energy(case: Case) -> Outputs:
    """T = 1/2 m_0 |x'|^2 + sum 1/2 m_a |r_a'|^2 (+ 1/2 J_k |q_k'|^2 + the rotors'), V = -g sum m_a e_d.r_a + the springs' energy (J)."""
    values, pose = case.values, case.pose()
    velocity = masses.stacked(values, pose.rate, pose.cart_rate)
    kinetic = fdot(masses.weighted(values, velocity), velocity) / 2
    if case.scene.has_cart:
        kinetic += values.cart_mass * fdot(pose.cart_rate, pose.cart_rate) / 2
    if any(values.armature):
        spins = [rate for (rate,) in pose.spin]
        kinetic += fdot(values.armature, [(a - b) ** 2 for a, b in zip(spins, [mpf(0), *spins], strict=False)]) / 2
    places = masses.stacked(values, pose.direction)
    height = fdot(masses.anti_gravity(values, pose), masses.weighted(values, places))
    return {"kinetic": kinetic, "potential": height + _spring_energy(case, pose)}


@judges("momentum")
def momentum(case: Case) -> Outputs:
    """p = sum_a J_a^T m_a r_a' + m_0 x' + rotors (kg m/s, kg m^2/s), in space along three axes a link: q_k x (its share of J^T m r')."""
    values, pose = case.values, case.pose(ambient=True)
    velocity = masses.stacked(values, pose.rate, pose.cart_rate)
    result = masses.conjugate(case.scene, values, pose, velocity)
    for axis, rate in enumerate(pose.cart_rate):
        result[axis] += values.cart_mass * rate
    if case.scene.is_planar:
        rotors = masses.rotor_momentum(case.scene, values, case.inputs["v"])
        result = [a + b for a, b in zip(result, rotors, strict=True)]
    return {"p": result}


@judges("positions")
def positions(case: Case) -> Outputs:
    """r_a, N x d (m), the last axis along gravity."""
    pose = case.pose()
    size = len(pose.direction[0])
    flat = masses.stacked(case.values, pose.direction, pose.cart_position)
    return {"r": [flat[i : i + size] for i in range(0, size * case.scene.links, size)]}


@judges("linearization")
def linearization(case: Case) -> Outputs:
    """(19) at q_k = s_k e_d: M and B of that pose, G and D from second variations of V and the dissipation.

    Along any axis d^2 q_k = -q_k, so gravity curves V by g s_k sum_a m_a lever_ak. Springs curve it by k_k
    times the square of the difference of neighbouring rotations, in space with the sign s_{k-1} s_k. Dry friction resists small
    rates as a damper F / v_0 does.
    """
    scene, values, signs = case.scene, case.values, [int(s) for s in case.inputs["s"]]
    pose = straight_pose(scene, signs)
    weight = [s * values.gravity * moment for s, moment in zip(signs, values.moments(1), strict=True)]
    align = (
        [1] * scene.links if scene.is_planar else [a * b for a, b in zip([1, *signs], signs, strict=False)]
    )
    spring = _joint_form([k * a for k, a in zip(values.stiffness, align, strict=True)])
    stiff = [[entry + weight[i] * int(i == j) for j, entry in enumerate(row)] for i, row in enumerate(spring)]
    outputs = {
        "M": Inertia(scene, values, pose).written(),
        "G": _in_coordinates(scene, stiff),
        "B": masses.input_matrix(scene),
    }
    if scene.base_accelerations:
        outputs |= _told(case, pose, outputs["M"], outputs["B"])
    resisted = [d + force / values.friction_speed for d, force in zip(values.damping, values.friction, strict=True)]
    drag = mpf(0) if scene.is_driven else values.cart_damping + values.cart_friction / values.cart_friction_speed
    if any(resisted) or drag:
        outputs["D"] = _in_coordinates(scene, _joint_form(resisted))
        for axis in range(cart_axes(scene)):
            outputs["D"][axis][axis] = drag
    return outputs


def _told(case: Case, pose: Pose, inertia: Matrix, inputs: Matrix) -> Outputs:
    """M and B where the base is given its acceleration: rows x'' = u, and of every mass what b does to it, on the right side."""
    carts, size = cart_axes(case.scene), len(pose.direction[0])
    columns = []
    for i, told in enumerate(case.scene.told_axes):
        moved = [mpf(int(axis == told)) for axis in range(size)] * case.scene.links + [mpf(0)] * (size * len(case.values.inertia))
        pull = masses.conjugate(case.scene, case.values, pose, moved)
        columns.append([mpf(int(k == i)) if k < carts else -entry for k, entry in enumerate(pull)])
    rows = [
        [mpf(int(i == j)) if min(i, j) < carts else entry for j, entry in enumerate(row)] for i, row in enumerate(inertia)
    ]
    return {"M": rows, "B": [[*given, *forces] for given, forces in zip(transposed(columns), inputs, strict=True)]}


@judges("project")
def project_state(case: Case) -> Outputs:
    """Return the nearest unit vectors and tangent rates."""
    q_out, v_out = project(case.scene, case.inputs["q"], case.inputs["v"])
    return {"q_out": q_out, "v_out": v_out}


def _spring_energy(case: Case, pose: Pose) -> Any:
    """1/2 k theta^2 in the plane, k (1 - q_{k-1}.q_k) in space, computed as k |q_k - q_{k-1}|^2 / 2."""
    if case.scene.is_planar:
        bends = [angle - rest for (angle,), rest in zip(pose.bend, case.values.rest_angle, strict=True)]
        return fdot(case.values.stiffness, [angle**2 for angle in bends]) / 2
    inner = [[mpf(0), mpf(0), mpf(1)], *pose.direction]
    gaps = [[a - b for a, b in zip(*pair, strict=True)] for pair in zip(inner, pose.direction, strict=False)]
    return fdot(case.values.stiffness, [fdot(gap, gap) for gap in gaps]) / 2


def _joint_form(weights: Vector) -> Matrix:
    """Return the N x N matrix of sum_k w_k (xi_k - xi_{k-1})^2 with xi_0 = 0."""
    size = len(weights)
    matrix = [[mpf(0)] * size for _ in weights]
    for k, weight in enumerate(weights):
        matrix[k][k] += weight
        if k:
            matrix[k - 1][k - 1] += weight
            matrix[k - 1][k] = matrix[k][k - 1] = -weight
    return matrix


def _in_coordinates(scene: Scene, form: Matrix) -> Matrix:
    """Return a link-by-link form in the coordinates of (19): S^T F S or F times I_2, zeros for the cart."""
    carts, size = cart_axes(scene), masses.rate_count(scene)
    if scene.is_planar:
        rows = [pulled_back(scene, row) for row in form]
        form = transposed([pulled_back(scene, column) for column in transposed(rows)])
    per_link = 1 if scene.is_planar else 2
    matrix = [[mpf(0)] * size for _ in range(size)]
    for i, row in enumerate(form):
        for j, entry in enumerate(row):
            for axis in range(per_link):
                matrix[carts + per_link * i + axis][carts + per_link * j + axis] = entry
    return matrix
