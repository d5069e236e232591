"""Forward dynamics of many states at once beside heyoka's batches, from C; and from Python on both cores.

Examples::

    python -m benchmarks.dynamics.batch
"""

from __future__ import annotations

import ctypes
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks import ours, plan
from benchmarks.chains import Chain, planar_chain, random_states, spatial_chain
from benchmarks.contest import Maker, Runner, Work, contest, detail, summary
from benchmarks.flows.cases import motion
from benchmarks.harness import compile_shared
from benchmarks.peers import present
from benchmarks.reference import accelerations, relative_error
from benchmarks.table import Table

HEADING = "Batches"
_CHECKED = 32
PASSES = 32
"""Over all states in one call from Python, whose own cost then vanishes."""
CHAINS = {
    "P": (lambda n: planar_chain(n, forced=False), (2, 8, 16)),
    "S": (lambda n: spatial_chain(n, forced=False), (3, 5)),
}
Array = NDArray[np.float64]


def dynamics(name: str, chain: Chain, run: plan.Plan) -> Work:
    """One chain: a pass over all states."""
    count = max(16, run.states // 4)  # in the caches, as a batch would be
    states = np.ascontiguousarray(random_states(chain, count).T)
    checked = min(_CHECKED, count)
    exact = np.array([accelerations(chain, state) for state in states.T[:checked]])
    with tempfile.TemporaryDirectory(prefix="phichain-bench-") as scratch:
        folder = Path(scratch)
        passer = ctypes.CDLL(str(compile_shared(Path(__file__).with_name("batch.c"), folder / "passes.so")))

        def runner(who: str, kind: str, call: Callable[[Array], None]) -> Runner:
            out = np.full((chain.nv, count), np.nan)
            call(out)
            return Runner(who, lambda: call(out), relative_error(out.T[:checked], exact), kind)

        def mine() -> Runner:
            function = own_dynamics(chain, folder)
            sizes = ctypes.c_size_t(chain.nq), ctypes.c_size_t(count)
            return runner("phichain", "ours", lambda out: passer.batch_own(function, *sizes, _at(states), _at(out), PASSES))

        def theirs(width: int) -> Runner:
            function = present.module("benchmarks.peers.heyoka.batch").dynamics(chain, folder, width)
            sizes = ctypes.c_size_t(width), ctypes.c_size_t(count)
            call = lambda out: passer.batch_peer(function, *sizes, _at(states), _at(out), PASSES)
            return runner(f"heyoka, batch {width}", "peer", call)

        makers: list[tuple[str, Maker]] = [("phichain", mine)]
        makers += [(f"heyoka, batch {width}", partial(theirs, width)) for width in (8, 16)]
        return contest(f"{name}, N = {chain.links}: {count} states, per state", makers, run.rounds, run.budget, "ns", per=PASSES * count)


def own_dynamics(chain: Chain, folder: Path) -> ctypes._CFuncPtr:
    """phichain's batch form, from its generated folder."""
    generated = ours.generate(chain, folder / f"own{chain.links}", want=("forward_dynamics_batch",))
    name = f"{chain.space}{chain.links}"
    library = compile_shared(generated / f"{name}.c", folder / f"own{chain.links}.so", extra=("-fno-tree-slp-vectorize",))
    return ctypes.CDLL(str(library))[f"{name}_forward_dynamics_batch"]


def cores(run: plan.Plan) -> Work:
    """A batch of 64 trajectories from Python: elapsed time over that of the same call for one after the other's eight."""
    m = motion("planar N = 2")
    q, v = m.starts(64)

    def mine(rows: int, who: str, kind: str) -> Runner:
        from phichain import build

        flow = build(m.scene(("propagate_batch",))).function("propagate_batch")
        parts = np.split(np.arange(64), 64 // rows)
        return Runner(who, lambda: [flow(q[k], v[k], 0.0, 10.0, 1e-12) for k in parts], kind=kind)

    # the yardstick is our own flow of eight at a time, which one core serves
    makers: list[tuple[str, Maker]] = [
        ("64 at once", lambda: mine(64, "phichain, 64 at once", "ours")),
        ("8 at a time", lambda: mine(8, "phichain, 8 at a time (one core)", "peer")),
    ]
    return contest("64 trajectories, P, N = 2, 10 s: elapsed time", makers, run.rounds, run.budget, "ms", "", time.perf_counter)


def _at(array: Array) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


def tables(run: plan.Plan) -> list[Table]:
    """Dynamics, cores, every row."""
    works = [dynamics(name, make(n), run) for name, (make, sizes) in CHAINS.items() for n in run.few(sizes)]
    both = cores(run)
    notes = (
        ("A pass over random states in component-major arrays, called from C; errors against 40 digits. heyoka: an expert's form"
        " (spatial: our tension form), fast_math, 8 and 16 states a call. The flows of eight: flows.md."),
    )
    own = "Elapsed time; the yardstick is our own flow of eight trajectories at a time: below 1, more than one core works."
    return [
        summary("Forward dynamics of many states, one core", works, notes),
        summary("Both cores", [both], (own,)),
        detail("Everybody", works),
    ]


def main(arguments: Sequence[str] | None = None) -> int:
    return plan.command("batch", "benchmarks.dynamics.batch", HEADING, tables, arguments, __doc__)


if __name__ == "__main__":
    sys.exit(main())
