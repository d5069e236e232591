"""Crossings that a small term opens: x y = delta, whose branches are hyperbolas half a width sqrt(delta) from the centre."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from phichain.continuation import Branch, BranchPoint, Engine, Evaluation, Level, Options, follow, start_on
from phichain.continuation.events import signed
from phichain.continuation.met.gaps import gap_between
from phichain.continuation.met.locate import way_through
from phichain.continuation.met.passage import is_crossed_smoothly
from phichain.continuation.point import Point, tangent_of
from phichain.continuation.problem import Extra
from phichain.continuation.record import point_of
from tests.continuation.problems import problem_of

AWAY = np.array([1.0, -2.0])
"""Where the branches cross, in u and v."""


def crossing(delta: float, bend: float = 0.0):
    """u (v - bend u^2) = delta, moved, and turned by 0.3 rad so that no axis is special."""
    c, s = np.cos(0.3), np.sin(0.3)
    turn = np.array([[c, s], [-s, c]])

    def residual(z: np.ndarray) -> np.ndarray:
        u, v = turn @ z - AWAY
        return np.array([u * (v - bend * u**2) - delta])

    def jacobian(z: np.ndarray) -> np.ndarray:
        u, v = turn @ z - AWAY
        return np.array([[v - 3 * bend * u**2, u]]) @ turn

    return problem_of(residual, jacobian, ("x", "y")), turn


def run(
    delta: float, through: float = 0.0, step_max: float = 0.1, bend: float = 0.0, mark: float | None = None, is_end: bool = False
) -> tuple[Branch, np.ndarray]:
    """A run towards the crossing; `mark` is a value of u whose passing is an event, which ends it where `is_end`."""
    problem, turn = crossing(delta, bend)
    engine = Engine(options=Options(step=min(0.01, step_max), step_max=step_max, max_points=700))
    begin = turn.T @ (np.array([-1.0, -delta + bend]) + AWAY)
    start = start_on(problem, begin, turn.T @ np.array([1.0, 0.0]), engine)
    ends = [Level(lambda z: float(np.max(np.abs(turn @ z - AWAY))), 1.1, "far")]
    if mark is not None:
        ends.append(Level(lambda z: float((turn @ z - AWAY)[0]), mark, "mark", terminal=is_end))
    branch = follow(problem, start, engine, [BranchPoint(), *ends], through=through)
    return branch, turn


@pytest.mark.parametrize("step_max", [2.0, 0.5, 0.1, 0.004])
@pytest.mark.parametrize("width", [1e-3, 5.5e-5, 1e-5, 5e-6])
def test_a_run_turns_at_a_gap_and_measures_it(width: float, step_max: float) -> None:
    branch, turn = run(width**2, step_max=step_max)
    assert turn @ branch.points[-1] - AWAY == pytest.approx([-(width**2) / 1.1, -1.1], abs=1e-9)
    (gap,) = branch.passages
    assert gap.width == pytest.approx(width, rel=0.2) and not gap.is_crossed
    assert turn @ gap.z - AWAY == pytest.approx([-width, -width], abs=0.3 * width)
    assert not branch.located("branch point")
    assert len(branch) < 100 + 2.5 / step_max


@pytest.mark.parametrize("step_max", [0.5, 0.02])
def test_a_run_goes_across_on_request(step_max: float) -> None:
    branch, turn = run(1e-8, through=2e-4, step_max=step_max)
    assert turn @ branch.points[-1] - AWAY == pytest.approx([1.1, 1e-8 / 1.1], abs=1e-9)
    (gap,) = branch.passages
    assert gap.is_crossed and gap.width == pytest.approx(1e-4, rel=0.2)
    assert np.all(np.diff(branch.arclength) > 0)
    wider, _ = run(1e-8, through=5e-5, step_max=step_max)
    assert not wider.passages[0].is_crossed


@pytest.mark.parametrize("step_max", [0.5, 0.1, 0.013])
def test_a_branch_point_is_stepped_over_and_found(step_max: float) -> None:
    """No creeping towards it, no gap named, and its place right to the last digits although Newton stalls there."""
    branch, turn = run(0.0, step_max=step_max, bend=0.7)
    assert turn @ branch.points[-1] - AWAY == pytest.approx([1.1, 0.7 * 1.1**2], abs=1e-9)
    (event,) = branch.located("branch point")
    assert turn @ event.z == pytest.approx(AWAY, abs=1e-11)
    assert not branch.passages and len(branch) < 40 + 2.5 / step_max


@pytest.mark.parametrize("reach", [0.1, 0.05, 0.01, 1e-3, 1.2e-4])
def test_a_step_across_a_narrow_gap_is_seen_whatever_its_length(reach: float) -> None:
    """It lands on the other branch with a smooth look, and det [J; t] changes its sign as over a branch point."""
    for delta, is_smooth in ((1e-9, False), (0.0, True)):
        problem, turn = crossing(delta, 0.7)

        def point(u: float, s: float, problem=problem, turn=turn, delta=delta) -> Point:
            y = turn.T @ (np.array([u, delta / u + 0.7 * u**2]) + AWAY)
            jacobian = problem.at(y).jacobian
            return Point(y, tangent_of(jacobian, turn.T @ np.array([1.0, 0.0])), s, jacobian, 0.0, 1, (), Extra())

        seen: list[float] = []
        ends = point(-reach, 0.0), point(1.3 * reach, 2.3 * reach)
        counting = replace(problem, evaluate=lambda z, problem=problem, seen=seen: seen.append(z[0]) or problem.evaluate(z))
        assert is_crossed_smoothly(counting, *ends, Engine()) is is_smooth
        # A jump is told from a zero by a bracket of a hundredth of the step, and not halved to its last digits.
        assert len(seen) < 100


@pytest.mark.parametrize("reach", [0.3, 0.1, 0.01, 1e-3])
def test_the_polynomial_beside_a_singular_point_tells_a_gap_from_it(reach: float) -> None:
    """Where it is the curve to round-off nothing else needs to be looked at; across a gap it is none, wide or narrow."""
    along = np.array([1.0, 0.0])
    for width in (0.0, 1e-7, 3e-6, 1e-4, 1e-2):
        problem, turn = crossing(width**2, 0.7)
        ends = []
        for u in (-reach, 1.3 * reach):
            y = turn.T @ (np.array([u, width**2 / u + 0.7 * u**2]) + AWAY)
            jacobian = problem.at(y).jacobian
            ends.append(Point(y, tangent_of(jacobian, turn.T @ along), u, jacobian, 0.0, 1, (), Extra()))
        _, is_smooth = way_through(problem, *ends, BranchPoint(), Engine(), ())
        assert is_smooth is (width == 0)


@pytest.mark.parametrize("step_max", [0.5, 0.1, 0.03, 0.004])
@pytest.mark.parametrize("width", [2.5e-6, 1e-6, 3e-7])
def test_what_no_step_tells_from_a_branch_point_is_crossed(width: float, step_max: float) -> None:
    """Whatever the step: a run that saw the gap goes on where one that stepped over it does."""
    branch, turn = run(width**2, step_max=step_max, bend=0.7)
    u, v = turn @ branch.points[-1] - AWAY
    assert u > 1 and v == pytest.approx(0.7 * u**2, abs=1e-9)
    # The one that saw it names the gap besides.
    (event,) = branch.located("branch point")
    assert turn @ event.z == pytest.approx(AWAY, abs=3 * width)
    assert all(gap.is_crossed and gap.width == pytest.approx(width, rel=0.3) for gap in branch.passages)


@pytest.mark.parametrize("step_max", [0.5, 0.02])
@pytest.mark.parametrize("mark", [-3e-3, 4e-3])
def test_what_lies_on_the_way_across_a_gap_is_met(mark: float, step_max: float) -> None:
    """The step that leads across goes from a hundred half widths before the gap to as many beyond; nothing vanishes in the gap itself."""
    branch, turn = run(1e-8, through=2e-4, step_max=step_max, mark=mark)
    assert [event.kind for event in branch.events] == ["mark", "far"] and branch.passages[0].is_crossed
    assert (turn @ branch.events[0].z - AWAY)[0] == pytest.approx(mark, abs=1e-12)
    ended, _ = run(1e-8, through=2e-4, step_max=step_max, mark=mark, is_end=True)
    assert (ended.status, ended.reason) == ("event", "ended by the event 'mark'")
    assert turn @ ended.points[-1] - AWAY == pytest.approx([mark, 1e-8 / mark], abs=1e-11)


@pytest.mark.parametrize("least", [1e-2, 1e-3, 1e-4])
@pytest.mark.parametrize("delta", [0.0, 1e-9])
def test_how_far_a_singular_value_reaches_is_no_matter(least: float, delta: float) -> None:
    """Away from the place another one is the smallest, so that it is much steeper there than over the whole step."""
    plane, turn = crossing(delta)

    def residual(z: np.ndarray) -> np.ndarray:
        return np.append(plane.evaluate(z[:2]).residual, least * z[2])

    def jacobian(z: np.ndarray) -> np.ndarray:
        whole = np.zeros((2, 3))
        whole[0, :2], whole[1, 2] = plane.evaluate(z[:2]).jacobian[0], least
        return whole

    problem = problem_of(residual, jacobian, ("x", "y", "z"))

    def point(u: float) -> Point:
        y = np.append(turn.T @ (np.array([u, delta / u]) + AWAY), 0.0)
        rows = problem.at(y).jacobian
        return Point(y, tangent_of(rows, np.append(turn.T @ np.array([1.0, 0.0]), 0.0)), u, rows, 0.0, 1, (), Extra())

    assert is_crossed_smoothly(problem, point(-0.1), point(0.08), Engine()) is (delta == 0)


def test_a_gap_is_not_measured_where_the_equations_are_no_numbers() -> None:
    """A motion that cannot be followed between the points of a run leaves nothing to fit, and no error either."""
    branch, _ = run(1e-6)
    problem, _ = crossing(1e-6)
    k = int(np.argmin(np.abs(branch.arclength - branch.passages[0].arclength)))
    near, engine = [point_of(problem, branch, i) for i in (k - 1, k, k + 1)], Engine(options=Options(step=0.01, step_max=0.1))
    nowhere = replace(problem, evaluate=lambda z: Evaluation(np.full(1, np.nan), np.full((1, 2), np.nan)))
    assert gap_between(problem, near, engine) is not None and gap_between(nowhere, near, engine) is None
    assert np.isnan(signed(np.full((3, 3), np.nan)))


def test_nothing_is_measured_where_the_jacobian_is_no_numbers() -> None:
    """Orbits end within a step, as where gravity vanishes: three points that look like a gap, and no numbers between them."""
    nowhere = problem_of(lambda z: np.full(2, np.nan), lambda z: np.full((2, 3), np.nan), ("x", "y", "l"))
    near = [
        Point(np.array([s, 0.0, 0.0]), np.array([1.0, 0.0, 0.0]), s, np.array([[0.0, np.hypot(s, 1e-3), 0.0], [0.0, 0.0, 1.0]]), 0.0, 1, (), Extra())
        for s in (-1e-3, 0.0, 1.3e-3)
    ]
    assert gap_between(nowhere, near, Engine()) is None


def test_a_run_ends_at_its_last_numbers() -> None:
    """A test function that has no numbers at a new point ends the run with a reason, as a step that gets too small does."""

    class Beyond:
        name, terminal = "beyond", False

        def value(self, problem: object, point: Point) -> float:
            if point.y[0] > 0.5:
                raise np.linalg.LinAlgError("SVD did not converge")
            return 1.0

    line = problem_of(lambda z: z[1:2], lambda z: np.array([[0.0, 1.0]]), ("x", "y"))
    start = start_on(line, np.array([0.0, 0.0]), np.array([1.0, 0.0]), Engine())
    branch = follow(line, start, Engine(options=Options(step=0.1, step_max=0.1)), [Beyond()])
    assert branch.status == "step" and "the Jacobian is no numbers" in branch.reason
    assert 0.3 < branch.points[-1][0] <= 0.5
