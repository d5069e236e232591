"""Reference of the functions made of many evaluations: Jacobians, the projection integral, a step."""

from __future__ import annotations

from typing import Any

from mpmath import mp, mpf

from phichain.reference import masses
from phichain.reference.algebra import Matrix, Vector, cross, moved, tangent_axes, transposed, unit
from phichain.reference.case import Case, Outputs, judges
from phichain.reference.inertia import Inertia
from phichain.reference.motion import forward_dynamics, inverse_dynamics
from phichain.reference.pose import cart_axes, project
from phichain.scene import Scene

_FIRST_QUARTER = 8


@judges("state_jacobian")
def state_jacobian(case: Case) -> Outputs:
    """Differentiate u(q, v, a) at fixed a and solve with the inertia; in space, see `_tangent_jacobian`."""
    if not case.scene.is_planar:
        return _tangent_jacobian(case)
    if case.scene.base_accelerations:
        return _told_jacobian(case)
    nv = case.scene.nv
    fixed = case.at(a=forward_dynamics(case)["a"])
    slopes = [_slope(fixed, name, unit(nv, i)) for name in ("q", "v") for i in range(nv)]
    inertia = Inertia(case.scene, case.values, case.pose())
    inputs = _columns(masses.input_matrix(case.scene))
    answer = inertia.solve(*([-entry for entry in slope] for slope in slopes), *inputs)
    return {
        "dadq": transposed(answer[:nv]),
        "dadv": transposed(answer[nv : 2 * nv]),
        "dadu": _rows(answer[2 * nv :], nv),
    }


def _told_jacobian(case: Case) -> Outputs:
    """Differentiate the accelerations themselves, where the base has no equation to be solved with."""
    width, precision = _difference()
    outputs: Outputs = {}
    for name in ("q", "v", "u"):
        columns, point = [], case.inputs[name]
        for i in range(len(point)):
            with mp.workprec(precision):
                ahead, behind = (
                    forward_dynamics(case.at(**{name: moved(point, unit(len(point), i), h)}))["a"] for h in (width, -width)
                )
                columns.append([(a - b) / (2 * width) for a, b in zip(ahead, behind, strict=True)])
        outputs[f"dad{name}"] = transposed(columns)
    return outputs


@judges("dynamics_and_jacobian")
def dynamics_and_jacobian(case: Case) -> Outputs:
    """Both of them, each by its own reference."""
    return {"a": forward_dynamics(case)["a"], **state_jacobian(case)}


@judges("inverse_and_jacobian")
def inverse_and_jacobian(case: Case) -> Outputs:
    """Differentiate u(q, v, a) along every entry of q, v and a."""
    by = {name: transposed([_slope(case, name, unit(case.scene.nv, i)) for i in range(case.scene.nv)]) for name in ("q", "v", "a")}
    return {"u": inverse_dynamics(case)["u"], **{f"dud{name}": columns for name, columns in by.items()}}


def tangents(scene: Scene, q: Vector, v: Vector) -> list[tuple[Vector, Vector]]:
    """Return directions that span the tangent space of spatial states: x, rotations of links, x', rates."""
    carts, size = cart_axes(scene), len(q)
    q, v = project(scene, q, v)
    still: Vector = [mpf(0)] * size
    shifts = [unit(size, axis) for axis in range(carts)]
    turns, rates = [], []
    for k in range(carts, size, 3):
        link, omega = q[k : k + 3], v[k : k + 3]
        for axis in tangent_axes(link):
            turns.append((_placed(cross(axis, link), k, size), _placed(cross(axis, omega), k, size)))
            rates.append((still, _placed(axis, k, size)))
    return [(shift, still) for shift in shifts] + turns + [(still, shift) for shift in shifts] + rates


@judges("phi")
def phi(case: Case) -> Outputs:
    """Phi = (1/pi) int_0^2pi f cos tau dtau, f the force that (x, theta) = A cos tau asks for, tau = omega t.

    Trapezoids, doubled until they settle: for a periodic analytic function they converge faster than any
    power. The four quarters of the period contribute alike, since the undamped force is odd in q and even in
    time.
    """
    return {"phi": _settled(case)[1]}


@judges("phi_jacobian")
def phi_jacobian(case: Case) -> Outputs:
    """Differentiate the quadrature in the amplitudes and in omega, n x (n + 1).

    The number of nodes is that which settles Phi: what the sum leaves out is analytic in the amplitudes, too,
    so its derivative is as small.
    """
    point = [*case.inputs["amplitude"], case.inputs["omega"]]
    quarter, _ = _settled(case)
    width, precision = _difference()
    columns = []
    for i in range(len(point)):
        with mp.workprec(precision):
            ahead, behind = (
                _harmonic(case.at(amplitude=at[:-1], omega=at[-1]), quarter)
                for at in (moved(point, unit(len(point), i), h) for h in (width, -width))
            )
            columns.append([(a - b) / (2 * width) for a, b in zip(ahead, behind, strict=True)])
    return {"dphi": transposed(columns)}


@judges("step")
def step(case: Case) -> Outputs:
    """One classical Runge-Kutta step of order 4 in (q, v), u held; spatial ends are projected."""
    h, q, v = case.inputs["h"], case.inputs["q"], case.inputs["v"]
    q_rates, v_rates = [], []
    q_stage, v_stage = q, v
    for ahead in (h / 2, h / 2, h, h):
        q_rates.append(_configuration_rate(case, q_stage, v_stage))
        v_rates.append(forward_dynamics(case.at(q=q_stage, v=v_stage))["a"])
        q_stage, v_stage = moved(q, q_rates[-1], ahead), moved(v, v_rates[-1], ahead)
    q_next, v_next = (
        [start + h * (a + 2 * b + 2 * c + d) / 6 for start, a, b, c, d in zip(state, *rates, strict=True)]
        for state, rates in ((q, q_rates), (v, v_rates))
    )
    if not case.scene.is_planar:
        q_next, v_next = project(case.scene, q_next, v_next)
    return {"q_next": q_next, "v_next": v_next}


