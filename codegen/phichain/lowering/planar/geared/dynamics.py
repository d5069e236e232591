"""The accelerations of a planar chain whose joints carry rotors, in O(N)."""

from __future__ import annotations

from phichain.ir.builder import ArrayRef, Builder
from phichain.lowering.chain.losses import push_on_cart
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.planar.geared.elimination import Elimination, kept_in, layout_of
from phichain.lowering.planar.geared.substitution import Substitution
from phichain.lowering.planar.joints import PlanarState, couples, from_absolute
from phichain.scene import Scene


def accelerations(
    builder: Builder, scene: Scene, parameters: Parameters, state: PlanarState, u: ArrayRef | None, a: ArrayRef
) -> None:
    """Write the accelerations [x'', theta''] into `a`."""
    sine, cosine = builder.sincos(state.angle, scene.links)
    kept = {name: builder.array(f"{name}_of", size) for name, size in layout_of(scene) if name not in ("sine", "cosine")}
    elimination = Elimination(builder, scene, parameters, (sine, cosine), kept_in(kept))
    elimination.base(elimination.run(), parameters.fall)
    bend = builder.array("bend", scene.links)
    with builder.loop("k", 0, scene.links) as loop:
        bend[loop.index] = -(state.rate[loop.index] * state.rate[loop.index])
    substitution = Substitution(builder, parameters, (kept | {"sine": sine, "cosine": cosine}).__getitem__)
    substitution.inwards(couples(builder, scene, parameters, state, u), bend, None)
    push = push_on_cart(scene, parameters, u, state.speed) if scene.has_cart else None
    base, cart = substitution.base(push, scene.has_cart)
    substitution.outwards(base, bend, None)
    offset = int(scene.has_cart)
    if scene.has_cart:
        a[0] = cart
    if scene.angles != "relative":
        from_absolute(builder, scene, substitution.work["swing"], a.shifted(offset))
        return
    with builder.loop("k", 0, scene.links) as loop:
        a[loop.index + offset] = substitution.work["slip"][loop.index]
