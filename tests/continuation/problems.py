"""Problems whose curves are known."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from phichain.continuation import Evaluation, Problem


def problem_of(residual: Callable, jacobian: Callable, names: Sequence[str], **more: Any) -> Problem:
    """A problem whose residual and Jacobian are written apart."""
    return Problem(lambda z: Evaluation(residual(z), jacobian(z)), tuple(names), **more)


PARABOLA = problem_of(lambda z: np.array([z[0] ** 2 + z[1]]), lambda z: np.array([[2 * z[0], 1.0]]), ("x", "l"))
CIRCLE = problem_of(
    lambda z: np.array([z[0] ** 2 + z[1] ** 2 - 1]), lambda z: np.array([[2 * z[0], 2 * z[1]]]), ("x", "y")
)
