"""The functions that derive spatial accelerations from one factorisation, and the chains that they serve.

Masses at the links' ends: `neighbours`, `tied` where joints transmit moments, both over `response` and `columns`. Masses anywhere on
their links: `mobilities` over `passing`. All others are differentiated.
"""

from __future__ import annotations

from phichain.ir.builder import ArrayRef, Builder
from phichain.lowering.chain.base import carried, on_wall
from phichain.lowering.chain.losses import ties_links
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.chain.units import units_where
from phichain.lowering.spatial import mobilities, tension
from phichain.lowering.spatial.derivatives.base import derivatives as mobility_derivatives
from phichain.lowering.spatial.derivatives.joints import Joints
from phichain.lowering.spatial.derivatives.neighbours import Neighbours
from phichain.lowering.spatial.derivatives.passing import Recalled
from phichain.lowering.spatial.derivatives.response import answers
from phichain.lowering.spatial.derivatives.tied import Tied
from phichain.lowering.spatial.rates import AngularVelocities
from phichain.lowering.writers import writes
from phichain.scene import Scene


def suits(scene: Scene) -> bool:
    """Whether the derivatives of the scene are written out."""
    return by_tensions(scene) or by_mobilities(scene)


def by_mobilities(scene: Scene) -> bool:
    """Whether joints' accelerations carry the chain, of more than one link."""
    return scene.links > 1 and mobilities.suits(on_wall(scene))


def by_tensions(scene: Scene) -> bool:
    """Whether the links are points at their ends."""
    if not scene.tip_masses or scene.actuated_joints:
        return False
    return scene.inertia is None and scene.armature is None and not (ties_links(scene) and scene.links == 1)


@writes("state_jacobian", space="spatial", suits=suits, units=units_where(suits), lumped=True)
def state_jacobian(
    builder: Builder, scene: Scene, parameters: Parameters, q: ArrayRef, v: ArrayRef, dadq: ArrayRef, dadv: ArrayRef,
    u: ArrayRef | None = None, dadu: ArrayRef | None = None,
) -> None:  # fmt: skip
    """The derivatives alone."""
    derivatives(builder, scene, parameters, (q, v, u), (builder.array("a_value", scene.nv), dadq, dadv, dadu))


@writes("dynamics_and_jacobian", space="spatial", suits=suits, units=units_where(suits), lumped=True)
def dynamics_and_jacobian(
    builder: Builder, scene: Scene, parameters: Parameters, q: ArrayRef, v: ArrayRef, a: ArrayRef, dadq: ArrayRef,
    dadv: ArrayRef, u: ArrayRef | None = None, dadu: ArrayRef | None = None,
) -> None:  # fmt: skip
    """The accelerations, and their derivatives."""
    derivatives(builder, scene, parameters, (q, v, u), (a, dadq, dadv, dadu))


def derivatives(
    builder: Builder, scene: Scene, parameters: Parameters, state: tuple[ArrayRef, ArrayRef, ArrayRef | None],
    results: tuple[ArrayRef, ArrayRef, ArrayRef, ArrayRef | None],
) -> None:  # fmt: skip
    """Write the accelerations and their derivatives.

    Args:
        builder: receives the operations.
        scene: a chain that `suits`.
        parameters: in its units.
        state: q, v and u, None where the chain has no input.
        results: a (nv), dadq and dadv (nv, nv), dadu (nv, nu), None where the chain has no input.
    """
    (q, v, u), (a, *_) = state, results
    base = carried(builder, scene, parameters, u)
    base.write_cart(a)
    rates = AngularVelocities(base.scene, base.seen(v), base.seen(a))
    if not by_tensions(scene):
        sweep = Recalled(builder, base.scene, base.parameters, base.seen(q), rates)
        sweep.run(base.u)
        mobility_derivatives(builder, scene, base, sweep, results[1:])
        return
    chain, cosine = tension.chain_of(builder, base.scene, base.parameters, base.seen(q), rates, base.u)
    found = answers(builder, base.parameters, tension.joints_of(base.scene, chain, cosine), base.scene.has_free_cart)
    cart = tension.moved_by(base.scene, chain, cosine, found.tension)
    if chain.moment is None:
        Neighbours(builder, scene, chain, found, cart).write(*results[1:])
        return
    joints = Joints(builder, base.scene, base.parameters, chain.direction, rates.angular(), chain.moment)
    Tied(builder, scene, chain, found, cart, joints).write(*results[1:])
