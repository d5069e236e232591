"""Planar forward dynamics of long chains: both sides' eliminations as two lanes of one loop, and the way back of `meeting`.

Row i eliminates link 2 m - 1 - i beyond and link i before link m, where the sides meet; of an odd number of links the last one
is eliminated ahead of the rows. The turn into a row stands in the row's cells; that at link m, which no row makes, in the one left over.
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.lowering.chain.body import is_folded
from phichain.lowering.chain.link_units import LinkUnits
from phichain.lowering.chain.losses import push_on_cart
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.chain.room import saves_memory
from phichain.lowering.planar.articulated import Outer
from phichain.lowering.planar.both_ends import base_side
from phichain.lowering.planar.both_ends.elimination import (
    Kept,
    Left,
    Seen,
    cells,
    eliminated,
    nothing,
    turned,
)
from phichain.lowering.planar.both_ends.meeting import Inner, Met, WayBack, beginning, met
from phichain.lowering.planar.both_ends.numbers import Rows, beyond
from phichain.lowering.planar.joints import PlanarState, couples, from_absolute
from phichain.scene import Scene

_BEYOND, _BEFORE = 0, 1
#: From so many links on two lanes take less time than two eliminations side by side. Of runtime parameters only where they are
#: prepared: tables for both lanes cost more at every call than the lanes gain (1.02 to 1.09 of the time with 16 to 64 links).
_FEWEST_LINKS = 16


def suits(scene: Scene) -> bool:
    """Whether this form is the faster one: long chains in loops on a host, whose vectors do both lanes at once."""
    return is_folded(scene) and suits_prepared(scene)


def suits_prepared(scene: Scene) -> bool:
    """The same where runtime parameters have been prepared."""
    if scene.links < _FEWEST_LINKS or scene.code == "unrolled" or saves_memory(scene) or scene.tip_masses:
        return False
    return base_side.suits(scene)


def accelerations(
    builder: Builder, scene: Scene, parameters: Parameters, state: PlanarState, u: ArrayRef | None, a: ArrayRef
) -> None:
    """Write the accelerations [x'', theta''] into `a`."""
    couple = couples(builder, scene, parameters, state, u)
    chain = _Chain(builder, scene, parameters, state, couple)
    force = push_on_cart(scene, parameters, u, state.speed)
    meeting = chain.meeting(force)
    alpha = builder.array("acceleration", scene.links)
    cart = chain.substitute(meeting, alpha, force)
    if scene.has_cart:
        a[0] = cart * parameters.units.length
    from_absolute(builder, scene, alpha, a.shifted(int(scene.has_cart)))


class _Chain:
    """The rows of both sides, from the ends to where they meet and back."""

    def __init__(
        self, builder: Builder, scene: Scene, parameters: Parameters, state: PlanarState, couple: ArrayRef | None
    ) -> None:
        self.builder, self.scene, self.parameters, self.state = builder, scene, parameters, state
        self.couple, self.rows = couple, scene.links // 2
        rows = self.rows
        self.is_odd = scene.links % 2 == 1
        self.units = LinkUnits(builder, scene, parameters)
        self.numbers = Rows(builder, self.units, rows)
        self.cells = cells(builder, rows)
        self.weight = base_side.weight(scene, parameters, self.units, rows)
        seen = () if self.weight is None else ("determinant", "minor_x")
        self.weighed = {name: builder.array(f"row_seen_{name}", 2 * rows) for name in seen}
        self.drive, self.spin = builder.array("row_drive", 2 * rows), builder.array("row_spin", 2 * rows)
        self.sine, self.cosine = self._turns()
        self.last = self._last_link() if self.is_odd else None
        self._motions()

    def _turns(self) -> tuple[ArrayRef, ArrayRef]:
        """Sines and cosines of the joints' angles in the order of the rows."""
        rows, angle, theta = self.rows, self.builder.array("row_angle", self.scene.links), self.state.angle
        angle[self._last_turn] = theta[rows]
        angle[1] = theta[0]
        if self.is_odd:
            angle[0] = theta[2 * rows]
        with self.builder.loop("i", 1, rows) as loop:
            angle[2 * loop.index] = theta[2 * rows - loop.index]
            angle[2 * loop.index + 1] = theta[loop.index]
        return self.builder.sincos(angle, self.scene.links)

    @property
    def _last_turn(self) -> int:
        """The cell of the turn where the sides meet."""
        return 2 * self.rows if self.is_odd else 0

    def _motions(self) -> None:
        """T and O of every row: a couple and a rate squared, and these exchanged."""
        last, drive, spin = 2 * self.rows - 1, self.drive, self.spin
        with self.builder.loop("i", 0, self.rows) as loop:
            i = loop.index
            drive[2 * i], spin[2 * i] = self._couple(last - i), self._squared(last - i)
            drive[2 * i + 1], spin[2 * i + 1] = self._squared(i), self._couple(i)

    def _couple(self, k: Index) -> Expr:
        return self.builder.lift(0) if self.couple is None else self.couple[k] * self.units.inverse_torque[k]

    def _squared(self, k: Index) -> Expr:
        return self.state.rate[k] * self.state.rate[k]

    # --- from the ends to where they meet ---------------------------------------------------------------------------

    def meeting(self, force: Expr) -> Met:
        """Eliminate all links; returns what both sides do where they meet."""
        builder, rows = self.builder, self.rows
        self._keep(self._at_tip(), _BEYOND)
        self._keep(self._at_base(force), _BEFORE)
        # The second lane's frames turn by half a turn more from link to link: c and k change sign there.
        sign = builder.constants("lane_sign", [Fraction(1), Fraction(-1)])
        with builder.loop("i", 1, rows) as loop, builder.loop("lane", 0, 2, is_lanes=True) as lanes:
            cell, sense = 2 * loop.index + lanes.index, sign[lanes.index]
            sine, cosine = builder.let("turn_sine", sense * self.sine[cell]), builder.let("turn_cosine", sense * self.cosine[cell])
            self._keep(turned(builder, self.cells[cell - 2], self.numbers[cell - 2], sine, cosine), cell)
        return met(builder, self.units, self._inner(), self._outer(), rows)

    def _keep(self, seen: Seen, cell: Index) -> None:
        self.cells.write(cell, *eliminated(self.builder, seen, self.numbers[cell], self.drive[cell], self.spin[cell]))
        for name, array in self.weighed.items():
            array[cell] = getattr(seen, name)

    def _last_link(self) -> tuple[Left, Kept]:
        """The link beyond all rows of an odd number of links."""
        last, none = self.scene.links - 1, nothing(self.builder)
        return eliminated(self.builder, none, beyond(self.builder, self.units, last), self._couple(last), self._squared(last))

    def _at_tip(self) -> Seen:
        """What the first row's link on the tip's side carries."""
        if self.last is None:
            return nothing(self.builder)
        return turned(self.builder, self.last[0], beyond(self.builder, self.units, self.scene.links - 1), self.sine[0], self.cosine[0])

    def _at_base(self, force: Expr) -> Seen:
        """What carries the first link, as its mobility and acceleration stand for inertia and force."""
        base = beginning(self.builder, self.scene, self.parameters, self.units, force)
        zero, leverage = self.builder.lift(0), self.units.leverage[0]
        left = Left(
            axial=zero, skew=zero, across=zero, inverse=zero + 1, determinant=zero, force_x=leverage * base.drift_y,
            force_y=leverage * base.drift_x, minor_x=leverage * base.minor_y, minor_y=leverage * base.minor_x,
        )  # fmt: skip
        numbers = replace(self.numbers[_BEFORE], own=leverage * leverage * base.yy)
        return turned(self.builder, left, numbers, self.sine[_BEFORE], self.cosine[_BEFORE])

    def _outer(self) -> Outer:
        """The tip's side in the frame and units of the last link on the base's side."""
        cell = 2 * self.rows - 2
        turn = self.sine[self._last_turn], self.cosine[self._last_turn]
        seen = turned(self.builder, self.cells[cell], self.numbers[cell], *turn)
        return Outer(seen.xx, seen.xy, seen.yy, seen.determinant, seen.force_x, seen.force_y, seen.minor_x, seen.minor_y)

    def _inner(self) -> Inner:
        """The base's side in the frame of its last link and the units of the next one."""
        left, numbers = self.cells[2 * self.rows - 1], self.numbers[2 * self.rows - 1]
        short = self.units.shortening[self.rows]
        of_mass, share = short * short, numbers.mass * left.inverse
        return Inner(
            xx=of_mass * (numbers.outer_squared * left.across * share),
            xy=-(of_mass * (numbers.overhang * left.skew * share)),
            yy=of_mass * (numbers.own + numbers.inner_squared * left.axial * share),
            determinant=short * left.determinant, drift_x=-(short * left.force_y), drift_y=-(short * left.force_x),
            minor_x=-(short * left.minor_y), minor_y=-(short * left.minor_x),
        )  # fmt: skip

    # --- from where they meet to the ends ---------------------------------------------------------------------------

    def substitute(self, meeting: Met, alpha: ArrayRef, force: Expr) -> Expr:
        """Write the angular accelerations of all links; returns the acceleration of the base across the vertical."""
        rows, way_back = self.rows, self._way_back()
        tip = self._outer_end(alpha, (meeting.x, meeting.y), rows, self._last_turn)
        carried = ("x_force", "x", "y")
        with self.builder.loop("i", 0, rows - 1) as loop:
            base_x, base_y = loop.carry("base_x", tip[0]), loop.carry("base_y", tip[1])
            inner = replace(meeting, **{name: loop.carry(f"met_{name}", getattr(meeting, name)) for name in carried})
            tip = self._outer_end(alpha, (base_x, base_y), loop.index + (rows + 1), 2 * (rows - 1) - 2 * loop.index)
            loop.follow(base_x, tip[0])
            loop.follow(base_y, tip[1])
            end = way_back.step(inner, alpha, rows - 1 - loop.index)
            for name in carried:
                loop.follow(getattr(inner, name), getattr(end, name))
        if self.last is not None:
            self._outer_end(alpha, (base_x, base_y), 2 * rows, 0)
        return way_back.cart_acceleration(way_back.step(inner, alpha, 0), force)

    def _outer_end(self, alpha: ArrayRef, base: tuple[Expr, Expr], k: Index, turn: Index) -> tuple[Expr, Expr]:
        """The acceleration of link k on the tip's side, written into `alpha`, and of its outer end; the joint's turn stands in a cell."""
        let, sine, cosine = self.builder.let, self.sine[turn], self.cosine[turn]
        before_x, before_y = (self.units.outward[k] * axis for axis in base)
        joint_x, joint_y = let("joint_x", cosine * before_x + sine * before_y), let("joint_y", cosine * before_y - sine * before_x)
        free, gain, inverse, rate_squared = self._left_of(k)
        tip_y = let("tip_y", free - gain * joint_x - self.units.overhang[k] * inverse * joint_y)
        alpha[k] = tip_y - joint_y
        return joint_x - rate_squared, tip_y

    def _left_of(self, k: Index) -> tuple[Expr, Expr, Expr, Expr]:
        """Of link k on the tip's side: free, A_xy / D, 1 / D and its rate squared."""
        if self.last is not None and k == 2 * self.rows:
            _, own = self.last
            return own.free, own.gain, own.inverse, self._squared(k)
        cell, kept = 2 * (2 * self.rows - 1) - 2 * k, self.cells.kept
        return kept["free"][cell], kept["gain"][cell], kept["inverse"][cell], self.spin[cell]

    def _way_back(self) -> WayBack:
        """What the way back to the base takes from the elimination: no link waits for another here."""
        builder, units, rows = self.builder, self.units, self.rows
        found, weight = {name: array.shifted(_BEFORE, 2) for name, array in self.cells.kept.items()}, self.weight
        overhang = self.parameters.derived("overhang_squared", lambda k: units.overhang[k] * units.overhang[k], rows)
        short = units.shortening
        squared = self.parameters.derived("shortening_squared", lambda k: units.shortening[k] * units.shortening[k], rows)
        kept = {name: builder.array(f"base_{name}", rows) for name in ("reach", "rest", "rest_force", "rest_across", "rest_push")}
        with builder.loop("i", 0, rows) as loop:
            k = loop.index
            of_pivot = builder.let("base_pivot", 1 + found["across"][k])
            pivot, push, across = of_pivot, short[k] * found["pull"][k], squared[k] * found["axial"][k]
            if weight is not None:
                pivot = pivot + weight.own[k] * (squared[k] * found["across"][k])
                push = push + weight.minor[k] * (short[k] * self.weighed["minor_x"][2 * k + _BEFORE])
                across = across + weight.determinant[k] * (short[k] * self.weighed["determinant"][2 * k + _BEFORE])
            rest = builder.let("inverse_rest", 1 / (pivot + overhang[k] * across))
            kept["rest"][k], kept["rest_push"][k] = squared[k] * (found["gain"][k] * (rest * of_pivot)), rest * push
            kept["rest_across"][k], kept["rest_force"][k] = rest * across, rest * pivot
            kept["reach"][k] = -(units.leverage[k] * (found["push"][k] * found["inverse"][k]))
        kept |= {"yield": found["inverse"], "coupling_skew": found["gain"]}
        if self.couple is not None:
            kept["drive"] = self.spin.shifted(_BEFORE, 2)
        return WayBack(
            builder, self.scene, self.parameters, units, weight, self.sine.shifted(_BEFORE, 2), self.cosine.shifted(_BEFORE, 2),
            self.drive.shifted(_BEFORE, 2), overhang, units.product("force_step", units.mass, units.length), kept,
        )  # fmt: skip
