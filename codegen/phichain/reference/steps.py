"""Reference of the structure-preserving steps: the discrete equations as momenta and positions state them.

The variational step is solved in momenta, without multipliers: p(q_0) + h/2 F = J_0^T m (r(q_1) - r(q_0)) / h for q_1, and
M(q_1) v_1 = J_1^T m (r(q_1) - r(q_0)) / h + h/2 F. It shares no formula with the sweeps of the lowered step.
"""

from __future__ import annotations

from typing import Any

from mpmath import fdot, mp, mpf

from phichain.errors import ConvergenceError
from phichain.reference import masses
from phichain.reference.algebra import Matrix, Vector, cross, moved
from phichain.reference.case import Case, Outputs, judges
from phichain.reference.derived import step
from phichain.reference.inertia import Inertia
from phichain.reference.motion import forward_dynamics
from phichain.reference.pose import Pose, cart_axes, planar_pose, project, scene_angles, spatial_pose

_MOST_NEWTON_STEPS = 60


@judges("step_lie4")
def step_lie4(case: Case) -> Outputs:
    """Runge-Kutta-Munthe-Kaas of order 4 with the inverse of dexp up to its second bracket; in the plane `step`."""
    if case.scene.is_planar:
        return step(case)
    h, carts = case.inputs["h"], cart_axes(case.scene)
    q, v = project(case.scene, case.inputs["q"], case.inputs["v"])
    links = [q[k : k + 3] for k in range(carts, len(q), 3)]
    still: Vector = [mpf(0)] * len(q)
    slopes: list[Vector] = []
    for ahead in (mpf(0), h / 2, h / 2, h):
        stage = moved([*still, *v], slopes[-1], ahead) if slopes else [*still, *v]
        slopes.append(_lie_slope(case, q[:carts], links, stage))
    total = [a + 2 * b + 2 * c + d for a, b, c, d in zip(*slopes, strict=True)]
    end = moved([*still, *v], total, h / 6)
    return dict(zip(("q_next", "v_next"), _turned(q[:carts], links, end), strict=True))


def _turned(x: Vector, links: Matrix, stage: Vector) -> tuple[Vector, Vector]:
    """Return (q, v) of [x - x_0, Theta_k; x', eta_k]: unit vectors and rates turned by exp(Theta_k)."""
    size = len(stage) // 2
    carts = len(x)
    q = [a + b for a, b in zip(x, stage, strict=False)]
    v = stage[size : size + carts]
    for k, link in enumerate(links):
        start = carts + 3 * k
        angle, rate = stage[start : start + 3], stage[size + start : size + start + 3]
        q, v = q + _rotated(angle, link), v + _rotated(angle, rate)
    return q, v


def _lie_slope(case: Case, x: Vector, links: Matrix, stage: Vector) -> Vector:
    size, carts = len(stage) // 2, len(x)
    q, v = _turned(x, links, stage)
    acceleration = forward_dynamics(case.at(q=q, v=v))["a"]
    slope, bend = v[:carts], acceleration[:carts]
    for start in range(carts, size, 3):
        angle, rate = stage[start : start + 3], stage[size + start : size + start + 3]
        once = cross(angle, rate)
        slope = slope + moved(moved(rate, once, mpf(1) / 2), cross(angle, once), mpf(1) / 12)
        bend = bend + _rotated([-entry for entry in angle], acceleration[start : start + 3])
    return slope + bend


def _rotated(angle: Vector, a: Vector) -> Vector:
    """Return exp(hat(angle)) a, by Rodrigues' formula."""
    size = mp.sqrt(fdot(angle, angle))
    if not size:
        return list(a)
    axis = [entry / size for entry in angle]
    once = cross(axis, a)
    return moved(moved(list(a), once, mp.sin(size)), cross(axis, once), 1 - mp.cos(size))


def _at(case: Case, q: Vector, v: Vector) -> Pose:
    return (planar_pose if case.scene.is_planar else spatial_pose)(case.scene, q, v)


def _force(case: Case, pose: Pose) -> Vector:
    """Gravity, springs, dampers and inputs, without the velocity terms of the equations of motion."""
    push = masses.push(case.scene, case.inputs["u"])
    fall = masses.conjugate(case.scene, case.values, pose, masses.anti_gravity(case.values, pose, case.base))
    joints = masses.joint_force(case.scene, case.values, pose)
    return [a - b + c for a, b, c in zip(push, fall, joints, strict=True)]


def _rates(case: Case, pose: Pose, v: Vector) -> Vector:
    """The pose's own rates: v in the plane, components along two axes a link in space."""
    if case.scene.is_planar:
        return v
    turns = zip(pose.axes, pose.spin, strict=True)
    return v[: cart_axes(case.scene)] + [fdot(axis, omega) for own, omega in turns for axis in own]


