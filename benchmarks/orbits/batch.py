"""Families of chains drawn at random, each traced with two step limits: no jump, no crash, every end with a reason.

    python -m benchmarks.orbits.batch --seed 7 --cases 100
    python -m benchmarks.orbits.batch --seed 7 --cases 100 --write    # and a table under benchmarks/results

Chains of one to five links, on a wall or a cart, with centres of mass, springs and inertia; a mode of each is followed to a largest angle drawn
as well. Where both runs claim the target their last orbits have to agree; where one ends before, it has to say why. Where only one has come
to its end within its points the other goes on until it has, too.
"""

from __future__ import annotations

import argparse
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from functools import lru_cache
from typing import Any

import numpy as np

from benchmarks.table import Table, write
from phichain.continuation import Branch
from phichain.errors import PhichainError
from phichain.orbits import trace
from phichain.pipeline import build
from phichain.scene import Scene
from phichain.system import System

STEPS = (0.1, 0.03)
AGREE = 1e-9
POINTS = 600
MORE = 3
"""How often a run goes on whose fellow has ended."""
R = "runtime"
NOTE = (
    f"Steps of at most {STEPS[0]} and {STEPS[1]}. In order is a case whose last orbits agree within {AGREE:g} where both runs claim the target, or whose "
    "runs say why they ended short of it, having met the same events on the way; with 600 points a run that has not come to an end says so."
)


@lru_cache
def chain(links: int, on_cart: bool) -> System:
    """One compiled chain for all numbers."""
    base: dict[str, Any] = {"base": "cart", "cart_mass": R} if on_cart else {}
    return build(
        Scene(f"batch{links}{'c' * on_cart}", links, mass=R, length=R, com=R, inertia=R, stiffness=R, variational=True,
              want=("propagate", "mass_matrix", "energy"), **base)
    )  # fmt: skip


def drawn(rng: np.random.Generator) -> tuple[System, dict[str, Any], int, float]:
    """A chain, its numbers, a mode and the largest angle to follow it to."""
    links, on_cart = int(rng.integers(1, 6)), bool(rng.integers(2))
    length = rng.uniform(0.2, 1.0, links)
    p: dict[str, Any] = {
        "mass": rng.uniform(0.1, 2.0, links), "length": length, "com": length * rng.uniform(0.3, 1.0, links),
        "inertia": rng.uniform(0.0, 0.02, links) * rng.integers(2), "stiffness": rng.uniform(0.0, 2.0, links) * rng.integers(2),
    }  # fmt: skip
    if on_cart:
        p["cart_mass"] = float(rng.uniform(0.2, 3.0))
    return chain(links, on_cart), p, int(rng.integers(1, links + 1)), float(rng.uniform(0.2, 1.6))


def judged(system: System, p: dict[str, Any], mode: int, amplitude: float) -> tuple[bool, str]:
    """Whether a case is in order, and what is to be said of it."""
    runs: list[Branch] = []
    for longest in STEPS:
        try:
            found = trace(system, mode, p=p, until=f"amplitude={amplitude}", limits={"step_max": longest, "max_points": POINTS})
        except PhichainError as refused:
            return bool(refused.problem), f"refused: {refused}"
        assert isinstance(found, Branch)
        runs.append(found)
    for _ in range(MORE):
        if len({run.status == "points" for run in runs}) == 1:
            break
        runs = [run if run.status != "points" else _gone_on(system, p, mode, amplitude, run, step) for run, step in zip(runs, STEPS, strict=True)]
    wanted = f"amplitude = {amplitude!r}"
    reached = [run.status == "event" and run.events[-1].kind == wanted for run in runs]
    reasons = " | ".join(run.reason for run in runs)
    if not all(run.reason for run in runs):
        return False, "an end without a reason"
    if any(reached) and any(run.status == "event" and not there and not run.passages for run, there in zip(runs, reached, strict=True)):
        return False, reasons
    if not all(reached):
        # An end short of the target is said; the way until there is to be one.
        return _one_way(*runs), reasons
    apart = float(np.max(np.abs(runs[0].points[-1] - runs[1].points[-1]) / runs[0].scale))
    error = max(float(run.error[-1]) for run in runs if run.error is not None)
    return apart < AGREE + 100 * error, f"{len(runs[0])} and {len(runs[1])} points, {apart:.1e} apart"


def _gone_on(system: System, p: dict[str, Any], mode: int, amplitude: float, run: Branch, step: float) -> Branch:
    """A run with as many points more."""
    found = trace(system, mode, p=p, until=f"amplitude={amplitude}", resume=run, limits={"step_max": step, "max_points": POINTS})
    assert isinstance(found, Branch)
    return found


def _one_way(one: Branch, other: Branch) -> bool:
    """Whether two runs met the same events, as far as the shorter one goes, gaps apart."""
    end = min(one.arclength[-1], other.arclength[-1])
    kinds = [[event.kind for event in run.events if event.arclength < 0.98 * end] for run in (one, other)]
    return kinds[0] == kinds[1] or bool(one.passages or other.passages)


def case(seed: np.random.SeedSequence) -> tuple[str, int, float, bool, str]:
    """One case: chain, mode, end, whether it is in order, and what is to be said of it."""
    system, p, mode, amplitude = drawn(np.random.default_rng(seed))
    return system.name, mode, amplitude, *judged(system, p, mode, amplitude)


def main(words: list[str] | None = None) -> int:
    """Every case in a line; 1 where one is not in order."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--seed", type=int, default=1)
    options.add_argument("--cases", type=int, default=100)
    options.add_argument("--first", type=int, default=0, help="the case to begin with")
    options.add_argument("--jobs", type=int, default=1, help="cases at a time, each a process")
    options.add_argument("--write", action="store_true", help="write the table")
    asked = options.parse_args(words)
    bad, rows, began = 0, [], time.perf_counter()
    seeds = np.random.SeedSequence(asked.seed).spawn(asked.cases)[asked.first :]
    with ProcessPoolExecutor(asked.jobs) as pool:
        for number, (name, mode, amplitude, is_right, said) in enumerate(pool.map(case, seeds), asked.first):
            bad += not is_right
            rows.append((f"{number}", name.removeprefix("batch"), str(mode), f"{amplitude:.4f}", "yes" if is_right else "NO", said.replace("|", ";")))
            print(f"{number:3} {name} mode {mode} to {amplitude:.4f}: {'' if is_right else 'NOT IN ORDER: '}{said}", flush=True)
    counted = f"{len(seeds) - bad} of {len(seeds)} in order"
    print(counted)
    if asked.write:
        command = f"python -m benchmarks.orbits.batch --seed {asked.seed} --cases {asked.cases} --write"
        table = Table(counted, ("case", "links (c: cart)", "mode", "to, rad", "in order", "what two step limits say"), tuple(rows), (NOTE,))
        write("families_at_random", "Families of chains drawn at random", [table], command, seconds=time.perf_counter() - began)
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main())
