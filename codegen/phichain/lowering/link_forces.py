"""The force in every link along it, positive in tension, just below the joint that carries it (theory section 5), in O(N).

Joint k takes from link k and all beyond it the force F_k = sum_{a>=k} m_a (r_a'' - g e_d), whatever drives or brakes the joints:
couples and springs act at both sides of a joint, and the motion that they make is in r_a''. The force along the link is

    tension_k = -q_k . F_k

Where every mass sits at its link's end the tensions are the multipliers of the forward dynamics, solved for directly: there they
are as good as the state however unlike the masses are. Elsewhere the masses' accelerations are summed up from the base, their
forces from the tip; then a light link between heavy ones has a tension that is the small difference of the heavy ones' forces,
and can lose as many digits as masses next to each other differ by powers of ten. Where masses or lengths are known to differ much, the
articulated sweep of `spatial.articulated` gives the tension without a difference: of F = alpha' u' (u'.a + c') + G' a + d' all but the first
has no part along q, and u' has 1, so that

    tension_k = -alpha' (u'.a + c'),

and what is in brackets goes outwards there as it is. A planar chain is one of unit vectors in a plane.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.ir.nodes import Program
from phichain.lowering.algebra.vector import Vector, add, cross, dot, load, multiple, named, store, sub, zeros
from phichain.lowering.chain.base import base_acceleration
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.chain.units import units_where
from phichain.lowering.planar import tension as planar_tension
from phichain.lowering.planar.functions import absolute_sincos
from phichain.lowering.planar.joints import PlanarState, absolute, couples, planar_state
from phichain.lowering.spatial import tension as spatial_tension
from phichain.lowering.spatial.articulated import Sweep
from phichain.lowering.spatial.links import directions
from phichain.lowering.spatial.outer import Outer
from phichain.lowering.spatial.rates import AngularVelocities, Rates
from phichain.lowering.writers import writes
from phichain.scene import Scene

#: Masses and lengths further apart than this are uneven; up to here differences of forces cost a digit.
_LARGEST_SPREAD: Final = 16


def are_multipliers(scene: Scene) -> bool:
    """Whether the tensions are the multipliers of a chain of points at the links' ends, on a wall or a cart that a force drives."""
    return scene.tip_masses and scene.armature is None and not (scene.is_driven or scene.is_moving)


def are_uneven(scene: Scene) -> bool:
    """Whether masses or lengths are known to differ so much that no difference of forces may be taken; links are points."""
    if isinstance(scene.mass, str) or isinstance(scene.length, str) or isinstance(scene.com, str) or isinstance(scene.cart_mass, str):
        return False
    if scene.inertia is not None or scene.armature is not None or scene.is_driven or scene.is_moving:
        return False
    masses = [*scene.mass, *([] if scene.cart_mass is None else [scene.cart_mass])]
    is_braked = scene.cart_damping is not None or scene.cart_friction is not None
    spread = max(max(masses) / min(masses), max(scene.length) / min(scene.length))
    return spread > _LARGEST_SPREAD and not is_braked


