"""Planar coordinates at the joints (theory section 2): relative angles, absolute rates, couples on the links, and the way back.

Sweeps work in joint terms whatever the scene's angles are: the angle of joint k is that of link k against link k-1 (of
link 0 against the hanging vertical), ``rate[k]`` is the absolute rate of link k, ``couple[k]`` the generalised force
conjugate to its absolute angle phi_k. With phi = S theta, tau_phi = S^-T tau_theta and theta'' = S^-1 phi''.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from phichain.ir.builder import ArrayRef, Builder, Expr, Index, Loop
from phichain.lowering.chain.losses import brakes_cart, joint_drag, slows_joints, ties_links
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.chain.room import saves_memory
from phichain.scene import Scene

#: From so many links on neighbours' differences are read from memory, forwards, which leaves them to a host's vectors.
_LONG = 16


@dataclass(frozen=True)
class PlanarState:
    """The input arrays of a planar function, seen at the joints.

    Attributes:
        angle: joint angles, N cells.
        rate: absolute rates of the links, in the Program's unit of time, N cells.
        joint_rate: rates of the joint angles, N cells.
        speed: x' of the cart, one cell; None where nothing resists it.
    """

    angle: ArrayRef
    rate: ArrayRef
    joint_rate: ArrayRef
    speed: ArrayRef | None = None


def difference(builder: Builder, scene: Scene, name: str, theta: ArrayRef) -> ArrayRef:
    """Joint values of the scene's own angles (or rates): the angle of each link against the one before it."""
    lag = {"relative": 0, "absolute": 1, "adjacent": 2}[str(scene.angles)]
    if lag == 0:
        return theta
    joint = builder.array(name, scene.links)
    for k in range(min(lag, scene.links)):
        joint[k] = theta[k]
    with builder.loop("k", min(lag, scene.links), scene.links) as loop:
        joint[loop.index] = theta[loop.index] - theta[loop.index - lag]
    return joint


def absolute(builder: Builder, scene: Scene, name: str, theta: ArrayRef) -> ArrayRef:
    """phi = S theta: absolute values of the scene's own angles, rates or accelerations."""
    if scene.angles == "absolute":
        return theta
    phi = builder.array(name, scene.links)
    with builder.loop("k", 0, scene.links) as loop:
        k = loop.index
        previous = loop.carry(f"{name}_before", 0)
        phi[k] = value = builder.let(f"link_{name}", previous + theta[k])
        loop.follow(previous, theta[k] if scene.angles == "adjacent" else value)
    return phi


def from_absolute(builder: Builder, scene: Scene, phi: ArrayRef, theta: ArrayRef) -> None:
    """theta = S^-1 phi, written into the cells of `theta`."""
    if _in_vectors(scene):
        theta[0] = phi[0]
        with builder.loop("k", 1, scene.links) as loop:
            theta[loop.index] = phi[loop.index] - phi[loop.index - 1]
        return
    with builder.loop("k", 0, scene.links) as loop:
        k = loop.index
        if scene.angles == "absolute":
            theta[k] = phi[k]
            return
        previous = loop.carry("before", 0)
        value = phi[k] - previous
        theta[k] = value
        loop.follow(previous, value if scene.angles == "adjacent" else phi[k])


def _in_vectors(scene: Scene) -> bool:
    """Whether differences of neighbours, no turn of which needs the one before, are worth their second reading."""
    return scene.angles == "relative" and scene.links >= _LONG and not saves_memory(scene)


def to_generalised(builder: Builder, scene: Scene, tau: ArrayRef, out: ArrayRef) -> None:
    """tau_theta = S^T tau_phi, written into the cells of `out`."""
    with builder.loop("k", scene.links - 1, -1, -1) as loop:
        k = loop.index
        if scene.angles == "absolute":
            out[k] = tau[k]
            return
        beyond = loop.carry("beyond", 0)
        value = tau[k] + beyond
        out[k] = value
        loop.follow(beyond, tau[k] if scene.angles == "adjacent" else value)


def congruence(builder: Builder, scene: Scene, inner: ArrayRef, out: ArrayRef, nv: int) -> None:
    """S^T M S: `inner` holds M (links x links), `out` starts at the block's first cell and has rows of nv cells."""
    links = scene.links
    if scene.angles == "absolute":
        with builder.loop("i", 0, links) as rows, builder.loop("j", 0, links) as columns:
            out[rows.index * nv + columns.index] = inner[rows.index * links + columns.index]
        return
    half = builder.array("half", links * links)
    with builder.loop("i", 0, links) as rows:
        to_generalised(builder, scene, inner.shifted(rows.index * links), half.shifted(rows.index * links))
    with builder.loop("j", 0, links) as columns:
        to_generalised(builder, scene, half.shifted(columns.index, links), out.shifted(columns.index, nv))


