"""Spatial chains from the dense matrix form (16)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from phichain.system import System
from tests.handmade.formulas import GRAVITY, batched, coefficients, complex_step, rk4


def hat(a: np.ndarray) -> np.ndarray:
    """Skew matrices of vectors (..., 3): hat(a) b = a x b."""
    out = np.zeros((*a.shape[:-1], 3, 3), dtype=a.dtype)
    out[..., 2, 1], out[..., 0, 2], out[..., 1, 0] = a[..., 0], a[..., 1], a[..., 2]
    return out - np.swapaxes(out, -1, -2)


def spatial(
    mass: Sequence[float],
    length: Sequence[float],
    *,
    cart_mass: float | None = None,
    gravity: float = GRAVITY,
    leave_out: Sequence[str] = (),
    name: str = "handmade_spatial",
) -> System:
    """A spatial chain with its masses at the link ends, from the dense matrix form (16), as a System."""
    m, l = np.asarray(mass, float), np.asarray(length, float)
    n, cart = len(m), 2 * int(cart_mass is not None)
    mu, c = coefficients(m, l, l)
    nu = cart

    def dynamics(q: np.ndarray, v: np.ndarray, u: np.ndarray | None = None) -> np.ndarray:
        directions, rates = q[cart:].reshape(n, 3), v[cart:].reshape(n, 3)
        hats = hat(directions)
        blocks = -c[:, :, None, None] * (hats[:, None] @ hats[None, :])
        blocks[range(n), range(n)] = c[range(n), range(n), None, None] * np.eye(3)
        M = np.zeros((cart + 3 * n, cart + 3 * n), dtype=q.dtype)
        h = np.zeros(cart + 3 * n, dtype=np.result_type(q, v))
        M[cart:, cart:] = blocks.transpose(0, 2, 1, 3).reshape(3 * n, 3 * n)
        pull = (c - np.diag(np.diag(c))) @ (np.sum(rates * rates, axis=1)[:, None] * directions)
        pull[:, 2] += mu * gravity
        h[cart:] = -np.einsum("kij,kj->ki", hats, pull).ravel()
        if cart:
            down = (mu[:, None, None] * hats[:, :, :2]).reshape(3 * n, 2)
            M[cart:, :2], M[:2, cart:] = down, down.T
            M[:2, :2] = (cart_mass + m.sum()) * np.eye(2)
            h[:2] = -(mu * np.sum(rates * rates, axis=1)) @ directions[:, :2] - u
        return np.linalg.solve(M, -h)

    def state_jacobian(*arguments: np.ndarray) -> tuple[np.ndarray, ...]:
        return tuple(complex_step(dynamics, arguments, k) for k in range(len(arguments)))

    def energy(q: np.ndarray, v: np.ndarray) -> tuple[float, float]:
        directions, rates = q[cart:].reshape(n, 3), v[cart:].reshape(n, 3)
        moving = np.cross(rates, directions)
        kinetic = 0.5 * np.sum(c * (moving @ moving.T))
        if cart:
            kinetic += 0.5 * (cart_mass + m.sum()) * v[:2] @ v[:2] + v[:2] @ (mu @ moving[:, :2])
        return kinetic, -gravity * mu @ directions[:, 2]

    def linearization(s: np.ndarray) -> tuple[np.ndarray, ...]:
        J = np.array([[0.0, -1.0], [1.0, 0.0]])
        M, G = np.zeros((cart + 2 * n, cart + 2 * n)), np.zeros((cart + 2 * n, cart + 2 * n))
        M[cart:, cart:] = np.kron(c * np.outer(s, s), np.eye(2))
        G[cart:, cart:] = np.kron(np.diag(gravity * mu * s), np.eye(2))
        if not cart:
            return M, G
        M[:2, :2] = (cart_mass + m.sum()) * np.eye(2)
        M[2:, :2] = np.kron((mu * s)[:, None], J)
        M[:2, 2:] = M[2:, :2].T
        return M, G, np.eye(cart + 2 * n)[:, :2]

    def step(
        h: float, q: np.ndarray, v: np.ndarray, u: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        nq = cart + 3 * n

        def field(x: np.ndarray) -> np.ndarray:
            moving = np.cross(x[nq + cart :].reshape(n, 3), x[cart:nq].reshape(n, 3)).ravel()
            return np.concatenate([x[nq : nq + cart], moving, dynamics(x[:nq], x[nq:], u)])

        after = rk4(field, np.concatenate([q, v]), h)
        directions, rates = after[cart:nq].reshape(n, 3), after[nq + cart :].reshape(n, 3)
        directions /= np.linalg.norm(directions, axis=1)[:, None]
        rates -= np.sum(rates * directions, axis=1)[:, None] * directions
        return after[:nq], after[nq:]

    functions: dict[str, Callable[..., Any]] = {
        "forward_dynamics": batched(dynamics),
        "state_jacobian": batched(state_jacobian),
        "energy": batched(energy),
        "linearization": linearization,
        "step": step,
    }
    cart_names = ("x_1", "x_2")[:cart]
    return System(
        name=name,
        space="spatial",
        base="cart" if cart else "fixed",
        links=n,
        nq=cart + 3 * n,
        nv=cart + 3 * n,
        nu=nu,
        functions={k: f for k, f in functions.items() if k not in leave_out},
        q_names=cart_names + tuple(f"q_{k + 1}_{i + 1}" for k in range(n) for i in range(3)),
        v_names=tuple(f"{x}_dot" for x in cart_names)
        + tuple(f"omega_{k + 1}_{i + 1}" for k in range(n) for i in range(3)),
        u_names=("force_1", "force_2")[:nu],
    )


def paper_b(**more: Any) -> System:
    """Paper B's five-link chain on a cart."""
    return spatial([0.1] * 5, [0.1] * 5, cart_mass=0.5, **more)
