"""The right sides of an implicit spatial step: one sweep inwards for forces and one outwards for motions (`spatial.implicit`)."""

from __future__ import annotations

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.lowering.algebra.matrix import Matrix, applied, load_matrix
from phichain.lowering.algebra.vector import Vector, add, cross, dot, load, scale, store, sub
from phichain.lowering.chain.losses import as_slopes, brakes_cart, cart_slope_cells
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.spatial import near_joints_solution
from phichain.lowering.spatial.chart import across
from phichain.lowering.spatial.implicit import CART_DRAG, joined
from phichain.lowering.spatial.joint import Joint
from phichain.lowering.spatial.links import directions
from phichain.lowering.spatial.near_joints import CART_PIVOT, near_joints
from phichain.scene import Scene


def solution(
    builder: Builder, scene: Scene, parameters: Parameters, gain: Expr, known: dict[str, ArrayRef],
    right: tuple[ArrayRef, ArrayRef], result: tuple[ArrayRef, ArrayRef],
) -> None:  # fmt: skip
    """Write k = (I - g J)^-1 r for the (r_s, r_sigma) of `right` into the (k_s, k_sigma) of `result`."""
    if near_joints(scene):
        near_joints_solution.solution(builder, scene, parameters, gain, known, right, result)
        return
    solve = _Solution(builder, scene, parameters, gain, known, right)
    sideways = solve.inwards()
    nothing = builder.lift(0)
    base: Vector = (nothing, nothing, nothing)
    if scene.has_free_cart:
        base = _cart(scene, gain, known, right, sideways, result)
    elif scene.has_cart:
        for i in range(2):
            result[1][i] = moved = right[1][i] + nothing
            result[0][i] = right[0][i] + gain * moved
    solve.outwards(base, *result)


def _cart(
    scene: Scene, gain: Expr, known: dict[str, ArrayRef], right: tuple[ArrayRef, ArrayRef], sideways: Vector,
    result: tuple[ArrayRef, ArrayRef],
) -> Vector:  # fmt: skip
    """Write the cart's k_s and k_v, and return its x; where something resists its speed, k_v is formed at once."""
    pivot, nothing = known[CART_PIVOT], gain.builder.lift(0)
    if not brakes_cart(scene):
        base = (
            -(pivot[0] * sideways[0] + pivot[1] * sideways[1]), -(pivot[2] * sideways[0] + pivot[3] * sideways[1]), nothing,
        )  # fmt: skip
        for i in range(2):
            result[1][i] = moved = right[1][i] + gain * base[i]
            result[0][i] = right[0][i] + gain * moved
        return base
    own, aside, other = as_slopes(known[CART_DRAG], scene)
    xx, xy, yx, yy = (known[CART_DRAG][cart_slope_cells(scene) + i] for i in range(4))
    x, y = right[1][0], right[1][1]
    driven = xx * x + xy * y - gain * sideways[0], yx * x + yy * y - gain * sideways[1]
    pulled = sideways[0] + own * x, sideways[1] + other * y
    if not aside.is_zero:
        pulled = pulled[0] + aside * y, pulled[1] + aside * x
    for i in range(2):
        result[1][i] = moved = pivot[2 * i] * driven[0] + pivot[2 * i + 1] * driven[1]
        result[0][i] = right[0][i] + gain * moved
    return (
        -(pivot[0] * pulled[0] + pivot[1] * pulled[1]), -(pivot[2] * pulled[0] + pivot[3] * pulled[1]), nothing,
    )  # fmt: skip


