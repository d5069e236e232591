"""Control (22): the linear regulator as a law on the chain's own state, and the errors the paper plots."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from phichain.control.gains import Gains
from phichain.errors import ArrayError
from phichain.system import System, Vector, angular_velocities, unit_vectors, unpack
from phichain.system.angles import absolute_angles
from phichain.system.arrays import real_numbers

Law = Callable[[float, Vector], Vector]


def feedback(system: System, gains: Gains, target: ArrayLike | None = None) -> Law:
    """The law u(t, x) = -K z(x), for `simulate(..., u=feedback(system, gains))`; with `sample=Ts` it is held between samples.

    Equation (22): u = -K_x (x - x_d) - K_xdot x' - sum_i K_q,i C^T (s_i e_3 x q_i) - sum_i K_omega,i C^T omega_i.

    Args:
        system: The chain the gains were made for.
        gains: The regulator.
        target: Where the cart is to stand (cart,), m; the origin unless given.

    Raises:
        ArrayError: The gains belong to another kind of chain, or the target has the wrong shape.
        ControlError: The target holds no real numbers.
    """
    deviation_of = deviation(system, gains, target)
    K = gains.K
    return lambda t, x: -(K @ deviation_of(x))


def deviation(system: System, gains: Gains, target: ArrayLike | None = None) -> Callable[[Vector], Vector]:
    """z(x) (..., 2m): how far a state (..., nx) is from the equilibrium, in the coordinates of (19).

    In space xi_i = s_i e_3 x q_i; in the plane angles count modulo a full turn.

    Raises:
        ArrayError: The gains belong to another kind of chain, or the target has the wrong shape.
        ControlError: The target holds no real numbers.
    """
    fits = gains.space == system.space and len(gains.s) == system.links and gains.cart == system.cart_size
    if not fits:
        kind = f"{gains.space} chain of {len(gains.s)} link(s) with {gains.cart} cart coordinate(s)"
        raise ArrayError(
            "gains", gains.name, f"were made for a {kind}", "make gains for this system: lqr(system, s)"
        )
    wanted = np.zeros(system.cart_size) if target is None else target
    place = np.atleast_1d(real_numbers("target", wanted, "give where the cart goes"))
    if place.shape != (system.cart_size,) or not np.all(np.isfinite(place)):
        raise ArrayError(
            "target", place, f"must hold {system.cart_size} finite position(s)", "give where the cart goes"
        )
    if system.is_planar:
        return lambda x: _planar(system, gains, place, x)
    return lambda x: _spatial(system, gains, place, x)


def _planar(system: System, gains: Gains, place: Vector, x: Vector) -> Vector:
    q, v = unpack(system, x)
    cart = system.cart_size
    turn = 2 * np.pi
    away = q[..., cart:] - gains.equilibrium[cart:]
    wrapped = away - turn * np.round(away / turn)
    return np.concatenate([q[..., :cart] - place, wrapped, v], axis=-1)


def _spatial(system: System, gains: Gains, place: Vector, x: Vector) -> Vector:
    q, v = unpack(system, x)
    cart = system.cart_size
    down = np.zeros((system.links, 3))
    down[:, 2] = gains.s
    directions = unit_vectors(system, q)
    tilts = np.cross(np.broadcast_to(down, directions.shape), directions)[..., :2]
    rates = angular_velocities(system, v)[..., :2]
    flat = (*q.shape[:-1], 2 * system.links)
    return np.concatenate(
        [q[..., :cart] - place, tilts.reshape(flat), v[..., :cart], rates.reshape(flat)], axis=-1
    )


def errors(system: System, gains: Gains, x: Vector) -> tuple[Vector, Vector]:
    """(e_q, e_omega) of states x (..., nx): the sums over the links of |q_i - s_i e_3| and of |omega_i|, rad/s.

    (The paper prints s_i e_i.) In the plane the same, with q_i = (sin phi_i, cos phi_i) of each link.
    """
    q, v = unpack(system, x)
    if system.is_planar:
        phi, rates = absolute_angles(system, q), absolute_angles(system, v)
        # |q_i - s_i e_2| is a chord of the unit circle.
        apart = phi - absolute_angles(system, gains.equilibrium)
        return 2 * np.sum(np.abs(np.sin(apart / 2)), axis=-1), np.sum(np.abs(rates), axis=-1)
    down = np.zeros((system.links, 3))
    down[:, 2] = gains.s
    gaps = np.linalg.norm(unit_vectors(system, q) - down, axis=-1)
    return np.sum(gaps, axis=-1), np.sum(np.linalg.norm(angular_velocities(system, v), axis=-1), axis=-1)
