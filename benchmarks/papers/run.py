"""Both papers' runs, error against time: computed torque (A, Fig. 2), the chain left alone (B, Fig. 2), gains of (22).

Examples::

    python -m benchmarks.papers
    python -m benchmarks.papers --write
    python -m benchmarks.papers --quick      # a few tolerances, to see that it runs
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

if __package__ in (None, ""):  # started as a file
    sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from benchmarks import plan, table
from benchmarks.fractional.powers import fastest
from benchmarks.papers.regulators import gains_table
from phichain.control import computed_torque, in_phase
from phichain.motion import simulate
from phichain.papers.figures import FIG_2, paper_a_chain
from phichain.pipeline import build
from phichain.scene.library import find_scene
from phichain.system import System, pack, rhs

HEADING = "Both papers' runs"
Vector = NDArray[np.float64]
Run = Callable[[], Vector]
"""One run; its result is the states at the output times, (m, nx)."""

MOTION = ([0.5, 0.3, -0.2], 3.0)
SECONDS = 6.0


@dataclass(frozen=True)
class Row:
    """One method at one tolerance.

    Attributes:
        method: Its name; ours begin with "phichain".
        setting: Its tolerance or step.
        error: What the table says an error is.
        seconds: Least processor time.
        more: Further cells.
    """

    method: str
    setting: str
    error: float
    seconds: float
    more: tuple[str, ...] = ()


def rows_of(
    runs: Iterable[tuple[str, str, Run]],
    judge: Callable[[Vector], tuple[float, tuple[str, ...]]],
    repeats: int,
) -> list[Row]:
    """Every run once for its error, and again for its time."""
    rows = []
    for method, setting, run in runs:
        error, more = judge(run())
        rows.append(Row(method, setting, error, fastest(run, repeats), more))
    return rows


def cells(rows: Sequence[Row]) -> tuple[tuple[str, ...], ...]:
    """Formatted, with the time of a peer over our least time at no larger error."""
    ours = [row for row in rows if row.method.startswith("phichain")]
    found = []
    for row in rows:
        equal = min((mine.seconds for mine in ours if mine.error <= row.error), default=np.nan)
        ratio = "" if row in ours or np.isnan(equal) else f"{row.seconds / equal:.3g}"
        found.append((row.method, row.setting, f"{row.error:.1e}", *row.more, f"{row.seconds:.3g}", ratio))
    return tuple(found)


def torque_table(quick: bool) -> table.Table:
    """How well three links follow (17), by the law, the integrator and its tolerance."""
    system, wanted = paper_a_chain(3, actuated="all"), in_phase(*MOTION)
    grid = np.linspace(0.0, SECONDS, 121)
    exact = np.array([np.concatenate(wanted(t)[:2]) for t in grid])
    laws = {
        "fed forward": computed_torque(system, wanted),
        "computed torque": computed_torque(system, wanted, 5.0),
    }
    tolerances = (1e-6, 1e-12) if quick else (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)

    def judge(states: Vector) -> tuple[float, tuple[str, ...]]:
        return float(np.max(np.abs(states[:, :3] - exact[:, :3]))), ()

    def runs() -> Iterable[tuple[str, str, Run]]:
        for name, law in laws.items():
            for tol in tolerances:
                yield f"phichain, {name}", f"{tol:.0e}", _ours(system, exact[0], grid, law, tol)
        for tol in tolerances:
            law = laws["computed torque"]
            yield (
                "phichain LSODA, computed torque",
                f"{tol:.0e}",
                _ours(system, exact[0], grid, law, tol, "LSODA"),
            )
        for method in ("RK45", "DOP853", "LSODA"):
            for tol in tolerances:
                label = f"scipy {method}, computed torque"
                yield (
                    label,
                    f"{tol:.0e}",
                    _by_scipy(system, exact[0], grid, laws["computed torque"], tol, method),
                )

    return table.Table(
        "Computed torque: three links follow 0.5, 0.3, -0.2 rad x cos 3t for 6 s (paper A, Fig. 2)",
        (
            "law and integrator",
            "tolerance",
            "tracking error, rad",
            "processor s",
            "its time / ours at no larger error",
        ),
        cells(rows_of(runs(), judge, 1 if quick else 3)),
        (
            (
                "Error: largest |theta_d - theta| at 121 times against the wanted motion in closed form. Fed forward, the error is "
                "the integrator's alone; fed back, it is damped at 5 1/s as well. SciPy integrates the same compiled right-hand "
                f"side and law through `solve_ivp` (scipy {metadata.version('scipy')})."
            ),
        ),
    )


def _ours(system: System, start: Vector, grid: Vector, law: Any, tol: float, method: str = "auto") -> Run:
    return lambda: simulate(system, start, grid, method, tol, u=law).x


def _by_scipy(system: System, start: Vector, grid: Vector, law: Any, tol: float, method: str) -> Run:
    field = rhs(system)

    def run() -> Vector:
        keys: dict[str, Any] = {"method": method, "t_eval": grid, "rtol": tol, "atol": tol / 100}
        found = solve_ivp(
            lambda t, x: field(t, x, law(t, x)) if law else field(t, x), (0.0, grid[-1]), start, **keys
        )
        return np.asarray(found.y.T)

    return run


def energy_table(quick: bool) -> table.Table:
    """Paper B's Fig. 2: how far the energy strays in ten seconds."""
    system = build(find_scene("paper_b"))
    start = pack(*FIG_2.start)
    grid = np.linspace(0.0, FIG_2.seconds, 1001)
    first = _energies(system, start[None])[0]

    def judge(states: Vector) -> tuple[float, tuple[str, ...]]:
        strayed = np.max(np.abs(_energies(system, states) - first)) / first
        sideways = np.max(np.abs((states - start)[:, [*range(3, 17, 3), 18]]))
        return float(strayed), ("exactly" if sideways == 0 else f"{sideways:.0e}",)

    runs = _left_alone(system, start, grid, (1e-9,) if quick else (1e-6, 1e-9, 1e-12))
    return table.Table(
        "Five links on a cart left alone for 10 s: energy (paper B, Fig. 2)",
        (
            "method", "tolerance or step", "energy error, relative", "in its plane", "processor s",
            "its time / ours at no larger error",
        ),
        cells(rows_of(runs, judge, 1 if quick else 3)),
        (
            (
                f"Error: largest |T + V - E| / E at 1001 times, E = {float(first)!r} J. 'auto' is what `simulate` takes by itself. heyoka "
                f"{table.version('heyoka')}: its adaptive Taylor integrator on an expert's tension form; SciPy through `solve_ivp` on "
                "the compiled right-hand side. In its plane: the largest e_2 component of the links and change of the cart's e_2 rate."
            ),
        ),
    )  # fmt: skip


