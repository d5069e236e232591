"""The equations of motion: accelerations and forces against the Lagrangian's residual, and their derivatives."""

from __future__ import annotations

from dataclasses import replace

from phichain.proof.case import Case, Wrong, nothing, proves
from phichain.proof.lagrange import Motion, triples
from phichain.proof.modular.compiled import FAULTS
from phichain.proof.modular.field import PRIME, Vector, dot, plus


@proves("forward_dynamics")
def forward_dynamics(case: Case) -> None:
    """The Lagrangian's virtual work is that of the inputs along every direction but a driven cart's; omega_k' is orthogonal to q_k."""
    _accelerations(case, case.run()["a"])


@proves("dynamics_of_many", "planar", is_helper=True)
def dynamics_of_many(case: Case) -> None:
    """The same."""
    forward_dynamics(case)


@proves("bent_dynamics", is_helper=True)
def bent_dynamics(case: Case) -> None:
    """The same where springs are bent as the unit vectors say, q_{k-1} - q_k with q_{-1} = e_3."""
    q = case.point.q[case.point.carts :]
    bend = plus([0, 0, 1, *q[:-3]], q, -1)
    _accelerations(case, case.run(case.point.given(bend=bend))["a"])


def _accelerations(case: Case, a: Vector) -> None:
    point, judge = case.point, case.judge
    if not case.scene.is_planar:
        _orthogonal(case, "a", a, [0] * case.scene.links)
    motion = judge.motion(point, a=a)
    case.zero("a", lambda turn: judge.balance(point, motion, turn), point.tangent("turn"))


@proves("direction_dynamics")
def direction_dynamics(case: Case) -> None:
    """The same for q_k'' itself, with q_k.q_k'' = -|q_k'|^2."""
    point, judge, carts = case.point, case.judge, case.point.carts
    rate = judge.turned(point, point.v)
    second = case.run(point.given(q_dot=rate))["q_ddot"]
    speeds = [rate[i : i + 3] for i in range(carts, len(rate), 3)]
    _orthogonal(case, "q_ddot", second, [-dot(speed, speed) for speed in speeds])
    motion = Motion(point.q, rate, second, [*rate[:carts], *triples(rate, point.q, carts)])
    case.zero("q_ddot", lambda turn: judge.balance(point, motion, turn), point.tangent("turn"))


@proves("inverse_dynamics")
def inverse_dynamics(case: Case) -> None:
    """u is the Lagrangian's virtual work at any accelerations, those of a moving base among them."""
    point, judge = case.point, case.judge
    a, b = point.free("a"), point.free("b", case.scene.base_inputs * case.scene.is_moving)
    u = case.run(point.given(a=a, **({"b": b} if b else {})))["u"]
    motion = replace(judge.motion(point, a=a), base=b)
    case.zero("u", lambda turn: judge.work(point, motion, turn).whole - dot(u, turn), point.free("turn"))


@proves("inverse_and_jacobian")
def inverse_and_jacobian(case: Case) -> None:
    """Its force is the Lagrangian's, and dudq dq + dudv dv + duda da the derivative of the inverse dynamics, itself proven, along a random direction."""
    inverse_dynamics(case)
    point, scene = case.point, case.scene
    a, b = point.free("a"), point.free("b", scene.base_inputs * scene.is_moving)
    given = point.given(a=a, **({"b": b} if b else {}))
    inverse = case.of("inverse_dynamics")
    inverse_dynamics(inverse)
    moved = {"q": point.free("dq", scene.nq), "v": point.free("dv"), "a": point.free("da")}
    try:
        true = inverse.subject.slopes(replace(given, along=moved), point)["u"][1]
    except FAULTS as fault:
        raise Wrong(f"no derivative, for {nothing(fault)}") from fault
    found = [0] * scene.nv
    for rows in case.times(given, {f"dud{name}": direction for name, direction in moved.items()}).values():
        found = plus(found, rows)
    case.same("a row of the derivatives of u, u", found, true)


@proves("state_jacobian")
def state_jacobian(case: Case) -> None:
    """dadq dq + dadv dv + dadu du is the derivative of the forward dynamics, itself proven, along a random direction."""
    point, scene = case.point, case.scene
    forward = case.forward
    moved = {"q": point.free("dq", scene.nq), "v": point.free("dv"), "u": point.free("du", scene.nu)}
    try:
        true = forward.slopes(replace(point.given(), along=moved), point)["a"][1]
    except FAULTS as fault:
        raise Wrong(f"no derivative, for {nothing(fault)}") from fault
    blocks = {f"dad{name}": direction for name, direction in moved.items() if direction}
    found = [0] * scene.nv
    for rows in case.times(point.given(), blocks).values():
        found = plus(found, rows)
    case.same("a row of the derivatives of a, a", found, true)


@proves("dynamics_and_jacobian")
def dynamics_and_jacobian(case: Case) -> None:
    """Its accelerations are those of the Lagrangian, and its derivatives theirs."""
    forward_dynamics(case)
    state_jacobian(case)


def _orthogonal(case: Case, name: str, found: Vector, true: list[int]) -> None:
    """Hold q_k against the k-th triple of an output."""
    carts = case.point.carts
    for k, (link, value) in enumerate(zip(case.point.links, true, strict=True)):
        first = carts + 3 * k
        if (dot(link, found[first : first + 3]) - value) % PRIME:
            raise Wrong(f"{name}[{first}] to [{first + 2}]")



def field_of_flows(case: Case) -> None:
    """The vector field (a, q') that flows differentiate: accelerations, and in space q_k' = omega_k x q_k."""
    forward_dynamics(case)
    if not case.scene.is_planar:
        case.same("q_dot", case.run()["q_dot"], case.judge.turned(case.point, case.point.v))
