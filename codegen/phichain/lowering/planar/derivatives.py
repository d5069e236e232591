"""The derivatives of the planar accelerations by angles, rates and inputs, and the accelerations themselves (theory, section 5)."""

from __future__ import annotations

from phichain.ir.builder import ArrayRef, Builder
from phichain.lowering.chain.losses import brakes_cart, cart_slope, joint_slopes, push_on_cart
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.chain.room import saves_memory
from phichain.lowering.planar.by_columns import sweeps as by_columns
from phichain.lowering.planar.disturbances import (
    Column,
    Disturbance,
    faster_links,
    slowed_joints,
    turned_joints,
)
from phichain.lowering.planar.geared import derivatives as geared
from phichain.lowering.planar.given_base import over_given_base
from phichain.lowering.planar.jacobian import Columns, Target
from phichain.lowering.planar.joints import planar_state
from phichain.lowering.planar.response import Base, Outwards, Recalled, Response
from phichain.lowering.writers import writes
from phichain.scene import Scene

#: Weights of the disturbances at a joint and the next ones in a column by an angle, by a rate of a link.
_ANGLE = {"relative": (1,), "absolute": (1, -1), "adjacent": (1, 0, -1)}
_RATE = {"absolute": (1,), "adjacent": (1, 1)}

#: Masses at the ends of the links of a chain on a cart may differ by so much.
_MOST = 1e6


def suits(scene: Scene) -> bool:
    """Whether no digit is lost against the differentiated sweeps.

    The tension form, which serves masses at the links' ends, keeps 4e-16 on a cart whatever the masses are; here 1e-13 is left where
    they grow by sixteen decades from link to link. Of chains with rotors `geared.derivatives` says it.
    """
    if scene.armature is not None:
        return geared.suits(scene)
    if not (scene.has_free_cart and scene.tip_masses):
        return True
    return not isinstance(scene.mass, str) and max(scene.mass) <= _MOST * min(scene.mass)


@writes("state_jacobian", space="planar", suits=suits, lumped=True)
def state_jacobian(
    builder: Builder, scene: Scene, parameters: Parameters, q: ArrayRef, v: ArrayRef, dadq: ArrayRef, dadv: ArrayRef,
    u: ArrayRef | None = None, dadu: ArrayRef | None = None,
) -> None:  # fmt: skip
    """The derivatives alone."""
    _written(builder, scene, parameters, q, v, u, builder.array("a_value", scene.nv), dadq, dadv, dadu)


@writes("dynamics_and_jacobian", space="planar", suits=suits, lumped=True)
def dynamics_and_jacobian(
    builder: Builder, scene: Scene, parameters: Parameters, q: ArrayRef, v: ArrayRef, a: ArrayRef, dadq: ArrayRef,
    dadv: ArrayRef, u: ArrayRef | None = None, dadu: ArrayRef | None = None,
) -> None:  # fmt: skip
    """The accelerations, and their derivatives."""
    if by_columns.serves(scene):
        by_columns.dynamics_and_columns(builder, scene, parameters, q, v, u, a, dadq, dadv, dadu)
        return
    _written(builder, scene, parameters, q, v, u, a, dadq, dadv, dadu)


def _written(
    builder: Builder, scene: Scene, parameters: Parameters, q: ArrayRef, v: ArrayRef, u: ArrayRef | None, a: ArrayRef,
    dadq: ArrayRef, dadv: ArrayRef, dadu: ArrayRef | None,
) -> None:  # fmt: skip
    """With rotors or without."""
    if scene.armature is not None:
        geared.derivatives(builder, scene, parameters, (q, v, u), (a, dadq, dadv, dadu))
        return
    derivatives(builder, scene, parameters, q, v, u, a, dadq, dadv, dadu)


