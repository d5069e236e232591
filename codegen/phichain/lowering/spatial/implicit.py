"""(I - g J) k = r in O(N) for the spatial chain, in the chart of `spatial.chart`: the linearised chain, swept by 3 x 3 blocks.

As in the plane (`planar.implicit`), with vectors across q_k: with nu = sigma x q the coordinates obey s' = nu, so x, the
perturbation of nu', gives dnu = V + g x and ds = P + g^2 x, V = r_nu, P = r_s + g r_nu. Link k with rate w, tangential
acceleration alpha and velocity q' = omega x q has

    d q'' = n x + c,   n = (1 - g^2 w^2) I - q (g^2 alpha + 2 g q')^T,   c = -w^2 P - q (alpha . P + 2 q' . V)
    across q_k:  m r dA_m + J dq'' + l dF_next - R ds - dQ = 0,   R = q . (m r A_m + J q'' + l F_next - Q)

Q holds the springs' k q_{k-1} and the losses' -c (omega_k - omega_{k-1}) x q_k, and the same of the joint beyond. A joint
ties x_k to x_{k-1}: the chain beyond it asks for a force and a couple on the link before,
(dF, dH) = Lambda (dA, x_before) + lambda with blocks A, U, W, kappa of 3 x 3; without springs and dampers only A is there, and
where masses sit near the joints `spatial.near_joints` takes its place.
"""

from __future__ import annotations

from dataclasses import dataclass

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.lowering.algebra.matrix import (
    Matrix,
    across_columns,
    across_rows,
    flat,
    from_flat,
    minus,
    outer,
    plus,
    product,
    scalar,
    scaled,
    store_matrix,
    tangent_inverse,
    zero,
)
from phichain.lowering.algebra.vector import Vector, add, cross, dot, load, scale, store, sub
from phichain.lowering.chain.base import base_acceleration
from phichain.lowering.chain.losses import brakes_cart, cart_slope_cells, cart_slopes, ties_links
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.spatial.joint import RESISTED, Joint, write_resistances
from phichain.lowering.spatial.links import directions
from phichain.lowering.spatial.near_joints import CART_PIVOT, NearJoints, near_joints, near_sizes
from phichain.scene import Scene

#: Arrays that `factors` hands to `solution`: entries a link has in each, everywhere, with joints, with dampers.
_FREE = {
    "unit": 3,
    "spin": 3,
    "moving": 3,
    "turning": 3,
    "pull": 1,
    "carried": 9,
    "arm": 9,
    "row": 9,
    "column": 9,
    "inverse": 9,
}
_JOINED = {"inner": 9, "outer": 9}
#: Where something resists the cart's speed: its slope c, or slopes xx, xy, yy, then m_c + Lambda of its horizontal block, row by row.
CART_DRAG = "cart_drag"


def joined(scene: Scene) -> bool:
    """Whether joints tie neighbours together."""
    return ties_links(scene)


def factor_sizes(scene: Scene) -> dict[str, int]:
    """Names and sizes of what `factors` writes."""
    if near_joints(scene):
        return near_sizes(scene)
    sizes = {name: size * scene.links for name, size in (_FREE | (_JOINED if joined(scene) else {})).items()}
    sizes |= {RESISTED: 2 * scene.links} if scene.friction is not None else {}
    sizes |= {CART_PIVOT: 4} if scene.has_free_cart else {}
    return sizes | ({CART_DRAG: 4 + cart_slope_cells(scene)} if brakes_cart(scene) else {})


@dataclass(frozen=True)
class _Beyond:
    """What the chain beyond a joint asks for: force by acceleration and by x, couple by acceleration and by x."""

    force: Matrix
    force_x: Matrix
    couple: Matrix
    couple_x: Matrix

    def flat(self) -> list[Expr]:
        return [entry for block in (self.force, self.force_x, self.couple, self.couple_x) for entry in flat(block)]

    @classmethod
    def from_flat(cls, values: list[Expr]) -> _Beyond:
        return cls(*(from_flat(values[i : i + 9]) for i in range(0, 36, 9)))


