"""The ends of a spatial flow: from (q, omega) to (q, q'), which its recurrences speak of, and back, with derivatives.

    enter: q' = omega x q                       dq' = domega x q + omega x dq
    leave: q / |q|,  omega = q x q' / |q|^2     omega does not feel what rounding left of q.q' or of |q| - 1

There and back a variation keeps what is tangent to the states, q.dq = 0 and q.domega + omega.dq = 0.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from phichain.ir.builder import ArrayRef, Builder, Index
from phichain.ir.nodes import Program
from phichain.lowering.algebra.vector import add, cross, dot, load, scale, store, sub
from phichain.lowering.series.shape import shaped
from phichain.lowering.spatial.links import directions
from phichain.scene import Scene


@dataclass(frozen=True)
class Ends:
    """The Programs of both ends.

    Attributes:
        enter: q, v -> rate = [x', q_k'].
        leave: q, rate -> q_out, v_out.
        settle: x = [q, rate], lost -> settled: what rounding took with the parts along q of |q| - 1 and q' taken out.
        enter_column: q, v, dq, dv -> d_rate.
        leave_column: q, rate, dq, d_rate -> dq_out, dv_out.
    """

    enter: Program
    leave: Program
    settle: Program
    enter_column: Program
    leave_column: Program


def spatial_ends(scene: Scene) -> Ends:
    """The ends of a spatial scene's flow."""
    return Ends(_enter(scene), _leave(scene), _settle(scene), _enter_column(scene), _leave_column(scene))


def _per_link(
    builder: Builder, scene: Scene, carts: list[tuple[ArrayRef, ArrayRef]], write: Callable[[Index], None]
) -> Program:
    """Cells of the cart that pass through (from, to), and what every link does."""
    for source, target in carts:
        for i in range(2 * scene.has_cart):
            target[i] = source[i]
    with builder.loop("k", 0, scene.links) as loop:
        write(loop.index)
    return shaped(builder.finish(), scene.code)


def _enter(scene: Scene) -> Program:
    builder = Builder("flow_enter", "Rates of the unit vectors from angular velocities.")
    q, v = builder.input("q", (scene.nq,), "configuration"), builder.input("v", (scene.nv,), "rates")
    rate = builder.output("rate", (scene.nq,), "rates of the configuration")

    def write(k: Index) -> None:
        store(directions(scene, rate), k, cross(load(directions(scene, v), k), load(directions(scene, q), k)))

    return _per_link(builder, scene, [(v, rate)], write)


def _enter_column(scene: Scene) -> Program:
    builder = Builder("flow_enter_column", "The same along a variation of the state.")
    q, v, dq, dv = (builder.input(name, (scene.nq,), "") for name in ("q", "v", "dq", "dv"))
    d_rate = builder.output("d_rate", (scene.nq,), "of the rates of the configuration")

    def write(k: Index) -> None:
        here, turn, shift, spin = (load(directions(scene, array), k) for array in (q, v, dq, dv))
        store(directions(scene, d_rate), k, add(cross(spin, here), cross(turn, shift)))

    return _per_link(builder, scene, [(dv, d_rate)], write)


def _leave(scene: Scene) -> Program:
    builder = Builder("flow_leave", "Unit vectors and angular velocities again.")
    q, rate = (
        builder.input("q", (scene.nq,), "configuration"),
        builder.input("rate", (scene.nq,), "its rates"),
    )
    q_out, v_out = (
        builder.output("q_out", (scene.nq,), "configuration"),
        builder.output("v_out", (scene.nv,), "rates"),
    )

    def write(k: Index) -> None:
        here, speed = load(directions(scene, q), k), load(directions(scene, rate), k)
        square = builder.let("square", dot(here, here))
        store(directions(scene, q_out), k, scale(1 / builder.sqrt(square), here))
        store(directions(scene, v_out), k, scale(1 / square, cross(here, speed)))

    return _per_link(builder, scene, [(q, q_out), (rate, v_out)], write)


def _settle(scene: Scene) -> Program:
    builder = Builder("flow_settle", "Unit vectors stay unit vectors: what is not tangent goes into the digits lost.")
    x, lost = builder.input("x", (2 * scene.nq,), "state"), builder.input("lost", (2 * scene.nq,), "what rounding took")
    settled = builder.output("settled", (2 * scene.nq,), "the same with the correction")

    def write(k: Index) -> None:
        here, rest = (load(directions(scene, array), k) for array in (x, lost))
        speed, speed_rest = (load(directions(scene, array.shifted(scene.nq)), k) for array in (x, lost))
        excess = builder.let("excess", (dot(here, here) - 1) * 0.5 + dot(here, rest))
        along = builder.let("along", dot(here, speed) + (dot(rest, speed) + dot(here, speed_rest)))
        store(directions(scene, settled), k, sub(rest, scale(excess, here)))
        store(directions(scene, settled.shifted(scene.nq)), k, sub(speed_rest, scale(along, here)))

    return _per_link(
        builder, scene, [(lost, settled), (lost.shifted(scene.nq), settled.shifted(scene.nq))], write
    )


def _leave_column(scene: Scene) -> Program:
    builder = Builder("flow_leave_column", "The same along a variation of (q, q').")
    q, rate, dq, d_rate = (builder.input(name, (scene.nq,), "") for name in ("q", "rate", "dq", "d_rate"))
    dq_out, dv_out = (
        builder.output("dq_out", (scene.nq,), "of q"),
        builder.output("dv_out", (scene.nv,), "of v"),
    )

    def write(k: Index) -> None:
        here, speed, shift, d_speed = (load(directions(scene, array), k) for array in (q, rate, dq, d_rate))
        square = builder.let("square", dot(here, here))
        inverse = builder.let("inverse_square", 1 / square)
        along = builder.let("along", dot(here, shift) * inverse)
        store(directions(scene, dq_out), k, scale(1 / builder.sqrt(square), sub(shift, scale(along, here))))
        turned = add(cross(shift, speed), cross(here, d_speed))
        turned = sub(turned, scale(along + along, cross(here, speed)))
        store(directions(scene, dv_out), k, scale(inverse, turned))

    return _per_link(builder, scene, [(dq, dq_out), (d_rate, dv_out)], write)
