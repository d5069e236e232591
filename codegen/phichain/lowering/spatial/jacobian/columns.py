"""Derivatives of the spatial accelerations from one factorisation: every column goes over the links as the perturbation of a joint.

A column by q_j or omega_j is a disturbance of link j (`spatial.response`). Beyond j it is a perturbation y of the joints' accelerations
that goes outwards; inside, it is a force -f on joint j, and what that does is by reciprocity read off the perturbations that unit
couples on the links inside make at joint j. With h = s w + d and d what is left of the joints' acceleration across q,

    f_q = s (I + kappa W) - alpha v h^T,   f_omega = -2 l alpha v omega^T

Where the masses are at the links' ends a perturbation is w times one number from the second link on: 45 operations for the two 3 x 3
blocks of a pair of links and their mirror images; else three numbers, and 300.
"""

from __future__ import annotations

from dataclasses import dataclass

from phichain.ir.builder import ArrayRef, Builder, Index
from phichain.lowering.algebra.matrix import (
    Matrix,
    applied,
    minus,
    outer,
    plus,
    product,
    scaled,
    store_matrix,
    symmetric,
    transposed,
    triangle,
)
from phichain.lowering.algebra.vector import Vector, add, cross, dot, load, scale, store, sub, zeros
from phichain.lowering.lanes import Lanes
from phichain.lowering.parameters import Parameters
from phichain.lowering.spatial.jacobian.response import Answers, Link, turning
from phichain.scene import Scene

#: Links up to which every perturbation has memory of its own; beyond, two rows are written and read in turn.
LONGEST_KEPT = 32


@dataclass(frozen=True)
class _Disturbed:
    """What link k is disturbed by: f_q, alpha v, 2 l omega."""

    force: Matrix
    along: Vector
    doubled: Vector


