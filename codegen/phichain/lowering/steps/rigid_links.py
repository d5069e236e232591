"""Spatial forward dynamics of rigid links that may be held at their centres of mass: `articulated_links` under their own constraints.

Such a link has a moment of inertia and no point mass anywhere, which the sweep of `spatial.articulated` measures by. The accelerations
of the unit vectors obey q.q'' = -|q'|^2, and omega' = q x q''.
"""

from __future__ import annotations

from phichain.ir.builder import ArrayRef, Builder
from phichain.lowering.algebra.unit_vectors import ambient_size
from phichain.lowering.algebra.vector import cross, load
from phichain.lowering.chain.losses import push_on_cart
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.spatial.links import couples, directions
from phichain.lowering.spatial.rates import Rates
from phichain.lowering.steps.articulated_links import sweep
from phichain.lowering.steps.link_multipliers import Links
from phichain.scene import Scene


def accelerations(
    builder: Builder, scene: Scene, parameters: Parameters, q: ArrayRef, rates: Rates, u: ArrayRef | None
) -> None:
    """Write x'' and the omega_k' through `rates`."""
    along, out = builder.array("along", scene.links), builder.array("bending", ambient_size(scene))
    with builder.loop("k", 0, scene.links) as loop:
        along[loop.index] = -rates.squared(loop.index)
    couple = couples(builder, scene, parameters, directions(scene, q), rates.angular, rates.bend)
    push = None
    if scene.has_cart:
        speeds = rates.cart()
        push = (push_on_cart(scene, parameters, u, speeds, 0), push_on_cart(scene, parameters, u, speeds, 1))
    sweep(Links(builder, scene, parameters, q, q, along, couple, push, out))
    if scene.has_cart:
        rates.write_cart((out[0], out[1]))
    with builder.loop("k", 0, scene.links) as loop:
        k = loop.index
        rates.write(k, cross(load(directions(scene, q), k), load(directions(scene, out), k)))
