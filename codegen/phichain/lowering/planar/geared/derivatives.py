"""The derivatives of the accelerations of a planar chain whose joints carry rotors: one factorisation, one substitution a column.

Along a variation (d phi_k, d w_k) of the links' angles and rates, at the accelerations that are there, the direction of link k bends
and rises by what its own acceleration becomes beside d alpha_k, and the moment that all forces have along the link turns with it:

    d C'' = -alpha_k d phi_k - 2 w_k d w_k,    d S'' = d alpha_k - w_k^2 d phi_k,    d tau_k = R_k d phi_k + what joints change

    R_k = m r a_x + l F_x

(what the link's own inertia asks for is J alpha_k, whichever way it points) with a the acceleration of the link's joint less gravity and F the force at its outer end, both along the link. So every column is
the system of the accelerations themselves with another right side: `elimination` serves all of them, and no large rotor is differentiated.
"""

from __future__ import annotations

from fractions import Fraction

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.lowering.chain.losses import brakes_cart, cart_slope, joint_slopes, push_on_cart
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.chain.planar_links import PlanarLinks
from phichain.lowering.planar.geared.dynamics import Solved, solved, write_swing
from phichain.lowering.planar.geared.substitution import Substitution
from phichain.lowering.planar.geared.torques import Torques, torques
from phichain.lowering.planar.joints import (
    PlanarState,
    absolute,
    difference,
    planar_state,
)
from phichain.scene import Scene

#: What all beyond a joint may resist turning with, over what the link turns with by itself: digits go as it grows.
_MOST = 100


def suits(scene: Scene) -> bool:
    """Whether no digit is lost against the differentiated sweeps.

    The moment R_k of a light link that holds heavy ones is large beside what turns it: of masses that alternate over seven decades 5e-13
    is left of a row, where those sweeps keep 1e-15. Rotors are no such spread: they turn with their links. Numbers at run time may be any.
    """
    given = scene.mass, scene.length, scene.length if scene.com is None else scene.com, scene.armature, scene.inertia or (0.0,) * scene.links
    numbers = [values for values in given if isinstance(values, tuple)]
    if scene.base_accelerations or len(numbers) < len(given):
        return False
    beyond = 0.0
    for m, l, r, rotor, spin in reversed(list(zip(*numbers, strict=True))):
        if m * r * l + l * l * beyond > _MOST * (m * r * r + spin + rotor):
            return False
        beyond += m
    return True


Outputs = tuple[ArrayRef, ArrayRef, ArrayRef, ArrayRef | None]


def derivatives(
    builder: Builder, scene: Scene, parameters: Parameters, state: tuple[ArrayRef, ArrayRef, ArrayRef | None], out: Outputs
) -> None:
    """Write the accelerations and their derivatives.

    Args:
        builder: where the Program is recorded.
        scene: the chain, on a wall or on a cart that moves freely.
        parameters: its numbers.
        state: q, v and the inputs.
        out: a, dadq, dadv and dadu.
    """
    _Derivatives(builder, scene, parameters, state, out).write()


