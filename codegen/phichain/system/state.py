"""The state of a System: packing, the geometry of its parts, and the equations of motion as a vector field.

The state of the numerics is ``x = (q, v)`` in one vector of length ``nq + nv``; callables are ``f(t, x, u, p)``.
Every array may carry one leading batch axis.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from phichain.errors import ArrayError
from phichain.system.arrays import Vector, reals
from phichain.system.system import Parameters, System

VectorField = Callable[..., Vector]


def pack(q: ArrayLike, v: ArrayLike) -> Vector:
    """State x = (q, v) of shape (..., nq + nv).

    Raises:
        ArrayError: q and v hold no real numbers, or differ in more than their last axis.
    """
    parts = reals("q", q, "give real numbers"), reals("v", v, "give real numbers")
    shapes = parts[0].shape, parts[1].shape
    if () in shapes or shapes[0][:-1] != shapes[1][:-1]:
        raise ArrayError("q, v", shapes, "do not fit each other", "give both as vectors, or as many rows of each")
    return np.concatenate(parts, axis=-1)


def unpack(system: System, x: ArrayLike) -> tuple[Vector, Vector]:
    """The parts (q, v) of a state of shape (..., nq + nv).

    Raises:
        ArrayError: The last axis of x has not nq + nv entries.
    """
    state = reals("x", x, "pack(q, v) makes such a state")
    if state.ndim == 0 or state.shape[-1] != system.nx:
        raise ArrayError(
            "x",
            state.shape,
            f"the last axis must hold nq + nv = {system.nx} numbers",
            "pack(q, v) makes such a state",
        )
    return state[..., : system.nq], state[..., system.nq :]


def unit_vectors(system: System, q: Vector) -> Vector:
    """Link directions q_1 .. q_N of a spatial system, shape (..., N, 3)."""
    return q[..., system.cart_size :].reshape(*q.shape[:-1], system.links, 3)


def angular_velocities(system: System, v: Vector) -> Vector:
    """omega_1 .. omega_N of a spatial system, rad/s, shape (..., N, 3)."""
    return unit_vectors(system, v)


def velocity(system: System, q: Vector, v: Vector) -> Vector:
    """q' from (q, v): v itself in the plane, (x', omega_k x q_k) in space; shape (..., nq)."""
    if system.is_planar:
        return v
    one, two = _turned(system.cart_size, system.nq)
    spin = v.take(one, -1) * q.take(two, -1) - v.take(two, -1) * q.take(one, -1)
    return np.concatenate([v[..., : system.cart_size], spin], axis=-1)


@lru_cache
def _turned(start: int, stop: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Indices of stacked triples, turned once and twice: a x b is a[one] b[two] - a[two] b[one]."""
    triples = np.arange(start, stop).reshape(-1, 3)
    return triples[:, [1, 2, 0]].ravel(), triples[:, [2, 0, 1]].ravel()


def acceleration(
    system: System, q: Vector, v: Vector, u: ArrayLike | None = None, p: Parameters | None = None
) -> Vector:
    """v' by the system's forward dynamics, equation (15) or (16) solved; shape (..., nv).

    Args:
        system: The chain.
        q: Configuration (..., nq).
        v: Rates (..., nv).
        u: Input (..., nu); None means zero.
        p: Runtime parameters by name; None means the system's defaults.

    Raises:
        AbsentFunctionError: The system has no forward dynamics.
    """
    dynamics = system.function("forward_dynamics")
    return cast(Vector, np.asarray(dynamics(q, v, *input_arguments(system, q, u), **system.parameters(p))))


def input_arguments(system: System, q: Vector, u: ArrayLike | None) -> tuple[Vector, ...]:
    """The positional u of a callable: nothing without inputs, else u spread over q's batch axis.

    Raises:
        ArrayError: u was given to a system without inputs, or has not nu entries.
    """
    if system.nu == 0:
        if u is not None and np.size(u):
            raise ArrayError(
                "u", np.shape(u), "this system has no input", "leave u out or name joints in `actuated`"
            )
        return ()
    shape = (*q.shape[:-1], system.nu)
    if u is None:
        return (np.zeros(shape),)
    value = reals("u", u, "give one number per input")
    fits = value.ndim > 0 and value.shape[-1] == system.nu and value.ndim <= len(shape)
    if not fits or any(size not in (1, wanted) for size, wanted in zip(value.shape[-2::-1], shape[-2::-1], strict=False)):
        raise ArrayError(
            "u", value.shape, f"the last axis must hold nu = {system.nu} numbers", "give one per input"
        )
    return (np.broadcast_to(value, shape).copy() if value.shape != shape else value,)


def rhs(system: System) -> VectorField:
    """Right-hand side ``f(t, x, u=None, p=None) -> x'`` of the chain's equations of motion.

    x' = (q', v') with q' of `velocity` and v' of `acceleration`; x may carry a leading batch axis.

    Raises:
        AbsentFunctionError: The system has no forward dynamics (raised here, not at the first call).
    """
    system.function("forward_dynamics")

    def field_of(t: float, x: Vector, u: ArrayLike | None = None, p: Parameters | None = None) -> Vector:
        q, v = unpack(system, x)
        return np.concatenate([velocity(system, q, v), acceleration(system, q, v, u, p)], axis=-1)

    return field_of


def rhs_jacobian(system: System) -> VectorField:
    """Jacobian ``J(t, x, u=None, p=None) -> dx'/dx`` of `rhs` in the plain (ambient) state, shape (nx, nx).

    Planar: [[0, I], [da/dq, da/dv]]. Spatial: q_k' = omega_k x q_k adds hat(omega_k) and -hat(q_k) blocks.

    Raises:
        AbsentFunctionError: The system has no `state_jacobian`.
    """
    state_jacobian = system.function("state_jacobian")

    def jacobian_of(t: float, x: Vector, u: ArrayLike | None = None, p: Parameters | None = None) -> Vector:
        q, v = unpack(system, x)
        parts = state_jacobian(q, v, *input_arguments(system, q, u), **system.parameters(p))
        result = np.zeros((system.nx, system.nx))
        result[: system.nq, : system.nq], result[: system.nq, system.nq :] = _velocity_jacobian(system, q, v)
        result[system.nq :, : system.nq] = np.reshape(parts[0], (system.nv, system.nq))
        result[system.nq :, system.nq :] = np.reshape(parts[1], (system.nv, system.nv))
        return result

    return jacobian_of


def _velocity_jacobian(system: System, q: Vector, v: Vector) -> tuple[Vector, Vector]:
    by_q, by_v = np.zeros((system.nq, system.nq)), np.eye(system.nq, system.nv)
    if system.is_planar:
        return by_q, by_v
    for k, (direction, omega) in enumerate(
        zip(unit_vectors(system, q), angular_velocities(system, v), strict=True)
    ):
        at = slice(system.cart_size + 3 * k, system.cart_size + 3 * k + 3)
        by_q[at, at] = hat(omega)
        by_v[at, at] = -hat(direction)
    return by_q, by_v


def hat(a: ArrayLike) -> Vector:
    """The skew matrix with hat(a) b = a x b, shape (3, 3)."""
    x, y, z = np.asarray(a, dtype=float)
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
