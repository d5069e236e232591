"""Two zeros of a function within one step, between points at which it has one sign."""

from __future__ import annotations

import numpy as np
import pytest

from phichain.continuation import (
    Engine,
    Evaluation,
    Fold,
    Level,
    Options,
    Problem,
    Quantity,
    follow,
    start_on,
)
from phichain.continuation.met import pairs
from tests.continuation.problems import problem_of


def run(of, step: float, *, in_pairs: bool = True, order=None):
    """Along the x axis from -1, slightly bent so that arclength is not x."""
    problem = problem_of(
        lambda z: np.array([z[1] - 0.1 * np.sin(z[0])]), lambda z: np.array([[-0.1 * np.cos(z[0]), 1.0]]), ("x", "y")
    )
    engine = Engine(options=Options(step=step, step_max=step, max_points=int(2.2 / step)))
    start = start_on(problem, np.array([-1.0, -0.1 * np.sin(1.0)]), np.array([1.0, 0.0]), engine)
    return follow(problem, start, engine, [Quantity(lambda point: of(point.y[0]), "zero", in_pairs=in_pairs, order=order)])


@pytest.mark.parametrize("step", [0.2, 0.13, 0.07])
@pytest.mark.parametrize("half", [0.04, 0.01, 0.002])
def test_both_zeros_of_a_dip_are_found(half: float, step: float) -> None:
    """A parabola with a quartic, so that no three places give it exactly."""

    def dip(x: float) -> float:
        u = x - 0.1234
        return (u**2 - half**2) * (1 + 0.5 * u + 2 * u**2)

    branch = run(dip, step)
    assert [event.z[0] for event in branch.events] == pytest.approx([0.1234 - half, 0.1234 + half], abs=1e-10)
    for event in branch.events:
        assert branch.arclength[event.index] <= event.arclength <= branch.arclength[event.index + 1]
    if half < step / 8:
        assert len(run(dip, step, in_pairs=False).events) in (0, 2)


def test_a_dip_that_stays_above_zero_is_none() -> None:
    assert not run(lambda x: (x - 0.1234) ** 2 + 1e-5, 0.13).events
    assert not run(lambda x: -((x - 0.1234) ** 2) - 1e-5, 0.13).events


@pytest.mark.parametrize("step", [0.2, 0.07])
@pytest.mark.parametrize("half", [1e-3, 1e-6])
@pytest.mark.parametrize("steep", [0.0, 9.0])
def test_two_zeros_however_close_are_found_by_what_they_exchange(half: float, step: float, steep: float) -> None:
    """Signs that pass each other at 0.1234, of a function whose least value lies at no three points, or does, and is found once."""

    def discriminant(x: float) -> float:
        return ((x - 0.1234) ** 2 - half**2) * float(np.exp(steep * x))

    def order(point) -> tuple[int, ...] | None:
        x = point.y[0] - 0.1234
        return None if abs(x) < half else (1, -1) if x < 0 else (-1, 1)

    branch = run(discriminant, step, order=order)
    assert [event.z[0] for event in branch.events] == pytest.approx([0.1234 - half, 0.1234 + half], abs=1e-10)


@pytest.mark.parametrize("step", [0.25, 0.13])
@pytest.mark.parametrize("half", [1e-3, 1e-6])
def test_what_passes_several_others_in_one_step_is_met_at_each(half: float, step: float) -> None:
    """One label passes three others, and another one goes away on the way: at each of the three two zeros, none where that goes."""
    places, gone = (0.10, 0.1234, 0.137), 0.143

    def discriminant(x: float) -> float:
        return float(np.prod([(x - place) ** 2 - half**2 for place in places])) * float(np.exp(3 * x))

    def order(point) -> tuple[int, ...] | None:
        x = point.y[0]
        if any(abs(x - place) < half for place in places):
            return None
        passed = sum(x > place for place in places)
        labels = (*(-1,) * passed, 1, *(-1,) * (3 - passed))
        return labels if x < gone else (*labels[:-1], labels[-1], -1)

    branch = run(discriminant, step, order=order)
    assert [event.z[0] for event in branch.events] == pytest.approx([place + side * half for place in places for side in (-1, 1)], abs=1e-10)


def along(height, slope, step: float, tests, seen: list[float] | None = None):
    """Along y = height(x) from x = -1, with the places of all evaluations."""
    seen = [] if seen is None else seen

    def evaluate(z: np.ndarray) -> Evaluation:
        seen.append(float(z[0]))
        return Evaluation(np.array([z[1] - height(z[0])]), np.array([[-slope(z[0]), 1.0]]))

    engine = Engine(options=Options(step=step, step_max=step, max_points=int(3.5 / step), max_angle=1.0, max_change=5.0))
    problem = Problem(evaluate, ("x", "y"))
    start = start_on(problem, np.array([-1.0, height(-1.0)]), np.array([1.0, 0.0]), engine)
    return follow(problem, start, engine, tests)