class Columns:
    """Writes dadq, dadv and dadu, link by link from the base."""

    def __init__(
        self, builder: Builder, scene: Scene, answers: Answers, omega: ArrayRef, turned: ArrayRef, parameters: Parameters,
        dadq: ArrayRef, dadv: ArrayRef, dadu: ArrayRef | None,
    ) -> None:  # fmt: skip
        self.builder, self.scene, self.answers = builder, scene, answers
        self.omega, self.turned, self.length, self.units = omega, turned, parameters.length, parameters.units
        self.dadq, self.dadv, self.dadu = dadq, dadv, dadu
        self.links, self.nv, self.carts = scene.links, scene.nv, 2 * int(scene.has_cart)
        self.is_short = answers.rank == 1
        turns, parts = self.links > LONGEST_KEPT, "xyz"[: answers.rank]
        self.couples = Lanes(builder, "couple_state", self.nv, self.links, parts, turns)
        self.by_angle = Lanes(builder, "by_angle_state", 3 * self.links, self.links, parts, turns)
        self.by_rate = Lanes(builder, "by_rate_state", 3 * self.links, self.links, parts, turns)
        self.fresh = {
            name: builder.array(f"{name}_fresh", 9 * self.links) for name in ("couple", "angle", "rate")
        }
        self.mobility = builder.array("joint_mobility", 6 * self.links)

    def write(self, base: Matrix | None) -> None:
        """All rows and columns; `base` is the mobility of the cart, None on a fixed base."""
        self._first(base)
        links = self.links
        for k in range(1, min(2, links)):
            self._step(k)
        if links > LONGEST_KEPT:
            pairs = (links - 3) // 2
            with self.builder.loop("pair", 0, pairs) as loop:
                for after in range(2):
                    self._step(2 * loop.index + (2 + after))
            for k in range(2 + 2 * pairs, links):
                self._step(k)
        elif links > 2:
            with self.builder.loop("k", 2, links - 1) as loop:
                self._step(loop.index)
            self._step(links - 1)

    def _is_last(self, k: Index) -> bool:
        """Whether nothing is handed on."""
        return isinstance(k, int) and k == self.links - 1

    def _keep(self, lanes: Lanes, k: Index, column: Index, state: Vector) -> None:
        if not self._is_last(k):
            lanes.put(k, column, state)

    def _first(self, base: Matrix | None) -> None:
        nothing = zeros(self.builder, 3)
        link = self.answers.link(0)
        turn = turning(link)
        if base is None:
            self._own(0, link, turn, (nothing,) * 3)
            return
        self._empty_columns()
        hit = self._disturbed(0, link)
        for i in range(2):
            state = scale(self.units.length, base[i])
            self._mirrored(0, i, state, hit)
            for j in range(2):
                if self.dadu is not None:
                    self.dadu[i * 2 + j] = state[j] / self.units.force
            self._answer(0, i, applied(turn, state))
            self._keep(self.couples, 0, i, self._reduced(link, state))
        self._own(0, link, turn, base, hit)

    def _empty_columns(self) -> None:
        with self.builder.loop("i", 0, self.nv) as loop:
            for i in range(2):
                self.dadq[loop.index * self.nv + i] = 0
                self.dadv[loop.index * self.nv + i] = 0

    def _answer(self, k: Index, column: int, rate: Vector) -> None:
        """What a force on the cart does to link k."""
        if self.dadu is not None:
            for i in range(3):
                self.dadu[(3 * k + self.carts + i) * 2 + column] = rate[i] / self.units.torque

    def _disturbed(self, k: Index, link: Link) -> _Disturbed:
        builder = self.builder
        along = scale(link.axial, link.stretch)
        across = cross(scale(self.length[k], load(self.turned, k)), link.q)
        bent = add(scale(link.multiplier, link.axis), across)
        force = scaled(-1, outer(along, bent))
        own = link.multiplier
        if link.carried is not None:
            force = minus(force, scaled(own, link.carried))
        force = tuple(
            tuple(entry + own if i == j else entry for j, entry in enumerate(row))
            for i, row in enumerate(force)
        )
        doubled = scale(2 * self.length[k], load(self.omega, k))
        return _Disturbed(force, tuple(builder.let("drawn", entry) for entry in along), doubled)

    def _reduced(self, link: Link, state: Vector) -> Vector:
        """What goes on over a link, from the perturbation of its joint."""
        along = link.axial * dot(link.stretch, state)
        if self.is_short:
            return (along,)
        assert link.carried is not None
        return add(scale(along, link.axis), applied(link.carried, state))

    def _passed(self, link: Link, drawn: Vector, matrix: Matrix | None) -> Matrix:
        """P M, drawn = v.M; M itself where P has more than its first term."""
        first = outer(scale(link.axial, link.axis), drawn)
        return first if link.carried is None or matrix is None else plus(first, product(link.carried, matrix))

    def _own(
        self, k: Index, link: Link, turn: Matrix, mobility: Matrix, hit: _Disturbed | None = None
    ) -> None:
        """The blocks of link k itself, and what its disturbances and couples hand on."""
        hit = hit or self._disturbed(k, link)
        carts, wide = self.carts, link.carried is not None
        inverse, axial = link.inverse_length, link.axial
        drawn = applied(mobility, link.stretch)
        swung = applied(turn, drawn)
        lever = transposed(product(turn, mobility))
        across = cross(scale(self.length[k], load(self.turned, k)), link.q)
        arm = scale(inverse, link.q)
        pushed = transposed(tuple(cross(arm, column) for column in link.held))
        # omega_k' by q_k: J (P - I) y + J C s - alpha J w d^T - (a' - a) x / l
        spin = load(self.omega, k)
        x, y, z = sub(cross(load(self.turned, k), link.q), scale(dot(spin, spin), link.q))
        zero = self.builder.lift(0)
        hat: Matrix = (zero, -z, y), (z, zero, -x), (-y, x, zero)
        own = plus(scaled(link.multiplier, pushed), scaled(-1, outer(scale(axial, link.turned_axis), across)))
        own = minus(minus(own, product(transposed(lever), hit.force)), hat)
        # omega_k' by omega_k
        bent = add(scale(axial, swung), scale(-axial, link.turned_axis))
        rates = outer(bent, hit.doubled)
        for i in range(3):
            for j in range(3):
                place = (3 * k + carts + i) * self.nv + (3 * k + carts + j)
                self.dadq[place], self.dadv[place] = own[i][j], rates[i][j]
        if self._is_last(k):
            return
        shaken = applied(transposed(hit.force), drawn)
        unheld = product(mobility, hit.force) if wide else None
        reached = self._passed(link, swung, lever if wide else None)
        fresh_couple = plus(reached, transposed(pushed))
        left = self._passed(link, shaken, unheld)
        fresh_angle = minus(
            scaled(link.multiplier, link.held), plus(left, outer(scale(axial, link.axis), across))
        )
        freed = self._passed(link, (dot(link.stretch, drawn),), transposed((drawn,)) if wide else None)
        slack = tuple(axial * (row[0] - entry) for row, entry in zip(freed, link.axis, strict=True))
        fresh_rate = outer(slack, hit.doubled)
        self._hand_on(k, {"couple": fresh_couple, "angle": fresh_angle, "rate": fresh_rate})
        self._move(k, link, mobility, drawn)

    def _hand_on(self, k: Index, states: dict[str, Matrix]) -> None:
        lanes = {"couple": (self.couples, self.carts), "angle": (self.by_angle, 0), "rate": (self.by_rate, 0)}
        for name, matrix in states.items():
            if self.is_short:
                store_matrix(self.fresh[name], k, transposed(matrix))
                continue
            into, offset = lanes[name]
            for i, column in enumerate(transposed(matrix)):
                into.put(k, 3 * k + (offset + i), column)

    def _move(self, k: Index, link: Link, mobility: Matrix, drawn: Vector) -> None:
        """Omega of the next joint."""
        axial = link.axial
        if link.carried is None:
            share = axial * axial * dot(link.stretch, drawn)
            moved = outer(scale(share, link.axis), link.axis)
        else:
            half = self._passed(link, drawn, mobility)
            ahead = applied(half, link.stretch)
            moved = plus(outer(scale(axial, ahead), link.axis), product(half, link.carried))
        store(self.mobility, k, triangle(plus(link.held, moved)))

    def _step(self, k: Index) -> None:
        """Over link k."""
        link, carts = self.answers.link(k), self.carts
        turn, hit = turning(link), self._disturbed(k, link)
        mobility = symmetric(load(self.mobility, k - 1, 6))
        if self.is_short:
            self._step_short(k, link, turn, hit)
        else:
            with self.builder.loop("i", 0, 3 * k + carts) as loop:
                state = self.couples.at(k - 1, loop.index)
                self._mirrored(k, loop.index, state, hit)
                self._keep(self.couples, k, loop.index, self._reduced(link, state))
            for lanes, target in ((self.by_angle, self.dadq), (self.by_rate, self.dadv)):
                with self.builder.loop("j", 0, 3 * k) as loop:
                    state = lanes.at(k - 1, loop.index)
                    self._put(target, k, loop.index, applied(turn, state))
                    self._keep(lanes, k, loop.index, self._reduced(link, state))
            for i in range(carts):
                self._answer(k, i, applied(turn, self.couples.at(k - 1, i)))
        self._own(k, link, turn, mobility, hit)

    def _step_short(self, k: Index, link: Link, turn: Matrix, hit: _Disturbed) -> None:
        """Old columns are numbers, those of link k - 1 still vectors."""
        carts, before = self.carts, self.answers.link(k - 1).axis
        gain = self.builder.let("handed_on", link.axial * dot(link.stretch, before))
        turned = add(scale(gain, link.turned_axis), scale(-1, self.answers.turned_before(k)))
        force = applied(transposed(hit.force), before)
        doubled = scale(gain, hit.doubled)
        with self.builder.loop("i", 0, 3 * (k - 1) + carts) as loop:
            (state,) = self.couples.at(k - 1, loop.index)
            self._mirror(k, loop.index, scale(-state, force), scale(state, doubled))
            self._keep(self.couples, k, loop.index, (gain * state,))
        for lanes, target in ((self.by_angle, self.dadq), (self.by_rate, self.dadv)):
            with self.builder.loop("j", 0, 3 * (k - 1)) as loop:
                (state,) = lanes.at(k - 1, loop.index)
                self._put(target, k, loop.index, scale(state, turned))
                self._keep(lanes, k, loop.index, (gain * state,))
        for i in range(carts):
            (state,) = self.couples.at(k - 1, i)
            self._answer(k, i, scale(state, turned))
        for i in range(3):
            place = 3 * (k - 1) + i
            newest = load(self.fresh["couple"], place)
            self._mirrored(k, place + carts, newest, hit)
            self._keep(self.couples, k, place + carts, self._reduced(link, newest))
            for name, lanes, target in (
                ("angle", self.by_angle, self.dadq),
                ("rate", self.by_rate, self.dadv),
            ):
                newest = load(self.fresh[name], place)
                self._put(target, k, place, applied(turn, newest))
                self._keep(lanes, k, place, self._reduced(link, newest))

    def _put(self, target: ArrayRef, k: Index, column: Index, value: Vector) -> None:
        for i, entry in enumerate(value):
            target[(3 * k + self.carts + i) * self.nv + (column + self.carts)] = entry

    def _mirrored(self, k: Index, row: Index, state: Vector, hit: _Disturbed) -> None:
        """What the disturbances of link k do where the couple of a lane acts."""
        forces = applied(transposed(hit.force), state)
        self._mirror(k, row, scale(-1, forces), scale(dot(hit.along, state), hit.doubled))

    def _mirror(self, k: Index, row: Index, angle: Vector, rate: Vector) -> None:
        for j in range(3):
            place = row * self.nv + (3 * k + self.carts + j)
            self.dadq[place], self.dadv[place] = angle[j], rate[j]
