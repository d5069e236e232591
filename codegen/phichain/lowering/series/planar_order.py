"""The back substitution of one order of a planar step (lowering.series.planar)."""

from __future__ import annotations

from fractions import Fraction
from typing import ClassVar

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.ir.nodes import Program
from phichain.ir.passes import prune
from phichain.lowering.chain.body import point_masses
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.chain.planar_links import PlanarLinks
from phichain.lowering.chain.units import units_of_links
from phichain.lowering.planar.joints import difference
from phichain.lowering.series.dry import KINDS, Dry, places
from phichain.lowering.series.held import Layout
from phichain.lowering.series.series import COEFFICIENT, HELD, LEFT, NEWEST, NEXT, NOW, RIGHT, SUMS
from phichain.mechanics import Model
from phichain.scene import Scene


def planar_order(model: Model, layout: Layout, substitution: type[Order]) -> Program:
    """Solve for the coefficients of order n + 1, by the kind of `Order` that goes with the factorisation."""
    scene = point_masses(model.scene)
    builder = Builder("flow_order", "Solve for the coefficients of order n + 1 of the Taylor series.")
    parameters = Parameters(builder, model, units_of_links(scene), scene)
    held = builder.input(HELD, (layout.size,), "constants of the step")
    rubbing = places(scene)
    sums = builder.input(SUMS, (4 * scene.links + 2 * rubbing,), "sums of products of known coefficients")
    width = 2 * scene.links + KINDS * rubbing
    newest = builder.input(NEWEST, (width,), "row n of left") if rubbing else None
    coefficient = builder.input(COEFFICIENT, (scene.nq + scene.nv,), "coefficients of order n of the state")
    now = builder.input(NOW, (4,), "n + 1, 1 / (n + 1), 1 / ((n + 1) (n + 2)), and whether n = 0")
    left = builder.output(LEFT, (width,), "coefficients n + 2 of the links' cosines and sines")
    right = builder.output(RIGHT, (4 * scene.links,), "the links' rates, twice, and moments of force")
    following = builder.output(NEXT, (scene.nq + scene.nv,), "coefficients of order n + 1 of the state")
    substitution(builder, scene, parameters, layout, held, now, newest).write(sums, coefficient, left, right, following)
    return prune(builder.finish())


