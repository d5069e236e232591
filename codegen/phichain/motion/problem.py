"""The initial value problem: every argument of `simulate`, once it was checked, in one frozen record."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from phichain.motion.events import Event
from phichain.motion.inputs.given import Input, as_input
from phichain.motion.inputs.legs import Leg, Legs, Planned
from phichain.motion.inputs.piece import NOTHING, Constant, Control, Law
from phichain.records import Held
from phichain.system import (
    Parameters,
    System,
    Vector,
    rhs,
    rhs_jacobian,
)

Progress = Callable[[float, float], Any]
Slope = Callable[[float, Vector], Vector]


class Counted:
    """A callable that counts its calls, so that every method reports its cost in the same unit."""

    def __init__(self, function: Callable[..., Vector], counter: Counted | None = None) -> None:
        """Count the calls of a function, among those of another one where it stands for that."""
        self.function = function
        self.calls = 0
        self.counter = self if counter is None else counter

    def __call__(self, t: float, x: Vector) -> Vector:
        self.counter.calls += 1
        return self.function(t, x)


@dataclass(frozen=True, eq=False)
class Problem(Held):
    """x' = f(t, x), x(t_0) = x_0, with outputs, tolerance, events and limits.

    Attributes:
        system: The chain.
        field: x' = f(t, x) with input and parameters bound; counts its calls.
        jacobian: df/dx with input and parameters bound, or None when the system has no `state_jacobian`.
        control: u(t, x), or None without inputs.
        held: The input when it is constant, else None.
        p: Runtime parameters, or None.
        x0: Initial state (nx,), on the manifold.
        t: Output times, monotone; two of them mean "at the method's own steps".
        tol: Relative tolerance of the local error.
        atol: Absolute tolerance of the local error, the unit of each entry of x.
        h: Step size of the fixed-step methods, s, or None.
        events: What is watched.
        max_steps: Step budget.
        progress: Called with (fraction done, t), or None.
        notes: What was done to the arguments, for the Trajectory's reason.
        input: The input with its breaks; None stands for `held`, or for one `control` without any.
    """

    system: System
    field: Counted
    jacobian: Counted | None
    control: Control | None
    held: Vector | None
    p: Parameters | None
    x0: Vector
    t: Vector
    tol: float
    atol: float
    h: float | None
    events: tuple[Event, ...]
    max_steps: int
    progress: Progress | None
    notes: tuple[str, ...] = ()
    input: Input | None = None

    def within(self, tol: float, atol: float) -> Problem:
        """The same problem under other tolerances."""
        return Problem.made(**{**vars(self), "tol": tol, "atol": atol})

    @property
    def own_steps(self) -> bool:
        """True when the outputs are the method's own steps."""
        return len(self.t) == 2

    @property
    def is_moved(self) -> bool:
        """Whether the input is more than one constant."""
        return self.control is not None and self.held is None

    @property
    def can_be_repeated(self) -> bool:
        """Whether the input can be asked once more: all but a law that samples, which may have a memory."""
        return self.input is None or self.input.sample is None or not self.input.signal.is_law

    @property
    def is_held(self) -> bool:
        """Whether the input is constant between its breaks, so that a flow which holds it can run from one to the next."""
        return self.control is None or self.held is not None or (self.input is not None and self.input.is_held)

    def legs(self) -> Legs:
        """The stretches between breaks of the input; one for all where there are none."""
        t0, t_end = float(self.t[0]), float(self.t[-1])
        if self.input is not None:
            return self.input.legs(t0, t_end)
        if self.control is not None and self.held is None:
            return Planned(Law(self.control), t0, t_end)
        return Planned(Constant.made(u=NOTHING if self.held is None else self.held), t0, t_end)

    def on(self, leg: Leg, t: Vector, x: Vector) -> Problem:
        """The problem of one leg: from x at t[0] to its end t[-1], with its piece of the input."""
        field, jacobian = closed(self.system, leg.control, leg.held, self.p)
        counted = Counted(field, self.field.counter)
        slope = None if jacobian is None or self.jacobian is None else Counted(jacobian, self.jacobian.counter)
        parts = {"field": counted, "jacobian": slope, "control": leg.control, "held": leg.held, "x0": x, "t": t, "input": None}
        return Problem.made(**{**vars(self), **parts})


