"""The emitted implicit flow: an L-stable Rosenbrock method of order 5 (Rodas5P, Steinebach 2023), for stiff chains.

``path`` runs a whole problem in compiled code when nothing has to be watched step by step; ``segments`` gives the steps
one by one, for events that are Python functions. A state inside a step is the end
of a shorter step from the same start, so it has the method's own order.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from phichain.motion.balance import FEW
from phichain.motion.ledger import Ledger
from phichain.motion.methods import emitted_flow
from phichain.motion.methods.emitted_flow import EmittedFlow
from phichain.motion.methods.legwise import legwise
from phichain.motion.path import Path, Segment, StalledError, StateAt, StatesAt
from phichain.motion.problem import Problem
from phichain.system import Vector, pack
from phichain.system.propagation import StiffPropagation


def is_possible(problem: Problem) -> bool:
    """Whether the system has the flow and its input, if any, is constant between breaks that are known."""
    return emitted_flow.is_possible(problem, "propagate_stiff")


def segments(problem: Problem, name: str, ledger: Ledger) -> Iterator[Segment]:
    """The flow's steps, one by one.

    Raises:
        UnsupportedError: the input is a function, or the system has no flow.
        StalledError: no step, however short, led to finite numbers within the tolerance.
    """
    run = _run(problem, name)
    yield from legwise(problem, ledger, lambda part: _steps(part, run, ledger))


def _steps(problem: Problem, run: EmittedFlow[StiffPropagation], ledger: Ledger) -> Iterator[Segment]:
    run.hold(problem.held)
    t_end = float(problem.t[-1])
    t, x = float(problem.t[0]), problem.x0
    while t != t_end:
        start = run.options
        step = run(t, x, t_end, max_steps=1)
        if step.outcome == "not finite":
            raise StalledError(f"{run.name} left the finite numbers")
        ledger.count(steps=step.steps, refused=step.refused)
        ledger.counts.update(order=step.order)
        if not step.steps:
            continue
        after, t1 = pack(step.q, step.v), emitted_flow.reached(step, t_end)
        inside = emitted_flow.dense(_inside(run, t, x, start))
        yield Segment(t, t1, after, inside, looks=_looks(run, t, x, t_end, start))
        t, x = t1, after


def path(problem: Problem, name: str, ledger: Ledger) -> Path:
    """The states at the problem's times, or at the ends of its own steps, in compiled code from end to end.

    Raises:
        UnsupportedError: the input is a function, or the system has no flow.
    """
    run = _run(problem, name)
    found, refused = (emitted_flow.own_path if problem.own_steps else emitted_flow.whole_path)(problem, run, ledger)
    ledger.counts.update(steps=found.steps, refused=refused, order=run.order)
    return found


def _run(problem: Problem, name: str) -> EmittedFlow[StiffPropagation]:
    return EmittedFlow(
        problem, name, "propagate_stiff", "Radau", lambda found: {"lost": found.lost, "memory": found.memory},
        FEW, lambda h: {"memory": (h, 0.0)},
    )  # fmt: skip


def _inside(run: EmittedFlow[StiffPropagation], t0: float, x0: Vector, start: dict[str, Any]) -> StateAt:
    def at(t: float) -> Vector:
        # A step that ends there: shorter than the one that was taken, so within the tolerance as well.
        found = run.once(t0, x0, t, **(start | {"memory": (t - t0, 0.0)}))
        return pack(found.q, found.v)

    return at


def _looks(run: EmittedFlow[StiffPropagation], t0: float, x0: Vector, t_end: float, start: dict[str, Any]) -> StatesAt:
    def at(times: Vector) -> Vector:
        # The same step again, asked for states on its way; what it heads for decides how long it is.
        found = run.once(t0, x0, t_end, **start, max_steps=1, times=times)
        return pack(found.q_at, found.v_at)

    return at
