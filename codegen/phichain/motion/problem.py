"""The initial value problem: every argument of `simulate`, checked once, in one frozen record."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from phichain.errors import ArrayError
from phichain.motion.events import Event
from phichain.records import Held
from phichain.system import (
    Parameters,
    System,
    Vector,
    angular_velocities,
    input_arguments,
    pack,
    rhs,
    rhs_jacobian,
    unit_vectors,
)
from phichain.system.arrays import positive, reals

REPAIRABLE = 1e-6
"""Deviations from the manifold up to this are projected away (and said); larger ones are refused."""

ROUND_OFF = 8 * np.finfo(float).eps

Control = Callable[[float, Vector], Vector]
Progress = Callable[[float, float], Any]


class Counted:
    """A callable that counts its calls, so that every method reports its cost in the same unit."""

    def __init__(self, function: Callable[..., Vector]) -> None:
        self.function = function
        self.calls = 0

    def __call__(self, t: float, x: Vector) -> Vector:
        self.calls += 1
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

    def within(self, tol: float, atol: float) -> Problem:
        """The same problem under other tolerances."""
        return Problem.made(**{**vars(self), "tol": tol, "atol": atol})

    @property
    def own_steps(self) -> bool:
        """True when the outputs are the method's own steps."""
        return len(self.t) == 2


def bind(
    system: System, u: ArrayLike | Control | None, p: Parameters | None, t0: float, x0: Vector
) -> tuple[Counted, Counted | None, Control | None, Vector | None]:
    """Close right-hand side and Jacobian over input and parameters.

    Returns:
        (field, jacobian or None, control or None, held input or None).

    Raises:
        ArrayError: u has the wrong shape, is not finite, or is given to a system without inputs.
        AbsentFunctionError: The system has no forward dynamics.
    """
    f = rhs(system)
    slope = rhs_jacobian(system) if system.has("state_jacobian") else None
    if callable(u):
        control = shielded(system, u)
        check_input(system, control(t0, x0))
        moving = (
            None
            if slope is None
            else Counted(lambda t, x: slope(t, x, control(t, x), p) + _by_input(system, control, p, t, x))
        )
        return Counted(lambda t, x: f(t, x, control(t, x), p)), moving, control, None
    held = check_input(system, u)
    still = None if slope is None else Counted(lambda t, x: slope(t, x, held, p))
    constant = None if held is None else lambda t, x: held
    return Counted(lambda t, x: f(t, x, held, p)), still, constant, held


def shielded(system: System, law: Control) -> Control:
    """A law that is given a state of its own, and whose answer is held to be one input vector.

    What a law writes into its state would otherwise change the motion, and what it hands out is its own memory.
    """
    shape = (system.nu,)

    def control(t: float, x: Vector) -> Vector:
        answer = law(t, np.array(x))
        u = reals("u", () if answer is None and system.nu == 0 else answer, "return one number per input")
        if u.shape != shape and u.size:
            problem = f"is no answer of a control law: it must hold nu = {system.nu} numbers"
            raise ArrayError("u", u.shape, problem, "return one number per input")
        return np.array(u)

    return control


def check_input(system: System, u: ArrayLike | None) -> Vector | None:
    """One input vector (nu,), zero by default, None for a system without inputs.

    Raises:
        ArrayError: Wrong shape, not finite, or given to a system without inputs.
    """
    given = input_arguments(system, np.zeros(system.nq), u)
    if not given:
        return None
    held = given[0]
    if held.shape != (system.nu,):
        raise ArrayError(
            "u", held.shape, f"must have shape ({system.nu},)", "give a constant vector or a callable u(t, x)"
        )
    if not np.all(np.isfinite(held)):
        raise ArrayError("u", held.tolist(), "is not finite", "give finite inputs")
    return held


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