class Order:
    """The back substitution: beside the chain first, along it inwards, outwards, and beside it again."""

    WORK: ClassVar[tuple[str, ...]] = (
        "bend", "torque", "push_x", "push_y", "free", "lift_x", "lift_y", "pulled", "turn", "rise",
    )  # fmt: skip
    """Names of the work arrays."""

    def __init__(
        self, builder: Builder, scene: Scene, parameters: Parameters, layout: Layout, held: ArrayRef, now: ArrayRef,
        newest: ArrayRef | None = None,
    ) -> None:
        self.builder, self.scene, self.parameters, self.layout, self.now = builder, scene, parameters, layout, now
        self.held, self.newest, self.dry = held, newest, Dry(builder, scene, layout, held, 2 * scene.links)
        self.speed: Expr | None = None
        self.work = {name: builder.array(name, scene.links) for name in self.WORK}
        if "own_moment" in layout:
            self.moment, self.own = layout.of(held, "own_moment"), layout.of(held, "second_moment")
        else:
            links = PlanarLinks(parameters)
            self.moment, self.own = links.moment, links.own

    def of(self, name: str) -> ArrayRef:
        """Where a quantity's numbers begin; zero everywhere where the scene has none."""
        if name in self.layout:
            return self.layout.of(self.held, name)
        return self.builder.constants(name, [Fraction(0)] * self.scene.links)

    def write(self, sums: ArrayRef, coefficient: ArrayRef, left: ArrayRef, right: ArrayRef, following: ArrayRef) -> None:
        """All cells of the results."""
        self.moments(sums, coefficient)
        force = self.inwards()
        self.outwards(self.base(force, coefficient, following), left, right)
        self.state(coefficient, following)
        self.rub(sums, left)

    def moments(self, sums: ArrayRef, coefficient: ArrayRef) -> None:
        """What is known of each link: C'', the moment about its joint, what both add to the force there and to its own acceleration."""
        builder, links, now = self.builder, self.scene.links, self.now
        bend, rise, torque, push_x, push_y, free = (
            self.work[name] for name in ("bend", "rise", "torque", "push_x", "push_y", "free")
        )
        couple = self.couple(coefficient)
        with builder.loop("k", 0, links) as loop:
            k = loop.index
            bend[k] = bent = -(now[0] * sums[k + links])
            rise[k] = risen = now[0] * sums[k]
            known = -(sums[k + 2 * links] + sums[k + 3 * links])
            torque[k] = left = builder.let("left_torque", known if couple is None else couple[k] + known)
            moment = builder.let("moment", left + self.own[k] * risen)
            push_x[k] = self.of("axial")[k] * bent + self.of("gain_x")[k] * moment
            push_y[k] = self.of("gain_y")[k] * moment - self.of("skew")[k] * bent
            free[k] = self.of("inverse")[k] * left - self.of("lag")[k] * risen

    def couple(self, coefficient: ArrayRef) -> ArrayRef | None:
        """Torques on the links of order n: inputs, springs, dampers and dry friction; None where there are none."""
        builder, links, drive = self.builder, self.scene.links, self.drive()
        if drive is None and not self.is_tied():
            return None
        pull = self.passive(coefficient)
        couple = builder.array("couple", links)

        def on(k: Index, beyond: Expr) -> Expr:
            total = pull[k] - beyond
            return total if drive is None else total + self.now[3] * drive[k]

        with builder.loop("k", 0, links - 1) as loop:
            couple[loop.index] = on(loop.index, pull[loop.index + 1])
        couple[links - 1] = on(links - 1, builder.lift(0))
        return couple

    def drive(self) -> ArrayRef | None:
        """What inputs do; None where no joint is actuated."""
        return self.layout.of(self.held, "drive") if "drive" in self.layout else None

    def is_tied(self) -> bool:
        """Whether springs, dampers or dry friction act across the joints."""
        return "stiffness" in self.layout or "damping" in self.layout or self.scene.friction is not None

    def passive(self, coefficient: ArrayRef) -> ArrayRef:
        """Torques across the joints of order n: springs, dampers and dry friction."""
        builder, scene, links = self.builder, self.scene, self.scene.links
        stiffness, damping = (
            self.layout.of(self.held, name) if name in self.layout else None for name in ("stiffness", "damping")
        )
        rubbed = self.newest if scene.friction is not None else None
        angles, rates = coefficient.shifted(int(scene.has_cart)), coefficient.shifted(scene.nq + int(scene.has_cart))
        pull = builder.array("pull", links)
        angle = difference(builder, scene, "joint_angle", angles) if stiffness is not None else angles
        rate = difference(builder, scene, "joint_rate", rates) if damping is not None else rates
        with builder.loop("k", 0, links) as loop:
            k = loop.index
            total = builder.lift(0)
            if stiffness is not None:
                total = total - stiffness[k] * self.bend(angle[k], k)
                if "rest" in self.layout:
                    total = total - self.now[3] * self.of("rest")[k]
            if damping is not None:
                total = total - damping[k] * rate[k]
            if rubbed is not None:
                total = total - self.dry.saturated(rubbed, k)
            pull[k] = total
        return pull

    def bend(self, angle: Expr, k: Index) -> Expr:
        """What the spring of joint k sees at this order: where it rests is constant in time."""
        rest = self.of("rest_angle") if "rest_angle" in self.layout else self.parameters.rest_angle
        return angle if rest is None else angle - self.now[3] * rest[k]

    def inwards(self) -> tuple[Expr, Expr]:
        """Forces of order n that the chain beyond each joint asks for, and what they leave of each link's free angular acceleration,
        how far that and C'' move the next joint, and the force at that joint along the link.

        All of it in one loop: what another one read as vectors would wait until every number had arrived in memory. Gives the force at the
        first joint.
        """
        builder, work, last, length = self.builder, self.work, self.scene.links - 1, self.parameters.length
        push_x, push_y, free, rise, bend = (work[name] for name in ("push_x", "push_y", "free", "rise", "bend"))
        if last == 0:
            return push_x[0], push_y[0]
        with builder.loop("k", last - 1, -1, -1) as loop:
            k = loop.index
            x, y = loop.carry("carried_x", push_x[last]), loop.carry("carried_y", push_y[last])
            free[k] = apart = builder.let("free_k", free[k] - self.of("arm_x")[k] * x - self.of("arm_y")[k] * y)
            along, across = length[k] * bend[k], length[k] * (apart + rise[k])
            work["lift_x"][k] = self.of("sine")[k + 1] * across + self.of("q_xx")[k] * along
            work["lift_y"][k] = self.of("cosine")[k + 1] * across + self.of("q_xy")[k] * along
            work["pulled"][k] = self.of("cosine")[k + 1] * x - self.of("sine")[k + 1] * y
            inner_x = (push_x[k] + self.of("q_xx")[k] * x) + self.of("q_xy")[k] * y
            inner_y = (push_y[k] + self.of("q_yx")[k] * x) + self.of("q_yy")[k] * y
            loop.follow(x, inner_x)
            loop.follow(y, inner_y)
        return x, y

    def outwards(self, base: tuple[Expr, Expr], left: ArrayRef, right: ArrayRef) -> None:
        """Accelerations of the joints less gravity, in the links' frames, the links' own, and with them their directions, rates and moments of
        the forces: less what a mass on its own circle needs, which has none."""
        builder, last = self.builder, self.scene.links - 1
        lateral, axial, lift_x, lift_y = right.shifted(2 * (last + 1)), right.shifted(3 * (last + 1)), self.work["lift_x"], self.work["lift_y"]
        if last:
            with builder.loop("k", 0, last) as loop:
                k = loop.index
                x, y = loop.carry("joint_x", base[0]), loop.carry("joint_y", base[1])
                outer_x = (lift_x[k] + self.of("q_yx")[k] * y) + self.of("q_xx")[k] * x
                outer_y = (lift_y[k] + self.of("q_yy")[k] * y) + self.of("q_xy")[k] * x
                swing = self.row(k, x, y, left, right)
                lateral[k] = self.work["torque"][k] - self.own[k] * swing
                pull = (self.work["pulled"][k] + self.of("pull_y")[k + 1] * outer_y) + self.of("pull_x")[k + 1] * outer_x
                axial[k] = -(self.moment[k] * x + self.parameters.length[k] * pull)
                loop.follow(x, outer_x)
                loop.follow(y, outer_y)
            base = x, y
        self.row(last, *base, left, right)
        lateral[last], axial[last] = self.moment[last] * base[1], -(self.moment[last] * base[0])

    def row(self, k: Index, x: Expr, y: Expr, left: ArrayRef, right: ArrayRef) -> Expr:
        """A link's angular acceleration but for what turning makes of it, and with it its direction and rate."""
        links, now, work, gain_x = self.scene.links, self.now, self.work, self.of("gain_x")[k]
        still = work["free"][k] - gain_x * (self.parameters.length[k] * work["bend"][k])
        swing = self.builder.let("angular", still - gain_x * x - self.of("gain_y")[k] * y)
        work["turn"][k] = rate = self.builder.let("rate", now[1] * swing)
        left[k], left[k + links] = now[2] * work["bend"][k], now[2] * (swing + work["rise"][k])
        right[k], right[k + links] = rate, rate
        return swing

    def base(self, force: tuple[Expr, Expr], coefficient: ArrayRef, following: ArrayRef) -> tuple[Expr, Expr]:
        """Acceleration of the base less gravity in the first link's frame; a cart's goes into the results."""
        scene, now, base = self.scene, self.now, self.of("base")
        weight_x, weight_y = now[3] * base[0], now[3] * base[1]
        if scene.is_driven:
            following[scene.nq] = now[1] * (now[3] * self.of("push")[0]) * self.parameters.units.length
        if not scene.has_free_cart:
            return weight_x, weight_y
        sine, cosine, arm = self.of("sine")[0], self.of("cosine")[0], self.of("base_arm")
        push = -(sine * force[0] + cosine * force[1])
        if scene.has_force:
            push = now[3] * self.of("push")[0] + push
        if "cart_damping" in self.layout:
            push = push - self.of("cart_damping")[0] * coefficient[scene.nq]
        if self.dry.cart is not None and self.newest is not None:
            push = push - self.dry.saturated(self.newest, self.dry.cart)
        free = self.builder.let("cart_free", arm[0] * push)
        acceleration = now[1] * (free + now[3] * arm[1])
        following[scene.nq] = self.cart_rate(acceleration * self.parameters.units.length)
        return weight_x + sine * free, weight_y + cosine * free

    def cart_rate(self, rate: Expr) -> Expr:
        """A coefficient of the cart's speed, noted where its friction asks for it."""
        if self.dry.cart is not None:
            self.speed = rate = self.builder.let("cart_rate", rate)
        return rate

    def slips(self) -> ArrayRef:
        """Coefficients n + 1 of the joints' rates."""
        rate, turn = self.builder.array("slip_rate", self.scene.links), self.work["turn"]
        rate[0] = turn[0]
        if self.scene.links > 1:
            with self.builder.loop("k", 1, self.scene.links) as loop:
                rate[loop.index] = turn[loop.index] - turn[loop.index - 1]
        return rate

    def rub(self, sums: ArrayRef, left: ArrayRef) -> None:
        """What dry friction is at the next order."""
        if self.dry.count:
            rate = self.slips() if self.scene.friction is not None else None
            self.dry.follow(self.now, sums.shifted(4 * self.scene.links), rate, self.speed, left)

    def state(self, coefficient: ArrayRef, following: ArrayRef) -> None:
        """The state's coefficients of order n + 1."""
        builder, scene = self.builder, self.scene
        with builder.loop("i", 0, scene.nq) as loop:
            following[loop.index] = self.now[1] * coefficient[loop.index + scene.nq]
        own = from_links(builder, scene, "own_rate", self.work["turn"])
        with builder.loop("k", 0, scene.links) as loop:
            following[loop.index + scene.nq + int(scene.has_cart)] = own[loop.index]


def from_links(builder: Builder, scene: Scene, name: str, rate: ArrayRef) -> ArrayRef:
    """theta' = S^-1 phi'."""
    if scene.angles == "absolute":
        return rate
    own = builder.array(name, scene.links)
    own[0] = rate[0]
    with builder.loop("k", 1, scene.links) as loop:
        if scene.angles == "relative":
            own[loop.index] = rate[loop.index] - rate[loop.index - 1]
            return own
        before = loop.carry("before", rate[0])
        value = rate[loop.index] - before
        own[loop.index] = value
        loop.follow(before, value)
    return own
