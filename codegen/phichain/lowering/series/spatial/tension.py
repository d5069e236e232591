"""Taylor recurrences of spatial chains with every mass at its link's end: the tensions of every order from one tridiagonal matrix.

With sigma_k the tension of link k over m_k, rho_k = m_k / m_{k-1} (m_{-1} the cart's mass), Y_k the known part of (sigma_k q_k)_n
less the link's couple n_k / (m_k l_k), and q, c, s those of the step's start, the coefficients of order n obey

    D_k = rho_{k+1} Y_{k+1} - Y_k,   B_k = D_k - D_{k-1} (B_0 = D_0 + g e_3 - C x'')     accelerations but for the unknown tensions
    -c_k sigma_{k-1} + (1 + rho_k) sigma_k - rho_{k+1} c_{k+1} sigma_{k+1} = r_k = q_k.B_k - l_k q_k.q_k''
    l_k q_k'' = B_k - r_k q_k + sigma_{k+1} rho_{k+1} P_k q_{k+1} + sigma_{k-1} P_k q_{k-1},   P_k = I - q_k q_k^T

q_k.q_k'' is known from the squares, so the own tension is out of q_k''. The matrix is factored from both ends towards the middle as
in `lowering.tensions`, pivots 1 + t_k and rho_k + Y_k with t, Y > 0 from s_k^2 = |q_{k-1} x q_k|^2; P_k q_{k+1} and P_k q_{k-1} are
cross products. On a cart, h = C^T q_0, h* = h turned by a right angle, K = f + rho_0 C^T Y_0 and b = q_0.(D_0 + g e_3) - l_0 q_0.q_0''

    (1 + rho_0 |h|^2) x'' = K + rho_0 h* (h*.K) + rho_0 h (b + rho_1 c_1 sigma_1)

where the pull of a light cart along h is out.
"""

from __future__ import annotations

from dataclasses import dataclass

from phichain.ir.builder import ArrayRef, Expr, Index
from phichain.lowering.algebra.vector import Vector, add, dot, load, scale, store, sub
from phichain.lowering.chain.body import point_masses
from phichain.lowering.series.series import Series
from phichain.lowering.series.spatial.made import spatial_series
from phichain.lowering.series.spatial.ordering import Ordering
from phichain.lowering.series.spatial.tension_factor import (
    INVERSE_LENGTH,
    LENGTH,
    PAIR_UNIT,
    RATIO,
    factor,
    layout,
    middle_link,
)
from phichain.mechanics import Model


def tension_series(model: Model) -> Series:
    """The recurrences of a spatial scene with tip masses."""
    scene = point_masses(model.scene)
    return spatial_series(model, scene, layout(scene), factor, _order)


@dataclass(frozen=True)
class _Known:
    """What one order knows: D_k - D_{k-1} and the right sides from link 1 on, and of link 0 what the cart leaves alone.

    Attributes:
        falling: D_0 + g e_3.
        pull: q_0.(D_0 + g e_3) - l_0 q_0.q_0''.
        free: K of a cart.
    """

    apart: ArrayRef
    load: ArrayRef
    falling: Vector
    pull: Expr
    free: tuple[Expr, Expr] | None


def _order(order: Ordering) -> None:
    """Right sides, tensions, accelerations."""
    known = _known(order)
    tension = _tensions(order, known.load)
    falling, load_first = known.falling, known.pull
    if known.free is not None:
        x, y = _cart(order, known.free, known.pull, tension)
        order.write_cart((x, y))
        falling = (falling[0] - x, falling[1] - y, falling[2])
        load_first = known.pull - (order.kept("direction")[0] * x + order.kept("direction")[1] * y)
    _accelerate(order, 0, falling, load_first, tension)
    with order.builder.loop("k", 1, order.scene.links) as loop:
        _accelerate(order, loop.index, load(known.apart, loop.index), known.load[loop.index], tension)