@judges("step_jacobian")
def step_jacobian(case: Case) -> Outputs:
    """The step, and central differences of it in each entry of q, v and u; in space of that from the nearest consistent states."""
    width, precision = _difference()
    columns: dict[str, list[Vector]] = {}
    for name in ("q", "v", "u"):
        point, columns[name] = case.inputs.get(name, []), []
        for i in range(len(point)):
            with mp.workprec(precision):
                ahead, behind = (step(_consistent(case.at(**{name: moved(point, unit(len(point), i), h)}))) for h in (width, -width))
                pairs = [*zip(ahead["q_next"], behind["q_next"], strict=True), *zip(ahead["v_next"], behind["v_next"], strict=True)]
                columns[name].append([(a - b) / (2 * width) for a, b in pairs])
    by_state = transposed(columns["q"] + columns["v"])
    return {**step(case), "A": by_state, "B": _rows(columns["u"], len(by_state))}


def _consistent(case: Case) -> Case:
    """The nearest state of unit vectors and tangent rates; a planar one as it is."""
    if case.scene.is_planar:
        return case
    q, v = project(case.scene, case.inputs["q"], case.inputs["v"])
    return case.at(q=q, v=v)


def _tangent_jacobian(case: Case) -> Outputs:
    """Differentiate forward dynamics along the manifold, one row per direction of `tangents`."""
    q, v, u = case.inputs["q"], case.inputs["v"], case.inputs["u"]
    width, precision = _difference()
    rows = []
    for dq, dv in tangents(case.scene, q, v):
        with mp.workprec(precision):
            ahead, behind = (
                forward_dynamics(case.at(q=moved(q, dq, h), v=moved(v, dv, h)))["a"] for h in (width, -width)
            )
            rows.append([(a - b) / (2 * width) for a, b in zip(ahead, behind, strict=True)])
    rest = forward_dynamics(case)["a"]
    pushed = [forward_dynamics(case.at(u=moved(u, unit(len(u), i), mpf(1))))["a"] for i in range(len(u))]
    return {
        "tangent": rows,
        "dadu": _rows([[a - b for a, b in zip(one, rest, strict=True)] for one in pushed], len(rest)),
    }


def _difference() -> tuple[Any, int]:
    """Return the width h of a central difference, h^2 below round-off, and the bits it needs."""
    width = mp.prec // 2 + 10
    return mpf(2) ** -width, mp.prec + width + 10


def _slope(case: Case, name: str, direction: Vector) -> Vector:
    """Return the derivative of u(q, v, a) in one input along one direction."""
    width, precision = _difference()
    with mp.workprec(precision):
        ahead, behind = (
            inverse_dynamics(case.at(**{name: moved(case.inputs[name], direction, h)}))["u"]
            for h in (width, -width)
        )
        return [(a - b) / (2 * width) for a, b in zip(ahead, behind, strict=True)]


def _settled(case: Case) -> tuple[int, Vector]:
    """Return the nodes per quarter at which the trapezoidal sum has settled, and the sum."""
    quarter, last = _FIRST_QUARTER, _harmonic(case, _FIRST_QUARTER)
    while True:
        quarter *= 2
        # Every other node is one of the last sum's.
        now = [(a + b) / 2 for a, b in zip(last, _harmonic(case, quarter, first=1, stride=2), strict=True)]
        change = max(abs(a - b) for a, b in zip(now, last, strict=True))
        if change <= mpf(10) ** (20 - mp.dps) * (1 + max(map(abs, now))):
            return quarter, now
        last = now


def _harmonic(case: Case, quarter: int, first: int = 0, stride: int = 1) -> Vector:
    """Return the trapezoidal sum of Phi with 4 * quarter nodes per period, from one quarter of them.

    With first = 1 and stride = 2 it is the sum over the odd nodes, at twice their weight.
    """
    amplitude, omega = case.inputs["amplitude"], case.inputs["omega"]
    total: Vector = [mpf(0)] * len(amplitude)
    for node in range(first, quarter, stride):
        cosine, sine = mp.cos_sin(mp.pi * node / (2 * quarter))
        force = inverse_dynamics(
            case.at(
                q=[entry * cosine for entry in amplitude],
                v=[-omega * entry * sine for entry in amplitude],
                a=[-(omega**2) * entry * cosine for entry in amplitude],
            )
        )["u"]
        # tau = 0 and pi belong to two quarters each; at tau = pi/2 the weight cos tau vanishes.
        total = moved(total, force, cosine * stride * (1 if node == 0 else 2) / quarter)
    return total


def _configuration_rate(case: Case, q: Vector, v: Vector) -> Vector:
    """Return q': v in the plane, [x', omega_k x q_k] in space."""
    if case.scene.is_planar:
        return v
    carts = cart_axes(case.scene)
    return v[:carts] + [entry for k in range(carts, len(q), 3) for entry in cross(v[k : k + 3], q[k : k + 3])]


def _placed(block: Vector, start: int, size: int) -> Vector:
    """Return a vector of zeros with `block` at `start`."""
    return [mpf(0)] * start + block + [mpf(0)] * (size - start - len(block))


def _columns(matrix: Matrix) -> Matrix:
    return transposed(matrix) if matrix[0] else []


def _rows(columns: Matrix, count: int) -> Matrix:
    """Return the transpose, `count` empty rows when there are no columns."""
    return transposed(columns) if columns else [[] for _ in range(count)]
