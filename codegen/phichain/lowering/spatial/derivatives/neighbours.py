"""Blocks of neighbours where tensions alone tie the links (`columns`): a direction loads the rows of its own link and both neighbours."""

from __future__ import annotations

from collections.abc import Callable

from phichain.ir.builder import ArrayRef, Index
from phichain.lowering.algebra.matrix import Matrix, hat, plus
from phichain.lowering.algebra.matrix import outer as dyad
from phichain.lowering.algebra.vector import Vector, add, load, named, scale, store
from phichain.lowering.spatial.derivatives.blocks import Blocks
from phichain.lowering.spatial.derivatives.columns import Columns


class Neighbours(Columns):
    """Writes the derivatives of a chain whose joints transmit no moments."""

    def near(self, beside: ArrayRef, by_q: Blocks, by_v: Blocks) -> None:
        """Blocks of links that are at most one apart."""
        self._links(beside, by_q, by_v)
        self._joints(by_q, by_v)

    def _links(self, beside: ArrayRef, by_q: Blocks, by_v: Blocks) -> None:
        """The tensions' answers to every direction, and the blocks on the diagonal."""
        builder, found = self.builder, self.found
        own = self._own()
        with builder.loop("k", 0, self.links) as loop:
            k = loop.index
            before, q, after = (load(beside, k + i) for i in range(3))
            from_before = named(builder, "from_before", add(scale(found.past[k], before), scale(found.past_size[k], q)))
            from_after = named(builder, "from_after", add(scale(found.short[k + 1], after), scale(found.short_size[k + 1], q)))
            here = add(from_before, from_after)
            onward = add(scale(found.past[k + 1], after), scale(found.past_size[k + 1], q))
            onward = add(scale(found.outer[k + 1], from_before), onward)
            back = add(scale(found.short[k], before), scale(found.short_size[k], q))
            back = add(scale(found.inner[k], from_after), back)
            store(self.here, k, here)
            store(self.next, k, onward)
            store(self.back, k, back)
            inner, outer = self._around(k)
            block = plus(dyad(inner, back), dyad(outer, onward))
            by_q.put(k, k, plus(block, own(k)))
            omega = self._load(k)
            answer = add(scale(found.inner[k], inner), scale(found.outer[k + 1], outer))
            by_v.put(k, k, dyad(answer, omega))

    def _around(self, k: Index) -> tuple[Vector, Vector]:
        """X_k / l_k and -rho_{k+1} X_{k+1} / l_k: how the tensions on both sides of a link turn it."""
        unit, crosses = self.inverse_length[k], self.chain.crosses
        return scale(unit, load(crosses, k)), scale(-(unit * self.rho[k + 1]), load(crosses, k + 1))

    def _load(self, k: Index) -> Vector:
        """G_kk 2 l_k omega_k, what L_k answers to omega_k."""
        factor = self.builder.let("twice_length", 2 * (self.parameters.length[k] * self.found.diagonal[k]))
        return scale(factor, load(self.chain.rates.angular(), k))

    def _rate_next(self, j: Index) -> Vector:
        """How the last tension that link j loads outwards answers to omega_j."""
        return scale(self.found.outer[j + 1], self._load(j))

    def _rate_back(self, j: Index) -> Vector:
        """The same inwards."""
        return scale(self.found.inner[j], self._load(j))

    def _own(self) -> Callable[[Index], Matrix]:
        """Blocks -hat(...) / l_k of a link's own direction; on a cart the first two columns of link 0 know that the cart follows."""
        builder, links, direction = self.builder, self.links, self.chain.direction
        pulled = builder.array("pulled", 3 * links)
        leaning = None if self.cart is None else builder.array("leaning", 2 * links)
        fall: Vector = tuple(self.parameters.fall)
        if self.cart is not None:
            fall = (fall[0] - self.cart[0], fall[1] - self.cart[1], fall[2])
        if links > 1:
            fall = add(fall, scale(self.rho[1] * self.pulls[1], load(direction, 1)))
        fall = scale(self.inverse_length[0], fall)
        if leaning is not None:
            leaning[0], leaning[1] = fall[0], fall[1]
            fall = add(fall, scale(self.inverse_length[0] * self._cart_pull(), load(direction, 0)))
        store(pulled, 0, fall)
        for start, stop in ((1, links - 1), (links - 1, links)):
            with builder.loop("k", max(start, 1), stop) as loop:
                k = loop.index
                value = scale(self.pulls[k - 1], load(direction, k - 1))
                if stop < links:
                    value = add(value, scale(self.rho[k + 1] * self.pulls[k + 1], load(direction, k + 1)))
                value = scale(self.inverse_length[k], value)
                store(pulled, k, value)
                if leaning is not None:
                    leaning[2 * k], leaning[2 * k + 1] = value[0], value[1]

        def block(k: Index) -> Matrix:
            x, y, z = load(pulled, k)
            flat = (x, y) if leaning is None else (leaning[2 * k], leaning[2 * k + 1])
            nothing = builder.lift(0)
            return (nothing, z, -flat[1]), (-z, nothing, flat[0]), (y, -x, nothing)

        return block

    def _joints(self, by_q: Blocks, by_v: Blocks) -> None:
        """The blocks of neighbours."""
        found, direction = self.found, self.chain.direction
        with self.builder.loop("k", 1, self.links) as loop:
            k = loop.index
            inner, outer = self._around(k)
            block = dyad(inner, load(self.here, k - 1))
            block = plus(block, dyad(scale(found.outer[k + 1], outer), load(self.next, k - 1)))
            pull = self.inverse_length[k] * self.pulls[k - 1]
            by_q.put(k, k - 1, plus(block, hat(self.builder, scale(pull, load(direction, k)))))
            inner, outer = self._around(k - 1)
            block = dyad(outer, load(self.here, k))
            block = plus(block, dyad(scale(found.inner[k - 1], inner), load(self.back, k)))
            pull = self.inverse_length[k - 1] * (self.rho[k] * self.pulls[k])
            by_q.put(k - 1, k, plus(block, hat(self.builder, scale(pull, load(direction, k - 1)))))
            by_v.put(k, k - 1, dyad(load(self.onwards, k), self._load(k - 1)))
            by_v.put(k - 1, k, dyad(load(self.inwards, k - 1), self._load(k)))

    def _first_cart_rows(self, by_q: Blocks, by_v: Blocks) -> None:
        self._cart_rows(by_q, 0, load(self.here, 0), self._cart_pull())
        self._cart_rows(by_v, 0, self._load(0), None)