def derivatives(
    builder: Builder, scene: Scene, parameters: Parameters, q: ArrayRef, v: ArrayRef, u: ArrayRef | None, a: ArrayRef,
    dadq: ArrayRef, dadv: ArrayRef, dadu: ArrayRef | None,
) -> Response | None:  # fmt: skip
    """Write the accelerations and their derivatives; returns how joints answer, where the base's acceleration is not given."""
    if scene.base_accelerations and u is not None and dadu is not None:
        over_given_base(builder, scene, parameters, (q, v, u), (a, dadq, dadv, dadu), derivatives)
        return None
    state = planar_state(builder, scene, q, v)
    sweep = Recalled(builder, scene, parameters, state, u)
    kind, carts = str(scene.angles), int(scene.has_cart)
    response, base, beside = _solved(builder, scene, parameters, sweep, u, a)
    angles = turned_joints(builder, scene, parameters, response, base)
    rates = faster_links(builder, scene, response, base, state.rate) if beside is None else beside
    parts = [] if kind == "relative" else [(rates, _RATE[kind])]
    slopes = joint_slopes(builder, scene, parameters, "resistance", state.joint_rate)
    if slopes is not None:
        parts.append((slowed_joints(builder, scene, slopes, response, base), _ANGLE[kind]))
    by_angle = Column(builder, "by_angle", response, [(angles, _ANGLE[kind])], base)
    by_rate = Column(builder, "by_rate", response, parts, base, rates if kind == "relative" else None)
    sides = [(by_angle, Target(dadq, carts, scene.nv)), (by_rate, Target(dadv, carts, scene.nv))]
    compliance = _compliance(builder, scene, dadu)
    Columns(builder, scene, response, base, parameters.length[0], sides, compliance).write()
    if carts:
        slope = cart_slope(scene, parameters, None if state.speed is None else state.speed[0])
        with builder.loop("i", 0, scene.nv) as loop:
            dadq[loop.index * scene.nv] = 0
        with builder.loop("i", 0, scene.nv) as loop:
            moved = 0 if compliance is None or slope.is_zero else -(slope * compliance.at(loop.index, 0))
            dadv[loop.index * scene.nv] = moved
    if dadu is not None and compliance is not None and compliance.array.name != dadu.name:
        _chosen(builder, scene, compliance, dadu)
    return response


def _solved(
    builder: Builder, scene: Scene, parameters: Parameters, sweep: Recalled, u: ArrayRef | None, a: ArrayRef
) -> tuple[Response, Base, Disturbance | None]:
    """Both sweeps, how joints answer, and what faster links disturb where that was found beside them.

    In relative angles forces of faster links go inwards over all joints while accelerations go outwards over them: neither waits for the
    other, so they share a loop, but for targets where the elimination's own way outwards is the shorter text.
    """
    carts, outer = int(scene.has_cart), sweep.to_base()
    fall, push, slide = parameters.fall, builder.lift(0), -parameters.fall[0]
    if carts:
        push = push_on_cart(scene, parameters, u, sweep.state.speed)
        a[0] = slide = sweep.cart_acceleration(outer, push)
        fall = (-slide, parameters.gravity)
    if saves_memory(scene):
        sweep.all_outwards(-fall[1], -fall[0], a.shifted(carts))
    response = Response(builder, scene, parameters, sweep)
    base = response.on_cart(parameters, outer, slide, push) if carts else response.on_wall(fall, parameters.length[0])
    if saves_memory(scene):
        return response, base, None
    way = Outwards(builder, scene, response, base)
    shared = scene.angles == "relative"
    rates = faster_links(builder, scene, response, base, sweep.state.rate, way.step if shared else None)
    if not shared:
        with builder.loop("k", 1, scene.links) as loop:
            way.step(loop)
    way.finish(a.shifted(carts))
    return response, base, rates


def _compliance(builder: Builder, scene: Scene, dadu: ArrayRef | None) -> Target | None:
    """Where the inverse of the mass matrix goes: into dadu itself where all its columns are asked for.

    What slows the cart is a force on it, whose answers are that inverse's first column.
    """
    if dadu is None and not brakes_cart(scene):
        return None
    if dadu is not None and scene.nu == scene.nv:
        return Target(dadu, 0, scene.nv)
    return Target(builder.array("compliance", scene.nv * scene.nv), 0, scene.nv)


def _chosen(builder: Builder, scene: Scene, compliance: Target, dadu: ArrayRef) -> None:
    """The columns of the inputs that there are."""
    first = [0] if scene.has_force else []
    for column, lane in enumerate([*first, *(int(scene.has_cart) + joint - 1 for joint in scene.actuated_joints)]):
        with builder.loop("i", 0, scene.nv) as loop:
            dadu[loop.index * scene.nu + column] = compliance.at(loop.index, lane)

