"""Observability with its margin: the smallest singular value of [lambda - A; C] at every eigenvalue of the chain."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from phichain.control.gains import Gains
from phichain.control.weights import spectrum
from phichain.errors import ControlError
from phichain.system import Vector

UNSEEN = 1e-9
"""Margins below this are called unobservable."""


def sight(A: Vector, C: Vector) -> tuple[complex, float]:
    """The mode that is seen worst, 1/s, and its margin, in units of the fastest mode's rate.

    Args:
        A: Dynamics (n, n).
        C: What is measured (ny, n).
    """
    modes = spectrum(A)
    rate = float(np.max(np.abs(modes), initial=0.0)) or 1.0
    # Rates in units of the fastest mode, so that places and speeds weigh alike.
    m = len(A) // 2
    scale = np.concatenate([np.ones(m), np.full(m, rate)])
    balanced = A * (scale / scale[:, None]) / rate
    seen = C * scale / np.linalg.norm(C * scale, axis=1, keepdims=True)
    margins = [np.linalg.svd(np.vstack([mode / rate * np.eye(2 * m) - balanced, seen]), compute_uv=False)[-1] for mode in modes]
    worst = int(np.argmin(margins))
    return complex(modes[worst]), float(margins[worst])


def demand_sight(gains: Gains, names: tuple[str, ...], C: Vector) -> None:
    """Refuse measurements that do not show a mode.

    Raises:
        ControlError: One is not seen; carries `mode`, `margin` and `measured`, what would be enough.
    """
    mode, margin = sight(gains.A, C)
    if margin > UNSEEN:
        return
    enough = _enough(gains, names, C)
    also = f"measure {' and '.join(enough)} too" if enough else "measure every position"
    raise ControlError(
        "measured", list(names), f"do not show the mode lambda = {mode:.6g} 1/s: margin {margin:.2g}", also,
        mode=mode, margin=margin, measured=(*names, *enough),
    )  # fmt: skip


def _enough(gains: Gains, names: tuple[str, ...], C: Vector) -> tuple[str, ...]:
    """The fewest further positions, one or two, with which every mode is seen."""
    whole = gains.on_state(np.eye(gains.K.shape[1]))
    more = [k for k in range(len(whole.names) // 2) if np.any(whole.gains[:, k]) and whole.names[k] not in names]
    for count in (1, 2):
        for chosen in combinations(more, count):
            if sight(gains.A, np.vstack([C, whole.gains[:, chosen].T]))[1] > UNSEEN:
                return tuple(whole.names[k] for k in chosen)
    return ()
