"""The variational equations of a flow: `follow` for several columns of derivatives at once, and their part of a workspace.

Differentiated with respect to anything, the recurrence of a product a b is

    dc_n = a_0 db_n + b_0 da_n + [ sum_{0<j<n} (da_j b_{n-j} + a_{n-j} db_j) + da_0 b_n + a_n db_0 ]

and likewise for quotients, roots, sines and cosines: the recurrence itself, its coefficients of order 0 those of the state,
with the bracket for S_n. With S_0 = 0 and 1/0 read as 0 it gives the derivatives at order 0, too. So `follow` serves, and
nothing is differentiated.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from phichain.ir.nodes import Program
from phichain.ir.short_loops import without_short_loops
from phichain.scene import Scene
from phichain.transform.columns import columns
from phichain.transform.lanes import SUMS, Jets

#: Columns in one vector of lanes, where there are that many.
_WIDTHS: Final = (4, 8)
#: Lanes from which on columns go one by one, so that their arrays leave room on the stack.
_HUGE: Final = 4096


def columns_at_once(scene: Scene, recurrences: Jets) -> int:
    """How many columns are carried side by side: whole vectors, few of them in vain."""
    size = scene.nq + scene.nv
    if recurrences.products > _HUGE:
        return 1
    if size < _WIDTHS[0]:
        return size
    return min(_WIDTHS, key=lambda width: (-(-size // width) * width, -width))


def column_program(scene: Scene, recurrences: Jets) -> Program:
    """`follow` for that many columns: what moves is wide, what belongs to the state is shared."""
    follow = recurrences.follow
    wide = {"q", "v", SUMS}
    shared = [array.name for array in follow.inputs if array.name not in wide]
    program = replace(
        follow,
        name="flow_follow_columns",
        doc="Order n of derivatives of the Taylor series, column by column.",
    )
    return without_short_loops(columns(program, columns_at_once(scene, recurrences), shared))


def workspace(scene: Scene, recurrences: Jets, highest: int) -> list[tuple[str, tuple[int, ...]]]:
    """Arrays of a workspace for derivatives."""
    width, size = columns_at_once(scene, recurrences), scene.nq + scene.nv
    lanes = max(recurrences.products, 1) * width
    return [
        ("d_x", (highest + 1, size * width)),
        ("d_left", (highest, lanes)),
        ("d_right", (highest, lanes)),
        ("d_sum", (4, lanes)),
        ("d_next", (size * size,)),
    ]
