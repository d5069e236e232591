"""state_jacobian beside CasADi's Jacobian of an expert's recursion and Pinocchio's derivatives, from C."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from benchmarks import ours, plan
from benchmarks.chains import planar_chain
from benchmarks.contest import detail, summary
from benchmarks.dynamics import compare
from benchmarks.dynamics.compare import Builder, Pair
from benchmarks.table import Table

HEADING = "Jacobians of the forward dynamics, timed from C"
REACH = {2: "", 5: "", 8: "0.6", 10: "0.5", 16: "0.15", 32: "0.2"}


def measure(links: int, run: plan.Plan) -> Pair:
    """d a/d q and d a/d v of chain P without torques."""
    builders: list[tuple[str, Builder]] = [
        ("phichain", lambda chain, folder: [ours.build(chain, folder, function="state_jacobian")]),
        ("Pinocchio", compare.pinocchio_jacobian),
        ("CasADi", compare.casadi_jacobian),
    ]
    with tempfile.TemporaryDirectory(prefix="phichain-bench-") as scratch:
        chain = planar_chain(links, forced=False)
        return compare.compare(
            f"P, N = {links}", chain, builders, Path(scratch), run, REACH[links], is_jacobian=True
        )


def tables(run: plan.Plan) -> list[Table]:
    """Summaries, then every row."""
    pairs = [measure(links, run) for links in run.few(list(REACH))]
    independent, chained = [pair.independent for pair in pairs], [pair.chained for pair in pairs]
    notes = (
        (
            "d a/d q and d a/d v, row-major. CasADi: the Jacobian of an expert's recursion, its straight-line C, given two minutes to"
            " compile. Pinocchio: computeABADerivatives. Errors: max norm over max norm against differences of the dense Lagrangian"
            " in 40 digits."
        ),
    )
    return [
        summary("Independent evaluations", independent, notes),
        summary("Chained evaluations", chained),
        detail("Independent: everybody", independent),
        detail("Chained: everybody", chained),
    ]


def main(arguments: Sequence[str] | None = None) -> int:
    return plan.command("jacobians", "benchmarks.dynamics.jacobians", HEADING, tables, arguments, __doc__)


if __name__ == "__main__":
    sys.exit(main())
