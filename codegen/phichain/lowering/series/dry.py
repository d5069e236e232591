"""Dry friction in Taylor recurrences: what F tanh(v / v_0) of a joint or a cart is, order by order.

With z = v / v_0, saturation y = tanh z and steepness s = 1 - y^2, y' = s z' and, with d_n = n z_n, the coefficients obey

    (n + 1) y_{n+1} = s_0 d_{n+1} + sum_{j=1..n} s_{n+1-j} d_j,        s_{n+1} = -(2 y_0 y_{n+1} + sum_{j=1..n} y_j y_{n+1-j})

d_{n+1} comes out of order n, so that y_{n+1} is there when order n + 1 asks for the torque F y_{n+1}. The three are further lanes
of left rows, behind those that are multiplied with right ones; `sums` ends with the two sums. Series converge no longer than a
rate takes to change by some v_0: steps are short where v_0 is small.
"""

from __future__ import annotations

from fractions import Fraction

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.series.held import Layout
from phichain.scene import Scene

#: Lanes of each place that rubs: saturation, steepness, change.
KINDS = 3


def places(scene: Scene) -> int:
    """How many places rub: the joints, then a cart that moves freely."""
    return scene.links * (scene.friction is not None) + _cart_rubs(scene)


def runs(scene: Scene) -> list[tuple[str, int]]:
    """What a step holds of them: F, 1 / v_0, and saturation and steepness at its start, in scaled time."""
    return [(name, places(scene)) for name in ("dry", "over_speed", "saturation", "steepness")]


def _cart_rubs(scene: Scene) -> bool:
    return scene.has_free_cart and scene.cart_friction is not None


class Dry:
    """The lanes of one scene's rubbing places.

    Args:
        builder: Where the Program is written.
        scene: The chain.
        layout: Where `held` keeps what.
        held: Constants of the step.
        lanes: Lanes of left rows before those here.
    """

    def __init__(self, builder: Builder, scene: Scene, layout: Layout, held: ArrayRef, lanes: int) -> None:
        self.builder, self.scene, self.count = builder, scene, places(scene)
        self.cart = self.count - 1 if _cart_rubs(scene) else None
        self._held = {name: layout.of(held, name) for name, _ in runs(scene) if name in layout}
        self._lanes = lanes

    def _lane(self, row: ArrayRef, kind: int) -> ArrayRef:
        return row.shifted(self._lanes + kind * self.count)

    def saturated(self, row: ArrayRef, i: Index) -> Expr:
        """The friction at a place, of the order of a left row."""
        return self._held["dry"][i] * self._lane(row, 0)[i]

    def begin(
        self, parameters: Parameters, scale: ArrayRef, rate: ArrayRef | None, speed: Expr | None, left: ArrayRef,
        share: Expr | None = None,
    ) -> None:
        """Write what is held and row 0: rates of joints and of a cart in scaled time, torques times a common share."""
        scene, friction, brake = self.scene, parameters.friction, parameters.cart_friction
        if friction is not None and rate is not None:
            with self.builder.loop("k", 0, scene.links) as loop:
                force = scale[1] * friction[loop.index]
                self._start(loop.index, scale[0], force if share is None else force * share, scene.friction_speed, rate[loop.index], left)
        if self.cart is not None and brake is not None and speed is not None:
            self._start(self.cart, scale[0], scale[1] * brake, scene.cart_friction_speed, speed, left)

    def _start(self, i: Index, rho: Expr, force: Expr, v_0: float | None, rate: Expr, left: ArrayRef) -> None:
        assert v_0 is not None
        let, builder = self.builder.let, self.builder
        over = let("over", (1 / Fraction(v_0)) / rho)
        saturation = let("saturated", builder.apply("tanh", over * rate))
        # As a product, which rounds no small one away beside 1.
        steepness = let("steep", (1 - saturation) * (1 + saturation))
        for name, value in (("dry", force), ("over_speed", over), ("saturation", saturation), ("steepness", steepness)):
            self._held[name][i] = value
        for kind, value in enumerate((saturation, steepness, builder.lift(0))):
            self._lane(left, kind)[i] = value

    def follow(self, now: ArrayRef, sums: ArrayRef, rate: ArrayRef | None, speed: Expr | None, left: ArrayRef) -> None:
        """Write row n + 1 from the rates' coefficients n + 1."""
        if rate is not None:
            with self.builder.loop("k", 0, self.scene.links) as loop:
                self._next(loop.index, now, sums, rate[loop.index], left)
        if self.cart is not None and speed is not None:
            self._next(self.cart, now, sums, speed, left)

    def _next(self, i: Index, now: ArrayRef, sums: ArrayRef, rate: Expr, left: ArrayRef) -> None:
        let = self.builder.let
        change = let("change", now[0] * (self._held["over_speed"][i] * rate))
        following = let("saturation_next", now[1] * (self._held["steepness"][i] * change + sums[i]))
        twice = 2 * self._held["saturation"][i]
        for kind, value in enumerate((following, -(twice * following + sums.shifted(self.count)[i]), change)):
            self._lane(left, kind)[i] = value

    def vary(self, rate: ArrayRef | None, speed: Expr | None, left: ArrayRef) -> None:
        """Write the variation of row 0 along variations of the rates."""
        if rate is not None:
            with self.builder.loop("k", 0, self.scene.links) as loop:
                self._varied(loop.index, rate[loop.index], left)
        if self.cart is not None and speed is not None:
            self._varied(self.cart, speed, left)

    def _varied(self, i: Index, rate: Expr, left: ArrayRef) -> None:
        let = self.builder.let
        saturation = let("d_saturation", self._held["steepness"][i] * (self._held["over_speed"][i] * rate))
        steepness = -(2 * self._held["saturation"][i] * saturation)
        for kind, value in enumerate((saturation, steepness, self.builder.lift(0))):
            self._lane(left, kind)[i] = value
