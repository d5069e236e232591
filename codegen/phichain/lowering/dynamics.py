"""The accelerations: which of the structured forms serves which chain (theory section 3)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from phichain.ir.builder import ArrayRef, Builder
from phichain.lowering.chain.base import Carried, carried, on_wall
from phichain.lowering.chain.body import has_points
from phichain.lowering.chain.light_carriers import carries_lightly
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.chain.time_unit import time_unit
from phichain.lowering.chain.units import Units, units_of_links, units_where
from phichain.lowering.planar import articulated as planar_articulated
from phichain.lowering.planar import tension as planar_tension
from phichain.lowering.planar.both_ends import base_side
from phichain.lowering.planar.both_ends import lanes as planar_lanes
from phichain.lowering.planar.both_ends import scalars as planar_both_ends
from phichain.lowering.planar.geared import dynamics as planar_geared
from phichain.lowering.planar.joints import PlanarState, planar_state
from phichain.lowering.planar.on_targets import ends as planar_ends
from phichain.lowering.planar.stretched import sweep as planar_stretched
from phichain.lowering.spatial import articulated as spatial_articulated
from phichain.lowering.spatial import mobilities
from phichain.lowering.spatial import tension as spatial_tension
from phichain.lowering.spatial.rates import AngularVelocities, DirectionRates, Rates
from phichain.lowering.steps import rigid_links
from phichain.lowering.writers import declared, helps, writes
from phichain.scene import Scene

#: The planar accelerations for many states at once.
OF_MANY: Final = "dynamics_of_many"
#: Those of runtime parameters that have been prepared.
OF_PREPARED: Final = "dynamics_of_prepared"
#: A sweep that writes the accelerations.
Form = Callable[[Builder, Scene, Parameters, PlanarState, ArrayRef | None, ArrayRef], None]


def by_tensions(scene: Scene) -> bool:
    """Whether the sweeps solve for tensions."""
    return planar_tension.suits(scene) if scene.is_planar else scene.tip_masses


def in_units_of_links(scene: Scene) -> bool:
    """Whether a sweep computes in units of the scene's links; the articulated ones have units of their own."""
    scene = on_wall(scene)
    return by_tensions(scene) or (not scene.is_planar and mobilities.suits(scene))


def planar_units(scene: Scene) -> Units:
    """Units of a planar chain's accelerations; rotors' are those of SI, and so are others' but for time (`time_unit`)."""
    if in_units_of_links(scene):
        return units_of_links(scene)
    return Units(time=time_unit(scene)) if scene.armature is None else Units()


@writes("forward_dynamics", space="planar", units=planar_units, lumped=True)
def planar_forward_dynamics(
    builder: Builder, scene: Scene, parameters: Parameters, q: ArrayRef, v: ArrayRef, a: ArrayRef, u: ArrayRef | None = None
) -> None:
    """(15) of paper A solved for the accelerations."""
    _planar(builder, scene, parameters, {"q": q, "v": v, "a": a} | ({} if u is None else {"u": u}), _in_lanes)


@helps(OF_MANY, "The accelerations in the fewest operations.", units=planar_units, lumped=True)
def dynamics_of_many(builder: Builder, scene: Scene, parameters: Parameters) -> None:
    """The Program `dynamics_of_many`: q, v[, u] -> a of a planar chain, for vectors that hold a number of every state."""
    _planar(builder, scene, parameters, declared(builder, scene, "forward_dynamics"), _by_scalars)


@helps(OF_PREPARED, "The accelerations where runtime parameters have been prepared.", units=planar_units, lumped=True)
def dynamics_of_prepared(builder: Builder, scene: Scene, parameters: Parameters) -> None:
    """The Program `dynamics_of_prepared`: q, v[, u] -> a of a long planar chain, whose tables are not made at every call."""
    _planar(builder, scene, parameters, declared(builder, scene, "forward_dynamics"), lambda _: planar_lanes.accelerations)


def form_of_prepared(scene: Scene) -> str:
    """The Program that is split into what runtime parameters alone determine and the rest."""
    on_its_wall = on_wall(scene)
    of_lanes = scene.is_planar and _by_scalars(on_its_wall) is planar_both_ends.accelerations and planar_lanes.suits_prepared(on_its_wall)
    return OF_PREPARED if of_lanes else "forward_dynamics"


