"""How far gains may be off because the linearisation they are made of is only as accurate as its type.

M, D, G and B of (19) come from functions that compute in the scene's type. Their last digits are moved by a few patterns of signs,
the regulator is made again, and the largest change of its gains is what their accuracy is worth: a chain that stands upright
amplifies it, by 80 with five links in single precision.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np

from phichain.control.linear import LinearSystem, first_order
from phichain.system import Vector

DRAWS: Final = 4
"""Patterns of signs that are tried."""

_ROOM: Final = 3.0
"""The worst of a few patterns is not the worst of all."""

Solve = Callable[[Vector, Vector], Vector]
"""K (nu, 2m) of A and B."""


def gains_error(linear: LinearSystem, K: Vector, solve: Solve) -> float:
    """The error of the gains relative to the largest.

    Args:
        linear: The chain about its equilibrium, with the accuracy of its matrices.
        K: Its gains (nu, 2m).
        solve: The same regulator of other matrices.
    """
    draw = np.random.default_rng(0)
    size = float(np.max(np.abs(K)))
    return _ROOM * max(float(np.max(np.abs(solve(*_moved(linear, draw)) - K))) / size for _ in range(DRAWS))


def _moved(linear: LinearSystem, draw: np.random.Generator) -> tuple[Vector, Vector]:
    """(A, B) of the chain whose matrices are moved in their last digit, symmetric ones symmetrically."""
    moved = []
    for matrix in (linear.M, linear.D, linear.G):
        signs = np.triu(np.sign(draw.uniform(-1, 1, matrix.shape)))
        moved.append(matrix * (1 + linear.noise / 2 * (signs + np.triu(signs, 1).T)))
    B = linear.B * (1 + linear.noise / 2 * np.sign(draw.uniform(-1, 1, linear.B.shape)))
    A, drive = first_order(*(part[None] for part in (*moved, B)))
    return A[0], drive[0]
