"""Spatial functions other than forward dynamics: the terms of (16), energy, positions, linearisation (19), projection.

(16) reads M [x''; omega'] + coriolis + gravity = [u; 0] with M_00 = M00 I, M_0j = -mu_j C^T hat(q_j), M_i0 = mu_i hat(q_i) C,
M_ii = c_ii I, M_ij = -c_ij hat(q_i) hat(q_j) = c_ij ((q_i.q_j) I - q_j q_i^T), coriolis_0 = -sum mu_j |omega_j|^2 C^T q_j,
coriolis_i = -sum_{j != i} c_ij |omega_j|^2 q_i x q_j and gravity_i = -mu_i g q_i x e_3.
"""

from __future__ import annotations

from fractions import Fraction

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.lowering.algebra.vector import Vector, add, cross, dot, load, scale, store, sub
from phichain.lowering.chain.base import spatial_base_columns
from phichain.lowering.chain.losses import cart_slope, slopes_at_rest
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.spatial.links import directions
from phichain.lowering.writers import writes
from phichain.scene import Scene


@writes("mass_matrix", space="spatial")
def mass_matrix(builder: Builder, scene: Scene, parameters: Parameters, q: ArrayRef, out: ArrayRef) -> None:
    """The matrix of (16), nv x nv."""
    links, nv, offset = scene.links, scene.nv, 2 if scene.has_cart else 0
    direction, nothing = directions(scene, q), builder.lift(0)
    block = out.shifted(offset * (nv + 1))
    with builder.loop("i", 0, links) as rows:
        i = rows.index
        for a in range(3):
            for b in range(3):
                block[(3 * i + a) * nv + 3 * i + b] = parameters.c_diagonal[i] if a == b else nothing
        with builder.loop("j", i + 1, links) as columns:
            j = columns.index
            inertia = builder.let("inertia", parameters.length[i] * parameters.mu[j])
            _pair_block(builder, load(direction, i), load(direction, j), inertia, block, (i, j), nv)
    if not scene.has_cart:
        return
    for a in range(2):
        for b in range(2):
            out[a * nv + b] = parameters.total_mass if a == b else nothing
    with builder.loop("k", 0, links) as loop:
        k = loop.index
        x, y, z = (parameters.mu[k] * part for part in load(direction, k))
        # -C^T hat(mu q): rows of the cart, columns of link k
        for a, row in enumerate(((nothing, z, -y), (-z, nothing, x))):
            for b, value in enumerate(row):
                out[a * nv + (3 * k + 2 + b)] = value
                out[(3 * k + 2 + b) * nv + a] = value


def _pair_block(
    builder: Builder, inner: Vector, outer: Vector, inertia: Expr, block: ArrayRef, at: tuple[Index, Index], nv: int
) -> None:
    """c_ij ((q_i.q_j) I - q_j q_i^T) into block (i, j), its transpose into (j, i)."""
    i, j = at
    projection = builder.let("projection", dot(inner, outer))
    for a in range(3):
        for b in range(3):
            product = outer[a] * inner[b]
            value = inertia * (projection - product) if a == b else -(inertia * product)
            block[(3 * i + a) * nv + (3 * j + b)] = value
            block[(3 * j + b) * nv + (3 * i + a)] = value


@writes("coriolis", space="spatial")
def coriolis(builder: Builder, scene: Scene, parameters: Parameters, q: ArrayRef, v: ArrayRef, out: ArrayRef) -> None:
    """The velocity terms of (16), nv, by prefix and suffix sums of c_ij = l_min mu_max."""
    links, mu, length = scene.links, parameters.mu, parameters.length
    direction, omega, result = directions(scene, q), directions(scene, v), directions(scene, out)
    inner_sum = builder.array("inner_sum", 3 * links)
    with builder.loop("i", 0, links) as loop:
        i = loop.index
        total = (loop.carry("inner_x", 0), loop.carry("inner_y", 0), loop.carry("inner_z", 0))
        store(inner_sum, i, total)
        pull = _pull(length[i], load(omega, i), load(direction, i))
        for before, after in zip(total, add(total, pull), strict=True):
            loop.follow(before, after)
    with builder.loop("i", links - 1, -1, -1) as loop:
        i = loop.index
        total = (loop.carry("outer_x", 0), loop.carry("outer_y", 0), loop.carry("outer_z", 0))
        lean = add(scale(mu[i], load(inner_sum, i)), scale(length[i], total))
        store(result, i, cross(lean, load(direction, i)))
        pull = _pull(mu[i], load(omega, i), load(direction, i))
        for before, after in zip(total, add(total, pull), strict=True):
            loop.follow(before, after)
    if scene.has_cart:
        out[0], out[1] = -total[0], -total[1]