@writes("tensions", space="planar", calls=("forward_dynamics",), units=units_where(are_multipliers))
def planar_tensions(
    builder: Builder, scene: Scene, parameters: Parameters, forward: Program, q: ArrayRef, v: ArrayRef, out: ArrayRef,
    u: ArrayRef | None = None,
) -> None:  # fmt: skip
    """Link frames have x along the link and y along its tangent and are turned from joint to joint; accelerations carry -g."""
    state = planar_state(builder, scene, q, v)
    if are_multipliers(scene):
        planar_tension.tensions(builder, scene, parameters, state, u, out)
        return
    if are_uneven(scene):
        _in_a_plane(builder, scene, parameters, q, state, u, out)
        return
    links, offset = scene.links, int(scene.has_cart)
    (a,) = builder.call(forward, _arguments(q, v, u), {"a": scene.nv})
    sine, cosine = builder.sincos(state.angle, links)
    alpha = absolute(builder, scene, "alpha", a.shifted(offset))
    sideways, down = _base(builder, scene, parameters, a, u)
    mass, length, com = parameters.mass, parameters.length, parameters.com
    inertial_x, inertial_y = builder.array("inertial_x", links), builder.array("inertial_y", links)
    with builder.loop("k", 0, links) as loop:
        k = loop.index
        before_x, before_y = loop.carry("base_x", down), loop.carry("base_y", sideways)
        joint_x = builder.let("rise_x", cosine[k] * before_x + sine[k] * before_y)
        joint_y = builder.let("rise_y", cosine[k] * before_y - sine[k] * before_x)
        squared = builder.let("rate_squared", state.rate[k] * state.rate[k])
        inertial_x[k] = mass[k] * (joint_x - com[k] * squared)
        inertial_y[k] = mass[k] * (joint_y + com[k] * alpha[k])
        loop.follow(before_x, joint_x - length[k] * squared)
        loop.follow(before_y, joint_y + length[k] * alpha[k])
    with builder.loop("k", links - 1, -1, -1) as loop:
        k = loop.index
        beyond_x, beyond_y = loop.carry("beyond_x", 0), loop.carry("beyond_y", 0)
        force_x = builder.let("force_x", inertial_x[k] + beyond_x)
        force_y = builder.let("force_y", inertial_y[k] + beyond_y)
        out[k] = -force_x
        loop.follow(beyond_x, cosine[k] * force_x - sine[k] * force_y)
        loop.follow(beyond_y, sine[k] * force_x + cosine[k] * force_y)


@writes("tensions", space="spatial", calls=("forward_dynamics",), units=units_where(are_multipliers))
def spatial_tensions(
    builder: Builder, scene: Scene, parameters: Parameters, forward: Program, q: ArrayRef, v: ArrayRef, out: ArrayRef,
    u: ArrayRef | None = None,
) -> None:  # fmt: skip
    """q_k'' = omega_k' x q_k - |omega_k|^2 q_k, and accelerations carry -g."""
    if are_multipliers(scene):
        spatial_tension.tensions(builder, scene, parameters, q, v, u, out)
        return
    if are_uneven(scene):
        rates = AngularVelocities(scene, v, builder.array("unused", scene.nv))
        _swept(_Stretched(builder, scene, parameters, q, rates, out), u)
        return
    (a,) = builder.call(forward, _arguments(q, v, u), {"a": scene.nv})
    direction, omega, alpha = (directions(scene, array) for array in (q, v, a))
    mass, length, com = parameters.mass, parameters.length, parameters.com
    base = _base(builder, scene, parameters, a, u)
    inertial = builder.array("inertial", 3 * scene.links)
    with builder.loop("k", 0, scene.links) as loop:
        k = loop.index
        before = tuple(loop.carry(f"rise_{axis}", start) for axis, start in zip("xyz", base, strict=True))
        here, turning = load(direction, k), load(omega, k)
        bending = named(builder, "bending", sub(cross(load(alpha, k), here), multiple(dot(turning, turning), here)))
        store(inertial, k, multiple(mass[k], add(before, multiple(com[k], bending))))
        for inner, outer in zip(before, add(before, multiple(length[k], bending)), strict=True):
            loop.follow(inner, outer)
    with builder.loop("k", scene.links - 1, -1, -1) as loop:
        k = loop.index
        beyond = tuple(loop.carry(f"beyond_{axis}", start) for axis, start in zip("xyz", zeros(builder, 3), strict=True))
        force = named(builder, "force", add(beyond, load(inertial, k)))
        out[k] = -dot(load(direction, k), force)
        for inner, outer in zip(beyond, force, strict=True):
            loop.follow(inner, outer)


