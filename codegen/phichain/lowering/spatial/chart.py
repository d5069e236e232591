"""The chart in which one implicit step moves a spatial chain: unit vectors and rates seen in the tangent planes at its start.

Link k starts the step at q_0, omega_0. Its coordinates are the projections across q_0

    s = P_0 q,   sigma = P_0 omega,   q = s + sqrt(1 - |s|^2) q_0,   omega = sigma - q_0 (sigma . q) / (q_0 . q)

so that |q| = 1 and omega . q = 0 hold wherever a stage looks, and s' = P_0 (omega x q), sigma' = P_0 omega'. The chart ends at a
right angle: a step that turns a link further yields values that are not finite, which the step control refuses.
"""

from __future__ import annotations

from phichain.ir.builder import ArrayRef, Builder
from phichain.lowering.algebra.vector import Vector, add, cross, dot, load, scale, store, sub
from phichain.lowering.spatial.links import directions
from phichain.scene import Scene


def across(q: Vector, a: Vector) -> Vector:
    """P a = a - q (q . a)."""
    return sub(a, scale(dot(q, a), q))


def on_manifold(
    builder: Builder,
    scene: Scene,
    start: tuple[ArrayRef, ArrayRef],
    moved: tuple[ArrayRef, ArrayRef],
    out: tuple[ArrayRef, ArrayRef],
) -> None:
    """Write the state (q, v) that has the coordinates of `start` plus `moved` in the chart at `start`."""
    (q, v), (shift, turn), (q_out, v_out) = start, moved, out
    for i in range(2 if scene.has_cart else 0):
        q_out[i], v_out[i] = q[i] + shift[i], v[i] + turn[i]
    with builder.loop("k", 0, scene.links) as loop:
        k = loop.index
        here, omega = load(directions(scene, q), k), load(directions(scene, v), k)
        aside = load(directions(scene, shift), k)
        rate = add(omega, load(directions(scene, turn), k))
        along = builder.let("along", builder.sqrt(1 - dot(aside, aside)))
        unit = add(aside, scale(along, here))
        # Tangent vectors are so to rounding: what is along q_0 in them drops out here.
        lean = builder.let("lean", dot(rate, unit) / dot(here, unit))
        store(directions(scene, q_out), k, unit)
        store(directions(scene, v_out), k, sub(rate, scale(lean, here)))


def displacement(
    builder: Builder,
    scene: Scene,
    start: tuple[ArrayRef, ArrayRef],
    moved: tuple[ArrayRef, ArrayRef],
    out: tuple[ArrayRef, ArrayRef],
) -> None:
    """Write how far q and v themselves move where the coordinates move by `moved`: small differences formed as such."""
    (q, v), (shift, turn), (q_out, v_out) = start, moved, out
    for i in range(2 if scene.has_cart else 0):
        q_out[i], v_out[i] = shift[i], turn[i]
    with builder.loop("k", 0, scene.links) as loop:
        k = loop.index
        here, omega = load(directions(scene, q), k), load(directions(scene, v), k)
        aside, turning = load(directions(scene, shift), k), load(directions(scene, turn), k)
        squared = builder.let("aside_squared", dot(aside, aside))
        along = builder.let("along", builder.sqrt(1 - squared))
        moving = sub(aside, scale(squared / (1 + along), here))
        # (sigma . q) / (q_0 . q) with sigma . q_0 = 0
        lean = builder.let("lean", dot(add(omega, turning), aside) / along)
        store(directions(scene, q_out), k, moving)
        store(directions(scene, v_out), k, sub(turning, scale(lean, here)))


def bends_at_start(builder: Builder, scene: Scene, q: ArrayRef, lost: ArrayRef) -> ArrayRef:
    """q_{k-1} - q_k of the unit vectors q + lost, q_{-1} = e_3: with what rounding took from them."""
    direction, rest = directions(scene, q), directions(scene, lost)
    bend, nothing = builder.array("bend", 3 * scene.links), builder.lift(0)
    upright: Vector = (nothing, nothing, builder.lift(1))
    store(bend, 0, sub(sub(upright, load(direction, 0)), load(rest, 0)))
    with builder.loop("k", 1, scene.links) as loop:
        k = loop.index
        apart = sub(load(direction, k - 1), load(direction, k))
        store(bend, k, add(apart, sub(load(rest, k - 1), load(rest, k))))
    return bend


def bends_moved(builder: Builder, scene: Scene, q: ArrayRef, bend: ArrayRef, shift: ArrayRef) -> ArrayRef:
    """The same where the coordinates have moved by `shift`: small differences formed as such."""
    moving, moved = builder.array("moving", 3 * scene.links), builder.array("stage_bend", 3 * scene.links)
    with builder.loop("k", 0, scene.links) as loop:
        k = loop.index
        aside = load(directions(scene, shift), k)
        squared = builder.let("aside_squared", dot(aside, aside))
        share = squared / (1 + builder.sqrt(1 - squared))
        store(moving, k, sub(aside, scale(share, load(directions(scene, q), k))))
    store(moved, 0, sub(load(bend, 0), load(moving, 0)))
    with builder.loop("k", 1, scene.links) as loop:
        k = loop.index
        store(moved, k, add(load(bend, k), sub(load(moving, k - 1), load(moving, k))))
    return moved


def slope(
    builder: Builder,
    scene: Scene,
    start: ArrayRef,
    state: tuple[ArrayRef, ArrayRef, ArrayRef],
    out: tuple[ArrayRef, ArrayRef],
) -> None:
    """Write (s', sigma') of a state (q, v) with accelerations a, in the chart at `start`."""
    (q, v, a), (shift, turn) = state, out
    for i in range(2 if scene.has_cart else 0):
        shift[i], turn[i] = v[i], a[i]
    with builder.loop("k", 0, scene.links) as loop:
        k = loop.index
        origin, here = load(directions(scene, start), k), load(directions(scene, q), k)
        spin = cross(load(directions(scene, v), k), here)
        store(directions(scene, shift), k, across(origin, spin))
        store(directions(scene, turn), k, across(origin, load(directions(scene, a), k)))
