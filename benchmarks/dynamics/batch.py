"""Batch forms beside heyoka's: forward dynamics of many states, and the Taylor flow of eight trajectories.

Examples::

    python -m benchmarks.batch
    python -m benchmarks.batch --rounds 200 --write
"""

from __future__ import annotations

import argparse
import ctypes
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

if __package__ in (None, ""):  # started as a file
    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from benchmarks import ours, table
from benchmarks.chains import Chain, planar_chain, random_states, scene_table
from benchmarks.harness import compile_shared
from benchmarks.peers import heyoka_batch
from benchmarks.reference import accelerations, relative_error

Array = NDArray[np.float64]

STATES = 1024
TOLERANCE = 1e-12
SPAN = 100.0
#: Spread of the eight starts about theta = (0.4, 0, ...): a user's ensemble.
SPREAD = 1e-3
#: Time that a timed flow runs, s: short enough to find a moment in which nothing else runs.
TIMED = {2: 10.0, 8: 0.5}


def least(candidates: Sequence[Callable[[], object]], rounds: int) -> list[float]:
    """Least processor time of each candidate, s, taking turns."""
    best = [np.inf] * len(candidates)
    for _ in range(rounds):
        for i, run in enumerate(candidates):
            start = time.thread_time()
            run()
            best[i] = min(best[i], time.thread_time() - start)
    return best


# --- forward dynamics -----------------------------------------------------------------------------------------------


def forward_dynamics(links: int, folder: Path, rounds: int) -> tuple[str, ...]:
    """One row: ns per evaluation of both, ratio, errors."""
    chain = planar_chain(links, forced=False)
    states = np.ascontiguousarray(random_states(chain, STATES).T)
    library = ctypes.CDLL(
        str(compile_shared(Path(__file__).with_name("batch.c"), folder / f"passes{links}.so"))
    )
    own = own_dynamics(chain, folder)
    peers = [heyoka_batch.dynamics(chain, folder, width) for width in (8, 16)]
    outs = [np.zeros((chain.nv, STATES)) for _ in range(3)]
    passes = max(1, 40 // links)

    def run(i: int) -> None:
        function, width = (own, chain.nq) if i == 0 else (peers[i - 1], 8 * i)
        passer = library.batch_own if i == 0 else library.batch_peer
        passer(function, ctypes.c_size_t(width), ctypes.c_size_t(STATES), _at(states), _at(outs[i]), passes)

    seconds = least([lambda i=i: run(i) for i in range(3)], rounds)  # type: ignore[misc]
    nanoseconds = [1e9 * s / passes / STATES for s in seconds]
    best = 1 + int(np.argmin(nanoseconds[1:]))
    checked = 32
    reference = np.array([accelerations(chain, state) for state in states.T[:checked]])
    errors = [relative_error(out.T[:checked], reference) for out in outs]
    return (
        f"forward dynamics, N = {links}", f"{nanoseconds[0]:.2f} ns", f"{nanoseconds[best]:.2f} ns (batch {8 * best})",
        f"{nanoseconds[0] / nanoseconds[best]:.2f}", f"{errors[0]:.0e}", f"{errors[best]:.0e}",
    )  # fmt: skip


def own_dynamics(chain: Chain, folder: Path) -> ctypes._CFuncPtr:
    """phichain's batch form, from its generated folder."""
    generated = ours.generate(chain, folder / f"own{chain.links}", want=("forward_dynamics_batch",))
    name = f"{chain.space}{chain.links}"
    candidate = ours.candidate_from_c(
        generated / f"{name}.c", f"{name}_forward_dynamics_batch", "phichain", folder
    )
    return ctypes.CDLL(str(candidate.library))[candidate.symbol]


def _at(array: Array) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


# --- flows ----------------------------------------------------------------------------------------------------------


def starts(chain: Chain) -> Array:
    """Angles of eight trajectories about theta = (0.4, 0, ...), one row each."""
    angles = np.zeros((8, chain.links))
    angles[:, 0] = 0.4
    return angles + SPREAD * np.random.default_rng(20261122).standard_normal(angles.shape)


def flows(links: int, rounds: int) -> tuple[str, ...]:
    """One row: ms per trajectory of SPAN seconds, ratio, largest error of an angle at its end."""
    from phichain import build
    from phichain.scene import scene_from_dict

    chain = planar_chain(links, forced=False)
    own = build(scene_from_dict(scene_table(chain, ("propagate_batch",)))).function("propagate_batch")
    q = starts(chain)
    v, timed = np.zeros_like(q), TIMED[links]
    peers = heyoka_batch.flows(chain, q, TOLERANCE)

    runs = [lambda: own(q, v, 0.0, timed, TOLERANCE), *(lambda peer=peer: peer(timed) for peer in peers)]
    seconds = least(runs, rounds)  # type: ignore[arg-type]
    best = 1 + int(np.argmin(seconds[1:]))
    milliseconds = [1e3 * s * SPAN / timed / len(q) for s in seconds]
    reference = np.array([heyoka_batch.reference(chain, row, SPAN) for row in q])
    found = own(q, v, 0.0, SPAN, TOLERANCE)
    errors = [float(np.max(np.abs(x - reference))) for x in (found.q, peers[best - 1](SPAN))]
    return (
        f"propagate, N = {links}, T = {SPAN:g} s, tol {TOLERANCE:g}", f"{milliseconds[0]:.3g} ms",
        f"{milliseconds[best]:.3g} ms (batch 8)", f"{milliseconds[0] / milliseconds[best]:.2f}", f"{errors[0]:.0e}", f"{errors[best]:.0e}",
    )  # fmt: skip


NOTES = (
    f"Forward dynamics: {STATES} random states in component-major arrays, called from C; errors against 40 digits.",
    f"Flows: eight starts {SPREAD:g} rad about theta = (0.4, 0, ...), per trajectory of {SPAN:g} s, timed over the first"
    + f" {TIMED[2]:g} s (N = 2) and {TIMED[8]:g} s (N = 8); errors are the largest of an angle at the end against heyoka"
    + " in extended precision at 1e-18. Both keep eight trajectories side by side.",
    "Paper A's chains, m = l = 1/N, r = l/2, unforced. heyoka gets the recursion of benchmarks/peers/recursions.py"
    + " (fast_math for the compiled function) and the best of its batch sizes and modes. Processor time, least of all"
    + " rounds, candidates in turn.",
)


def parser() -> argparse.ArgumentParser:
    """The command line."""
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--rounds", type=int, default=100)
    p.add_argument("--write", action="store_true", help="write benchmarks/results/batch.md")
    return p


def main(arguments: Sequence[str] | None = None) -> int:
    given = list(sys.argv[1:] if arguments is None else arguments)
    options = parser().parse_args(given)
    rows: list[tuple[str, ...]] = []
    with tempfile.TemporaryDirectory(prefix="phichain-bench-") as scratch:
        for links in (2, 8, 16):
            rows.append(forward_dynamics(links, Path(scratch), options.rounds))
            print(rows[-1], flush=True)
    for links in (2, 8):
        rows.append(flows(links, options.rounds))
        print(rows[-1], flush=True)
    columns = ("case", "phichain", "heyoka", "ratio", "error, phichain", "error, heyoka")
    made = table.Table("Batches on one core, per state or trajectory", columns, tuple(rows), NOTES)
    if options.write:
        print(table.write("batch", "Batch forms", [made], " ".join(["python -m benchmarks.batch", *given])))
    return 0


if __name__ == "__main__":
    sys.exit(main())
