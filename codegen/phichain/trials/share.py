"""How well a share of runs is known."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.stats import beta


def interval_of(held: NDArray[np.bool_] | NDArray[np.int64]) -> tuple[float, float]:
    """95 % confidence interval of the share that held (Clopper and Pearson).

    Args:
        held: Of every run whether it did (n,).
    """
    n, k = len(held), int(np.sum(held))
    low = 0.0 if k == 0 else float(beta.ppf(0.025, k, n - k + 1))
    high = 1.0 if k == n else float(beta.ppf(0.975, k + 1, n - k))
    return low, high
