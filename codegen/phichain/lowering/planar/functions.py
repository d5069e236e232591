"""Planar functions other than forward dynamics: the terms of (15), energy, positions, inverse dynamics, linearisation.

In absolute angles phi: M_ij = c_ij cos(phi_i - phi_j), Coriolis_i = sum_j c_ij sin(phi_i - phi_j) phi_j'^2,
gravity_i = g mu_i sin phi_i, on a cart M_0i = mu_i cos phi_i and Coriolis_0 = -sum mu_j sin(phi_j) phi_j'^2. With
c_ij = l_min mu_max the sums over j run as prefix and suffix sums, so that vectors cost O(N). Everything then goes through
the linear map phi = S theta of theory section 2.
"""

from __future__ import annotations

from phichain.ir.builder import ArrayRef, Builder, Expr
from phichain.lowering.chain.base import base_acceleration, planar_base_columns
from phichain.lowering.chain.losses import cart_drag, cart_slope, is_braked, slopes_at_rest
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.planar.geared import terms as rotors
from phichain.lowering.planar.joints import (
    absolute,
    bend,
    congruence,
    passive_torque,
    planar_state,
    to_generalised,
)
from phichain.lowering.writers import writes
from phichain.scene import Scene


def absolute_sincos(builder: Builder, scene: Scene, q: ArrayRef) -> tuple[ArrayRef, ArrayRef]:
    """Sines and cosines of the absolute angles."""
    phi = absolute(builder, scene, "phi", q.shifted(int(scene.has_cart)))
    return builder.sincos(phi, scene.links)


@writes("mass_matrix", space="planar")
def mass_matrix(builder: Builder, scene: Scene, parameters: Parameters, q: ArrayRef, out: ArrayRef) -> None:
    """I(q) of (15), nv x nv."""
    sine, cosine = absolute_sincos(builder, scene, q)
    links, mu, length = scene.links, parameters.mu, parameters.length
    inner = builder.array("absolute_mass", links * links)
    with builder.loop("i", 0, links) as rows:
        i = rows.index
        inner[i * (links + 1)] = parameters.c_diagonal[i]
        with builder.loop("j", i + 1, links) as columns:
            j = columns.index
            entry = builder.let("entry", length[i] * mu[j] * (cosine[i] * cosine[j] + sine[i] * sine[j]))
            inner[i * links + j] = entry
            inner[j * links + i] = entry
    rotors.inertia(builder, scene, parameters, inner, out)
    if scene.has_cart:
        coupling = builder.array("cart_coupling", links)
        with builder.loop("k", 0, links) as loop:
            coupling[loop.index] = mu[loop.index] * cosine[loop.index]
        cart_border(builder, scene, parameters, coupling, out)


def cart_border(builder: Builder, scene: Scene, parameters: Parameters, coupling: ArrayRef, out: ArrayRef) -> None:
    """First row and column of a mass matrix on a cart: the total mass and S^T times the coupling."""
    row = builder.array("cart_row", scene.links)
    to_generalised(builder, scene, coupling, row)
    out[0] = parameters.total_mass
    with builder.loop("k", 0, scene.links) as loop:
        out[loop.index + 1] = row[loop.index]
        out[(loop.index + 1) * scene.nv] = row[loop.index]


@writes("coriolis", space="planar")
def coriolis(
    builder: Builder, scene: Scene, parameters: Parameters, q: ArrayRef, v: ArrayRef, out: ArrayRef
) -> None:
    """N(q, v) of (15), nv."""
    sine, cosine = absolute_sincos(builder, scene, q)
    rate = planar_state(builder, scene, q, v).rate
    links, mu, length = scene.links, parameters.mu, parameters.length
    # sum over j < i of l_j (cos, sin)(phi_j) w_j^2, and over j > i of mu_j likewise
    inner_part = builder.array("inner_part", links)
    with builder.loop("i", 0, links) as loop:
        i = loop.index
        along, across = loop.carry("inner_cosine", 0), loop.carry("inner_sine", 0)
        inner_part[i] = mu[i] * (sine[i] * along - cosine[i] * across)
        pull = builder.let("pull", length[i] * (rate[i] * rate[i]))
        loop.follow(along, along + pull * cosine[i])
        loop.follow(across, across + pull * sine[i])
    torque = builder.array("absolute_coriolis", links)
    with builder.loop("i", links - 1, -1, -1) as loop:
        i = loop.index
        along, across = loop.carry("outer_cosine", 0), loop.carry("outer_sine", 0)
        torque[i] = inner_part[i] + length[i] * (sine[i] * along - cosine[i] * across)
        pull = builder.let("pull", mu[i] * (rate[i] * rate[i]))
        loop.follow(along, along + pull * cosine[i])
        loop.follow(across, across + pull * sine[i])
    to_generalised(builder, scene, torque, out.shifted(int(scene.has_cart)))
    if scene.has_cart:
        out[0] = -across


