"""Studies: what a task costs beside its computing, what a store saves, and a million trajectories."""

from __future__ import annotations

import resource
import sys
from pathlib import Path
from typing import Any

from benchmarks.front_door.processes import clean, megabytes, run
from benchmarks.harness import BenchmarkError
from benchmarks.plan import Plan
from benchmarks.table import Table
from phichain import study

ROOT = Path(__file__).resolve().parents[2]
KILLED = "tests/studies/test_cluster.py::test_a_killed_worker_costs_no_result"


def _plan(name: str, task: str, count: int) -> dict[str, Any]:
    """Paper A's four links for a second, from `count` squared places."""
    angles = {"from": -1.0, "to": 1.0, "count": count}
    return {"name": name, "scene": "planar4", "task": {"run": task, "t": 1.0, "q": [0.0] * 4}, "grid": {"task.q[1]": angles, "task.q[2]": angles}}


def table(scratch: Path, plan: Plan) -> Table:
    """Overheads and sizes."""
    small, large = (4, 10) if plan.tiny else (100, 1000)
    for task in ("simulate", "propagate"):
        study(_plan("compiled", task, 2), scratch / f"compiled_{task}.zarr", workers=2)
    single = study(_plan("tasks", "simulate", small), scratch / "tasks.zarr", workers=2)
    again = study(_plan("tasks", "simulate", small), scratch / "tasks.zarr", workers=2)
    many = study(_plan("trajectories", "propagate", large), scratch / "trajectories.zarr", workers=2)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (1e6 if sys.platform == "darwin" else 1e3)
    count = single.computed
    rows = (
        (f"{count} tasks of `simulate`, N = 4: beyond the computing, a task", f"{1e3 * single.overhead:.2f} ms", "2 ms"),
        ("their computing, a task", f"{1e3 * single.busy / count:.2f} ms", "-"),
        ("the same study again", f"{again.found} found, {again.computed} computed", "recomputes nothing"),
        ("a worker of a scheduler killed on the way", _killed(scratch), "costs no result"),
        (f"{many.computed} trajectories of `propagate`, N = 4, in one study", f"{many.seconds:.0f} s, {len(many.failures)} failed", "10^6 on this machine"),
        ("a trajectory: computing; everything else", f"{1e3 * many.busy / many.computed:.3f} ms; {1e3 * many.overhead:.4f} ms", "-"),
        ("the store; the process that hands out, at most", f"{megabytes(scratch / 'trajectories.zarr'):.0f} MB; {peak:.0f} MB", "-"),
    )
    notes = (("Two workers, each a process; a second of motion of paper A's chain from rest. Beyond the computing: two workers' time by the clock less what they"
             " computed in, over the tasks."),)  # fmt: skip
    return Table("Studies", ("what", "measured", "reach"), rows, notes)


def _killed(scratch: Path) -> str:
    """The test of a scheduler with two workers, one of which is killed."""
    environment = clean(PYTHONPATH=f"{ROOT / 'codegen'}:{ROOT}", PHICHAIN_CACHE=str(scratch / "cache"))
    try:
        run([sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", KILLED], ROOT, environment)
    except BenchmarkError as failure:
        return f"failed: {failure}"
    return "all results there, none computed twice"
