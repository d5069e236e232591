"""Times, tolerance and start as a caller of `simulate` gives them, checked."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite
from typing import Any, TypeGuard

import numpy as np
from numpy.typing import ArrayLike

from phichain.errors import ArrayError
from phichain.system import System, Vector, angular_velocities, pack, unit_vectors
from phichain.system.arrays import positive, reals

REPAIRABLE = 1e-6
"""Deviations from the manifold up to this are projected away (and said); larger ones are refused."""

ROUND_OFF = 8 * np.finfo(float).eps


def check_times(t: ArrayLike) -> Vector:
    """Output times from a final time, a span or a grid.

    Raises:
        ArrayError: Not finite, not strictly monotone, or an empty span.
    """
    ends: Any = t
    if isinstance(ends, tuple) and len(ends) == 2 and type(ends[0]) is float and type(ends[1]) is float and isfinite(ends[1] - ends[0]) and ends[0] != ends[1]:
        return np.array(ends)
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
    if (isinstance(x0, tuple) and len(x0) == 2) or _is_pair(x0):
        x = pack(*x0)
    else:
        x = np.array(reals("x0", x0, "give one flat state, or the pair (q, v)"))
    if x.shape != (system.nx,):
        expected = f"must hold q ({system.nq}) and then v ({system.nv})"
        raise ArrayError("x0", x.shape, expected, "give one flat state, or the pair (q, v)")
    if not np.isfinite(x).all():
        raise ArrayError("x0", x, "holds values that are not finite", "start from a finite state")
    return (x, ()) if system.is_planar else _on_manifold(system, x)


def _is_pair(x0: Any) -> TypeGuard[Sequence[ArrayLike]]:
    """Whether a list holds two vectors, and is no flat state of a single angle."""
    return isinstance(x0, list) and len(x0) == 2 and all(isinstance(part, list | tuple) or getattr(part, "ndim", 0) == 1 for part in x0)


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
