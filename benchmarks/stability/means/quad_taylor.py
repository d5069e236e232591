"""A second way to a reference: heyoka's Taylor method in binary128 on the link-frame recursion (relative angles)."""

from __future__ import annotations

from typing import Any

import mpmath as mp
import numpy as np

from benchmarks.stability.cases.case import Case

_MOST_LINKS = 4


def serves(case: Case) -> bool:
    """Planar chains on a fixed base, few links, no springs."""
    chain = case.chain
    return (
        "stiffness" not in chain
        and case.means == "extrapolation"
        and chain.get("space", "planar") == "planar"
        and chain.get("base", "fixed") == "fixed"
        and chain["links"] <= _MOST_LINKS
    )


def states(case: Case) -> list[list[mp.mpf]]:
    """(q, v) at the case's times."""
    import heyoka as hy

    from benchmarks.peers.heyoka.taylor import equations

    wide = hy.real128
    start = np.array([wide(x) for x in (*case.q, *case.v)])
    flow = hy.taylor_adaptive(
        equations(case.plain(), number=wide), start, fp_type=wide, tol=wide(1e-28), compact_mode=True
    )
    found = []
    for t in case.times:
        flow.propagate_until(wide(t))
        found.append([_number(x) for x in flow.state])
    return found


def _number(value: Any) -> mp.mpf:
    return mp.mpf(str(value))
