"""The back substitution of one order of a planar step whose joints carry rotors (lowering.planar.geared).

With slip_n the relative angular acceleration of joint k, the moment balance of `lowering.series.planar` becomes

    Hy_n + A_k slip_{k,n} - A_{k+1} slip_{k+1,n} + sum_{j=0..n-1} (C_{j+1} Hy_{n-1-j} - S_{j+1} Hx_{n-1-j}) = tau_n

whose couples are linear in what is solved for: one factorisation a step serves every order here, too.
"""

from __future__ import annotations

from typing import ClassVar

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.planar.geared.substitution import Substitution
from phichain.lowering.planar.geared.torques import Torques
from phichain.lowering.series.held import Layout
from phichain.lowering.series.planar_order import Order, from_links
from phichain.scene import Scene


class GearedOrder(Order):
    """The substitutions with rotors; what is beside the chain is that of any planar chain."""

    WORK: ClassVar[tuple[str, ...]] = ("bend", "torque", "turn", "rise")

    def __init__(
        self, builder: Builder, scene: Scene, parameters: Parameters, layout: Layout, held: ArrayRef, now: ArrayRef,
        newest: ArrayRef | None = None,
    ) -> None:
        super().__init__(builder, scene, parameters, layout, held, now, newest)
        self.drives_joints = scene.angles == "relative" and self.drive() is not None
        self.has_joint_torques = self.is_tied() or self.drives_joints
        self.substitution = Substitution(builder, parameters, self.of, feels=self.has_joint_torques)
        self.work |= self.substitution.work

    def write(self, sums: ArrayRef, coefficient: ArrayRef, left: ArrayRef, right: ArrayRef, following: ArrayRef) -> None:
        """All cells of the results."""
        bend, rise = self.work["bend"], self.work["rise"]
        self.moments(sums, coefficient)
        joint = self.joint_torques(coefficient) if self.has_joint_torques else None
        self.substitution.inwards(Torques(self.work["torque"], joint), bend, rise)
        push = self.now[3] * self.of("push")[0] if self.scene.has_force else None
        if self.scene.is_driven and push is not None:
            following[self.scene.nq] = self.now[1] * push * self.parameters.units.length
        if "cart_damping" in self.layout:
            drag = self.of("cart_damping")[0] * coefficient[self.scene.nq]
            push = -drag if push is None else push - drag
        if self.dry.cart is not None and self.newest is not None:
            rubbed = self.dry.saturated(self.newest, self.dry.cart)
            push = -rubbed if push is None else push - rubbed
        base, cart = self.substitution.base(push, self.scene.has_free_cart, self.now[3])
        if self.scene.has_free_cart:
            following[self.scene.nq] = self.cart_rate(self.now[1] * cart * self.parameters.units.length)
        self.substitution.outwards(base, bend, rise)
        self.rows(left, right)
        self.arms(right)
        self.state(coefficient, following)
        self.rub(sums, left)

    def slips(self) -> ArrayRef:
        """Coefficients n + 1 of the joints' rates, formed at once."""
        rate = self.builder.array("slip_rate", self.scene.links)
        with self.builder.loop("k", 0, self.scene.links) as loop:
            rate[loop.index] = self.now[1] * self.work["slip"][loop.index]
        return rate

    def moments(self, sums: ArrayRef, coefficient: ArrayRef) -> None:
        """What is known of each link: C'', S'' beside turning, and the moment about its joint but for what acts across joints."""
        builder, links, now = self.builder, self.scene.links, self.now
        drive = None if self.drives_joints else self.drive()
        with builder.loop("k", 0, links) as loop:
            k = loop.index
            self.work["bend"][k] = -(now[0] * sums[k + links])
            self.work["rise"][k] = now[0] * sums[k]
            known = -(sums[k + 2 * links] + sums[k + 3 * links])
            self.work["torque"][k] = known if drive is None else now[3] * drive[k] + known

    def joint_torques(self, coefficient: ArrayRef) -> ArrayRef:
        """Torques across the joints of order n: springs, dampers, dry friction, and inputs where angles are relative."""
        drive = self.drive() if self.drives_joints else None
        if drive is None:
            return self.passive(coefficient)
        passive = self.passive(coefficient) if self.is_tied() else None
        joint = self.builder.array("joint_torque", self.scene.links)
        with self.builder.loop("k", 0, self.scene.links) as loop:
            driven = self.now[3] * drive[loop.index]
            joint[loop.index] = driven if passive is None else passive[loop.index] + driven
        return joint

    def rows(self, left: ArrayRef, right: ArrayRef) -> None:
        """The links' directions and rates."""
        links, now, work = self.scene.links, self.now, self.work
        with self.builder.loop("k", 0, links) as loop:
            k = loop.index
            work["turn"][k] = rate = self.builder.let("rate", now[1] * work["swing"][k])
            left[k], left[k + links] = now[2] * work["bend"][k], now[2] * (work["swing"][k] + work["rise"][k])
            right[k], right[k + links] = rate, rate

    def arms(self, right: ArrayRef) -> None:
        """Moments of the forces at the links, less what a mass on its own circle needs, which has none."""
        builder, last, length = self.builder, self.scene.links - 1, self.parameters.length
        joint_x, joint_y = self.work["joint_x"], self.work["joint_y"]
        lateral, axial = right.shifted(2 * (last + 1)), right.shifted(3 * (last + 1))
        with builder.loop("k", 0, last) as loop:
            k = loop.index
            lateral[k] = self.borne(k)
            axial[k] = -(self.moment[k] * joint_x[k] + length[k] * self.tip_force(k + 1))
        lateral[last], axial[last] = self.moment[last] * joint_y[last], -(self.moment[last] * joint_x[last])

    def borne(self, k: Index) -> Expr:
        """The moment of the forces at link k: what is left of the torques on it."""
        torque, turning = self.work["torque"][k], self.work["swing"][k]
        if self.has_joint_torques:
            return (torque - self.own[k] * turning) + (self.work["felt"][k] - self.work["felt"][k + 1])
        armature, slip = self.parameters.armature, self.work["slip"]
        assert armature is not None
        rotors = armature[k] * slip[k] - armature[k + 1] * slip[k + 1]
        return (torque - self.own[k] * turning) - rotors

    def tip_force(self, k: Index) -> Expr:
        """The force at joint k along the link before."""
        work = self.work
        pull = self.of("cosine")[k] * work["force_x"][k] - self.of("sine")[k] * work["force_y"][k]
        held = (pull + self.of("pull_y")[k] * work["joint_y"][k]) + self.of("pull_x")[k] * work["joint_x"][k]
        return held + self.of("pull_n")[k] * work["swing"][k - 1]

    def state(self, coefficient: ArrayRef, following: ArrayRef) -> None:
        """The state's coefficients of order n + 1; rates of joints are formed at once, not as differences."""
        builder, scene = self.builder, self.scene
        with builder.loop("i", 0, scene.nq) as loop:
            following[loop.index] = self.now[1] * coefficient[loop.index + scene.nq]
        is_relative = scene.angles == "relative"
        own = self.work["slip"] if is_relative else from_links(builder, scene, "own_rate", self.work["turn"])
        with builder.loop("k", 0, scene.links) as loop:
            rate = self.now[1] * own[loop.index] if is_relative else own[loop.index]
            following[loop.index + scene.nq + int(scene.has_cart)] = rate
