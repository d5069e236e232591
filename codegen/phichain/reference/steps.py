"""Reference of the structure-preserving steps: the discrete equations as momenta and positions state them.

The variational step is solved in momenta, dense and without multipliers: p(q_0) + h/2 F = J_0^T m (r(q_1) - r(q_0)) / h for q_1, and
M(q_1) v_1 = J_1^T m (r(q_1) - r(q_0)) / h + h/2 F. It shares no formula with the sweeps of the lowered step.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from mpmath import fdot, mp, mpf

from phichain.errors import ConvergenceError
from phichain.reference import dense
from phichain.reference.algebra import Matrix, Vector, cross, moved, product, solve, transposed
from phichain.reference.case import Case, Outputs, judges
from phichain.reference.derived import step
from phichain.reference.motion import forward_dynamics
from phichain.reference.pose import Pose, cart_axes, planar_pose, project, spatial_pose

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


@dataclass(frozen=True)
class _At:
    """Everything of one configuration: columns of dr/d(rates), inertia, and the generalised force there."""

    pose: Pose
    columns: Matrix
    matrix: Matrix

    @classmethod
    def of(cls, case: Case, q: Vector, v: Vector) -> _At:
        pose = (planar_pose if case.scene.is_planar else spatial_pose)(case.scene, q, v)
        columns = dense.jacobian(case.scene, case.values, pose)
        return cls(pose, columns, dense.mass_matrix(case.scene, case.values, columns))

    def force(self, case: Case) -> Vector:
        """Gravity, springs, dampers and inputs, without the velocity terms of the equations of motion."""
        push = [fdot(row, case.inputs["u"]) for row in dense.input_matrix(case.scene, len(self.columns))]
        fall = dense.conjugate(case.values, self.columns, dense.anti_gravity(case.values, self.pose))
        joints = dense.joint_force(case.scene, case.values, self.pose)
        return [a - b + c for a, b, c in zip(push, fall, joints, strict=True)]

    def rates(self, case: Case, v: Vector) -> Vector:
        """The link's own rates of `columns`: v in the plane, components along two axes a link in space."""
        if case.scene.is_planar:
            return v
        carts = cart_axes(case.scene)
        turns = zip(self.pose.axes, self.pose.spin, strict=True)
        return v[:carts] + [fdot(axis, omega) for own, omega in turns for axis in own]


@judges("step_variational")
def step_variational(case: Case) -> Outputs:
    """Solve the discrete equations of Lee, Leok & McClamroch (2009) in momenta; the residual of an exact step is 0."""
    h, q, v = case.inputs["h"], case.inputs["q"], case.inputs["v"]
    if not case.scene.is_planar:
        q, v = project(case.scene, q, v)
    start = _At.of(case, q, v)
    momentum = [fdot(row, start.rates(case, v)) for row in start.matrix]
    kicked = moved(momentum, start.force(case), h / 2)
    q_next = _drifted(case, start, q, v, kicked)
    end = _At.of(case, q_next, _ahead(case, start, q, v, q_next))
    gained = moved(_transport(case, start, end, q_next, q, end.columns), end.force(case), h / 2)
    rates = solve(end.matrix, [gained])[0]
    return {"q_next": q_next, "v_next": _contract_rates(case, end, rates), "residual": mpf(0)}


def _transport(case: Case, start: _At, end: _At, q_next: Vector, q: Vector, columns: Matrix) -> Vector:
    """Return the momentum of the discrete velocity, conjugate to the rates of `columns`."""
    h, carts = case.inputs["h"], cart_axes(case.scene)
    size = len(start.pose.direction[0])
    change = [
        [a - b for a, b in zip(there, here, strict=True)]
        for there, here in zip(end.pose.direction, start.pose.direction, strict=True)
    ]
    slide = [a - b for a, b in zip(q_next[:carts], q[:carts], strict=True)]
    masses = dense.stacked(case.values, change)
    masses = [entry + (slide[i % size] if i % size < carts else 0) for i, entry in enumerate(masses)]
    momentum = dense.conjugate(case.values, columns, [entry / h for entry in masses])
    for axis in range(carts):
        momentum[axis] += case.values.cart_mass * slide[axis] / h
    return momentum