def _pull(weight: Expr, omega: Vector, direction: Vector) -> Vector:
    """weight |omega|^2 q"""
    return scale(weight * dot(omega, omega), direction)


@writes("gravity_torque", space="spatial")
def gravity_torque(builder: Builder, scene: Scene, parameters: Parameters, q: ArrayRef, out: ArrayRef) -> None:
    """The gravity terms of (16), nv; gravity alone, without springs."""
    direction, result, nothing = directions(scene, q), directions(scene, out), builder.lift(0)
    with builder.loop("k", 0, scene.links) as loop:
        k = loop.index
        weight = parameters.gravity * parameters.mu[k]
        x, y, _ = load(direction, k)
        store(result, k, (-(weight * y), weight * x, nothing))
    if scene.has_cart:
        out[0], out[1] = nothing, nothing


@writes("energy", space="spatial")
def energy(
    builder: Builder, scene: Scene, parameters: Parameters, q: ArrayRef, v: ArrayRef, kinetic: ArrayRef, potential: ArrayRef
) -> None:
    """T and V of theory section 1 from the masses' velocities and heights, with the springs' energy."""
    direction, omega = directions(scene, q), directions(scene, v)
    half, nothing = builder.lift(1) / 2, builder.lift(0)
    cart_speed: Vector = (v[0], v[1], nothing) if scene.has_cart else (nothing, nothing, nothing)
    start = parameters.cart_mass * (v[0] * v[0] + v[1] * v[1]) if scene.has_cart else nothing
    with builder.loop("k", 0, scene.links) as loop:
        k = loop.index
        mass, length, com = parameters.mass[k], parameters.length[k], parameters.com[k]
        speed: Vector = tuple(loop.carry(f"joint_speed_{x}", part) for x, part in zip("xyz", cart_speed, strict=True))
        depth = loop.carry("joint_depth", nothing)
        twice_kinetic, fallen = loop.carry("twice_kinetic", start), loop.carry("fallen", nothing)
        here = load(direction, k)
        turning = cross(load(omega, k), here)
        at_mass = add(speed, scale(com, turning))
        own = mass * dot(at_mass, at_mass)
        spin = None if parameters.inertia is None else parameters.inertia[k] * dot(turning, turning)
        loop.follow(twice_kinetic, twice_kinetic + own if spin is None else twice_kinetic + own + spin)
        loop.follow(fallen, fallen + parameters.gravity * mass * (depth + com * here[2]))
        for before, after in zip(speed, add(speed, scale(length, turning)), strict=True):
            loop.follow(before, after)
        loop.follow(depth, depth + length * here[2])
    kinetic[0] = half * twice_kinetic
    potential[0] = -fallen if parameters.stiffness is None else _springs(builder, parameters, direction) - fallen


def _springs(builder: Builder, parameters: Parameters, direction: ArrayRef) -> Expr:
    """sum k_k (1 - q_{k-1}.q_k) as half the squared distance of the unit vectors, free of cancellation."""
    assert parameters.stiffness is not None
    half, nothing = builder.lift(1) / 2, builder.lift(0)
    lean = sub(load(direction, 0), (nothing, nothing, builder.lift(1)))
    first = half * parameters.stiffness[0] * dot(lean, lean)
    with builder.loop("k", 1, parameters.links) as loop:
        k = loop.index
        stored = loop.carry("stored", first)
        bend = sub(load(direction, k), load(direction, k - 1))
        loop.follow(stored, stored + half * parameters.stiffness[k] * dot(bend, bend))
    return stored