class _Derivatives:
    """The columns, each by its own right side."""

    def __init__(
        self, builder: Builder, scene: Scene, parameters: Parameters, state: tuple[ArrayRef, ArrayRef, ArrayRef | None], out: Outputs
    ) -> None:
        self.builder, self.scene, self.parameters, self.out = builder, scene, parameters, out
        self.q, self.v, self.u = state
        self.carts = int(scene.has_cart)
        self.state: PlanarState = planar_state(builder, scene, self.q, self.v)
        push = push_on_cart(scene, parameters, self.u, self.state.speed) if scene.has_cart else None
        acting = torques(builder, scene, parameters, self.state, self.u)
        self.solved: Solved = solved(builder, scene, parameters, self.state, acting, push)
        self.turned = Substitution(builder, parameters, self.solved.of)
        seeds = scene.nv + scene.nu
        self.seeds = builder.constants("seed", [Fraction(int(i == seeds - 1)) for i in range(2 * seeds - 1)]).shifted(seeds - 1)

    def write(self) -> None:
        """All results."""
        builder, scene, (a, dadq, dadv, dadu) = self.builder, self.scene, self.out
        self.solved.write(a)
        moment, slopes = self._moments(), joint_slopes(builder, scene, self.parameters, "resistance", self.state.joint_rate)
        with builder.loop("j", 0, scene.links) as columns:
            self._by_angle(columns.index, moment, dadq.shifted(columns.index + self.carts, scene.nv))
        with builder.loop("j", 0, scene.links) as columns:
            self._by_rate(columns.index, slopes, dadv.shifted(columns.index + self.carts, scene.nv))
        if dadu is not None:
            with builder.loop("j", 0, scene.nu) as columns:
                inputs = self.seeds.shifted(-columns.index)
                push = inputs[0] / self.parameters.units.force if scene.has_force else None
                self._column(torques(builder, scene, self.parameters, None, inputs), None, push, dadu.shifted(columns.index, scene.nu))
        if self.carts:
            with builder.loop("i", 0, scene.nv) as loop:
                dadq[loop.index * scene.nv] = 0
            self._by_speed(dadv.shifted(0, scene.nv))

    def _moments(self) -> ArrayRef:
        """R_k."""
        builder, links, work, of = self.builder, PlanarLinks(self.parameters), self.solved.substitution.work, self.solved.of
        moment, last = builder.array("moment_along", self.scene.links), self.scene.links - 1
        with builder.loop("k", 0, last) as loop:
            k, n = loop.index, loop.index + 1
            tip = of("cosine")[n] * work["force_x"][n] - of("sine")[n] * work["force_y"][n]
            tip = (tip + of("pull_y")[n] * work["joint_y"][n]) + of("pull_x")[n] * work["joint_x"][n]
            tip = tip + of("pull_n")[n] * work["swing"][k]
            moment[k] = links.moment[k] * work["joint_x"][k] + self.parameters.length[k] * tip
        moment[last] = links.moment[last] * work["joint_x"][last]
        return moment

    def _by_angle(self, j: Index, moment: ArrayRef, column: ArrayRef) -> None:
        """Along the scene's angle j."""
        builder, scene, links, rate = self.builder, self.scene, self.scene.links, self.state.rate
        turn = self.seeds.shifted(-j)
        phi = absolute(builder, scene, "turned_by", turn)
        bend, rise, torque = (builder.array(name, links) for name in ("column_bend", "column_rise", "column_torque"))
        swing, stiffness = self.solved.substitution.work["swing"], self.parameters.stiffness
        with builder.loop("k", 0, links) as loop:
            k = loop.index
            bend[k] = -(swing[k] * phi[k])
            rise[k] = -((rate[k] * rate[k]) * phi[k])
            torque[k] = moment[k] * phi[k]
        joint = None if stiffness is None else self._resisted(stiffness, difference(builder, scene, "joint_turned_by", turn))
        self._column(Torques(torque, joint), (bend, rise), None, column)

    def _by_rate(self, j: Index, slopes: ArrayRef | None, column: ArrayRef) -> None:
        """Along the scene's rate j."""
        builder, scene, links = self.builder, self.scene, self.scene.links
        faster = self.seeds.shifted(-j)
        own, bend = absolute(builder, scene, "faster_by", faster), builder.array("column_bend", links)
        with builder.loop("k", 0, links) as loop:
            bend[loop.index] = -(2 * self.state.rate[loop.index] * own[loop.index])
        joint = None if slopes is None else self._resisted(slopes, difference(builder, scene, "joint_faster_by", faster))
        self._column(Torques(joint=joint), (bend, None), None, column)

    def _resisted(self, slope: ArrayRef, by: ArrayRef) -> ArrayRef:
        """Torques across the joints, of so much for each unit of what they turn or turn faster by."""
        joint = self.builder.array("column_joint_torque", self.scene.links)
        with self.builder.loop("k", 0, self.scene.links) as loop:
            joint[loop.index] = -(slope[loop.index] * by[loop.index])
        return joint

    def _by_speed(self, column: ArrayRef) -> None:
        """Along the cart's speed."""
        if not brakes_cart(self.scene):
            with self.builder.loop("i", 0, self.scene.nv) as loop:
                column[loop.index] = 0
            return
        slope = cart_slope(self.scene, self.parameters, None if self.state.speed is None else self.state.speed[0])
        self._column(Torques(), None, -slope, column)

    def _column(
        self, acting: Torques, bent: tuple[ArrayRef, ArrayRef | None] | None, push: Expr | None, column: ArrayRef
    ) -> None:
        """The accelerations of a right side, into a column."""
        bend, rise = (self._still(), None) if bent is None else bent
        self.turned.inwards(acting, bend, rise)
        base, cart = self.turned.base(push, self.scene.has_cart, 0)
        self.turned.outwards(base, bend, rise)
        write_swing(self.builder, self.scene, self.turned, cart, column)

    def _still(self) -> ArrayRef:
        return self.builder.constants("still", [Fraction(0)] * self.scene.links)
