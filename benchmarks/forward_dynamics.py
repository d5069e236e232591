"""Forward dynamics: time and error per evaluation, phichain beside its peers, from C in one process.

Examples::

    python -m benchmarks.forward_dynamics
    python -m benchmarks.forward_dynamics --space planar --links 2 4 8
    python -m benchmarks.forward_dynamics --space planar --links 8 --candidate-c trial.c --symbol trial
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

    found = [heyoka_cfunc.build(chain, folder, slp=slp) for slp in (False, True)]
    return found + [heyoka_cfunc.build(chain, folder, form) for form in _other_forms(chain)]


def _casadi(chain: Chain, folder: Path) -> list[Candidate]:
    from benchmarks.peers import casadi_recursion

    found = [casadi_recursion.build(chain, folder, slp=slp) for slp in (True, False)]
    return found + [casadi_recursion.build(chain, folder, form) for form in _other_forms(chain)]


def _pinocchio(chain: Chain, folder: Path) -> list[Candidate]:
    if not _is_plain_planar(chain):
        return []
    from benchmarks.peers import pinocchio_aba

    return [pinocchio_aba.build(chain, folder)]


def _mujoco(chain: Chain, folder: Path) -> list[Candidate]:
    if not _is_plain_planar(chain):
        return []
    from benchmarks.peers import mujoco_forward

    return [mujoco_forward.build(chain, folder)]


def _other_forms(chain: Chain) -> list[str]:
    """Spatial forms beside the plain tension form; below three tensions both ends are one."""
    if chain.space == "planar":
        return []
    return ["recursion", "twisted"] if chain.links > 2 else ["recursion"]


def _is_plain_planar(chain: Chain) -> bool:
    """Whether Pinocchio and MuJoCo are compared: on the sphere neither has a joint that is free of poles."""
    return chain.space == "planar" and chain.forced


_LEGEND = table.Table(
    "What the rows are",
    ("row", "code"),
    (
        ("**bold**", "phichain's emitted C"),
        ("heyoka cfunc", "an expert's O(N) recursion, fast_math; slp: with LLVM's superword vectoriser"),
        (
            "CasADi",
            "the same recursion, emitted by CasADi, our compiler flags; no slp: without gcc's superword vectoriser",
        ),
        ("*italic*", "a formula of ours (elimination from both ends) in a peer's compiler: no yardstick"),
        ("Pinocchio, MuJoCo", "their own algorithms, called from C"),
    ),
    (
        f"{STATES} random states, candidates in turn, each sample about 0.2 ms; ratios are formed round by"
        + " round. The best peer is the fastest row that is neither bold nor italic.",
    ),
)
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
            _label(t.name, t.kind),
            f"{t.median:.1f}",
            f"{t.minimum:.1f}",
            "-" if t.ratio is None else f"{t.ratio:.2f}",
            f"{t.error:.1e}",
        )
        for t in sorted(timings, key=lambda t: t.median)
    )
    return table.Table(chain.label, ("", "ns, median", "ns, least", "x best peer", "relative error"), rows)


def summary(space: str, results: Sequence[tuple[Chain, Sequence[Timing]]]) -> list[table.Table]:
    """Sizes side by side: times, ratios to the best peer, errors."""
    found: dict[str, str] = {t.name: t.kind for _, timings in results for t in timings}
    heads = tuple(str(chain.links) for chain, _ in results)
    views: tuple[tuple[str, Callable[[Timing], str]], ...] = (
        ("ns per evaluation, median", lambda t: f"{t.median:.1f}"),
        ("time over the best peer's", lambda t: "-" if t.ratio is None else f"{t.ratio:.2f}"),
        ("largest relative error", lambda t: f"{t.error:.0e}"),
    )
    tables = []
    for title, cell in views:
        rows: list[tuple[str, ...]] = []
        for name, kind in found.items():
            by_size = [next((cell(t) for t in timings if t.name == name), "-") for _, timings in results]
            rows.append((_label(name, kind), *by_size))
        tables.append(table.Table(f"{space.capitalize()}: {title}", ("N =", *heads), tuple(rows)))
    return tables


def _label(name: str, kind: str) -> str:
    return {"ours": f"**{name}**", "hybrid": f"*{name}*"}.get(kind, name)


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
    p.add_argument(
        "--candidate-c", action="append", default=[], metavar="FILE.c", help="not phichain's own but this"
    )
    p.add_argument("--symbol", action="append", default=[], help="the function in each --candidate-c")
    p.add_argument("--rounds", type=int, default=201)
    p.add_argument("--write", action="store_true", help="write benchmarks/results/forward_dynamics.md")
    return p


def main(arguments: Sequence[str] | None = None) -> int:
    given = list(sys.argv[1:] if arguments is None else arguments)
    options = parser().parse_args(given)
    if len(options.candidate_c) != len(options.symbol):
        parser().error("give one --symbol for every --candidate-c")
    tables: list[table.Table] = []
    for space in options.space:
        results = []
        for links in options.links or SIZES[space]:
            chain = chain_of(space, links, not options.unforced)
            results.append((chain, measure(chain, options)))
            print(as_table(*results[-1]).markdown(), flush=True)
        tables += summary(space, results)
    if options.write:
        command = " ".join(["python -m benchmarks.forward_dynamics", *given])
        print(table.write("forward_dynamics", "Forward dynamics, timed from C", [*tables, _LEGEND], command))
    return 0


if __name__ == "__main__":
    sys.exit(main())