@writes("gravity_torque", space="planar")
def gravity_torque(builder: Builder, scene: Scene, parameters: Parameters, q: ArrayRef, out: ArrayRef) -> None:
    """G(q) of (15), nv; gravity alone, without springs."""
    offset = int(scene.has_cart)
    phi = absolute(builder, scene, "phi", q.shifted(offset))
    sine, _ = builder.sincos(phi, scene.links)
    torque = builder.array("absolute_gravity", scene.links)
    with builder.loop("k", 0, scene.links) as loop:
        torque[loop.index] = parameters.gravity * parameters.mu[loop.index] * sine[loop.index]
    to_generalised(builder, scene, torque, out.shifted(offset))
    if scene.has_cart:
        out[0] = builder.lift(0)


@writes("energy", space="planar")
def energy(
    builder: Builder, scene: Scene, parameters: Parameters, q: ArrayRef, v: ArrayRef, kinetic: ArrayRef, potential: ArrayRef
) -> None:
    """T and V of theory section 1 from the masses' velocities and heights (no cancellation), the links' spins and the springs."""
    sine, cosine = absolute_sincos(builder, scene, q)
    state = planar_state(builder, scene, q, v)
    half, nothing = builder.lift(1) / 2, builder.lift(0)
    cart_speed = v[0] if scene.has_cart else nothing
    start = parameters.cart_mass * (v[0] * v[0]) if scene.has_cart else nothing
    with builder.loop("k", 0, scene.links) as loop:
        k = loop.index
        mass, length, com = parameters.mass[k], parameters.length[k], parameters.com[k]
        speed_x, speed_y = loop.carry("joint_speed_x", cart_speed), loop.carry("joint_speed_y", nothing)
        depth = loop.carry("joint_depth", nothing)
        twice_kinetic, fallen = loop.carry("twice_kinetic", start), loop.carry("fallen", nothing)
        sideways = builder.let("sideways", cosine[k] * state.rate[k])
        downwards = builder.let("downwards", -(sine[k] * state.rate[k]))
        mass_x = builder.let("mass_speed_x", speed_x + com * sideways)
        mass_y = builder.let("mass_speed_y", speed_y + com * downwards)
        moving = twice_kinetic + mass * (mass_x * mass_x + mass_y * mass_y)
        if parameters.inertia is not None:
            moving = moving + parameters.inertia[k] * (state.rate[k] * state.rate[k])
        rotor = rotors.kinetic(parameters, state.joint_rate, k)
        loop.follow(twice_kinetic, moving if rotor is None else moving + rotor)
        stored = parameters.gravity * mass * (depth + com * cosine[k])
        if parameters.stiffness is not None:
            stretch = bend(parameters, state, k)
            stored = stored - half * parameters.stiffness[k] * (stretch * stretch)
        loop.follow(fallen, fallen + stored)
        loop.follow(speed_x, speed_x + length * sideways)
        loop.follow(speed_y, speed_y + length * downwards)
        loop.follow(depth, depth + length * cosine[k])
    kinetic[0] = half * twice_kinetic
    potential[0] = -fallen


