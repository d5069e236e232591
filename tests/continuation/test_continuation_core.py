"""The continuation core on problems whose folds, branch points and curves are known."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from phichain.continuation import (
    BranchPoint,
    Engine,
    Extremum,
    Fold,
    Level,
    Options,
    correctors,
    follow,
    predictors,
    start_on,
)
from phichain.errors import ConvergenceError
from tests.continuation.problems import CIRCLE, PARABOLA, problem_of

EVERY_PART = [
    Engine(predictor, corrector)
    for predictor in (predictors.tangent, predictors.secant, predictors.cubic)
    for corrector in (correctors.pseudo_arclength, correctors.moore_penrose)
]


@pytest.mark.parametrize("engine", EVERY_PART, ids=lambda e: f"{e.predictor.__name__}-{e.corrector.__name__}")
def test_the_fold_of_a_parabola(engine: Engine) -> None:
    start = start_on(PARABOLA, np.array([-1.0, -1.0]), np.array([1.0, 0.0]), engine)
    stop = Level(lambda z: z[0], 1.0, "end")
    branch = follow(PARABOLA, start, engine, [Fold(), BranchPoint(), stop])
    assert [event.kind for event in branch.events] == ["fold", "end"]
    assert np.max(np.abs(branch.located("fold")[0].z)) < 1e-14
    assert branch.status == "event" and branch.points[-1] == pytest.approx([1.0, -1.0], abs=1e-12)
    assert np.max(np.abs(branch.points[:, 0] ** 2 + branch.points[:, 1])) < 1e-14
    assert np.all(np.diff(branch.arclength) > 0)
    # The length of y = x^2 between -1 and 1, which chords approach from below.
    exact = np.sqrt(5) + np.arcsinh(2) / 2
    assert 0.995 * exact < branch.arclength[-1] < exact


def test_a_pitchfork_is_located_from_either_branch() -> None:
    """(x - y)(l - (x - y)^2) = 0 with y = l / 3: branches cross at the origin, also seen from the curved one."""

    def residual(z: np.ndarray) -> np.ndarray:
        w = z[0] - z[1] / 3
        return np.array([w * (z[1] - w**2)])

    def jacobian(z: np.ndarray) -> np.ndarray:
        w = z[0] - z[1] / 3
        by_w = z[1] - 3 * w**2
        return np.array([[by_w, w - by_w / 3]])

    problem = problem_of(residual, jacobian, ("x", "l"))
    tests = [Fold(), BranchPoint(), Level(lambda z: abs(z[0]), 2.0)]
    straight = follow(
        problem, start_on(problem, np.array([-0.31, -1.0]), np.array([0, 1.0]), Engine()), tests=tests
    )
    curved = follow(
        problem, start_on(problem, np.array([-0.7, 1.0]), np.array([1.0, -1.0]), Engine()), tests=tests
    )
    for branch in (straight, curved):
        (at,) = branch.located("branch point")
        assert np.max(np.abs(at.z)) < 1e-7
    assert np.allclose(straight.points[:, 0], straight.points[:, 1] / 3)
    w = curved.points[:, 0] - curved.points[:, 1] / 3
    assert np.allclose(w**2, curved.points[:, 1], atol=1e-12) and w[0] < 0 < w[-1]
    assert len(straight.located("fold")) == 0 and len(curved.located("fold")) == 1


def test_a_transcritical_point_and_a_cubic_of_two_folds() -> None:
    crossing = problem_of(
        lambda z: np.array([z[0] * (z[1] - z[0])]), lambda z: np.array([[z[1] - 2 * z[0], z[0]]]), ("x", "l")
    )
    start = start_on(crossing, np.array([0.0, -0.73]), np.array([0, 1.0]), Engine())
    branch = follow(crossing, start, tests=[Fold(), BranchPoint(), Level(lambda z: z[1], 1.0)])
    assert [event.kind for event in branch.events] == ["branch point", "level"]
    assert np.max(np.abs(branch.events[0].z)) < 1e-10
    cubic = problem_of(
        lambda z: np.array([z[0] ** 3 - z[0] - z[1]]),
        lambda z: np.array([[3 * z[0] ** 2 - 1, -1.0]]),
        ("x", "l"),
    )
    start = start_on(cubic, np.array([-2.0, -6.0]), np.array([1.0, 0]), Engine())
    branch = follow(cubic, start, tests=[Fold(), BranchPoint(), Level(lambda z: z[0], 2.0)])
    folds = np.array([event.z for event in branch.located("fold")])
    assert np.allclose(folds, [[-(3**-0.5), 2 * 3**-1.5], [3**-0.5, -2 * 3**-1.5]], atol=1e-12)
    assert not branch.located("branch point")


def chebyshev(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Chebyshev points on [0, 1] and their differentiation matrix (Trefethen 2000)."""
    x = np.cos(np.pi * np.arange(n + 1) / n)
    weights = np.r_[2, np.ones(n - 1), 2] * (-1) ** np.arange(n + 1)
    gap = x[:, None] - x
    D = np.outer(weights, 1 / weights) / (gap + np.eye(n + 1))
    D -= np.diag(D.sum(axis=1))
    return (x + 1) / 2, 2 * D


