"""The flow in single precision: 200 states a chain, how many it refuses and how far off the others end."""

from __future__ import annotations

import sys
from collections.abc import Sequence

import numpy as np

from benchmarks import plan
from benchmarks.chains import planar_chain, scene_table
from benchmarks.flows.cases import Array
from benchmarks.table import Table

HEADING = "Taylor flow in single precision"
LINKS = (2, 1, 3, 4, 6, 8, 12, 16)
TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6)
SPAN = 0.5
STATES = 200


def starts(links: int, count: int) -> tuple[Array, Array]:
    """Angles within 1 rad, rates of about 1 rad/s, exact in single precision."""
    rng = np.random.default_rng(links)
    q, v = rng.uniform(-1, 1, (count, links)), rng.standard_normal((count, links))
    return q.astype(np.float32).astype(float), v.astype(np.float32).astype(float)


def row(links: int, count: int, tolerances: Sequence[float]) -> tuple[str, ...]:
    """Refused and the 90th percentile and largest error over the tolerance, for each tolerance."""
    from phichain import build
    from phichain.scene import scene_from_dict

    flows = []
    for real in ("float", "double"):
        table = scene_table(planar_chain(links, forced=False), ("propagate",))
        table["target"]["real"] = real
        flows.append(build(scene_from_dict({**table, "name": f"{real}{links}"})).function("propagate"))
    q, v = starts(links, count)
    exact = [flows[1](a, b, 0.0, SPAN, 1e-13).q for a, b in zip(q, v, strict=True)]
    cells = []
    for tol in tolerances:
        found = [flows[0](a, b, 0.0, SPAN, tol) for a, b in zip(q, v, strict=True)]
        off = [float(np.max(np.abs(f.q - x))) for f, x in zip(found, exact, strict=True) if f.outcome == "done"]
        refused = count - len(off)
        tail = f"{np.percentile(off, 90) / tol:.2g} / {max(off) / tol:.2g}" if off else "-"
        cells.append(f"{refused}; {tail}")
    print(f"  N = {links}: {cells}", flush=True)
    return (f"N = {links}", *cells)


def tables(run: plan.Plan) -> list[Table]:
    """One row a chain."""
    count = 4 if run.tiny else STATES
    tolerances = run.few(TOLERANCES)
    rows = tuple(row(n, count, tolerances) for n in run.few(LINKS))
    notes = (
        (f"Chain P without torques, {count} states, {SPAN:g} s. A cell: states refused; error over tolerance, 90th percentile and"
        " largest, the largest angle against the flow in double precision at 1e-13. Aimed at: none refused. A chaotic chain amplifies"
        " the round-off of single precision, 6e-8, too."),
    )
    return [Table("Refused; error over tolerance", ("chain", *(f"{t:.0e}" for t in tolerances)), rows, notes)]


def main(arguments: Sequence[str] | None = None) -> int:
    return plan.command("single_precision", "benchmarks.flows.single_precision", HEADING, tables, arguments, __doc__)


if __name__ == "__main__":
    sys.exit(main())
