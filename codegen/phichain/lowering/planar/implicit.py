"""(I - g J) k = r in O(N) for the planar chain, J the Jacobian of (v, a(q, v)): the linearised chain, swept as the chain is.

With x the perturbation of the accelerations the perturbed state is dv = r_v + g x and dq = r_q + g r_v + g^2 x, so every
equation of motion, linearised, has x alone as its unknown. In link frames (x along the link, y along its tangent), link k turning
with rate w and acceleration alpha, P and V the absolute r_q + g r_v and r_v, its far end is accelerated by

    dA + l (n x + c),   n = (-(g^2 alpha + 2 g w), 1 - g^2 w^2),   c = (-(alpha P + 2 w V), -w^2 P)

more than before, and its moment balance gains J x - R (P + g^2 x) with R = r m A_mx + l F_x, the pull that the link carries. The chain
beyond a joint asks for force and moment Lambda (dA, x_before) + lambda there, where x_before belongs to the link before: joints
transmit -s (x_k - x_before) - rho with s = A_k + g d_k + g^2 k_k, A_k the rotor's inertia and d_k the slope of the joint's damper and
dry friction together. Lambda is not symmetric; one sweep per step builds it, and each right side costs one sweep inwards and one
outwards. With D the pivot of the joint less s, B = D + A_k and S what acts on it,

    (D + s) (x_k - x_before) = S - rho,   k_v = (B r_v + g S - g k_k r_q) / (D + s),   k_q = ((B + g d_k) r_q + g (B r_v + g S)) / (D + s)

in joint terms: what a stiff joint's rate and angle are is formed at once, never as the difference of what the spring cancels.
"""

from __future__ import annotations

from dataclasses import dataclass

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.lowering.algebra.compound import Compound
from phichain.lowering.chain.base import base_acceleration
from phichain.lowering.chain.losses import brakes_cart, cart_slope, joint_slope, ties_links
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.planar.joints import absolute, planar_state
from phichain.scene import Scene

#: Arrays that `factors` hands to `solution`, with the entries a link has in each.
FACTORS = {
    "joint_sine": 1, "joint_cosine": 1, "rate": 1, "turning": 1, "pull": 1, "carried": 4, "arm": 2, "column": 2, "row": 2, "pivot": 3,
}  # fmt: skip
#: And the pivot of the cart, 1 / (m_c + g c + Lambda_yy), c the slope of what resists its speed.
CART_PIVOT = "cart_pivot"
#: Where it is resisted, c and m_c + Lambda_yy.
CART_DRAG = "cart_drag"
#: Slopes of what resists the joints' rates, where dry friction makes them other than the dampers.
SLOPES = "resistance"


def factor_sizes(scene: Scene) -> dict[str, int]:
    """Names and sizes of what `factors` writes."""
    sizes = {name: size * scene.links for name, size in FACTORS.items()}
    sizes |= {SLOPES: scene.links} if scene.friction is not None else {}
    sizes |= {CART_PIVOT: 1} if scene.has_free_cart else {}
    return sizes | ({CART_DRAG: 2} if brakes_cart(scene) else {})


def held_slopes(scene: Scene, parameters: Parameters, known: dict[str, ArrayRef]) -> ArrayRef | None:
    """Slopes of what resists the joints' rates; None where nothing does."""
    return known[SLOPES] if scene.friction is not None else parameters.damping


@dataclass(frozen=True)
class _Motion:
    """The unperturbed chain: rates, accelerations, and the pull of each link."""

    sine: ArrayRef
    cosine: ArrayRef
    rate: ArrayRef
    turning: ArrayRef
    pull: ArrayRef


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
    motion = _motion(builder, scene, parameters, q, v, a, out)
    beyond = _Inwards(builder, scene, parameters, gain, motion, out).run()
    if brakes_cart(scene):
        slope = builder.let("cart_slope", cart_slope(scene, parameters, v[0]))
        firm = builder.let("cart_inertia", parameters.cart_mass + beyond.matrix[1][1])
        out[CART_PIVOT][0] = 1 / (firm + gain * slope)
        out[CART_DRAG][0], out[CART_DRAG][1] = slope, firm
    elif scene.has_free_cart:
        out[CART_PIVOT][0] = 1 / (parameters.cart_mass + beyond.matrix[1][1])