def form_of_many(scene: Scene) -> str:
    """The Program that many states at once run fastest: where their numbers fill the vectors, two lanes of one state only cost operations."""
    return OF_MANY if scene.is_planar and planar_lanes.suits(on_wall(scene)) else "forward_dynamics"


def _planar(
    builder: Builder, scene: Scene, parameters: Parameters, given: dict[str, ArrayRef], form_of: Callable[[Scene], Form]
) -> None:
    q, v, a, u = given["q"], given["v"], given["a"], given.get("u")
    base, time = carried(builder, scene, parameters, u), parameters.units.time
    state = planar_state(builder, base.scene, base.seen(q), base.seen(v), time)
    base.write_cart(a)
    found = base.seen(a) if time == 1 else builder.array("measured", base.scene.nv)
    form_of(base.scene)(builder, base.scene, base.parameters, state, base.u, found)
    if time != 1:
        with builder.loop("k", 0, base.scene.nv) as loop:
            base.seen(a)[loop.index] = found[loop.index] / time**2


def _in_lanes(scene: Scene) -> Form:
    """What serves a planar chain."""
    form = _by_scalars(scene)
    return planar_lanes.accelerations if form is planar_both_ends.accelerations and planar_lanes.suits(scene) else form


def _by_scalars(scene: Scene) -> Form:
    """The same without lanes."""
    if scene.armature is not None:
        return planar_geared.accelerations
    if by_tensions(scene):
        return planar_tension.accelerations
    if carries_lightly(scene):
        return planar_stretched.accelerations
    if planar_ends.suits(scene):
        return planar_ends.accelerations
    return (planar_both_ends if base_side.suits(scene) else planar_articulated).accelerations


@writes("forward_dynamics", space="spatial", units=units_where(in_units_of_links), lumped=True)
def spatial_forward_dynamics(
    builder: Builder, scene: Scene, parameters: Parameters, q: ArrayRef, v: ArrayRef, a: ArrayRef, u: ArrayRef | None = None
) -> None:
    """(16) of paper B solved for [x'', omega']."""
    base = carried(builder, scene, parameters, u)
    base.write_cart(a)
    _sweep(builder, base, base.seen(q), AngularVelocities(base.scene, base.seen(v), base.seen(a)))


@helps("bent_dynamics", "The accelerations where springs are bent as given.", units=units_where(in_units_of_links), lumped=True)
def bent_dynamics(builder: Builder, scene: Scene, parameters: Parameters) -> None:
    """The Program `bent_dynamics`: q, v, bend[, u] -> a of a sprung spatial chain, bend = q_{k-1} - q_k of every joint.

    A spring makes a moment of k q_k x (q_{k-1} - q_k): what rounding took from unit vectors is k times as much there.
    """
    q, v = builder.input("q", (scene.nq,), "configuration"), builder.input("v", (scene.nv,), "rates")
    bend = builder.input("bend", (3 * scene.links,), "q_{k-1} - q_k")
    u = builder.input("u", (scene.nu,), "inputs") if scene.nu else None
    a = builder.output("a", (scene.nv,), "accelerations")
    base = carried(builder, scene, parameters, u)
    base.write_cart(a)
    _sweep(builder, base, base.seen(q), AngularVelocities(base.scene, base.seen(v), base.seen(a), bend))


@writes("direction_dynamics", units=units_where(in_units_of_links), lumped=True)
def direction_dynamics(
    builder: Builder, scene: Scene, parameters: Parameters, q: ArrayRef, q_dot: ArrayRef, q_ddot: ArrayRef,
    u: ArrayRef | None = None,
) -> None:  # fmt: skip
    """(15) of paper B solved for [x'', q''] of the unit vectors."""
    base = carried(builder, scene, parameters, u)
    base.write_cart(q_ddot)
    arrays = base.seen(q), base.seen(q_dot), base.seen(q_ddot)
    _sweep(builder, base, arrays[0], DirectionRates(builder, base.scene, *arrays))


def _sweep(builder: Builder, base: Carried, q: ArrayRef, rates: Rates) -> None:
    """Any form of a spatial chain's accelerations."""
    if by_tensions(base.scene):
        spatial_tension.accelerations(builder, base.scene, base.parameters, q, rates, base.u)
        return
    if base.scene.inertia is not None and not has_points(base.scene):
        rigid_links.accelerations(builder, base.scene, base.parameters, q, rates, base.u)
        return
    form = mobilities if mobilities.suits(base.scene) else spatial_articulated
    form.accelerations(builder, base.scene, base.parameters, q, rates, base.u)