def check_times(t: ArrayLike) -> Vector:
    """Output times from a final time, a span or a grid.

    Raises:
        ArrayError: Not finite, not strictly monotone, or an empty span.
    """
    times = np.array(reals("t", t, "give (t0, t1), a final time, or a grid"))
    if times.ndim == 0:
        times = np.array([0.0, float(times)])
    if times.ndim != 1 or len(times) < 2:
        raise ArrayError(
            "t", times.shape, "is no span or grid of times", "give (t0, t1), a final time, or a grid"
        )
    if not np.isfinite(times).all():
        raise ArrayError("t", times, "holds times that are not finite", "give finite times")
    before, after = times[:-1], times[1:]
    if not ((after > before).all() or (after < before).all()):
        raise ArrayError("t", times, "is not strictly monotone", "sort the times and drop repeated ones")
    return times


def check_tolerance(tol: float, field: str = "tol") -> float:
    """A positive, finite tolerance.

    Raises:
        ToleranceError: It is zero, negative, NaN or infinite.
    """
    return positive(field, tol, "use 1e-9, or as little as 1e-13")


def check_state(system: System, x0: ArrayLike | Sequence[ArrayLike]) -> tuple[Vector, tuple[str, ...]]:
    """The initial state on the manifold, and what had to be done to it.

    Args:
        system: The chain.
        x0: The state (nq + nv,), or the pair (q, v).

    Raises:
        ArrayError: Wrong shape, not finite, a unit vector of length 0 or further than 1e-6 from length 1, a rate
            further than 1e-6 (relative) from tangent.
    """
    if isinstance(x0, tuple) and len(x0) == 2:
        x = pack(*x0)
    else:
        x = np.array(reals("x0", x0, "give one flat state, or the pair (q, v)"))
    if x.shape != (system.nx,):
        expected = f"must hold q ({system.nq}) and then v ({system.nv})"
        raise ArrayError("x0", x.shape, expected, "give one flat state, or the pair (q, v)")
    if not np.isfinite(x).all():
        raise ArrayError("x0", x, "holds values that are not finite", "start from a finite state")
    return (x, ()) if system.is_planar else _on_manifold(system, x)


def _on_manifold(system: System, x: Vector) -> tuple[Vector, tuple[str, ...]]:
    x = x.copy()
    directions = unit_vectors(system, x[: system.nq])
    rates = angular_velocities(system, x[system.nq :])
    lengths = np.linalg.norm(directions, axis=1)
    notes = []
    stretch = np.abs(lengths - 1)
    worst = int(np.argmax(stretch))
    if lengths.min() == 0:
        k = int(np.argmin(lengths))
        raise ArrayError(
            f"q_{k + 1}", directions[k].tolist(), "has length 0 and no direction", "give a unit vector"
        )
    if stretch[worst] > REPAIRABLE:
        problem = f"is no unit vector: its length is off by {stretch[worst]:.3g}, more than {REPAIRABLE:g}"
        raise ArrayError(f"q_{worst + 1}", directions[worst].tolist(), problem, "normalise it")
    if stretch[worst] > ROUND_OFF:
        directions = directions / lengths[:, None]
        notes.append(f"unit vectors were normalised (off by up to {stretch[worst]:.2g})")
    along = np.sum(directions * rates, axis=1)
    tilt = np.abs(along) / np.maximum(1.0, np.linalg.norm(rates, axis=1))
    worst = int(np.argmax(tilt))
    if tilt[worst] > REPAIRABLE:
        problem = f"is not tangent: omega . q = {along[worst]:.3g}, more than {REPAIRABLE:g} of its size"
        raise ArrayError(
            f"omega_{worst + 1}", rates[worst].tolist(), problem, "subtract (omega . q) q from it"
        )
    if tilt[worst] > ROUND_OFF:
        rates = rates - along[:, None] * directions
        notes.append(f"rates were projected on the tangent planes (off by up to {tilt[worst]:.2g})")
    x[system.cart_size : system.nq] = directions.ravel()
    x[system.nq + system.cart_size :] = rates.ravel()
    return x, tuple(notes)
