"""Where derivatives of a spatial motion along its state start: rows 0 of a column."""

from __future__ import annotations

from phichain.ir.builder import Builder
from phichain.ir.nodes import Program
from phichain.lowering.series.series import LEAD, LEFT, RIGHT
from phichain.lowering.series.shape import shaped
from phichain.lowering.series.spatial.rows import right_rows
from phichain.lowering.spatial.links import directions
from phichain.scene import Scene


def columns_program(scene: Scene) -> Program:
    """`flow_columns`: the variation of q_0 leads, that of v_0 is row 0; the rest begins with nothing."""
    lanes, rights = 3 * scene.links, 3 * right_rows(scene) * scene.links
    builder = Builder("flow_columns", "Derivatives of rows 0 along a variation of the state.")
    dq, dv = (
        builder.input("dq", (scene.nq,), "variation"),
        builder.input("dv", (scene.nv,), "variation, scaled time"),
    )
    lead = builder.output(LEAD, (lanes,), "of the unit vectors themselves")
    d_left, d_right = (
        builder.output(f"d_{LEFT}", (lanes,), "of row 0"),
        builder.output(f"d_{RIGHT}", (rights,), "of row 0"),
    )
    with builder.loop("i", 0, lanes) as loop:
        lead[loop.index], d_left[loop.index] = (
            directions(scene, dq)[loop.index],
            directions(scene, dv)[loop.index],
        )
    with builder.loop("i", 0, rights) as loop:
        d_right[loop.index] = builder.lift(0)
    return shaped(builder.finish(), scene.code)
