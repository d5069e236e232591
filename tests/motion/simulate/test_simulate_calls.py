"""What `simulate` costs beside the flow underneath, counted: calls of Python and of C functions, which no other load changes."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from phichain import build
from phichain.motion import simulate
from tests.flow.flows import planar

WANT = {"want": ["propagate", "forward_dynamics", "energy", "state_jacobian"]}


def calls(run: Callable[[], Any]) -> int:
    """How many functions are entered, once everything that is kept from run to run is there."""
    run()
    entered: list[str] = []
    sys.setprofile(lambda _, event, __: entered.append(event))
    try:
        run()
    finally:
        sys.setprofile(None)
    return entered.count("call") + entered.count("c_call") - 1  # setprofile itself


@pytest.mark.parametrize("links", [1, 2])
def test_a_short_run_is_not_made_of_calls(links: int) -> None:
    """Was 226 for a run on its own steps."""
    system = build(planar(links, f"counted{links}", functions=WANT))
    q, v = np.full(links, 0.4), np.zeros(links)
    assert calls(lambda: simulate(system, (q, v), (0.0, 2.0), method="taylor", tol=1e-12)) <= 176
    assert calls(lambda: system.function("propagate")(q, v, 0.0, 2.0, 1e-12)) <= 42


def test_more_steps_are_no_more_calls() -> None:
    """All of a run is one call of C, however long it is."""
    system = build(planar(1, "counted1", functions=WANT))
    short, long = (calls(lambda end=end: simulate(system, ([0.4], [0.0]), (0.0, end), method="taylor", tol=1e-12)) for end in (1.0, 50.0))
    assert short == long


def test_nobody_writes_to_what_a_run_left() -> None:
    """Arrays are handed on without a copy, and none of them can be written to."""
    found = simulate(build(planar(2, "counted2", functions=WANT)), ([0.4, 0.1], [0.0, 0.0]), (0.0, 1.0), method="taylor")
    for array in (found.t, found.q, found.v):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0
