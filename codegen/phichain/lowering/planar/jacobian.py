"""Derivatives of the planar accelerations from one factorisation: every column goes over the links as two numbers.

Column m of a derivative is a sum of disturbances at single joints (`disturbances`). At joint k one is a force eta on the chain inside,
seen at joint k - 1, and a turn -zeta of link k - 1; what it does inside is by reciprocity read off what unit couples inside do at
joint k - 1 (lanes Y below): - eta.Y - zeta. What it does beyond is one state X that goes outwards. So every entry is one product
of two pairs, and every state goes over every link once: about 20 operations for the entries of all three derivatives together.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.lowering.chain.room import saves_memory
from phichain.lowering.planar.disturbances import Column, Jump
from phichain.lowering.planar.response import Base, Pair, Response, dot
from phichain.scene import Scene

#: Links up to which every state has memory of its own; beyond, two rows of states are written and read in turn.
LONGEST_KEPT = 48


@dataclass
class Target:
    """A matrix of results: where its links' part begins, and its row length."""

    array: ArrayRef
    first_column: int
    width: int

    def put(self, row: Index, column: Index, value: Expr | int) -> None:
        """Write an entry; rows are counted from the cart."""
        self.array[row * self.width + self.first_column + column] = value

    def at(self, row: Index, column: Index) -> Expr:
        return self.array[row * self.width + self.first_column + column]


class Lanes:
    """States of columns side by side: one row of cells a link, two rows in turn for a long chain, or one that is written anew."""

    def __init__(self, builder: Builder, name: str, width: int, links: int, in_place: bool) -> None:
        self.width, self.in_place, self.takes_turns = width, in_place, links > LONGEST_KEPT and not in_place
        rows = 1 if self.takes_turns or in_place else links
        names = (f"{name}_even", f"{name}_odd") if self.takes_turns else (name,)
        self.cells = [tuple(builder.array(f"{part}_{axis}", width * rows) for axis in "xy") for part in names]

    def put(self, row: Index, column: Index, value: Pair) -> None:
        for cells, entry in zip(self.cells[self._turn(row)], value, strict=True):
            cells[self._place(row, column)] = entry

    def at(self, row: Index, column: Index) -> Pair:
        x, y = self.cells[self._turn(row)]
        place = self._place(row, column)
        return x[place], y[place]

    def _turn(self, row: Index) -> int:
        """Rows that loops count step by two links, so that their offset tells even from odd."""
        return (row if isinstance(row, int) else row.offset) % 2 if self.takes_turns else 0

    def _place(self, row: Index, column: Index) -> Index:
        return column if self.takes_turns or self.in_place else row * self.width + column


_MOBILITY: Final = ("mobility_xx", "mobility_xy", "mobility_yy")