def _known(order: Ordering) -> _Known:
    builder, links = order.builder, order.scene.links
    ratio = order.kept(RATIO).shifted(-1) if RATIO in order.layout else order.parameters.mass_ratio
    known, direction, length = _sums(order), order.kept("direction"), order.number(LENGTH)
    still, apart, loads = (
        builder.array(*pair) for pair in (("still", 3 * links), ("apart", 3 * links), ("load", links))
    )
    with builder.loop("k", 0, links - 1) as loop:
        k = loop.index
        store(still, k, sub(scale(ratio[k + 1], load(known, k + 1)), load(known, k)))
    store(still, links - 1, tuple(-entry for entry in load(known, links - 1)))
    with builder.loop("k", 1, links) as loop:
        k = loop.index
        store(apart, k, value := sub(load(still, k), load(still, k - 1)))
        loads[k] = dot(load(direction, k), value) - length[k] * order.along(k)
    x, y, z = load(still, 0)
    *aside, weight = (order.first * order.kept("gravity")[i] for i in range(3 if order.scene.base_accelerations else 1))
    falling = (*(a + b for a, b in zip((x, y), aside, strict=True)), z + weight) if aside else (x, y, z + weight)
    pull = builder.let("pull", dot(load(direction, 0), falling) - length[0] * order.along(0))
    if not order.scene.has_free_cart:
        order.write_driven()
        loads[0] = pull
        return _Known(apart, loads, falling, pull, None)
    free = [order.kept("cart_ratio")[0] * known[i] for i in range(2)]
    if "push" in order.layout:
        free = [value + order.first * order.kept("push")[i] for i, value in enumerate(free)]
    if "cart_damping" in order.layout:
        free = [value - order.kept("cart_damping")[0] * order.cart_rate(i) for i, value in enumerate(free)]
    if (dry := order.cart_friction()) is not None:
        free = [value - entry for value, entry in zip(free, dry, strict=False)]
    first, second = builder.let("free_cart_x", free[0]), builder.let("free_cart_y", free[1])
    loads[0] = pull - (direction[0] * first + direction[1] * second)
    return _Known(apart, loads, falling, pull, (first, second))


def _sums(order: Ordering) -> ArrayRef:
    """Y_k: the sums, less the couples' force pairs."""
    if order.couple is None:
        return order.sums
    builder, links, unit = order.builder, order.scene.links, order.number(PAIR_UNIT)
    known = builder.array("known", 3 * links)
    with builder.loop("k", 0, links) as loop:
        k = loop.index
        store(known, k, sub(load(order.sums, k), scale(unit[k], load(order.couple, k))))
    return known


def _tensions(order: Ordering, loads: ArrayRef) -> ArrayRef:
    """sigma_k, N + 1 cells, zero beyond the tip: towards the middle from both ends, and back."""
    builder, links = order.builder, order.scene.links
    passed, particular, coupling = map(order.kept, ("passed", "particular", "coupling"))
    middle, paired = middle_link(links)
    gathered, tension = builder.array("gathered", links), builder.array("tension", links + 1)
    base = tip = builder.lift(0)

    def gather(k: Index, incoming: Expr) -> Expr:
        total = builder.let("gathered_load", loads[k] + incoming)
        gathered[k] = particular[k] * total
        return passed[k] * total

    def outwards(k: Index, neighbour: Expr) -> Expr:
        tension[k] = value = builder.let("tension_next", gathered[k] + coupling[k] * neighbour)
        return value

    if paired:
        with builder.loop("i", 0, paired) as loop:
            base, tip = loop.carry("from_base", 0), loop.carry("from_tip", 0)
            loop.follow(base, gather(loop.index, base))
            loop.follow(tip, gather(links - 1 - loop.index, tip))
    if middle > paired:
        base = gather(middle - 1, base)
    tension[middle] = met = builder.let("middle_tension", particular[middle] * (loads[middle] + base + tip))
    inner = met
    if paired:
        with builder.loop("i", 0, paired) as loop:
            inner, outer = loop.carry("inner_tension", met), loop.carry("outer_tension", met)
            loop.follow(inner, outwards(middle - 1 - loop.index, inner))
            loop.follow(outer, outwards(middle + 1 + loop.index, outer))
    if middle > paired:
        outwards(0, inner)
    tension[links] = builder.lift(0)
    return tension


def _cart(order: Ordering, free: tuple[Expr, Expr], pull: Expr, tension: ArrayRef) -> tuple[Expr, Expr]:
    """x''."""
    builder, entries, (x, y) = order.builder, order.kept("cart"), free
    if order.scene.links > 1:
        pull = builder.let("pull_beyond", pull + entries[5] * tension[1])
    first = builder.let("cart_x", (entries[0] * x + entries[1] * y) + entries[3] * pull)
    return first, builder.let("cart_y", (entries[1] * x + entries[2] * y) + entries[4] * pull)


def _accelerate(order: Ordering, k: Index, bare: Vector, along: Expr, tension: ArrayRef) -> None:
    """q_k'' from B_k, r_k and the neighbours' tensions."""
    value = sub(bare, scale(along, load(order.kept("direction"), k)))
    value = add(value, scale(tension[k + 1], load(order.kept("outer"), k)))
    if k != 0:
        value = add(value, scale(tension[k - 1], load(order.kept("inner"), k)))
    order.write(k, value, order.number(INVERSE_LENGTH)[k], tension[k])
