"""References of the stability table: the engine against the oracle and closed forms, stored rows against both."""

from __future__ import annotations

import shutil
from typing import Any

import mpmath as mp
import numpy as np
import pytest

from benchmarks.stability.cases.case import Case
from benchmarks.stability.cases.table import all_cases, work_cases
from benchmarks.stability.means import elliptic, engine
from benchmarks.stability.references import gap, read, references, relative_gap
from phichain.reference import reference
from phichain.scene import Scene

CASES = {case.id: case for case in [*all_cases(), *work_cases()]}
needs_compiler = pytest.mark.skipif(
    shutil.which("c++") is None, reason="the reference engine needs a C++ compiler"
)


def state(chain: Scene, seed: int) -> list[float]:
    rng = np.random.default_rng(seed)
    if chain.is_planar:
        return rng.normal(size=chain.nq + chain.nv).tolist()
    q, w = rng.normal(size=(2, chain.links, 3))
    q /= np.linalg.norm(q, axis=1)[:, None]
    w -= np.sum(q * w, axis=1)[:, None] * q
    cart = rng.normal(size=2).tolist() if chain.has_cart else []
    return [*cart, *q.ravel().tolist(), *cart, *w.ravel().tolist()]


@needs_compiler
@pytest.mark.parametrize("base", [{}, {"base": "cart", "cart_mass": 0.7}], ids=["fixed", "cart"])
@pytest.mark.parametrize("space", ["planar", "spatial"])
def test_the_engine_agrees_with_the_oracle(space: str, base: dict[str, Any]) -> None:
    chain = Scene(
        "engine", 3, space=space, mass=[1, 2, 0.5], length=[0.3, 0.6, 1.0], com=[0.2, 0.6, 0.5], stiffness=[1, 2, 3],
        damping=[0.3, 0.2, 0.1], actuated="none", **base,
    )  # fmt: skip
    x = state(chain, 3)
    exact = reference(chain, "forward_dynamics", {"q": x[: chain.nq], "v": x[chain.nq :]}, digits=34)["a"]
    assert relative_gap(exact, engine.accelerations(chain, x)) < 1e-30


@needs_compiler
def test_the_engine_follows_the_pendulum() -> None:
    chain = Scene("one", 1, mass=2.0, length=0.7, actuated="none")
    found = engine.integrate(chain, [2.5, 0.0], [0.5, 3.0], tol=1e-26)
    with mp.workdps(50):
        omega0 = mp.sqrt(mp.mpf(chain.gravity) / mp.mpf(0.7))
        exact = [elliptic.state(mp.mpf(2.5), mp.mpf(0), omega0, mp.mpf(t)) for t in (0.5, 3.0)]
    assert gap(exact, found.numbers(), found.fastest) < 1e-23


@needs_compiler
def test_radau_agrees_with_extrapolation_where_both_serve() -> None:
    chain = Scene("two", 2, mass=1.0, length=1.0, stiffness=[0.0, 50.0], damping=[0.1, 0.2], actuated="none")
    x0, times = [1.0, 0.3, 0.0, 0.5], [0.2, 0.7]
    stiffly = engine.integrate(chain, x0, times, tol=1e-19, stages=7)
    plainly = engine.integrate(chain, x0, times, tol=1e-24)
    assert gap(plainly.numbers(), stiffly.numbers(), plainly.fastest) < 1e-18


def test_the_radau_tableau_fulfils_its_order_conditions() -> None:
    stages = 5
    with mp.workdps(40):
        numbers = [
            mp.fsum(map(mp.mpf, part)) for part in engine.radau_tableau(stages).reshape(-1, 3).tolist()
        ]
        c, a = numbers[:stages], np.array(numbers[stages:]).reshape(stages, stages)
        assert abs(c[-1] - 1) < 1e-35
        for power in range(stages):  # A c^p = c^(p+1) / (p+1), and the last row as weights to order 2 s - 1
            powers = [x**power for x in c]
            gaps = [
                abs(mp.fdot(row, powers) - x ** (power + 1) / (power + 1))
                for row, x in zip(a, c, strict=True)
            ]
            assert max(gaps) < 1e-30
        for power in range(2 * stages - 1):
            assert abs(mp.fdot(a[-1], [x**power for x in c]) - mp.mpf(1) / (power + 1)) < 1e-30


def test_every_case_has_a_reference_that_was_checked_twice() -> None:
    stored = read()
    assert set(CASES) == set(stored)
    for name, entry in stored.items():
        case = CASES[name]
        rows = 0 if case.kind == "energy" else len(case.times) or 1
        assert len(entry["rows"]) == rows
        assert len(entry["kappa"]) == (rows or 1)
        assert min(entry["kappa"]) > 0
        if case.kind != "energy":
            assert entry["crosscheck"]
            attainable = case.round_off * max(1.0, *entry["kappa"])
            assert max(entry["crosscheck"].values()) < 10 * attainable, name


@pytest.mark.parametrize("name", ["S01", "S02", "S03", "S05"])
def test_stored_pendulums_are_those_of_the_closed_form(name: str) -> None:
    case, known = CASES[name], references()[name]
    with mp.workdps(elliptic.DIGITS):
        omega0 = mp.sqrt(mp.mpf(9.81))
        exact = [elliptic.state(mp.mpf(case.q[0]), mp.mpf(case.v[0]), omega0, mp.mpf(t)) for t in case.times]
    assert gap(exact, known.rows, known.fastest) < 1e-25


@pytest.mark.parametrize("name", ["D02", "D12", "D14", "A25"])
def test_stored_accelerations_are_those_of_the_oracle(name: str) -> None:
    case = CASES[name]
    exact = reference(case.plain(), "forward_dynamics", {"q": case.q, "v": case.v, "u": case.u}, digits=34)[
        "a"
    ]
    assert relative_gap(exact, references()[name].rows[0]) < 1e-25


@needs_compiler
@pytest.mark.parametrize("name", ["B14", "S11", "S13", "S33"])
def test_stored_motions_come_out_again(name: str) -> None:
    case, known = CASES[name], references()[name]
    again = engine.integrate(case.plain(), (*case.q, *case.v), case.times[:1], u=case.u, tol=1e-20, columns=9)
    assert gap(known.rows[:1], again.numbers(), known.fastest) < 1e-17


def test_the_separatrix_is_between_its_two_cases() -> None:
    below, above = references()["S02"].rows[-1][0], references()["S03"].rows[-1][0]
    assert abs(below) < mp.pi < above


def test_cases_cover_what_was_asked() -> None:
    kinds = {case.kind for case in CASES.values()}
    assert kinds == {"dynamics", "motion", "energy", "period"}
    assert len(all_cases()) >= 47
    assert {case.chain["links"] for case in CASES.values()} >= {1, 2, 4, 64, 256}
    assert all(isinstance(case, Case) for case in CASES.values())
