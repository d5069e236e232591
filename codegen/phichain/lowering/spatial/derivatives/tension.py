"""The functions that derive spatial accelerations with every mass at its link's end, from one factorisation."""

from __future__ import annotations

from phichain.ir.builder import ArrayRef, Builder
from phichain.lowering.chain.base import carried
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.spatial import tension
from phichain.lowering.spatial.derivatives.columns import Columns
from phichain.lowering.spatial.derivatives.response import answers
from phichain.lowering.spatial.rates import AngularVelocities
from phichain.lowering.writers import writes
from phichain.scene import Scene


def suits(scene: Scene) -> bool:
    """Whether tensions alone tie the links, which are points at their ends, and a free cart is known to be heavy beside them.

    Where joints transmit moments, or the force left for a light cart is a small difference, the sweeps are differentiated.
    """
    if not scene.tip_masses or scene.actuated_joints:
        return False
    if any(getattr(scene, name) is not None for name in ("stiffness", "damping", "friction", "inertia", "armature")):
        return False
    return not scene.has_free_cart or tension.is_heavy(scene)


@writes("state_jacobian", space="spatial", suits=suits, own_units=suits)
def state_jacobian(
    builder: Builder, scene: Scene, parameters: Parameters, q: ArrayRef, v: ArrayRef, dadq: ArrayRef, dadv: ArrayRef,
    u: ArrayRef | None = None, dadu: ArrayRef | None = None,
) -> None:  # fmt: skip
    """The derivatives alone."""
    derivatives(builder, scene, parameters, (q, v, u), (builder.array("a_value", scene.nv), dadq, dadv, dadu))


@writes("dynamics_and_jacobian", space="spatial", suits=suits, own_units=suits)
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
    """Write the accelerations and their derivatives."""
    (q, v, u), (a, *_) = state, results
    base = carried(builder, scene, parameters, u)
    base.write_cart(a)
    rates = AngularVelocities(base.scene, base.seen(v), base.seen(a))
    chain, cosine = tension.chain_of(builder, base.scene, base.parameters, base.seen(q), rates, base.u)
    joints = tension.joints_of(chain, cosine)
    found = answers(builder, base.parameters, joints, base.scene.has_free_cart)
    cart = tension.moved_by(base.scene, chain, cosine, found.tension)
    Columns(builder, scene, chain, found, cart).write(*results[1:])