class _Solution:
    """One right side: inwards for forces, outwards for motions."""

    def __init__(
        self, builder: Builder, scene: Scene, parameters: Parameters, gain: Expr, known: dict[str, ArrayRef],
        right: tuple[ArrayRef, ArrayRef],
    ) -> None:  # fmt: skip
        self.builder, self.scene, self.parameters, self.gain, self.known = (
            builder,
            scene,
            parameters,
            gain,
            known,
        )
        self.right = tuple(directions(scene, array) for array in right)
        links = 3 * scene.links
        self.shift, self.rate = builder.array("shift", links), builder.array("velocity", links)
        self.constant, self.load = builder.array("constant", links), builder.array("load", links)

    def _vector(self, name: str, k: Index) -> Vector:
        return load(self.known[name], k)

    def _matrix(self, name: str, k: Index) -> Matrix:
        return load_matrix(self.known[name], k)

    def inwards(self) -> Vector:
        """Forces and couples lambda; returns the force on the base."""
        builder, links = self.builder, self.scene.links
        with builder.loop("k", 0, links) as loop:
            k = loop.index
            rate = cross(load(self.right[1], k), self._vector("unit", k))
            store(self.rate, k, rate)
            store(self.shift, k, add(load(self.right[0], k), scale(self.gain, rate)))
        nothing = builder.lift(0)
        still: Vector = (nothing, nothing, nothing)
        force = couple = still
        if links > 1:
            with builder.loop("k", links - 1, 0, -1) as loop:
                force = tuple(loop.carry(f"force_{x}", 0) for x in "xyz")
                if joined(self.scene):
                    couple = tuple(loop.carry(f"couple_{x}", 0) for x in "xyz")
                following = self._eliminated(force, couple, loop.index, True)
                for before, after in zip((force, couple), following, strict=True):
                    for part, next_part in zip(before, after, strict=True):
                        if not part.is_zero:
                            loop.follow(part, next_part)
        return self._eliminated(force, couple, 0, False)[0]

    def _eliminated(
        self, force: Vector, couple: Vector, k: Index, has_neighbour: bool
    ) -> tuple[Vector, Vector]:
        known, length = self.known, self.parameters.length[k]
        here, spin, moving, turning = (
            self._vector(name, k) for name in ("unit", "spin", "moving", "turning")
        )
        shift, rate = load(self.shift, k), load(self.rate, k)
        lean = dot(turning, shift) + 2 * dot(moving, rate)
        constant = sub(scale(-dot(spin, spin), shift), scale(lean, here))
        store(self.constant, k, constant)
        own = add(force, applied(self._matrix("carried", k), constant))
        total = add(applied(self._matrix("arm", k), constant), scale(length, across(here, force)))
        total = sub(add(total, couple), scale(known["pull"][k], shift))
        joint = None
        if joined(self.scene):
            joint = Joint(self.builder, self.parameters, known, k, not has_neighbour)
            total = add(total, joint.on_link((shift, rate)))
            if has_neighbour:
                total = add(total, joint.across_to_link((load(self.shift, k - 1), load(self.rate, k - 1))))
        store(self.load, k, total)
        free = applied(self._matrix("inverse", k), total)
        passed = sub(own, applied(self._matrix("column", k), free))
        if joint is None or not has_neighbour:
            return passed, couple
        answered = add(
            joint.across_to_before((shift, rate)),
            joint.on_before((load(self.shift, k - 1), load(self.rate, k - 1))),
        )
        return passed, sub(answered, applied(self._matrix("outer", k), free))

    def outwards(self, base: Vector, result_q: ArrayRef, result_v: ArrayRef) -> None:
        """Motions, link by link."""
        nothing = self.builder.lift(0)
        still: Vector = (nothing, nothing, nothing)
        results = directions(self.scene, result_q), directions(self.scene, result_v)
        joint, moved = self._moved(base, still, 0, False, results)
        if self.scene.links == 1:
            return
        with self.builder.loop("k", 1, self.scene.links) as loop:
            at: Vector = tuple(loop.carry(f"joint_{x}", part) for x, part in zip("xyz", joint, strict=True))
            before = still
            if joined(self.scene):
                before = tuple(loop.carry(f"before_{x}", part) for x, part in zip("xyz", moved, strict=True))
            following = self._moved(at, before, loop.index, True, results)
            for old, new in zip((at, before), following, strict=True):
                for part, next_part in zip(old, new, strict=True):
                    if not part.is_zero:
                        loop.follow(part, next_part)

    def _moved(
        self, joint: Vector, before: Vector, k: Index, has_neighbour: bool, results: tuple[ArrayRef, ArrayRef]
    ) -> tuple[Vector, Vector]:
        """x_k from the joint's motion; returns the next joint's and x_k."""
        gain, here = self.gain, self._vector("unit", k)
        acting = add(load(self.load, k), applied(self._matrix("row", k), joint))
        if joined(self.scene) and has_neighbour:
            acting = add(acting, applied(self._matrix("inner", k), before))
        moved = scale(-1, applied(self._matrix("inverse", k), acting))
        rate = add(load(self.rate, k), scale(gain, moved))
        store(results[0], k, add(load(self.right[0], k), scale(gain, rate)))
        store(results[1], k, cross(here, rate))
        spin, moving, turning = (self._vector(name, k) for name in ("spin", "moving", "turning"))
        lean = gain * gain * dot(turning, moved) + 2 * gain * dot(moving, moved)
        bent = sub(scale(1 - gain * gain * dot(spin, spin), moved), scale(lean, here))
        return add(joint, scale(self.parameters.length[k], add(bent, load(self.constant, k)))), moved
