"""The factorisation of a planar step: everything that is constant over it (lowering.series.planar)."""

from __future__ import annotations

from dataclasses import dataclass

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.ir.nodes import Program
from phichain.ir.passes import prune
from phichain.lowering.chain.base import carried
from phichain.lowering.chain.body import point_masses
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.chain.planar_links import PlanarLinks
from phichain.lowering.chain.units import units_of_links
from phichain.lowering.planar.joint_state import rest_of_difference
from phichain.lowering.planar.joints import absolute, difference, input_couples
from phichain.lowering.series.dry import KINDS, Dry, places
from phichain.lowering.series.held import Layout
from phichain.lowering.series.series import HELD, LEFT, LOST, RIGHT, SCALE
from phichain.mechanics import Model
from phichain.scene import Scene


@dataclass(frozen=True)
class _Inertia:
    """A chain from a joint on, in the frame of its first link: A = [xx xy; xy yy], E = det A in the place of yy."""

    xx: Expr
    xy: Expr
    determinant: Expr


@dataclass(frozen=True)
class _Turned:
    """The same seen along and across another direction: the joint's tangent and axis in the first link's frame."""

    across: Expr  # e = X s + Z c
    mixed: Expr  # c Y + s Z
    xx: Expr
    xy: Expr
    yy: Expr


def directions(builder: Builder, scene: Scene, q: ArrayRef, lost: ArrayRef) -> tuple[ArrayRef, ArrayRef]:
    """Sines and cosines of the joints' angles q + lost, to the digits that q alone does not hold."""
    angle = difference(builder, scene, "joint_angle", q)
    rest = difference(builder, scene, "joint_rest", lost)
    near_sine, near_cosine = builder.sincos(angle, scene.links)
    sine, cosine = builder.array("joint_sine", scene.links), builder.array("joint_cosine", scene.links)
    with builder.loop("k", 0, scene.links) as loop:
        k = loop.index
        sine[k] = near_sine[k] + near_cosine[k] * rest[k]
        cosine[k] = near_cosine[k] - near_sine[k] * rest[k]
    return sine, cosine


def planar_factor(model: Model, layout: Layout, elimination: type[Factor]) -> Program:
    """Everything that is constant over a step, and rows 0, by one kind of `Factor`."""
    scene = point_masses(model.scene)
    builder = Builder("flow_factor", "Factor the mass matrix at the start of a step.")
    parameters = Parameters(builder, model, units_of_links(scene), scene)
    q, v = builder.input("q", (scene.nq,), "configuration"), builder.input("v", (scene.nv,), "rates in scaled time")
    u = builder.input("u", (scene.nu,), "inputs") if scene.nu else None
    parameters = carried(builder, scene, parameters, u).parameters
    scale = builder.input(SCALE, (2,), "unit of time and its square")
    lost = builder.input(LOST, (scene.nq + scene.nv,), "what rounding took from q and v")
    held = builder.output(HELD, (layout.size,), "constants of the step")
    left = builder.output(LEFT, (2 * scene.links + KINDS * places(scene),), "coefficients 1 of the links' cosines and sines")
    right = builder.output(RIGHT, (4 * scene.links,), "the links' rates, twice, and zeros")
    elimination(builder, scene, parameters, layout, held, scale).write(q, lost, u)
    rate = absolute(builder, scene, "rate", v.shifted(int(scene.has_cart)))
    with builder.loop("k", 0, scene.links) as loop:
        k = loop.index
        left[k], left[k + scene.links] = builder.lift(0), rate[k]
        right[k], right[k + scene.links] = rate[k], rate[k]
        right[k + 2 * scene.links], right[k + 3 * scene.links] = builder.lift(0), builder.lift(0)
    if places(scene):
        slip = None if scene.friction is None else difference(builder, scene, "joint_rate", v.shifted(int(scene.has_cart)))
        dry = Dry(builder, scene, layout, held, 2 * scene.links)
        dry.begin(parameters, scale, slip, v[0] if scene.has_cart else None, left)
    return prune(builder.finish())


