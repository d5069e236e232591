"""Planar chains as Systems made by hand, with the scene's numbers, and their motion and powers at high precision."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mpmath
import numpy as np

from phichain.system import Drive, Joints, Numbers, System
from tests.handmade import GRAVITY, angle_map, batched, coefficients


def chain(
    mass: Sequence[float],
    length: Sequence[float],
    com: Sequence[float] | None = None,
    *,
    angles: str = "relative",
    cart_mass: float | None = None,
    stiffness: Sequence[float] | None = None,
    damping: Sequence[float] | None = None,
    actuated: Any = "none",
    runtime: bool = False,
) -> System:
    """A chain with `coriolis`, `gravity_torque` and `forward_dynamics` by dense formulas (docs/theory.md, 1, 2)."""
    m, l = np.asarray(mass, float), np.asarray(length, float)
    r = l if com is None else np.asarray(com, float)
    n, cart = len(m), int(cart_mass is not None)
    mu, c = coefficients(m, l, r)
    S = np.eye(n + cart)
    S[cart:, cart:] = angle_map(n, angles)
    relative = (np.eye(n) - np.eye(n, k=-1)) @ angle_map(n, angles)
    inputs = input_matrix(n, cart, actuated)

    def mass_matrix(q: np.ndarray) -> np.ndarray:
        phi = (S @ q)[cart:]
        M = np.zeros((n + cart, n + cart))
        M[cart:, cart:] = c * np.cos(phi[:, None] - phi)
        if cart_mass is not None:
            M[0, 0] = cart_mass + m.sum()
            M[0, 1:] = M[1:, 0] = mu * np.cos(phi)
        return S.T @ M @ S

    def coriolis(q: np.ndarray, v: np.ndarray, **_: Any) -> np.ndarray:
        phi, rate = (S @ q)[cart:], (S @ v)[cart:]
        h = np.zeros(n + cart)
        h[cart:] = (c * np.sin(phi[:, None] - phi)) @ rate**2
        h[:cart] = -(mu * np.sin(phi)) @ rate**2
        return S.T @ h

    def gravity_torque(q: np.ndarray, **_: Any) -> np.ndarray:
        g = np.zeros(n + cart)
        g[cart:] = GRAVITY * mu * np.sin((S @ q)[cart:])
        return S.T @ g

    def forward_dynamics(q: np.ndarray, v: np.ndarray, u: np.ndarray | None = None, **_: Any) -> np.ndarray:
        force = -coriolis(q, v) - gravity_torque(q)
        for factors, signal in ((stiffness, q), (damping, v)):
            if factors is not None:
                force[cart:] -= relative.T @ (np.asarray(factors) * (relative @ signal[cart:]))
        if u is not None:
            force = force + inputs @ u
        return np.linalg.solve(mass_matrix(q), force)

    functions = {
        "coriolis": batched(coriolis),
        "gravity_torque": batched(gravity_torque),
        "forward_dynamics": batched(forward_dynamics),
        "mass_matrix": batched(mass_matrix),
    }
    numbers: dict[str, Any] = {"mass": list(m), "length": list(l), "com": list(r)}
    if cart_mass is not None:
        numbers["cart_mass"] = cart_mass
    return System(
        name="chain",
        space="planar",
        base="cart" if cart else "fixed",
        links=n,
        nq=n + cart,
        nv=n + cart,
        nu=inputs.shape[1],
        functions=functions,
        params=numbers if runtime else None,
        angles=angles,
        numbers=Numbers(**(dict.fromkeys(numbers, "runtime") if runtime else numbers), gravity=GRAVITY),
        joints=Joints(stiffness, damping),
        drive=Drive(tuple(np.flatnonzero(column)[0] for column in inputs.T)),
    )


def input_matrix(n: int, cart: int, actuated: Any) -> np.ndarray:
    """B of the scene's `actuated`: u = (force, torques) as generalised forces."""
    if actuated == "none":
        return np.zeros((n + cart, 0))
    if actuated in ("all", "cart"):
        return np.eye(n + cart)[:, : n + cart if actuated == "all" else 1]
    return np.eye(n + cart)[:, [*range(cart), *(cart + joint - 1 for joint in actuated)]]


def exact_powers(system: System, q: np.ndarray, u: np.ndarray, p: Sequence[float]) -> np.ndarray:
    """(I^-1)^p u at 50 digits from positions' Jacobians and a symmetric eigendecomposition, shape (P, nv) of mpf."""
    with mpmath.workdps(60):
        values, vectors = mpmath.eigsy(exact_inertia(system, q))
        modal = vectors.T * mpmath.matrix([mpmath.mpf(x) for x in u])
        rows = []
        for exponent in p:
            scaled = [modal[i] * values[i] ** -mpmath.mpf(exponent) for i in range(len(u))]
            rows.append(list(vectors * mpmath.matrix(scaled)))
        return np.array(rows)


def exact_inertia(system: System, q: np.ndarray) -> mpmath.matrix:
    """I = sum_a m_a J_a^T J_a, with the positions differentiated by hand; call within mpmath.workdps."""
    n, cart, numbers = system.links, system.cart_size, system.numbers
    S = angle_map(n, system.angles)
    phi = [mpmath.fsum(mpmath.mpf(S[k, j]) * mpmath.mpf(q[cart + j]) for j in range(n)) for k in range(n)]
    J = mpmath.zeros(2 * n + cart, n + cart)
    for a in range(n):
        root = mpmath.sqrt(mpmath.mpf(float(numbers.mass[a])))
        for k in range(a + 1):
            reach = root * mpmath.mpf(float((numbers.length if k < a else numbers.com)[k]))
            for j in np.flatnonzero(S[k]):
                J[2 * a, cart + int(j)] += reach * mpmath.cos(phi[k])
                J[2 * a + 1, cart + int(j)] -= reach * mpmath.sin(phi[k])
        if cart:
            J[2 * a, 0] = root
    if cart:
        J[2 * n, 0] = mpmath.sqrt(mpmath.mpf(float(numbers.cart_mass)))
    return J.T * J
