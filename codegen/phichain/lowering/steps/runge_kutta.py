"""One classical Runge-Kutta step of order 4; spatial states are carried back onto the sphere at its end.

    k_1 = f(x), k_2 = f(x + h/2 k_1), k_3 = f(x + h/2 k_2), k_4 = f(x + h k_3),  x + h/6 (k_1 + 2 k_2 + 2 k_3 + k_4)

with f = (q', v'), q' = v in the plane and q_k' = omega_k x q_k on the sphere, u held over the step.
"""

from __future__ import annotations

from phichain.ir.builder import ArrayRef, Builder, Expr
from phichain.ir.nodes import Program
from phichain.lowering.algebra.vector import cross, load, store
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.spatial.functions import project
from phichain.lowering.spatial.links import directions
from phichain.lowering.writers import writes
from phichain.scene import Scene

_HALF = 0.5


@writes("step", calls=("forward_dynamics",))
def step(
    builder: Builder, scene: Scene, parameters: Parameters, forward: Program, **arguments: ArrayRef
) -> None:
    """Write the state after one step of size h into q_next and v_next."""
    h = arguments["h"][0]
    q, v = arguments["q"], arguments["v"]
    stages: list[tuple[ArrayRef, ArrayRef]] = []
    for weight in (0, _HALF, _HALF, 1):
        at_q, at_v = (q, v) if not stages else moved(builder, scene, (q, v), h * weight, stages[-1])
        inputs = [at_q, at_v, *([arguments["u"]] if scene.nu else [])]
        (acceleration,) = builder.call(forward, inputs, {f"acceleration_{len(stages) + 1}": scene.nv})
        stages.append((velocity(builder, scene, at_q, at_v, len(stages) + 1), acceleration))
    sixth = h / 6
    ends = [(arguments["q_next"], 0, q, scene.nq), (arguments["v_next"], 1, v, scene.nv)]
    if not scene.is_planar:
        ends[0] = (builder.array("q_free", scene.nq), *ends[0][1:])
        ends[1] = (builder.array("v_free", scene.nv), *ends[1][1:])
    for target, part, start, size in ends:
        with builder.loop("i", 0, size) as loop:
            k1, k2, k3, k4 = (stage[part][loop.index] for stage in stages)
            target[loop.index] = start[loop.index] + sixth * ((k1 + k4) + 2 * (k2 + k3))
    if not scene.is_planar:
        project(builder, scene, ends[0][0], ends[1][0], arguments["q_next"], arguments["v_next"])


def velocity(builder: Builder, scene: Scene, q: ArrayRef, v: ArrayRef, stage: int) -> ArrayRef:
    """q' of a stage."""
    if scene.is_planar:
        return v
    velocity = builder.array(f"velocity_{stage}", scene.nq)
    if scene.has_cart:
        velocity[0], velocity[1] = v[0], v[1]
    with builder.loop("k", 0, scene.links) as loop:
        k = loop.index
        turning = cross(load(directions(scene, v), k), load(directions(scene, q), k))
        store(directions(scene, velocity), k, turning)
    return velocity


def moved(
    builder: Builder, scene: Scene, start: tuple[ArrayRef, ArrayRef], by: Expr, slope: tuple[ArrayRef, ArrayRef]
) -> tuple[ArrayRef, ArrayRef]:
    """start + by * slope, cell by cell."""
    made = []
    for name, origin, direction, size in zip(("q_stage", "v_stage"), start, slope, (scene.nq, scene.nv), strict=True):
        target = builder.array(name, size)
        with builder.loop("i", 0, size) as loop:
            target[loop.index] = origin[loop.index] + by * direction[loop.index]
        made.append(target)
    return made[0], made[1]
