"""The state transition matrix along a trajectory: all 2N columns over a quarter period, and events of one link."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np

from benchmarks import plan
from benchmarks.contest import Entry, Runner, Work, contest, detail, summary
from benchmarks.flows.cases import Array, Motion, motion
from benchmarks.peers import present
from benchmarks.table import Table

HEADING = "Derivatives along a trajectory, and events"
TOLERANCE = 1e-12
FACTORS = {2: "2.5", 1: "", 4: "4", 8: "8"}
"""Links -> the time of all columns over that of the plain flow, aimed at."""


def quarter(links: int) -> Motion:
    """The motion of the flows' table, cut to a quarter of the slow mode's period."""
    from benchmarks.chains import planar_chain

    slow = 2 * math.pi / 4.5 if links > 1 else 2 * math.pi * math.sqrt(0.5 / 9.81)
    return Motion(f"planar N = {links}", planar_chain(links, forced=False), slow / 4, ("link frame",))


def transition(links: int, run: plan.Plan) -> tuple[Work, Entry | None]:
    """The race of the matrices, and our plain flow's row of the same race."""
    m = quarter(links)
    (q,), (v,) = m.starts(1)
    size = 2 * links
    exact = differences(m, q, v)

    def off(matrix: Array) -> float:
        return float(np.max(np.abs(matrix - exact)) / np.max(np.abs(exact)))

    def ours() -> list[Runner]:
        from phichain import build

        flow = build(m.scene(("propagate",), flow={"variational": True})).function("propagate")
        identity = np.eye(size)
        whole = lambda: flow(q, v, 0.0, m.span, TOLERANCE, transition=identity).transition
        plain, bound = partial(flow, q, v, 0.0, m.span, TOLERANCE), flow.bind(TOLERANCE, columns=size)
        start = np.concatenate([q, v, identity.ravel()])

        def again() -> Array:
            bound.state[:] = start
            bound(0.0, m.span)
            return bound.transition

        return [
            Runner("phichain", whole, off(whole()), "ours"), Runner("phichain, no columns", plain, kind="hybrid"),
            Runner("phichain, bound", again, off(again()), "hybrid"),
        ]  # fmt: skip

    def theirs(compact: bool) -> Runner:
        flow = present.module("benchmarks.peers.heyoka.flows").columns(m.chain, q, v, TOLERANCE, compact)
        return Runner(f"heyoka{', compact' if compact else ''}", partial(flow, m.span), off(flow(m.span)))

    modes = (False, True) if links < 4 else (True,)
    makers: list[tuple[str, Any]] = [("phichain", ours), *((f"heyoka, compact {c}", partial(theirs, c)) for c in modes)]
    work = contest(f"{size} columns, P, N = {links}", makers, run.rounds, run.budget, "us")
    return work, next((e for e in work.entries if e.who == "phichain, no columns"), None)


def differences(m: Motion, q: Array, v: Array) -> Array:
    """The matrix by central differences of DOP853 in extended steps: only a check that nobody is wrong, to about 1e-7."""
    from scipy.integrate import solve_ivp

    from benchmarks.peers.recursions import accelerations

    def rate(_: float, x: Array) -> list[float]:
        values = x.tolist()
        half = len(values) // 2
        found = accelerations(m.chain, "link frame", values[:half], values[half:], [], math.sin, math.cos)
        return [*values[half:], *found]

    x0 = np.concatenate([q, v])
    step, columns = 1e-5, []
    for k in range(len(x0)):
        ends = []
        for way in (step, -step):
            x = x0.copy()
            x[k] += way
            ends.append(solve_ivp(rate, (0.0, m.span), x, method="DOP853", rtol=1e-13, atol=1e-14).y[:, -1])
        columns.append((ends[0] - ends[1]) / (2 * step))
    return np.array(columns).T


def factors(pairs: Sequence[tuple[Work, Entry | None]], links: Sequence[int]) -> Table:
    """All columns over the plain flow of the same race."""
    rows = []
    for (work, plain), n in zip(pairs, links, strict=True):
        mine = work.ours
        if mine is not None and mine.time is not None and plain is not None and plain.time is not None:
            rows.append((f"{2 * n} columns, N = {n}", f"{mine.time.median / plain.time.median:.3g}", FACTORS[n] or "-"))
    return Table("All columns over the plain flow", ("work", "x the plain flow", "reach"), tuple(rows))


def first_event(run: plan.Plan) -> Work:
    """One link released at 0.4 rad: when it first hangs down."""
    m = motion("planar N = 1")
    (q,), (v,) = m.starts(1)
    from scipy.special import ellipk

    exact = float(ellipk(math.sin(q[0] / 2) ** 2) / math.sqrt(9.81 / 0.5))

    def ours() -> list[Runner]:
        from phichain import build
        from phichain.system.propagation import Stop

        flow, stop = build(m.scene(("propagate",))).function("propagate"), Stop("q", 0)
        find, bound = lambda: flow(q, v, 0.0, 100.0, TOLERANCE, stop=stop).t, flow.bind(TOLERANCE, stop=stop)
        start = np.concatenate([q, v])

        def again() -> float:
            bound.state[:] = start
            return bound(0.0, 100.0)

        return [Runner("phichain, bound", again, abs(again() - exact), "ours"), Runner("phichain", find, abs(find() - exact), "hybrid")]

    def theirs() -> Runner:
        find = present.module("benchmarks.peers.heyoka.flows").event(m.chain, q, v, TOLERANCE)
        return Runner("heyoka", find, abs(find() - exact))

    makers: list[tuple[str, Any]] = [("phichain", ours), ("heyoka", theirs)]
    return contest("N = 1: the first passage of the bottom, from Python", makers, run.rounds, run.budget, "us", "0.8")


def tables(run: plan.Plan) -> list[Table]:
    """Factors, the race of the matrices, the event."""
    links = run.few(list(FACTORS))
    pairs = [transition(n, run) for n in links]
    works = [*(work for work, _ in pairs), first_event(run)]
    notes = (
        ("From Python, tolerance 1e-12. Errors of matrices against differences of SciPy's DOP853, good to about 1e-7: they tell that"
        " nobody is wrong, no more; of the event against the elliptic integral, s."),
    )
    return [factors(pairs, links), summary("Beside heyoka's variational equations", works, notes), detail("Everybody", works)]


def main(arguments: Sequence[str] | None = None) -> int:
    return plan.command("columns", "benchmarks.flows.columns", HEADING, tables, arguments, __doc__)


if __name__ == "__main__":
    sys.exit(main())
