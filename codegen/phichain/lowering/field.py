"""The whole vector field of a scene as one Program: accelerations, and in space the rates of the unit vectors."""

from __future__ import annotations

from dataclasses import replace

from phichain.ir.builder import Builder
from phichain.ir.inline import inline
from phichain.ir.nodes import Call, Program
from phichain.ir.passes import prune
from phichain.lowering.algebra.vector import cross, load, store
from phichain.lowering.lower import lower_function
from phichain.mechanics import Model


def vector_field(model: Model) -> Program:
    """v' = a(q, v, u) and, on unit vectors, q_k' = omega_k x q_k (with the cart's x' before them), as loops.

    Planar scenes have q' = v, which needs no Program. Outputs: "a", and "q_dot" on spatial scenes.
    """
    scene, dynamics = model.scene, lower_function(model, "forward_dynamics", "loops")
    if scene.is_planar:
        return inline(dynamics)
    builder = Builder("field", "Derivative of the state.")
    q, v = builder.input("q", (scene.nq,), "configuration"), builder.input("v", (scene.nv,), "rates")
    arguments = ["q", "v"]
    if scene.nu:
        builder.input("u", (scene.nu,), "inputs")
        arguments.append("u")
    builder.output("a", (scene.nv,), "accelerations")
    q_dot = builder.output("q_dot", (scene.nq,), "rates of the configuration")
    offset = 2 if scene.has_cart else 0
    for i in range(offset):
        q_dot[i] = v[i]
    with builder.loop("k", 0, scene.links) as loop:
        k = loop.index
        spin = cross(load(v.shifted(offset), k), load(q.shifted(offset), k))
        store(q_dot.shifted(offset), k, spin)
    rates = builder.finish()
    call = Call("forward_dynamics", tuple(arguments), ("a",))
    whole = replace(
        rates, params=dynamics.params, body=(*rates.body, call), callees={"forward_dynamics": dynamics}
    )
    return prune(inline(whole))
