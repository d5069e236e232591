"""The derivatives of spatial accelerations with every mass at its link's end (theory, section 5): joints pass one number on, so that
every block beyond a neighbour is a product of two vectors.

    l_i omega_i' = L_{i-1} X_i - rho_{i+1} L_{i+1} X_{i+1},   X_i = q_i x q_{i-1},   with base: q_{-1} what the chain falls with, L_{-1} = 1.

A column by q_j or omega_j loads rows j - 1 to j + 1 of the tensions' system (`response`). Past these the tensions L_i that answer are
those before them times outer_i on the way to the tip, times inner_i on the way to the base; with A_ij = d L_i / d q_j therefore

    block(i, j) = Z_i A_{i-1,j}^T  (i > j + 1),   l_i Z_i = X_i - rho_{i+1} outer_i outer_{i+1} X_{i+1}
    block(i, j) = V_i A_{i+1,j}^T  (i < j - 1),   l_i V_i = inner_{i-1} inner_i X_i - rho_{i+1} X_{i+1}

and by omega_j, of which row j has the load 2 l_j omega_j, the same from i = j + 1 and i = j - 1 on. Neighbours and the links themselves
add what their own directions do: with hat(a) b = a x b

    (i, i): -hat(L_{i-1} q_{i-1} + rho_{i+1} L_{i+1} q_{i+1}),   (i, i - 1): L_{i-1} hat(q_i),   (i, i + 1): rho_{i+1} L_{i+1} hat(q_i).

A cart of mass m_c is one more joint, m_c x'' = f + m_0 L_0 h, h = C^T q_0: link 0 answers L_0 with X_0 = -(m_0 / m_c) q_0 x C h.
"""
from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.lowering.algebra.matrix import outer as dyad
from phichain.lowering.algebra.vector import Vector, cross, dot, load, scale, store, sub
from phichain.lowering.chain.losses import brakes_cart, cart_slopes
from phichain.lowering.spatial import tension
from phichain.lowering.spatial.derivatives.blocks import Blocks
from phichain.lowering.spatial.derivatives.response import Answers
from phichain.scene import Scene


