"""A regulator's gains on what is measured: from the coordinates of (19) to the state x = (q, v) itself."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from phichain.system import Vector
from phichain.system.vertical import Signs


class Measured(NamedTuple):
    """Gains on x - x_target, and what x is.

    Attributes:
        gains: K (nu, nx).
        names: Names of x.
        units: Units of x.
        wraps: Which entries are angles.
    """

    gains: Vector
    names: tuple[str, ...]
    units: tuple[str, ...]
    wraps: tuple[bool, ...]


def on_angles(K: Vector, cart: int, names: tuple[str, ...]) -> Measured:
    """In the plane z = x - x_target: the gains are the regulator's own."""
    links = len(names) // 2 - cart
    units = (*["m"] * cart, *["rad"] * links, *["m/s"] * cart, *["rad/s"] * links)
    wraps = (*[False] * cart, *[True] * links, *[False] * (cart + links))
    return Measured(K, names, units, wraps)


def on_unit_vectors(K: Vector, cart: int, s: Signs, names: tuple[str, ...]) -> Measured:
    """In space C^T xi_k = C^T (s_k e_3 x q_k) = s_k (-q_k2, q_k1) and C^T omega_k are linear in x, and zero at the target."""
    size, m = cart + 3 * len(s), cart + 2 * len(s)
    gains = np.zeros((len(K), 2 * size))
    for shift, column in ((0, 0), (size, m)):
        gains[:, shift : shift + cart] = K[:, column : column + cart]
    for k, sign in enumerate(s):
        tilt, rate = K[:, cart + 2 * k : cart + 2 * k + 2], K[:, m + cart + 2 * k : m + cart + 2 * k + 2]
        q, omega = cart + 3 * k, size + cart + 3 * k
        gains[:, q], gains[:, q + 1] = sign * tilt[:, 1], -sign * tilt[:, 0]
        gains[:, omega : omega + 2] = rate
    parts = [(k, i) for k in range(1, len(s) + 1) for i in (1, 2, 3)]
    place, speed = names[:cart], names[m : m + cart]
    known = (*place, *(f"q_{k}_{i}" for k, i in parts), *speed, *(f"omega_{k}_{i}" for k, i in parts))
    units = (*["m"] * cart, *["1"] * len(parts), *["m/s"] * cart, *["rad/s"] * len(parts))
    return Measured(gains, known, units, (False,) * (2 * size))
