"""Spatial forward dynamics with every mass at its link's end (r = l), theory section 5: tensions on unit vectors, no trigonometry.

With X_k = q_k x q_{k-1} and N_k = n_k / l_k the force pairs of springs and dampers, f the horizontal force left for the cart,

    b_k = l_k |omega_k|^2 - q_k.N_{k+1} / m_k - q_k.N_{k-1} / m_{k-1},   b_0 gains (g e_3 - C f / m_c).q_0
    l_k omega_k' = (lambda_{k-1} / m_{k-1}) X_k - (lambda_{k+1} / m_k) X_{k+1}
                   + q_k x (N_k (1/m_k + 1/m_{k-1}) - N_{k+1} / m_k - N_{k-1} / m_{k-1})
    (m_c + m_0 |h|^2) x'' = f + h (m_0 (b_0 + h.f / m_c) + c_1 lambda_1) + (m_0 / m_c) h* (h*.f),   h = C^T q_0,   f = u - C^T N_0
    l_0 omega_0' gains q_0 x (g e_3 - C x'')

h* is h turned by a right angle. The cart's equation is m_c x'' = f + lambda_0 h with lambda_0 put in: on a light cart the two
forces all but cancel along h. What is left of them is at least the part m_c / (m_c + sum m_k), so on a cart that is known to be heavy
enough m_c x'' = f + lambda_0 h is the shorter way.
"""

from __future__ import annotations

from dataclasses import dataclass

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.lowering.algebra.vector import Vector, add, cross, dot, load, scale, store, sub
from phichain.lowering.chain.losses import brakes_cart, cart_drag
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.spatial.links import (
    cosines,
    couples_of,
    directions,
    joint_moments,
    neighbours,
    write_cross,
)
from phichain.lowering.spatial.rates import AngularVelocities, Rates
from phichain.lowering.tensions import Joints, middle, solve_tensions, takes_cosines, write_tensions
from phichain.scene import Scene

#: Up to this ratio of the chain's mass to the cart's the forces on the cart are added as they are.
_LARGEST_LOAD = 16


@dataclass(frozen=True)
class Chain:
    """What both halves of the computation share: `moment` of the joints and `pair` are zero beyond the tip, `horizontal` is f / m_c."""

    builder: Builder
    parameters: Parameters
    direction: ArrayRef
    rates: Rates
    crosses: ArrayRef
    moment: ArrayRef | None
    pair: ArrayRef | None
    horizontal: tuple[Expr, Expr] | None


def accelerations(
    builder: Builder, scene: Scene, parameters: Parameters, q: ArrayRef, rates: Rates, u: ArrayRef | None
) -> None:
    """Write x'' and the omega_k' through `rates`."""
    chain, cosine = chain_of(builder, scene, parameters, q, rates, u)
    moved_by(scene, chain, cosine, solve_tensions(builder, parameters, joints_of(scene, chain, cosine)))


def moved_by(scene: Scene, chain: Chain, cosine: ArrayRef, tension: ArrayRef) -> tuple[Expr, Expr] | None:
    """Write the accelerations that these tensions over the masses make; returns x'' in the Program's units."""
    cart = _heavy_cart(scene, chain, tension) if is_heavy(scene) else _cart(chain, cosine, tension)
    if cart is not None:
        unit = chain.parameters.units.length
        chain.rates.write_cart((cart[0] * unit, cart[1] * unit))
    # The first tension pulls along C^T q_0, which q_0 does not turn about the vertical: what turns it there need not wait for it.
    upright = chain.horizontal if is_heavy(scene) else None
    if by_cosines(scene):
        write_cross(chain.builder, chain.crosses, chain.direction, 1)
    _first(chain, tension, cart, upright)
    _beyond(chain, tension)
    return cart


def tensions(
    builder: Builder, scene: Scene, parameters: Parameters, q: ArrayRef, v: ArrayRef, u: ArrayRef | None, out: ArrayRef
) -> None:
    """Write the links' tensions, N, into `out`; no acceleration is made of them."""
    rates = AngularVelocities(scene, v, builder.array("acceleration", scene.nv))
    chain, cosine = chain_of(builder, scene, parameters, q, rates, u)
    write_tensions(builder, parameters, solve_tensions(builder, parameters, joints_of(scene, chain, cosine)), out)


def chain_of(
    builder: Builder, scene: Scene, parameters: Parameters, q: ArrayRef, rates: Rates, u: ArrayRef | None
) -> tuple[Chain, ArrayRef]:
    """The chain, and the cosines between its links."""
    direction = directions(scene, q)
    cosine, crosses = (cosines if by_cosines(scene) else neighbours)(builder, direction, scene.links)
    moment = joint_moments(builder, scene, parameters, direction, rates.angular, rates.bend)
    pair = None if moment is None else _force_pairs(builder, scene, parameters, direction, moment)
    horizontal = _horizontal(builder, scene, parameters, rates, u, pair)
    return Chain(builder, parameters, direction, rates, crosses, moment, pair, horizontal), cosine


