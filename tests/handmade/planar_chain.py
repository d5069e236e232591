"""Planar chains from their dense mass matrix, with Phi of their single-harmonic balance."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from scipy.special import jv

from phichain.system import Joints, Numbers, System
from tests.handmade.formulas import GRAVITY, angle_map, batched, coefficients, complex_step, rk4


def planar(
    mass: Sequence[float],
    length: Sequence[float],
    com: Sequence[float] | None = None,
    *,
    cart_mass: float | None = None,
    gravity: float = GRAVITY,
    angles: str = "relative",
    stiffness: Sequence[float] | None = None,
    damping: Sequence[float] | None = None,
    armature: Sequence[float] | None = None,
    actuated: str = "none",
    leave_out: Sequence[str] = (),
    name: str = "handmade",
) -> System:
    """A planar chain, on a fixed base or a cart, as a System."""
    m, l = np.asarray(mass, float), np.asarray(length, float)
    r = l if com is None else np.asarray(com, float)
    n, cart = len(m), int(cart_mass is not None)
    mu, c = coefficients(m, l, r)
    S = np.eye(n + cart)
    S[cart:, cart:] = angle_map(n, angles)
    to_relative = np.linalg.inv(angle_map(n, "relative"))
    K = np.zeros((n + cart, n + cart))
    D, rotors = np.zeros_like(K), np.zeros_like(K)
    if stiffness is not None:
        K[cart:, cart:] = to_relative.T @ np.diag(stiffness) @ to_relative
    if damping is not None:
        D[cart:, cart:] = to_relative.T @ np.diag(damping) @ to_relative
    if armature is not None:
        rotors[cart:, cart:] = to_relative.T @ np.diag(armature) @ to_relative
    nu = {"none": 0, "all": n + cart, "cart": 1}[actuated]
    B = np.eye(n + cart)[:, :nu]

    def absolute_terms(y: np.ndarray, y_dot: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        phi, rate = y[cart:], y_dot[cart:]
        gap = phi[:, None] - phi
        M = rotors.astype(gap.dtype)
        M[cart:, cart:] += c * np.cos(gap)
        h, g = np.zeros(n + cart, dtype=np.result_type(y, y_dot)), np.zeros(n + cart, dtype=y.dtype)
        h[cart:] = (c * np.sin(gap)) @ rate**2
        g[cart:] = gravity * mu * np.sin(phi)
        if cart:
            M[0, 0] = cart_mass + m.sum()
            M[0, 1:] = M[1:, 0] = mu * np.cos(phi)
            h[0] = -(mu * np.sin(phi)) @ rate**2
        return M, h, g

    def dynamics(q: np.ndarray, v: np.ndarray, u: np.ndarray | None = None) -> np.ndarray:
        y, y_dot = S @ q, S @ v
        M, h, g = absolute_terms(y, y_dot)
        force = -h - g - K @ y - D @ y_dot
        generalised = S.T @ force + (0 if u is None else B @ u)
        return np.linalg.solve(S.T @ M @ S, generalised)

    def state_jacobian(*arguments: np.ndarray) -> tuple[np.ndarray, ...]:
        return tuple(complex_step(dynamics, arguments, k) for k in range(len(arguments)))

    def energy(q: np.ndarray, v: np.ndarray) -> tuple[float, float]:
        y, y_dot = S @ q, S @ v
        M, _, _ = absolute_terms(y, y_dot)
        return 0.5 * y_dot @ M @ y_dot, -gravity * mu @ np.cos(y[cart:]) + 0.5 * y @ K @ y

    def mass_matrix(q: np.ndarray) -> np.ndarray:
        return S.T @ absolute_terms(S @ q, S @ q)[0] @ S

    def linearization(s: np.ndarray) -> tuple[np.ndarray, ...]:
        signs = np.concatenate([np.ones(cart), s])
        y = np.where(signs > 0, 0.0, np.pi)
        M = S.T @ absolute_terms(y, 0 * y)[0] @ S
        G = K.copy()
        G[cart:, cart:] += np.diag(gravity * mu * s)
        parts: tuple[np.ndarray, ...] = (M, S.T @ G @ S)
        if damping is not None:
            parts = (*parts, S.T @ D @ S)
        return (*parts, B) if nu else parts

    def step(
        h: float, q: np.ndarray, v: np.ndarray, u: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        nq = n + cart
        after = rk4(
            lambda x: np.concatenate([x[nq:], dynamics(x[:nq], x[nq:], u)]), np.concatenate([q, v]), h
        )
        return after[:nq], after[nq:]

    functions: dict[str, Callable[..., Any]] = {
        "forward_dynamics": batched(dynamics),
        "state_jacobian": batched(state_jacobian),
        "energy": batched(energy),
        "mass_matrix": batched(mass_matrix),
        "linearization": linearization,
        "step": step,
    }
    if damping is None and armature is None:
        phi, phi_jacobian = harmonic(mu, c, S, K, gravity, None if not cart else cart_mass + m.sum())
        functions |= {"phi": phi, "phi_jacobian": phi_jacobian}
    thetas = tuple(f"theta_{k + 1}" for k in range(n))
    q_names = ("x",) * cart + thetas
    return System(
        name=name,
        space="planar",
        base="cart" if cart else "fixed",
        links=n,
        nq=n + cart,
        nv=n + cart,
        nu=nu,
        functions={k: f for k, f in functions.items() if k not in leave_out},
        q_names=q_names,
        v_names=tuple(f"{name}_dot" for name in q_names),
        u_names=tuple(f"u_{k}" for k in range(nu)),
        angles=angles,
        numbers=Numbers(m, l, r, cart_mass, gravity),
        joints=Joints(stiffness, damping, armature),
    )


def harmonic(
    mu: np.ndarray, c: np.ndarray, S: np.ndarray, K: np.ndarray, gravity: float, total: float | None
) -> tuple[Callable[..., np.ndarray], Callable[..., np.ndarray]]:
    """Phi of section 6 of docs/theory.md and its Jacobian; `total` is M00 of a chain on a cart."""
    cart = int(total is not None)

    def phi(amplitude: np.ndarray, omega: float) -> np.ndarray:
        X, B = amplitude[:cart], S[cart:, cart:] @ amplitude[cart:]
        gap = B[:, None] - B
        inertia = c * (-(jv(0, gap) - jv(2, gap)) * B + 0.5 * (jv(1, gap) + jv(3, gap)) * B**2)
        out = np.zeros(len(amplitude))
        out[cart:] = omega**2 * inertia.sum(axis=1) + 2 * gravity * mu * jv(1, B) + K[cart:, cart:] @ B
        if cart:
            out[cart:] -= omega**2 * mu * X * (jv(0, B) - jv(2, B))
            out[0] = -(omega**2) * (total * X[0] + 2 * mu @ jv(1, B))
        return S.T @ out

    def phi_jacobian(amplitude: np.ndarray, omega: float) -> np.ndarray:
        X, B = amplitude[:cart], S[cart:, cart:] @ amplitude[cart:]
        gap = B[:, None] - B
        by_gap = 1.5 * jv(1, gap) - 0.5 * jv(3, gap)
        slope = c * (by_gap * B + 0.25 * (jv(0, gap) - jv(4, gap)) * B**2)
        by_other = c * (-(jv(0, gap) - jv(2, gap)) + (jv(1, gap) + jv(3, gap)) * B)
        block = omega**2 * (by_other - slope + np.diag(slope.sum(axis=1)))
        block += np.diag(gravity * mu * (jv(0, B) - jv(2, B))) + K[cart:, cart:]
        out = np.zeros((len(amplitude), len(amplitude) + 1))
        if cart:
            block += np.diag(omega**2 * mu * X * (1.5 * jv(1, B) - 0.5 * jv(3, B)))
            out[cart:, 0] = -(omega**2) * mu * (jv(0, B) - jv(2, B))
            out[0, 0] = -(omega**2) * total
            out[0, 1:-1] = -(omega**2) * mu * (jv(0, B) - jv(2, B))
        out[cart:, cart:-1] = block
        out[:, :-1] = S.T @ out[:, :-1] @ S
        still = phi(amplitude, 0.0)
        out[:, -1] = 0.0 if omega == 0 else 2 / omega * (phi(amplitude, omega) - still)
        return out

    return phi, phi_jacobian


def uniform_planar(n: int, **more: Any) -> System:
    """Paper A's chain: masses and lengths 1/N, mass at half the link."""
    return planar([1 / n] * n, [1 / n] * n, [0.5 / n] * n, **more)