class Columns:
    """Writes the derivatives, link by link from the base."""

    def __init__(
        self, builder: Builder, scene: Scene, response: Response, base: Base, length: Expr,
        sides: list[tuple[Column, Target]], compliance: Target | None,
    ) -> None:  # fmt: skip
        self.builder, self.scene, self.response, self.base, self.length = builder, scene, response, base, length
        self.sides, self.compliance = sides, compliance
        self.carts, links = int(scene.has_cart), scene.links
        self.relative, self.adjacent = scene.angles == "relative", scene.angles == "adjacent"
        # Memory is dear on a target. Only where the cells of a row are read before they are written anew does one row do.
        self.in_place = saves_memory(scene) and self.relative
        self.couples = Lanes(builder, "couple_state", links + self.carts, links, self.in_place)
        self.states = [Lanes(builder, f"{column.name}_state", links, links, self.in_place) for column, _ in sides]
        #: Omega of the joints, and that of the last joint alone where memory is dear.
        self.mobility = [] if self.in_place else [builder.array(name, links) for name in _MOBILITY]
        self.held: tuple[Expr, ...] = ()

    def write(self) -> None:
        """All rows and columns of links; on a cart its own row and column too."""
        self._first()
        peeled = max([1, *(column.reach for column, _ in self.sides)])
        links = self.scene.links
        for k in range(1, min(peeled, links)):
            self._step(k, k)
        if links > LONGEST_KEPT and not self.in_place:
            pairs = (links - peeled) // 2
            with self.builder.loop("pair", 0, pairs) as loop:
                for after in range(2):
                    self._step(2 * loop.index + (peeled + after), peeled)
            for k in range(peeled + 2 * pairs, links):
                self._step(k, peeled)
        elif links > peeled:
            with self.builder.loop("k", peeled, links) as loop:
                carried = [loop.carry(name, value) for name, value in zip(_MOBILITY, self.held, strict=False)]
                self.held = tuple(carried)
                self._step(loop.index, peeled)
                for carry, following in zip(carried, self.held, strict=True):
                    loop.follow(carry, following)

    # --- the base ---------------------------------------------------------------------------------------------------------

    def _first(self) -> None:
        response, base, zero = self.response, self.base, self.response.nothing
        turn, rho = response.turn(0), response.rho(0)
        squares = turn[0] * turn[0], turn[0] * turn[1], turn[1] * turn[1]
        self._hold(0, (base.mobile * value for value in squares))
        mobile = response.arrays["link_mobility"][0]
        lean = base.mobile * dot(turn, rho)
        self.couples.put(0, self.carts, (-(lean * turn[0]), -(lean * turn[1])))
        if self.compliance is not None:
            self.compliance.put(self.carts, self.carts, mobile + lean * dot(turn, rho))
        if self.carts:
            slide = self.length * base.mobile
            state = slide * turn[0], slide * turn[1]
            self.couples.put(0, 0, state)
            if self.compliance is not None:
                self.compliance.put(0, 0, slide * self.length)
                self._both(0, 0, -(self.length * lean))
        for (column, target), lanes in zip(self.sides, self.states, strict=True):
            jump, own = column.start(0), column.along(0, 0)
            state = self._beyond(0, (zero, zero), jump)
            lanes.put(0, 0, state)
            target.put(self.carts, 0, self._own(0, own) - dot(rho, state))
            if self.carts:
                target.put(0, 0, self.length * (jump.phi - base.gain * jump.x))

    def _beyond(self, k: Index, before: Pair, jump: Jump) -> Pair:
        """X of joint k, from that of joint k - 1."""
        turn, response = self.response.turn(k), self.response
        free = jump.phi + jump.y
        if isinstance(k, int) and k == 0 and not self.carts:
            aside = response.nothing if self.base.tip[1].is_zero else jump.x
            return free * turn[0] + aside * turn[1], free * turn[1] - aside * turn[0]
        x = response.outwards(k, (before[0] + jump.x, before[1]))
        return x[0] + free * turn[0], x[1] + free * turn[1]

    def _own(self, k: Index, jump: Jump) -> Expr:
        """phi - gain_x d_x of link k."""
        return jump.phi - self.response.sweep.gain_x[k] * jump.x

    # --- links ------------------------------------------------------------------------------------------------------------

    def _step(self, k: Index, known: int) -> None:
        """Over link k - 1 to link k; `known` lags surely exist."""
        response, builder = self.response, self.builder
        sigma = response.row(k, self.relative)
        lean = response.arrays["joint_gain"][k]
        before, mobile = response.arrays["link_mobility"][k - 1], response.arrays["link_mobility"][k]
        lever = builder.let("joint_lever", 1 + lean) if self.relative else lean
        omega = builder.let("joint_mobility", before * lever)
        mobility = self.held or tuple(cells[k - 1] for cells in self.mobility)
        self._hold(k, self._moved_mobility(k, mobility, before))
        self._couples(k, sigma, omega, before)
        for (column, target), lanes in zip(self.sides, self.states, strict=True):
            self._columns(k, known, column, target, lanes, sigma, mobility)
        answer = _times(mobility, sigma)
        turn = response.turn(k)
        state = response.outwards(k, answer)
        state = state[0] - omega * turn[0], state[1] - omega * turn[1]
        diagonal = mobile + dot(sigma, answer) + omega * lever
        if self.adjacent:
            self._adjacent_couple(k, answer, omega, turn)
            return
        self.couples.put(k, k + self.carts, state)
        if self.compliance is not None:
            self.compliance.put(k + self.carts, k + self.carts, diagonal)

    def _adjacent_couple(self, k: Index, answer: Pair, omega: Expr, turn: Pair) -> None:
        """Y of the adjacent angle: that of a couple on link k less the one before."""
        response, carts = self.response, self.carts
        moved = self.couples.at(k, k - 1 + carts)
        own = response.outwards(k, answer)
        state = own[0] - omega * turn[0] - moved[0], own[1] - omega * turn[1] - moved[1]
        self.couples.put(k, k + carts, state)
        if self.compliance is not None:
            mixed = self.compliance.at(k + carts, k - 1 + carts)
            alpha = response.arrays["link_mobility"][k] - dot(response.rho(k), state)
            self.compliance.put(k + carts, k + carts, alpha - mixed)

    def _moved_mobility(self, k: Index, mobility: tuple[Expr, ...], before: Expr) -> Iterator[Expr]:
        """Omega_k = T Omega T^T + n n^T / D, entry by entry."""
        response, turn = self.response, self.response.turn(k)
        a, b, c, d = response.matrix(k)
        first = response.outwards(k, (mobility[0], mobility[1]))
        second = response.outwards(k, (mobility[1], mobility[2]))
        own = before * turn[0], before * turn[1]
        yield first[0] * a + second[0] * b + own[0] * turn[0]
        yield first[0] * c + second[0] * d + own[0] * turn[1]
        yield first[1] * c + second[1] * d + own[1] * turn[1]

    def _hold(self, k: Index, omega: Iterator[Expr]) -> None:
        """Keep the entries of Omega_k for the next joint."""
        held = []
        for number, value in enumerate(omega):
            held.append(value)
            if self.mobility:
                self.mobility[number][k] = value
        self.held = tuple(held) if self.in_place else ()

    def _columns(
        self, k: Index, known: int, column: Column, target: Target, lanes: Lanes, sigma: Pair, mobility: tuple[Expr, ...]
    ) -> None:  # fmt: skip
        """All columns of one derivative that are not beyond link k."""
        special = min(column.reach, known)
        common = column.common(k - 1), column.common(k)
        with self.builder.loop("j", 0, k - column.reach if special == column.reach else 0) as loop:
            self._advance(k, loop.index, target, lanes, lanes.at(k - 1, loop.index), sigma, common)
        for lag in range(special, 0, -1):
            jumps = column.along(k - 1, lag - 1), column.along(k, lag)
            self._advance(k, k - lag, target, lanes, lanes.at(k - 1, k - lag), sigma, jumps)
        inside = _times(mobility, column.eta(k))
        state = -inside[0], -inside[1]
        self._advance(k, k, target, lanes, state, sigma, (column.start(k), column.along(k, 0)))

    def _advance(
        self, k: Index, j: Index, target: Target, lanes: Lanes, before: Pair, sigma: Pair, jumps: tuple[Jump, Jump]
    ) -> None:  # fmt: skip
        """One column over one link: its entry of row k and its state at joint k."""
        jump, after = jumps
        response, carts = self.response, self.carts
        lean = response.arrays["joint_gain"][k]
        shifted = before[0] + jump.x, before[1]
        free = jump.phi + jump.y
        entry = dot(sigma, shifted) + (self._own(k, after) - free * lean)
        if self.relative:
            entry = entry - jump.phi
        after_link = self._beyond(k, before, jump)
        if self.in_place:
            after_link = self._named(after_link)
            target.put(k + carts, j, entry)
            lanes.put(k, j, after_link)
            return
        lanes.put(k, j, after_link)
        target.put(k + carts, j, entry - target.at(k - 1 + carts, j) if self.adjacent else entry)

    def _named(self, state: Pair) -> Pair:
        """Values that are computed before either of their cells is written."""
        return self.builder.let("moved_x", state[0]), self.builder.let("moved_y", state[1])

    def _couples(self, k: Index, sigma: Pair, omega: Expr, before: Expr) -> None:
        """Unit couples inside: what they do at link k, and what the columns of joint k do where they act."""
        carts, response = self.carts, self.response
        with self.builder.loop("i", 0, k - 1 + carts) as loop:
            i = loop.index
            state = self.couples.at(k - 1, i)
            self._pass_on(k, i, response.outwards(k, state), state, sigma, None)
        newest = k - 1 + carts
        state, turn = self.couples.at(k - 1, newest), response.turn(k)
        moved = response.outwards(k, state)
        self._pass_on(k, newest, (moved[0] + before * turn[0], moved[1] + before * turn[1]), state, sigma, omega)

    def _pass_on(self, k: Index, i: Index, moved: Pair, state: Pair, sigma: Pair, omega: Expr | None) -> None:
        """One lane goes on over link k, and what it says of the columns there."""
        if self.in_place:
            moved = self._named(moved)
            self._reciprocal(k, i, state, sigma, omega)
            self.couples.put(k, i, moved)
            return
        self.couples.put(k, i, moved)
        self._reciprocal(k, i, state, sigma, omega)

    def _reciprocal(self, k: Index, i: Index, state: Pair, sigma: Pair, omega: Expr | None) -> None:
        """One lane: the entries of row i that columns of joint k have, and that of the lane itself in row k."""
        for column, target in self.sides:
            entry = -dot(column.eta(k), state)
            if omega is not None:
                start = column.start(k)
                entry = entry + (start.phi - self.response.sweep.gain_x[k - 1] * start.x)
            target.put(i, k, entry)
        if self.compliance is not None:
            entry = dot(sigma, state)
            self._both(k, i, entry if omega is None else entry - omega)

    def _both(self, k: Index, i: Index, entry: Expr) -> None:
        compliance, carts = self.compliance, self.carts
        assert compliance is not None
        if self.adjacent and not (isinstance(k, int) and k == 0):
            entry = entry - compliance.at(k - 1 + carts, i)
        compliance.put(k + carts, i, entry)
        compliance.put(i, k + carts, entry)


def _times(matrix: tuple[Expr, ...], vector: Pair) -> Pair:
    xx, xy, yy = matrix
    return xx * vector[0] + xy * vector[1], xy * vector[0] + yy * vector[1]
