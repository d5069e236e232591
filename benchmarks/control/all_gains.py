"""Regulators of all 2^n equilibria of paper B's chain, beside SciPy's and python-control's own Riccati solvers."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from itertools import product

import numpy as np

from benchmarks import plan
from benchmarks.chains import scene_table, spatial_chain
from benchmarks.contest import Maker, Runner, Work, contest, detail, summary
from benchmarks.flows.cases import Array
from benchmarks.peers import present
from benchmarks.table import Table

HEADING = "Regulators of all equilibria"
LINKS = (2, 5, 8)
REACH = {2: "1", 5: "1", 8: "1"}


def race(links: int, run: plan.Plan) -> Work:
    """All equilibria of one chain; errors are residuals of the Riccati equation over its largest term, the worst of all."""
    from phichain import build
    from phichain.control import lqr, regulators
    from phichain.scene import scene_from_dict

    want = ("forward_dynamics", "linearization")
    system = build(scene_from_dict(scene_table(spatial_chain(links), want)))
    every = list(product((1, -1), repeat=links))
    found = regulators(system, every)
    weights = [(g.A, g.B, g.Q, g.R) for g in found]

    def worst(solutions: Sequence[Array]) -> float:
        return max(residual(*w, S) for w, S in zip(weights, solutions, strict=True))

    def ours() -> Runner:
        return Runner("phichain regulators", lambda: regulators(system, every), worst([g.S for g in found]), "ours")

    def singly() -> Runner:
        return Runner("phichain lqr, one by one", lambda: [lqr(system, s) for s in every], worst([g.S for g in found]), "ours")

    def by(who: str, solve: Callable[..., Array]) -> Runner:
        return Runner(who, lambda: [solve(*w) for w in weights], worst([solve(*w) for w in weights]))

    def scipy() -> Runner:
        from scipy.linalg import solve_continuous_are

        return by("SciPy solve_continuous_are", solve_continuous_are)

    def control() -> Runner:
        care = present.module("control").care
        return by("python-control care", lambda *w: np.asarray(care(*w)[0]))

    makers: list[tuple[str, Maker]] = [("phichain", ours), ("phichain lqr", singly), ("SciPy", scipy), ("python-control", control)]
    return contest(f"n = {links}: {len(every)} equilibria", makers, min(run.rounds, 9), 2 * run.budget, "s", REACH[links])


def residual(A: Array, B: Array, Q: Array, R: Array, S: Array) -> float:
    """|A^T S + S A - S B R^-1 B^T S + Q| over the largest of its terms."""
    quadratic = S @ B @ np.linalg.solve(R, B.T @ S)
    size = max(np.max(np.abs(S @ A)), np.max(np.abs(quadratic)), np.max(np.abs(Q)))
    return float(np.max(np.abs(A.T @ S + S @ A - quadratic + Q)) / size)


def tables(run: plan.Plan) -> list[Table]:
    """The summary, then every row."""
    works = [race(n, run) for n in run.few(LINKS)]
    notes = (
        ("Paper B's chain, identity weights. Ours linearises, tests controllability and solves; a peer solves alone, of matrices that are"
        " there. Aimed at: n = 5 in 0.08 s, n = 8 in 1 s, and below SciPy's own. Errors: residual of the Riccati equation over its"
        " largest term."),
    )
    return [summary("All equilibria", works, notes), detail("Everybody", works)]


def main(arguments: Sequence[str] | None = None) -> int:
    return plan.command("regulators", "benchmarks.control.all_gains", HEADING, tables, arguments, __doc__)


if __name__ == "__main__":
    sys.exit(main())
