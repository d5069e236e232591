"""f and J of short planar chains in the least text: every column goes through the same pair of linear sweeps (docs/theory.md, section 5).

After the articulated sweep the chain answers what disturbs link m by the elimination it was factored by. Seen at the joint, turned by its angle
or not, with A' and b' the inertia and force of link m and all beyond it, a the joint's acceleration less gravity, c a push of the tip along
the link and tau a couple on it, over m r^2, a disturbance is a jump of a in the frame of the link, a force there and a free turn:

    by the joint's angle   (a_y, -a_x)   A' (a_y, -a_x) + (-F_y, F_x), F = A' a + b'          0
    by the link's rate     (-c, 0)       c (-(lambda + (A_xx + E) / D), (lambda - 1) gain_x)  0           c = 2 w
    by a couple            0             (gain_x tau, tau + (lambda - 1) tau / D)             tau / D

and inwards and outwards it goes on by

    free = -b_y / D,   b' = (b_x - gain_x b_y, (lambda - 1) free),   tip = (a_x, free - gain_x a_x - gain_y a_y).

The force is a difference where masses beyond are heavier, of as many digits less (the T of `response` is none). Columns by relative rates are the sums over all links beyond, those by relative couples differences of neighbours. It takes O(N^2) a column
where `jacobian` takes O(N), and no other text than these sweeps: of use where links are few.
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

#: Links up to which the text saved is worth the instructions: at four 1.6 times those of `jacobian`, at ten twice.
MOST_LINKS: Final = 4
#: A mass may be so many times one before it: what heavier links push inwards is left as a difference, of as many digits less.
_HEAVIER: Final = 3
_ANGLE, _RATE, _COUPLE = range(3)
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
    sweep = Disturbed(builder, scene, parameters, planar_state(builder, scene, q, v), u, 2 if dadu is None else 3)
    sweep.to_base()
    sweep.all_outwards(-parameters.fall[1], -parameters.fall[0], a)
    answers = sweep.columns()
    links = scene.links
    with builder.loop("i", 0, links) as rows:
        row = rows.index * (links + 1)
        if dadu is not None:
            answers[_COUPLE * links * (links + 1) + row] = 0
        with builder.loop("m", links - 1, -1, -1) as loop:
            m = loop.index
            by_angle, by_rate, by_couple = (answers.shifted(kind * links * (links + 1) + row + m) for kind in range(3))
            beyond = loop.carry("rate_beyond", 0)
            total = beyond + by_rate[1]
            dadq[rows.index * links + m] = by_angle[1]
            dadv[rows.index * links + m] = total
            if dadu is not None:
                dadu[rows.index * links + m] = by_couple[1] - by_couple[0]
            loop.follow(beyond, total)


class Disturbed(Sweep):
    """The articulated sweep that says what disturbs each link, and its linear form for one disturbance at a time.

    Args:
        kinds: 3 with the couples, 2 without.
    """

    def __init__(self, builder: Builder, scene: Scene, parameters: Parameters, state: PlanarState, u: ArrayRef | None, kinds: int) -> None:
        super().__init__(builder, scene, parameters, state, couples(builder, scene, parameters, state, u))
        self.kinds = kinds
        self.inverse = builder.array("inverse_of", scene.links)
        self.spread, self.force_x, self.force_y = (builder.array(f"link_{name}_of", scene.links) for name in ("spread", "force_x", "force_y"))
        names = ("push_x", "push_y", "jump_x", "jump_y", "turn")
        causes = builder.array("cause", len(names) * kinds * scene.links)
        self.cause = {name: causes.shifted(place, len(names)) for place, name in enumerate(names)}

    def _put(self, kind: int, k: Index, force: Pair, jump: Pair, turn: Expr) -> None:
        for name, value in zip(self.cause, (*force, *jump, turn), strict=True):
            self.cause[name][k + kind * self.scene.links] = value

    def pivot(self, outer: Outer, k: Index) -> Pivot:
        """As the sweep, and what its rate and a couple on it disturb."""
        pivot, units, force, nothing = super().pivot(outer, k), self.units, self.factors.force[k], self.builder.lift(0)
        self.inverse[k] = pivot.inverse
        slope = self.builder.let("tip_slope", -2 * self.state.rate[k])
        along = units.leverage[k] + self.axial(outer, k) * pivot.inverse
        self._put(_RATE, k, (slope * (force * along), -(slope * (force * (units.overhang[k] * pivot.gain_x)))), (slope, nothing), nothing)
        if self.kinds > _COUPLE:
            drive = units.inverse_torque[k]
            turn = drive * pivot.inverse
            self._put(_COUPLE, k, (force * (drive * pivot.gain_x), force * (drive + units.overhang[k] * turn)), (nothing, nothing), turn)
        return pivot

    def _turned(self, link: Outer, k: Index) -> Outer:
        self.spread[k] = link.xx - link.yy
        self.force_x[k], self.force_y[k] = link.force_x, link.force_y
        return super()._turned(link, k)

    def outer_end(self, alpha: ArrayRef, base: Pair, k: Index) -> Pair:
        """As the sweep, and what the joint's angle disturbs."""
        end = super().outer_end(alpha, base, k)
        turned = self._to_link(base, k)
        joint = self.units.outward[k] * turned[0], self.units.outward[k] * turned[1]
        twice = -2 * (self.factors.skew[k] * self.gain_x[k])
        push = self.spread[k] * turned[1] - twice * turned[0] - self.force_y[k], self.spread[k] * turned[0] + twice * turned[1] + self.force_x[k]
        self._put(_ANGLE, k, push, (joint[1], -joint[0]), self.builder.lift(0))
        return end

    def _to_link(self, pair: Pair, k: Index) -> Pair:
        sine, cosine = self.sine[k], self.cosine[k]
        return cosine * pair[0] + sine * pair[1], cosine * pair[1] - sine * pair[0]

    def columns(self) -> ArrayRef:
        """What every disturbance makes of all accelerations: for each kind a row of N + 1 a link, its first cell free."""
        builder, links = self.builder, self.scene.links
        state = {name: builder.array(f"{name}_at", links) for name in ("turn", "jump_x", "jump_y")}
        answers = builder.array("answer", self.kinds * links * (links + 1))
        with builder.loop("k", 0, links) as loop:
            for cells in state.values():
                cells[loop.index] = 0
        with builder.loop("kind", 0, self.kinds) as kinds, builder.loop("m", links - 1, -1, -1) as columns:
            m, cause = columns.index, columns.index + kinds.index * links
            for name, cells in state.items():
                cells[m] = self.cause[name][cause]
            self._inwards(m, (self.cause["push_x"][cause], self.cause["push_y"][cause]), state["turn"])
            self._outwards(state, answers.shifted(kinds.index * (links * (links + 1)) + m + 1, links + 1))
            for cells in state.values():
                cells[m] = 0
        return answers

    def _inwards(self, m: Index, push: Pair, turn: ArrayRef) -> None:
        """A force at joint m, in the frame of its link, over all links before it."""
        let = self.builder.let
        with self.builder.loop("k", m, 0, -1) as loop:
            k, before = loop.index, loop.index - 1
            x, y = loop.carry("push_x", push[0]), loop.carry("push_y", push[1])
            sine, cosine = self.sine[k], self.cosine[k]
            outer_x, outer_y = let("outer_push_x", cosine * x - sine * y), let("outer_push_y", sine * x + cosine * y)
            free = -(outer_y * self.inverse[before])
            turn[before] = free
            force = self.factors.force[before]
            loop.follow(x, force * (outer_x - self.gain_x[before] * outer_y))
            loop.follow(y, force * (self.units.overhang[before] * free))

    def _outwards(self, state: dict[str, ArrayRef], answer: ArrayRef) -> None:
        """From joint to joint what a column makes of the accelerations."""
        let = self.builder.let
        with self.builder.loop("k", 0, self.scene.links) as loop:
            k = loop.index
            x, y, before = loop.carry("moved_x", 0), loop.carry("moved_y", 0), loop.carry("moved_before", 0)
            turned = self._to_link((self.units.outward[k] * x, self.units.outward[k] * y), k)
            joint_x, joint_y = let("moved_joint_x", turned[0] + state["jump_x"][k]), let("moved_joint_y", turned[1] + state["jump_y"][k])
            tip_y = let("moved_tip_y", state["turn"][k] - self.gain_x[k] * joint_x - self.gain_y[k] * joint_y)
            alpha = let("moved_alpha", tip_y - joint_y)
            answer[k] = alpha - before
            loop.follow(x, joint_x)
            loop.follow(y, tip_y)
            loop.follow(before, alpha)
