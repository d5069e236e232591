"""Regulators across orbits: the periodic linear quadratic regulator of what lies across, the way along left free.

At each node f is the flow's direction, <.,.> the weighed product and P = 1 - f <f, .> / <f, f> the projection across. Between nodes the
deviation goes by P F P z + P G u, F and G the exact derivatives of the motion by state and held input. The Riccati equation

    S = h Q + F^T S F - F^T S G (h R + G^T S G)^-1 G^T S F,    K = (h R + G^T S G)^-1 G^T S F P

is run backwards over half periods, at whose end the mirror image takes over (z -> -z, which leaves S as it is), until K repeats.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from phichain.orbits.climb.motion import Equations
from phichain.system import Vector

STEPS: Final = 8
"""Steps of integration between two nodes."""
PARTS: Final = 4
"""Steps of integration from a state that is kept to a node."""
ROUNDS: Final = 400
"""Half periods at most; small orbits forget slowly."""
SETTLED: Final = 1e-4
STRAYS: Final = 3**0.5 / 18 / 6
"""Largest g (1 - g) (1 - 2 g) / 6: the cubic of Catmull and Rom misses so many third differences of its nodes."""
EVEN: Final = 0.25
"""Share of the phase that goes evenly with time, the rest with the way."""


def by_phase(equations: Equations, quarters: Vector, periods: Vector, weights: Vector, nodes: int) -> tuple[Vector, Vector, Vector]:
    """Half periods at nodes evenly spaced in a phase that goes with the way more than with time.

    Args:
        equations: The chain's motion.
        quarters: States from brake to bottom (orbits, m, nx), evenly spaced in time.
        periods: (orbits,), s.
        weights: Of the state's entries (nx,).
        nodes: Nodes of half a period, both ends among them.

    Returns:
        States (orbits, nodes, nx), their times (orbits, nodes) and rates of the phase (orbits, nodes), half periods a second.
    """
    half = quarters.shape[2] // 2
    mirror = np.concatenate([-np.ones(half), np.ones(half)])
    x = np.concatenate([quarters, quarters[:, -2::-1] * mirror], axis=1)
    count = x.shape[1] - 1
    h = periods / 2 / count
    speed = _speed(equations, x, weights)
    steps = (speed[:, 1:] + speed[:, :-1]) / 2 * h[:, None]
    length = np.sum(steps, axis=1, keepdims=True)
    phase = np.concatenate([np.zeros((len(x), 1)), np.cumsum((1 - EVEN) * steps / length + EVEN / count, axis=1)], axis=1)
    even = np.linspace(0, 1, nodes)
    t = np.array([np.interp(even, one / one[-1], np.arange(count + 1) * size) for one, size in zip(phase, h, strict=True)])
    before = np.minimum((t / h[:, None]).astype(int), count - 1)
    start = np.take_along_axis(x, before[:, :, None], axis=1)
    states, part = start, (t - before * h[:, None]) / PARTS
    for _ in range(PARTS):
        states = equations.step(states, part)
    rates = (1 - EVEN) * _speed(equations, states, weights) / length + 2 * EVEN / periods[:, None]
    return states, t, rates


def _speed(equations: Equations, x: Vector, weights: Vector) -> Vector:
    return np.asarray(np.sqrt(np.sum(weights * equations.rate(x) ** 2, axis=-1)))


def gains_across(equations: Equations, states: Vector, t: Vector, slowness: Vector, cost: float) -> Vector:
    """K (orbits, nodes, nx), with Q of the weights and R = cost.

    Args:
        equations: The chain's motion.
        states: By phase (orbits, nodes, nx).
        t: Their times (orbits, nodes), s.
        slowness: Weights of squared rates (orbits,), s^2; those of angles are 1.
        cost: R, per squared input.
    """
    orbits, nodes, nx = states.shape
    h = np.diff(t, axis=1)
    _, D = equations.carried(states[:, :-1].reshape(-1, nx), h.ravel(), STEPS)
    D = D.reshape(orbits, nodes - 1, nx, nx + 1)
    flow = equations.rate(states)
    weights = np.concatenate([np.ones((orbits, nx // 2)), np.tile(slowness[:, None], nx // 2)], axis=1)
    weighed = weights[:, None] * flow
    P = np.eye(nx) - flow[..., :, None] * weighed[..., None, :] / np.sum(flow * weighed, axis=-1)[..., None, None]
    F, G = P[:, 1:] @ D[..., :nx] @ P[:, :-1], (P[:, 1:] @ D[..., nx:])[..., 0]
    Q = weights[:, :, None] * np.eye(nx)
    S = Q.copy()
    K, old = np.zeros((orbits, nodes, nx)), np.full((orbits, nodes, nx), np.inf)
    for _ in range(ROUNDS):
        for i in range(nodes - 2, -1, -1):
            A, B = F[:, i], G[:, i]
            row = np.einsum("oi,oij,ojk->ok", B, S, A)
            r = cost * h[:, i] + np.einsum("oi,oij,oj->o", B, S, B)
            S = h[:, i, None, None] * Q + np.swapaxes(A, 1, 2) @ S @ A - row[:, :, None] * row[:, None, :] / r[:, None, None]
            S = (S + np.swapaxes(S, 1, 2)) / 2
            K[:, i] = row / r[:, None]
        K[:, -1] = K[:, 0]
        if np.all(np.abs(K - old) <= SETTLED * np.max(np.abs(K), axis=(1, 2), keepdims=True)):
            break
        old = K.copy()
    return K


def asked_between(states: Vector, gains: Vector) -> Vector:
    """Inputs that a law asks for between nodes while the chain is on its orbit (orbits, nodes - 1): |K d|, d by what the cubic misses the orbit.

    Args:
        states: By phase (orbits, nodes, nx).
        gains: K at them (orbits, nodes, nx).
    """
    whole = np.concatenate([-states[:, -2:-1], states, -states[:, 1:2]], axis=1)
    return np.asarray(STRAYS * np.abs(np.einsum("kni,kni->kn", gains[:, :-1], np.diff(whole, 3, axis=1))))
