"""What weights must see: a mode on the imaginary axis that costs nothing is never damped."""

from __future__ import annotations

import numpy as np

from phichain.control.equations.newton import largest
from phichain.control.weights import spectrum
from phichain.errors import ControlError
from phichain.system import Vector

UNSEEN = 1e-10
"""A mode that the weights see by less than this share is as good as not weighed."""


def demand_detectable(A: Vector, Q: Vector) -> None:
    """Refuse Qs that do not see a mode on the imaginary axis: no cost, so no gain, would ever damp it."""
    for k in np.flatnonzero(~(np.linalg.eigvalsh(Q)[:, 0] > UNSEEN * largest(Q))):
        _demand_sight(A[k], Q[k])


def _demand_sight(A: Vector, Q: Vector) -> None:
    values = spectrum(A)
    size, weights = float(np.max(np.abs(values), initial=0.0)) or 1.0, Q / np.max(np.abs(Q))
    for value in values[np.abs(values.real) <= 1e-6 * size]:
        pencil = np.vstack([(A - value * np.eye(len(A))) / size, weights])
        margin = float(np.linalg.svd(pencil, compute_uv=False)[-1])
        if margin < UNSEEN:
            raise ControlError(
                "Q",
                Q,
                f"does not weigh the mode lambda = {value:.6g} 1/s, which would stay undamped",
                "weigh every coordinate",
                mode=complex(value),
                margin=margin,
            )
