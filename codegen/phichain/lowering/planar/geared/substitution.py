"""The substitutions that go with `elimination`: forces and moments inwards, accelerations outwards.

Link k, whose direction bends by C'' and rises by S'' - w' beside turning, with the torque t on it, the torque j across its joint, and
p = (p_x, p_y, p_n) asked for by the chain beyond, turns by

    free = (j + t - p_n) / D - drag,   drag = lag rise + l (s p_x + c p_y) / D,    drawn = free - gain.(a + (l C'', 0)),
    alpha = drawn + (A / D) alpha_before,                    slip = alpha - alpha_before = drawn - (P / D) alpha_before

where slip is formed at once: behind a large rotor it is small, and A slip is the couple across the joint. The link before feels -j + A slip
there. p_n is what of this hangs on nothing, j among it: with rest = t - p_n beyond,

    p_n' = j - A (free - gain_x l C'') = (P / D) j - (A / D) rest + A (drag + gain_x l C''),
    j - A slip = (P / D) j - (A / D) rest + A (drag + gain.(a + (l C'', 0)) + (P / D) alpha_before)

A torque that a large rotor takes up is nowhere a difference: of j and its A / D-th part 1e-12 of the links' own torques would be left.
"""

from __future__ import annotations

from collections.abc import Callable

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.planar.geared.torques import Torques

Pair = tuple[Expr, Expr]


