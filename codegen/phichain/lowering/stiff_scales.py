"""What errors of an implicit step are measured by: the slowest rate of the hanging chain, and its length."""

from __future__ import annotations

from phichain.ir.builder import Builder
from phichain.ir.nodes import Program
from phichain.ir.passes import prune
from phichain.lowering.chain.parameters import Parameters
from phichain.mechanics import Model


def scales_program(model: Model) -> Program:
    """sqrt(g / L), rad/s, and L, the sum of all lengths, m."""
    builder = Builder("stiff_scales", "Rate sqrt(g / L) at which the chain hangs about, and its length L.")
    scene, parameters = model.scene, Parameters(builder, model)
    scales = builder.output("scales", (2,))
    if scene.length == "runtime":
        with builder.loop("k", 0, scene.links) as loop:
            length = loop.carry("length_before", 0)
            loop.follow(length, length + parameters.length[loop.index])
    else:
        length = builder.lift(0)
        for k in range(scene.links):
            length = length + parameters.length[k]
    scales[0] = builder.sqrt(parameters.gravity / length)
    scales[1] = length
    return prune(builder.finish())