class Factor:
    """The elimination from the tip to the base."""

    def __init__(
        self, builder: Builder, scene: Scene, parameters: Parameters, layout: Layout, held: ArrayRef, scale: ArrayRef
    ) -> None:
        self.builder, self.scene, self.parameters, self.layout = builder, scene, parameters, layout
        self.held, self.rho, self.square = held, scale[0], scale[1]
        self.links = PlanarLinks(parameters)

    def keep(self, name: str, k: Index, value: Expr) -> None:
        """Store a number of link k where the scene has a place for it."""
        if name in self.layout:
            self.layout.of(self.held, name)[k] = value

    def write(self, q: ArrayRef, lost: ArrayRef, u: ArrayRef | None) -> None:
        """All numbers of `held`."""
        builder, scene, links, parameters = self.builder, self.scene, self.scene.links, self.parameters
        offset = int(scene.has_cart)
        self.sine, self.cosine = directions(builder, scene, q.shifted(offset), lost.shifted(offset))
        inertia, last = self.tip(links - 1), links - 1
        if parameters.bodies is not None and last:
            # a rigid link that is held at its centre of mass has no force at its joint to divide by
            last -= 1
            inertia = self.link(inertia, last)
        if last:
            with builder.loop("k", last - 1, -1, -1) as loop:
                parts = {"xx": inertia.xx, "xy": inertia.xy, "determinant": inertia.determinant}
                moving = {"xx"} if scene.tip_masses else set(parts)
                carried = {name: loop.carry(f"beyond_{name}", parts[name]) for name in parts if name in moving}
                known = {name: carried.get(name, value) for name, value in parts.items()}
                after = self.link(_Inertia(**known), loop.index)
                for name, value in carried.items():
                    loop.follow(value, getattr(after, name))
            inertia = _Inertia(**known)
        self.base(inertia)
        self.inputs(u)
        self.hold_moments()
        if "rest" in self.layout:
            self.rests(q, lost)

    def hold_moments(self) -> None:
        """Moments of rigid links that come at run time, for the orders."""
        if "own_moment" in self.layout:
            with self.builder.loop("k", 0, self.scene.links) as loop:
                self.keep("own_moment", loop.index, self.links.moment[loop.index])
                self.keep("second_moment", loop.index, self.links.own[loop.index])

    def turned(self, beyond: _Inertia, k: Index) -> _Turned:
        """The chain from joint k on, in the frame of the link before."""
        let, s, c = self.builder.let, self.sine[k], self.cosine[k]
        if beyond.xy.is_zero and beyond.determinant.is_zero:
            across, along = let("across", beyond.xx * s), let("along", beyond.xx * c)
            self.keep("pull_x", k, along)
            self.keep("pull_y", k, self.builder.lift(0))
            return _Turned(across, self.builder.lift(0), along * c, along * s, across * s)
        inverse = let("inverse_axial", 1 / beyond.xx)
        across, along = let("across", beyond.xx * s + beyond.xy * c), let("along", beyond.xx * c - beyond.xy * s)
        self.keep("pull_x", k, along)
        rest_s, rest_c = let("rest_s", s * beyond.determinant), let("rest_c", c * beyond.determinant)
        self.keep("pull_y", k, (along * beyond.xy - rest_s) * inverse)
        return _Turned(
            across=across,
            mixed=let("mixed", (across * beyond.xy + rest_c) * inverse),
            xx=let("turned_xx", (along * along + s * rest_s) * inverse),
            xy=let("turned_xy", (across * along - s * rest_c) * inverse),
            yy=let("turned_yy", (across * across + c * rest_c) * inverse),
        )

    def tip(self, k: Index) -> _Inertia:
        """The last link: a point mass beyond which there is nothing."""
        (inverse, moment, gain), zero = self.links.alone(k), self.builder.lift(0)
        self.keep("sine", k, self.sine[k])
        self.keep("cosine", k, self.cosine[k])
        self.keep("inverse", k, inverse)
        self.keep("axial", k, moment)
        self.keep("gain_y", k, gain)
        for name in ("lag", "skew", "gain_x", "q_xx", "q_xy", "q_yx", "q_yy", "arm_x", "arm_y"):
            self.keep(name, k, zero)
        return _Inertia(self.links.mass[k], zero, zero)

    def link(self, beyond: _Inertia, k: Index) -> _Inertia:
        """Eliminate the rotation of link k; the chain from its joint on."""
        let, parameters, scene = self.builder.let, self.parameters, self.scene
        mass, length = self.links.mass[k], parameters.length[k]
        s, c, outer = self.sine[k + 1], self.cosine[k + 1], self.turned(beyond, k + 1)
        own, moment = self.links.own[k], self.links.moment[k]
        square = parameters.derived("length_square", lambda k: parameters.length[k] * parameters.length[k])[k]
        inverse = let("inverse_pivot", 1 / (own + square * outer.yy))
        shift = let("shift", (own * outer.xx + square * beyond.determinant) * inverse)
        gain_x = let("gain_x", length * outer.xy * inverse)
        for name, value in (
            ("q_xx", (own * c + square * outer.mixed) * inverse),
            ("q_xy", -((own * s + square * outer.across) * inverse)),
            ("axial", moment + length * shift), ("gain_x", gain_x), ("gain_y", (moment + length * outer.yy) * inverse),
            ("inverse", inverse), ("lag", square * outer.yy * inverse), ("arm_x", length * s * inverse), ("arm_y", length * c * inverse),
            ("sine", self.sine[k]), ("cosine", self.cosine[k]),
        ):  # fmt: skip
            self.keep(name, k, value)
        xx = let("link_xx", mass + shift)
        if scene.tip_masses:
            zero = self.builder.lift(0)
            return _Inertia(xx, zero, zero)
        kappa = let("kappa", self.links.lever[k] * inverse)
        overhang = self.links.overhang[k]
        xy, zero = let("link_xy", -(kappa * outer.xy)), self.builder.lift(0)
        self.keep("q_yx", k, -(kappa * s))
        self.keep("q_yy", k, -(kappa * c))
        self.keep("skew", k, kappa * (length * outer.xy))
        determinant = kappa * (overhang * (mass * outer.yy + beyond.determinant))
        return _Inertia(xx, xy, let("link_determinant", determinant))

    def base(self, inertia: _Inertia) -> None:
        """Gravity and, on a cart, its mobility."""
        aside, weight = (-(self.square * entry) for entry in self.parameters.fall)
        s, c = self.sine[0], self.cosine[0]
        if not self.scene.has_free_cart:
            self.keep("base", 0, weight * c + aside * s)
            self.keep("base", 1, aside * c - weight * s)
            self.keep("pull_x", 0, self.builder.lift(0))
            self.keep("pull_y", 0, self.builder.lift(0))
            return
        mass, outer = self.parameters.base_mass, self.turned(inertia, 0)
        inverse = self.builder.let("mobility", 1 / (mass + outer.yy))
        scaled = weight * inverse
        self.keep("base", 0, scaled * (mass * c + outer.mixed))
        self.keep("base", 1, -(scaled * (mass * s + outer.across)))
        self.keep("base_arm", 0, inverse)
        self.keep("base_arm", 1, -(scaled * outer.xy))

    def inputs(self, u: ArrayRef | None) -> None:
        """Inputs, springs and dampers in scaled time; the cart's damper takes speeds in the scene's own unit of length."""
        builder, scene, parameters = self.builder, self.scene, self.parameters
        if scene.has_force and u is not None:
            unit = parameters.units.length if scene.is_driven else parameters.units.force
            self.keep("push", 0, self.square * (u[0] / unit))
        if "cart_damping" in self.layout and parameters.cart_damping is not None:
            self.keep("cart_damping", 0, self.rho * (parameters.cart_damping / parameters.units.length))
        couple = self.driven(u)
        with builder.loop("k", 0, scene.links) as loop:
            k = loop.index
            if couple is not None:
                self.keep("drive", k, self.square * couple[k])
            if parameters.stiffness is not None:
                self.keep("stiffness", k, self.square * parameters.stiffness[k])
            if parameters.rest_angle is not None:
                self.keep("rest_angle", k, parameters.rest_angle[k])
            if parameters.damping is not None:
                self.keep("damping", k, self.rho * parameters.damping[k])

    def driven(self, u: ArrayRef | None) -> ArrayRef | None:
        """What inputs do, as the orders take it: torques on the links."""
        return input_couples(self.builder, self.scene, self.parameters, u)

    def rests(self, q: ArrayRef, lost: ArrayRef) -> None:
        """Torques of the joints' springs for what the rounded differences of the angles leave out of them."""
        offset, stiffness = int(self.scene.has_cart), self.parameters.stiffness
        assert stiffness is not None
        rest = rest_of_difference(self.builder, self.scene, "spring_rest", q.shifted(offset), lost.shifted(offset))
        with self.builder.loop("k", 0, self.scene.links) as loop:
            self.keep("rest", loop.index, self.square * stiffness[loop.index] * rest[loop.index])