def factors(
    builder: Builder,
    scene: Scene,
    parameters: Parameters,
    inputs: tuple[Expr, ArrayRef, ArrayRef, ArrayRef],
    out: dict[str, ArrayRef],
    b: tuple[Expr, ...] = (),
) -> None:
    """Write what `solution` needs for the g, q, v and a (the accelerations at q, v) of `inputs`, on a base moved by b."""
    gain, q, v, a = inputs
    parameters = parameters.carried(scene, base_acceleration(builder, scene, b))
    _motion(builder, scene, parameters, q, v, a, out)
    if near_joints(scene):
        NearJoints(builder, scene, parameters, gain, v, out).run()
        return
    if scene.friction is not None:
        write_resistances(builder, scene, parameters, out)
    beyond = _Inwards(builder, scene, parameters, gain, out).run()
    if scene.has_free_cart:
        (xx, xy, _), (yx, yy, _), _ = beyond.force
        xx, yy = xx + parameters.cart_mass, yy + parameters.cart_mass
        if brakes_cart(scene):
            own, aside, other = (builder.let("cart_slope", entry) for entry in cart_slopes(scene, parameters, v))
            for i, entry in enumerate((*(own, aside, other)[: cart_slope_cells(scene)], xx, xy, yx, yy)):
                out[CART_DRAG][i] = entry
            xx, xy, yx, yy = xx + gain * own, xy + gain * aside, yx + gain * aside, yy + gain * other
        inverse = builder.let("inverse_cart", 1 / (xx * yy - xy * yx))
        for i, entry in enumerate((yy, -xy, -yx, xx)):
            out[CART_PIVOT][i] = entry * inverse


def _motion(
    builder: Builder,
    scene: Scene,
    parameters: Parameters,
    q: ArrayRef,
    v: ArrayRef,
    a: ArrayRef,
    out: dict[str, ArrayRef],
) -> None:
    """The unperturbed chain: unit vectors, rates, velocities, tangential accelerations, and the pull R of each link."""
    links, mass, length, com = (
        scene.links,
        parameters.mass,
        parameters.length,
        parameters.com,
    )
    inertial = builder.array("inertial", 3 * links)
    rise = tuple(-entry for entry in parameters.fall)
    base = (a[0], a[1]) if scene.has_cart else rise[:-1]
    with builder.loop("k", 0, links) as loop:
        k = loop.index
        start = (*base, rise[-1])
        joint: Vector = tuple(loop.carry(f"joint_{x}", part) for x, part in zip("xyz", start, strict=True))
        here, omega = load(directions(scene, q), k), load(directions(scene, v), k)
        moving, turning = cross(omega, here), cross(load(directions(scene, a), k), here)
        whole = sub(turning, scale(dot(omega, omega), here))
        store(inertial, k, scale(mass[k], add(joint, scale(com[k], whole))))
        for name, value in (("unit", here), ("spin", omega), ("moving", moving), ("turning", turning)):
            store(out[name], k, value)
        for before, after in zip(joint, add(joint, scale(length[k], whole)), strict=True):
            loop.follow(before, after)
    with builder.loop("k", links - 1, -1, -1) as loop:
        k = loop.index
        beyond: Vector = tuple(loop.carry(f"beyond_{x}", 0) for x in "xyz")
        own, here = load(inertial, k), load(out["unit"], k)
        pull = com[k] * dot(here, own) + length[k] * dot(here, beyond)
        if parameters.inertia is not None:
            spin = load(out["spin"], k)
            pull = pull - parameters.inertia[k] * dot(spin, spin)
        out["pull"][k] = pull
        for before, after in zip(beyond, add(beyond, own), strict=True):
            loop.follow(before, after)


