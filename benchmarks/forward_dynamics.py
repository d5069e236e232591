"""Forward dynamics: nanoseconds per evaluation and error, phichain beside its peers, timed from C in one process.

Examples::

    python -m benchmarks.forward_dynamics
    python -m benchmarks.forward_dynamics --space planar --links 2 4 8
    python -m benchmarks.forward_dynamics --space planar --links 8 --candidate-c trial.c --symbol trial_forward_dynamics
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

if __package__ in (None, ""):  # started as a file
    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from benchmarks import ours, table
from benchmarks.chains import Chain, chain_of, random_states
from benchmarks.harness import Arena, Candidate, Timing
from benchmarks.reference import accelerations, relative_error

SIZES = {"planar": (1, 2, 4, 8, 16, 32, 64), "spatial": (1, 5, 16, 64)}
PEERS = ("heyoka", "casadi", "pinocchio", "mujoco")
STATES = 256


def peer_candidates(chain: Chain, folder: Path, names: Sequence[str]) -> list[Candidate]:
    """The peers by name; a peer is imported only when it is asked for."""
    found: list[Candidate] = []
    for name in names:
        found += _BUILDERS[name](chain, folder)
    return found


def _heyoka(chain: Chain, folder: Path) -> list[Candidate]:
    from benchmarks.peers import heyoka_cfunc

    plain = [heyoka_cfunc.build(chain, folder, slp=slp) for slp in (False, True)]
    if chain.space == "planar" or chain.links < 3:
        return plain
    return [*plain, *(heyoka_cfunc.build(chain, folder, twisted=True, slp=slp) for slp in (False, True))]


def _casadi(chain: Chain, folder: Path) -> list[Candidate]:
    from benchmarks.peers import casadi_recursion

    forms = (False,) if chain.space == "planar" or chain.links < 3 else (False, True)
    return [casadi_recursion.build(chain, folder, twisted=twisted) for twisted in forms]


def _pinocchio(chain: Chain, folder: Path) -> list[Candidate]:
    from benchmarks.peers import pinocchio_aba

    return [pinocchio_aba.build(chain, folder)]


def _mujoco(chain: Chain, folder: Path) -> list[Candidate]:
    from benchmarks.peers import mujoco_forward

    return [mujoco_forward.build(chain, folder)]


_BUILDERS: dict[str, Callable[[Chain, Path], list[Candidate]]] = {
    "heyoka": _heyoka,
    "casadi": _casadi,
    "pinocchio": _pinocchio,
    "mujoco": _mujoco,
}


def compare(chain: Chain, candidates: Sequence[Candidate], rounds: int) -> list[Timing]:
    """Times and errors of all candidates on one chain."""
    states = random_states(chain, STATES)
    arena = Arena(chain, candidates, states)
    # the dense reference costs the cube of the size: fewer states where the chain is long
    checked = max(2, min(32, 256 // chain.nv))
    reference = np.array([accelerations(chain, state) for state in states[:checked]])
    errors = [relative_error(arena.evaluate(i, checked), reference) for i in range(len(candidates))]
    return arena.timings(rounds, errors)


def as_table(chain: Chain, timings: Sequence[Timing]) -> table.Table:
    """One chain's comparison, fastest first."""
    rows = tuple(
        (
            t.name if t.peer else f"**{t.name}**",
            f"{t.median:.1f}",
            f"{t.minimum:.1f}",
            "-" if t.ratio is None else f"{t.ratio:.2f}",
            f"{t.error:.1e}",
        )
        for t in sorted(timings, key=lambda t: t.median)
    )
    return table.Table(chain.label, ("", "ns, median", "ns, least", "x best peer", "relative error"), rows)


def measure(chain: Chain, options: argparse.Namespace) -> list[Timing]:
    """Builds everything for one chain in a scratch folder and compares it."""
    with tempfile.TemporaryDirectory(prefix="phichain-bench-") as scratch:
        folder = Path(scratch)
        candidates = [
            ours.candidate_from_c(Path(source), symbol, f"{Path(source).name}: {symbol}", folder)
            for source, symbol in zip(options.candidate_c, options.symbol, strict=True)
        ]
        if not candidates:
            candidates = [ours.build(chain, folder, code) for code in options.code]
        candidates += peer_candidates(chain, folder, options.peers)
        return compare(chain, candidates, options.rounds)


def parser() -> argparse.ArgumentParser:
    """The command line."""
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--space", nargs="+", choices=tuple(SIZES), default=list(SIZES))
    p.add_argument("--links", nargs="+", type=int, help="default: 1 .. 64")
    p.add_argument("--unforced", action="store_true", help="no input u: symbols are called as f(q, v, a)")
    p.add_argument("--peers", nargs="*", choices=PEERS, default=["heyoka", "casadi"])
    p.add_argument("--code", nargs="+", choices=("auto", "unrolled", "loops"), default=["auto"])
    p.add_argument("--candidate-c", action="append", default=[], metavar="FILE.c", help="instead of phichain's own; may repeat")
    p.add_argument("--symbol", action="append", default=[], help="the function in each --candidate-c")
    p.add_argument("--rounds", type=int, default=201)
    p.add_argument("--write", action="store_true", help="write benchmarks/results/forward_dynamics.md")
    return p


def main(arguments: Sequence[str] | None = None) -> int:
    options = parser().parse_args(arguments)
    if len(options.candidate_c) != len(options.symbol):
        parser().error("give one --symbol for every --candidate-c")
    tables = []
    for space in options.space:
        for links in options.links or SIZES[space]:
            chain = chain_of(space, links, not options.unforced)
            tables.append(as_table(chain, measure(chain, options)))
            print(tables[-1].markdown(), flush=True)
    if options.write:
        command = "python -m benchmarks.forward_dynamics " + " ".join(sys.argv[1:] if arguments is None else arguments)
        print(table.write("forward_dynamics", "Forward dynamics", tables, command.strip()))
    return 0


if __name__ == "__main__":
    sys.exit(main())
