"""What carries the chain: a wall, a cart that forces push, a cart or a base whose acceleration is given.

A wall and a free cart are part of the sweeps: the one does not move, the other has an equation of its own. A base that is given
an acceleration b has none. In its frame the chain is one on a wall under the gravity

    g e_d - b        ("fall" in `Parameters`: what the chain falls with, seen from its base)

so that every sweep that knows a wall serves it, whatever moves it: b = C u on a cart that is driven by its acceleration u = x'',
b = u, up and down too, on a moving base.
"""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from dataclasses import dataclass

from phichain.contract.bases import FIXED
from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.planar.joints import to_generalised
from phichain.scene import Scene


@dataclass(frozen=True)
class Carried:
    """A chain as sweeps see it, which know a wall and a free cart alone.

    Attributes:
        scene: the chain on what they know.
        parameters: its numbers, the fall included.
        first: cells of q, v and their like that stand before what they see, those of a driven cart.
        u: inputs that they see, or None.
        cart: the acceleration of a driven cart, m/s^2.
    """

    scene: Scene
    parameters: Parameters
    first: int
    u: ArrayRef | None
    cart: tuple[Expr, ...]

    def seen(self, array: ArrayRef) -> ArrayRef:
        """The part of an array such as q that the sweeps see."""
        return array.shifted(self.first)

    def write_cart(self, out: ArrayRef) -> None:
        """Write the acceleration of a driven cart to the head of an array such as a."""
        for i, value in enumerate(self.cart):
            out[i] = value


def carried(builder: Builder, scene: Scene, parameters: Parameters, u: ArrayRef | None) -> Carried:
    """How sweeps see a scene under inputs u.

    Args:
        builder: where the Program is recorded.
        scene: the chain.
        parameters: its numbers.
        u: inputs, None for none.
    """
    if not scene.base_accelerations:
        return Carried(scene, parameters, 0, u, ())
    alone = on_wall(scene)
    given = () if u is None else tuple(u[i] for i in range(scene.base_inputs))
    cart = given if scene.is_driven else ()
    acceleration = base_acceleration(builder, scene, given)
    torques = None if u is None or not scene.actuated_joints else u.shifted(scene.base_inputs)
    return Carried(alone, parameters.carried(alone, acceleration), len(cart), torques, cart)


def base_acceleration(builder: Builder, scene: Scene, given: tuple[Expr, ...]) -> tuple[Expr, ...]:
    """b, all d components, of the entries of u that move the base; nothing moves along what is not given."""
    known = dict(zip(scene.told_axes, given, strict=False))
    return tuple(known[axis] if axis in known else builder.lift(0) for axis in range(scene.dimensions))


def on_wall(scene: Scene) -> Scene:
    """The chain of a base that is given an acceleration, on a wall; any other scene as it is."""
    if not scene.base_accelerations:
        return scene
    # A copy: numbers of point masses that stand for rigid links are exact fractions, which a new scene would round.
    view = copy(scene)
    changed = {"base": FIXED.base, "drive": None, "actuated": scene.actuated if scene.actuated_joints else "none"}
    changed |= dict.fromkeys(("cart_mass", "cart_damping", "cart_friction", "cart_friction_speed"))
    for name, value in changed.items():
        object.__setattr__(view, name, value)
    return view


def planar_base_columns(builder: Builder, scene: Scene, coupling: ArrayRef, inertia: ArrayRef, inputs: ArrayRef) -> None:
    """(19) over a base that is given its acceleration: B holds what of M would be its part, and x'' = u has a row of its own.

    Up and down it has none at an upright or hanging chain, to first order. Columns of torques are not written.

    Args:
        builder: where the Program is recorded.
        scene: the chain.
        coupling: mu_k s_k of every link.
        inertia: M; written in the cart's row and column.
        inputs: B.
    """
    carts, nv, nu, nothing = int(scene.has_cart), scene.nv, scene.nu, builder.lift(0)
    row = builder.array("base_row", scene.links)
    to_generalised(builder, scene, coupling, row)
    with builder.loop("k", 0, scene.links) as loop:
        k = loop.index
        for column, axis in enumerate(scene.told_axes):
            inputs[(k + carts) * nu + column] = nothing if axis else -row[k]
        if carts:
            inertia[k + 1] = inertia[(k + 1) * nv] = nothing
    if carts:
        inertia[0], inputs[0] = builder.lift(1), builder.lift(1)


def spatial_base_columns(
    builder: Builder, scene: Scene, coupling: Callable[[Index], Expr], inertia: ArrayRef, inputs: ArrayRef
) -> None:
    """The same in space, in the two horizontal components of each link's rotation."""
    carts, nu, nothing = 2 * scene.has_cart, scene.nu, builder.lift(0)
    size = carts + 2 * scene.links
    with builder.loop("k", 0, scene.links) as loop:
        k, lean = loop.index, coupling(loop.index)
        first, second = (2 * k + carts) * nu, (2 * k + (carts + 1)) * nu
        for cell, value in ((first, (nothing, lean, nothing)), (second, (-lean, nothing, nothing))):
            for column, axis in enumerate(scene.told_axes):
                inputs[cell + column] = value[axis]
    for a in range(carts):
        for b in range(carts):
            inertia[a * size + b] = inputs[a * nu + b] = builder.lift(int(a == b))
        with builder.loop("k", carts, size) as loop:
            inertia[loop.index + a * size] = inertia[loop.index * size + a] = nothing