@writes("positions", space="spatial")
def positions(builder: Builder, scene: Scene, parameters: Parameters, q: ArrayRef, out: ArrayRef) -> None:
    """Mass positions, links x 3, the last component along gravity."""
    direction, nothing = directions(scene, q), builder.lift(0)
    base = (q[0], q[1], nothing) if scene.has_cart else (nothing, nothing, nothing)
    with builder.loop("k", 0, scene.links) as loop:
        k = loop.index
        joint = (loop.carry("joint_x", base[0]), loop.carry("joint_y", base[1]), loop.carry("joint_z", base[2]))
        here = load(direction, k)
        store(out, k, add(joint, scale(parameters.com[k], here)))
        for before, after in zip(joint, add(joint, scale(parameters.length[k], here)), strict=True):
            loop.follow(before, after)


@writes("linearization", space="spatial")
def linearization(builder: Builder, scene: Scene, parameters: Parameters, s: ArrayRef, **outputs: ArrayRef) -> None:
    """(19) in [x; C^T xi_k], two coordinates a link: M x'' + [D x'] + G x = B u about q_k = s_k e_3.

    M_ij = c_ij s_i s_j I, M_0k = mu_k s_k [[0, 1], [-1, 0]], G_kk = g mu_k s_k I. A spring adds k_k s_{k-1} s_k |xi_k - xi_{k-1}|^2 / 2
    to the potential, a damper d_k |xi_k' - xi_{k-1}'|^2 / 2 to the dissipation, dry friction
    that of a damper F_k / v_0.
    """
    links, offset = scene.links, 2 if scene.has_cart else 0
    size = 2 * links + offset
    mu, length = parameters.mu, parameters.length
    inertia = _Planes(outputs["M"].shifted(offset * (size + 1)), size)
    with builder.loop("i", 0, links) as rows:
        i = rows.index
        inertia.write(i, i, parameters.c_diagonal[i])
        with builder.loop("j", i + 1, links) as columns:
            j = columns.index
            entry = builder.let("entry", length[i] * mu[j] * (s[i] * s[j]))
            inertia.write(i, j, entry)
            inertia.write(j, i, entry)
    weight = builder.array("weight", links)
    with builder.loop("k", 0, links) as loop:
        weight[loop.index] = parameters.gravity * mu[loop.index] * s[loop.index]
    springs = None if parameters.stiffness is None else _signed(builder, parameters.stiffness, s, links)
    _neighbour_matrix(builder, links, weight, springs, _Planes(outputs["G"].shifted(offset * (size + 1)), size))
    if "D" in outputs:
        _neighbour_matrix(builder, links, None, slopes_at_rest(scene, parameters), _Planes(outputs["D"].shifted(offset * (size + 1)), size))
    if scene.has_free_cart:
        _cart_inertia(builder, scene, parameters, s, outputs["M"])
    if scene.has_cart:
        _border(builder, outputs["G"], size, builder.lift(0))
        if "D" in outputs:
            drag = cart_slope(scene, parameters, None) if scene.has_free_cart else builder.lift(0)
            _border(builder, outputs["D"], size, drag)
    if scene.base_accelerations:
        spatial_base_columns(builder, scene, lambda k: mu[k] * s[k], outputs["M"], outputs["B"])
    elif "B" in outputs:
        _force_matrix(builder, outputs["B"], size)


class _Planes:
    """A matrix of 2 x 2 blocks value * I, from its first cell on, with rows of `size` cells."""

    def __init__(self, out: ArrayRef, size: int) -> None:
        self.out, self.size = out, size

    def write(self, i: Index, j: Index, value: Expr) -> None:
        """Block (i, j) = value * I."""
        for a in range(2):
            for b in range(2):
                cell = (2 * i + a) * self.size + (2 * j + b)
                self.out[cell] = value if a == b else value.builder.lift(0)