def _force_pairs(builder: Builder, scene: Scene, parameters: Parameters, direction: ArrayRef, moment: ArrayRef) -> ArrayRef:
    couple = couples_of(builder, scene, direction, moment)
    inverse_length = parameters.derived("inverse_length", lambda k: 1 / parameters.length[k])
    pair = builder.array("force_pair", 3 * scene.links + 3)
    with builder.loop("k", 0, scene.links) as loop:
        store(pair, loop.index, scale(inverse_length[loop.index], load(couple, loop.index)))
    nothing = builder.lift(0)
    store(pair, scene.links, (nothing, nothing, nothing))
    return pair


def _horizontal(
    builder: Builder, scene: Scene, parameters: Parameters, rates: Rates, u: ArrayRef | None, pair: ArrayRef | None
) -> tuple[Expr, Expr] | None:
    """f / m_c, what the cart's acceleration would be without the first tension."""
    if not scene.has_cart:
        return None
    total = []
    for i in range(2):
        force = builder.lift(0) if u is None else u[i] * (1 / (parameters.base_mass * parameters.units.force))
        if brakes_cart(scene):
            force = force - cart_drag(scene, parameters, rates.cart(), i) / parameters.base_mass
        pull = builder.lift(0) if pair is None else pair[i] / parameters.base_mass
        total.append(builder.let("free_cart_acceleration", force - pull))
    return total[0], total[1]


def joints_of(scene: Scene, chain: Chain, cosine: ArrayRef) -> Joints:
    """The system of the tensions.

    A cart that may be light takes x'' from row 0, which is to hold off the spheres too: the fronts meet beyond link 0, where there is one.
    """
    builder, parameters = chain.builder, chain.parameters
    links = parameters.links
    right_side = builder.array("right_side", links)
    right_side[0] = _first_right_side(scene, chain)
    with builder.loop("k", 1, links) as loop:
        right_side[loop.index] = _right_side(chain, loop.index)
    squared = None if by_cosines(scene) else _sines_squared(chain)
    base_slack = builder.lift(0)
    if chain.horizontal is not None:
        x, y, _ = load(chain.direction, 0)
        base_slack = parameters.mass[0] / parameters.base_mass * (x * x + y * y)
    meeting = middle(links)
    if chain.horizontal is not None and not is_heavy(scene):
        meeting = max(meeting, min(1, links - 1))
    return Joints(cosine, squared, base_slack, right_side, meeting)


def _sines_squared(chain: Chain) -> ArrayRef:
    links = chain.parameters.links
    squared = chain.builder.array("sine_squared", links)
    with chain.builder.loop("k", 1, links) as loop:
        across = load(chain.crosses, loop.index)
        squared[loop.index] = dot(across, across)
    return squared


def _right_side(chain: Chain, k: Index) -> Expr:
    parameters = chain.parameters
    value = parameters.length[k] * chain.rates.squared(k)
    if chain.pair is None:
        return value
    here = load(chain.direction, k)
    value = value - dot(here, load(chain.pair, k + 1)) / parameters.mass[k]
    return value - dot(here, load(chain.pair, k - 1)) / parameters.mass[k - 1]


def _first_right_side(scene: Scene, chain: Chain) -> Expr:
    """b_0. Its weight and the pull on the cart, and the rate's square, are sums of their own, which do not wait for each other.

    A cart that may be light wants the weight with the rate's square, without the pull, once more.
    """
    if chain.horizontal is None:
        return _still_right_side(chain)
    x, y = (chain.direction[i] * chain.horizontal[i] for i in range(2))
    if not is_heavy(scene):
        return _still_right_side(chain) - (x + y)
    return _with_rate(chain, _weight(chain) - x - y)


def _still_right_side(chain: Chain) -> Expr:
    """b_0 over a base that stands still, or is given its acceleration."""
    return _with_rate(chain, _weight(chain))


def _weight(chain: Chain) -> Expr:
    return dot(chain.parameters.fall, load(chain.direction, 0))


def _with_rate(chain: Chain, weight: Expr) -> Expr:
    parameters = chain.parameters
    value = weight + parameters.length[0] * chain.rates.squared(0)
    if chain.pair is not None:
        value = value - dot(load(chain.direction, 0), load(chain.pair, 1)) / parameters.mass[0]
    return value