@judges("step_variational")
def step_variational(case: Case) -> Outputs:
    """Solve the discrete equations of Lee, Leok & McClamroch (2009) in momenta; the residual of an exact step is 0."""
    h, q, v = case.inputs["h"], case.inputs["q"], case.inputs["v"]
    if case.scene.base_accelerations:
        return _told(case, step_variational(case.links()))
    if not case.scene.is_planar:
        q, v = project(case.scene, q, v)
    start = _at(case, q, v)
    momentum = Inertia(case.scene, case.values, start).times(_rates(case, start, v))
    kicked = moved(momentum, _force(case, start), h / 2)
    q_next = _drifted(case, start, q, v, kicked)
    end = _at(case, q_next, _ahead(case, start, q, v, q_next))
    gained = moved(_transport(case, start, end, q_next, q, end), _force(case, end), h / 2)
    (rates,) = Inertia(case.scene, case.values, end).solve(gained)
    return {"q_next": q_next, "v_next": _contract_rates(case, end, rates), "residual": mpf(0)}


def _told(case: Case, links: Outputs) -> Outputs:
    """The step of a chain whose base is given its acceleration, held: a driven cart moves as such a motion does."""
    h, carts, u = case.inputs["h"], cart_axes(case.scene), case.inputs["u"]
    x, rate = case.inputs["q"][:carts], case.inputs["v"][:carts]
    place = [a + h * b + h * h * c / 2 for a, b, c in zip(x, rate, u, strict=False)]
    rates = [b + h * c for b, c in zip(rate, u, strict=False)]
    return {**links, "q_next": place + links["q_next"], "v_next": rates + links["v_next"]}


def _transport(case: Case, start: Pose, end: Pose, q_next: Vector, q: Vector, pose: Pose) -> Vector:
    """Return the momentum of the discrete velocity, conjugate to the rates of `pose`; rotors turn by the angles themselves."""
    h, carts = case.inputs["h"], cart_axes(case.scene)
    change = [
        [a - b for a, b in zip(there, here, strict=True)]
        for there, here in zip(end.direction, start.direction, strict=True)
    ]
    slide = [a - b for a, b in zip(q_next[:carts], q[:carts], strict=True)]
    gained = masses.stacked(case.values, change, slide)
    momentum = masses.conjugate(case.scene, case.values, pose, [entry / h for entry in gained])
    for axis in range(carts):
        momentum[axis] += case.values.cart_mass * slide[axis] / h
    if not case.scene.is_planar:
        return momentum
    turned = [(there - here) / h for there, here in zip(q_next, q, strict=True)]
    rotors = masses.rotor_momentum(case.scene, case.values, turned)
    return [a + b for a, b in zip(momentum, rotors, strict=True)]


def _drifted(case: Case, start: Pose, q: Vector, v: Vector, kicked: Vector) -> Vector:
    """Return q_1 with J_0^T m (r(q_1) - r(q_0)) / h = kicked, by Newton's method from q_0."""
    h, q_next = case.inputs["h"], q
    still: Vector = [mpf(0)] * len(v)
    for _ in range(_MOST_NEWTON_STEPS):
        end = _at(case, q_next, still)
        gap = [a - b for a, b in zip(kicked, _transport(case, start, end, q_next, q, start), strict=True)]
        change = [h * entry for entry in Inertia(case.scene, case.values, start, ahead=end).solve(gap)[0]]
        q_next = _moved_place(case, end, q_next, change)
        if max(map(abs, change)) < mpf(10) ** (10 - mp.dps):
            return q_next
    raise ConvergenceError(
        "h",
        h,
        "is too long for the variational step: its equations have no solution near the start",
        "shorten it",
    )


def _moved_place(case: Case, at: Pose, q: Vector, change: Vector) -> Vector:
    """Return the configuration after a small change of the rates' coordinates."""
    if case.scene.is_planar:
        return moved(q, change, mpf(1))
    carts = cart_axes(case.scene)
    parts: Any = [a + b for a, b in zip(q[:carts], change, strict=False)]
    for k, (link, turning) in enumerate(zip(at.direction, at.turning, strict=True)):
        first, second = change[carts + 2 * k : carts + 2 * k + 2]
        parts = parts + moved(moved(link, turning[0], first), turning[1], second)
    return project(case.scene, parts, [mpf(0)] * len(parts))[0]


def _ahead(case: Case, start: Pose, q: Vector, v: Vector, q_next: Vector) -> Vector:
    """Return the rates at the end that dampers see: those of 2 (z_1 - z_0) / h - z_0'."""
    h, carts = case.inputs["h"], cart_axes(case.scene)
    end = _at(case, q_next, [mpf(0)] * len(v))
    spin: Vector = []
    for here, there, rate, turning in zip(
        start.direction, end.direction, start.rate, _turnings(case, end), strict=True
    ):
        ahead = [2 * (b - a) / h - c for a, b, c in zip(here, there, rate, strict=True)]
        spin = spin + ([fdot(turning, ahead)] if case.scene.is_planar else cross(there, ahead))
    cart = [2 * (b - a) / h - c for a, b, c in zip(q[:carts], q_next[:carts], v[:carts], strict=True)]
    return cart + (scene_angles(case.scene, spin) if case.scene.is_planar else spin)


def _turnings(case: Case, at: Pose) -> Matrix:
    return [turn[0] for turn in at.turning]


def _contract_rates(case: Case, at: Pose, rates: Vector) -> Vector:
    """Return v of the rates of the pose."""
    if case.scene.is_planar:
        return rates
    carts = cart_axes(case.scene)
    return rates[:carts] + [entry for omega in masses.spun(at, rates[carts:]) for entry in omega]
