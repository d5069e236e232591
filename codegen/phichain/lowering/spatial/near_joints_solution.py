"""The right sides of `spatial.near_joints`: one sweep inwards for forces and one outwards for motions.

The force of the chain beyond a joint is Lambda (a + p) + d, d across the chain's first link: what an acceleration p of the whole
would do is kept apart from the rest, so that no part is a difference of large ones. With A = M^-1 P Lambda, c the constant part
of the tip's motion over l, j = -R P, v = p + (1 - beta) c (symbols there), T = M^-1 P Lambda N, h~ - (a + beta) b = row,

    x = -(A + beta M^-1) a - A (c + p) - M^-1 (beta^2 c + d + j)
    across q:  p' = p + c,   d' = -M^-1 (kappa v + zeta d + beta s j) - T ((1 - beta) v + j) + zeta A q (t - q.v) / a'
    along q:   p' = (X (p + c) + beta c + t) / a',   t = q.d - row.M^-1 (d - beta v + j),   a' = 1 + X = q.Lambda' q
    next a:    -zeta M^-1 a - A q (s q.a + b.a + s q.c + b.c) - s A p + M^-1 (kappa c - s (d + j)) + q (q.a - b.x + q.c).
"""

from __future__ import annotations

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.lowering.algebra.matrix import Matrix, applied, load_matrix
from phichain.lowering.algebra.vector import Vector, add, cross, dot, load, scale, store, sub
from phichain.lowering.chain.losses import as_slopes, brakes_cart, cart_slope_cells
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.spatial.links import directions
from phichain.lowering.spatial.near_joints import CART_DRAG, CART_LOAD, CART_PIVOT, COEFFICIENTS
from phichain.lowering.spatial.units import SpatialUnits
from phichain.scene import Scene


def solution(
    builder: Builder, scene: Scene, parameters: Parameters, gain: Expr, known: dict[str, ArrayRef],
    right: tuple[ArrayRef, ArrayRef], result: tuple[ArrayRef, ArrayRef],
) -> None:  # fmt: skip
    """Write k = (I - g J)^-1 r for the (r_s, r_sigma) of `right` into the (k_s, k_sigma) of `result`."""
    solve = _Solution(builder, scene, parameters, gain, known, right)
    drawn, push = solve.inwards()
    nothing = builder.lift(0)
    base: Vector = (nothing, nothing, nothing)
    length = parameters.length[0]
    if scene.has_free_cart:
        loads, pivot = known[CART_LOAD], known[CART_PIVOT]
        x, y = (dot((loads[3 * i], loads[3 * i + 1], loads[3 * i + 2]), drawn) + push[i] for i in range(2))
        if brakes_cart(scene):
            own, aside, other = as_slopes(known[CART_DRAG], scene)
            cart = known[CART_DRAG][cart_slope_cells(scene)]
            # k_v is formed at once, and no difference of what the resistance cancels.
            held = [
                cart * right[1][i] + loads[3 * i] * right[1][0] + loads[3 * i + 1] * right[1][1] - gain * (length * pull)
                for i, pull in enumerate((x, y))
            ]
            over = 1 / length
            right_x, right_y = over * right[1][0], over * right[1][1]
            x, y = x + own * right_x, y + other * right_y
            if not aside.is_zero:
                x, y = x + aside * right_y, y + aside * right_x
        base = (-(pivot[0] * x + pivot[1] * y), -(pivot[2] * x + pivot[3] * y), nothing)
    if scene.has_cart:
        for i in range(2):
            moved = right[1][i] + gain * (length * base[i])
            if brakes_cart(scene):
                moved = pivot[2 * i] * held[0] + pivot[2 * i + 1] * held[1]
            result[1][i] = moved
            result[0][i] = right[0][i] + gain * moved
    solve.outwards(base, *result)


