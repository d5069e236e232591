"""Where branches cross, on curves that bend close by within less than a step: their places are chosen."""

from __future__ import annotations

import numpy as np
import pytest

from phichain.continuation import BranchPoint, Engine, Level, Options, follow, start_on
from tests.continuation.problems import problem_of

PLACE = 0.7


@pytest.mark.parametrize("step_max", [0.5, 0.1, 0.02])
@pytest.mark.parametrize(("bend", "within"), [(0.1, 1.5e-3), (0.03, 4e-3), (0.03, 1.5e-3), (0.3, 1e-2)])
def test_a_crossing_lies_where_it_does_however_soon_the_curve_bends(bend: float, within: float, step_max: float) -> None:
    """(x - 0.7) (y - f(x)) = 0, where f turns by `bend` rad and back `within` so much of the crossing: no step is shorter for that."""
    away = PLACE + 0.4 * within

    def f(x: float) -> float:
        return float(bend * within * np.arctan((x - away) / within))

    def jacobian(z: np.ndarray) -> np.ndarray:
        slope = bend / (1 + ((z[0] - away) / within) ** 2)
        return np.array([[z[1] - f(z[0]) - (z[0] - PLACE) * slope, z[0] - PLACE]])

    problem = problem_of(lambda z: np.array([(z[0] - PLACE) * (z[1] - f(z[0]))]), jacobian, ("x", "y"))
    engine = Engine(options=Options(step=min(0.02, step_max), step_max=step_max))
    start = start_on(problem, np.array([0.0, f(0.0)]), np.array([1.0, 0.0]), engine)
    branch = follow(problem, start, engine, [BranchPoint(), Level(lambda z: float(z[0]), 1.5, "far")])
    (event,) = branch.located("branch point")
    assert event.z == pytest.approx([PLACE, f(PLACE)], abs=1e-10)
