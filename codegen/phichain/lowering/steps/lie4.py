"""A Runge-Kutta-Munthe-Kaas step of order 4 on unit vectors: every stage lies on the spheres, by a rotation (theory section 8).

Write q_k = R_k q_k(0) and omega_k = R_k eta_k with R_k' = hat(omega_k) R_k. Then eta_k stays in the fixed plane that is orthogonal to
q_k(0), and with R_k = exp(hat(Theta_k))

    Theta' = dexp^-1_{-Theta} eta = eta + Theta x eta / 2 + Theta x (Theta x eta) / 12 + O(Theta^4),    eta' = R^T omega'(q, omega)

is a differential equation in a vector space, together with x and x'. The classical method of order 4 takes one step from
Theta = 0; what the series leaves out is O(h^5) of the step's end. Steady rotation is exact.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.ir.nodes import Program
from phichain.lowering.algebra.matrix import applied
from phichain.lowering.algebra.vector import Vector, add, cross, dot, load, scale, store, sub
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.spatial.links import directions
from phichain.lowering.steps import runge_kutta
from phichain.lowering.writers import writes
from phichain.scene import Scene

#: Added to |Theta|^2 so that sin(|Theta|) / |Theta| has no 0 / 0; it changes no digit of it, in single precision neither.
_TINY = Fraction(1, 2**100)
_HALF = Fraction(1, 2)


@dataclass(frozen=True)
class _Slope:
    """Derivatives at a stage: of the rotation vectors, and of [x', eta]."""

    rotation: ArrayRef
    rate: ArrayRef


@writes("step_lie4", space="planar", calls=("forward_dynamics",))
def planar_step(
    builder: Builder, scene: Scene, parameters: Parameters, forward: Program, **arguments: ArrayRef
) -> None:
    """Turns of the plane commute: the method is Runge-Kutta on the angles."""
    runge_kutta.step(builder, scene, parameters, forward, **arguments)


@writes("step_lie4", space="spatial", calls=("forward_dynamics",))
def spatial_step(
    builder: Builder, scene: Scene, parameters: Parameters, forward: Program, **arguments: ArrayRef
) -> None:
    """Write q_next and v_next."""
    _Step(builder, scene, forward, arguments).run()


class _Step:
    """The step being written: `run` is the whole of it."""

    def __init__(
        self, builder: Builder, scene: Scene, forward: Program, arguments: dict[str, ArrayRef]
    ) -> None:
        self.builder, self.scene, self.forward, self.arguments = builder, scene, forward, arguments
        self.h, self.q, self.v = arguments["h"][0], arguments["q"], arguments["v"]
        self.cart = 2 if scene.has_cart else 0

    def run(self) -> None:
        """Write q_next and v_next."""
        (start,) = self.builder.call(
            self.forward, self._inputs(self.q, self.v), {"acceleration_1": self.scene.nv}
        )
        first = _Slope(self.v.shifted(self.cart), start)
        speeds = [self.v]
        slopes = [first]
        for number, weight in ((2, _HALF), (3, _HALF), (4, 1)):
            slope, speed = self._stage(slopes[-1], speeds[-1], self.h * weight, number)
            slopes.append(slope)
            speeds.append(speed)
        self._end(slopes, speeds)

    def _inputs(self, q: ArrayRef, v: ArrayRef) -> list[ArrayRef]:
        return [q, v, *([self.arguments["u"]] if self.scene.nu else [])]

    def _stage(self, slope: _Slope, speed: ArrayRef, by: Expr, number: int) -> tuple[_Slope, ArrayRef]:
        """One stage: its slope, and its [x', eta]."""
        builder, scene, cart = self.builder, self.scene, self.cart
        q, v = builder.array("q_stage", scene.nq), builder.array("v_stage", scene.nv)
        turning = builder.array(f"turning_{number}", 3 * scene.links)
        moved = builder.array(f"rate_{number}", scene.nv)
        with builder.loop("i", 0, scene.nv) as loop:
            moved[loop.index] = self.v[loop.index] + by * slope.rate[loop.index]
        for i in range(cart):
            q[i] = self.q[i] + by * speed[i]
            v[i] = moved[i]
        theta = builder.array("theta", 3 * scene.links)
        with builder.loop("i", 0, 3 * scene.links) as loop:
            theta[loop.index] = by * slope.rotation[loop.index]
        rotation = self._rotations(theta)
        with builder.loop("k", 0, scene.links) as loop:
            k = loop.index
            angle, eta = load(theta, k), load(moved.shifted(cart), k)
            rows = _rows(rotation, k)
            store(q.shifted(cart), k, applied(rows, load(directions(scene, self.q), k)))
            store(v.shifted(cart), k, applied(rows, eta))
            once = cross(angle, eta)
            twice = scale(Fraction(1, 12), cross(angle, once))
            store(turning, k, add(eta, add(scale(_HALF, once), twice)))
        (acceleration,) = builder.call(self.forward, self._inputs(q, v), {f"acceleration_{number}": scene.nv})
        rate = builder.array(f"rate_slope_{number}", scene.nv)
        for i in range(cart):
            rate[i] = acceleration[i]
        with builder.loop("k", 0, scene.links) as loop:
            k = loop.index
            back = _back(_rows(rotation, k), load(acceleration.shifted(cart), k))
            store(rate.shifted(cart), k, back)
        return _Slope(turning, rate), moved

    def _rotations(self, theta: ArrayRef) -> ArrayRef:
        """exp(hat(Theta_k)) = I + 2 c hat(e) + 2 hat(e)^2, row by row; c, e = cos, sin of half the angle along Theta."""
        builder, links = self.builder, self.scene.links
        half, rotation = builder.array("half_angle", links), builder.array("rotation", 9 * links)
        with builder.loop("k", 0, links) as loop:
            angle = load(theta, loop.index)
            half[loop.index] = _HALF * builder.sqrt(dot(angle, angle) + _TINY)
        sine, cosine = builder.sincos(half, links)
        with builder.loop("k", 0, links) as loop:
            k = loop.index
            x, y, z = scale(builder.let("shrink", _HALF * (sine[k] / half[k])), load(theta, k))
            c = cosine[k]
            rows = (
                (1 - 2 * (y * y + z * z), 2 * (x * y - c * z), 2 * (x * z + c * y)),
                (2 * (x * y + c * z), 1 - 2 * (x * x + z * z), 2 * (y * z - c * x)),
                (2 * (x * z - c * y), 2 * (y * z + c * x), 1 - 2 * (x * x + y * y)),
            )
            for i, row in enumerate(rows):
                store(rotation, 3 * k + i, row)
        return rotation

    def _end(self, slopes: list[_Slope], speeds: list[ArrayRef]) -> None:
        """The weighted sum of the stages, and one rotation with it; rounding is taken off the lengths and the tangency."""
        builder, scene, cart = self.builder, self.scene, self.cart
        q_next, v_next = self.arguments["q_next"], self.arguments["v_next"]
        sixth = self.h * Fraction(1, 6)
        for i in range(cart):
            k1, k2, k3, k4 = (speed[i] for speed in speeds)
            q_next[i] = self.q[i] + sixth * ((k1 + k4) + 2 * (k2 + k3))
        theta, rate = builder.array("theta", 3 * scene.links), builder.array("rate_end", scene.nv)
        with builder.loop("i", 0, 3 * scene.links) as loop:
            k1, k2, k3, k4 = (slope.rotation[loop.index] for slope in slopes)
            theta[loop.index] = sixth * ((k1 + k4) + 2 * (k2 + k3))
        with builder.loop("i", 0, scene.nv) as loop:
            k1, k2, k3, k4 = (slope.rate[loop.index] for slope in slopes)
            rate[loop.index] = self.v[loop.index] + sixth * ((k1 + k4) + 2 * (k2 + k3))
        rotation = self._rotations(theta)
        for i in range(cart):
            v_next[i] = rate[i]
        with builder.loop("k", 0, scene.links) as loop:
            k = loop.index
            rows = _rows(rotation, k)
            turned = applied(rows, load(directions(scene, self.q), k))
            unit = scale(builder.let("lengthen", Fraction(3, 2) - _HALF * dot(turned, turned)), turned)
            omega = applied(rows, load(rate.shifted(cart), k))
            store(q_next.shifted(cart), k, unit)
            store(v_next.shifted(cart), k, sub(omega, scale(dot(unit, omega), unit)))


def _rows(rotation: ArrayRef, k: Index) -> tuple[Vector, Vector, Vector]:
    """Link k's rotation matrix."""
    first, second, third = (load(rotation, 3 * k + i) for i in range(3))
    return first, second, third


def _back(rows: tuple[Vector, Vector, Vector], a: Vector) -> Vector:
    """R^T a"""
    return add(add(scale(a[0], rows[0]), scale(a[1], rows[1])), scale(a[2], rows[2]))
