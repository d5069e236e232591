"""The two forms of paper B's equations, told apart where a spatial sweep meets them: which rates it reads, what it writes.

(16)-(17) speak of angular velocities: v = [x', omega_k], a = [x'', omega_k']. (15) speaks of the unit vectors themselves:
q' = [x', q_k'] and q'' = [x'', q_k'']. A sweep needs |omega_k|^2 = |q_k'|^2 of the rates alone (dampers need omega_k = q_k x q_k'),
and finds omega_k', of which (15) wants

    q_k'' = omega_k' x q_k - |q_k'|^2 q_k.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.lowering.algebra.vector import Vector, cross, dot, load, scale, store, sub
from phichain.lowering.spatial.links import directions
from phichain.scene import Scene


class Rates(Protocol):
    """What a sweep reads of the rates and of the springs' bends, and where its accelerations go."""

    @property
    def bend(self) -> ArrayRef | None:
        """q_{k-1} - q_k, three cells a link, where they are known to more digits than the q_k are; None where they are not."""

    def squared(self, k: Index) -> Expr:
        """|omega_k|^2."""

    def angular(self) -> ArrayRef:
        """omega, three cells a link."""

    def cart(self) -> ArrayRef:
        """x', two cells."""

    def write_cart(self, acceleration: tuple[Expr, Expr]) -> None:
        """x''."""

    def write(self, k: Index, turning: Vector) -> None:
        """What omega_k' = turning means in this form."""


@dataclass(frozen=True)
class AngularVelocities:
    """(16)-(17): `v` and `a` of [x', omega_k]."""

    scene: Scene
    v: ArrayRef
    a: ArrayRef
    bend: ArrayRef | None = None

    def squared(self, k: Index) -> Expr:
        omega = load(self.angular(), k)
        return dot(omega, omega)

    def angular(self) -> ArrayRef:
        return directions(self.scene, self.v)

    def cart(self) -> ArrayRef:
        return self.v

    def write_cart(self, acceleration: tuple[Expr, Expr]) -> None:
        self.a[0], self.a[1] = acceleration

    def write(self, k: Index, turning: Vector) -> None:
        store(directions(self.scene, self.a), k, turning)


@dataclass(frozen=True)
class DirectionRates:
    """(15): `q_dot` and `q_ddot` of [x', q_k']."""

    builder: Builder
    scene: Scene
    q: ArrayRef
    q_dot: ArrayRef
    q_ddot: ArrayRef
    bend: ArrayRef | None = None

    def squared(self, k: Index) -> Expr:
        rate = load(directions(self.scene, self.q_dot), k)
        return dot(rate, rate)

    def angular(self) -> ArrayRef:
        omega = self.builder.array("omega", 3 * self.scene.links)
        direction, rate = directions(self.scene, self.q), directions(self.scene, self.q_dot)
        with self.builder.loop("k", 0, self.scene.links) as loop:
            store(omega, loop.index, cross(load(direction, loop.index), load(rate, loop.index)))
        return omega

    def cart(self) -> ArrayRef:
        return self.q_dot

    def write_cart(self, acceleration: tuple[Expr, Expr]) -> None:
        self.q_ddot[0], self.q_ddot[1] = acceleration

    def write(self, k: Index, turning: Vector) -> None:
        here = load(directions(self.scene, self.q), k)
        x, y, z = turning
        named = (
            self.builder.let("turning_x", x),
            self.builder.let("turning_y", y),
            self.builder.let("turning_z", z),
        )
        value = sub(cross(named, here), scale(self.squared(k), here))
        store(directions(self.scene, self.q_ddot), k, value)
