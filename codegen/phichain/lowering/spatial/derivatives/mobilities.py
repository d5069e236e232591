"""The derivatives of spatial accelerations with masses anywhere on their links: one vector a column goes over every link once.

The directions and rates of link j disturb that link, and its neighbours where joints transmit moments. What they do inside is one force
a column, F = (c, d), which goes inwards by P and is answered by the rows `inwards`; what they do beyond is the acceleration of a joint,
which goes outwards by T and is answered by the rows `outwards` (`passing`). On link j, s its tension and a, a' its ends,

    g = s (1 - q q^T) dq + dp,     e = -(a' - a).dq - 2 l omega.domega,     l domega' = dq x (a' - a) + q x (da' - da),

p = n / l of the couples n (`joints`); of the last link, held at its joint alone,

    c = a.dq + z q.dq - 2 r omega.domega,   d = m z (1 - q q^T) dq + dp / beta,   z = q.a - r w^2 the stretch,
    l domega' = dq x t + q x (dp / b - da / beta),   t = p / b - a / beta.

Where joints transmit nothing, rates act through e alone: one column a link stands for three.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from phichain.ir.builder import ArrayRef, Builder, Index
from phichain.lowering.algebra.matrix import (
    Matrix,
    applied,
    dyads,
    hat,
    load_matrix,
    minus,
    outer,
    plus,
    product,
    scalar,
    scaled,
    store_matrix,
    transposed,
    zero,
)
from phichain.lowering.algebra.vector import Vector, add, load, multiple, scale, store, sub, zeros
from phichain.lowering.chain.base import Carried
from phichain.lowering.spatial.derivatives.blocks import Blocks
from phichain.lowering.spatial.derivatives.joints import Joints
from phichain.lowering.spatial.derivatives.lanes import Lanes
from phichain.lowering.spatial.derivatives.passing import Passing, Recalled
from phichain.scene import Scene


class Lanewise:
    """Writes the derivatives of one chain after its sweep."""

    def __init__(self, builder: Builder, scene: Scene, base: Carried, sweep: Recalled, by_q: Blocks, by_v: Blocks) -> None:
        self.builder, self.scene, self.base, self.sweep = builder, scene, base, sweep
        self.parameters, self.links = base.parameters, scene.links
        self.by_q, self.by_v = by_q, by_v
        self.joints = None
        if sweep.moment is not None:
            self.joints = Joints(builder, base.scene, self.parameters, sweep.direction, sweep.rates.angular(), sweep.moment)
        self.reach = 0 if self.joints is None else 1
        self.offsets, self.columns = range(-self.reach, self.reach + 1), 4 if self.joints is None else 6
        self.load_of, self.force_of, self.motion_of = (
            {offset: builder.array(f"{name}_{offset + 1}", rows * self.columns * self.links) for offset in self.offsets if self.reach}
            for name, rows in (("load", 4), ("force_from", 4), ("motion_from", 3))
        )
        self.passing = Passing(sweep)
        wide = 3 if self.joints is not None else 1
        widths = {"by_direction": 3 * self.links, "by_rate": wide * self.links}
        self.forces = [Lanes(builder, f"force_{name}", width, "cxyz") for name, width in widths.items()]
        self.motions = [Lanes(builder, f"motion_{name}", width, "xyz") for name, width in widths.items()]
        self.load = builder.array("rate_load", 3 * self.links)

    def write(self) -> None:
        """All blocks of links."""
        with self.builder.loop("k", 0, self.links) as loop:
            k = loop.index
            store(self.load, k, multiple(-2 * self.parameters.length[k], load(self.sweep.rates.angular(), k)))
        for offset in reversed(self.offsets):
            self._each(offset, self._force if self.reach else self._alone)
        for offset in self.offsets if self.reach else ():
            self._each(offset, self._motion)
        self._outwards()
        self._inwards()

    # --- where columns begin ----------------------------------------------------------------------------------------------

    def _each(self, offset: int, do: Callable[[Index, int, bool], None]) -> None:
        """All links j that disturb link j + offset: the ones at the ends apart, `do` being told which link is the last."""
        first, last = max(0, -offset), self.links - 1 - max(0, offset)
        if (offset == 0 or (do == self._motion and offset == self.offsets[0])) and first < self.links - 1 - offset:
            do(first, offset, False)
            first += 1
        stop = min(last, self.links - 2 - offset) + 1
        with self.builder.loop("j", first, max(first, stop)) as loop:
            do(loop.index, offset, False)
        if last + offset == self.links - 1:
            do(last, offset, True)

    def _kept(self, arrays: dict[int, ArrayRef], j: Index, offset: int) -> Matrix:
        """4 x m or 3 x m numbers of link j + offset by link j."""
        cells = arrays[offset].size // (self.columns * self.links)
        entries = [arrays[offset][cells * self.columns * j + i] for i in range(cells * self.columns)]
        return tuple(tuple(entries[self.columns * i : self.columns * (i + 1)]) for i in range(cells))

    def _alone(self, j: Index, offset: int, is_last: bool) -> None:
        """All of link j where nothing else is disturbed."""
        loads = self._load(j, 0, is_last)
        force = self._inside(j, loads, None, is_last)
        self._put(self.forces, j, force)
        mobility = self.passing.at_joint(j)
        self._rows(j, 0, loads, None, None if mobility is None else scaled(-1, product(mobility, force)), is_last)

    def _force(self, j: Index, offset: int, is_last: bool) -> None:
        """The load of link j + offset by link j, and F there."""
        own, along = self._load(j, offset, is_last)
        unspread = zeros(self.builder, self.columns)
        store_matrix(self.load_of[offset], j, (*own, unspread if along is None or is_last else along))
        beyond = None if is_last or offset == self.offsets[-1] else self._kept(self.force_of, j, offset + 1)
        force = self._inside(j + offset, (own, along), beyond, is_last)
        store_matrix(self.force_of[offset], j, force)
        if offset == self.offsets[0] or (isinstance(j, int) and j + offset == 0):
            self._put(self.forces, j, force)

    def _motion(self, j: Index, offset: int, is_last: bool) -> None:
        """What link j + offset does where link j is disturbed."""
        *own, along = self._kept(self.load_of, j, offset)
        beyond = None if is_last or offset == self.offsets[-1] else self._kept(self.force_of, j, offset + 1)
        if offset == self.offsets[0] or (isinstance(j, int) and j + offset == 0):
            mobility = self.passing.at_joint(j + offset)
            before = None if mobility is None else scaled(-1, product(mobility, self._kept(self.force_of, j, offset)))
        else:
            before = self._kept(self.motion_of, j, offset - 1)
        self._rows(j, offset, (tuple(own), None if offset else along), beyond, before, is_last)

    def _rows(
        self, j: Index, offset: int, loads: tuple[Matrix, Vector | None], beyond: Matrix | None, before: Matrix | None, is_last: bool
    ) -> None:  # fmt: skip
        """Rows of link j + offset by link j, and what goes on from there."""
        k = j + offset
        after = self._moved(k, loads, beyond, before, is_last)
        change = after if before is None or is_last else minus(after, before)
        self._write(k, j, product(self.passing.turn(k), change), None if offset else self._own(k, is_last))
        if is_last:
            return
        if self.reach:
            store_matrix(self.motion_of[offset], j, after)
        if offset == self.offsets[-1]:
            self._put(self.motions, j, after)

    def _load(self, j: Index, offset: int, is_tip: bool) -> tuple[Matrix, Vector | None]:
        """g of link j + offset, and e of link j itself, by its direction and rates."""
        k = j + offset
        by_direction: Matrix = zero(self.builder)
        by_rate: Matrix = tuple((self.builder.lift(0),) for _ in range(3))
        if self.joints is not None:
            unit = self.sweep.inverse_length[k]
            by_direction, by_rate = (scaled(unit, found(k, -offset, is_tip)) for found in (self.joints.by_direction, self.joints.by_rate))
        if offset:
            return _beside(by_direction, by_rate), None
        rate = (self.builder.lift(1),) if self.joints is None else load(self.load, k)
        if is_tip:
            return _beside(by_direction, by_rate), rate
        own = scaled(self.sweep.axial[k] * self.sweep.stretch[k], self._across(k))
        spread = sub(load(self.sweep.joint, k), load(self.sweep.joint, k + 1))
        return _beside(plus(own, by_direction), by_rate), (*spread, *rate)

    def _across(self, k: Index) -> Matrix:
        """1 - q q^T: a pair of forces along q does nothing but to the tension, and a large one would leave a difference."""
        q = load(self.sweep.direction, k)
        return minus(scalar(self.builder.lift(1)), dyads(q, q))

    def _inside(self, k: Index, own: tuple[Matrix, Vector | None], force: Matrix | None, is_tip: bool) -> Matrix:
        """F of a link: what its load and that of what is beyond asks for at its joint."""
        (pair, along), sweep, nothing = own, self.sweep, self.builder.lift(0)
        if is_tip:
            asked = scaled(self.passing.over_reach, pair)
            if along is None:
                return (tuple(nothing for _ in pair[0]), *asked)
            q, joint, mass, com = load(sweep.direction, k), load(sweep.joint, k), self.parameters.mass[k], self.parameters.com[k]
            drawn = sweep.stretch[k]
            held = _beside(scaled(mass * drawn, self._across(k)), tuple(tuple(nothing for _ in along) for _ in range(3)))
            by_direction = add(joint, scale(drawn, q))
            return ((*by_direction, *scale(com / self.parameters.length[k], along)), *plus(asked, held))
        stretched = scale(-1, applied(transposed(pair), load(sweep.tension_axis, k)))
        pushed = minus(pair, scaled(sweep.scales.lean[k], product(self.passing.kept_mobility(k), pair)))
        asked = (stretched if along is None else add(stretched, along), *pushed)
        return asked if force is None else plus(asked, product(self.passing.passed_force(k), force))

    def _moved(
        self, k: Index, own: tuple[Matrix, Vector | None], force: Matrix | None, motion: Matrix | None, is_tip: bool
    ) -> Matrix:  # fmt: skip
        """da' of a link; of the last one what its direction is crossed with."""
        (pair, along), passing, sweep = own, self.passing, self.sweep
        after = product(passing.freedom(k), pair)
        if force is not None:
            after = minus(after, product(passing.freed(k), force))
        if is_tip:
            return after if motion is None else minus(after, scaled(self.passing.over_reach, motion))
        if motion is not None:
            after = plus(product(passing.passed(k), motion), after)
        if along is not None:
            after = plus(after, outer(scale(sweep.axial[k], load(sweep.tension_axis, k)), along))
        return after

    def _own(self, k: Index, is_tip: bool) -> Matrix:
        """-hat(a' - a) / l."""
        sweep, unit = self.sweep, self.sweep.inverse_length[k]
        joint = load(sweep.joint, k)
        if not is_tip:
            return hat(self.builder, scale(unit, sub(joint, load(sweep.joint, k + 1))))
        turned = scale(self.passing.over_reach, joint)
        if sweep.pair is not None:
            turned = sub(turned, scale(1 / sweep.scales.own[k], load(sweep.pair, k)))
        return hat(self.builder, scale(unit, turned))

    def _put(self, lanes: list[Lanes], j: Index, value: Matrix) -> None:
        columns = transposed(value)
        for i, column in enumerate(columns[:3]):
            lanes[0].put(3 * j + i, column)
        for i, column in enumerate(columns[3:]):
            lanes[1].put(len(columns[3:]) * j + i, column)

    def _write(self, k: Index, j: Index, rows: Matrix, own: Matrix | None) -> None:
        by_direction, by_rate = tuple(row[:3] for row in rows), tuple(row[3:] for row in rows)
        self.by_q.put(k, j, by_direction if own is None else plus(by_direction, own))
        if self.joints is None:
            by_rate = outer(tuple(row[0] for row in by_rate), load(self.load, j))
        self.by_v.put(k, j, by_rate)

    # --- where they go ----------------------------------------------------------------------------------------------------

    def _outwards(self) -> None:
        """Rows beyond."""
        last, first = self.links - 1, 1 + self.reach
        with self.builder.loop("k", first, last) as loop:
            k = loop.index
            self._over(k, load_matrix(self.passing.outwards, k), self.motions, self.passing.passed(k), (0, k - self.reach))
        if last >= first:
            held = scaled(-self.passing.over_reach, self.passing.turn(last))
            self._over(last, held, self.motions, None, (0, last - self.reach))

    def _inwards(self) -> None:
        """Rows inside."""
        last = self.links - 2 - self.reach
        stop = -1 if self.sweep.cart is not None else 0
        with self.builder.loop("k", last, stop, -1) as loop:
            k = loop.index
            self._over(k, self._rows_inwards(k), self.forces, self.passing.passed_force(k), (k + (1 + self.reach), self.links))
        if stop == 0 and last >= 0:
            self._over(0, self._rows_inwards(0), self.forces, None, (1 + self.reach, self.links))

    def _rows_inwards(self, k: Index) -> Matrix:
        entries = [self.passing.inwards[12 * k + i] for i in range(12)]
        return tuple(tuple(entries[4 * i : 4 * i + 4]) for i in range(3))

    def _over(self, k: Index, answer: Matrix, lanes: list[Lanes], through: Matrix | None, columns: tuple[Index, Index]) -> None:
        """All columns of these links over link k: their entries of its rows, and on, unless it is the end."""
        start, stop = columns
        with self.builder.loop("c", 3 * start, 3 * stop) as loop:
            self._advance(lanes[0], loop.index, answer, through, partial(self._put_column, self.by_q, k))
        if self.joints is not None:
            with self.builder.loop("c", 3 * start, 3 * stop) as loop:
                self._advance(lanes[1], loop.index, answer, through, partial(self._put_column, self.by_v, k))
            return
        with self.builder.loop("j", start, stop) as loop:
            self._advance(lanes[1], loop.index, answer, through, lambda j, entries: self.by_v.put(k, j, outer(entries, load(self.load, j))))

    def _put_column(self, target: Blocks, k: Index, column: Index, entries: Vector) -> None:
        for r, entry in enumerate(entries):
            target.entry(3 * k + r, column, entry)

    def _advance(
        self, lanes: Lanes, column: Index, answer: Matrix, through: Matrix | None, put: Callable[[Index, Vector], None]
    ) -> None:  # fmt: skip
        """One column over one link. Its cells are written anew, so what is read of them has to be written or named before."""
        value = lanes.at(column)
        moved = None if through is None else tuple(self.builder.let("moved", entry) for entry in applied(through, value))
        put(column, applied(answer, value))
        if moved is not None:
            lanes.put(column, moved)


def _beside(left: Matrix, right: Matrix) -> Matrix:
    """[left, right]"""
    return tuple((*a, *b) for a, b in zip(left, right, strict=True))