def _energies(system: System, states: Vector) -> Vector:
    kinetic, potential = system.energy(states[:, : system.nq].copy(), states[:, system.nq :].copy())
    return np.asarray(kinetic + potential, dtype=float)


def _left_alone(
    system: System, start: Vector, grid: Vector, tolerances: Sequence[float]
) -> Iterable[tuple[str, str, Run]]:
    for tol in tolerances:
        yield "phichain auto", f"{tol:.0e}", lambda tol=tol: simulate(system, start, grid, tol=tol).x
    for tol in tolerances:
        yield "phichain DOP853", f"{tol:.0e}", lambda tol=tol: simulate(system, start, grid, "DOP853", tol).x
    for h in (1e-3,) if len(tolerances) < 2 else (1e-3, 2e-4):
        yield "phichain step (RK4)", f"{h:g} s", lambda h=h: simulate(system, start, grid, "step", h=h).x
    yield from _heyoka(system, start, grid, tolerances)
    for method in ("RK45", "DOP853", "LSODA"):
        for tol in tolerances:
            yield f"scipy {method}", f"{tol:.0e}", _by_scipy(system, start, grid, None, tol, method)


def _heyoka(
    system: System, start: Vector, grid: Vector, tolerances: Sequence[float]
) -> Iterable[tuple[str, str, Run]]:
    try:
        import heyoka as hy
    except ImportError:
        return
    from benchmarks.peers.heyoka.taylor import equations

    for tol in tolerances:
        flow = hy.taylor_adaptive(
            equations(find_scene("paper_b")), start.tolist(), tol=tol, compact_mode=False
        )

        def run(flow: Any = flow) -> Vector:
            flow.time, flow.state[:] = 0.0, start
            return np.asarray(flow.propagate_grid(grid)[-1])

        yield "heyoka taylor_adaptive", f"{tol:.0e}", run


def tables(run: plan.Plan) -> list[table.Table]:
    """Torque, energy, gains."""
    return [torque_table(run.tiny), energy_table(run.tiny), gains_table(run.tiny)]


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.papers", description=__doc__)
    parser.add_argument("--write", action="store_true", help="write benchmarks/results/papers.md")
    parser.add_argument("--quick", action="store_true", help="a few tolerances, to see that it runs")
    given = parser.parse_args(arguments)
    made = tables(plan.TINY if given.quick else plan.FULL)
    for one in made:
        print(one.markdown())
    if given.write:
        print(table.write("papers", HEADING, made, "python -m benchmarks.papers --write"))


if __name__ == "__main__":
    main()