def bind(
    system: System, u: Any, p: Parameters | None, t0: float, x0: Vector
) -> tuple[Counted, Counted | None, Control | None, Vector | None]:
    """Close right-hand side and Jacobian over an input without breaks, and over parameters.

    Returns:
        (field, jacobian or None, control or None, held input or None).

    Raises:
        ArrayError: u has the wrong shape, is not finite, or is given to a system without inputs.
        AbsentFunctionError: The system has no forward dynamics.
    """
    return bound(system, as_input(system, u, (t0, t0)), p, t0, x0)


def bound(
    system: System, given: Input | None, p: Parameters | None, t0: float, x0: Vector
) -> tuple[Counted, Counted | None, Control | None, Vector | None]:
    """The same over any input; of a sampled one that is not asked before the run, over what it is until then."""
    control: Control | None
    if given is None:
        control, held = None, None
    elif given.sample is not None:
        control, held = given.at_rest, None
    else:
        control, held = given.signal.value, given.constant
        control(t0, x0)
    system.function("forward_dynamics")
    both = _Closed(lambda: closed(system, control, held if control else None, p))
    return Counted(both.field), Counted(both.jacobian) if system.has("state_jacobian") else None, control, held


class _Closed:
    """`closed`, when one of the two is first called: emitted flows call neither."""

    def __init__(self, make: Callable[[], tuple[Slope, Slope | None]]) -> None:
        self._make = make

    @cached_property
    def _made(self) -> tuple[Slope, Slope | None]:
        return self._make()

    def field(self, t: float, x: Vector) -> Vector:
        return self._made[0](t, x)

    def jacobian(self, t: float, x: Vector) -> Vector:
        slope = self._made[1]
        assert slope is not None
        return slope(t, x)


def closed(
    system: System, control: Control | None, held: Vector | None, p: Parameters | None
) -> tuple[Slope, Slope | None]:
    """x' = f(t, x) and df/dx (None without `state_jacobian`) under an input: none, one that is held, or a function."""
    f = rhs(system)
    slope = rhs_jacobian(system) if system.has("state_jacobian") else None
    if control is None or held is not None:
        return lambda t, x: f(t, x, held, p), None if slope is None else lambda t, x: slope(t, x, held, p)
    moving = None if slope is None else lambda t, x: slope(t, x, control(t, x), p) + _by_input(system, control, p, t, x)
    return lambda t, x: f(t, x, control(t, x), p), moving


def _by_input(system: System, control: Control, p: Parameters | None, t: float, x: Vector) -> Vector:
    # (df/du) (du/dx): the input's own slope by differences, since a control law is a plain callable.
    result = np.zeros((system.nx, system.nx))
    if system.nu == 0:
        return result
    u = control(t, x)
    parts = system.state_jacobian(x[: system.nq], x[system.nq :], u, **system.parameters(p))
    result[system.nq :] = np.reshape(parts[2], (system.nv, system.nu)) @ differences(
        lambda y: control(t, y), x, u
    )
    return result


def differences(
    function: Callable[[Vector], Vector], x: Vector, value: Vector, noise: float = np.finfo(float).eps
) -> Vector:
    """Forward-difference Jacobian of `function` at x, where it has `value`; shape (len(value), len(x)).

    `noise` is the relative accuracy of the function; the step is its square root.
    """
    columns = []
    for k in range(len(x)):
        width = np.sqrt(noise) * max(1.0, abs(x[k]))
        moved = x.copy()
        moved[k] += width
        columns.append((np.asarray(function(moved)) - value) / (moved[k] - x[k]))
    return np.array(columns).T