class _Stretched(Sweep):
    """The articulated sweep that writes the tensions on its way outwards; accelerations are nobody's."""

    def __init__(
        self, builder: Builder, scene: Scene, parameters: Parameters, q: ArrayRef, rates: Rates, out: ArrayRef
    ) -> None:
        super().__init__(builder, scene, parameters, q, rates)
        self.out, self.along = out, builder.array("along", scene.links)
        mass, length = parameters.mass, parameters.length
        # What a link passes on is in the units of the one before.
        self.force_unit = parameters.derived("force_unit", lambda k: mass[k - 1 if k else k] * length[k - 1 if k else k])

    def eliminate(self, chain: Outer, k: Index) -> Outer:
        """Link k and all beyond it; keeps its inertia along the link."""
        outer = super().eliminate(chain, k)
        self.along[k] = self.force_unit[k] * outer.axial
        return outer

    def stretched(self, k: Index, stretch: Expr) -> None:
        """Write the tension."""
        self.out[k] = -(self.along[k] * stretch)


@dataclass(frozen=True)
class _PlaneRates:
    """Rates of a planar chain as a spatial sweep reads them."""

    rate: ArrayRef
    bend: ArrayRef | None = None

    def squared(self, k: Index) -> Expr:
        return self.rate[k] * self.rate[k]

    def angular(self) -> ArrayRef:
        return self.rate

    def cart(self) -> ArrayRef:
        return self.rate  # nothing resists a cart here

    def write_cart(self, acceleration: tuple[Expr, Expr]) -> None:
        """Nobody's."""

    def write(self, k: Index, turning: Vector) -> None:
        """Nobody's."""


def _in_a_plane(
    builder: Builder, scene: Scene, parameters: Parameters, q: ArrayRef, state: PlanarState, u: ArrayRef | None, out: ArrayRef
) -> None:
    """q_k = (sin phi_k, 0, cos phi_k), and a couple tau on a link is tau (cos phi_k, 0, -sin phi_k)."""
    links, nothing, first = scene.links, builder.lift(0), 2 * scene.has_cart
    sine, cosine = absolute_sincos(builder, scene, q)
    couple = couples(builder, scene, parameters, state, u)
    direction, moment = builder.array("direction", first + 3 * links), builder.array("moment", 3 * links)
    with builder.loop("k", 0, links) as loop:
        k = loop.index
        store(direction.shifted(first), k, (sine[k], nothing, cosine[k]))
        if couple is not None:
            store(moment, k, (couple[k] * cosine[k], nothing, -(couple[k] * sine[k])))
    alone = replace(
        scene, space="spatial", angles=None, damping=None, stiffness=None, friction=None, friction_speed=None, rest_angle=None,
        actuated="none", want=("forward_dynamics",), variational=False, forced=None, axis=None,
    )  # fmt: skip
    sweep = _Stretched(builder, alone, parameters, direction, _PlaneRates(state.rate), out)
    sweep.couple = None if couple is None else moment
    _swept(sweep, u if scene.has_force else None, axes=1)


def _swept(sweep: _Stretched, u: ArrayRef | None, axes: int = 2) -> None:
    """In to the base and out again; the first entries of u push a cart along so many axes."""
    builder, parameters, scene = sweep.builder, sweep.parameters, sweep.scene
    nothing, chain = builder.lift(0), sweep.inwards()
    base: Vector = (nothing, nothing, -parameters.gravity)
    if scene.has_cart:
        pushed = [] if u is None else [u[i] for i in range(axes)]
        x, y, _ = sweep.close_on_cart(chain, (*pushed, *zeros(builder, 3 - len(pushed))))
        base = (x, y, base[2])
    else:
        chain = sweep.eliminate(chain, 0)
    sweep.outwards(base, chain)


def _base(builder: Builder, scene: Scene, parameters: Parameters, a: ArrayRef, u: ArrayRef | None) -> Vector:
    """The acceleration of the first joint less gravity, the last component down: of a wall, a cart, or a base that is moved."""
    size = 2 if scene.is_planar else 3
    moved = list(zeros(builder, size))
    if scene.has_cart:
        moved[:-1] = [a[i] for i in range(size - 1)]
    if scene.is_moving and u is not None:
        moved = list(base_acceleration(builder, scene, tuple(u[i] for i in range(scene.base_inputs))))
    return (*moved[:-1], moved[-1] - parameters.gravity)


def _arguments(q: ArrayRef, v: ArrayRef, u: ArrayRef | None) -> list[ArrayRef]:
    return [q, v, *([] if u is None else [u])]
