"""How the tensions of a spatial chain answer small changes: the two fronts of their tridiagonal system, kept for every joint.

With L_k the tensions over the masses m_k, rho_k = m_k / m_{k-1} and c_k = q_{k-1}.q_k, row k of the system (`lowering.tensions`) reads

    -c_k L_{k-1} + (rho_k + 1) L_k - rho_{k+1} c_{k+1} L_{k+1} = b_k.

Its inverse G is made of products: G_kk = 1 / (t_k + Y_k) of the slacks that both fronts leave, and

    G_{i+1,j} = outer_{i+1} G_ij  (i >= j),   outer_k = c_k / (rho_k + Y_k),      G_{i-1,j} = inner_{i-1} G_ij  (i <= j),   inner_k = rho_{k+1} c_{k+1} / (1 + t_k)

so that nothing cancels. A change of the cosine of joint k is a load L_{k-1} on row k and rho_k L_k on row k - 1: row k then answers
`past` and row k - 1 `short` of it, rows beyond by products. Off the unit spheres the sweep, whose pivots come from |q_{k-1} x q_k|^2,
solves another system: (|q_{k-1}|^2 |q_k|^2 - 1) rho_k / (1 + t_{k-1}) more on the diagonal of row k where the base's front passes, and
over 1 + Y_k / rho_k on that of row k - 1 where the tip's does. `past_size` and `short_size` are what rows k and k - 1 answer to that.
"""

from __future__ import annotations

from dataclasses import dataclass

from phichain.ir.builder import ArrayRef, Builder
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
    names = ("inner", "outer", "answer_past", "answer_short", "size_past", "size_short")
    inner, outer, past, short, past_size, short_size = (builder.array(name, links + 1) for name in names)
    past_load, short_load = (builder.array(name, links + 1) for name in ("past_load", "short_load"))
    tension, diagonal = builder.array("tension", links + 1), builder.array("compliance", links)
    slack, carried = builder.array("slack", links), builder.array("carried_load", links)
    base_inverse, tip_inverse = builder.array("base_inverse", links), builder.array("tip_inverse", links)
    rho, cosine, squared = parameters.mass_ratio, joints.cosine, joints.sine_squared

    with builder.loop("k", 0, links - 1) as loop:
        k = loop.index
        free, load = loop.carry("base_slack", joints.base_slack), loop.carry("load", joints.right_side[0])
        inverse = builder.let("base_inverse_pivot", 1 / (1 + free))
        lever = builder.let("lever", cosine[k + 1] * inverse)
        slack[k], carried[k], base_inverse[k], inner[k + 1] = free, load * inverse, inverse, rho[k + 1] * lever
        loop.follow(free, rho[k + 1] * ((squared[k + 1] + free) * inverse))
        loop.follow(load, joints.right_side[k + 1] + lever * load)
    slack[links - 1], last = free, builder.let("tip_compliance", 1 / (1 + free))
    diagonal[links - 1], tension[links - 1], tension[links] = last, load * last, nothing
    ratio = parameters.inverse_mass_ratio
    with builder.loop("k", links - 1, 0, -1) as loop:
        k = loop.index
        free = loop.carry("tip_slack", one)
        beyond = builder.let("scaled_slack", ratio[k] * free)
        inverse = builder.let("tip_inverse_pivot", 1 / (1 + beyond))
        tip_inverse[k], outer[k] = inverse, ratio[k] * (cosine[k] * inverse)
        following = builder.let("tip_slack_next", (squared[k] + beyond) * inverse)
        diagonal[k - 1] = 1 / (slack[k - 1] + following)
        tension[k - 1] = carried[k - 1] + inner[k] * tension[k]
        loop.follow(free, following)

    outer[links] = past[links] = short[links] = past_size[links] = short_size[links] = nothing
    inner[0], past[0] = builder.lift(int(is_on_cart)), diagonal[0]
    short[0] = diagonal[0] if is_on_cart else nothing
    past_size[0] = short_size[0] = nothing
    past_load[0] = past_load[links] = short_load[0] = short_load[links] = nothing
    with builder.loop("k", 1, links) as loop:
        k = loop.index
        own, before = diagonal[k] * tension[k - 1], diagonal[k - 1] * (rho[k] * tension[k])
        past[k], short[k] = own + outer[k] * before, before + inner[k] * own
    with builder.loop("k", 1, joints.meeting + 1) as loop:
        k = loop.index
        load = -2 * (rho[k] * (base_inverse[k - 1] * tension[k]))
        past_load[k], short_load[k] = load, nothing
        answer = builder.let("size_answer", diagonal[k] * load)
        past_size[k], short_size[k] = answer, inner[k] * answer
    with builder.loop("k", joints.meeting + 1, links) as loop:
        k = loop.index
        load = -2 * (tip_inverse[k] * tension[k - 1])
        past_load[k], short_load[k] = nothing, load
        answer = builder.let("size_answer", diagonal[k - 1] * load)
        past_size[k], short_size[k] = outer[k] * answer, answer
    return Answers(tension, diagonal, inner, outer, past, short, past_size, short_size, past_load, short_load)


