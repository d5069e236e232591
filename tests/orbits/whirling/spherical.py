"""The spherical pendulum in closed form: Legendre's integrals give the time from its lowest place to its lowest, and how far it has turned."""

from __future__ import annotations

import numpy as np
from scipy.special import elliprf, elliprj


def period_and_turn(energy: float, momentum: float, mass: float, length: float, gravity: float = 9.81) -> tuple[float, float]:
    """T, s, and phi, rad, of the motion of energy E, J from the hanging rest, and momentum J about the vertical.

    With u = cos theta from the hanging vertical u'^2 = (1 - u^2) (2 h - 2 w^2 (1 - u)) - j^2 = 2 w^2 (u - u_0) (u - u_1) (u_2 - u), and
    psi' = j / (1 - u^2): T = 4 K(m) / sqrt(2 w^2 (u_2 - u_0)), m = (u_2 - u_1) / (u_2 - u_0), and phi by Pi.
    """
    h, j, square = energy / (mass * length**2), momentum / (mass * length**2), gravity / length
    below, low, high = np.sort(np.roots([-2 * square, -2 * h + 2 * square, 2 * square, 2 * h - 2 * square - j**2]).real)
    m, pace = (high - low) / (high - below), np.sqrt(2 * square * (high - below))
    first = elliprf(0.0, 1 - m, 1.0)

    def third(n: float) -> float:
        return first + n / 3 * elliprj(0.0, 1 - m, 1.0, 1 - n)

    # 1 / (1 - u^2) is half of the sum of 1 / (1 + u) and 1 / (1 - u).
    about = third((high - low) / (1 + high)) / (1 + high) + third((low - high) / (1 - high)) / (1 - high)
    return 4 * first / pace, 2 * j * about / pace
