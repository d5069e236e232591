"""One function of one chain: everybody's compiled code over the same states, independent and chained."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.chains import Chain, random_states
from benchmarks.contest import Entry, Work, entries, line
from benchmarks.harness import Arena, BenchmarkError, Candidate
from benchmarks.peers import present, recursions
from benchmarks.plan import Plan
from benchmarks.reference import accelerations, jacobian, relative_error

Builder = Callable[[Chain, Path], list[Candidate]]


@dataclass(frozen=True)
class Pair:
    """The two ways to time one function: evaluations that overlap, and evaluations that wait for each other."""

    independent: Work
    chained: Work


def compare(
    title: str, chain: Chain, builders: Sequence[tuple[str, Builder]], folder: Path, plan: Plan, reach: str = "",
    is_jacobian: bool = False,
) -> Pair:  # fmt: skip
    """Build everybody who can be built, hold every answer against the dense Lagrangian at 40 digits, time both ways."""
    candidates: list[Candidate] = []
    skipped: list[Entry] = []
    for name, build in builders:
        try:
            candidates += build(chain, folder)
        except BenchmarkError as reason:
            skipped.append(Entry(name, note=f"skipped: {reason}"))
    states = random_states(chain, plan.states)
    outputs = chain.nv * (chain.nq + chain.nv) if is_jacobian else chain.nv
    arena = Arena(chain, candidates, states, outputs)
    exact, checked = (jacobian, 8 // chain.nv) if is_jacobian else (accelerations, min(32, 256 // chain.nv))
    checked = min(max(1, checked), len(states))
    reference = np.array([exact(chain, state) for state in states[:checked]])
    errors = [relative_error(arena.evaluate(i, checked), reference) for i in range(len(candidates))]
    names, kinds = [c.name for c in candidates], [c.kind for c in candidates]
    works = [
        Work(title, (*entries(names, kinds, 1e-9 * arena.measure(plan.rounds, chained), errors), *skipped), "ns", reach)
        for chained in (False, True)
    ]
    for kind, work in zip(("independent", "chained"), works, strict=True):
        print(f"{line(work)}  [{kind}]", flush=True)
    return Pair(*works)


def heyoka(chain: Chain, folder: Path) -> list[Candidate]:
    """Its cfunc in every form, with and without its superword vectoriser."""
    peer = present.module("benchmarks.peers.heyoka.cfunc")
    first, *others = recursions.forms(chain)
    return [peer.build(chain, folder, first, slp) for slp in (False, True)] + [
        peer.build(chain, folder, form) for form in others
    ]


def casadi(chain: Chain, folder: Path) -> list[Candidate]:
    """Its emitted C in every form, with and without gcc's superword vectoriser."""
    peer = present.module("benchmarks.peers.casadi_recursion")
    first, *others = recursions.forms(chain)
    return [peer.build(chain, folder, first, slp) for slp in (True, False)] + [
        peer.build(chain, folder, form, slp=False) for form in others
    ]


def casadi_jacobian(chain: Chain, folder: Path) -> list[Candidate]:
    """Its Jacobian of its best form, emitted; without gcc's superword vectoriser, which takes minutes on it."""
    return [present.module("benchmarks.peers.casadi_recursion").build(chain, folder, slp=False, jacobian=True)]


def pinocchio(chain: Chain, folder: Path) -> list[Candidate]:
    """Its aba."""
    return [present.module("benchmarks.peers.pinocchio_aba").build(chain, folder)]


def pinocchio_jacobian(chain: Chain, folder: Path) -> list[Candidate]:
    """Its derivatives of aba."""
    return [present.module("benchmarks.peers.pinocchio_aba").build(chain, folder, jacobian=True)]


def mujoco(chain: Chain, folder: Path) -> list[Candidate]:
    """Its minimal pipeline."""
    return [present.module("benchmarks.peers.mujoco_forward").build(chain, folder)]
