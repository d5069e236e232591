"""What a chain can be asked for, read off the table of the contract."""

from __future__ import annotations

from phichain.contract.chain import Sample
from phichain.contract.functions import TABLE

SLOW_TO_JUDGE = frozenset({("spatial", "step_jacobian")})
"""Its reference differences every column of a step in 50 digits, 5 s a case: `lowering/jacobians/test_step_jacobian.py` judges it, and no list of all."""

DERIVATIVES = frozenset(row.name for row in TABLE if row.derivative)
"""Functions that are the Jacobians of others."""


def offered(
    space: str, damped: bool = False, *, on_request: bool = False, flows: bool = False, driven: bool = False, slow: bool = False
) -> tuple[str, ...]:
    """The functions of such a chain, in the order of the contract.

    Args:
        space: "planar" or "spatial".
        damped: whether its joints carry dampers.
        on_request: also those that are asked for by name.
        flows: also those that run over many steps or states, which are no Program.
        driven: whether a cart is driven by its acceleration.
        slow: also those whose reference takes seconds a case.
    """
    base, drive = ("cart", "acceleration") if driven else ("fixed", None)
    kind = Sample(space == "planar", (1.0,) if damped else None, drive=drive, base=base)
    return tuple(
        row.name
        for row in TABLE
        if row.absence(kind) is None and (flows or not row.flow) and (on_request or not row.on_request) and (slow or (space, row.name) not in SLOW_TO_JUDGE)
    )
