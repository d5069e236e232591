"""The accelerations of a planar chain whose joints carry rotors, in O(N)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from phichain.ir.builder import ArrayRef, Builder, Expr
from phichain.lowering.chain.losses import push_on_cart
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.planar.geared.elimination import Elimination, kept_in, layout_of
from phichain.lowering.planar.geared.substitution import Substitution
from phichain.lowering.planar.geared.torques import Torques, torques
from phichain.lowering.planar.joints import PlanarState, from_absolute
from phichain.scene import Scene


@dataclass(frozen=True)
class Solved:
    """The accelerations of a state, and what else it took to find them.

    Attributes:
        builder: where the Program is recorded.
        scene: the chain.
        of: the arrays that the elimination filled, by name.
        substitution: both ways; its work holds what they found.
        cart: the acceleration of a cart.
    """

    builder: Builder
    scene: Scene
    of: Callable[[str], ArrayRef]
    substitution: Substitution
    cart: Expr

    def write(self, a: ArrayRef) -> None:
        """Write [x'', theta'']."""
        write_swing(self.builder, self.scene, self.substitution, self.cart, a)


def accelerations(
    builder: Builder, scene: Scene, parameters: Parameters, state: PlanarState, u: ArrayRef | None, a: ArrayRef
) -> None:
    """Write the accelerations [x'', theta''] into `a`."""
    push = push_on_cart(scene, parameters, u, state.speed) if scene.has_cart else None
    solved(builder, scene, parameters, state, torques(builder, scene, parameters, state, u), push).write(a)


def solved(
    builder: Builder, scene: Scene, parameters: Parameters, state: PlanarState, acting: Torques, push: Expr | None
) -> Solved:
    """Eliminate and substitute.

    Args:
        builder: where the Program is recorded.
        scene: the chain, on a wall or on a cart that moves freely.
        parameters: its numbers.
        state: angles and rates.
        acting: torques on the links and across the joints.
        push: the force on a cart.
    """
    sine, cosine = builder.sincos(state.angle, scene.links)
    kept = {name: builder.array(f"{name}_of", size) for name, size in layout_of(scene) if name not in ("sine", "cosine")}
    elimination = Elimination(builder, scene, parameters, (sine, cosine), kept_in(kept))
    elimination.base(elimination.run(), parameters.fall)
    bend = builder.array("bend", scene.links)
    with builder.loop("k", 0, scene.links) as loop:
        bend[loop.index] = -(state.rate[loop.index] * state.rate[loop.index])
    of = (kept | {"sine": sine, "cosine": cosine}).__getitem__
    substitution = Substitution(builder, parameters, of)
    substitution.inwards(acting, bend, None)
    base, cart = substitution.base(push, scene.has_cart)
    substitution.outwards(base, bend, None)
    return Solved(builder, scene, of, substitution, cart)


def write_swing(builder: Builder, scene: Scene, substitution: Substitution, cart: Expr, a: ArrayRef) -> None:
    """Write what a substitution found, in the scene's own angles."""
    offset = int(scene.has_cart)
    if scene.has_cart:
        a[0] = cart
    if scene.angles != "relative":
        from_absolute(builder, scene, substitution.work["swing"], a.shifted(offset))
        return
    with builder.loop("k", 0, scene.links) as loop:
        a[loop.index + offset] = substitution.work["slip"][loop.index]