@pytest.mark.parametrize("step", [0.25, 0.13, 0.07])
@pytest.mark.parametrize("half", [0.04, 0.004, 4e-4])
def test_both_folds_of_a_bend_are_found(half: float, step: float) -> None:
    """y' = (u^2 - half^2) (1 + u / 2) where the tangent's component has one sign at all points: folds at u = -half and half."""

    def height(x: float) -> float:
        u = x - 0.1234
        return u**3 / 3 - half**2 * u + u**4 / 8 - half**2 * u**2 / 4

    def slope(x: float) -> float:
        u = x - 0.1234
        return (u**2 - half**2) * (1 + u / 2)

    branch = along(height, slope, step, [Fold(1)])
    assert [event.z[0] for event in branch.events] == pytest.approx([0.1234 - half, 0.1234 + half], abs=1e-10)


@pytest.mark.parametrize("step", [0.25, 0.13, 0.07])
def test_a_bend_that_does_not_turn_costs_little_and_one_that_is_far_from_it_nothing(step: float) -> None:
    def count(least: float, tests) -> int:
        seen: list[float] = []
        branch = along(lambda x: x**3 / 3 + least * x, lambda x: x**2 + least, step, tests, seen)
        assert not branch.events
        return len(seen)

    assert count(0.5, [Fold(1)]) == count(0.5, [])
    assert count(1e-5, [Fold(1)]) <= count(1e-5, []) + 12


@pytest.mark.parametrize(("half", "step"), [(0.01, 0.25), (0.01, 0.13), (0.003, 0.25), (0.003, 0.07)])
def test_a_run_ends_at_a_level_that_it_reaches_and_leaves_in_one_step(half: float, step: float) -> None:
    """y = half^2 - (x - 0.05)^2 is 0 at two places within one step: all points lie below, and only where it turns it is above."""

    def parabola(*tests):
        return along(lambda x: half**2 - (x - 0.05) ** 2, lambda x: -2 * (x - 0.05), step, [Fold(1), *tests])

    assert np.all(parabola().points[:, 1] < 0)
    branch = parabola(Level(lambda z: z[1], 0.0, "end"))
    assert branch.events[-1].kind == "end" and branch.status == "event"
    assert branch.points[-1] == pytest.approx([0.05 - half, 0.0], abs=1e-10)


PLACES = {
    "three": (-0.03, 0.01, 0.04), "three close": (-0.002, 0.0, 0.003), "two of three close": (-0.04, 0.02, 0.021), "four": (-0.04, -0.015, 0.01, 0.04),
    "five": (-0.045, -0.02, 0.001, 0.02, 0.04), "six": (-0.05, -0.03, -0.01, 0.012, 0.03, 0.05),
}  # fmt: skip


@pytest.mark.parametrize("step", [0.25, 0.13])
@pytest.mark.parametrize("name", PLACES)
def test_all_zeros_within_a_step_are_found_however_many(name: str, step: float) -> None:
    """Their product, bent so that no polynomial is it: an odd number shows one sign, an even one none."""

    def product(x: float) -> float:
        u = x - 0.1234
        return float(np.prod([u - place for place in PLACES[name]])) * float(np.exp(u)) / (1 + u * u)

    branch = run(product, step)
    assert [event.z[0] for event in branch.events] == pytest.approx([0.1234 + place for place in PLACES[name]], abs=1e-10)


@pytest.mark.parametrize("step", [0.25, 0.13])
@pytest.mark.parametrize("half", [0.05, 0.01, 0.001])
def test_three_folds_of_a_bend_are_found(half: float, step: float) -> None:
    """y' = u (u^2 - half^2) (1 + u / 2): the tangent's component changes its sign once from point to point, and three times between."""
    shape = np.polynomial.Polynomial([0, -(half**2), -(half**2) / 2, 1, 0.5])
    height = shape.integ()
    branch = along(lambda x: float(height(x - 0.1234)), lambda x: float(shape(x - 0.1234)), step, [Fold(1)])
    found = [event.z[0] for event in branch.events if abs(event.z[0] - 0.1234) < 0.1]
    assert found == pytest.approx([0.1234 - half, 0.1234, 0.1234 + half], abs=1e-10)


def test_zeros_are_looked_for_so_often_and_not_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """Eight within a step, told two by two: where rounding makes more and more of them a search has to end, too."""
    places = np.linspace(-0.055, 0.055, 8)

    def product(x: float) -> float:
        return float(np.prod(8 * (x - 0.1234 - places))) * float(np.exp(x))

    assert len(run(product, 0.25).events) == 8
    monkeypatch.setattr(pairs, "ROUNDS", 3)
    assert len(run(product, 0.25).events) == 6


def test_one_zero_in_a_step_is_one() -> None:
    assert len(run(lambda x: x - 0.1234 + 2 * (x - 0.1234) ** 3, 0.2).events) == 1
    assert len(run(lambda x: float(np.sinh(3 * (x - 0.1234))), 0.13).events) == 1
