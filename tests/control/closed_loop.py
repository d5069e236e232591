"""Closed loops of handmade chains by one Runge-Kutta step a sample: for tests that ask a law thousands of times."""

from __future__ import annotations

import numpy as np

from phichain.system import System


def after(system: System, x: np.ndarray, u: np.ndarray, period: float) -> np.ndarray:
    """The state (nx,) one period later, the input held."""
    return np.concatenate(system.step(period, x[: system.nq], x[system.nq :], np.asarray(u, dtype=float)))
