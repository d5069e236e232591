r"""One Runge-Kutta step of order 4 in the plane with its exact discrete Jacobian, for controllers and estimators.

With the state x = (q, v), f = (v, a), stages x_s = x + w_s h f_{s-1} (w = 0, 1/2, 1/2, 1) and z any of q, v, u, the chain rule gives
for alpha_s = d a_s / d z, by d q_s / d z = E_q + w_s h (E_v + w_{s-1} h alpha_{s-2}) and d v_s / d z = E_v + w_s h alpha_{s-1},

    alpha_s = (dadq E_q + (dadv + w_s h dadq) E_v + dadu E_u) + w_s w_{s-1} h^2 dadq alpha_{s-2} + w_s h dadv alpha_{s-1},
    d q_next / d z = E_q + h E_v + h^2/6 (alpha_1 + alpha_2 + alpha_3),
    d v_next / d z = E_v + h/6 (alpha_1 + 2 alpha_2 + 2 alpha_3 + alpha_4)

with E_z = d z / d z and the derivatives of a at stage s: no difference, no error of order in h between A, B and the step itself.
"""

from __future__ import annotations

from collections.abc import Callable

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.ir.nodes import Program
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.writers import writes
from phichain.scene import Scene

_WEIGHTS = (0.0, 0.5, 0.5, 1.0)


@writes("step_jacobian", space="planar", calls=("dynamics_and_jacobian",))
def step_jacobian(
    builder: Builder, scene: Scene, parameters: Parameters, dynamics: Program, **arguments: ArrayRef
) -> None:
    """Write the state after one step of size h, and its derivatives by the state before and by the held input."""
    size, h = scene.nv, arguments["h"][0]
    q, v = arguments["q"], arguments["v"]
    accelerations: list[ArrayRef] = []
    by_start: list[ArrayRef] = []
    at_q, at_v = q, v
    for stage, weight in enumerate(_WEIGHTS, 1):
        if stage > 1:
            at_q, at_v = _moved(builder, (q, v), h, stage, accelerations)
        a, dadq, dadv, *dadu = builder.call(
            dynamics, [at_q, at_v, *([arguments["u"]] if scene.nu else [])],
            {
                f"acceleration_{stage}": size, f"by_q_{stage}": size * size, f"by_v_{stage}": size * size,
                **({f"by_u_{stage}": size * scene.nu} if scene.nu else {}),
            },
        )  # fmt: skip
        accelerations.append(a)
        by_start.append(_stage(builder, scene, (dadq, dadv, *dadu), h * weight, h * _WEIGHTS[stage - 2], by_start))
    sixth, area = builder.let("sixth", h / 6), builder.let("area", h * h / 6)
    with builder.loop("i", 0, size) as loop:
        i = loop.index
        a1, a2, a3, a4 = (a[i] for a in accelerations)
        arguments["q_next"][i] = q[i] + h * v[i] + area * (a1 + a2 + a3)
        arguments["v_next"][i] = v[i] + sixth * ((a1 + a4) + 2 * (a2 + a3))
    _results(builder, scene, by_start, (h, sixth, area), arguments["A"], arguments.get("B"))


def _moved(
    builder: Builder, start: tuple[ArrayRef, ArrayRef], h: Expr, stage: int, accelerations: list[ArrayRef]
) -> tuple[ArrayRef, ArrayRef]:
    """The state at a stage, from the accelerations of the two before."""
    q, v = start
    by, before = h * _WEIGHTS[stage - 1], h * _WEIGHTS[stage - 2]
    moved = builder.array(f"q_stage_{stage}", q.size), builder.array(f"v_stage_{stage}", v.size)
    with builder.loop("i", 0, v.size) as loop:
        i = loop.index
        rate = v[i] if stage == 2 else v[i] + before * accelerations[-2][i]
        moved[0][i] = q[i] + by * rate
        moved[1][i] = v[i] + by * accelerations[-1][i]
    return moved


def _stage(
    builder: Builder, scene: Scene, partial: tuple[ArrayRef, ...], by: Expr, before: Expr, known: list[ArrayRef]
) -> ArrayRef:
    """alpha_s: rows of accelerations, columns of q, v and u side by side."""
    size, width = scene.nv, 2 * scene.nv + scene.nu
    made = builder.array(f"by_start_{len(known) + 1}", size * width)
    own: list[tuple[int, int, Callable[[Index, Index], Expr]]] = [
        (0, size, lambda i, c: partial[0][i * size + c]),
        (size, size, lambda i, c: partial[1][i * size + c] + by * partial[0][i * size + c] if known else partial[1][i * size + c]),
    ]  # fmt: skip
    if scene.nu:
        own.append((2 * size, scene.nu, lambda i, c: partial[2][i * scene.nu + c]))
    for first, count, entry in own:
        with builder.loop("i", 0, size) as rows, builder.loop("c", 0, count) as columns:
            i, c = rows.index, columns.index
            total = entry(i, c)
            if known:
                total = _with_stages(builder, scene, (i, c, first), (partial[0], partial[1]), (by, before), known, total)
            made[i * width + (c + first)] = total
    return made


def _with_stages(
    builder: Builder, scene: Scene, place: tuple[Index, Index, int], partial: tuple[ArrayRef, ArrayRef], weights: tuple[Expr, Expr],
    known: list[ArrayRef], total: Expr,
) -> Expr:  # fmt: skip
    """What the stages before add to one entry."""
    (i, c, first), (by, before), size = place, weights, scene.nv
    width = 2 * size + scene.nu
    with builder.loop("j", 0, size) as loop:
        j = loop.index
        sum_ = loop.carry("sum", builder.lift(0))
        term = partial[1][i * size + j] * known[-1][j * width + (c + first)]
        if len(known) > 1:
            term = term + before * (partial[0][i * size + j] * known[-2][j * width + (c + first)])
        loop.follow(sum_, sum_ + term)
    return total + by * sum_


def _results(
    builder: Builder, scene: Scene, alpha: list[ArrayRef], steps: tuple[Expr, Expr, Expr], a: ArrayRef, b: ArrayRef | None
) -> None:
    """A and B, rows of q_next above those of v_next."""
    size, (h, sixth, area) = scene.nv, steps
    width = 2 * size + scene.nu

    def put(target: ArrayRef, columns: int, i: Index, c: Index, first: int, of_q: Expr | int, of_v: Expr | int) -> None:
        s1, s2, s3, s4 = (one[i * width + (c + first)] for one in alpha)
        target[i * columns + (c + (first if target is a else 0))] = of_q + area * (s1 + s2 + s3)
        target[(i + size) * columns + (c + (first if target is a else 0))] = of_v + sixth * ((s1 + s4) + 2 * (s2 + s3))

    for first, on_diagonal in ((0, (1, 0)), (size, (h, 1))):
        with builder.loop("i", 0, size) as rows:
            i = rows.index
            with builder.loop("c", 0, i) as columns:
                put(a, 2 * size, i, columns.index, first, 0, 0)
            put(a, 2 * size, i, i, first, *on_diagonal)
            with builder.loop("c", i + 1, size) as columns:
                put(a, 2 * size, i, columns.index, first, 0, 0)
    if b is not None:
        with builder.loop("i", 0, size) as rows, builder.loop("c", 0, scene.nu) as columns:
            put(b, scene.nu, rows.index, columns.index, 2 * size, 0, 0)
