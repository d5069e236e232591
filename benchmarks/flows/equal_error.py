"""The Taylor flow against everybody else's integrators at equal error: CVODES, DOP853, diffrax, collocation."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from benchmarks import plan
from benchmarks.contest import Runner, Work, contest, detail
from benchmarks.flows.cases import Array, Motion, error, motion
from benchmarks.peers import present
from benchmarks.table import Table

HEADING = "Integrators at equal error"
NAMES = ("planar N = 2", "planar N = 8", "spatial n = 5")
OWN = tuple(10.0**-digits for digits in range(3, 16))
"""Every decade: at a thousand times the peer's error or a thousandth nothing is compared at equal ones."""
REACH = {"CVODES Adams": "30", "SciPy DOP853": "100"}


def makers(m: Motion) -> list[tuple[str, Callable[[], Runner]]]:
    """Every method with its settings."""
    (q, *_), (v, *_) = m.starts()

    def ours(tol: float) -> Runner:
        from phichain import build

        flow = build(m.scene(("propagate",))).function("propagate")
        return _runner(f"phichain taylor, {tol:.0e}", lambda: flow(q, v, 0.0, m.span, tol).q, "ours")

    def cvodes(tol: float) -> Runner:
        peer = present.module("benchmarks.peers.casadi_flows")
        return _runner(f"CVODES Adams, {tol:.0e}", peer.cvodes(m.chain, q, v, m.span, tol))

    def collocation(degree: int, step: float) -> Runner:
        peer = present.module("benchmarks.peers.casadi_flows")
        elements = max(1, round(m.span / step))
        who = f"CasADi collocation, degree {degree}, {1e3 * step:g} ms"
        return _runner(who, peer.collocation(m.chain, q, v, m.span, degree, elements))

    def diffrax(solver: str, tol: float) -> Runner:
        peer = present.module("benchmarks.peers.diffrax_flow")
        return _runner(f"diffrax {solver}, {tol:.0e}", peer.flow(m.chain, q, v, m.span, solver, tol))

    def scipy(tol: float) -> Runner:
        return _runner(f"SciPy DOP853, {tol:.0e}", dop853(m, q, v, tol))

    def _runner(who: str, run: Callable[[], Array], kind: str = "peer") -> Runner:
        return Runner(who, run, error(m.name, run()), kind)

    found: list[tuple[str, Callable[[], Runner]]] = [("phichain", partial(ours, tol)) for tol in OWN]
    found += [("CVODES Adams", partial(cvodes, tol)) for tol in (1e-8, 1e-10, 1e-12)]
    found += [("SciPy DOP853", partial(scipy, tol)) for tol in (1e-6, 1e-9, 1e-12)]
    found += [("diffrax", partial(diffrax, *pair)) for pair in (("Dopri8", 1e-8), ("Dopri8", 1e-11), ("Tsit5", 1e-8))]
    return found + [("CasADi collocation", partial(collocation, *pair)) for pair in ((5, 0.02), (9, 0.02))]


def dop853(m: Motion, q: Array, v: Array, tol: float) -> Callable[[], Array]:
    """SciPy's DOP853 on a right-hand side that costs one call: the compiled forward dynamics, pointers bound before."""
    import ctypes
    import tempfile
    from pathlib import Path

    from scipy.integrate import solve_ivp

    from benchmarks import ours

    chain = m.chain
    scratch = tempfile.TemporaryDirectory(prefix="phichain-bench-")
    candidate = ours.build(chain, Path(scratch.name))
    function = getattr(ctypes.CDLL(str(candidate.library)), candidate.symbol)
    function.argtypes = [ctypes.c_void_p] * 4
    x0, state, out = np.concatenate([q, v]), np.empty(chain.nq + chain.nv), np.empty(chain.nq + chain.nv)
    to, at = out.ctypes.data + 8 * chain.nq, state.ctypes.data

    def rate(_: float, x: Array) -> Array:
        state[:] = x
        function(to, at, None, None)
        if chain.space == "planar":
            out[: chain.nq] = x[chain.nq :]
        else:
            out[:2] = x[chain.nq : chain.nq + 2]
            w, u = x[chain.nq + 2 :].reshape(-1, 3), x[2 : chain.nq].reshape(-1, 3)
            out[2 : chain.nq] = np.cross(w, u).ravel()
        return out.copy()

    def run(_: Any = scratch) -> Array:
        found = solve_ivp(rate, (0.0, m.span), x0, method="DOP853", rtol=tol, atol=tol / 100)
        return np.asarray(found.y[: chain.nq, -1])

    return run


def slower(works: Sequence[Work]) -> Table:
    """How many times longer each takes than our cheapest run that is at least as accurate."""
    rows = []
    for work in works:
        mine = [e for e in work.entries if e.kind == "ours" and e.time is not None]
        for entry in work.entries:
            good = [e for e in mine if e.error <= entry.error]
            if entry.kind == "ours" or entry.time is None or not good:
                continue
            best = min(good, key=lambda e: e.time.median)  # type: ignore[union-attr]
            factor = entry.time.median / best.time.median  # type: ignore[union-attr]
            reach = next((words for peer, words in REACH.items() if entry.who.startswith(peer)), "-")
            rows.append((work.title, entry.who, f"{factor:.3g}", reach, best.who, f"{best.error:.0e} / {entry.error:.0e}"))
    if not rows:
        rows.append(("-", "nobody", "-", "-", "no peer whose error our flow reaches", "-"))
    heads = ("motion", "who", "times slower", "reach", "than", "errors, ours / theirs")
    return Table("Times slower than phichain at no larger error", heads, tuple(rows))


def tables(run: plan.Plan) -> list[Table]:
    """Factors at equal error, then every row."""
    works = []
    for name in run.few(NAMES):
        m = motion(name)
        if run.tiny:  # one of each, over a hundredth of the time: errors then say nothing
            m = Motion(m.name, m.chain, m.span / 100, m.forms)
        chosen = list({who: (who, make) for who, make in makers(m)}.values()) if run.tiny else makers(m)
        works.append(contest(f"{m.name}, {m.span:g} s", chosen, min(run.rounds, 15), 3 * run.budget, "ms"))
    notes = (
        ("Processor time, quartiles over the rounds. CVODES (in CasADi, jit) and DOP853 have a compiled right-hand side; diffrax runs"
        " in JAX on the CPU in double precision, compiled before; CasADi's collocation has equal elements, Gauss-Legendre. Errors:"
        " the largest of an entry of q at the end against 80-bit arithmetic."),
    )
    return [slower(works), detail("Everybody", works, notes)]


def main(arguments: Sequence[str] | None = None) -> int:
    return plan.command("equal_error", "benchmarks.flows.equal_error", HEADING, tables, arguments, __doc__)


if __name__ == "__main__":
    sys.exit(main())
