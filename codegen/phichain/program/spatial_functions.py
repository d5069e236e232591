"""Spatial functions other than forward dynamics: the terms of (16), energy, positions, linearisation (19), projection.

(16) reads M [x''; omega'] + coriolis + gravity = [u; 0] with M_00 = M00 I, M_0j = -mu_j C^T hat(q_j), M_i0 = mu_i hat(q_i) C,
M_ii = c_ii I, M_ij = -c_ij hat(q_i) hat(q_j) = c_ij ((q_i.q_j) I - q_j q_i^T), coriolis_0 = -sum mu_j |omega_j|^2 C^T q_j,
coriolis_i = -sum_{j != i} c_ij |omega_j|^2 q_i x q_j and gravity_i = -mu_i g q_i x e_3.
"""

from __future__ import annotations

from phichain.program.builder import ArrayRef, Builder, Expr, Index
from phichain.program.parameters import Parameters
from phichain.program.spatial_links import directions
from phichain.program.vector import Vector, add, cross, dot, load, scale, store, sub
from phichain.scene import Scene


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


def coriolis(
    builder: Builder, scene: Scene, parameters: Parameters, q: ArrayRef, v: ArrayRef, out: ArrayRef
) -> None:
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


def energy(
    builder: Builder, scene: Scene, parameters: Parameters, q: ArrayRef, v: ArrayRef, kinetic: ArrayRef, potential: ArrayRef
) -> None:
    """T and V of design 1.1 from the masses' velocities and heights, with the springs' energy."""
    direction, omega = directions(scene, q), directions(scene, v)
    half, nothing = builder.lift(1) / 2, builder.lift(0)
    cart_speed: Vector = (v[0], v[1], nothing) if scene.has_cart else (nothing, nothing, nothing)
    start = parameters.cart_mass * (v[0] * v[0] + v[1] * v[1]) if scene.has_cart else nothing
    with builder.loop("k", 0, scene.links) as loop:
        k = loop.index
        mass, length, com = parameters.mass[k], parameters.length[k], parameters.com[k]
        names = ("joint_speed_x", "joint_speed_y", "joint_speed_z")
        speed = (
            loop.carry(names[0], cart_speed[0]), loop.carry(names[1], cart_speed[1]), loop.carry(names[2], nothing),
        )  # fmt: skip
        depth = loop.carry("joint_depth", nothing)
        twice_kinetic, fallen = loop.carry("twice_kinetic", start), loop.carry("fallen", nothing)
        here = load(direction, k)
        turning = cross(load(omega, k), here)
        at_mass = add(speed, scale(com, turning))
        loop.follow(twice_kinetic, twice_kinetic + mass * dot(at_mass, at_mass))
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


def linearization(
    builder: Builder, scene: Scene, parameters: Parameters, s: ArrayRef, outputs: dict[str, ArrayRef]
) -> None:
    """(19) in [x; C^T xi_k], two coordinates a link: M x'' + [D x'] + G x = B u about q_k = s_k e_3."""
    links, offset = scene.links, 2 if scene.has_cart else 0
    size = 2 * links + offset
    mu, length, nothing = parameters.mu, parameters.length, builder.lift(0)
    entries: dict[str, dict[tuple[int, int], Expr]] = {"M": {}, "G": {}, "D": {}, "B": {}}
    for i in range(links):
        _block(entries["M"], offset + 2 * i, offset + 2 * i, parameters.c_diagonal[i])
        _block(entries["G"], offset + 2 * i, offset + 2 * i, parameters.gravity * mu[i] * s[i])
        for j in range(i + 1, links):
            entry = length[i] * mu[j] * (s[i] * s[j])
            _block(entries["M"], offset + 2 * i, offset + 2 * j, entry)
            _block(entries["M"], offset + 2 * j, offset + 2 * i, entry)
    if scene.has_cart:
        _block(entries["M"], 0, 0, parameters.total_mass)
        for k in range(links):
            lean, column = mu[k] * s[k], offset + 2 * k
            entries["M"].update({(0, column + 1): lean, (column + 1, 0): lean})
            entries["M"].update({(1, column): -lean, (column, 1): -lean})
        for a in range(2):
            entries["B"][a, a] = builder.lift(1)
    if parameters.stiffness is not None:
        bent = [parameters.stiffness[k] * (s[k] * s[k - 1] if k else s[0]) for k in range(links)]
        _chain(entries["G"], offset, bent)
    if parameters.damping is not None:
        _chain(entries["D"], offset, [parameters.damping[k] for k in range(links)])
    for name, out in outputs.items():
        columns = out.size // size
        for i in range(size):
            for j in range(columns):
                out[i * columns + j] = entries[name].get((i, j), nothing)


def _block(entries: dict[tuple[int, int], Expr], row: int, column: int, value: Expr) -> None:
    """Add value * I to a 2 x 2 block."""
    for a in range(2):
        at = (row + a, column + a)
        entries[at] = entries[at] + value if at in entries else value


def _chain(entries: dict[tuple[int, int], Expr], offset: int, joint: list[Expr]) -> None:
    """Second variation of sum joint_k |xi_k - xi_{k-1}|^2 / 2, xi_{-1} = 0."""
    for k, value in enumerate(joint):
        _block(entries, offset + 2 * k, offset + 2 * k, value)
        if k:
            _block(entries, offset + 2 * k - 2, offset + 2 * k - 2, value)
            _block(entries, offset + 2 * k, offset + 2 * k - 2, -value)
            _block(entries, offset + 2 * k - 2, offset + 2 * k, -value)


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