def _drifted(case: Case, start: _At, q: Vector, v: Vector, kicked: Vector) -> Vector:
    """Return q_1 with J_0^T m (r(q_1) - r(q_0)) / h = kicked, by Newton's method from q_0."""
    h, q_next = case.inputs["h"], q
    still: Vector = [mpf(0)] * len(v)
    for _ in range(_MOST_NEWTON_STEPS):
        end = _At.of(case, q_next, still)
        gap = [
            a - b for a, b in zip(kicked, _transport(case, start, end, q_next, q, start.columns), strict=True)
        ]
        heavy = [dense.weighted(case.values, column) for column in start.columns]
        slope = product(heavy, transposed(end.columns))
        for axis in range(cart_axes(case.scene)):
            slope[axis][axis] += case.values.cart_mass
        change = [h * entry for entry in solve(slope, [gap])[0]]
        q_next = _moved_place(case, end, q_next, change)
        if max(map(abs, change)) < mpf(10) ** (10 - mp.dps):
            return q_next
    raise ConvergenceError(
        "h",
        h,
        "is too long for the variational step: its equations have no solution near the start",
        "shorten it",
    )


def _moved_place(case: Case, at: _At, q: Vector, change: Vector) -> Vector:
    """Return the configuration after a small change of the rates' coordinates."""
    if case.scene.is_planar:
        return moved(q, change, mpf(1))
    carts = cart_axes(case.scene)
    parts: Any = [a + b for a, b in zip(q[:carts], change, strict=False)]
    for k, (link, turning) in enumerate(zip(at.pose.direction, at.pose.turning, strict=True)):
        first, second = change[carts + 2 * k : carts + 2 * k + 2]
        parts = parts + moved(moved(link, turning[0], first), turning[1], second)
    return project(case.scene, parts, [mpf(0)] * len(parts))[0]


def _ahead(case: Case, start: _At, q: Vector, v: Vector, q_next: Vector) -> Vector:
    """Return the rates at the end that dampers see: those of 2 (z_1 - z_0) / h - z_0'."""
    h, carts = case.inputs["h"], cart_axes(case.scene)
    end = _At.of(case, q_next, [mpf(0)] * len(v))
    spin: Vector = []
    for here, there, rate, turning in zip(
        start.pose.direction, end.pose.direction, start.pose.rate, _turnings(case, end), strict=True
    ):
        ahead = [2 * (b - a) / h - c for a, b, c in zip(here, there, rate, strict=True)]
        spin = spin + ([fdot(turning, ahead)] if case.scene.is_planar else cross(there, ahead))
    cart = [2 * (b - a) / h - c for a, b, c in zip(q[:carts], q_next[:carts], v[:carts], strict=True)]
    return cart + (_own_angles(case, spin) if case.scene.is_planar else spin)


def _turnings(case: Case, at: _At) -> Matrix:
    return [turn[0] for turn in at.pose.turning]


def _own_angles(case: Case, phi: Vector) -> Vector:
    """Return theta with S theta = phi."""
    theta: Vector = []
    for k, value in enumerate(phi):
        before = {"absolute": mpf(0), "adjacent": theta[k - 1] if k else mpf(0)}.get(
            str(case.scene.angles), phi[k - 1] if k else mpf(0)
        )
        theta.append(value - before)
    return theta


def _contract_rates(case: Case, at: _At, rates: Vector) -> Vector:
    """Return v of the rates of `columns`."""
    if case.scene.is_planar:
        return rates
    carts = cart_axes(case.scene)
    v = rates[:carts]
    for axes, first, second in zip(at.pose.axes, rates[carts::2], rates[carts + 1 :: 2], strict=True):
        v = v + [first * a + second * b for a, b in zip(*axes, strict=True)]
    return v