def is_heavy(scene: Scene) -> bool:
    """Whether the cart is known to be heavy beside the chain."""
    if isinstance(scene.mass, str) or isinstance(scene.cart_mass, str) or scene.cart_mass is None:
        return False
    return sum(scene.mass) <= _LARGEST_LOAD * scene.cart_mass


def by_cosines(scene: Scene) -> bool:
    """Whether the tensions are found from cosines alone, and q_1 x q_0 is formed where it is used."""
    return takes_cosines(scene) and (is_heavy(scene) or not scene.has_cart)


def _heavy_cart(scene: Scene, chain: Chain, tension: ArrayRef) -> tuple[Expr, Expr]:
    """x'' from the force and the first tension."""
    assert chain.horizontal is not None
    builder, parameters = chain.builder, chain.parameters
    if parameters.links == 1:
        x, y, _ = load(chain.direction, 0)
        pull = _first_right_side(scene, chain) / (parameters.base_mass / parameters.mass[0] + x * x + y * y)
    else:
        pull = tension[0] * (parameters.mass[0] / parameters.base_mass)
    pull = builder.let("pull_on_cart", pull)
    first, second = (free + chain.direction[i] * pull for i, free in enumerate(chain.horizontal))
    return builder.let("cart_acceleration", first), builder.let("cart_acceleration", second)


def _cart(chain: Chain, cosine: ArrayRef, tension: ArrayRef) -> tuple[Expr, Expr] | None:
    """x''; the part of the force across C^T q_0 is met by the cart alone, the part along it by the first mass as well."""
    if chain.horizontal is None:
        return None
    builder, parameters = chain.builder, chain.parameters
    (x, y), (free_x, free_y) = (chain.direction[0], chain.direction[1]), chain.horizontal
    ratio = parameters.mass[0] / parameters.base_mass
    value = _still_right_side(chain)
    if parameters.links > 1:
        value = value + cosine[1] * (tension[1] * parameters.mass_ratio[1])
    along = builder.let("pull_along", ratio * value)
    across = builder.let("push_across", ratio * (x * free_y - y * free_x))
    inverse = builder.let("inverse_cart_pivot", 1 / (1 + ratio * (x * x + y * y)))
    first = builder.let("cart_acceleration", (free_x + x * along - y * across) * inverse)
    second = builder.let("cart_acceleration", (free_y + y * along + x * across) * inverse)
    return first, second


def _first(chain: Chain, tension: ArrayRef, cart: tuple[Expr, Expr] | None, upright: tuple[Expr, Expr] | None) -> None:
    """l_0 omega_0' = q_0 x (g e_3 - C x'' + couples) - (lambda_1 / m_0) X_1.

    Args:
        cart: x'', None on a fixed base.
        upright: what stands for it about the vertical, None where it does itself.
    """
    parameters = chain.parameters
    inverse = 1 / parameters.length[0]
    here = load(chain.direction, 0)
    fall: Vector = tuple(entry * inverse for entry in parameters.fall)
    if cart is not None:
        fall = (-(cart[0] * inverse), -(cart[1] * inverse), fall[2])
    turned = cross(here, fall)
    if upright is not None:
        turned = (turned[0], turned[1], inverse * (here[1] * upright[0] - here[0] * upright[1]))
    if chain.pair is not None:
        own = sub(load(chain.pair, 0), load(chain.pair, 1))
        turned = add(turned, cross(here, scale(inverse / parameters.mass[0], own)))
    pull = tension[1] * (parameters.mass_ratio[1] * inverse)
    chain.rates.write(0, sub(turned, scale(pull, load(chain.crosses, 1))))


def _beyond(chain: Chain, tension: ArrayRef) -> None:
    parameters, builder = chain.parameters, chain.builder
    inverse_length = parameters.derived("inverse_length", lambda k: 1 / parameters.length[k])
    with builder.loop("k", 1, parameters.links) as loop:
        k = loop.index
        outer = builder.let("outer_pull", tension[k + 1] * (parameters.mass_ratio[k + 1] * inverse_length[k]))
        inner = builder.let("inner_pull", tension[k - 1] * inverse_length[k])
        rate = sub(scale(inner, load(chain.crosses, k)), scale(outer, load(chain.crosses, k + 1)))
        if chain.pair is not None:
            rate = add(rate, _couple_rate(chain, k))
        chain.rates.write(k, rate)


def _couple_rate(chain: Chain, k: Index) -> Vector:
    assert chain.pair is not None
    parameters = chain.parameters
    own = load(chain.pair, k)
    beyond = scale(1 / parameters.mass[k], sub(own, load(chain.pair, k + 1)))
    before = scale(1 / parameters.mass[k - 1], sub(own, load(chain.pair, k - 1)))
    return scale(1 / parameters.length[k], cross(load(chain.direction, k), add(beyond, before)))
