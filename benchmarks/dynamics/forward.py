"""Forward dynamics of every kind of chain: time and error per evaluation, phichain beside its peers, from C.

Examples::

    python -m benchmarks.dynamics.forward
    python -m benchmarks.dynamics.forward --tiny
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from benchmarks import chains, ours, plan
from benchmarks.contest import Work, detail, summary
from benchmarks.dynamics import compare
from benchmarks.dynamics.compare import Builder, Pair
from benchmarks.table import Table

HEADING = "Forward dynamics, timed from C"
ROBOTICS = ("P, torques",)
"""Kinds that Pinocchio and MuJoCo are compared on: elsewhere their joints have poles or fictitious inertia."""
PREPARED = ("P, parameters prepared",)
"""Kinds whose runtime parameters stay the same from call to call: `prepare` has kept what they alone determine."""
KINDS = {
    "P, torques": (chains.planar_chain, (2, 1, 4, 8, 16, 32, 64), {8: "0.55", 32: "0.35", 64: "0.35"}),
    "P": (lambda n: chains.planar_chain(n, forced=False), (2, 8, 32, 64), {8: "0.55", 32: "0.35", 64: "0.35"}),
    "P, absolute angles": (chains.absolute_chain, (2, 1, 4, 8, 32), {2: "0.8", 8: "0.55", 32: "0.35"}),
    "P, masses 1e4 .. 1e-4": (chains.spread_chain, (2, 8, 32), {8: "0.55", 32: "0.35"}),
    "P, runtime parameters": (chains.runtime_chain, (2, 8, 32), {8: "0.55", 32: "0.35"}),
    "P, parameters prepared": (chains.runtime_chain, (2, 8, 32), {8: "0.55", 32: "0.35"}),
    "P on a cart": (chains.cart_chain, (2, 1, 8, 32), {8: "0.55", 32: "0.35"}),
    "planar, tip masses": (chains.tip_chain, (2, 8, 32), {}),
    "S": (chains.spatial_chain, (2, 1, 5, 16, 64), {1: "0.95", 2: "1.0", 5: "0.95"}),
    "S, masses at 0.6 l": (chains.inner_spatial_chain, (2, 1, 5, 10), {5: "0.8", 10: "0.8"}),
}
"""Kind of chain -> what makes it, its sizes (the first one alone in a tiny run), the ratios aimed at."""
_LEGEND = Table(
    "What the rows are",
    ("row", "code"),
    (
        ("**bold**", "phichain's emitted C"),
        ("heyoka cfunc", "an expert's O(N) recursion, fast_math; slp: with LLVM's superword vectoriser"),
        ("CasADi", "the same recursion, emitted by CasADi, our compiler flags; no slp: without gcc's superword vectoriser"),
        ("closed form", "the dense Lagrangian in absolute angles, factorised symbol by symbol"),
        ("given the tension form", "this project's own formula for masses at the links' ends, in the peer's compiler: a yardstick"),
        ("*italic*", "our elimination from both ends in a peer's compiler: no yardstick"),
        ("Pinocchio, MuJoCo", "their own algorithms, called from C"),
    ),
    (
        ("Independent: no result feeds the next evaluation (throughput). Chained: every entry of the next state waits for the last"
        " result, as in an integrator (latency). Ratios are formed round by round; the best peer is the fastest row that is neither"
        " bold nor italic. Errors: max norm over max norm against the dense Lagrangian at 40 digits."),
    ),
)


def measure(kind: str, links: int, run: plan.Plan) -> Pair:
    """One chain."""
    make, _, reach = KINDS[kind]
    builders: list[tuple[str, Builder]] = [
        ("phichain", lambda chain, folder: [ours.build_prepared(chain, folder) if kind in PREPARED else ours.build(chain, folder)]),
        ("heyoka", compare.heyoka),
        ("CasADi", compare.casadi),
    ]
    if kind in ROBOTICS:
        builders += [("Pinocchio", compare.pinocchio), ("MuJoCo", compare.mujoco)]
    with tempfile.TemporaryDirectory(prefix="phichain-bench-") as scratch:
        return compare.compare(f"{kind}, N = {links}", make(links), builders, Path(scratch), run, reach.get(links, ""))


def tables(run: plan.Plan) -> list[Table]:
    """Summaries of both ways to time, then every row."""
    pairs = [measure(kind, links, run) for kind, (_, sizes, _) in KINDS.items() for links in run.few(sizes)]
    independent: list[Work] = [pair.independent for pair in pairs]
    chained: list[Work] = [pair.chained for pair in pairs]
    states = f"{run.states} random states, {run.rounds} rounds of about 0.2 ms each."
    return [
        summary("Independent evaluations", independent, (states,)),
        summary("Chained evaluations", chained, (states,)),
        _LEGEND,
        detail("Independent: everybody", independent),
        detail("Chained: everybody", chained),
    ]


def main(arguments: Sequence[str] | None = None) -> int:
    return plan.command("forward_dynamics", "benchmarks.dynamics.forward", HEADING, tables, arguments, __doc__)


if __name__ == "__main__":
    sys.exit(main())
