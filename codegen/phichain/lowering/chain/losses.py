"""What takes energy from a chain: dampers and dry friction at its joints and its cart, as forces and as their slopes.

    f(v) = d v + F tanh(v / v_0),    f'(v) = d + (F / v_0) (1 - tanh^2(v / v_0)),    f'(0) = d + F / v_0

with v the relative rate of a joint or the speed of the cart. All forces here act against the motion, in the Program's units; a
speed is asked for in SI units and a torque or force comes out in the Program's.

In space v is a vector w, and both laws are c(w) w with

    c = d + (F / v_0) T,    T = tanh(x) / x,    x = |w| / v_0,    dc = g (w.dw),    g = F / v_0^3 (1 - tanh^2(x) - T) / x^2

T is even in x, so that c is a smooth function of w.w, one at rest; x is the root of |w|^2 / v_0^2 + 2^-126, which no digit of T
feels, and which leaves root and quotients something to divide by.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from phichain.contract.chain import LEAST_SQUARE
from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.lowering.algebra.vector import Vector, dot
from phichain.lowering.chain.parameters import Parameters
from phichain.scene import Scene


def ties_links(scene: Scene) -> bool:
    """Whether joints transmit moments: springs, dampers or dry friction."""
    return scene.stiffness is not None or scene.damping is not None or scene.friction is not None


def slows_joints(scene: Scene) -> bool:
    """Whether joints resist their rates."""
    return scene.damping is not None or scene.friction is not None


def brakes_cart(scene: Scene) -> bool:
    """Whether anything resists the speed of a free cart; one that is driven goes where it is told."""
    return scene.has_free_cart and is_braked(scene)


def is_braked(scene: Scene) -> bool:
    """Whether a cart is resisted at all, be it only felt by what drives it."""
    return scene.cart_damping is not None or scene.cart_friction is not None


def joint_drag(scene: Scene, parameters: Parameters, k: Index, rate: Expr) -> Expr | None:
    """d_k v + F_k tanh(v / v_0) of a joint at its relative rate; None where nothing resists."""
    total = None if parameters.damping is None else parameters.damping[k] * rate
    if parameters.friction is None:
        return total
    dry = parameters.friction[k] * _saturation(rate, scene.friction_speed, "joint_saturation")
    return dry if total is None else total + dry


def joint_slope(scene: Scene, parameters: Parameters, k: Index, rate: Expr) -> Expr:
    """d_k + (F_k / v_0) (1 - tanh^2(v / v_0))."""
    total = rate.builder.lift(0) if parameters.damping is None else parameters.damping[k]
    if parameters.friction is None:
        return total
    steepness = _steepness(rate, scene.friction_speed, "joint_saturation")
    return total + (parameters.friction[k] / _speed(scene.friction_speed)) * steepness


def joint_slopes(builder: Builder, scene: Scene, parameters: Parameters, name: str, rate: ArrayRef) -> ArrayRef | None:
    """The same of all joints; the dampers themselves where friction is not there, None where nothing resists."""
    if parameters.friction is None:
        return parameters.damping
    slopes = builder.array(name, scene.links)
    with builder.loop("k", 0, scene.links) as loop:
        slopes[loop.index] = joint_slope(scene, parameters, loop.index, rate[loop.index])
    return slopes


def slopes_at_rest(scene: Scene, parameters: Parameters) -> ArrayRef | None:
    """d_k + F_k / v_0, which a joint at rest resists small rates with."""
    damping, friction = parameters.damping, parameters.friction
    if friction is None:
        return damping
    over = 1 / _speed(scene.friction_speed)
    return parameters.derived(
        "resistance", lambda k: over * friction[k] if damping is None else damping[k] + over * friction[k]
    )


@dataclass(frozen=True)
class Resistance:
    """What resists a vector w as c w.

    Attributes:
        c: the force over the rate.
        g: how c moves, dc = g (w.dw); None for dampers alone.
    """

    c: Expr
    g: Expr | None


def joint_resistance(scene: Scene, parameters: Parameters, k: Index, slip: Vector) -> Expr | None:
    """c of spatial joint k at the difference of its links' angular velocities; None where nothing resists."""
    damping = None if parameters.damping is None else parameters.damping[k]
    if parameters.friction is None:
        return damping
    steep = (1 / _speed(scene.friction_speed)) * parameters.friction[k] * _Vanishing(slip, scene.friction_speed, "joint").share
    return steep if damping is None else damping + steep


def joint_resisted(scene: Scene, parameters: Parameters, k: Index, slip: Vector) -> Resistance:
    """The same and how it moves."""
    c = joint_resistance(scene, parameters, k, slip)
    assert c is not None
    if parameters.friction is None:
        return Resistance(c, None)
    over = 1 / _speed(scene.friction_speed)
    return Resistance(c, over * over * over * parameters.friction[k] * _Vanishing(slip, scene.friction_speed, "joint").bend)


