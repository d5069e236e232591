"""One section per kind of work: its tables and figures."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from benchmarks.contest import Work, detail
from benchmarks.dynamics import forward as dynamics
from benchmarks.fractional import run as fractional_table
from benchmarks.pages.html import Figure
from benchmarks.plan import FULL
from benchmarks.stability.references import references
from benchmarks.table import Table
from benchmarks.work_precision import families as family_rows
from benchmarks.work_precision import integrators, reach
from benchmarks.work_precision.problems import problems
from benchmarks.work_precision.rows import Row, as_table, measure
from phichain.report.measured.work_precision import Curve, draw_work_precision


@dataclass(frozen=True)
class Section:
    """Tables and figures of one kind of work."""

    tables: list[Table] = field(default_factory=list)
    figures: list[Figure] = field(default_factory=list)


def integration(quick: bool, folder: Path) -> Section:
    """Regular, chaotic, eight links, spatial, stiff: final states against binary128 references."""
    section, measured = Section(), {}
    for work in problems():
        references.cache_clear()  # a reference may have been made since the last problem
        known = references().get(work.case.id)
        if known is None:
            print(
                f"  {work.case.id} has no reference yet: python -m benchmarks.stability.make_references",
                flush=True,
            )
            continue
        rows = measure(integrators.candidates(work, quick), 3 if quick else 15, 1.0 if quick else 3.0)
        measured[work.words] = rows
        heyoka = tuple({row.method for row in rows if row.method.startswith("heyoka")})
        mine = (
            (integrators.TAYLOR,)
            if any(row.method == integrators.TAYLOR for row in rows)
            else ("phichain rosenbrock",)
        )
        yardsticks = {"x heyoka": heyoka, f"x {mine[0]}": mine}
        attainable = 2.0**-53 * max(1.0, *known.kappa)
        notes = (
            (
                f"Ratios: time over the least time of that method at no larger error. Attainable: {attainable:.1e}. "
                "Processor time, the least of several rounds. "
                "Setup: derive, lower, emit, compile and load; or build and JIT."
            ),
        )
        section.tables.append(
            as_table(f"{work.words.capitalize()}: {work.case.title}", rows, yardsticks, ("ms", 1e-3), notes)
        )
        picture = folder / f"work_precision_{work.case.id.lower()}.png"
        section.figures.append(
            Figure(draw_work_precision(picture, work.case.title, curves(rows), attainable), work.case.title)
        )
    section.tables[:0] = [reach.table(measured), reach.energy_table()]
    return section


def curves(rows: Sequence[Row]) -> list[Curve]:
    """One curve per method."""
    names = list(dict.fromkeys(row.method for row in rows))
    chosen = ([row for row in rows if row.method == name] for name in names)
    return [
        Curve(group[0].method, [r.seconds for r in group], [r.error for r in group], group[0].own)
        for group in chosen
    ]


def forward_dynamics(quick: bool, folder: Path) -> Section:
    """One state from C, evaluations that overlap, beside CasADi, heyoka, Pinocchio and MuJoCo."""
    section = Section()
    sizes = {"P, torques": (2, 8) if quick else (2, 4, 8, 32), "S": (5,) if quick else (5, 16)}
    run = replace(FULL, rounds=21) if quick else FULL
    for kind, links in sizes.items():
        for count in links:
            work = dynamics.measure(kind, count, run).independent
            section.tables.append(detail(work.title, [work]))
            picture = folder / f"work_precision_dynamics_{'planar' if kind != 'S' else 'spatial'}{count}.png"
            section.figures.append(Figure(draw_work_precision(picture, work.title, _points(work)), work.title))
    return section


def _points(work: Work) -> list[Curve]:
    timed = [entry for entry in work.entries if entry.time is not None and entry.kind != "hybrid"]
    return [Curve(e.who, [e.time.median], [e.error], e.kind == "ours") for e in timed if e.time]


def families(quick: bool, folder: Path) -> Section:
    """Phi against quadrature, families against closed forms; and where one harmonic stops being true."""
    section = Section()
    for links in (1, 2, 8) if quick else (1, 2, 4, 8):
        rows = measure(family_rows.evaluations(links), 5 if quick else 20, 2.0)
        title = f"Phi, N = {links}: 200 evaluations from Python"
        section.tables.append(
            as_table(title, rows, {"x phichain phi": ("phichain phi",)}, ("ms", 1e-3), _PHI_NOTE)
        )
        picture = folder / f"work_precision_phi{links}.png"
        section.figures.append(Figure(draw_work_precision(picture, title, curves(rows)), title))
    for links in (1, 2) if quick else (1, 2, 4):
        rows = measure(list(family_rows.families(links)), 3, 2.0)
        points = {"phichain trace": family_rows.points_of(links)}
        cells = tuple(
            (
                row.method,
                f"{points.get(row.method, 60)}",
                f"{row.error:.1e}",
                f"{1e6 * row.seconds / points.get(row.method, 60):.3g}",
            )
            for row in rows
        )
        title = f"First family, N = {links}"
        section.tables.append(
            Table(title, ("method", "points", "error", "microseconds per point"), cells, _FAMILY_NOTE)
        )
    pairs = tuple((f"{a:.6g}", f"{gap:+.2e}") for a, gap in family_rows.one_harmonic_against_exact())
    section.tables.append(
        Table("One harmonic against the exact frequency, N = 1", ("amplitude, rad", "relative error"), pairs)
    )
    return section


_PHI_NOTE = (
    "Error: max norm over max norm against a quadrature in 30 digits. Both are called from Python, call by call.",
)
_FAMILY_NOTE = (
    (
        "Error: N = 1 the frequency against sqrt(2 g J1(A) / (r A)), relative; else the largest residual by quadrature with "
        "128 samples, N m. The followed family carries its folds, branch points and energy extrema, located."
    ),
)


def fractional(quick: bool, folder: Path) -> Section:
    """Differintegrals of a signal beside differint and pycaputo."""
    probed = (-1.5, -0.5) if quick else (-1.9, -1.5, -1.0, -0.5, -0.1)
    found = fractional_table.our_rows((100, 1000) if quick else (100, 1000, 10_000), probed)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found += fractional_table.peer_rows(True, probed)
    rows = [
        Row(
            r.method,
            f"{r.samples} samples",
            r.method.startswith("phichain"),
            r.error,
            r.seconds,
            float("nan"),
        )
        for r in found
    ]
    mine = tuple({row.method for row in rows if row.own})
    title = "Differintegrals: 101 alpha in [-2, 0], one signal"
    note = (
        "Processor time for 101 alpha; peers timed on a few alpha and scaled. The full table: fractional.md.",
    )
    picture = draw_work_precision(folder / "work_precision_fractional.png", title, curves(rows))
    return Section([as_table(title, rows, {"x phichain": mine}, ("s", 1.0), note)], [Figure(picture, title)])