class Columns(ABC):
    """Writes the derivatives of one chain.

    `here`, `next` and `back` are A_jj, A_{j+1,j} and A_{j-1,j}; `onwards` and `inwards` Z_i and V_i; `reach` how many rows of tensions on
    either side of its own a link loads.
    """

    reach = 1

    def __init__(
        self, builder: Builder, scene: Scene, chain: tension.Chain, found: Answers, cart: tuple[Expr, Expr] | None
    ) -> None:
        self.builder, self.scene, self.chain, self.found = builder, scene, chain, found
        self.parameters, self.links, self.cart = chain.parameters, scene.links, cart
        self.inverse_length = self.parameters.derived("inverse_length", lambda k: 1 / self.parameters.length[k])
        links = scene.links
        self.pulls, self.rho = found.tension, self.parameters.mass_ratio
        self.here, self.next, self.back = (builder.array(f"by_direction_{name}", 3 * links) for name in ("here", "next", "back"))
        self.onwards, self.inwards = builder.array("onwards", 3 * links), builder.array("inwards", 3 * links)

    def write(self, dadq: ArrayRef, dadv: ArrayRef, dadu: ArrayRef | None) -> None:
        """All rows and columns."""
        first = 2 if self.scene.has_cart else 0
        by_q, by_v = (Blocks(array, first, self.scene.nv) for array in (dadq, dadv))
        beside = self._beside()
        self._passing()
        self.near(beside, by_q, by_v)
        self._outwards(by_q, by_v)
        self._inwards(by_q, by_v)
        self._base(dadq, dadv, dadu)

    # --- what is beside a link --------------------------------------------------------------------------------------------

    def _beside(self) -> ArrayRef:
        """q_{k-1} from cell k on: what the chain falls with before link 0, nothing beyond the tip; X_0 into the crosses."""
        builder, links, direction, nothing = self.builder, self.links, self.chain.direction, self.builder.lift(0)
        beside = builder.array("beside", 3 * links + 6)
        x, y, z = load(direction, 0)
        fall: Vector = tuple(self.parameters.fall)
        cart: Vector = (nothing, nothing, nothing)
        if self.cart is not None:
            pull = self._cart_pull()
            # x'' = f / m_c + pull h; on a light cart these two nearly cancel, so f / m_c is not taken from their sum
            alone, twice = self.chain.horizontal, pull + pull
            assert alone is not None
            fall = (fall[0] - alone[0] - twice * x, fall[1] - alone[1] - twice * y, fall[2])
            ratio = self._cart_ratio()
            cart = (ratio * (z * y), -(ratio * (z * x)), nothing)
        store(beside, 0, fall)
        store(self.chain.crosses, 0, cart)
        with builder.loop("k", 0, links) as loop:
            store(beside, loop.index + 1, load(direction, loop.index))
        store(beside, links + 1, (nothing, nothing, nothing))
        return beside

    def _cart_ratio(self) -> Expr:
        """m_0 / m_c."""
        return self.parameters.mass[0] / self.parameters.base_mass

    def _cart_pull(self) -> Expr:
        """(m_0 / m_c) L_0."""
        return self.builder.let("pull_of_link", self._cart_ratio() * self.pulls[0])

    def _passing(self) -> None:
        """Z_i and V_i."""
        found = self.found
        with self.builder.loop("k", 0, self.links - 1) as loop:
            k = loop.index
            before, after = load(self.chain.crosses, k), scale(self.rho[k + 1], load(self.chain.crosses, k + 1))
            inner = self.builder.let("passes_inwards", found.inner[k] * found.inner[k + 1] * self.inverse_length[k])
            store(self.inwards, k, sub(scale(inner, before), scale(self.inverse_length[k], after)))
        with self.builder.loop("k", 1, self.links) as loop:
            k = loop.index
            before, after = load(self.chain.crosses, k), scale(self.rho[k + 1], load(self.chain.crosses, k + 1))
            outer = self.builder.let("passes_outwards", found.outer[k] * found.outer[k + 1] * self.inverse_length[k])
            store(self.onwards, k, sub(scale(self.inverse_length[k], before), scale(outer, after)))
        crosses = self.chain.crosses
        lean = self.rho[1] * found.outer[1]
        first = sub(load(crosses, 0), scale(lean, load(crosses, 1)))
        store(self.onwards, 0, scale(self.inverse_length[0], first))

    # --- blocks far from each other --------------------------------------------------------------------------------------

    @abstractmethod
    def near(self, beside: ArrayRef, by_q: Blocks, by_v: Blocks) -> None:
        """Blocks of links that are at most `reach` apart, and `next` and `back`."""

    @abstractmethod
    def _rate_next(self, j: Index) -> Vector:
        """How the last tension that link j loads outwards answers to omega_j."""

    @abstractmethod
    def _rate_back(self, j: Index) -> Vector:
        """The same inwards."""

    def _outwards(self, by_q: Blocks, by_v: Blocks) -> None:
        """Blocks below the neighbours'."""
        found = self.found
        with self.builder.loop("j", 0, self.links - (1 + self.reach)) as columns:
            j = columns.index
            direction, rate = load(self.next, j), self._rate_next(j)
            with self.builder.loop("i", j + (1 + self.reach), self.links) as rows:
                i = rows.index
                share = rows.carry("share", 1)
                turned = scale(share, load(self.onwards, i))
                by_q.put(i, j, dyad(turned, direction))
                by_v.put(i, j, dyad(turned, rate))
                rows.follow(share, share * found.outer[i])

    def _inwards(self, by_q: Blocks, by_v: Blocks) -> None:
        """Blocks above the neighbours', and how the first tension, and so the cart, answers."""
        found = self.found
        with self.builder.loop("j", self.reach, self.links) as columns:
            j = columns.index
            direction, rate = load(self.back, j), self._rate_back(j)
            with self.builder.loop("i", j - (1 + self.reach), -1, -1) as rows:
                i = rows.index
                share = rows.carry("share", 1)
                turned = scale(share, load(self.inwards, i))
                by_q.put(i, j, dyad(turned, direction))
                by_v.put(i, j, dyad(turned, rate))
                rows.follow(share, share * found.inner[i + 1])
            if self.cart is not None:
                self._cart_rows(by_q, j, scale(share, direction), None)
                self._cart_rows(by_v, j, scale(share, rate), None)

    # --- the base ---------------------------------------------------------------------------------------------------------

    @abstractmethod
    def _first_cart_rows(self, by_q: Blocks, by_v: Blocks) -> None:
        """x'' by the links before `reach`."""

    def _cart_rows(self, target: Blocks, j: Index, answer: Vector, own: Expr | None) -> None:
        """x'' by link j where L_0 answers so: (m_0 / m_c) h answer^T, and its own pull where h moves."""
        unit = self._cart_ratio() * self.parameters.units.length
        for row in range(2):
            lean = self.builder.let("cart_lean", unit * self.chain.direction[row])
            for c, entry in enumerate(answer):
                value = lean * entry
                if own is not None and c == row:
                    value = value + own * self.parameters.units.length
                target.array[3 * j + (row * target.width + target.first + c)] = value

    def _base(self, dadq: ArrayRef, dadv: ArrayRef, dadu: ArrayRef | None) -> None:
        """The columns of what moves the base, and the rows and columns of a cart."""
        scene, width, nothing = self.scene, self.scene.nv, self.builder.lift(0)
        first = 2 if scene.has_cart else 0
        unit = self.parameters.units
        if self.cart is not None:
            by_q, by_v = Blocks(dadq, 2, width), Blocks(dadv, 2, width)
            self._first_cart_rows(by_q, by_v)
        for c in range(first):
            with self.builder.loop("i", 0, width) as loop:
                dadq[loop.index * width + c] = nothing
            if self.cart is None or not brakes_cart(scene):
                with self.builder.loop("i", 0, width) as loop:
                    dadv[loop.index * width + c] = nothing
        if scene.is_driven:
            for target in (dadq, dadv):
                for row in range(2):
                    with self.builder.loop("i", 2, width) as loop:
                        target[loop.index + row * width] = nothing
        if self.cart is not None and brakes_cart(scene):
            over = -1 / (self.parameters.base_mass * unit.length)
            own, aside, other = (over * slope for slope in cart_slopes(scene, self.parameters, self.chain.rates.cart()))
            self._pushed(dadv, width, [(own, aside, nothing), (aside, other, nothing)])
        if dadu is None:
            return
        factor = 1 / (self.parameters.base_mass * unit.force) if self.cart is not None else 1 / (self.builder.lift(1) * unit.length)
        axes = (0, 1) if self.cart is not None else scene.told_axes
        self._pushed(dadu, scene.nu, [tuple(factor if i == axis else nothing for i in range(3)) for axis in axes])

    def _pushed(self, target: ArrayRef, width: int, moves: Sequence[Vector]) -> None:
        """Columns of what would accelerate a free cart so, were there no chain, or of given accelerations of the base."""
        builder, found, scene = self.builder, self.found, self.scene
        carts, columns = 2 if scene.has_cart else 0, len(moves)
        here = load(self.chain.direction, 0)
        pushes = [builder.let(f"push_{c}", -dot(move, here)) for c, move in enumerate(moves)]
        share = found.diagonal[0]
        for c, move in enumerate(moves):
            turned = sub(scale(share * pushes[c], load(self.onwards, 0)), scale(self.inverse_length[0], cross(here, move)))
            for r, value in enumerate(turned):
                target[(carts + r) * width + c] = value
            for row in range(carts):
                own = move[row]
                if self.cart is not None:
                    own = own + self._cart_ratio() * (here[row] * (share * pushes[c]))
                target[row * width + c] = own * self.parameters.units.length
        with builder.loop("k", 1, self.links) as loop:
            k = loop.index
            passed = loop.carry("passed", share)
            turned = scale(passed, load(self.onwards, k))
            for c in range(columns):
                for r, value in enumerate(scale(pushes[c], turned)):
                    target[(3 * k + (carts + r)) * width + c] = value
            loop.follow(passed, passed * found.outer[k])
