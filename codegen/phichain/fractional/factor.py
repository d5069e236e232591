"""The factor F of a planar chain's inertia matrix I = F^T F, straight from the scene's masses and lengths."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from phichain.errors import ArrayError, SignalError, UnsupportedError
from phichain.fractional.signals import real_array
from phichain.system import Parameters, System

Vector = NDArray[np.float64]


def joint_map(angles: str | None, links: int) -> Vector:
    """S of phi = S theta (section 2 of docs/theory.md): absolute angles from the scene's own, shape (N, N)."""
    if angles == "absolute":
        return np.eye(links)
    if angles == "adjacent":
        return np.eye(links) + np.eye(links, k=-1)
    return np.tril(np.ones((links, links)))


def inertia_factor(system: System, q: ArrayLike, p: Parameters | None = None) -> Vector:
    """F = diag(sqrt(m_a)) J_a with I(q) = F^T F, from the scene's parameters.

    Two rows per mass, horizontal and along gravity; links with inertia add one each, sqrt(J_k) phi_k', rotors one per joint, and a
    cart its own row and the column of x.

    Args:
        system: A planar chain.
        q: Configurations, shape (S, nq) or (nq,).
        p: Runtime parameters by name; None means the system's defaults.

    Returns:
        Shape (S, 2N (+ N) (+ 1), nv).

    Raises:
        UnsupportedError: A spatial scene.
        ArrayError: q of another shape, or parameters that are missing.
        SignalError: q is not finite.
    """
    rows = states_of(system, "q", q, system.nq)
    factor, relation = absolute_factor(system, rows.T, p), coordinates(system)
    return np.einsum("mks,kn->smn", factor, relation)


def coordinates(system: System) -> Vector:
    """The map from the scene's coordinates to absolute ones, cart included, shape (nv, nv)."""
    cart = system.cart_size
    relation = np.eye(cart + system.links)
    relation[cart:, cart:] = joint_map(system.angles, system.links)
    return relation


def _directions(angles: str | None, theta: Vector) -> tuple[Vector, Vector]:
    """cos phi and -sin phi of the links, by turning from joint to joint: exact at any number of turns."""
    turns = np.cos(theta) - 1j * np.sin(theta)
    if angles == "relative":
        np.cumprod(turns, axis=0, out=turns)
    elif angles == "adjacent":
        turns[1:] = turns[1:] * turns[:-1]
    return turns.real, turns.imag


def absolute_factor(system: System, q: Vector, p: Parameters | None) -> Vector:
    """The factor in absolute angles with the states along the last axis: q (nq, S) -> (2N (+ N) (+ 1), nv, S)."""
    refuse_spatial(system)
    links, cart = system.links, system.cart_size
    mass, length = system.number("mass", p), system.number("length", p)
    com = system.number("com", p, default=length)
    cosine, minus_sine = _directions(system.angles, q[cart:])
    spin = system.number("inertia", p, default=())
    rotors = 0 if system.joints.armature is None else links
    factor = np.zeros((2 * links + len(spin) + rotors + cart, cart + links, q.shape[1]))
    for k, own in enumerate(spin):
        factor[2 * links + k, cart + k] = np.sqrt(own)
    for a in range(links):
        reach = (np.where(np.arange(a + 1) < a, length[: a + 1], com[: a + 1]) * np.sqrt(mass[a]))[:, None]
        factor[2 * a, cart : cart + a + 1] = reach * cosine[: a + 1]
        factor[2 * a + 1, cart : cart + a + 1] = reach * minus_sine[: a + 1]
        factor[2 * a, :cart] = np.sqrt(mass[a])
    if rotors:
        slips = np.sqrt(system.number("armature", p))[:, None] * (np.eye(links) - np.eye(links, k=-1))
        factor[2 * links : 3 * links, cart:] = slips[:, :, None]
    if cart:
        factor[-1, 0] = np.sqrt(system.number("cart_mass", p))
    return factor


def refuse_spatial(system: System) -> None:
    """Raise for spatial scenes, which have no fractional view, and for planar ones whose base is given its acceleration.

    Raises:
        UnsupportedError: Always for them, with the reason.
    """
    if not system.is_planar:
        raise UnsupportedError(
            "space",
            system.space,
            "the fractional view needs angles: on the sphere v' = omega', and its second integral is not q",
            "use a planar scene",
        )
    if system.drive.accelerations:
        raise UnsupportedError(
            "base",
            system.base,
            "the fractional view is one of forces, and this base is given its acceleration",
            'use base = "fixed", or drive = "force" on a cart',
        )


def states_of(system: System, field: str, values: ArrayLike, size: int) -> Vector:
    """Rows of finite numbers, one per state, shape (S, size).

    Raises:
        ArrayError: Another shape.
        SignalError: They are not finite.
    """
    states = np.atleast_2d(real_array(field, values))
    if states.ndim != 2 or states.shape[1] != size:
        raise ArrayError(
            field, states.shape, f"must be (states, {size})", f"pass one row per state of '{system.name}'"
        )
    if not np.all(np.isfinite(states)):
        raise SignalError(field, states, "holds values that are not finite", "cut the states before them")
    return states