class _Solution:
    """One right side: inwards for forces, outwards for motions."""

    def __init__(
        self, builder: Builder, scene: Scene, parameters: Parameters, gain: Expr, known: dict[str, ArrayRef],
        right: tuple[ArrayRef, ArrayRef],
    ) -> None:  # fmt: skip
        self.builder, self.scene, self.gain, self.known = builder, scene, gain, known
        self.units = SpatialUnits(builder, scene, parameters)
        self.right = tuple(directions(scene, array) for array in right)
        links = 3 * scene.links
        self.rate, self.load = builder.array("velocity", links), builder.array("load", links)
        self.still = builder.array("still", links)
        self.tip, self.along = builder.array("tip", links), builder.array("along", scene.links)

    def _vector(self, name: str, k: Index) -> Vector:
        return load(self.known[name], k)

    def _matrix(self, name: str, k: Index) -> Matrix:
        return load_matrix(self.known[name], k)

    def inwards(self) -> tuple[Vector, Vector]:
        """p and d of the chain beyond the base, in units of link 0."""
        with self.builder.loop("k", self.scene.links - 1, -1, -1) as loop:
            drawn = tuple(loop.carry(f"drawn_{x}", 0) for x in "xyz")
            push = tuple(loop.carry(f"push_{x}", 0) for x in "xyz")
            following = self._eliminated(drawn, push, loop.index)
            for before, after in zip((drawn, push), following, strict=True):
                for part, next_part in zip(before, after, strict=True):
                    loop.follow(part, next_part)
        return drawn, push

    def _eliminated(self, p: Vector, d: Vector, k: Index) -> tuple[Vector, Vector]:
        known, units = self.known, self.units
        q, moving, turning = (self._vector(name, k) for name in ("unit", "moving", "turning"))
        s, kappa, zeta, squared, loaded, moved, passed_on, turned, pulled_on = (
            known["turn"][COEFFICIENTS * k + i] for i in range(COEFFICIENTS)
        )
        minv, reply = self._matrix("inverse", k), self._matrix("reply", k)
        rate = cross(load(self.right[1], k), q)
        shift = add(load(self.right[0], k), scale(self.gain, rate))
        along = -(dot(turning, shift) + 2 * dot(moving, rate))
        store(self.rate, k, rate)
        store(self.still, k, sub(scale(along, q), scale(squared, shift)))
        self.along[k] = along
        by_shift, by_p, by_d = applied(minv, shift), applied(minv, p), applied(minv, d)
        held = add(applied(reply, p), by_d)
        store(self.load, k, add(held, scale(loaded, by_shift)))
        store(self.tip, k, sub(scale(moved, by_shift), scale(s, held)))
        beta, over, length = units.reach[k], units.overhang[k], units.length[k]
        across = sub(add(by_d, scale(pulled_on, by_shift)), scale(beta, by_p))
        pulled, p_along = dot(q, d) - dot(self._vector("row", k), across), dot(q, p)
        added, inverse_axial = known["axial"][2 * k], known["axial"][2 * k + 1]
        kept = add(add(scale(kappa, by_p), scale(zeta, by_d)), scale(passed_on, by_shift))
        kept = add(kept, applied(self._matrix("held", k), add(scale(over, p), scale(turned, shift))))
        bent = scale(zeta * (inverse_axial * (pulled - p_along - over * along)), self._vector("column", k))
        drawn = inverse_axial * (added * (p_along + along) + beta * along + pulled)
        following = add(sub(p, scale(squared, shift)), scale(drawn - p_along, q))
        return scale(length, following), scale(units.mass[k] * length, sub(bent, kept))

    def outwards(self, base: Vector, result_q: ArrayRef, result_v: ArrayRef) -> None:
        """Motions, link by link."""
        gain, units = self.gain, self.units
        results = directions(self.scene, result_q), directions(self.scene, result_v)
        with self.builder.loop("k", 0, self.scene.links) as loop:
            k = loop.index
            carried: Vector = tuple(
                loop.carry(f"joint_{x}", part) for x, part in zip("xyz", base, strict=True)
            )
            joint, q = scale(units.outward[k], carried), self._vector("unit", k)
            s, zeta = (self.known["turn"][COEFFICIENTS * k + i] for i in (0, 2))
            lean, whole = self._vector("lean", k), add(joint, load(self.still, k))
            held = applied(self._matrix("inverse", k), joint)
            back = add(applied(self._matrix("reply", k), whole), scale(units.reach[k], held))
            back = add(back, load(self.load, k))
            rate = sub(load(self.rate, k), scale(gain, back))
            store(results[0], k, add(load(self.right[0], k), scale(gain, rate)))
            store(results[1], k, cross(q, rate))
            along = dot(q, joint) + self.along[k]
            tip = sub(load(self.tip, k), scale(zeta, held))
            tip = sub(tip, scale(dot(lean, whole) + s * along, self._vector("column", k)))
            tip = add(tip, scale(along + dot(lean, back), q))
            for before, after in zip(carried, tip, strict=True):
                loop.follow(before, after)
