"""The linear model of a chain as a state space of python-control, and back: its tools on our chains, its gains in our laws.

python-control is imported when it is asked for.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from phichain.control.equations.sampled import demand_sample, held
from phichain.control.linear import LinearSystem
from phichain.errors import ControlError, UnsupportedError
from phichain.system.vertical import Signs

SAME = 1e-12
"""Entries of z' = (x', ...) that differ from the identity by more belong to no chain."""


def to_control(linear: LinearSystem, sample: float | None = None, name: str | None = None) -> Any:
    """z' = A z + B u, or z_{k+1} = A_d z_k + B_d u_k with the input held, as a `control.StateSpace` whose outputs are z.

    Args:
        linear: The chain about one equilibrium, as `linearize(system, s)` gives it.
        sample: Seconds between two samples; None for continuous time.
        name: The system's name there.

    Raises:
        ControlError: `sample` is no positive time, or too long for the fastest unstable mode.
        UnsupportedError: python-control is not installed.
    """
    A, B = linear.first_order
    names, inputs = list(linear.state_names), [f"u[{k}]" for k in range(B.shape[1])]
    if sample is not None:
        demand_sample(A, sample)
        A, B = (part.high for part in held(A, B, float(sample)))
    words: dict[str, Any] = {"states": names, "outputs": names, "inputs": inputs, "dt": 0 if sample is None else float(sample)}
    return _library().ss(A, B, np.eye(len(A)), np.zeros(B.shape), **words, **({} if name is None else {"name": name}))


def from_control(space: Any, s: Sequence[int], cart: int = 0, noise: float = float(np.finfo(float).eps)) -> LinearSystem:
    """The chain's linear model of a continuous `control.StateSpace` whose state is z = (x, x'), M taken as the identity.

    Args:
        space: The state space; any object with A, B, dt and state_labels.
        s: Directions of the links at its equilibrium.
        cart: Number of cart coordinates at the head of x.
        noise: Relative accuracy of its matrices.

    Raises:
        ControlError: It is sampled, or its state is not (x, x').
    """
    A, B = (np.asarray(part, dtype=float) for part in (space.A, space.B))
    if space.dt:
        raise ControlError("space.dt", space.dt, "belongs to a sampled system", "convert it to continuous time first")
    m = len(A) // 2
    upper = np.hstack([np.zeros((m, m)), np.eye(m)])
    if len(A) % 2 or np.max(np.abs(A[:m] - upper), initial=0.0) > SAME or np.any(B[:m]):
        raise ControlError("space", A, "has a state that is no (x, x')", "order it as positions, then their rates")
    names = tuple(str(label) for label in space.state_labels[:m])
    signs: Signs = tuple(int(sign) for sign in s)
    return LinearSystem(signs, np.eye(m), -A[m:, m:], -A[m:, :m], B[m:], cart, names, (A, B), noise)


def _library() -> Any:
    try:
        import control
    except ImportError:
        raise UnsupportedError(
            "control", "python-control", "is not installed", "run: pip install control; or take A and B of linearize(system, s)"
        ) from None
    return control
