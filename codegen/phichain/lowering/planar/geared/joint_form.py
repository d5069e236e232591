"""The form sum_k w_k (joint angle k)^2 on top of a matrix in a planar scene's own angles."""

from __future__ import annotations

from collections.abc import Callable

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.lowering.planar.joint_state import LAG
from phichain.scene import Scene


def with_joints(
    builder: Builder,
    scene: Scene,
    weight: Callable[[Index], Expr] | None,
    block: ArrayRef,
    out: ArrayRef,
    cell: Callable[[Index, Index], Index],
) -> None:
    """Write a links x links matrix with the joints' form.

    The angle of joint k is theta_k - theta_(k - lag): its weight stands at (k, k), at (k - lag, k - lag) and, with the
    other sign, between them. Added here and not in absolute angles, large ones round nothing but themselves.

    Args:
        builder: where the Program is recorded.
        scene: the chain.
        weight: w_k; None for the matrix alone.
        block: the matrix, in the scene's angles.
        out: receives the sum.
        cell: where entry (i, j) goes.
    """
    links, lag = scene.links, LAG[str(scene.angles)]

    def copied(i: Index, start: Index, stop: Index) -> None:
        with builder.loop("j", start, stop) as columns:
            out[cell(i, columns.index)] = block[i * links + columns.index]

    def row(i: Index, has_before: bool, has_after: bool) -> None:
        assert weight is not None
        held = block[i * links + i] + weight(i)
        copied(i, 0, i - lag if has_before else i)
        if has_before:
            out[cell(i, i - lag)] = block[i * links + i - lag] - weight(i)
            copied(i, i - lag + 1, i)
        if has_after:
            held = held + weight(i + lag)
            copied(i, i + 1, i + lag)
            out[cell(i, i + lag)] = block[i * links + i + lag] - weight(i + lag)
        copied(i, i + lag + 1 if has_after else i + 1, links)
        out[cell(i, i)] = held

    if weight is None:
        with builder.loop("i", 0, links) as rows:
            copied(rows.index, 0, links)
        return
    ends = [k for k in range(links) if lag and (k < lag or k >= links - lag)]
    for k in ends:
        row(k, k >= lag, k + lag < links)
    with builder.loop("i", lag, max(lag, links - lag)) as rows:
        row(rows.index, bool(lag), bool(lag))