def cart_slopes(scene: Scene, parameters: Parameters, speeds: ArrayRef) -> tuple[Expr, Expr, Expr]:
    """xx, xy and yy of c I + g v v^T of a spatial cart, in the Program's unit of mass over seconds."""
    total = parameters.none if parameters.cart_damping is None else parameters.cart_damping
    if parameters.cart_friction is None:
        return total, parameters.none, total
    over = 1 / _speed(scene.cart_friction_speed)
    steep = over * parameters.units.length * parameters.cart_friction
    x, y = over * speeds[0], over * speeds[1]
    dry = _Vanishing((speeds[0], speeds[1]), scene.cart_friction_speed, "cart")
    c, g = total + steep * dry.share, steep * dry.bend
    return c + g * (x * x), g * (x * y), c + g * (y * y)


class _Vanishing:
    """T and (1 - tanh^2 - T) / x^2 of a vector that may vanish: of its square, without a difference where that is small."""

    def __init__(self, vector: Vector, speed: float | None, name: str) -> None:
        self.builder = vector[0].builder
        over = 1 / _speed(speed)
        let = self.builder.let
        self.ratio = let(f"{name}_ratio", self.builder.apply("sqrt", over * over * dot(vector, vector) + LEAST_SQUARE))
        self.saturation = let(f"{name}_saturation", self.builder.apply("tanh", self.ratio))
        self.over = let(f"{name}_over_ratio", 1 / self.ratio)
        self.share = let(f"{name}_share", self.saturation * self.over)

    @property
    def bend(self) -> Expr:
        """(1 - tanh^2 - T) / x^2, where x is small with an error of one rounding of T over x^2: times w w^T, one of T."""
        steepness = (1 - self.saturation) * (1 + self.saturation)
        return ((steepness - self.share) * self.over) * self.over


def cart_slope_cells(scene: Scene) -> int:
    """Cells that the slopes of a spatial cart take: one number where they are one times the identity."""
    return 1 if scene.cart_friction is None else 3


def as_slopes(cells: ArrayRef, scene: Scene) -> tuple[Expr, Expr, Expr]:
    """xx, xy and yy of what `cart_slopes` left in so many cells."""
    if scene.cart_friction is None:
        return cells[0], cells[0].builder.lift(0), cells[0]
    return cells[0], cells[1], cells[2]


def cart_drag(scene: Scene, parameters: Parameters, speeds: ArrayRef, axis: int = 0) -> Expr:
    """d_0 v + F_0 tanh(v / v_0), or its part along one of the cart's directions in space."""
    speed = speeds[axis]
    total = speed.builder.lift(0)
    if parameters.cart_damping is not None:
        total = parameters.cart_damping * (speed / parameters.units.length)
    if parameters.cart_friction is not None:
        total = total + parameters.cart_friction * _cart_share(scene, speeds, axis)
    return total


def _cart_share(scene: Scene, speeds: ArrayRef, axis: int) -> Expr:
    """tanh(v / v_0), or a part of it in space."""
    if scene.is_planar:
        return _saturation(speeds[0], scene.cart_friction_speed, "cart_saturation")
    over = 1 / _speed(scene.cart_friction_speed)
    return (over * speeds[axis]) * _Vanishing((speeds[0], speeds[1]), scene.cart_friction_speed, "cart").share


def cart_slope(scene: Scene, parameters: Parameters, speed: Expr | None) -> Expr:
    """d_0 + (F_0 / v_0) (1 - tanh^2(v / v_0)) in the Program's unit of mass over seconds; at rest where no speed is given."""
    total = parameters.none if parameters.cart_damping is None else parameters.cart_damping
    if parameters.cart_friction is None:
        return total
    steep = (parameters.cart_friction * parameters.units.length) / _speed(scene.cart_friction_speed)
    return total + (steep if speed is None else steep * _steepness(speed, scene.cart_friction_speed, "cart_saturation"))


def push_on_cart(
    scene: Scene, parameters: Parameters, u: ArrayRef | None, speeds: ArrayRef | None, axis: int = 0
) -> Expr:
    """The horizontal force on the cart along one of its directions: its input, less what resists its speed."""
    force = parameters.none
    if u is not None and scene.has_force:
        force = u[axis] / parameters.units.force
    if speeds is None or not brakes_cart(scene):
        return force
    return force - cart_drag(scene, parameters, speeds, axis)


def rate_unit(speed: float | None) -> Fraction:
    """1 / v_0."""
    return 1 / _speed(speed)


def _speed(speed: float | None) -> Fraction:
    assert speed is not None
    return Fraction(speed)


def _saturation(rate: Expr, speed: float | None, name: str) -> Expr:
    """tanh(v / v_0)."""
    builder = rate.builder
    return builder.let(name, builder.apply("tanh", (1 / _speed(speed)) * rate))


def _steepness(rate: Expr, speed: float | None, name: str) -> Expr:
    """1 - tanh^2(v / v_0), as a product that rounds no small one away beside 1."""
    saturation = _saturation(rate, speed, name)
    return (1 - saturation) * (1 + saturation)
