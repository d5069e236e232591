"""What a run is worth: right, inaccurate, silently wrong, wrong and says so, refused, not finished."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isnan

RIGHT, INACCURATE, WRONG, DOUBTED, REFUSED, UNFINISHED = (
    "right",
    "inaccurate",
    "SILENTLY WRONG",
    "wrong, and says so",
    "refuses",
    "does not finish",
)
SLACK = 1e4
"""How far above the attainable error an answer may be and still be called right."""
LIMIT = 1e-2
"""An answer further off than this is wrong, whatever its tolerance was."""


@dataclass(frozen=True)
class Answer:
    """What one method said about one case.

    Attributes:
        status: "ok", "refused" or "unfinished".
        said: its message, when it had one.
        errors: one per row of the reference; empty without an answer.
        tolerance: relative tolerance it was asked for; 0 for a function that has none.
        estimate: its own error estimate, where halving the step gives one.
        same_side: False when it ended on the other side of a separatrix.
        steps: steps it took, or None.
        seconds: wall time.
        doubted: whether it ended with words of doubt about its own answer.
    """

    status: str
    said: str = ""
    errors: tuple[float, ...] = ()
    tolerance: float = 0.0
    estimate: float = 0.0
    same_side: bool = True
    steps: int | None = None
    seconds: float = 0.0
    doubted: bool = False


@dataclass(frozen=True)
class Judgement:
    """A verdict and the row it rests on: where the error is the largest multiple of what would be right."""

    verdict: str
    error: float
    attainable: float


def judge(answer: Answer, kappa: Sequence[float], round_off: float) -> Judgement:
    """Judge an answer.

    The attainable error is round_off x max(1, kappa): what a backward stable method reaches. An answer is right within
    SLACK times that, and within LIMIT. Beyond, it is inaccurate as long as its tolerance (times the condition and the
    larger of SLACK and its steps, since local errors add up) says so, and within LIMIT. A fixed step promises nothing:
    its estimate, the difference to half as many steps, says how inaccurate it is. It is silently wrong when they do not
    say so, when it is off by more than LIMIT although a double could do better, or past a separatrix; silently no more
    when it ended with status "doubtful".
    """
    if answer.status == "refused":
        return Judgement(REFUSED, float("nan"), _attainable(kappa, round_off))
    if answer.status != "ok":
        return Judgement(UNFINISHED, float("nan"), _attainable(kappa, round_off))
    bounds = [round_off * max(1.0, k) for k in kappa]
    limits = [min(SLACK * bound, max(LIMIT, bound)) for bound in bounds]
    growth = max(SLACK, answer.steps or 0.0)
    promised = [growth * answer.tolerance * max(1.0, k) for k in kappa]
    said = [
        max(limit, 10 * answer.estimate) if answer.estimate else min(max(limit, p), max(LIMIT, bound))
        for limit, p, bound in zip(limits, promised, bounds, strict=True)
    ]
    rows = list(zip(answer.errors, bounds, limits, said, strict=True))
    if any(_times(error, most) > 1 for error, _, _, most in rows) or not answer.same_side:
        error, bound, _, _ = max(rows, key=lambda row: _times(row[0], row[3]))
        return Judgement(DOUBTED if answer.doubted else WRONG, error, bound)
    error, bound, limit, _ = max(rows, key=lambda row: _times(row[0], row[2]))
    return Judgement(RIGHT if error <= limit else INACCURATE, error, bound)


def _attainable(kappa: Sequence[float], round_off: float) -> float:
    return round_off * max(1.0, *kappa)


def _times(error: float, limit: float) -> float:
    return float("inf") if isnan(error) else error / limit
