"""States of planar and spatial chains as vectors z = [x, q_1 .. q_N] with rates z', and the way back to (q, v).

In the plane q_k = (sin phi_k, cos phi_k) and q_k' = phi_k' t_k with the tangent t_k = (cos phi_k, -sin phi_k); in space
q_k' = omega_k x q_k and omega_k = q_k x q_k'.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from phichain.ir.builder import ArrayRef, Builder, Index
from phichain.lowering.algebra.unit_vectors import ambient_size, cart_size, dimension
from phichain.lowering.algebra.vector import Vector, cross, dot, load, multiple, store
from phichain.lowering.chain.losses import brakes_cart, push_on_cart, ties_links
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.planar import joints as planar_joints
from phichain.lowering.planar.joints import PlanarState
from phichain.lowering.spatial import links as spatial_links
from phichain.scene import Scene

#: Corrections of the angle that a planar link has turned by, each cubing the error.
_ANGLE_CORRECTIONS = 2
_HALF = Fraction(1, 2)


def has_couples(scene: Scene) -> bool:
    """Whether anything but gravity and the cart's force acts on the links."""
    return ties_links(scene) or bool(scene.actuated_joints)


def has_push(scene: Scene) -> bool:
    """Whether a horizontal force acts on a free cart."""
    return scene.has_free_cart and (scene.has_force or brakes_cart(scene))


