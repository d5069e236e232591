"""Blocks of close links where joints transmit moments as well (`columns`): a direction or rate moves the couples of three links, as
pairs of forces p on both their ends, and so loads five rows of tensions.

    l_k omega_k' = q_k x S_k,    S_k = L_{k-1} q_{k-1} + rho_{k+1} L_{k+1} q_{k+1} + (p_k - p_{k+1}) / m_k + (p_k - p_{k-1}) / m_{k-1},
    b_k = l_k |omega_k|^2 - q_k.p_{k+1} / m_k - q_k.p_{k-1} / m_{k-1},

with g e_3 - C x'' for the tension and mass before link 0, and x'' = f / m_c + (m_0 L_0 h - h.p_0) / m_c. What is beyond either end is zero
in arrays that reach further, so that all links are alike.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.lowering.algebra.matrix import (
    Matrix,
    applied,
    hat,
    load_matrix,
    minus,
    plus,
    product,
    scalar,
    scaled,
    store_matrix,
    transposed,
    zero,
)
from phichain.lowering.algebra.matrix import outer as dyad
from phichain.lowering.algebra.vector import Vector, add, load, scale, store, sub, zeros
from phichain.lowering.spatial import tension
from phichain.lowering.spatial.derivatives.blocks import Blocks
from phichain.lowering.spatial.derivatives.columns import Columns
from phichain.lowering.spatial.derivatives.joints import Joints
from phichain.lowering.spatial.derivatives.response import Answers
from phichain.scene import Scene

#: How far arrays reach beyond either end of the chain.
_PAD = 3


class Tied(Columns):
    """Writes the derivatives of a chain with springs, dampers or dry friction.

    `rows` holds what the rows from three before a link to three beyond it answer to its direction and to its rates, `pairs` how p_k moves
    with the direction and rates of the link before, with its own, and with the next one's.
    """

    reach = 2

    def __init__(
        self, builder: Builder, scene: Scene, chain: tension.Chain, found: Answers, cart: tuple[Expr, Expr] | None, joints: Joints
    ) -> None:
        super().__init__(builder, scene, chain, found, cart)
        links, pair = self.links, chain.pair
        assert pair is not None
        self.joints = joints
        self.rate_next, self.rate_back = (builder.array(f"by_rate_{name}", 3 * links) for name in ("next", "back"))
        self.rows = {row: builder.array(f"answer_{row + _PAD}", 6 * links) for row in range(-_PAD, _PAD + 1)}
        self.pairs = {of: builder.array(f"pair_slope_{of + 1}", 18 * (links + 2)).shifted(18) for of in (-1, 0, 1)}
        self.over_mass = self._known("over_mass", lambda k: 1 / self.parameters.mass[k], 0)
        self.unit = self._padded("unit", lambda k: load(chain.direction, k))
        self.pair = self._padded("pair", lambda k: load(pair, k))
        self.compliance = self._padded("own_compliance", lambda k: (found.diagonal[k],))
        self.onward = self._padded("onward_share", lambda k: (found.outer[k],), 1)
        self.backward = self._padded("backward_share", lambda k: (found.inner[k + 1],), -1, links - 1)
        self.inner_pull = self._padded("inner_pull", lambda k: (self.pulls[k],))
        self.outer_pull = self._padded("outer_pull", lambda k: (self.rho[k] * self.pulls[k],), 1)
        self.past_load = self._padded("past_size_load", lambda k: (found.past_load[k],), 1)
        self.short_load = self._padded("short_size_load", lambda k: (found.short_load[k],), 1)

    def _known(self, name: str, entry: Callable[[Index], Expr], first: int) -> ArrayRef:
        """A padded table of numbers, constants where they are known."""
        if isinstance(self.scene.mass, str):
            return self._padded(name, lambda k: (entry(k),), first)
        known = [entry(k).constant or Fraction(0) for k in range(first, self.links)]
        around = [Fraction(0)] * _PAD
        return self.builder.constants(name, [*around, *([Fraction(0)] * first), *known, *around]).shifted(_PAD)

    def _padded(self, name: str, entry: Callable[[Index], Vector], first: int = 0, stop: int | None = None) -> ArrayRef:
        """An array with zeros beyond its ends."""
        links, size = self.links, len(entry(first))
        stop = links if stop is None else stop
        cells = self.builder.array(name, size * (links + 2 * _PAD)).shifted(size * _PAD)
        for k in (*range(-_PAD, first), *range(stop, links + _PAD)):
            store(cells, k, zeros(self.builder, size))
        with self.builder.loop("k", first, stop) as loop:
            store(cells, loop.index, entry(loop.index))
        return cells

    def near(self, beside: ArrayRef, by_q: Blocks, by_v: Blocks) -> None:
        """Blocks of links that are at most two apart."""
        self._move_pairs()
        first = 1 if self.cart is None else 2
        for j in range(min(first, self.links)):
            self._answer(j, load(beside, 0) if j == 0 else None)
        with self.builder.loop("j", first, self.links) as loop:
            self._answer(loop.index, None)
        for apart in range(-2, 3):
            start, stop = max(0, -apart), self.links - max(0, apart)
            if start + apart == 0 and start < stop:
                self._block(start, apart, by_q, by_v, load(beside, 0))
                start += 1
            with self.builder.loop("j", start, stop) as loop:
                self._block(loop.index, apart, by_q, by_v, None)

    def _rate_next(self, j: Index) -> Vector:
        return load(self.rate_next, j)

    def _rate_back(self, j: Index) -> Vector:
        return load(self.rate_back, j)

    # --- loads and answers ------------------------------------------------------------------------------------------------

    def _move_pairs(self) -> None:
        """dp_k by the link before, its own and the next one, zero beyond the ends."""
        links, last, nothing = self.links, self.links - 1, zeros(self.builder, 18)
        for of, cells in self.pairs.items():
            beyond = {-1: (-1, 0, links), 0: (-1, links), 1: (-1, last, links)}[of]
            for k in beyond:
                store(cells, k, nothing)
            for k in (0, last) if of == 0 else ():
                self._move_pair(k, of, k == last)
            with self.builder.loop("k", 1 if of < 1 else 0, links if of < 0 else last) as loop:
                self._move_pair(loop.index, of, False)

    def _move_pair(self, k: Index, of: int, is_tip: bool) -> None:
        for part, found in enumerate((self.joints.by_direction, self.joints.by_rate)):
            store_matrix(self.pairs[of], 2 * k + part, scaled(self.inverse_length[k], found(k, of, is_tip)))

    def _moved(self, k: Index, of: int) -> tuple[Matrix, Matrix] | None:
        """dp_k by the direction and by the rates of link k + of."""
        if abs(of) > 1:
            return None
        return load_matrix(self.pairs[of], 2 * k), load_matrix(self.pairs[of], 2 * k + 1)

    def _loads(self, j: Index, row: int, fall: Vector | None) -> list[Vector]:
        """What row j + row is loaded with by the direction and by the rates of link j."""
        k, here = j + row, load(self.unit, j + row)
        found = [zeros(self.builder, 3), zeros(self.builder, 3)]
        pushes = [(self._moved(k + 1, -row - 1), -self.over_mass[k]), (self._moved(k - 1, 1 - row), -self.over_mass[k - 1])]
        if self.cart is not None and k == 0:
            pushes.append((self._moved(k, -row), 1 / self.parameters.base_mass))
        for number, (pairs, weight) in enumerate(pushes):
            push = scale(weight, here if number < 2 else (here[0], here[1], self.builder.lift(0)))
            for part, moved in enumerate(pairs or ()):
                found[part] = add(found[part], applied(transposed(moved), push))
        before, own, after = (load(self.unit, j + i) for i in (-1, 0, 1))
        if row == -1:
            found[0] = add(found[0], add(scale(self.outer_pull[j], before), scale(self.short_load[j], own)))
        elif row == 1:
            found[0] = add(found[0], add(scale(self.inner_pull[j], after), scale(self.past_load[j + 1], own)))
        elif row == 0:
            drawn = add(scale(self.outer_pull[j + 1], after), scale(self.past_load[j] + self.short_load[j + 1], own))
            drawn = add(drawn, scale(self.inner_pull[j - 1], before) if fall is None else fall)
            drawn = sub(drawn, scale(self.over_mass[j], load(self.pair, j + 1)))
            found[0] = add(found[0], sub(drawn, scale(self.over_mass[j - 1], load(self.pair, j - 1))))
            found[1] = add(found[1], scale(2 * self.parameters.length[j], load(self.chain.rates.angular(), j)))
        return found

    def _answer(self, j: Index, fall: Vector | None) -> None:
        """What all rows that link j loads answer, and one more on either side."""
        loads = {row: self._loads(j, row, fall) for row in range(-2, 3)}
        for part in range(2):
            own = {row: scale(self.compliance[j + row], loads[row][part]) for row in loads}
            onward, backward = {-2: own[-2]}, {2: own[2]}
            for row in range(-1, 3):
                onward[row] = add(scale(self.onward[j + row], onward[row - 1]), own[row])
            for row in range(1, -3, -1):
                backward[row] = add(scale(self.backward[j + row], backward[row + 1]), own[row])
            found = {row: add(onward[row], scale(self.backward[j + row], backward[row + 1])) for row in range(-2, 2)}
            found |= {2: onward[2], 3: scale(self.onward[j + 3], onward[2]), -3: scale(self.backward[j - 3], backward[-2])}
            for row, value in found.items():
                store(self.rows[row], 2 * j + part, value)
            store((self.next, self.rate_next)[part], j, found[2])
            store((self.back, self.rate_back)[part], j, found[-2])

    # --- blocks -----------------------------------------------------------------------------------------------------------

    def _around(self, k: Index) -> tuple[Vector, Vector]:
        """X_k / l_k and -rho_{k+1} X_{k+1} / l_k."""
        unit, crosses = self.inverse_length[k], self.chain.crosses
        return scale(unit, load(crosses, k)), scale(-(unit * self.rho[k + 1]), load(crosses, k + 1))

    def _block(self, j: Index, apart: int, by_q: Blocks, by_v: Blocks, fall: Vector | None) -> None:
        """Blocks of link j + apart by link j; `fall` is given for the first link's rows."""
        i, builder = j + apart, self.builder
        inner, outer = self._around(i)
        on_cart = self.cart is not None and fall is not None
        turn = hat(builder, scale(self.inverse_length[i], load(self.unit, i)))
        pushes = [(self._moved(i, -apart), self.over_mass[i] + self.over_mass[i - 1])]
        pushes += [(self._moved(i + 1, -apart - 1), -self.over_mass[i]), (self._moved(i - 1, 1 - apart), -self.over_mass[i - 1])]
        for part, target in enumerate((by_q, by_v)):
            change = zero(builder)
            for moved, weight in pushes:
                if moved is not None:
                    change = plus(change, scaled(weight, moved[part]))
            if on_cart and (moved := self._moved(i, -apart)) is not None:
                change = plus(change, _horizontal(scaled(1 / self.parameters.base_mass, moved[part])))
            if part == 0 and abs(apart) == 1:
                change = plus(change, scalar((self.inner_pull if apart > 0 else self.outer_pull)[j]))
            if part == 0 and apart == 0 and on_cart:
                change = minus(change, _horizontal(scalar(self._cart_pull())))
            block = product(turn, change)
            if part == 0 and apart == 0:
                block = minus(block, hat(builder, scale(self.inverse_length[i], self._pull(i, fall))))
            block = plus(block, dyad(inner, load(self.rows[apart - 1], 2 * j + part)), dyad(outer, load(self.rows[apart + 1], 2 * j + part)))
            target.put(i, j, block)

    def _pull(self, k: Index, fall: Vector | None) -> Vector:
        """S_k."""
        if fall is None:
            pull = scale(self.inner_pull[k - 1], load(self.unit, k - 1))
        elif self.cart is None:
            pull = fall
        else:
            pull = (-self.cart[0], -self.cart[1], self.parameters.fall[2])
        pull = add(pull, scale(self.outer_pull[k + 1], load(self.unit, k + 1)))
        before, own, after = (load(self.pair, k + i) for i in (-1, 0, 1))
        pull = add(pull, scale(self.over_mass[k], sub(own, after)))
        return add(pull, scale(self.over_mass[k - 1], sub(own, before)))

    def _first_cart_rows(self, by_q: Blocks, by_v: Blocks) -> None:
        ratio, length = self._cart_ratio(), self.parameters.units.length
        for j in range(min(2, self.links)):
            moved = self._moved(0, j)
            assert moved is not None
            for part, target in enumerate((by_q, by_v)):
                answer = load(self.rows[-j], 2 * j + part)
                pulled = scaled(-1 / self.parameters.base_mass, moved[part])
                for row in range(2):
                    value = add(scale(ratio * self.chain.direction[row], answer), pulled[row])
                    for c, entry in enumerate(value):
                        own = entry + self._cart_pull() if part == 0 and j == 0 and c == row else entry
                        target.array[3 * j + (row * target.width + target.first + c)] = own * length


def _horizontal(matrix: Matrix) -> Matrix:
    """C C^T matrix, its horizontal rows."""
    nothing = matrix[0][0].builder.lift(0)
    return matrix[0], matrix[1], (nothing, nothing, nothing)
