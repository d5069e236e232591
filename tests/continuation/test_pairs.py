"""Two zeros of a function within one step, between points at which it has one sign."""

from __future__ import annotations

import numpy as np
import pytest

from phichain.continuation import Engine, Options, Quantity, follow, start_on
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
