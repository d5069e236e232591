"""f and J of short planar chains in the least text: every column goes through the same pair of linear sweeps (docs/theory.md, section 5).

After the articulated sweep the chain answers what disturbs link m by the elimination it was factored by. Seen at the joint, turned by its angle
or not, with A' and b' the inertia and force of link m and all beyond it, a the joint's acceleration less gravity, c a push of the tip along
the link and tau a couple on it, over m r^2, a disturbance is a jump of a in the frame of the link, a force there and a free turn:

    by the joint's angle         (a_y, -a_x)   A' (a_y, -a_x) + (-F_y, F_x), F = A' a + b'        0
    by less of the link's rate   (c, 0)        c (lambda + (A_xx + E) / D, -(lambda - 1) gain_x)  0           c = 2 w
    by a couple                  0             (gain_x tau, tau + (lambda - 1) tau / D)           tau / D

and inwards and outwards it goes on by

    free = -b_y / D,   b' = (b_x - gain_x b_y, (lambda - 1) free),   tip = (a_x, free - gain_x a_x - gain_y a_y).

The force is a difference where masses beyond are heavier, of as many digits less (the T of `response` is none), and so are the accelerations' own: k is not
carried. A link's columns follow as the accelerations come to it, so that what disturbs links is kept for one of them. Columns by relative rates are the sums
over all links beyond, those by relative couples differences of neighbours. It takes O(N^2) a column where `jacobian` takes O(N), and no other text than
these sweeps: of use where links are few.
"""

from __future__ import annotations

from typing import Final

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.lowering.chain.losses import slows_joints
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.chain.room import saves_text
from phichain.lowering.planar.articulated import Outer, Pivot, Sweep
from phichain.lowering.planar.joints import PlanarState, couples, planar_state
from phichain.scene import Scene

#: Links up to which the text saved is worth the instructions: at four 1.5 times those of `jacobian`, at ten twice.
MOST_LINKS: Final = 4
#: A mass may be so many times one before it: what heavier links push inwards is left as a difference, of as many digits less.
_HEAVIER: Final = 3
#: From what disturbs a link in one way to what disturbs it in the next: a couple, where there are any, its rate, its joint's angle.
_STRIDE: Final = 4
Pair = tuple[Expr, Expr]


def serves(scene: Scene) -> bool:
    """Whether columns one by one are the shorter text, and known: points on links without springs and losses, on a fixed base."""
    return (
        saves_text(scene) and 2 < scene.links <= MOST_LINKS and _is_even(scene) and scene.angles == "relative" and not scene.has_cart
        and not scene.tip_masses and scene.inertia is None and scene.armature is None and scene.stiffness is None
        and not slows_joints(scene) and not scene.base_accelerations and scene.nu in (0, scene.nv)
    )  # fmt: skip


def _is_even(scene: Scene) -> bool:
    """Whether masses are known, and none much heavier than one before it."""
    return not isinstance(scene.mass, str) and all(
        beyond <= _HEAVIER * mass for k, mass in enumerate(scene.mass) for beyond in scene.mass[k + 1 :]
    )


def dynamics_and_columns(
    builder: Builder, scene: Scene, parameters: Parameters, q: ArrayRef, v: ArrayRef, u: ArrayRef | None, a: ArrayRef,
    dadq: ArrayRef, dadv: ArrayRef, dadu: ArrayRef | None,
) -> None:  # fmt: skip
    """The accelerations, and their derivatives column by column."""
    sweep = Disturbed(builder, scene, parameters, planar_state(builder, scene, q, v), u, dadu is not None)
    sweep.to_base()
    answers, links = sweep.outwards_with_columns((-parameters.fall[1], -parameters.fall[0]), a), scene.links
    with builder.loop("i", 0, links) as rows:
        if dadu is not None:
            answers[rows.index] = 0
        with builder.loop("m", links - 1, -1, -1) as loop:
            entry, place = rows.index * links + loop.index, rows.index + loop.index * links
            by_rate, by_angle = (answers[place + links * (1 + kind * (links + 1))] for kind in (sweep.rate_kind, sweep.rate_kind + 1))
            beyond = loop.carry("rate_beyond", 0)
            total = beyond - by_rate
            dadq[entry] = by_angle
            dadv[entry] = total
            if dadu is not None:
                dadu[entry] = answers[place + links] - answers[place]
            loop.follow(beyond, total)


