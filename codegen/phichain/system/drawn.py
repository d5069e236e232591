"""What a result keeps of its chain so that it can be drawn when the chain is gone."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from phichain.system.arrays import Vector
from phichain.system.system import Parameters, System


def entry_lengths(system: System, p: Parameters | None = None) -> Vector | None:
    """Length of the link that each entry of q belongs to (nq,), m, 0 for a cart's; None of a system made by hand that holds none."""
    found = np.repeat(system.number("length", p, default=math.nan), 1 if system.is_planar else 3)
    return None if np.isnan(found).any() else np.concatenate([np.zeros(system.cart_size), found])


def looks(system: System, p: Parameters | None = None) -> dict[str, Any]:
    """Fields `lengths` and `angles` of a result."""
    return {"lengths": entry_lengths(system, p), "angles": system.angles or ""}
