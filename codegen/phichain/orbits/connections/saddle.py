"""Where a connection leaves an equilibrium: along its unstable directions, which (19) gives.

M w'' + G w = 0 with w = e^(lambda t) w_k: -G w_k = lambda_k^2 M w_k, the largest entry of w_k 1. Motions near the equilibrium are odd in the
distance from it, so that the unstable manifold is x = x_0 + sum_k a_k (w_k, lambda_k w_k) up to the third order of a.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import eigh

from phichain.control.equilibria import demand_equilibrium
from phichain.errors import ControlError, UnsupportedError
from phichain.records import Held
from phichain.system import Parameters, System, Vector
from phichain.system.angles import scene_angles


@dataclass(frozen=True, eq=False)
class Saddle(Held):
    """An equilibrium with as many unstable directions as links.

    Attributes:
        s: Directions of the links, +1 hanging, -1 upright.
        phi: Absolute angles of the links (N,), 0 or -pi.
        x: The state (2 nq,), the cart at the origin.
        rates: Growth rates lambda_k, 1/s, falling (N,).
        directions: Columns (w_k, lambda_k w_k), (2 nq, N).
    """

    s: tuple[int, ...]
    phi: Vector
    x: Vector
    rates: Vector
    directions: Vector


def saddle(system: System, s: Sequence[int], p: Parameters | None) -> Saddle:
    """The equilibrium s of a conservative chain.

    Raises:
        ControlError: s is no equilibrium, or has fewer unstable directions than links.
        UnsupportedError: The chain is spatial, sprung, damped, or its base is moved.
    """
    _demand_conservative(system)
    linear = demand_equilibrium(system, s, p)
    squares, shapes = eigh(-linear.G, linear.M)
    growing = np.flatnonzero(squares > 0)[::-1]
    if len(growing) < system.links:
        problem = f"has {len(growing)} unstable direction(s) and {system.links} links: its unstable manifold meets no stable one of the same energy"
        raise ControlError(
            "s", list(linear.s), problem, "choose the upright chain; others connect at single values of a parameter only", unstable=len(growing)
        )
    rates = np.sqrt(squares[growing])
    phi = np.where(np.array(linear.s) > 0, 0.0, -np.pi)
    still = np.zeros(system.cart_size)
    x = np.concatenate([still, scene_angles(system, phi), np.zeros(system.nv)])
    largest = shapes[np.argmax(np.abs(shapes), axis=0), np.arange(len(squares))]
    modes = (shapes / largest)[:, growing]
    columns = np.vstack([modes, modes * rates])
    return Saddle(linear.s, phi, x, rates, columns)


def leaving(system: System, origin: Saddle, start: Vector, p: Parameters | None) -> Vector:
    """The state (2 nq,) at a = start; a cart moves so that the whole has no momentum, of which the tangent keeps a third power."""
    x, nq, carts = origin.x + origin.directions @ start, system.nq, system.cart_size
    if carts:
        row = np.asarray(system.mass_matrix(x[:nq], **system.parameters(p)))[0]
        x[nq] = -(row[carts:] @ x[nq + carts :]) / row[0]
    return x


def _demand_conservative(system: System) -> None:
    remedy = "use a planar scene of point masses or rigid links on a fixed base or a free cart, without springs and losses"
    if not system.is_planar:
        raise UnsupportedError("space", "spatial", "has no connections here", remedy)
    if system.joints.resists or system.numbers.brakes_cart:
        raise UnsupportedError("system", system.name, "loses energy, and no motion comes back to a saddle", remedy)
    if system.drive.accelerations:
        raise UnsupportedError("chain.drive", "acceleration", "moves the base as it is told", remedy)
    if system.joints.stiffness is not None:
        raise UnsupportedError("joints.stiffness", "given", "makes turns of the angles differ", remedy)
    if system.real != "double":
        raise UnsupportedError("target.real", system.real, "has too few digits for what leaves a saddle", 'use real = "double"')