class Disturbed(Sweep):
    """The articulated sweep that says what disturbs each link, and its linear form for one disturbance at a time.

    Args:
        has_couples: whether couples disturb links, too.
    """

    def __init__(
        self, builder: Builder, scene: Scene, parameters: Parameters, state: PlanarState, u: ArrayRef | None, has_couples: bool
    ) -> None:
        super().__init__(builder, scene, parameters, state, couples(builder, scene, parameters, state, u))
        self.rate_kind, links = int(has_couples), scene.links
        self.inverse, self.reach = builder.array("inverse_of", links), builder.array("reach_of", links)
        self.spread, self.force_x, self.force_y = (builder.array(f"link_{name}_of", links) for name in ("spread", "force_x", "force_y"))
        self.turned_sine, self.turned_cosine = builder.array("sine_of", links), builder.array("cosine_of", links)
        self.moved_turn, self.jump_x, self.jump_y = (builder.array(f"{name}_at", links) for name in ("turn", "jump_x", "jump_y"))
        # Kind by kind: the turn, the force and the jump, whose second part is none where the next kind's turn is none.
        self.causes = builder.array("cause", _STRIDE * (self.rate_kind + 2) + 1)

    def with_link(self, outer: Outer, pivot: Pivot, k: Index) -> Outer:
        """As the sweep without k, b'_x = b_x + gain_x (tau - b_y) - w^2 (lambda + (A_xx + E) / D)."""
        let, factors, zero = self.builder.let, self.factors, self.builder.lift(0)
        self.inverse[k] = pivot.inverse
        axial = let("axial", self.axial(outer, k) * pivot.inverse)
        reach = let("reach", self.units.leverage[k] + axial)
        self.reach[k] = reach
        force_x = outer.force_x + pivot.gain_x * (pivot.drive - outer.force_y) - pivot.rate_squared * reach
        force_y = pivot.drive + self.units.overhang[k] * pivot.free
        return Outer(
            xx=let("link_xx", factors.axial[k] + factors.mass[k] * axial),
            xy=-(factors.skew[k] * pivot.gain_x),
            yy=let("link_yy", factors.lever[k] * (outer.yy * pivot.inverse)),
            determinant=let("link_determinant", factors.determinant[k] * self.determinant(outer, pivot.inverse, k)),
            force_x=let("link_force_x", factors.force[k] * force_x),
            force_y=let("link_force_y", factors.force[k] * force_y),
            minor_x=zero,
            minor_y=zero,
        )

    def _turned(self, link: Outer, k: Index) -> Outer:
        self.spread[k] = link.xx - link.yy
        self.force_x[k], self.force_y[k] = link.force_x, link.force_y
        # Beside what else the columns read of a link, they need no pointer of their own.
        self.turned_sine[k], self.turned_cosine[k] = self.sine[k], self.cosine[k]
        for cells in (self.moved_turn, self.jump_x, self.jump_y):
            cells[k] = 0
        return super()._turned(link, k)

    def outwards_with_columns(self, base: Pair, a: ArrayRef) -> ArrayRef:
        """Write the accelerations; what every disturbance makes of them: for each kind N cells that are free, and N a link."""
        builder, links = self.builder, self.scene.links
        inverse = 1 / self.parameters.length[0]
        answers = builder.array("answer", (self.rate_kind + 2) * links * (links + 1))
        for kind in range(self.rate_kind + 1):
            self.causes[_STRIDE * kind + _STRIDE] = 0
        self.causes[_STRIDE * self.rate_kind - (1 if self.rate_kind else 0)] = 0
        with builder.loop("m", 0, links) as loop:
            m = loop.index
            x, y, before = loop.carry("base_x", inverse * base[0]), loop.carry("base_y", inverse * base[1]), loop.carry("before", 0)
            turned = self._to_link((x, y), m)
            turned = builder.let("turned_x", turned[0]), builder.let("turned_y", turned[1])
            joint = builder.let("joint_x", self.units.outward[m] * turned[0]), builder.let("joint_y", self.units.outward[m] * turned[1])
            tip_y = self._tip("tip_y", self.free[m], joint, m)
            alpha = builder.let("alpha", tip_y - joint[1])
            a[m] = alpha - before
            rate = self.state.rate[m]
            self._causes(turned, joint, rate, m)
            loop.follow(x, joint[0] - rate * rate)
            loop.follow(y, tip_y)
            loop.follow(before, alpha)
            with builder.loop("kind", 0, self.rate_kind + 2) as kinds:
                turn, push_x, push_y, jump_x, jump_y = (self.causes[_STRIDE * kinds.index + place] for place in range(5))
                self.moved_turn[m], self.jump_x[m], self.jump_y[m] = turn, jump_x, jump_y
                self._inwards(m, (push_x, push_y))
                self._outwards(answers.shifted(kinds.index * (links * (links + 1)) + m * links + links))
            self.jump_x[m], self.jump_y[m] = 0, 0
        return answers

    def _causes(self, turned: Pair, joint: Pair, rate: Expr, m: Index) -> None:
        """What disturbs link m: a couple on it, less of its rate, its joint's angle."""
        units, force, causes = self.units, self.factors.force[m], self.causes
        gain, spread = self.gain_x[m], self.spread[m]
        twice = 2 * (self.factors.skew[m] * gain)
        angle = causes.shifted(_STRIDE * self.rate_kind + _STRIDE)
        angle[1] = spread * turned[1] + twice * turned[0] - self.force_y[m]
        angle[2] = spread * turned[0] - twice * turned[1] + self.force_x[m]
        angle[3], angle[4] = joint[1], -joint[0]
        slope, by_rate = self.builder.let("tip_slope", 2 * rate), causes.shifted(_STRIDE * self.rate_kind)
        by_rate[1] = slope * (force * self.reach[m])
        by_rate[2] = -(slope * (force * (units.overhang[m] * gain)))
        by_rate[3] = slope
        if self.rate_kind:
            drive = units.inverse_torque[m]
            turn = self.builder.let("turn", drive * self.inverse[m])
            causes[0] = turn
            causes[1], causes[2] = force * (drive * gain), force * (drive + units.overhang[m] * turn)

    def _to_link(self, pair: Pair, k: Index) -> Pair:
        """In the frame of link k what is given in that of the link before."""
        sine, cosine = self.turned_sine[k], self.turned_cosine[k]
        return cosine * pair[0] + sine * pair[1], cosine * pair[1] - sine * pair[0]

    def _tip(self, name: str, free: Expr, joint: Pair, k: Index) -> Expr:
        """The acceleration of the link's tip across it."""
        return self.builder.let(name, free - self.gain_x[k] * joint[0] - self.gain_y[k] * joint[1])

    def _inwards(self, m: Index, push: Pair) -> None:
        """A force at joint m, in the frame of its link, over all links before it."""
        let = self.builder.let
        with self.builder.loop("k", m, 0, -1) as loop:
            k, before = loop.index, loop.index - 1
            x, y = loop.carry("push_x", push[0]), loop.carry("push_y", push[1])
            sine, cosine = self.turned_sine[k], self.turned_cosine[k]
            outer_x, outer_y = let("outer_push_x", cosine * x - sine * y), let("outer_push_y", sine * x + cosine * y)
            free = -(outer_y * self.inverse[before])
            self.moved_turn[before] = free
            force = self.factors.force[before]
            loop.follow(x, force * (outer_x - self.gain_x[before] * outer_y))
            loop.follow(y, force * (self.units.overhang[before] * free))

    def _outwards(self, answer: ArrayRef) -> None:
        """From joint to joint what a column makes of the accelerations."""
        let = self.builder.let
        with self.builder.loop("k", 0, self.scene.links) as loop:
            k = loop.index
            x, y, before = loop.carry("moved_x", 0), loop.carry("moved_y", 0), loop.carry("moved_before", 0)
            turned = self._to_link((self.units.outward[k] * x, self.units.outward[k] * y), k)
            joint = let("moved_joint_x", turned[0] + self.jump_x[k]), let("moved_joint_y", turned[1] + self.jump_y[k])
            tip_y = self._tip("moved_tip_y", self.moved_turn[k], joint, k)
            alpha = let("moved_alpha", tip_y - joint[1])
            answer[k] = alpha - before
            loop.follow(x, joint[0])
            loop.follow(y, tip_y)
            loop.follow(before, alpha)
