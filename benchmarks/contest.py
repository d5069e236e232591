"""One piece of work, everybody who does it, and the one format in which the tables tell of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.clock import Samples, Spread, race, ratios, spread
from benchmarks.harness import BenchmarkError
from benchmarks.table import Table

Maker = Callable[[], "Runner | list[Runner]"]
UNITS = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1.0}


@dataclass(frozen=True)
class Runner:
    """One contestant, ready to go.

    Attributes:
        who: Its row.
        run: Does the work once.
        error: Of its result, in the norm that the table states; NaN where there is none.
        kind: "ours", "peer", or "hybrid" for a formula of ours in a peer's compiler: listed, but no yardstick.
    """

    who: str
    run: Callable[[], object]
    error: float = float("nan")
    kind: str = "peer"


@dataclass(frozen=True)
class Entry:
    """A row: a contestant's time, its ratio to the best peer of the same rounds, its error; or why there is none."""

    who: str
    kind: str = "peer"
    time: Spread | None = None
    ratio: Spread | None = None
    error: float = float("nan")
    note: str = ""


@dataclass(frozen=True)
class Work:
    """One piece of work and its rows.

    Attributes:
        title: What is done.
        entries: The rows.
        unit: Of the times: a key of UNITS.
        reach: What is aimed at, as a ratio; empty for none.
    """

    title: str
    entries: tuple[Entry, ...]
    unit: str = "ns"
    reach: str = ""

    @property
    def ours(self) -> Entry | None:
        """Our fastest row."""
        return _fastest([e for e in self.entries if e.kind == "ours"])

    @property
    def best(self) -> Entry | None:
        """The fastest peer."""
        return _fastest([e for e in self.entries if e.kind == "peer"])


def _fastest(entries: Sequence[Entry]) -> Entry | None:
    timed = [entry for entry in entries if entry.time is not None]
    return min(timed, key=lambda entry: entry.time.median) if timed else None  # type: ignore[union-attr]


def entries(names: Sequence[str], kinds: Sequence[str], samples: Samples, errors: Sequence[float]) -> list[Entry]:
    """Rows of samples (rounds, names), each beside the fastest peer; without peers there are no ratios."""
    times = [spread(samples[:, i]) for i in range(len(names))]
    peers = [i for i, kind in enumerate(kinds) if kind == "peer"]
    best = min(peers, key=lambda i: times[i].median) if peers else None
    over: list[Spread | None] = [None] * len(names) if best is None else [*ratios(samples, best)]
    return [
        Entry(name, kind, t, ratio, error)
        for name, kind, t, ratio, error in zip(names, kinds, times, over, errors, strict=True)
    ]


def gather(makers: Sequence[tuple[str, Maker]]) -> tuple[list[Runner], list[Entry]]:
    """Everybody who can take part, and a row with the reason for everybody who cannot.

    Args:
        makers: (name, what builds it); only a `BenchmarkError` excuses.
    """
    runners: list[Runner] = []
    skipped = []
    for name, make in makers:
        try:
            made = make()
        except BenchmarkError as reason:
            skipped.append(Entry(name, note=f"skipped: {reason}"))
            print(f"  {name}: skipped: {reason}", flush=True)
            continue
        runners += [made] if isinstance(made, Runner) else made
    return runners, skipped


def contest(
    title: str, makers: Sequence[tuple[str, Maker]], rounds: int, budget: float = 6.0, unit: str = "ms", reach: str = "",
    clock: Callable[[], float] | None = None, per: float = 1.0,
) -> Work:  # fmt: skip
    """Build, race, relate.

    Args:
        title: Of the work.
        makers: Who takes part.
        rounds: As `race`.
        budget: As `race`.
        unit: Of the times.
        reach: Ratio aimed at.
        clock: Processor time by default.
        per: Pieces of work in one call; times are given for one.
    """
    runners, skipped = gather(makers)
    found: list[Entry] = []
    if runners:
        options = {} if clock is None else {"clock": clock}
        samples = race([r.run for r in runners], rounds, budget, **options) / per
        found = entries([r.who for r in runners], [r.kind for r in runners], samples, [r.error for r in runners])
    work = Work(title, (*found, *skipped), unit, reach)
    print(line(work), flush=True)
    return work


def line(work: Work) -> str:
    """For the terminal."""
    mine, best = work.ours, work.best
    return f"  {work.title}: " + ("; ".join(filter(None, (_told(mine, work.unit), _told(best, work.unit)))) or "nobody")


def _told(entry: Entry | None, unit: str) -> str:
    if entry is None or entry.time is None:
        return ""
    ratio = "" if entry.ratio is None else f" x {entry.ratio.median:.2f}"
    return f"{entry.who} {entry.time.median / UNITS[unit]:.3g} {unit}{ratio} ({entry.error:.0e})"


def summary(title: str, works: Sequence[Work], notes: Sequence[str] = ()) -> Table:
    """A row per piece of work: ours over the best peer, quartiles, errors, what is aimed at."""
    rows = []
    for work in works:
        mine, best = work.ours, work.best
        ratio = mine.ratio.text() if mine and mine.ratio else "-"
        worse = mine is not None and best is not None and mine.error > best.error
        rows.append((
            work.title, _time(mine, work.unit), "-" if best is None else f"{_time(best, work.unit)} ({best.who})", ratio,
            work.reach or "-", _error(mine), _error(best) + (" (smaller)" if worse else ""),
        ))  # fmt: skip
    heads = ("work", "phichain", "best peer", "ratio [quartiles]", "reach", "error", "the peer's error")
    return Table(title, heads, tuple(rows), tuple(notes))


def detail(title: str, works: Sequence[Work], notes: Sequence[str] = ()) -> Table:
    """Every row of every piece of work; bold is ours, italic a formula of ours in a peer's compiler."""
    rows = []
    for work in works:
        order = sorted(work.entries, key=lambda e: float("inf") if e.time is None else e.time.median)
        for k, entry in enumerate(order):
            spread_of = "-" if entry.time is None else f"{entry.time.text(3, UNITS[work.unit])} {work.unit}"
            ratio = "-" if entry.ratio is None else entry.ratio.text()
            rows.append((work.title if k == 0 else "", _label(entry), spread_of, ratio, _error(entry), entry.note))
    heads = ("work", "who", "time [quartiles]", "x best peer [quartiles]", "error", "note")
    return Table(title, heads, tuple(rows), tuple(notes))


def with_errors(work: Work, errors: dict[str, float]) -> Work:
    """The same with errors measured elsewhere, by name."""
    return replace(work, entries=tuple(replace(e, error=errors.get(e.who, e.error)) for e in work.entries))


def _label(entry: Entry) -> str:
    return {"ours": f"**{entry.who}**", "hybrid": f"*{entry.who}*"}.get(entry.kind, entry.who)


def _time(entry: Entry | None, unit: str) -> str:
    return "-" if entry is None or entry.time is None else f"{entry.time.median / UNITS[unit]:.3g} {unit}"


def _error(entry: Entry | None) -> str:
    return "-" if entry is None or np.isnan(entry.error) else f"{entry.error:.0e}"
