"""How the tensions of a spatial chain answer small changes: the two fronts of their tridiagonal system, kept for every joint.

With L_k the tensions over the masses m_k, rho_k = m_k / m_{k-1} and c_k = q_{k-1}.q_k, row k of the system (`lowering.tensions`) reads

    -c_k L_{k-1} + (rho_k + 1) L_k - rho_{k+1} c_{k+1} L_{k+1} = b_k.

Its inverse G is made of products: G_kk = 1 / (t_k + Y_k) of the slacks that both fronts leave, and

    G_{i+1,j} = outer_{i+1} G_ij  (i >= j),   outer_k = c_k / (rho_k + Y_k),      G_{i-1,j} = inner_{i-1} G_ij  (i <= j),   inner_k = rho_{k+1} c_{k+1} / (1 + t_k)

so that nothing cancels. A change of the cosine of joint k is a load L_{k-1} on row k and rho_k L_k on row k - 1: row k then answers
`past` and row k - 1 `short` of it, rows beyond by products. Off the unit spheres the sweep, whose pivots come from |q_{k-1} x q_k|^2,
solves another system: (|q_{k-1}|^2 |q_k|^2 - 1) rho_k / (1 + t_{k-1}) more on the diagonal of row k where the base's front passes, and
over 1 + Y_k / rho_k on that of row k - 1 where the tip's does. `past_size` and `short_size` are what rows k and k - 1 answer to that;
pivots of cosines alone are this system's own, off the spheres too, and nothing is added.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.tensions import Joints


@dataclass(frozen=True)
class Answers:
    """What the tensions answer.

    Attributes:
        tension: L_k, N + 1 cells, zero beyond the tip.
        diagonal: G_kk.
        inner: what L_k makes of a change of L_{k+1}; cell k + 1 holds inner_k, and cell 0 what stands before the chain.
        outer: what L_k makes of a change of L_{k-1}, from 1 to N, zero at the ends.
        past, short, past_size, short_size: see above, for joints 0 to N, zero at N.
    """

    tension: ArrayRef
    diagonal: ArrayRef
    inner: ArrayRef
    outer: ArrayRef
    past: ArrayRef
    short: ArrayRef
    past_size: ArrayRef
    short_size: ArrayRef
    past_load: ArrayRef
    short_load: ArrayRef


def answers(builder: Builder, parameters: Parameters, joints: Joints, is_on_cart: bool) -> Answers:
    """Both fronts all the way, the tensions, and what they answer."""
    links, one, nothing = parameters.links, builder.lift(1), builder.lift(0)
    names = ("inner", "outer", "answer_past", "answer_short")
    inner, outer, past, short = (builder.array(name, links + 1) for name in names)
    tension, diagonal = builder.array("tension", links + 1), builder.array("compliance", links)
    slack, carried = builder.array("slack", links), builder.array("carried_load", links)
    base_inverse, tip_inverse = builder.array("base_inverse", links), builder.array("tip_inverse", links)
    rho, cosine, squared = parameters.mass_ratio, joints.cosine, joints.sine_squared

    def parted(k: Index, free: Expr, lever: Expr, inverse: Expr) -> Expr:
        """What joint k leaves of a slack: (s^2 + z) / (1 + z)."""
        return 1 - cosine[k] * lever if squared is None else (squared[k] + free) * inverse

    with builder.loop("k", 0, links - 1) as loop:
        k = loop.index
        free, load = loop.carry("base_slack", joints.base_slack), loop.carry("load", joints.right_side[0])
        inverse = builder.let("base_inverse_pivot", 1 / (1 + free))
        lever = builder.let("lever", cosine[k + 1] * inverse)
        slack[k], carried[k], base_inverse[k], inner[k + 1] = free, load * inverse, inverse, rho[k + 1] * lever
        loop.follow(free, rho[k + 1] * parted(k + 1, free, lever, inverse))
        loop.follow(load, joints.right_side[k + 1] + lever * load)
    slack[links - 1], last = free, builder.let("tip_compliance", 1 / (1 + free))
    diagonal[links - 1], tension[links - 1], tension[links] = last, load * last, nothing
    ratio = parameters.inverse_mass_ratio
    with builder.loop("k", links - 1, 0, -1) as loop:
        k = loop.index
        free = loop.carry("tip_slack", one)
        beyond = builder.let("scaled_slack", ratio[k] * free)
        inverse = builder.let("tip_inverse_pivot", 1 / (1 + beyond))
        lever = builder.let("tip_lever", cosine[k] * inverse)
        tip_inverse[k], outer[k] = inverse, ratio[k] * lever
        following = builder.let("tip_slack_next", parted(k, beyond, lever, inverse))
        diagonal[k - 1] = 1 / (slack[k - 1] + following)
        tension[k - 1] = carried[k - 1] + inner[k] * tension[k]
        loop.follow(free, following)

    outer[links] = past[links] = short[links] = nothing
    inner[0], past[0] = builder.lift(int(is_on_cart)), diagonal[0]
    short[0] = diagonal[0] if is_on_cart else nothing
    with builder.loop("k", 1, links) as loop:
        k = loop.index
        own, before = diagonal[k] * tension[k - 1], diagonal[k - 1] * (rho[k] * tension[k])
        past[k], short[k] = own + outer[k] * before, before + inner[k] * own
    fronts = tension, diagonal, inner, outer, past, short
    if squared is None:
        none = builder.constants("no_size", [Fraction(0)] * (links + 1))
        return Answers(*fronts, none, none, none, none)
    return Answers(*fronts, *_of_sizes(builder, parameters, joints.meeting, fronts, (base_inverse, tip_inverse)))


def _of_sizes(
    builder: Builder, parameters: Parameters, meeting: int, fronts: tuple[ArrayRef, ...], inverses: tuple[ArrayRef, ArrayRef]
) -> tuple[ArrayRef, ArrayRef, ArrayRef, ArrayRef]:
    """`past_size`, `short_size` and the loads that they answer."""
    links, rho, nothing = parameters.links, parameters.mass_ratio, builder.lift(0)
    tension, diagonal, inner, outer = fronts[:4]
    base_inverse, tip_inverse = inverses
    names = ("size_past", "size_short", "past_load", "short_load")
    past_size, short_size, past_load, short_load = made = tuple(builder.array(name, links + 1) for name in names)
    for array in made:
        array[0] = array[links] = nothing
    with builder.loop("k", 1, meeting + 1) as loop:
        k = loop.index
        load = -2 * (rho[k] * (base_inverse[k - 1] * tension[k]))
        past_load[k], short_load[k] = load, nothing
        answer = builder.let("size_answer", diagonal[k] * load)
        past_size[k], short_size[k] = answer, inner[k] * answer
    with builder.loop("k", meeting + 1, links) as loop:
        k = loop.index
        load = -2 * (tip_inverse[k] * tension[k - 1])
        past_load[k], short_load[k] = nothing, load
        answer = builder.let("size_answer", diagonal[k - 1] * load)
        past_size[k], short_size[k] = outer[k] * answer, answer
    return past_size, short_size, past_load, short_load