@writes("positions", space="planar")
def positions(builder: Builder, scene: Scene, parameters: Parameters, q: ArrayRef, out: ArrayRef) -> None:
    """Mass positions (along e_1, along gravity), links x 2."""
    sine, cosine = absolute_sincos(builder, scene, q)
    nothing = builder.lift(0)
    with builder.loop("k", 0, scene.links) as loop:
        k = loop.index
        joint_x = loop.carry("joint_x", q[0] if scene.has_cart else nothing)
        joint_y = loop.carry("joint_y", nothing)
        out[2 * k] = joint_x + parameters.com[k] * sine[k]
        out[2 * k + 1] = joint_y + parameters.com[k] * cosine[k]
        loop.follow(joint_x, joint_x + parameters.length[k] * sine[k])
        loop.follow(joint_y, joint_y + parameters.length[k] * cosine[k])


@writes("inverse_dynamics", space="planar")
def inverse_dynamics(
    builder: Builder, scene: Scene, parameters: Parameters, q: ArrayRef, v: ArrayRef, a: ArrayRef, u: ArrayRef,
    b: ArrayRef | None = None,
) -> None:  # fmt: skip
    """The full generalised force that produces the accelerations a: a sweep out for motions and back for forces.

    Link frames have x along the link and y along its tangent; accelerations carry -g. Springs, dampers and dry friction are part
    of the chain: their forces are overcome by u. b is the acceleration of a moving base.
    """
    links, offset = scene.links, int(scene.has_cart)
    given = () if b is None else tuple(b[i] for i in range(scene.base_inputs))
    fall = parameters.carried(scene, base_acceleration(builder, scene, given)).fall
    state = planar_state(builder, scene, q, v)
    sine, cosine = builder.sincos(state.angle, links)
    alpha = absolute(builder, scene, "alpha", a.shifted(offset))
    inertial_x, inertial_y = builder.array("inertial_x", links), builder.array("inertial_y", links)
    with builder.loop("k", 0, links) as loop:
        k = loop.index
        before_x = loop.carry("base_x", -fall[1])
        before_y = loop.carry("base_y", a[0] if scene.has_cart else -fall[0])
        joint_x = builder.let("joint_x", cosine[k] * before_x + sine[k] * before_y)
        joint_y = builder.let("joint_y", cosine[k] * before_y - sine[k] * before_x)
        squared = builder.let("rate_squared", state.rate[k] * state.rate[k])
        inertial_x[k] = parameters.mass[k] * (joint_x - parameters.com[k] * squared)
        inertial_y[k] = parameters.mass[k] * (joint_y + parameters.com[k] * alpha[k])
        loop.follow(before_x, joint_x - parameters.length[k] * squared)
        loop.follow(before_y, joint_y + parameters.length[k] * alpha[k])
    torque = builder.array("absolute_torque", links)
    couple = rotors.couples(builder, scene, parameters, "rotor_couple", a.shifted(offset))
    with builder.loop("k", links - 1, -1, -1) as loop:
        k = loop.index
        beyond_x, beyond_y = loop.carry("beyond_x", 0), loop.carry("beyond_y", 0)
        own = parameters.com[k] * inertial_y[k] + parameters.length[k] * beyond_y
        if parameters.inertia is not None:
            own = own + parameters.inertia[k] * alpha[k]
        passive = passive_torque(scene, parameters, state, k)
        if passive is not None:
            outer = loop.carry("passive_beyond", 0)
            own = own - (passive - outer)
            loop.follow(outer, passive)
        torque[k] = rotors.added(own, couple, k)
        force_x = builder.let("force_x", inertial_x[k] + beyond_x)
        force_y = builder.let("force_y", inertial_y[k] + beyond_y)
        loop.follow(beyond_x, cosine[k] * force_x - sine[k] * force_y)
        loop.follow(beyond_y, sine[k] * force_x + cosine[k] * force_y)
    to_generalised(builder, scene, torque, u.shifted(offset))
    if scene.has_cart:
        needed = parameters.cart_mass * a[0] + beyond_y
        u[0] = needed + cart_drag(scene, parameters, v) if is_braked(scene) else needed


