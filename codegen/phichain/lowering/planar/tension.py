"""Planar forward dynamics with every mass at its link's end (r = l), theory section 5: tensions, in joint angles alone.

One sine-cosine pair a joint, no cumulative angle. A couple tau_phi,k on link k enters as a pair of forces
M_k = tau_phi,k / l_k across the link; with lambda the tensions, f the horizontal force left for the cart,

    b_k = l_k w_k^2 + M_{k+1} s_{k+1} / m_k - M_{k-1} s_k / m_{k-1},   b_0 gains g c_0 - s_0 f / m_c
    l_k phi_k'' = M_k (1/m_k + 1/m_{k-1}) + (lambda_{k+1} s_{k+1} - M_{k+1} c_{k+1}) / m_k
                  - (lambda_{k-1} s_k + M_{k-1} c_k) / m_{k-1}
    (m_c + m_0 s_0^2) x'' = f + s_0 (m_0 (b_0 + s_0 f / m_c) + c_1 lambda_1),   f = u - M_0 c_0
    l_0 phi_0'' gains -g s_0 - c_0 x''

The cart's equation is m_c x'' = f + lambda_0 s_0 with lambda_0 put in: on a light cart the two forces all but cancel. Couples
on a light link push it against a heavy one beyond in the same way, so `suits` keeps chains out that bear one.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import accumulate
from math import inf

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.lowering.chain.losses import cart_drag, ties_links
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.planar.joints import PlanarState, couples, from_absolute
from phichain.lowering.tensions import Joints, middle, solve_tensions, write_tensions
from phichain.scene import Scene

#: A couple is a pair of forces across its link. What of them pushes a light mass along a heavy link beyond it is taken up there, and costs as
#: many digits as that is heavier: measured over four decades of masses and lengths, 2e-15 are left up to this, 6e-14 not far beyond.
_LARGEST_RISE = 8


@dataclass(frozen=True)
class _Chain:
    """What both halves of the computation share; `horizontal` is f / m_c."""

    builder: Builder
    parameters: Parameters
    sine: ArrayRef
    cosine: ArrayRef
    pair: ArrayRef | None
    horizontal: Expr | None


def suits(scene: Scene) -> bool:
    """Whether tensions give all digits: every mass at its link's end and, with couples on links, none much heavier than one before it.

    Rotors' couples depend on the accelerations that tensions are to give.
    """
    if scene.armature is not None:
        return False
    has_couples = scene.actuated_joints or ties_links(scene)
    return scene.tip_masses and not (has_couples and _rise(scene) > _LARGEST_RISE)


def _rise(scene: Scene) -> float:
    """By how much a mass outweighs the lightest of those between it and the base, the cart's included, at most."""
    if isinstance(scene.mass, str) or isinstance(scene.cart_mass, str):
        return inf
    masses = [*([] if scene.cart_mass is None else [scene.cart_mass]), *scene.mass]
    return max(mass / lightest for mass, lightest in zip(masses, accumulate(masses, min), strict=True))


def accelerations(
    builder: Builder, scene: Scene, parameters: Parameters, state: PlanarState, u: ArrayRef | None, a: ArrayRef
) -> None:
    """Write the accelerations [x'', theta''] into `a`."""
    chain = _chain(builder, scene, parameters, state, u)
    tension = solve_tensions(builder, parameters, _joints(chain, state))
    cart = None
    if chain.horizontal is not None:
        cart = _cart(chain, state, chain.horizontal, tension)
        a[0] = cart * parameters.units.length
    alpha = builder.array("acceleration", scene.links)
    length = parameters.length
    alpha[0] = _first(chain, tension, cart) / length[0]
    inverse_length = parameters.derived("inverse_length", lambda k: 1 / length[k])
    with builder.loop("k", 1, scene.links) as loop:
        alpha[loop.index] = _beyond(chain, tension, loop.index) * inverse_length[loop.index]
    from_absolute(builder, scene, alpha, a.shifted(int(scene.has_cart)))


def tensions(
    builder: Builder, scene: Scene, parameters: Parameters, state: PlanarState, u: ArrayRef | None, out: ArrayRef
) -> None:
    """Write the links' tensions, N, into `out`: couples, as pairs of forces across their links, have no part along them."""
    scaled = solve_tensions(builder, parameters, _joints(_chain(builder, scene, parameters, state, u), state))
    write_tensions(builder, parameters, scaled, out)