def planar_state(builder: Builder, scene: Scene, q: ArrayRef, v: ArrayRef, time: Fraction = Fraction(1)) -> PlanarState:
    """Joint angles and rates of the argument arrays q and v (the cart's coordinate, if any, comes first in both).

    Args:
        builder: where the Program is recorded.
        scene: the chain.
        q: its configuration.
        v: its rates.
        time: unit of time of the links' rates, in s; what torques are made of stays in rad/s and m/s.
    """
    offset = int(scene.has_cart)
    theta, theta_dot = q.shifted(offset), v.shifted(offset)
    slips = slows_joints(scene) or scene.armature is not None
    return PlanarState(
        angle=difference(builder, scene, "joint_angle", theta),
        rate=_measured(builder, scene, absolute(builder, scene, "rate", theta_dot), time),
        joint_rate=difference(builder, scene, "joint_rate", theta_dot) if slips else theta_dot,
        speed=v if brakes_cart(scene) else None,
    )


def _measured(builder: Builder, scene: Scene, rate: ArrayRef, time: Fraction) -> ArrayRef:
    """Rates in 1 / time."""
    if time == 1:
        return rate
    measured = builder.array("measured_rate", scene.links)
    with builder.loop("k", 0, scene.links) as loop:
        measured[loop.index] = time * rate[loop.index]
    return measured


def passive_torque(scene: Scene, parameters: Parameters, state: PlanarState, k: Index) -> Expr | None:
    """Torque -k_k (theta_k - alpha_k) - d_k theta_k' - F_k tanh(theta_k' / v_0) at joint k; None where nothing ties it."""
    torque = None
    if parameters.stiffness is not None:
        torque = -(parameters.stiffness[k] * bend(parameters, state, k))
    drag = joint_drag(scene, parameters, k, state.joint_rate[k])
    if drag is None:
        return torque
    return -drag if torque is None else torque - drag


def bend(parameters: Parameters, state: PlanarState, k: Index) -> Expr:
    """theta_k - alpha_k, what the spring at joint k sees."""
    angle = state.angle[k]
    return angle if parameters.rest_angle is None else angle - parameters.rest_angle[k]


def couples(
    builder: Builder, scene: Scene, parameters: Parameters, state: PlanarState, u: ArrayRef | None
) -> ArrayRef | None:
    """tau_phi of all inputs, springs, dampers and dry friction, N cells; None on an unforced chain without any."""
    return _couples(builder, scene, parameters, u, state if ties_links(scene) else None)


def input_couples(builder: Builder, scene: Scene, parameters: Parameters, u: ArrayRef | None) -> ArrayRef | None:
    """tau_phi of the inputs alone; None where no joint is actuated."""
    return _couples(builder, scene, parameters, u, None)


def _couples(
    builder: Builder, scene: Scene, parameters: Parameters, u: ArrayRef | None, passive: PlanarState | None
) -> ArrayRef | None:
    driven = drive(builder, scene, parameters, u)
    if driven is None and passive is None:
        return None
    couple, last = builder.array("couple", scene.links), scene.links - 1
    if driven is not None and passive is None and _in_vectors(scene):
        with builder.loop("k", 0, last) as loop:
            couple[loop.index] = driven[loop.index] - driven[loop.index + 1]
        couple[last] = driven[last]
        return couple
    with builder.loop("k", last, -1, -1) as loop:
        k = loop.index
        couple[k] = _couple(builder, loop, scene, driven, None if passive is None else passive_torque(scene, parameters, passive, k), k)
    return couple


def _couple(
    builder: Builder, loop: Loop, scene: Scene, drive: ArrayRef | None, passive: Expr | None, k: Index
) -> Expr:
    """tau_phi,k = (S^-T T)_k + J_k - J_{k+1}, J the passive joint torques; loops run from the tip inwards."""
    if drive is not None and scene.angles == "relative":
        torque = drive[k] if passive is None else drive[k] + passive
        beyond = loop.carry("torque_beyond", 0)
        loop.follow(beyond, torque)
        return builder.let("link_couple", torque - beyond)
    total = None
    if drive is not None and scene.angles == "absolute":
        total = drive[k]
    elif drive is not None:
        beyond = loop.carry("couple_beyond", 0)
        total = drive[k] - beyond
        loop.follow(beyond, total)
    if passive is None:
        assert total is not None
        return total
    outer = loop.carry("passive_beyond", 0)
    loop.follow(outer, passive)
    return passive - outer if total is None else total + (passive - outer)


def drive(builder: Builder, scene: Scene, parameters: Parameters, u: ArrayRef | None) -> ArrayRef | None:
    """The torque inputs conjugate to the scene's angles, one cell a joint; None when no joint is actuated."""
    joints = scene.actuated_joints
    if u is None or not joints:
        return None
    u = u.shifted(scene.base_inputs)
    unit = parameters.units.torque
    driven = builder.array("drive", scene.links)
    if len(joints) == scene.links:
        with builder.loop("k", 0, scene.links) as loop:
            driven[loop.index] = u[loop.index] / unit
        return u if unit == 1 else driven
    for k in range(scene.links):
        driven[k] = u[joints.index(k + 1)] / unit if k + 1 in joints else builder.lift(0)
    return driven
