"""A bound flow is the flow to the last bit, call after call in the same memory, and leaves nothing of one call to the next."""

from __future__ import annotations

import math
import sys
from types import FrameType
from typing import Any

import numpy as np
import pytest

from phichain.errors import ArrayError, ToleranceError, UnsupportedError
from phichain.system.propagation import Stop
from tests.flow.flows import compiled, planar

CHAIN = planar(2, "bound", functions={"want": ["propagate"]}, flow={"variational": True})
STARTS = (([0.7, -0.4], [0.3, 1.0]), ([-2.9, 0.2], [4.0, -7.0]), ([0.7, -0.4], [0.3, 1.0]))


def test_calls_are_those_of_the_flow_whatever_went_before() -> None:
    """Long and short runs in turn, with all columns: also beyond the steps after which C looks for Ctrl-C."""
    propagate = compiled(CHAIN)
    bound = propagate.bind(1e-12, columns=4)
    for (q, v), span in zip(STARTS, ((0.0, 0.4), (1.0, 21.0), (0.5, -0.2)), strict=True):
        bound.q[:], bound.v[:], bound.transition[:] = q, v, np.eye(4)
        end = bound(*span)
        found = propagate(q, v, *span, 1e-12, transition=np.eye(4))
        assert (end, bound.outcome, bound.steps) == (found.t, found.outcome, found.steps)
        assert bound.q.tolist() == found.q.tolist() and bound.v.tolist() == found.v.tolist()
        assert bound.transition.tolist() == found.transition.tolist() and bound.lost.tolist() == found.lost.tolist()
    assert propagate(*STARTS[1], 1.0, 21.0, 1e-12).steps > 512


def test_a_stop_and_a_budget_stay() -> None:
    propagate, stop = compiled(CHAIN), Stop("q", 0)
    bound = propagate.bind(1e-12, stop=stop)
    assert bound.transition is None
    for q, v in STARTS[:2]:
        bound.q[:], bound.v[:] = q, v
        found = propagate(q, v, 0.0, 9.0, 1e-12, stop=stop)
        assert bound(0.0, 9.0) == found.t < 9.0 and bound.outcome == "event" and bound.q.tolist() == found.q.tolist()
    few = propagate.bind(1e-12, max_steps=3)
    few.q[:], few.v[:] = STARTS[0]
    reached = few(0.0, 9.0)
    assert few.outcome == "step budget" and few.steps == 3
    few(reached, 9.0)
    assert few.steps == 3 and few.outcome == "step budget"


def test_all_that_moves_is_one_vector() -> None:
    bound = compiled(CHAIN).bind(1e-12, columns=4)
    for q, v in STARTS[:2]:
        bound.state[:] = [*q, *v, *np.eye(4).ravel()]
        bound(0.0, 0.4)
        found = compiled(CHAIN)(q, v, 0.0, 0.4, 1e-12, transition=np.eye(4))
        assert found.transition is not None
        assert bound.state.tolist() == [*found.q, *found.v, *found.transition.ravel()]
        assert bound.transition.tolist() == found.transition.tolist()
    assert compiled(CHAIN).bind(1e-12).state.shape == (4,)


def test_a_call_hands_over_one_address() -> None:
    """What a call costs is what it does in Python: one function, a few bytecodes, and one number that ctypes converts."""
    bound = compiled(CHAIN).bind(1e-12, columns=4)
    bound.state[:] = [*STARTS[0][0], *STARTS[0][1], *np.eye(4).ravel()]
    handed: list[int] = []
    done: list[str] = []
    inside, bound._go = bound._go, lambda *given: handed.append(len(given)) or inside(*given)

    def watch(frame: FrameType, event: str, _: Any) -> Any:
        if frame.f_code is not type(bound).__call__.__code__:
            return None
        frame.f_trace_opcodes = True
        done.append(event)
        return watch

    before = sys.gettrace()
    sys.settrace(watch)
    try:
        assert bound(0.0, 0.4) == 0.4
    finally:
        sys.settrace(before)
    assert handed == [1]
    assert done.count("call") == 1 and done.count("opcode") <= 36


def test_a_start_that_is_not_finite_ends_as_such() -> None:
    bound = compiled(CHAIN).bind(1e-12)
    bound.q[:], bound.v[:] = [math.nan, 0.0], 0.0
    bound(0.0, 1.0)
    assert bound.outcome == "not finite"
    bound.q[:] = 0.1
    assert bound(0.0, 1.0) == 1.0 and bound.outcome == "done"
    with pytest.raises(TypeError):
        bound(0.0, "soon")


def test_what_stays_is_checked_once() -> None:
    bind = compiled(CHAIN).bind
    with pytest.raises(ToleranceError, match=r"propagate\.tol"):
        bind(-1.0)
    for columns in (-1, 5.5):
        with pytest.raises(ArrayError, match=r"propagate\.columns"):
            bind(1e-9, columns=columns)
    with pytest.raises(ArrayError, match=r"stop\.index"):
        bind(1e-9, stop=Stop("q", 2))
    with pytest.raises(ArrayError, match=r"propagate\.u"):
        bind(1e-9, u=[1.0])
    with pytest.raises(UnsupportedError, match="variational"):
        compiled(planar(2)).bind(1e-9, columns=4)
