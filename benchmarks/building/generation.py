"""From a description to something callable: seconds to generate and to build, phichain beside its peers.

Every figure comes from a fresh process that has imported everything and built the one-link chain once, so
neither imports nor results kept from another size are counted; a process that takes too long is ended, and says so.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from statistics import median

from benchmarks import ours, plan
from benchmarks.chains import Chain, chain_of
from benchmarks.harness import BenchmarkError, compile_shared
from benchmarks.peers import present
from benchmarks.table import Table

HEADING = "From a description to something callable"
SIZES = {"planar": (4, 2, 8, 16, 64, 256, 500, 1024), "spatial": (5, 16, 64, 256)}
REACH = {("phichain, generate", 64): 1.0, ("phichain, generate", 256): 6.0, ("phichain, build", 500): 10.0,
         ("phichain, build", 1024): 25.0}  # fmt: skip
"""Seconds aimed at, planar."""
LIMIT = 60.0
QUICK = 4.0
"""Seconds below which a figure is the median of three."""
ROOT = Path(__file__).resolve().parents[2]


def _generate(chain: Chain, folder: Path) -> None:
    ours.generate(chain, folder)


def _build(chain: Chain, folder: Path) -> None:
    compile_shared(ours.source(ours.generate(chain, folder)), folder / "ours.so")


def _casadi(chain: Chain, folder: Path) -> None:
    present.module("benchmarks.peers.casadi_recursion").build(chain, folder)


def _heyoka(chain: Chain, folder: Path) -> None:
    present.module("benchmarks.peers.heyoka.cfunc").seconds_to_callable(chain)


CONTESTANTS: dict[str, Callable[[Chain, Path], None]] = {
    "phichain, generate": _generate, "phichain, build": _build, "CasADi, emit and compile": _casadi, "heyoka cfunc": _heyoka,
}  # fmt: skip
_NEEDS = {"CasADi, emit and compile": "casadi", "heyoka cfunc": "heyoka"}


def alone(contestant: str, chain: Chain, limit: float) -> float:
    """Seconds in a process of its own.

    Raises:
        BenchmarkError: It failed, or took longer than `limit`.
    """
    command = [sys.executable, "-m", "benchmarks.building.generation", "--child", contestant, chain.space, str(chain.links)]
    # a session of its own: what it started ends with it
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=ROOT, start_new_session=True
    )
    try:
        out, said = process.communicate(timeout=limit)
    except subprocess.TimeoutExpired as late:
        os.killpg(process.pid, 9)
        process.communicate()
        raise BenchmarkError(f"over {limit:g} s") from late
    if process.returncode != 0:
        raise BenchmarkError("; ".join(said.splitlines()[-1:]) or f"ended with {process.returncode}")
    return float(out.split()[-1])


def child(contestant: str, space: str, links: int) -> float:
    """What `alone` starts."""
    make = CONTESTANTS[contestant]
    with tempfile.TemporaryDirectory(prefix="phichain-bench-") as scratch:
        for name in ("warm", "timed"):
            (Path(scratch) / name).mkdir()
        make(chain_of(space, 1), Path(scratch) / "warm")
        start = time.perf_counter()
        make(chain_of(space, links), Path(scratch) / "timed")
        return time.perf_counter() - start


def cell(contestant: str, chain: Chain, run: plan.Plan) -> str:
    """The median of three, of one where that takes long, or why there is none."""
    try:
        if contestant in _NEEDS:
            present.module(_NEEDS[contestant])
        times = [alone(contestant, chain, LIMIT)]
        while not run.tiny and times[0] < QUICK and len(times) < 3:
            times.append(alone(contestant, chain, LIMIT))
    except present.PeerAbsent as absent:
        return f"skipped: {absent}"
    except BenchmarkError as reason:
        return str(reason)
    reach = REACH.get((contestant, chain.links)) if chain.space == "planar" else None
    return f"{median(times):.2f}" + (f" (reach {reach:g})" if reach else "")


def tables(run: plan.Plan) -> list[Table]:
    """One table per space."""
    found = []
    for space, sizes in SIZES.items():
        chosen, rows = run.few(sizes), []
        for contestant in CONTESTANTS:
            cells: list[str] = []
            for n in sorted(chosen):
                late = any(c.startswith(("over", "skipped")) for c in cells)
                cells.append("-" if late else cell(contestant, chain_of(space, n), run))
            rows.append((contestant, *cells))
            print(f"  {rows[-1]}", flush=True)
        letter = "P, with torques" if space == "planar" else "S"
        notes = (
            ("Seconds elapsed, forward dynamics alone. generate: derive, lower, prove, emit. build: the same and compile. A peer's: its"
            f" expert's recursion to a compiled function. Ended after {LIMIT:g} s."),
        )
        found.append(Table(f"Chain {letter}", ("seconds, N =", *map(str, sorted(chosen))), tuple(rows), notes))
    return found


def main(arguments: Sequence[str] | None = None) -> int:
    given = list(sys.argv[1:] if arguments is None else arguments)
    if given[:1] == ["--child"]:
        print(child(given[1], given[2], int(given[3])))
        return 0
    return plan.command("generation", "benchmarks.building.generation", HEADING, tables, given, __doc__)


if __name__ == "__main__":
    sys.exit(main())
