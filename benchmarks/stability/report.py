"""The stability table as Markdown, and its overview as one picture and one page."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmarks.stability.cases.case import Case
from benchmarks.stability.verdict import (
    DOUBTED,
    INACCURATE,
    LIMIT,
    REFUSED,
    RIGHT,
    SLACK,
    UNFINISHED,
    WRONG,
    Answer,
    Judgement,
)
from benchmarks.table import Table

ORDER = (RIGHT, INACCURATE, WRONG, DOUBTED, REFUSED, UNFINISHED)
_LONGEST = 160


@dataclass(frozen=True)
class Result:
    """One method on one case; `horizon` is the case's, as `horizon.words` gives it."""

    case: Case
    method: str
    own: bool
    answer: Answer
    judgement: Judgement
    horizon: str = "-"

    def line(self) -> str:
        """One line for the terminal."""
        return f"{self.case.id:4} {self.method:26} {self.error:9} {self.attainable:9} {self.steps:>9} {self.words}"

    @property
    def error(self) -> str:
        return "-" if self.judgement.error != self.judgement.error else f"{self.judgement.error:.1e}"

    @property
    def attainable(self) -> str:
        return f"{self.judgement.attainable:.1e}"

    @property
    def steps(self) -> str:
        return "-" if self.answer.steps is None else str(self.answer.steps)

    @property
    def words(self) -> str:
        """The verdict, and what was said where there is no answer."""
        if self.judgement.verdict not in (REFUSED, UNFINISHED):
            return self.judgement.verdict
        said = " ".join(self.answer.said.split())
        return f"{self.judgement.verdict}: {said if len(said) <= _LONGEST else said[:_LONGEST] + ' ...'}"


def markdown_tables(results: Sequence[Result], seconds: float, absent: Sequence[str] = ()) -> list[Table]:
    """A summary by method, then one table per kind of case; `absent` are words about peers that are not installed."""
    tables = [_summary(results, True), _summary(results, False)]
    kinds = {
        "Forward dynamics": ("dynamics",), "Motion": ("motion",), "Energy over long times": ("energy",),
        "Frequency": ("period",),
    }  # fmt: skip
    for title, chosen in kinds.items():
        rows = [result for result in results if result.case.kind in chosen]
        if rows:
            tables.append(_details(title, rows))
    return [*tables, _legend(seconds, absent)]


def _summary(results: Sequence[Result], own: bool) -> Table:
    chosen = [result for result in results if result.own == own]
    methods = list(dict.fromkeys(result.method for result in chosen))
    rows = []
    for method in methods:
        counts = Counter(result.judgement.verdict for result in chosen if result.method == method)
        rows.append((method, *(str(counts[verdict]) if counts[verdict] else "" for verdict in ORDER)))
    return Table(
        "Verdicts of phichain's methods" if own else "Verdicts of the peers", ("method", *ORDER), tuple(rows)
    )


def _details(title: str, results: Sequence[Result]) -> Table:
    timed = any(result.case.kind == "motion" for result in results)
    rows: list[tuple[str, ...]] = []
    before = ""
    for result in results:
        case = f"**{result.case.id}** {result.case.title}" if result.case.id != before else ""
        before = result.case.id
        method = f"**{result.method}**" if result.own else result.method
        seconds = f"{result.answer.seconds:.2g}" if result.answer.status == "ok" else "-"
        words = result.words.replace("|", "/")
        cells = (case, method, result.error, result.attainable, result.horizon if case else "", result.steps, seconds, words)
        rows.append(cells if timed else (*cells[:4], *cells[5:]))
    heads = ("case", "method", "error", "attainable", *(("horizon, s",) if timed else ()), "steps", "s", "verdict")
    return Table(title, heads, tuple(rows))


def _legend(seconds: float, absent: Sequence[str]) -> Table:
    rows = (
        (RIGHT, f"error within {SLACK:.0e} of the attainable one"),
        (
            INACCURATE,
            f"beyond that, within what its tolerance says and within {LIMIT:g}; a fixed step: within ten times what halving it shows",
        ),
        (
            WRONG,
            f"reported success with an error above {LIMIT:g}, beyond what its tolerance says, or past a separatrix",
        ),
        (DOUBTED, "the same, but it ended with status doubtful and said why"),
        (REFUSED, "an error that says what is the matter"),
        (UNFINISHED, f"not done within {seconds:g} s, or gave up and said so"),
    )
    return Table(
        "How to read it", ("verdict", "meaning"), rows,
        (
            ("Error: accelerations and frequencies max norm over max norm; motions the worse of positions over "
            "max(1, largest position) and rates over the fastest rate of the motion, at the time that decides the verdict; energies the largest change over the height above the hanging rest. "
            "Attainable: unit round-off times the condition number (amplification of a relative change of every number "
            "of the problem; for motions also of the state on the way, by one ulp). References and how each was made and cross-checked: benchmarks/stability/references.json."),
            ("**Bold**: phichain. DOP853, RK45, Radau, BDF and LSODA are SciPy's, cvodes and idas SUNDIALS', on phichain's "
            "right-hand side and Jacobian. A fixed-step method takes 20 000 steps; 10 000 tell its own estimate. "
            "A-, B-, C-cases: tests/data/extreme_cases.json. Horizon: when one round-off has grown to 1e-2. The rules, as they were before"
            " the run: benchmarks/stability/README.md."),
            *absent,
        ),
    )  # fmt: skip


def label(case: Case) -> str:
    """What the picture calls a case."""
    return f"{case.id}  {case.title}"


def page(results: Sequence[Result], folder: Path, command: str) -> Path:
    """Write stability.html and stability.png."""
    from benchmarks.pages.html import Figure, write_page
    from phichain.report.measured.verdicts import draw_verdicts

    cases = list(dict.fromkeys(label(result.case) for result in results))
    methods = list(dict.fromkeys(result.method for result in sorted(results, key=lambda r: not r.own)))
    cells = {(label(r.case), r.method): r.judgement.verdict for r in results}
    picture = draw_verdicts(folder / "stability.png", cases, methods, cells, ORDER)
    caption = "Every method on every case; an empty cell was not run."
    return write_page(
        folder / "stability.html", "Stiff and extreme cases", f"Made by {command}.",
        [Figure(picture, caption)], markdown_tables(results, 0.0)[:-1],
    )  # fmt: skip
