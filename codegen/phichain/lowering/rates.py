"""The fastest linear mode of the hanging chain, by which angles and rates are weighed against each other.

Small motions about hanging are those of T = 1/2 m_0 x'^2 + 1/2 sum_k (m_k (y_{k-1} + r_k phi_k)'^2 + J_k phi_k'^2) with y_k = y_{k-1} + l_k phi_k,
y_0 = x, and V = 1/2 sum_k g mu_k phi_k^2 + 1/2 sum_k k_k (phi_k - phi_{k-1})^2; their largest frequency bounds how fast a chain
swings without being driven. Rotors add 1/2 sum_k A_k (phi_k' - phi_{k-1}')^2 to T. The form V - omega^2 T is eliminated link by
link from the tip; as many pivots are negative as squared frequencies lie below omega^2 (Sylvester), and the wanted digits of the
largest follow by bisection. Where parameters come at run time

    omega^2 <~ 4 max_k (g outer_k + k_k / r_k) / (m_k r_k) (1 + sum_k (l_k - r_k) / (2 r_k))^2,   outer_k = sum_{a >= k} m_a

serves. For r = l it is Gershgorin's bound on the tridiagonal inverse of M, for masses that do not grow outwards; the last
factor is an estimate: with masses half-way zigzags of N links hardly move them, and frequencies grow by as much as N
(checked on uniform chains). Of rigid links r_k is the radius of gyration about the joint, sqrt(r_k^2 + J_k / m_k), and l_k stands for
l_k - r_k; a rotor adds A_k to its link's own m_k r_k^2 there. The largest of the terms is replaced by their 4-norm, which a Program can
compute.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache
from typing import Any, Final

from mpmath import mp, mpf

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.ir.nodes import Program
from phichain.ir.passes import prune
from phichain.lowering.chain.base import on_wall
from phichain.lowering.chain.parameters import Parameters
from phichain.mechanics import Model
from phichain.scene import Scene

#: A frequency is given in three significant digits: as 100 to 1000 units of the last.
_UNITS: Final = 100
#: What is added before it is rounded to the nearest unit, so that three digits hardly ever lie below the frequency.
_SLACK: Final = Fraction(1, 2000)
_GUARD_DIGITS: Final = 40
#: Slower than this, rad/s, is no mode at all, as without gravity and springs.
_LEAST: Final = Fraction(1, 10**300)


@lru_cache(maxsize=8)
def fastest_rate(scene: Scene) -> Fraction | None:
    """Largest linear frequency of the hanging chain, rad/s, to three digits; None where parameters come at run time."""
    scene = on_wall(scene)
    if scene.runtime:
        return None
    with mp.workdps(_GUARD_DIGITS + 2 * _decades(scene)):
        return _fastest(_chain(scene))


def weight_rate(scene: Scene) -> Fraction:
    """Rate, rad/s, that weight gives an angle of 1 rad while the fastest mode moves: the square of the fastest rate without springs over that with them.

    Without springs it is the fastest rate itself. Numeric parameters alone.
    """
    scene = on_wall(scene)
    with mp.workdps(_GUARD_DIGITS + 2 * _decades(scene)):
        chain = _chain(scene)
        fastest, hanging = _fastest(chain), _fastest(replace(chain, spring=[mpf(0)] * scene.links))
    return hanging * hanging / fastest if fastest else Fraction(0)


def _fastest(chain: _Chain) -> Fraction:
    """The largest frequency, to three digits."""
    if _is_below(chain, _LEAST):
        return Fraction(0)
    unit = _unit(chain)
    low, high = _UNITS - 1, 10 * _UNITS
    while high - low > 1:
        middle = (low + high) // 2
        if _is_below(chain, (middle + Fraction(1, 2)) * unit):
            high = middle
        else:
            low = middle
    return high * unit


@dataclass(frozen=True)
class _Chain:
    """What small motions need of a chain, as mpf: m_k (kg), r_k and l_k (m), J_k and A_k (kg m^2), k_k and g mu_k (N m), m_0 (kg or None)."""

    mass: list[Any]
    com: list[Any]
    length: list[Any]
    inertia: list[Any]
    spring: list[Any]
    rotor: list[Any]
    weight: list[Any]
    cart_mass: Any


def _chain(scene: Scene) -> _Chain:
    mass, length = ([mpf(x) for x in values] for values in (scene.mass, scene.length))
    com = length if scene.com is None else [mpf(x) for x in scene.com]
    spring, rotor = (
        [mpf(0)] * scene.links if law is None else [mpf(x) for x in law] for law in (scene.stiffness, scene.armature)
    )
    weight, outer = [], mpf(0)
    for m, r, l in zip(reversed(mass), reversed(com), reversed(length), strict=True):
        weight.append(mpf(scene.gravity) * (m * r + l * outer))
        outer += m
    cart_mass = mpf(scene.cart_mass) if scene.cart_mass is not None else None
    spin = [mpf(0)] * scene.links if scene.inertia is None else [mpf(x) for x in scene.inertia]
    return _Chain(mass, com, length, spin, spring, rotor, weight[::-1], cart_mass)


def _decades(scene: Scene) -> int:
    """Over how many powers of ten masses, lengths, inertias, rotors and springs spread, together."""
    arrays = (
        scene.mass, scene.cart_mass, scene.length, scene.com, scene.stiffness, scene.gravity, scene.inertia, scene.armature,
    )  # fmt: skip
    mass, cart_mass, length, com, stiffness, gravity, inertia, armature = (
        () if x is None else x if isinstance(x, tuple) else (x,) for x in arrays
    )
    lists = (mass + cart_mass, length + com, stiffness + gravity, inertia, armature)
    groups = [[abs(Fraction(x)) for x in group if x] for group in lists]
    return sum(len(str(int(max(group) / min(group)))) for group in groups if group)


def _unit(chain: _Chain) -> Fraction:
    """The power of ten of which the frequency with its slack holds at least 100 and less than 1000."""
    exponent = 0
    while not _is_below(chain, 10 * _UNITS * Fraction(10) ** exponent):
        exponent += 1
    while _is_below(chain, _UNITS * Fraction(10) ** exponent):
        exponent -= 1
    return Fraction(10) ** exponent


def _is_below(chain: _Chain, bound: Fraction) -> bool:
    """Whether the largest frequency, its slack added, is less than the bound, rad/s."""
    rate = bound / (1 + _SLACK)
    return _all_below(chain, (mpf(rate.numerator) / rate.denominator) ** 2)


def _all_below(chain: _Chain, square: Any) -> bool:
    """Whether every squared frequency lies below the given one: every pivot of V - omega^2 T is negative.

    What lies beyond a joint is the form 1/2 (a y^2 + 2 b y phi + c phi^2) in the place y of the joint and the angle of the link
    before it.
    """
    a = b = c = mpf(0)
    springs = [k - square * rotor for k, rotor in zip(chain.spring, chain.rotor, strict=True)]
    links = zip(chain.mass, chain.com, chain.length, chain.inertia, springs, chain.weight, strict=True)
    for m, r, l, spin, k, weight in reversed(list(links)):
        inertia = square * m
        pivot = weight + k - inertia * r * r - square * spin + (a * l + 2 * b) * l + c
        if pivot >= 0:
            return False
        slope = (a * l + b) - inertia * r
        a = a - inertia - slope * slope / pivot
        b, c = (k * slope / pivot, k - k * k / pivot) if k else (mpf(0), mpf(0))
    return chain.cart_mass is None or not square or bool(a < square * chain.cart_mass)


def reach(scene: Scene) -> Fraction | None:
    """Length of the chain, m; None where lengths come at run time."""
    return None if scene.length == "runtime" else sum(map(Fraction, scene.length), Fraction(0))


def scales_program(model: Model) -> Program:
    """The bound above, rad/s, the chain's length, m, and with springs the rate that weight gives, rad/s, from the runtime parameters."""
    scene = model.scene
    builder = Builder("flow_scales", "Fastest linear rate, and length of the chain.")
    parameters = Parameters(builder, model)
    scales = builder.output("scales", (2 if scene.stiffness is None else 3,))
    inertia = parameters.inertia

    def radius(k: Index) -> Expr:
        com = parameters.com[k]
        return com if inertia is None else builder.let("gyration", builder.sqrt(com * com + inertia[k] / parameters.mass[k]))

    def term(k: Index, com: Expr, stiffness: ArrayRef | None) -> Expr:
        mass = parameters.mass[k]
        outer = parameters.outer_mass[k] + mass
        pull = parameters.gravity * outer
        if parameters.armature is not None:
            held = pull * com if stiffness is None else pull * com + stiffness[k]
            return held / (mass * com * com + parameters.armature[k])
        if stiffness is not None:
            pull = pull + stiffness[k] / com
        return pull / (mass * com)

    def fourth_power(name: str, k: Index, com: Expr, stiffness: ArrayRef | None) -> Expr:
        square = builder.let(name, 4 * term(k, com, stiffness))
        square = square * square
        return square * square

    weighed = builder.lift(0)
    with builder.loop("k", 0, scene.links) as loop:
        total, length, slack = loop.carry("total", 0), loop.carry("length_before", 0), loop.carry("slack", 1)
        com = radius(loop.index)
        loop.follow(total, total + fourth_power("square", loop.index, com, parameters.stiffness))
        arm = parameters.length[loop.index]
        loop.follow(length, length + arm)
        over = arm if inertia is not None else arm - com
        loop.follow(slack, slack if scene.tip_masses else slack + Fraction(1, 2) * (over / com))
        if scene.stiffness is not None:
            weighed = loop.carry("weighed", 0)
            loop.follow(weighed, weighed + fourth_power("of_weight", loop.index, com, None))
    fastest = builder.sqrt(builder.sqrt(builder.sqrt(total)))
    scales[0] = slack * fastest
    scales[1] = length
    if scene.stiffness is not None:
        scales[2] = slack * (builder.sqrt(builder.sqrt(weighed)) / fastest)
    return prune(builder.finish())
