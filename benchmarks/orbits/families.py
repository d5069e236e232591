"""One family of limit cycles, theirs and ours: mode 1 of paper A's double pendulum from 0.01 rad to theta_1 = -2.5, through both folds.

    python -m benchmarks.orbits.families [--tiny] [--write]

Processor time of whole runs in turn. Ours computes every orbit's multipliers and locates fifteen events; *the flow calls alone* are the very calls of
the emitted flow that it made, once more, and nothing else, each from Python, which is some 2 us of it: what is above that is all that is not the flow. AUTO-07p starts as a program of its own, which
costs it a few milliseconds; it computes what its form says. omega at theta_1 = 1.2 is judged by `tests/data/limit_cycles.json`, at the end by
T = 2.27931277388 s of a quadruple-precision integration, which has twelve digits.
"""

from __future__ import annotations

import json
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.orbits import auto
from benchmarks.plan import Plan, command
from benchmarks.table import Table
from phichain.continuation import Branch
from phichain.orbits import pick, trace
from phichain.pipeline import build
from phichain.scene import Scene
from phichain.system import System

HEADING = "A family of limit cycles, beside AUTO-07p"
UNTIL = "theta_1=-2.5"
CYCLES = Path(__file__).resolve().parents[2] / "tests" / "data" / "limit_cycles.json"
MESHES = {"quarter": ((15, 5, 1.0), (20, 6, 1.0), (20, 6, 0.2)), "periodic": ((60, 5, 1.0), (60, 5, 0.2), (100, 6, 0.2))}
"""Intervals, collocation points and largest steps of AUTO's runs, cheapest first."""
WORDS = {"quarter": "quarter period, no multipliers", "periodic": "periodic orbit, multipliers"}


Outcome = tuple[float, tuple[float, float], int]
LAST = 2.27931277388
"""T at theta_1 = -2.5, s."""


@dataclass(frozen=True)
class Runner:
    """What takes part: a name, whether it computes multipliers, and a run: () -> (seconds, periods at 1.2 and at the end, points)."""

    name: str
    has_multipliers: bool
    run: Callable[[], Outcome]