def _motion(
    builder: Builder,
    scene: Scene,
    parameters: Parameters,
    q: ArrayRef,
    v: ArrayRef,
    a: ArrayRef,
    out: dict[str, ArrayRef],
) -> _Motion:
    links, offset = scene.links, int(scene.has_cart)
    state = planar_state(builder, scene, q, v)
    builder.sincos_into(out["joint_sine"], out["joint_cosine"], state.angle, links)
    if scene.friction is not None:
        with builder.loop("k", 0, links) as loop:
            out[SLOPES][loop.index] = joint_slope(scene, parameters, loop.index, state.joint_rate[loop.index])
    alpha = absolute(builder, scene, "alpha", a.shifted(offset))
    sine, cosine, let = out["joint_sine"], out["joint_cosine"], builder.let
    inertial_x, inertial_y = builder.array("inertial_x", links), builder.array("inertial_y", links)
    with builder.loop("k", 0, links) as loop:
        k = loop.index
        before_x = loop.carry("base_x", -parameters.fall[1])
        before_y = loop.carry("base_y", a[0] if scene.has_cart else -parameters.fall[0])
        joint_x = let("joint_x", cosine[k] * before_x + sine[k] * before_y)
        joint_y = let("joint_y", cosine[k] * before_y - sine[k] * before_x)
        squared = let("rate_squared", state.rate[k] * state.rate[k])
        inertial_x[k] = parameters.mass[k] * (joint_x - parameters.com[k] * squared)
        inertial_y[k] = parameters.mass[k] * (joint_y + parameters.com[k] * alpha[k])
        out["rate"][k], out["turning"][k] = state.rate[k], alpha[k]
        loop.follow(before_x, joint_x - parameters.length[k] * squared)
        loop.follow(before_y, joint_y + parameters.length[k] * alpha[k])
    with builder.loop("k", links - 1, -1, -1) as loop:
        k = loop.index
        beyond_x, beyond_y = loop.carry("beyond_x", 0), loop.carry("beyond_y", 0)
        out["pull"][k] = parameters.com[k] * inertial_x[k] + parameters.length[k] * beyond_x
        force_x = let("force_x", inertial_x[k] + beyond_x)
        force_y = let("force_y", inertial_y[k] + beyond_y)
        loop.follow(beyond_x, cosine[k] * force_x - sine[k] * force_y)
        loop.follow(beyond_y, sine[k] * force_x + cosine[k] * force_y)
    return _Motion(sine, cosine, out["rate"], out["turning"], out["pull"])


class _Inwards:
    """The elimination from the tip to the base."""

    def __init__(
        self,
        builder: Builder,
        scene: Scene,
        parameters: Parameters,
        gain: Expr,
        motion: _Motion,
        out: dict[str, ArrayRef],
    ) -> None:
        self.builder, self.scene, self.parameters = builder, scene, parameters
        self.gain, self.motion, self.out = gain, motion, out
        self.squared = builder.let("gain_squared", gain * gain)
        self.twice = builder.let("gain_twice", gain + gain)

    def run(self) -> Compound:
        """The chain beyond the base, in the base's frame (down, sideways)."""
        nothing, is_sprung = self.builder.lift(0), transmits(self.scene)
        with self.builder.loop("k", self.scene.links - 1, -1, -1) as loop:
            carried = [loop.carry(name, 0) if is_sprung or name in _FREE else nothing for name in _NAMES]
            following = self.eliminate(Compound.from_flat(carried), loop.index)
            for before, after in zip(carried, following.flat(), strict=True):
                if not before.is_zero:
                    loop.follow(before, after)
        return Compound.from_flat(carried)

    def eliminate(self, beyond: Compound, k: Index) -> Compound:
        """Link k and all beyond it, in the frame of the link before."""
        parameters, out, let = self.parameters, self.out, self.builder.let
        mass, length, com = parameters.mass[k], parameters.length[k], parameters.com[k]
        rate, turning = self.motion.rate[k], self.motion.turning[k]
        axial = let("axial", -(self.squared * turning + self.twice * rate))
        tangential = let("tangential", 1 - self.squared * (rate * rate))
        column = (axial, tangential)
        self._levers(beyond, k)
        overhang = length - com
        body = beyond if self.scene.tip_masses else beyond.shifted(overhang, column)
        held = -(self.squared * self.motion.pull[k])
        if parameters.inertia is not None:
            held = held + parameters.inertia[k]
        body = body.with_mass(mass).stiffened(held).shifted(com, column)
        joint = self.joint_stiffness(k)
        pivot = body.matrix[2][2]
        inverse = let("inverse_pivot", 1 / (pivot + joint))
        for i in range(2):
            out["column"][2 * k + i], out["row"][2 * k + i] = body.matrix[i][2], body.matrix[2][i]
        out["pivot"][3 * k], out["pivot"][3 * k + 1], out["pivot"][3 * k + 2] = pivot, inverse, joint
        behind = body.released(joint, inverse)
        return behind.turned(self.motion.sine[k], self.motion.cosine[k])

    def _levers(self, beyond: Compound, k: Index) -> None:
        """What the constant part c of a link's motion does: m r I + l A, and m r^2 e_y^T + l^2 A_y. + l w^T."""
        parameters, m = self.parameters, beyond.matrix
        mass, length, com = parameters.mass[k], parameters.length[k], parameters.com[k]
        moment = mass * com
        for i in range(2):
            for j in range(2):
                own = length * m[i][j]
                self.out["carried"][4 * k + 2 * i + j] = own + moment if i == j else own
        self.out["arm"][2 * k] = length * (length * m[1][0] + m[2][0])
        self.out["arm"][2 * k + 1] = moment * com + length * (length * m[1][1] + m[2][1])

    def joint_stiffness(self, k: Index) -> Expr:
        """A_k + g d_k + g^2 k_k."""
        parameters = self.parameters
        total = self.builder.lift(0) if parameters.armature is None else parameters.armature[k]
        if parameters.stiffness is not None:
            total = total + self.squared * parameters.stiffness[k]
        slopes = held_slopes(self.scene, parameters, self.out)
        if slopes is not None:
            total = total + self.gain * slopes[k]
        return total


def transmits(scene: Scene) -> bool:
    """Whether joints transmit moments."""
    return ties_links(scene) or scene.armature is not None


_NAMES = (
    *(f"beyond_{i}{j}" for i in "xyz" for j in "xyz"), *(f"adjugate_{i}{j}" for i in "xyz" for j in "xyz"), "determinant",
)  # fmt: skip
#: What a chain of free joints passes on: no moment, so that the adjugate is the determinant of the forces alone.
_FREE = ("beyond_xx", "beyond_xy", "beyond_yx", "beyond_yy", "adjugate_zz")