@dataclass(frozen=True)
class Ambient:
    """Writes conversions between (q, v) and (z, z') into one Program."""

    builder: Builder
    scene: Scene
    parameters: Parameters

    @property
    def cart(self) -> int:
        """Number of the cart's coordinates."""
        return cart_size(self.scene)

    def at(self, array: ArrayRef, k: Index) -> Vector:
        """Link k's vector."""
        return load(array.shifted(self.cart), k, dimension(self.scene))

    def put(self, array: ArrayRef, k: Index, value: Vector) -> None:
        """Write link k's vector."""
        store(array.shifted(self.cart), k, value)

    def place(self, suffix: str, q: ArrayRef) -> ArrayRef:
        """z of a configuration; the suffix tells its names from others."""
        if not self.scene.is_planar:
            return q
        builder = self.builder
        place = builder.array(f"place{suffix}", ambient_size(self.scene))
        for i in range(self.cart):
            place[i] = q[i]
        phi = planar_joints.absolute(builder, self.scene, f"phi{suffix}", q.shifted(self.cart))
        sine, cosine = builder.sincos(phi, self.scene.links)
        with builder.loop("k", 0, self.scene.links) as loop:
            self.put(place, loop.index, (sine[loop.index], cosine[loop.index]))
        return place

    def rate(self, place: ArrayRef, v: ArrayRef) -> ArrayRef:
        """z' of rates v at a configuration."""
        builder, scene = self.builder, self.scene
        rate = builder.array("rate", ambient_size(scene))
        for i in range(self.cart):
            rate[i] = v[i]
        if scene.is_planar:
            turning = planar_joints.absolute(builder, scene, "spin", v.shifted(self.cart))
            with builder.loop("k", 0, scene.links) as loop:
                self.put(rate, loop.index, multiple(turning[loop.index], tangent(self.at(place, loop.index))))
        else:
            with builder.loop("k", 0, scene.links) as loop:
                self.put(rate, loop.index, cross(self.at(v, loop.index), self.at(place, loop.index)))
        return rate

    def write_rates(self, rate: ArrayRef, place: ArrayRef, v: ArrayRef, name: str) -> None:
        """The scene's own rates of z' at a configuration, into v; what z' has along the links is left out."""
        builder, scene = self.builder, self.scene
        for i in range(self.cart):
            v[i] = rate[i]
        if not scene.is_planar:
            with builder.loop("k", 0, scene.links) as loop:
                self.put(v, loop.index, cross(self.at(place, loop.index), self.at(rate, loop.index)))
            return
        turning = builder.array(f"turning_{name}", scene.links)
        with builder.loop("k", 0, scene.links) as loop:
            k = loop.index
            turning[k] = dot(tangent(self.at(place, k)), self.at(rate, k))
        planar_joints.from_absolute(builder, scene, turning, v.shifted(self.cart))

    def couple(
        self, q: ArrayRef, v: ArrayRef, place: ArrayRef, u: ArrayRef | None, name: str
    ) -> ArrayRef | None:
        """Forces of springs, dampers and inputs conjugate to the unit vectors, no cart cells; None without any."""
        builder, scene = self.builder, self.scene
        if not has_couples(scene):
            return None
        if not scene.is_planar:
            omega = v.shifted(self.cart)
            direction = q.shifted(self.cart)
            return spatial_links.couples(builder, scene, self.parameters, direction, lambda: omega)
        angle = planar_joints.difference(builder, scene, "joint_angle", q.shifted(self.cart))
        joint_rate = planar_joints.difference(builder, scene, "joint_rate", v.shifted(self.cart))
        state = PlanarState(angle, joint_rate, joint_rate)  # of the rates only the joints' are looked at
        torque = planar_joints.couples(builder, scene, self.parameters, state, u)
        assert torque is not None
        couple = builder.array(name, 2 * scene.links)
        with builder.loop("k", 0, scene.links) as loop:
            store(couple, loop.index, multiple(torque[loop.index], tangent(self.at(place, loop.index))))
        return couple

    def push(self, v: ArrayRef, u: ArrayRef | None, name: str) -> ArrayRef | None:
        """The horizontal force on the cart at rates v, its input less what resists its speed; None without either."""
        if not has_push(self.scene):
            return None
        if not brakes_cart(self.scene):
            return u
        push = self.builder.array(name, self.cart)
        for axis in range(self.cart):
            push[axis] = push_on_cart(self.scene, self.parameters, u, v, axis)
        return push

    def arrive(
        self, q: ArrayRef, place: ArrayRef, moved: ArrayRef, arrived: ArrayRef, way: ArrayRef | None = None
    ) -> ArrayRef | None:
        """The configuration of vectors `moved` that are unit up to rounding, found from q, whose z is `place`.

        Returns:
            The angles that the links of a planar chain have turned by; None in space.
        """
        builder, scene = self.builder, self.scene
        for i in range(self.cart):
            arrived[i] = moved[i]
        if not scene.is_planar:
            with builder.loop("k", 0, scene.links) as loop:
                there = self.at(moved, loop.index)
                self.put(arrived, loop.index, multiple(1 / builder.sqrt(dot(there, there)), there))
            return None
        turned, change = self.turned(place, moved, way), builder.array("change", scene.links)
        planar_joints.from_absolute(builder, scene, turned, change)
        with builder.loop("k", 0, scene.links) as loop:
            k = loop.index
            arrived[k + self.cart] = q[k + self.cart] + change[k]
        return turned

    def turned(self, place: ArrayRef, moved: ArrayRef, way: ArrayRef | None = None) -> ArrayRef:
        """Angles between planar vectors: twice the y with sin y = s, cos y = c, from the first terms of arcsin s.

        With the `way` between them their digits are relative to it, not to the vectors.

        y + s cos y - c sin y = y + sin(exact - y) cubes the error.
        """
        builder, links = self.builder, self.scene.links
        sine, cosine, angle = (
            builder.array(name, links) for name in ("half_sine", "half_cosine", "half_turn")
        )
        with builder.loop("k", 0, links) as loop:
            k = loop.index
            here, there = self.at(place, k), self.at(moved, k)
            over = builder.let("over_norm", 1 / builder.sqrt(dot(there, there)))
            c = builder.let("cosine_k", builder.sqrt(_HALF + _HALF * over * dot(here, there)))
            across = there if way is None else self.at(way, k)
            s = builder.let("sine_k", _HALF * over * dot(tangent(here), across) / c)
            sine[k], cosine[k] = s, c
            x = builder.let("sine_squared", s * s)
            series = Fraction(1, 6) + x * (Fraction(3, 40) + Fraction(5, 112) * x)
            angle[k] = s + s * (x * series)
        for _ in range(_ANGLE_CORRECTIONS):
            sines, cosines = builder.sincos(angle, links)
            better = builder.array("half_turn", links)
            with builder.loop("k", 0, links) as loop:
                k = loop.index
                better[k] = angle[k] + (sine[k] * cosines[k] - cosine[k] * sines[k])
            angle = better
        turned = builder.array("turned", links)
        with builder.loop("k", 0, links) as loop:
            turned[loop.index] = 2 * angle[loop.index]
        return turned


def tangent(unit: Vector) -> Vector:
    """dq/dphi of q = (sin phi, cos phi)."""
    return unit[1], -unit[0]
