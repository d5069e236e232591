"""Dry friction of spatial chains in Taylor recurrences: F T(w.w) w with T(s) = tanh(sqrt s) / sqrt s, order by order.

w is the rate over v_0: of a joint the difference of its links' angular velocities, of a cart its velocity. T is even in |w|, so it
is a power series in s = w.w at every s, at rest too, and with s - s_0 = s_1 t + s_2 t^2 + ...

    s_n = 2 w_0.w_n + sum_{j=1..n-1} w_j.w_{n-j},    T_n = f_1 s_n + R_n,    R_n = sum_{k=2..n} f_k [(s - s_0)^k]_n,
    (T w)_n = T_0 w_n + T_n w_0 + sum_{j=1..n-1} T_j w_{n-j},                f_k = T^(k)(s_0) / k!

No recurrence of T itself is used: its differential equation, 2 s T' = 1 - T - s T^2, divides by s, and chains come to rest. The flow
forms the f_k from s_0, T_0 and the steepness 1 - tanh^2, and the powers of s - s_0 (`stencils/flow/sums.c`). Left rows go on behind
their lanes with five numbers a place: of row 0 w_0, the steepness and T_0; of row n + 1 w_n, s_n and T_n, which is 0 for n = 0. Sums end with

    sum w_j.w_{n-j},    the three of sum T_j w_{n-j},    R_n,    f_1

a place. For derivatives along the state the same holds of variations, with the sums' variations, since f_1 is the slope of T at s_0.
"""

from __future__ import annotations

from phichain.contract.chain import LEAST_SQUARE
from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.lowering.algebra.vector import Vector, add, dot, load, scale, store
from phichain.lowering.chain.losses import rate_unit
from phichain.lowering.series.held import Layout
from phichain.lowering.series.series import RUB_LANES, RUB_SUMS
from phichain.scene import Scene


def places(scene: Scene) -> int:
    """How many places rub: the joints, then a cart that moves freely."""
    return scene.links * (scene.friction is not None) + _cart_rubs(scene)


def runs(scene: Scene) -> list[tuple[str, int]]:
    """What a step holds of them: F, 1 / v_0 in scaled time, w_0 and T_0."""
    count = places(scene)
    return [("rub_force", count), ("rub_over", count), ("rub_slip", 3 * count), ("rub_share", count)]


def _cart_rubs(scene: Scene) -> bool:
    return scene.has_free_cart and scene.cart_friction is not None


class Rubs:
    """The places of one scene, in the Program that is being written.

    Args:
        builder: Where the Program is written.
        scene: The chain.
        layout: Where `held` keeps what.
        held: Constants of the step.
        left: The left row that is written.
    """

    def __init__(self, builder: Builder, scene: Scene, layout: Layout, held: ArrayRef, left: ArrayRef) -> None:
        self.builder, self.scene = builder, scene
        self.cart = places(scene) - 1 if _cart_rubs(scene) else None
        self._held = {name: layout.of(held, name) for name, _ in runs(scene) if name in layout}
        self._left = left.shifted(3 * scene.links)

    def begin(self, i: Index, rate: Vector, rho: Expr, force: Expr) -> None:
        """Hold a place and write row 0: its rate in scaled time, and F in the units of the recurrence."""
        let, builder, lanes = self.builder.let, self.builder, self._left
        v_0 = self.scene.cart_friction_speed if i is self.cart else self.scene.friction_speed
        over = let("over", rate_unit(v_0) / rho)
        slip = scale(over, rate)
        ratio = let("rub_ratio", builder.sqrt(dot(slip, slip) + LEAST_SQUARE))
        saturation = let("rub_saturation", builder.apply("tanh", ratio))
        share = let("rub_share", saturation / ratio)
        for name, value in (("rub_force", force), ("rub_over", over), ("rub_share", share)):
            self._held[name][i] = value
        store(self._held["rub_slip"], i, slip)
        for lane, value in enumerate((*slip, (1 - saturation) * (1 + saturation), share)):
            lanes[RUB_LANES * i + lane] = value

    def resisted(self, i: Index, rate: Vector, sums: ArrayRef, first: Expr) -> Vector:
        """The friction of a place at order n from the coefficient of its rate; writes row n + 1."""
        let, held, lanes = self.builder.let, self._held, self._left
        squares, x, y, z, beyond, slope = (sums[RUB_SUMS * i + lane] for lane in range(RUB_SUMS))
        begun, share = load(held["rub_slip"], i), held["rub_share"][i]
        slip = scale(held["rub_over"][i], rate)
        # What starts the series is no change of it.
        square = let("rub_square", 2 * dot(begun, slip) + squares - first * (2 * dot(begun, begun)))
        moved = let("rub_moved", slope * square + beyond)
        for lane, value in enumerate((*slip, square, moved)):
            lanes[RUB_LANES * i + lane] = value
        return scale(held["rub_force"][i], add(add(scale(share, slip), scale(moved, begun)), (x, y, z)))