@writes("linearization", space="planar")
def linearization(
    builder: Builder, scene: Scene, parameters: Parameters, s: ArrayRef, **outputs: ArrayRef
) -> None:
    """M x'' + [D x'] + G x = B u about phi_k = 0 (s_k = 1) or pi (s_k = -1); (19) in the plane. Dry friction is a damper F / v_0 there."""
    links, mu, length = scene.links, parameters.mu, parameters.length
    inner = builder.array("absolute_mass", links * links)
    with builder.loop("i", 0, links) as rows:
        i = rows.index
        inner[i * (links + 1)] = parameters.c_diagonal[i]
        with builder.loop("j", i + 1, links) as columns:
            j = columns.index
            entry = builder.let("entry", length[i] * mu[j] * (s[i] * s[j]))
            inner[i * links + j] = entry
            inner[j * links + i] = entry
    rotors.inertia(builder, scene, parameters, inner, outputs["M"])
    coupling, falling = builder.array("cart_coupling", links), builder.array("falling", links)
    with builder.loop("k", 0, links) as loop:
        coupling[loop.index] = mu[loop.index] * s[loop.index]
        falling[loop.index] = parameters.gravity * coupling[loop.index]
    _joint_matrix(builder, scene, parameters.stiffness, falling, outputs["G"])
    if "D" in outputs:
        resistance = slopes_at_rest(scene, parameters)
        drag = cart_slope(scene, parameters, None) if scene.has_free_cart else builder.lift(0)
        _joint_matrix(builder, scene, resistance, None, outputs["D"], drag)
    if scene.has_free_cart:
        cart_border(builder, scene, parameters, coupling, outputs["M"])
    if "B" in outputs:
        input_matrix(builder, scene, outputs["B"])
    if scene.base_accelerations:
        planar_base_columns(builder, scene, coupling, outputs["M"], outputs["B"])


def _joint_matrix(
    builder: Builder, scene: Scene, joint: ArrayRef | None, diagonal: ArrayRef | None, out: ArrayRef, corner: Expr | int = 0
) -> None:
    """S^T (diag(absolute) + P^T diag(joint) P) S, P phi the joint angles; of the cart's row and column the corner alone is not zero."""
    links, offset, nv = scene.links, int(scene.has_cart), scene.nv
    inner, nothing = builder.array("absolute_matrix", links * links), builder.lift(0)
    with builder.loop("i", 0, links) as rows:
        i = rows.index
        own = nothing if diagonal is None else diagonal[i]
        inner[i * (links + 1)] = own if joint is None else own + joint[i] + _beyond(builder, joint, links)[i]
        with builder.loop("j", i + 2, links) as columns:
            j = columns.index
            inner[i * links + j], inner[j * links + i] = nothing, nothing
    with builder.loop("i", 1, links) as rows:
        i = rows.index
        shared = nothing if joint is None else -joint[i]
        inner[i * links + (i - 1)], inner[(i - 1) * links + i] = shared, shared
    congruence(builder, scene, inner, out.shifted(offset * (nv + 1)), nv)
    if scene.has_cart:
        out[0] = corner
        with builder.loop("k", 1, nv) as loop:
            out[loop.index], out[loop.index * nv] = nothing, nothing


def _beyond(builder: Builder, joint: ArrayRef, links: int) -> ArrayRef:
    """The joint's value at each link's far end, zero beyond the tip."""
    with builder.first_of_all():
        beyond = builder.array("next_joint", links)
        with builder.loop("k", 1, links) as loop:
            beyond[loop.index - 1] = joint[loop.index]
        beyond[links - 1] = builder.lift(0)
    return beyond


def input_matrix(builder: Builder, scene: Scene, out: ArrayRef) -> None:
    """The constant matrix that takes u to generalised forces, nv x nu; columns of the base's acceleration are left out."""
    if scene.base_accelerations or len(scene.driven) < scene.nv:
        for column, driven in enumerate(scene.driven, scene.base_accelerations):
            _unit_column(builder, scene, out.shifted(column, scene.nu), driven)
        return
    with builder.loop("i", 0, scene.nv) as rows:
        i = rows.index
        out[i * (scene.nv + 1)] = builder.lift(1)
        with builder.loop("j", i + 1, scene.nv) as others:
            j = others.index
            out[i * scene.nv + j], out[j * scene.nv + i] = builder.lift(0), builder.lift(0)


def _unit_column(builder: Builder, scene: Scene, column: ArrayRef, driven: int) -> None:
    column[driven] = builder.lift(1)
    for first, last in ((0, driven), (driven + 1, scene.nv)):
        with builder.loop("i", first, last) as rows:
            column[rows.index] = builder.lift(0)
