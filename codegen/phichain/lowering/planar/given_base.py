"""Derivatives of planar accelerations over a base that is given its acceleration: those of the chain on a wall, put where they belong.

A unit of the base's acceleration is a state X of joint 0, turned into its link's frame, that goes outwards as every other does
(`response`): alpha_k = -rho_k.X_k, X_{k+1} = T_{k+1} X_k. So a column of it costs one sweep outwards.
"""

from __future__ import annotations

from collections.abc import Callable

from phichain.ir.builder import ArrayRef, Builder, Expr
from phichain.lowering.chain.base import Carried, carried
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.planar.joints import from_absolute
from phichain.lowering.planar.response import Response, dot
from phichain.scene import Scene

Results = tuple[ArrayRef, ArrayRef, ArrayRef, ArrayRef]
"""a, dadq, dadv and dadu."""


def over_given_base(
    builder: Builder, scene: Scene, parameters: Parameters, state: tuple[ArrayRef, ArrayRef, ArrayRef], results: Results,
    on_wall: Callable[..., Response | None],
) -> None:  # fmt: skip
    """Write accelerations and derivatives.

    Args:
        builder: where the Program is recorded.
        scene: the chain.
        parameters: its numbers.
        state: q, v and u.
        results: where they go.
        on_wall: writes those of the chain on a wall, and returns how its joints answer.
    """
    (q, v, u), (a, dadq, dadv, dadu) = state, results
    base = carried(builder, scene, parameters, u)
    size, torques = base.scene.nv, base.scene.nu
    inner = [builder.array(name, size * size) for name in ("links_by_q", "links_by_v")]
    by_torque = builder.array("links_by_torque", size * torques) if torques else None
    base.write_cart(a)
    arrays = (*map(base.seen, (q, v)), base.u, base.seen(a), *inner, by_torque)
    response = on_wall(builder, base.scene, base.parameters, *arrays)
    assert response is not None
    for source, target in zip(inner, (dadq, dadv), strict=True):
        _placed(builder, source, (size, size), target.shifted(base.first * scene.nv + base.first), scene.nv)
    if by_torque is not None:
        _placed(builder, by_torque, (size, torques), dadu.shifted(base.first * scene.nu + scene.base_inputs), scene.nu)
    for column, axis in enumerate(scene.told_axes):
        _answer(builder, base, response, axis == 1, dadu.shifted(base.first * scene.nu + column, scene.nu))
    if base.first:
        _row_of_cart(builder, scene, results)


def _placed(builder: Builder, source: ArrayRef, shape: tuple[int, int], target: ArrayRef, width: int) -> None:
    """Copy a matrix into a larger one of that row length, from its first cell on."""
    rows, columns = shape
    with builder.loop("i", 0, rows) as outer, builder.loop("j", 0, columns) as inner:
        target[outer.index * width + inner.index] = source[outer.index * columns + inner.index]


def _answer(builder: Builder, base: Carried, response: Response, is_down: bool, column: ArrayRef) -> None:
    """What a unit of the base's acceleration does, down or sideways."""
    unit, (sine, cosine) = 1 / base.parameters.length[0], response.turn(0)
    x, y = (cosine, -sine) if is_down else (sine, cosine)
    state: tuple[Expr, Expr] = unit * x, unit * y
    alpha = builder.array("base_answer", base.scene.links)
    alpha[0] = -dot(response.rho(0), state)
    with builder.loop("k", 1, base.scene.links) as loop:
        before = loop.carry("answer_x", state[0]), loop.carry("answer_y", state[1])
        here = response.outwards(loop.index, before)
        alpha[loop.index] = -dot(response.rho(loop.index), here)
        loop.follow(before[0], here[0])
        loop.follow(before[1], here[1])
    from_absolute(builder, base.scene, alpha, column)


def _row_of_cart(builder: Builder, scene: Scene, results: Results) -> None:
    """x'' = u, and nothing that leans on x or x'."""
    _, dadq, dadv, dadu = results
    for target in (dadq, dadv):
        with builder.loop("i", 0, scene.nv) as loop:
            target[loop.index] = builder.lift(0)
        with builder.loop("i", 1, scene.nv) as loop:
            target[loop.index * scene.nv] = builder.lift(0)
    dadu[0] = builder.lift(1)
    with builder.loop("i", 1, scene.nu) as loop:
        dadu[loop.index] = builder.lift(0)
