"""Krein's signatures: which two pairs of multipliers can leave the unit circle when they meet, and whether
two have passed each other.

With Q = [a b; c d] symplectic the matrix X = d^T a, whose eigenvalues are those of the multipliers, is
symmetric in the form G = a^T c, for G X = a^T (c d^T) a and c d^T is symmetric. Where kappa is inside (-1, 1)
the sign of x^T G x of its eigenvector does not change but where two
kappa of opposite sign meet: they leave the real axis there, and come back to it in the other order a little
later. So a changed order of the signs from one point to the next says that two collisions lie between them,
however close to each other.

Source: V. Yakubovich and V. Starzhinskii, Linear Differential Equations with Periodic Coefficients, Wiley
1975, chapter 3.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from phichain.system import Vector

_EDGE: Final = 1e-7
"""Distance from kappa = 1 and -1 within which a kappa has no sign: the flow's own is there."""


def signs(a: Vector, c: Vector, d: Vector) -> tuple[int, ...] | None:
    """The signs of all kappa inside (-1, 1), by rising eigenvalue of d^T a; None where some are complex."""
    values, vectors = np.linalg.eig(d.T @ a)
    if np.iscomplexobj(values):
        return None
    inside = (values > _EDGE) & (values < 1 - _EDGE)
    weights = np.einsum("ik,ij,jk->k", vectors, a.T @ c, vectors)
    return tuple(int(np.sign(weights[k])) for k in np.argsort(values) if inside[k])


def signs_of_symplectic(matrix: Vector) -> tuple[int, ...] | None:
    """The same of a symplectic map, by falling Re mu of the multipliers on the upper half of the circle; None
    where some are off circle and axis."""
    values, vectors = np.linalg.eig(matrix)
    half = len(matrix) // 2
    on_axis, on_circle = np.abs(values.imag) < _EDGE, np.abs(np.abs(values) - 1) < _EDGE
    if not np.all(on_axis | on_circle):
        return None
    upper = on_circle & (values.imag > _EDGE)
    # i x^H J x
    weights = 2 * np.imag(np.sum(vectors[:half].conj() * vectors[half:], axis=0))
    return tuple(int(np.sign(weights[k])) for k in np.argsort(-values.real) if upper[k])
