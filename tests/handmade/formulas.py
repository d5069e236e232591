"""What the chains made by hand share: inertia, angles, batches, a Runge-Kutta step and the complex step."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

GRAVITY = 9.81


def coefficients(mass: np.ndarray, length: np.ndarray, com: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """mu_k and c_ij of section 1 of docs/theory.md."""
    outer = mass.sum() - np.cumsum(mass)
    mu = mass * com + length * outer
    n = len(mass)
    c = np.array([[length[min(i, j)] * mu[max(i, j)] for j in range(n)] for i in range(n)])
    c[np.diag_indices(n)] = mass * com**2 + length**2 * outer
    return mu, c


def angle_map(n: int, angles: str) -> np.ndarray:
    """S with phi = S theta (docs/theory.md, section 2)."""
    if angles == "absolute":
        return np.eye(n)
    if angles == "relative":
        return np.tril(np.ones((n, n)))
    return np.eye(n) + np.eye(n, k=-1)


def batched(function: Callable[..., Any]) -> Callable[..., Any]:
    """Let a function of vectors take one leading batch axis."""

    def wrapper(*arrays: Any, **keywords: Any) -> Any:
        arrays = tuple(np.asarray(a) for a in arrays)
        if arrays[0].ndim < 2:
            return function(*arrays, **keywords)
        rows = [function(*row, **keywords) for row in zip(*arrays, strict=True)]
        if isinstance(rows[0], tuple):
            return tuple(np.array(part) for part in zip(*rows, strict=True))
        return np.array(rows)

    return wrapper


def rk4(field: Callable[[np.ndarray], np.ndarray], x: np.ndarray, h: float) -> np.ndarray:
    """One classical Runge-Kutta step."""
    k1 = field(x)
    k2 = field(x + h / 2 * k1)
    k3 = field(x + h / 2 * k2)
    k4 = field(x + h * k3)
    return x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


def complex_step(function: Callable[..., np.ndarray], arguments: Sequence[np.ndarray], k: int) -> np.ndarray:
    """d function / d arguments[k] by the complex step, exact to round-off."""
    columns = []
    for i in range(len(arguments[k])):
        moved = [np.asarray(a, dtype=complex) for a in arguments]
        moved[k][i] += 1e-30j
        columns.append(function(*moved).imag / 1e-30)
    return np.array(columns).T