def _chain(
    builder: Builder, scene: Scene, parameters: Parameters, state: PlanarState, u: ArrayRef | None
) -> _Chain:
    sine, cosine = builder.sincos(state.angle, scene.links, padding=1)
    sine[scene.links], cosine[scene.links] = builder.lift(0), builder.lift(0)
    couple = couples(builder, scene, parameters, state, u)
    pair = None
    if couple is not None:
        pair = builder.array("force_pair", scene.links + 1)
        inverse_length = parameters.derived("inverse_length", lambda k: 1 / parameters.length[k])
        with builder.loop("k", 0, scene.links) as loop:
            pair[loop.index] = couple[loop.index] * inverse_length[loop.index]
        pair[scene.links] = builder.lift(0)
    horizontal = None
    if scene.has_cart:
        horizontal = builder.lift(0)
        if u is not None and scene.has_force:
            horizontal = u[0] * (1 / (parameters.base_mass * parameters.units.force))
        if state.speed is not None:
            horizontal = horizontal - cart_drag(scene, parameters, state.speed) / parameters.base_mass
        if pair is not None:
            horizontal = horizontal - pair[0] * cosine[0] / parameters.base_mass
    return _Chain(builder, parameters, sine, cosine, pair, horizontal)


def _joints(chain: _Chain, state: PlanarState) -> Joints:
    builder, parameters, sine = chain.builder, chain.parameters, chain.sine
    links = parameters.links
    right_side = builder.array("right_side", links)
    right_side[0] = _first_right_side(chain, state)
    with builder.loop("k", 1, links) as loop:
        k = loop.index
        right_side[k] = _right_side(chain, state, k)
    squared = builder.array("sine_squared", links)
    with builder.loop("k", 1, links) as loop:
        squared[loop.index] = sine[loop.index] * sine[loop.index]
    base_slack = builder.lift(0)
    if chain.horizontal is not None:
        base_slack = parameters.mass[0] / parameters.base_mass * (sine[0] * sine[0])
    return Joints(chain.cosine, squared, base_slack, right_side, middle(parameters.links))


def _right_side(chain: _Chain, state: PlanarState, k: Index) -> Expr:
    parameters, pair = chain.parameters, chain.pair
    value = parameters.length[k] * (state.rate[k] * state.rate[k])
    if pair is None:
        return value
    value = value + pair[k + 1] * chain.sine[k + 1] / parameters.mass[k]
    return value - pair[k - 1] * chain.sine[k] / parameters.mass[k - 1]


def _first_right_side(chain: _Chain, state: PlanarState) -> Expr:
    value = _still_right_side(chain, state)
    return value if chain.horizontal is None else value - chain.sine[0] * chain.horizontal


def _still_right_side(chain: _Chain, state: PlanarState) -> Expr:
    """b_0 over a base that stands still, or is given its acceleration."""
    parameters = chain.parameters
    value = parameters.length[0] * (state.rate[0] * state.rate[0]) + parameters.fall[1] * chain.cosine[0]
    value = value + parameters.fall[0] * chain.sine[0]
    if chain.pair is not None:
        value = value + chain.pair[1] * chain.sine[1] / parameters.mass[0]
    return value


def _cart(chain: _Chain, state: PlanarState, horizontal: Expr, tension: ArrayRef) -> Expr:
    """x''."""
    parameters, sine = chain.parameters, chain.sine[0]
    beyond = tension[1] * parameters.mass_ratio[1] * chain.cosine[1]
    ratio = parameters.mass[0] / parameters.base_mass
    pull = ratio * sine * (_still_right_side(chain, state) + beyond)
    return chain.builder.let("cart_acceleration", (horizontal + pull) / (1 + ratio * (sine * sine)))


def _first(chain: _Chain, tension: ArrayRef, cart: Expr | None) -> Expr:
    """l_0 phi_0''."""
    parameters, sine, cosine, pair = chain.parameters, chain.sine, chain.cosine, chain.pair
    value = tension[1] * parameters.mass_ratio[1] * sine[1] - parameters.fall[1] * sine[0]
    value = value + parameters.fall[0] * cosine[0]
    if pair is not None:
        value = value + (pair[0] - pair[1] * cosine[1]) / parameters.mass[0]
    return value if cart is None else value - cosine[0] * cart


def _beyond(chain: _Chain, tension: ArrayRef, k: Index) -> Expr:
    """l_k phi_k'' for k >= 1."""
    parameters, sine, cosine, pair = chain.parameters, chain.sine, chain.cosine, chain.pair
    pull = tension[k + 1] * parameters.mass_ratio[k + 1] * sine[k + 1] - tension[k - 1] * sine[k]
    if pair is None:
        return pull
    own = (pair[k] - pair[k + 1] * cosine[k + 1]) / parameters.mass[k]
    return pull + own + (pair[k] - pair[k - 1] * cosine[k]) / parameters.mass[k - 1]