def tables(plan: Plan) -> list[Table]:
    """The table, without AUTO's rows where it is missing, which is said."""
    system = double()
    with tempfile.TemporaryDirectory() as folder:
        runners, absent = [_ours(system), _flows(system)], auto.missing()
        if not absent:
            program = auto.compiled(Path(folder))
            for form, meshes in MESHES.items():
                runners += [_auto(program, form, *mesh) for mesh in plan.few(meshes)]
        return [_table(runners, 2 if plan.tiny else max(5, plan.rounds // 4), absent)]


def double() -> System:
    """Paper A's double pendulum with a flow that carries derivatives."""
    want = ("propagate", "mass_matrix", "energy", "forward_dynamics")
    return build(Scene("double_pendulum", 2, mass=0.5, length=0.5, com=0.25, actuated="none", want=want, variational=True))


def _table(runners: Sequence[Runner], rounds: int, absent: str) -> Table:
    seconds = np.empty((rounds, len(runners)))
    periods, points = np.empty((len(runners), 2)), [0] * len(runners)
    for turn in range(rounds):
        for place in range(len(runners)):
            k = (place + turn) % len(runners)
            seconds[turn, k], periods[k], points[k] = runners[k].run()
    errors = np.abs(np.array([_reference(), LAST]) / periods - 1)
    rows = []
    for k, runner in enumerate(runners):
        low, middle, high = np.percentile(seconds[:, 0] / seconds[:, k], (25, 50, 75))
        shown = ["" if np.isnan(error) else f"{error:.1e}" for error in errors[k]]
        rows.append((
            runner.name, "yes" if runner.has_multipliers else "no", str(points[k]), *shown, f"{1e3 * np.median(seconds[:, k]):.1f}",
            f"{middle:.3g} [{low:.3g}, {high:.3g}]",
        ))  # fmt: skip
    notes = [
        "AUTO-07p writes eleven digits: its errors below 4e-11 are those of its file. *15 x 5* are intervals and collocation points of its mesh.",
        "*At most* is its largest step, in its own norm.",
        *([f"skipped: AUTO-07p, for {absent}."] if absent else []),
    ]
    columns = ("run", "multipliers", "points", "error of omega at 1.2", "at the end", "processor ms", "our time / its")
    return Table("N = 2, mode 1, from 0.01 rad to theta_1 = -2.5", columns, tuple(rows), tuple(notes))


def _reference() -> float:
    """T of the orbit at theta_1 = 1.2, s."""
    points = json.loads(CYCLES.read_text())["points"]
    return float(next(c["period"] for c in points if c["N"] == 2 and c["mode"] == 1 and float(c["theta0"][0]) == 1.2))


def _ours(system: System) -> Runner:
    def run() -> Outcome:
        begin = time.process_time()
        branch = _followed(system)
        seconds = time.process_time() - begin
        early = pick(system, branch, "theta_1=1.2", samples=2)
        return seconds, (early.period, 2 * np.pi / float(branch.points[-1, -1])), len(branch)

    return Runner("phichain, shooting over a quarter period", True, run)


def _followed(system: System) -> Branch:
    return trace(system, 1, until=UNTIL)


class _NotedBrake:
    """Compiled brake orbits that write down what they ask of the flow."""

    def __init__(self, brake: Any, evaluations: list[list[float]]) -> None:
        self._brake, self._evaluations = brake, evaluations

    def __getattr__(self, name: str) -> Any:
        return getattr(self._brake, name)

    def another(self) -> _NotedBrake:
        return _NotedBrake(self._brake.another(), self._evaluations)

    def at(self, *words: Any) -> Any:
        return self._told(self._brake.at(*words))

    def corrected(self, *words: Any) -> Any:
        return self._told(self._brake.corrected(*words))

    def settled(self, *words: Any) -> Any:
        return self._told(self._brake.settled(*words))

    def ahead(self, *words: Any) -> Any:
        return self._told(self._brake.ahead(*words))

    def run(self, *words: Any) -> Any:
        return self._told(self._brake.run(*words))

    def zero(self, *words: Any) -> Any:
        return self._told(self._brake.zero(*words))

    def places(self, *words: Any) -> Any:
        return self._told(self._brake.places(*words))

    def _told(self, found: Any) -> Any:
        asked = self._brake.asked
        assert self._brake.desk["evaluations"] == len(asked)  # none is left out
        self._evaluations += asked
        return found


class _Noted:
    """The emitted flow that writes down what it is asked for, by families or plainly."""

    def __init__(self, flow: Any, nq: int) -> None:
        self._flow, self._identity = flow, np.eye(2 * nq)
        self._evaluations: list[list[float]] = []
        self._plain: list[tuple[tuple[Any, ...], dict[str, Any]]] = []
        self._bound: dict[tuple[float, float], Any] = {}

    def __call__(self, *words: Any, **more: Any) -> Any:
        self._plain.append((words, more))
        return self._flow(*words, **more)

    def brake(self, *words: Any, **more: Any) -> _NotedBrake:
        return _NotedBrake(self._flow.brake(*words, **more), self._evaluations)

    def __len__(self) -> int:
        return len(self._evaluations) + len(self._plain)

    def repeat(self) -> None:
        """Every call once more."""
        for *start, omega, tolerance, columns in self._evaluations:
            bound = self._bound.get((tolerance, columns))
            if bound is None:
                bound = self._bound[tolerance, columns] = self._flow.bind(tolerance, columns=int(columns), max_steps=20_000)
            bound.q[:], bound.v[:] = start, 0.0
            if columns:
                bound.transition[:] = self._identity[:, : int(columns)]
            bound(0.0, np.pi / (2 * omega))
        for words, more in self._plain:
            self._flow(*words, **more)


def _flows(system: System) -> Runner:
    noted = _Noted(system.function("propagate"), system.nq)
    branch = _followed(replace(system, functions={**system.functions, "propagate": noted}))
    assert len(noted) > len(branch)  # no point comes without a call
    noted.repeat()

    def run() -> Outcome:
        begin = time.process_time()
        noted.repeat()
        return time.process_time() - begin, (float("nan"), float("nan")), len(noted)

    return Runner("the flow calls alone (points: calls)", True, run)


def _auto(program: Path, form: str, ntst: int, ncol: int, ds_max: float) -> Runner:
    def run() -> Outcome:
        found = auto.run(program, form, ntst, ncol, ds_max=ds_max)
        return found.seconds, (found.early, found.late), found.points

    return Runner(f"AUTO-07p, {WORDS[form]}, {ntst} x {ncol}, steps at most {ds_max:g}", form == "periodic", run)


def main(arguments: Sequence[str] | None = None) -> int:
    return command("families", "benchmarks.orbits.families", HEADING, tables, arguments, __doc__)


if __name__ == "__main__":
    sys.exit(main())
