"""The verdicts of the stability table: what counts as right, and what as silently wrong."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from benchmarks.stability.verdict import (
    DOUBTED,
    INACCURATE,
    LIMIT,
    REFUSED,
    RIGHT,
    UNFINISHED,
    WRONG,
    Answer,
    judge,
)

EPS = 2.0**-53


def verdict(error: float, kappa: float = 1.0, **more: object) -> str:
    return judge(Answer("ok", errors=(error,), **more), [kappa], EPS).verdict  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("error", "kappa", "tolerance", "expected"),
    [
        (0.0, 1.0, 0.0, RIGHT),
        (0.9e4 * EPS, 1.0, 0.0, RIGHT),
        (1.1e4 * EPS, 1.0, 0.0, WRONG),  # nothing said that it would be worse
        (1e-9, 1.0, 1e-12, INACCURATE),
        (1e-7, 1.0, 1e-12, WRONG),
        (1e-7, 100.0, 1e-12, INACCURATE),
        (2 * LIMIT, 1.0, 1e-3, WRONG),  # a loose tolerance excuses no error above the limit
        (2 * LIMIT, 1e12, 0.0, WRONG),  # a double could have done better
        (2 * LIMIT, 1e15, 0.0, RIGHT),  # none could
        (math.nan, 1.0, 1e-3, WRONG),
    ],
)
def test_error_against_what_is_attainable_and_promised(
    error: float, kappa: float, tolerance: float, expected: str
) -> None:
    assert verdict(error, kappa, tolerance=tolerance) == expected


def test_local_errors_may_add_up_over_the_steps() -> None:
    assert verdict(1e-7, tolerance=1e-12, steps=100) == WRONG
    assert verdict(1e-7, tolerance=1e-12, steps=1_000_000) == INACCURATE


def test_a_method_may_speak_by_its_own_estimate() -> None:
    assert verdict(1e-5, estimate=2e-6) == INACCURATE
    assert verdict(1e-5, estimate=1e-7) == WRONG
    assert (
        verdict(3 * LIMIT, estimate=LIMIT) == INACCURATE
    )  # a fixed step whose halving shows it hides nothing


def test_the_wrong_side_of_a_separatrix_is_wrong_however_small_the_error() -> None:
    assert verdict(0.0, same_side=False) == WRONG


def test_the_worst_time_decides() -> None:
    found = judge(Answer("ok", errors=(1e-14, 1e-11, 1e-10)), [1.0, 1.0, 1e6], EPS)
    assert (found.verdict, found.error, found.attainable) == (WRONG, 1e-11, EPS)


def test_no_answer_is_no_wrong_answer() -> None:
    assert judge(Answer("refused", said="no"), [3.0], EPS).verdict == REFUSED
    assert judge(Answer("unfinished"), [3.0], EPS).verdict == UNFINISHED
    assert judge(Answer("unfinished"), [3.0], EPS).attainable == 3 * EPS


def test_a_wrong_answer_that_was_doubted_is_not_silent() -> None:
    wrong = Answer("ok", errors=(1.0,), tolerance=1e-9)
    assert judge(wrong, [1.0], EPS).verdict == WRONG
    assert judge(replace(wrong, doubted=True), [1.0], EPS).verdict == DOUBTED
    assert judge(Answer("ok", errors=(0.0,), doubted=True), [1.0], EPS).verdict == RIGHT


def test_a_written_table_gives_its_picture_the_verdicts_that_its_summary_counts() -> None:
    """Two tables of the same page: every method's verdicts, one by one and counted."""
    from benchmarks.stability.picture import TABLE, verdicts
    from benchmarks.stability.report import ORDER

    text = TABLE.read_text()
    counted: dict[str, tuple[int, ...]] = {}
    for line in text.partition("## Forward dynamics")[0].splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if len(cells) == 7 and all(not cell or cell.isdecimal() for cell in cells[1:]):
            counted[cells[0]] = tuple(int(cell or 0) for cell in cells[1:])
    found = verdicts(text)
    assert len(counted) > 15 and counted == {
        method: tuple(sum(verdict == wanted for (_, other), verdict in found.items() if other == method) for wanted in ORDER) for method in counted
    }
    with pytest.raises(ValueError, match="A01, heyoka: 'fine' is no verdict"):
        verdicts("| **A01** one | heyoka | 1 | 1 | - | 0 | fine |")