def test_bratu_folds_where_it_should() -> None:
    """u'' + l exp(u) = 0, u(0) = u(1) = 0 folds at l = 3.513830719 (Bratu 1914), spectrally discretised."""
    n = 24
    D2 = np.linalg.matrix_power(chebyshev(n)[1], 2)[1:-1, 1:-1]
    names = (*(f"u_{k}" for k in range(n - 1)), "l")
    problem = problem_of(
        lambda z: D2 @ z[:-1] + z[-1] * np.exp(z[:-1]),
        lambda z: np.column_stack([D2 + np.diag(z[-1] * np.exp(z[:-1])), np.exp(z[:-1])]),
        names,
    )
    start = start_on(problem, np.zeros(n), np.eye(n)[-1], Engine())
    branch = follow(
        problem,
        start,
        Engine(options=Options(step_max=0.5)),
        [Fold(), BranchPoint(), Level(lambda z: z[n // 2 - 1], 4.0)],
    )
    (fold,) = branch.located("fold")
    assert abs(fold.z[-1] - 3.513830719125162) < 1e-10
    assert fold.z[n // 2 - 1] == pytest.approx(1.1868421, abs=1e-6)
    assert not branch.located("branch point") and branch.column("l")[-1] < 3


def test_a_closed_curve_ends_at_its_start() -> None:
    start = start_on(CIRCLE, np.array([1.0, 0.1]), np.array([0, 1.0]), Engine())
    branch = follow(CIRCLE, start, Engine(options=Options(step_max=0.1)))
    assert branch.status == "closed"
    assert len(branch.located("fold")) == 2
    assert 2 * np.pi < branch.arclength[-1] < 2 * np.pi + 0.11
    assert np.allclose(np.abs([event.z[1] for event in branch.located("fold")]), 1) or np.allclose(
        np.abs([event.z[0] for event in branch.located("fold")]), 1
    )


def test_extrema_and_levels_of_a_scalar() -> None:
    start = start_on(CIRCLE, np.array([1.0, 0.0]), np.array([0, 1.0]), Engine())
    height = Extremum(lambda z: z[0] + z[1], "highest")
    branch = follow(CIRCLE, start, tests=[height, Level(lambda z: z[0], -0.5, "left", terminal=True)])
    assert [event.kind for event in branch.events] == ["highest", "left"]
    assert branch.events[0].z == pytest.approx([np.sqrt(0.5), np.sqrt(0.5)], abs=1e-9)
    assert branch.events[1].z == pytest.approx([-0.5, np.sqrt(0.75)], abs=1e-12)


def test_newton_converges_quadratically() -> None:
    found = correctors.pseudo_arclength(
        CIRCLE, np.array([1.3, 0.5]), np.array([0.1, 0.9]), Options(tol=1e-14)
    )
    sizes = np.array(found.corrections)
    assert found.converged and found.residual < 3e-16
    rates = np.log(sizes[1:4]) - 2 * np.log(sizes[:3])
    assert len(sizes) >= 4 and np.all(np.abs(np.diff(rates)) < 0.5)


def test_newton_failing_is_said() -> None:
    nowhere = problem_of(lambda z: np.array([z[0] ** 2 + 1]), lambda z: np.array([[2 * z[0], 0.0]]), ("x", "l"))
    with pytest.raises(ConvergenceError, match="did not reach the branch"):
        start_on(nowhere, np.array([0.5, 0.0]), np.array([1.0, 0.0]), Engine(), fixed=True)


def test_a_curve_that_ends_is_left_with_its_reason() -> None:
    """x = sqrt(l) has no continuation below l = 0 when negative values are not numbers."""

    def residual(z: np.ndarray) -> np.ndarray:
        with np.errstate(invalid="ignore"):
            return np.array([z[0] - 1 + np.sqrt(z[1])])

    def jacobian(z: np.ndarray) -> np.ndarray:
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.array([[1.0, 0.5 / np.sqrt(z[1])]])

    problem = problem_of(residual, jacobian, ("x", "l"))
    start = start_on(problem, np.array([0.0, 1.0]), np.array([1.0, 0]), Engine())
    branch = follow(problem, start, Engine(options=Options(step_min=1e-4)), [])
    assert branch.status == "step" and "step_min" in branch.reason
    assert 0 < branch.column("l")[-1] < 1e-2


@pytest.mark.parametrize("gap", [1e-1, 1e-3, 1e-4, 1e-5])
def test_an_avoided_crossing_is_not_jumped_over(gap: float) -> None:
    """x^2 - l^2 = gap^2: two branches 2 gap apart that turn by a right angle; a run stays on its own."""
    problem = problem_of(
        lambda z: np.array([z[0] ** 2 - z[1] ** 2 - gap**2]),
        lambda z: np.array([[2 * z[0], -2 * z[1]]]),
        ("x", "l"),
    )
    start = start_on(problem, np.array([1.0, -1.0]), np.array([-1.0, 1.0]), Engine())
    tests = [Fold(), BranchPoint(), Fold(0, "turn in x"), Level(lambda z: z[1], 1.0)]
    branch = follow(problem, start, tests=tests)
    assert np.min(branch.column("x")) > 0.9 * gap and branch.points[-1, 1] == pytest.approx(1)
    assert branch.located("turn in x")[0].z == pytest.approx([gap, 0.0], abs=1e-9)
    assert not branch.located("branch point")


@given(st.floats(-3, 3), st.floats(0.2, 5), st.floats(0.1, 10))
def test_scaling_unknowns_changes_nothing_but_the_steps(at: float, size: float, unit: float) -> None:
    """The fold of size (x - at)^2 + l = 0 is found whatever the units of x."""
    problem = problem_of(
        lambda z: np.array([size * (z[0] - at) ** 2 + z[1]]),
        lambda z: np.array([[2 * size * (z[0] - at), 1.0]]),
        ("x", "l"),
        scale=np.array([unit, 1.0]),
    )
    start = start_on(problem, np.array([at - 1, -size]), np.array([1.0, 0]), Engine())
    branch = follow(problem, start, tests=[Fold(), Level(lambda z: z[0], at + 1)])
    (fold,) = branch.located("fold")
    assert fold.z == pytest.approx([at, 0.0], abs=1e-11 * (1 + abs(at)) * max(1, unit))
    slope = branch.tangent
    assert np.allclose(np.linalg.norm(slope / branch.scale, axis=1), 1)
    assert np.allclose(2 * size * (branch.points[:, 0] - at) * slope[:, 0] + slope[:, 1], 0, atol=1e-9)
