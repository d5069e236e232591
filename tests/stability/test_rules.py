"""The page with the rules of judgement says what the code does; the chaos horizon; references of long chains."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import mpmath as mp
import numpy as np
import pytest

from benchmarks.stability import others, store, verdict
from benchmarks.stability.cases.case import Case
from benchmarks.stability.cases.table import all_cases
from benchmarks.stability.horizon import horizon, words
from benchmarks.stability.means import long_chain
from benchmarks.stability.references import Reference, references
from benchmarks.stability.report import Result
from benchmarks.stability.run import parser
from benchmarks.stability.verdict import Answer, judge

RULES = (Path(verdict.__file__).with_name("README.md")).read_text()


def test_the_page_has_the_verdicts_and_the_numbers_of_the_code() -> None:
    for name in (verdict.RIGHT, verdict.INACCURATE, verdict.WRONG, verdict.DOUBTED, verdict.REFUSED, verdict.UNFINISHED):
        assert f"| {name} |" in RULES
    assert f"{verdict.SLACK:.0e} times the attainable error" in RULES
    assert f"within {verdict.LIMIT:g} " in RULES and "2^-53" in RULES and "2^-24" in RULES
    assert "5 s, 2 s in a quick run" in RULES and "5, or 2 in a quick run" in parser().format_help()


def motion(times: tuple[float, ...], real: str = "double") -> Case:
    chain = {"links": 1, "mass": 1.0, "length": 1.0, "real": real}
    return Case("X", "x", "motion", chain, (0.1,), (0.0,), times=times)


def known(*kappa: float) -> Reference:
    return Reference(((mp.mpf(0), mp.mpf(0)),) * len(kappa), kappa, 1.0)


def test_the_horizon_is_where_round_off_has_grown_to_a_hundredth() -> None:
    """kappa = e^(3t): the horizon solves 2^-53 e^(3t) = 1e-2, wherever the rows lie."""
    exact = math.log(1e-2 * 2.0**53) / 3
    for times in ((1.0, 2.0), (5.0, 8.0), (4.0,)):
        found = horizon(motion(times), known(*(math.exp(3 * t) for t in times)))
        assert found == pytest.approx(exact, rel=1e-12)
    single = horizon(motion((1.0, 2.0), "float"), known(math.exp(3), math.exp(6)))
    assert single == pytest.approx(math.log(1e-2 * 2.0**24) / 3, rel=1e-12)


def test_a_regular_motion_has_no_horizon() -> None:
    assert words(motion((1.0, 2.0)), known(5.0, 10.0)) == "far"
    assert words(replace(motion((1.0,)), kind="dynamics"), known(1.0)) == "-"


def test_the_long_chain_against_the_engine_on_a_short_one() -> None:
    """Two links for 0.1 s: another formula, another method, other arithmetic."""
    from benchmarks.stability.means import engine

    case = next(case for case in all_cases() if case.id == "S09")
    short = replace(case, times=(0.05, 0.1))
    ours = long_chain.states(short, 0.005, 6)
    exact = engine.integrate(short.plain(), (*case.q, *case.v), short.times, tol=1e-22).numbers()
    with mp.workdps(40):
        gaps = [abs(a - b) for x, y in zip(ours, exact, strict=True) for a, b in zip(x, y, strict=True)]
    assert max(gaps) < 2e-18
    assert long_chain.acceleration_gap(short, ours[-1]) < 1e-15


def test_motion_at_256_links_is_a_case() -> None:
    case = next(case for case in all_cases() if case.chain["links"] == 256 and case.kind == "motion")
    reference = references()[case.id]
    assert len(reference.rows) == len(case.times) and len(reference.rows[0]) == 512
    # nothing but gravity has worked on it: the energy above the start is still zero, to single round-off
    theta, rate = (np.cumsum([float(x) for x in part]) for part in np.split(np.array(reference.rows[-1]), 2))
    along = np.cumsum(np.stack([np.sin(theta), np.cos(theta)]), axis=1) / 256
    speed = np.cumsum(np.stack([np.cos(theta), -np.sin(theta)]) * rate, axis=1) / 256
    kinetic, fallen = np.sum(speed**2) / 512, 9.81 * np.sum(along[1]) / 256
    assert kinetic == pytest.approx(fallen, rel=1e-9)


def test_peers_that_are_not_here_are_named(no_peers: None) -> None:
    found, absent = others.installed(others.DYNAMICS | others.MOTION)
    assert found == {} and len(absent) == len(others.NEEDS)
    assert any(line.startswith("Pinocchio aba: skipped: pin is not installed: pip install pin") for line in absent)


def test_a_stored_result_counts_for_the_code_that_made_it(tmp_path: Path) -> None:
    case = all_cases()[0]
    answer = Answer("ok", errors=(1e-16,))
    path = tmp_path / "new" / "stability.json"
    store.keep(path, [Result(case, "taylor", True, answer, judge(answer, [1.0], case.round_off))], "this")
    assert store.done(path, "this") == {(case.id, "taylor")} and store.done(path, "that") == set()
