"""Numbers from callers, as arrays of doubles."""

from __future__ import annotations

import numpy as np

from phichain.errors import ControlError
from phichain.system.system import Vector


def real_numbers(field: str, values: object, remedy: str) -> Vector:
    """Values as an array of doubles.

    Raises:
        ControlError: They are complex, ragged or no numbers.
    """
    try:
        array = np.asarray(values)
        if np.iscomplexobj(array):
            raise TypeError("complex")
        return np.asarray(array, dtype=float)
    except (TypeError, ValueError) as failure:
        raise ControlError(field, values, "does not hold real numbers", remedy) from failure
