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
