"""Levels that a curve reaches and leaves again between two of its points."""

from __future__ import annotations

import numpy as np
import pytest

from phichain.continuation import Engine, Fold, Level, Options, follow, start_on
from tests.continuation.problems import CIRCLE


@pytest.mark.parametrize("beyond", [0.02, 0.05, 0.09])
def test_a_level_that_is_reached_and_left_within_a_step_ends_the_run(beyond: float) -> None:
    """On the circle x turns between two points at -0.1 and 0.1 rad: what lies above both of them is met where it is reached first."""
    engine = Engine(options=Options(step=0.2, step_max=0.2, aim_angle=0.2))
    start = start_on(CIRCLE, np.array([np.cos(0.1), -np.sin(0.1)]), np.array([0.1, 1.0]), engine)
    high = Level(lambda z: float(z[0]), float(np.cos(beyond)), "high")
    branch = follow(CIRCLE, start, engine, [Fold(0, "turn"), high])
    assert branch.reason == "ended by the event 'high'" and len(branch) == 2
    assert branch.points[-1] == pytest.approx([np.cos(beyond), -np.sin(beyond)], abs=1e-9)
    # The turn lies beyond the end.
    assert [event.kind for event in branch.events] == ["high"]