class Substitution:
    """Both ways, for one right side; work arrays hold what is found.

    Attributes:
        work: by name, `force_x`, `force_y` at the joints, `free`, `joint_x`, `joint_y` (accelerations of the joints less gravity), `swing`
            (alpha) and `slip`; where it is asked for, also `felt` (j - A slip).
    """

    def __init__(self, builder: Builder, parameters: Parameters, of: Callable[[str], ArrayRef], feels: bool = False) -> None:
        """Prepare.

        Args:
            builder: where the Program is recorded.
            parameters: the chain's numbers.
            of: the arrays that the elimination filled, by name.
            feels: whether what the links before feel of the joints' torques is kept.
        """
        self.builder, self.parameters, self.of = builder, parameters, of
        names = {"force_x": "asked_x", "force_y": "asked_y", "free": "loose", "swing": "turned"}
        names |= {name: name for name in ("joint_x", "joint_y", "slip")}
        names |= {"felt": "felt"} if feels else {}
        self.feels = feels
        self.work = {name: builder.array(label, parameters.links) for name, label in names.items()}

    def inwards(self, acting: Torques, bend: ArrayRef, rise: ArrayRef | None) -> None:
        """Forces and moments that the chain beyond each joint asks for, and the links' free turning."""
        builder, of, last = self.builder, self.of, self.parameters.links - 1
        armature, length, zero = self.parameters.armature, self.parameters.length, builder.lift(0)
        assert armature is not None
        with builder.loop("k", last, -1, -1) as loop:
            k = loop.index
            x, y, n = (loop.carry(f"beyond_{name}", 0) for name in ("x", "y", "n"))
            pushed = zero if acting.link is None else acting.link[k]
            lifted = zero if rise is None else rise[k]
            driven = rest = builder.let("driven" if acting.joint is None else "beside_joint", pushed - n)
            if acting.joint is None:
                still = of("inverse")[k] * driven - of("lag")[k] * lifted
                free = builder.let("loose", still - of("arm_x")[k] * x - of("arm_y")[k] * y)
                passed = -(armature[k] * (free - of("gain_x")[k] * (length[k] * bend[k])))
            else:
                driven = builder.let("driven", acting.joint[k] + rest)
                drag = builder.let("drag", of("lag")[k] * lifted + (of("arm_x")[k] * x + of("arm_y")[k] * y))
                free = builder.let("loose", of("inverse")[k] * driven - drag)
                held = of("slack")[k] * acting.joint[k] - of("share")[k] * rest
                bent = of("gain_x")[k] * (length[k] * bend[k])
                if self.feels:
                    self.work["felt"][k] = held = builder.let("felt_moment", held + armature[k] * drag)
                passed = held + armature[k] * (bent if self.feels else drag + bent)
            self.work["free"][k] = free
            own_x = of("axial")[k] * bend[k] + of("gain_x")[k] * driven + of("lift_x")[k] * lifted
            own_y = of("skew")[k] * bend[k] + of("gain_y")[k] * driven + of("lift_y")[k] * lifted
            force_x = builder.let("asked_x", own_x + of("q_xx")[k] * x + of("q_xy")[k] * y)
            force_y = builder.let("asked_y", own_y + of("q_yx")[k] * x + of("q_yy")[k] * y)
            self.work["force_x"][k], self.work["force_y"][k] = force_x, force_y
            loop.follow(x, force_x)
            loop.follow(y, force_y)
            loop.follow(n, passed)

    def outwards(self, base: Pair, bend: ArrayRef, rise: ArrayRef | None) -> None:
        """Accelerations of the joints and links, from that of the base less gravity in the first link's frame."""
        builder, last = self.builder, self.parameters.links - 1
        x, y, before = base[0], base[1], builder.lift(0)
        if last:
            with builder.loop("k", 0, last) as loop:
                k = loop.index
                x, y, before = (
                    loop.carry(f"carried_{name}", start)
                    for name, start in (("x", x), ("y", y), ("turning", before))
                )
                after = self._outer_end(k, (x, y), before, bend, rise)
                for carried, value in zip((x, y, before), after, strict=True):
                    loop.follow(carried, value)
        self._turn(last, (x, y), before, bend)

    def base(self, push: Expr | None, has_cart: bool, weight: Expr | int = 1) -> tuple[Pair, Expr]:
        """Acceleration of the base less gravity in the first link's frame, and that of a cart on its rails.

        Args:
            push: the force on the cart, if there is one.
            has_cart: whether there is a cart.
            weight: by which gravity counts: 0 in all but the first order of a series.
        """
        of = self.of
        base = self.of("base")[0] * weight, self.of("base")[1] * weight
        if not has_cart:
            return base, self.builder.lift(0)
        sine, cosine, arm = of("sine")[0], of("cosine")[0], of("base_arm")
        pull = -(sine * self.work["force_x"][0] + cosine * self.work["force_y"][0])
        free = self.builder.let("cart_free", arm[0] * (pull if push is None else push + pull))
        return (base[0] + sine * free, base[1] + cosine * free), free + arm[1] * weight

    def _turn(self, k: Index, joint: Pair, before: Expr, bend: ArrayRef) -> Pair:
        """Write the accelerations of joint and link k; returns that of its outer end along it, and its turning."""
        let, of, work = self.builder.let, self.of, self.work
        work["joint_x"][k], work["joint_y"][k] = joint
        along = let("tip_along", joint[0] + self.parameters.length[k] * bend[k])
        held = of("slack")[k] * before
        if self.feels:
            armature = self.parameters.armature
            assert armature is not None
            pulled = let("pulled", of("gain_x")[k] * along + of("gain_y")[k] * joint[1])
            drawn = let("drawn", work["free"][k] - pulled)
            work["felt"][k] = work["felt"][k] + armature[k] * (pulled + held)
        else:
            drawn = let("drawn", work["free"][k] - of("gain_x")[k] * along - of("gain_y")[k] * joint[1])
        work["slip"][k] = drawn - held
        work["swing"][k] = swing = let("turned", drawn + of("share")[k] * before)
        return along, swing

    def _outer_end(
        self, k: Index, joint: Pair, before: Expr, bend: ArrayRef, rise: ArrayRef | None
    ) -> tuple[Expr, Expr, Expr]:
        """Write the same; returns the acceleration of the next joint in the next link's frame, and the link's turning."""
        let, of = self.builder.let, self.of
        along, swing = self._turn(k, joint, before, bend)
        turning = self.work["free"][k] + of("share")[k] * before
        across = let("tip_across", self.parameters.length[k] * (turning if rise is None else turning + rise[k]))
        return (
            let("next_x", of("q_xx")[k] * along + of("q_yx")[k] * joint[1] + of("sine")[k + 1] * across),
            let("next_y", of("q_xy")[k] * along + of("q_yy")[k] * joint[1] + of("cosine")[k + 1] * across),
            swing,
        )