def _signed(builder: Builder, stiffness: ArrayRef, s: ArrayRef, links: int) -> ArrayRef:
    """k_k s_{k-1} s_k, s_{-1} = 1."""
    signed = builder.array("signed_stiffness", links)
    signed[0] = stiffness[0] * s[0]
    with builder.loop("k", 1, links) as loop:
        k = loop.index
        signed[k] = stiffness[k] * (s[k - 1] * s[k])
    return signed


def _neighbour_matrix(
    builder: Builder, links: int, diagonal: ArrayRef | None, joint: ArrayRef | None, planes: _Planes
) -> None:
    """diag(diagonal) plus the second variation of sum joint_k |xi_k - xi_{k-1}|^2 / 2, xi_{-1} = 0."""
    nothing = builder.lift(0)
    own = diagonal if diagonal is not None else builder.constants("no_diagonal", [Fraction(0)] * links)
    with builder.loop("k", 0, links - 1) as loop:
        k = loop.index
        planes.write(k, k, own[k] if joint is None else own[k] + joint[k] + joint[k + 1])
    tip = links - 1
    planes.write(tip, tip, own[tip] if joint is None else own[tip] + joint[tip])
    with builder.loop("i", 1, links) as rows:
        i = rows.index
        shared = nothing if joint is None else -joint[i]
        planes.write(i, i - 1, shared)
        planes.write(i - 1, i, shared)
    with builder.loop("i", 0, links) as rows, builder.loop("j", rows.index + 2, links) as columns:
        planes.write(rows.index, columns.index, nothing)
        planes.write(columns.index, rows.index, nothing)


def _cart_inertia(builder: Builder, scene: Scene, parameters: Parameters, s: ArrayRef, out: ArrayRef) -> None:
    size, nothing = 2 * scene.links + 2, builder.lift(0)
    for a in range(2):
        for b in range(2):
            out[a * size + b] = parameters.total_mass if a == b else nothing
    with builder.loop("k", 0, scene.links) as loop:
        k = loop.index
        lean, first, second = parameters.mu[k] * s[k], 2 * k + 2, 2 * k + 3
        out[first], out[first * size] = nothing, nothing
        out[second], out[second * size] = lean, lean
        out[first + size], out[first * size + 1] = -lean, -lean
        out[second + size], out[second * size + 1] = nothing, nothing


def _border(builder: Builder, out: ArrayRef, size: int, corner: Expr) -> None:
    """The cart's rows and columns: corner * I, and zeros."""
    nothing = builder.lift(0)
    for a in range(2):
        for b in range(2):
            out[a * size + b] = corner if a == b else nothing
        with builder.loop("k", 2, size) as loop:
            out[loop.index + a * size], out[loop.index * size + a] = nothing, nothing


def _force_matrix(builder: Builder, out: ArrayRef, size: int) -> None:
    for i in range(4):
        out[i] = builder.lift(int(i in (0, 3)))
    with builder.loop("i", 4, 2 * size) as loop:
        out[loop.index] = builder.lift(0)


@writes("project")
def _project(builder: Builder, scene: Scene, parameters: Parameters, **arguments: ArrayRef) -> None:
    project(builder, scene, **arguments)


def project(builder: Builder, scene: Scene, q: ArrayRef, v: ArrayRef, q_out: ArrayRef, v_out: ArrayRef) -> None:
    """Unit vectors made unit, rates made tangent; the cart's cells pass through."""
    if scene.has_cart:
        for i in range(2):
            q_out[i], v_out[i] = q[i], v[i]
    direction, omega = directions(scene, q), directions(scene, v)
    unit_out, omega_out = directions(scene, q_out), directions(scene, v_out)
    with builder.loop("k", 0, scene.links) as loop:
        k = loop.index
        here = load(direction, k)
        unit = scale(1 / builder.sqrt(dot(here, here)), here)
        turning = load(omega, k)
        store(unit_out, k, unit)
        store(omega_out, k, sub(turning, scale(dot(unit, turning), unit)))