class _Inwards:
    """The elimination from the tip to the base."""

    def __init__(
        self, builder: Builder, scene: Scene, parameters: Parameters, gain: Expr, out: dict[str, ArrayRef]
    ) -> None:
        self.builder, self.scene, self.parameters, self.gain, self.out = builder, scene, parameters, gain, out
        self.squared, self.twice = (
            builder.let("gain_squared", gain * gain),
            builder.let("gain_twice", gain + gain),
        )

    def run(self) -> _Beyond:
        """The chain beyond the base. The joint at the base ties link 0 to nothing that moves."""
        builder, links = self.builder, self.scene.links
        nothing = builder.lift(0)
        start = _Beyond(*(zero(builder) for _ in range(4)))
        if links > 1:
            with builder.loop("k", links - 1, 0, -1) as loop:
                count = 36 if joined(self.scene) else 9
                carried = [loop.carry("beyond", 0) if i < count else nothing for i in range(36)]
                after = self.eliminate(_Beyond.from_flat(carried), loop.index, True)
                for before, following in zip(carried[:count], after.flat(), strict=False):
                    loop.follow(before, following)
            start = _Beyond.from_flat(carried)
        return self.eliminate(start, 0, False)

    def eliminate(self, beyond: _Beyond, k: Index, has_neighbour: bool) -> _Beyond:
        """Link k and all beyond it."""
        parameters, out = self.parameters, self.out
        mass, length, com = parameters.mass[k], parameters.length[k], parameters.com[k]
        here, spin, moving = (load(out[name], k) for name in ("unit", "spin", "moving"))
        lean = add(scale(self.squared, load(out["turning"], k)), scale(self.twice, moving))
        bent = minus(scalar(1 - self.squared * dot(spin, spin)), outer(here, lean))
        carried = plus(scalar(mass * com), scaled(length, beyond.force))
        own = mass * com * com if parameters.inertia is None else mass * com * com + parameters.inertia[k]
        arm = plus(
            across_rows(plus(scalar(own), scaled(length * length, beyond.force)), here),
            scaled(length, beyond.couple),
        )
        row = plus(across_rows(carried, here), beyond.couple)
        column = across_columns(plus(product(carried, bent), beyond.force_x), here)
        pivot = plus(
            product(arm, bent), scaled(length, across_rows(beyond.force_x, here)), beyond.couple_x,
            scalar(-(self.squared * out["pull"][k])),
        )  # fmt: skip
        for name, value in (("carried", carried), ("arm", arm), ("row", row), ("column", column)):
            store_matrix(out[name], k, value)
        if joined(self.scene):
            return self._behind_joint(beyond, k, has_neighbour, (mass, row, column, pivot))
        inverse = tangent_inverse(across_columns(across_rows(pivot, here), here), here)
        store_matrix(out["inverse"], k, inverse)
        passed = minus(plus(scalar(mass), beyond.force), product(product(column, inverse), row))
        return _Beyond(passed, beyond.force_x, beyond.couple, beyond.couple_x)

    def _behind_joint(
        self, beyond: _Beyond, k: Index, has_neighbour: bool, body: tuple[Expr, Matrix, Matrix, Matrix]
    ) -> _Beyond:
        """The same behind a joint with a spring or damper."""
        mass, row, column, pivot = body
        out, gain = self.out, self.gain
        here = load(out["unit"], k)
        joint = Joint(self.builder, self.parameters, out, k, not has_neighbour)
        pivot = plus(pivot, joint.matrix(joint.on_link, gain))
        inverse = tangent_inverse(across_columns(across_rows(pivot, here), here), here)
        inner = outer = back = zero(self.builder)
        if has_neighbour:
            before = load(out["unit"], k - 1)
            inner = across_columns(joint.matrix(joint.across_to_link, gain), before)
            outer = across_columns(joint.matrix(joint.across_to_before, gain), here)
            back = joint.matrix(joint.on_before, gain)
        for name, value in (("inverse", inverse), ("inner", inner), ("outer", outer)):
            store_matrix(out[name], k, value)
        through, answered = product(column, inverse), product(outer, inverse)
        return _Beyond(
            force=minus(plus(scalar(mass), beyond.force), product(through, row)),
            force_x=scaled(-1, product(through, inner)),
            couple=scaled(-1, product(answered, row)),
            couple_x=minus(back, product(answered, inner)),
        )
