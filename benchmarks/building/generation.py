"""From a description to something callable: seconds to derive, lower, emit and compile, phichain beside its
peers.

Every figure comes from a fresh process that has imported everything and built the one-link chain once, so
neither imports nor results kept from another size are counted.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from statistics import median

from benchmarks import ours, table
from benchmarks.chains import Chain, chain_of
from benchmarks.harness import BenchmarkError, compile_shared

SIZES = {"planar": (2, 4, 8, 16, 32, 64), "spatial": (5, 16, 64)}
CONTESTANTS = ("phichain, generate", "phichain, compile", "CasADi", "heyoka")
ROOT = Path(__file__).resolve().parents[1]


def seconds(contestant: str, chain: Chain, folder: Path) -> float:
    """One contestant's time on one chain, in this process."""
    if contestant == "CasADi":
        from benchmarks.peers import casadi_recursion

        return casadi_recursion.seconds_to_callable(chain, folder)
    if contestant == "heyoka":
        from benchmarks.peers import heyoka_cfunc

        return heyoka_cfunc.seconds_to_callable(chain)
    start = time.perf_counter()
    generated = ours.generate(chain, folder)
    if contestant == "phichain, generate":
        return time.perf_counter() - start
    start = time.perf_counter()
    compile_shared(ours.source(generated), folder / "ours.so")
    return time.perf_counter() - start


def alone(contestant: str, chain: Chain) -> float:
    """The same in a process of its own; the work of ``_child``."""
    command = [
        sys.executable,
        "-m",
        "benchmarks.generation",
        "--child",
        contestant,
        chain.space,
        str(chain.links),
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=ROOT)
    if done.returncode != 0:
        raise BenchmarkError(f"{contestant} on {chain.label}: " + "\n".join(done.stderr.splitlines()[-3:]))
    return float(done.stdout.split()[-1])


def _child(contestant: str, space: str, links: int) -> float:
    with tempfile.TemporaryDirectory(prefix="phichain-bench-") as scratch:
        for name in ("warm", "timed"):
            (Path(scratch) / name).mkdir()
        seconds(contestant, chain_of(space, 1), Path(scratch) / "warm")
        return seconds(contestant, chain_of(space, links), Path(scratch) / "timed")


def tables(repetitions: int) -> list[table.Table]:
    """Medians over repetitions, one table per space."""
    found = []
    for space, sizes in SIZES.items():
        rows = []
        for contestant in CONTESTANTS:
            times = [median(alone(contestant, chain_of(space, n)) for _ in range(repetitions)) for n in sizes]
            rows.append((contestant, *(f"{t:.2f}" for t in times)))
        letter = "P, with torques" if space == "planar" else "S"
        heads = (f"seconds, N = {''}".strip(), *(str(n) for n in sizes))
        found.append(table.Table(f"Chain {letter}", heads, tuple(rows)))
    return found


def main(arguments: Sequence[str] | None = None) -> int:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--write", action="store_true", help="write benchmarks/results/generation.md")
    p.add_argument("--repetitions", type=int, default=3)
    p.add_argument("--child", nargs=3, help=argparse.SUPPRESS)
    options = p.parse_args(arguments)
    if options.child:
        contestant, space, links = options.child
        print(_child(contestant, space, int(links)))
        return 0
    found = tables(options.repetitions)
    print("\n".join(t.markdown() for t in found))
    if options.write:
        heading = "From a description to something callable"
        print(table.write("generation", heading, found, "python -m benchmarks.generation --write"))
    return 0


if __name__ == "__main__":
    sys.exit(main())
