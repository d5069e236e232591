"""The right sides of an implicit planar step: one sweep inwards for forces and one outwards for motions (`planar.implicit`)."""

from __future__ import annotations

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.lowering.chain.losses import brakes_cart, ties_links
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.planar.implicit import CART_DRAG, CART_PIVOT, held_slopes, transmits
from phichain.lowering.planar.joints import difference, from_absolute
from phichain.scene import Scene

Pair = tuple[Expr, Expr]


def solution(
    builder: Builder, scene: Scene, parameters: Parameters, gain: Expr, known: dict[str, ArrayRef],
    right: tuple[ArrayRef, ArrayRef], result: tuple[ArrayRef, ArrayRef],
) -> None:  # fmt: skip
    """Write k = (I - g J)^-1 r for the (r_q, r_v) of `right` into the (k_q, k_v) of `result`."""
    _Solution(builder, scene, parameters, gain, known, right).write(*result)


class _Solution:
    """One right side: inwards for forces, outwards for motions."""

    def __init__(
        self, builder: Builder, scene: Scene, parameters: Parameters, gain: Expr, known: dict[str, ArrayRef],
        right: tuple[ArrayRef, ArrayRef],
    ) -> None:  # fmt: skip
        self.builder, self.scene, self.parameters, self.gain, self.known = (
            builder,
            scene,
            parameters,
            gain,
            known,
        )
        self.right_q, self.right_v = right
        offset, links = int(scene.has_cart), scene.links
        self.joint_q = difference(builder, scene, "joint_right_q", self.right_q.shifted(offset))
        self.joint_v = difference(builder, scene, "joint_right_v", self.right_v.shifted(offset))
        self.constant = builder.array("constant", 2 * links)
        self.load = builder.array("load", links)
        self.rest = builder.array("rest", links) if ties_links(scene) else None

    @property
    def slopes(self) -> ArrayRef | None:
        """Slopes of what resists the joints' rates; None where nothing does."""
        return held_slopes(self.scene, self.parameters, self.known)

    def write(self, result_q: ArrayRef, result_v: ArrayRef) -> None:
        scene, builder = self.scene, self.builder
        sideways = self.inwards()
        base = builder.lift(0)
        if scene.has_free_cart:
            base, moved = self._cart(sideways)
            result_v[0] = moved
        elif scene.has_cart:
            result_v[0] = moved = self.right_v[0]
        if scene.has_cart:
            result_q[0] = self.right_q[0] + self.gain * moved
        joints = [builder.array(name, scene.links) for name in ("joint_q", "joint_v")]
        self.outwards(base, *joints)
        for joint, target in zip(joints, (result_q, result_v), strict=True):
            _from_joints(builder, scene, joint, target.shifted(int(scene.has_cart)))

    def _cart(self, sideways: Expr) -> tuple[Expr, Expr]:
        """The cart's x and k_v; where something resists its speed, k_v is formed at once, as at the joints."""
        inverse = self.known[CART_PIVOT][0]
        if not brakes_cart(self.scene):
            base = self.builder.let("cart", -(sideways * inverse))
            return base, self.right_v[0] + self.gain * base
        slope, firm = self.known[CART_DRAG][0], self.known[CART_DRAG][1]
        base = self.builder.let("cart", -((sideways + slope * self.right_v[0]) * inverse))
        return base, (firm * self.right_v[0] - self.gain * sideways) * inverse

    def inwards(self) -> Expr:
        """Forces and moments lambda; returns the sideways force on the base."""
        builder, known, parameters, let = self.builder, self.known, self.parameters, self.builder.let
        links = self.scene.links
        spread = builder.array("spread", links)
        with builder.loop("k", 0, links) as loop:
            spread[loop.index] = self.joint_q[loop.index] + self.gain * self.joint_v[loop.index]
        turn, spin = _summed(builder, links, "turn", spread), _summed(builder, links, "spin", self.joint_v)
        with builder.loop("k", links - 1, -1, -1) as loop:
            k = loop.index
            force = (loop.carry("force_x", 0), loop.carry("force_y", 0))
            moment = loop.carry("moment", 0) if transmits(self.scene) else builder.lift(0)
            rate = known["rate"][k]
            constant = (
                let("constant_x", -(known["turning"][k] * turn[k] + 2 * (rate * spin[k]))),
                let("constant_y", -(rate * rate * turn[k])),
            )
            self.constant[2 * k], self.constant[2 * k + 1] = constant
            own = [
                let("own_force", force[i] + self._product("carried", 2 * k + i, constant)) for i in range(2)
            ]
            load = moment + parameters.length[k] * force[1] - known["pull"][k] * turn[k]
            self.load[k] = load = let("own_load", load + self._product("arm", k, constant))
            rest = self._rest(spread, k)
            pivot, inverse, joint = (known["pivot"][3 * k + i] for i in range(3))
            free = let("free", (load if rest is None else load + rest) * inverse)
            passed = [own[i] - known["column"][2 * k + i] * free for i in range(2)]
            sine, cosine = known["joint_sine"][k], known["joint_cosine"][k]
            loop.follow(force[0], cosine * passed[0] - sine * passed[1])
            loop.follow(force[1], sine * passed[0] + cosine * passed[1])
            if rest is not None:
                loop.follow(moment, (joint * load - pivot * rest) * inverse)
            elif not moment.is_zero:
                loop.follow(moment, joint * load * inverse)
        return force[1]

    def _product(self, name: str, k: Index, vector: Pair) -> Expr:
        """The k-th row of two entries times a vector."""
        return self.known[name][2 * k] * vector[0] + self.known[name][2 * k + 1] * vector[1]

    def _rest(self, spread: ArrayRef, k: Index) -> Expr | None:
        """rho = d r_v + k (r_q + g r_v) of a joint, kept for the way outwards."""
        if self.rest is None:
            return None
        rest = self.builder.lift(0)
        if self.parameters.stiffness is not None:
            rest = self.parameters.stiffness[k] * spread[k]
        if self.slopes is not None:
            rest = rest + self.slopes[k] * self.joint_v[k]
        self.rest[k] = rest = self.builder.let("own_rest", rest)
        return rest

    def outwards(self, base: Expr, joint_q: ArrayRef, joint_v: ArrayRef) -> None:
        builder, known, parameters, let = self.builder, self.known, self.parameters, self.builder.let
        with builder.loop("k", 0, self.scene.links) as loop:
            k = loop.index
            before = (loop.carry("base_x", 0), loop.carry("base_y", base))
            link = loop.carry("link_before", 0)
            sine, cosine = known["joint_sine"][k], known["joint_cosine"][k]
            at = (
                let("joint_x", cosine * before[0] + sine * before[1]), let("joint_y", cosine * before[1] - sine * before[0]),
            )  # fmt: skip
            pivot, inverse = known["pivot"][3 * k], known["pivot"][3 * k + 1]
            acting = let("acting", -(self.load[k] + self._product("row", k, at) + pivot * link))
            turned = acting if self.rest is None else acting - self.rest[k]
            moved = let("link_moved", link + turned * inverse)
            self._results(k, acting, joint_q, joint_v)
            axial = -(self.gain * self.gain * known["turning"][k] + 2 * self.gain * known["rate"][k])
            tangential = 1 - self.gain * self.gain * (known["rate"][k] * known["rate"][k])
            length = parameters.length[k]
            loop.follow(before[0], at[0] + length * (axial * moved + self.constant[2 * k]))
            loop.follow(before[1], at[1] + length * (tangential * moved + self.constant[2 * k + 1]))
            loop.follow(link, moved)

    def _results(self, k: Index, acting: Expr, joint_q: ArrayRef, joint_v: ArrayRef) -> None:
        """k_v and k_q of a joint, without what its spring and damper cancel."""
        gain, pivot, inverse = self.gain, self.known["pivot"][3 * k], self.known["pivot"][3 * k + 1]
        right_q, right_v, stiffness, slopes = (
            self.joint_q[k],
            self.joint_v[k],
            self.parameters.stiffness,
            self.slopes,
        )
        if self.rest is None:
            joint_v[k] = moved = self.builder.let("joint_rate", right_v + gain * (acting * inverse))
            joint_q[k] = right_q + gain * moved
            return
        if self.parameters.armature is not None:
            pivot = self.builder.let("borne", pivot + self.parameters.armature[k])
        driven = self.builder.let("driven", pivot * right_v + gain * acting)
        slowed = driven if stiffness is None else driven - gain * (stiffness[k] * right_q)
        joint_v[k] = slowed * inverse
        held = pivot if slopes is None else pivot + gain * slopes[k]
        joint_q[k] = (held * right_q + gain * driven) * inverse


def _summed(builder: Builder, links: int, name: str, joint: ArrayRef) -> ArrayRef:
    """Absolute values of joint values."""
    total = builder.array(name, links)
    with builder.loop("k", 0, links) as loop:
        before = loop.carry(f"{name}_before", 0)
        total[loop.index] = value = builder.let(f"{name}_here", before + joint[loop.index])
        loop.follow(before, value)
    return total


def _from_joints(builder: Builder, scene: Scene, joint: ArrayRef, theta: ArrayRef) -> None:
    """The scene's own angles of joint values, written into the cells of `theta`."""
    if scene.angles == "relative":
        with builder.loop("k", 0, scene.links) as loop:
            theta[loop.index] = joint[loop.index]
        return
    from_absolute(builder, scene, _summed(builder, scene.links, f"absolute_{joint.name}", joint), theta)
