"""Loops or straight-line code for the Programs of a recurrence, as a scene asks or by operation count."""

from __future__ import annotations

from phichain.ir.nodes import Program
from phichain.ir.passes import prune, total_operations, unroll
from phichain.ir.short_loops import without_short_loops
from phichain.lowering.lower import UNROLL_LIMIT


def shaped(loops: Program, code: str) -> Program:
    """The same function as `code` says: "unrolled", "loops" or, for "auto", whichever its operations speak for."""
    whole = prune(loops)
    if code == "loops" or (code == "auto" and total_operations(whole) > 2 * UNROLL_LIMIT):
        return without_short_loops(whole)
    flat = unroll(whole)
    is_flat = code == "unrolled" or total_operations(flat) <= UNROLL_LIMIT
    return flat if is_flat else without_short_loops(whole)
