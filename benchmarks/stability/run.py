"""Stiff and extreme cases: every method on every case, each in a process of its own, judged against references.

Examples::

    python -m benchmarks.stability --quick
    python -m benchmarks.stability --cases B10 S17 --methods taylor auto
    python -m benchmarks.stability --write
"""

from __future__ import annotations

import argparse
import dataclasses
import sys
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from benchmarks.campaign import digest
from benchmarks.stability import others, ours
from benchmarks.stability.apart import run_apart
from benchmarks.stability.cases.case import Case
from benchmarks.stability.cases.table import all_cases
from benchmarks.stability.horizon import words
from benchmarks.stability.references import Reference, references
from benchmarks.stability.report import Result, markdown_tables, page
from benchmarks.stability.store import done, keep, kept
from benchmarks.stability.verdict import WRONG, Answer, judge
from benchmarks.table import write
from phichain import build
from phichain.errors import PhichainError

STORE = "stability.json"

Work = tuple[tuple[Case, str, bool], Callable[[], Answer]]


def work_on(case: Case, known: Reference, options: argparse.Namespace) -> tuple[list[Work], list[Result]]:
    """What is to be run on a case; a chain that does not build is refused at once."""
    peers = others.DYNAMICS if case.kind == "dynamics" else others.MOTION
    work: list[Work] = []
    if not options.no_peers and case.real == "double" and case.kind != "energy":
        peers, _ = others.installed(peers)
        work += [
            ((case, name, False), partial(others.answer, peer, case, known)) for name, peer in peers.items()
        ]
    try:
        system = build(case.scene())
    except PhichainError as refusal:
        answer = Answer("refused", said=str(refusal))
        judged = judge(answer, known.kappa, case.round_off)
        return work, [Result(case, "build", True, answer, judged, words(case, known))]
    if case.kind == "dynamics":
        mine: list[Work] = [
            ((case, "forward_dynamics", True), partial(ours.accelerations, case, system, known))
        ]
    else:
        mine = [
            ((case, method.label, True), partial(ours.answer, case, system, method, known))
            for method in ours.methods(options.quick)
        ]
    work = [*mine, *work]
    return [
        entry for entry in work if not options.methods or entry[0][1].split(",")[0] in options.methods
    ], []


def run(options: argparse.Namespace) -> list[Result]:
    """All results, in the order of the cases."""
    known, source = references(), digest()
    before = done(options.out / STORE, source) if options.resume else set()
    chosen = [
        c for c in all_cases() if (c.id in options.cases if options.cases else not (options.quick and c.slow))
    ]
    results = []
    for case in chosen:
        if case.id not in known:
            print(f"{case.id}: no reference yet; python -m benchmarks.stability.make_references", flush=True)
            continue
        work, refused = work_on(case, known[case.id], options)
        work = [entry for entry in work if (case.id, entry[0][1]) not in before]
        found = list(refused)
        for ended in run_apart(work, options.seconds, options.jobs):
            answer = ended.result if ended.result is not None else Answer("unfinished", said=ended.failure)
            if answer.status == others.ABSENT:
                continue
            answer = dataclasses.replace(answer, seconds=ended.seconds)
            _, name, own = ended.key
            judged = judge(answer, known[case.id].kappa, case.round_off)
            found.append(Result(case, name, own, answer, judged, words(case, known[case.id])))
        order = [key[1] for key, _ in work]
        found.sort(key=lambda result: order.index(result.method) if result.method in order else -1)
        for result in found:
            print(result.line(), flush=True)
        keep(options.out / STORE, found, source)
        results += found
    return results


def _order() -> list[str]:
    """Methods as a table lists them."""
    return [
        "forward_dynamics",
        *(method.label for method in ours.methods(False)),
        *others.DYNAMICS,
        *others.MOTION,
    ]


def parser() -> argparse.ArgumentParser:
    """The command line."""
    p = argparse.ArgumentParser(
        prog="python -m benchmarks.stability",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    p.add_argument(
        "--quick", action="store_true", help="the methods that matter most, no long cases, 2 s each"
    )
    p.add_argument("--cases", nargs="*", default=[], metavar="ID")
    p.add_argument(
        "--methods", nargs="*", default=[], metavar="NAME", help="by the first word of their label"
    )
    p.add_argument("--no-peers", action="store_true")
    p.add_argument("--seconds", type=float, help="time limit of one run; 5, or 2 in a quick run")
    p.add_argument("--jobs", type=int, default=2)
    p.add_argument(
        "--keep", action="store_true", help="take over earlier results for whatever is not run again"
    )
    p.add_argument(
        "--resume", action="store_true", help="go on with an interrupted run of the same code, and keep what it has"
    )
    p.add_argument("--write", action="store_true", help="write benchmarks/results/stability.md")
    p.add_argument(
        "--out", type=Path, default=Path("generated/report"), help="folder of the overview (HTML and PNG)"
    )
    return p


def main(arguments: Sequence[str] | None = None) -> int:
    given = list(sys.argv[1:] if arguments is None else arguments)
    options = parser().parse_args(given)
    options.seconds = options.seconds or (2.0 if options.quick else 5.0)
    begin = time.perf_counter()
    if not options.keep and not options.resume:
        (options.out / STORE).unlink(missing_ok=True)
    results = run(options)
    if options.keep or options.resume:
        results = kept(options.out / STORE, all_cases(), references(), _order())
    command = " ".join(["python -m benchmarks.stability", *given])
    absent = others.installed(others.DYNAMICS | others.MOTION)[1]
    for line in absent:
        print(line)
    tables = markdown_tables(results, options.seconds, absent)
    if options.write:
        taken = sum(result.answer.seconds for result in results)
        print(write("stability", "Stiff and extreme cases", tables, command, seconds=taken))
        (options.out / STORE).unlink(missing_ok=True)
    print(page(results, options.out, command))
    wrong = [result for result in results if result.own and result.judgement.verdict == WRONG]
    print(
        f"{len(results)} runs in {time.perf_counter() - begin:.0f} s; silently wrong among ours: {len(wrong)}"
    )
    for result in wrong:
        print(f"  {result.line()}")
    return 0
