"""The fastest linear mode of the hanging chain, which no step of a Taylor series may step over.

Small motions about hanging obey M x'' + G x = 0, M_ij = c_ij, G_ii = g mu_i, and springs add k_k (x_k - x_{k-1})^2; their
largest frequency bounds how fast a chain swings without being driven. Where parameters come at run time the bound

    omega^2 <= 4 max_k (g outer_k + k_k / r_k + k_{k+1} / r_k) / (min(m_k, m_{k-1}) r_k),    outer_k = sum_{a >= k} m_a

serves (Gershgorin's circles on the tridiagonal inverse of M for r = l; shorter arms r only raise it).
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import scipy.linalg

from phichain.scene import Scene

#: Digits kept of a frequency: the text must not depend on the last bits of an eigenvalue solver.
_DIGITS = 3


def fastest_rate(scene: Scene) -> Fraction | None:
    """Largest linear frequency of the hanging chain, rad/s, rounded up; None where parameters come at run time."""
    if scene.runtime:
        return None
    mass, length = (np.array(values, dtype=float) for values in (scene.mass, scene.length))
    com = length if scene.com is None else np.array(scene.com, dtype=float)
    outer = np.append(np.cumsum(mass[::-1])[::-1][1:], 0.0)
    mu = mass * com + length * outer
    links = np.arange(scene.links)
    inner = np.minimum.outer(links, links)
    inertia = length[inner] * mu[np.maximum.outer(links, links)]
    inertia[links, links] = mass * com**2 + length**2 * outer
    if scene.has_cart:
        # On a cart that moves freely: its coordinate eliminated.
        inertia -= np.outer(mu, mu) / (float(scene.cart_mass) + mass.sum())  # type: ignore[arg-type]
    stiff = np.diag(float(scene.gravity) * mu)
    if scene.stiffness is not None:
        difference = np.eye(scene.links) - np.eye(scene.links, k=-1)
        stiff = stiff + difference.T @ np.diag(np.array(scene.stiffness, dtype=float)) @ difference
    # Of a badly scaled chain the largest eigenvalue is the accurate one.
    square = float(np.max(scipy.linalg.eigh(stiff, inertia, eigvals_only=True)))
    return _rounded_up(max(square, 0.0) ** 0.5)


def _rounded_up(rate: float) -> Fraction:
    digits = f"{rate * (1 + 0.5 * 10.0**-_DIGITS):.{_DIGITS - 1}e}"
    return Fraction(digits)
