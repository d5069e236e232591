"""A caller's law, asked so that it can change nothing, and its answer held to be one finite input vector."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from phichain.errors import ArrayError
from phichain.motion.inputs.limits import Limits
from phichain.motion.inputs.piece import Control
from phichain.system import Vector
from phichain.system.arrays import reals

REMEDY = "return one number per input"


def shielded(field: str, size: int, law: Callable[[float, Vector], Any], limits: Limits | None = None, alone: bool = False) -> Control:
    """A law that is given a state of its own, and whose answer is held to be one input vector.

    What a law writes into its state would otherwise change the motion, and what it hands out is its own memory.

    Args:
        field: How it is called in messages.
        size: How many inputs it gives.
        law: The caller's function of (t, x).
        limits: Where its answer is cut off.
        alone: Whether it gives one input by name, and may return a plain number.
    """

    def control(t: float, x: Vector) -> Vector:
        answer = law(t, np.array(x))
        u = reals(field, () if answer is None and size == 0 else answer, f"{REMEDY} (asked at t = {t:.6g} s)")
        if alone and u.shape == ():
            u = u.reshape(1)
        if u.shape != (size,) and (u.size or size):
            counted = f"nu = {size}" if field == "u" else "one"
            problem = f"is no answer of a control law at t = {t:.6g} s: it must hold {counted} number{'' if size == 1 else 's'}"
            raise ArrayError(field, u.shape, problem, REMEDY)
        # Where the state itself has left the finite numbers, the run is told so, not the law.
        if not math.isfinite(u.sum()) and not np.isfinite(u).all() and np.isfinite(x).all():
            raise ArrayError(field, u.tolist(), f"is not finite at t = {t:.6g} s", "return finite inputs")
        return np.array(u) if limits is None else limits.cut(u)

    return control
