"""Harmonic balance of one link as NumPy writes it: odd harmonics, alternating frequency-time, pseudo-arclength, an exact Jacobian.

    m r^2 theta'' + d theta' + m g r sin theta = A cos(omega t)

Two forms: the free link's brake orbits on odd cosines (amplitude and omega free), and the driven one's response on odd cosines and sines.
Steps follow the turn of the tangent, as ours do.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

Vector = np.ndarray
Equations = Callable[[Vector], tuple[Vector, Vector]]
_TURN, _LARGEST = 0.1, 0.1


@dataclass(frozen=True)
class Link:
    """m r^2, m g r, d and A."""

    inertia: float
    weight: float
    damping: float = 0.0
    drive: float = 0.0


def free(link: Link, highest: int) -> Equations:
    """z = (X_1, X_3, .., omega) -> residual (M,), Jacobian (M, M + 1)."""
    order = np.arange(1, highest + 1, 2)
    count = 2 * len(order)
    value = np.cos(np.outer(np.pi / 2 * (np.arange(count) + 0.5) / count, order))
    project = 2 / count * value.T

    def equations(z: Vector) -> tuple[Vector, Vector]:
        theta, inertia = value @ z[:-1], -link.inertia * order**2 * z[:-1]
        residual = z[-1] ** 2 * inertia + link.weight * (project @ np.sin(theta))
        jacobian = np.empty((len(order), len(order) + 1))
        jacobian[:, :-1] = link.weight * (project @ (np.cos(theta)[:, None] * value))
        jacobian[np.arange(len(order)), np.arange(len(order))] -= z[-1] ** 2 * link.inertia * order**2
        jacobian[:, -1] = 2 * z[-1] * inertia
        return residual, jacobian

    return equations


def driven(link: Link, highest: int) -> Equations:
    """z = (cosines, sines, omega) -> residual (2 M,), Jacobian (2 M, 2 M + 1)."""
    order = np.arange(1, highest + 1, 2)
    m, count = len(order), 2 * (highest + 1)
    angle = np.outer(np.pi * np.arange(count) / count, order)
    value = np.hstack([np.cos(angle), np.sin(angle)])
    project, both = 2 / count * value.T, np.concatenate([order, order])
    places, drive = np.arange(2 * m), np.zeros(2 * m)
    drive[0] = link.drive

    def equations(z: Vector) -> tuple[Vector, Vector]:
        theta, omega = value @ z[:-1], z[-1]
        inertia = -link.inertia * both**2 * z[:-1]
        resistance = link.damping * order * np.concatenate([z[m:-1], -z[:m]]).reshape(2, m)
        residual = omega**2 * inertia + omega * resistance.ravel() + link.weight * (project @ np.sin(theta)) - drive
        jacobian = np.empty((2 * m, 2 * m + 1))
        jacobian[:, :-1] = link.weight * (project @ (np.cos(theta)[:, None] * value))
        jacobian[places, places] -= omega**2 * link.inertia * both**2
        jacobian[places[:m], places[m:]] += omega * link.damping * order
        jacobian[places[m:], places[:m]] -= omega * link.damping * order
        jacobian[:, -1] = 2 * omega * inertia + resistance.ravel()
        return residual, jacobian

    return equations


def followed(equations: Equations, z: Vector, scale: Vector, ends: Callable[[Vector], bool], tolerance: float = 1e-9) -> Vector:
    """The points (m, n + 1) of the branch from z on, until `ends`; omega rises at first where it can, else the first coefficient does."""

    def at(y: Vector) -> tuple[Vector, Vector]:
        residual, jacobian = equations(y * scale)
        return residual, jacobian * scale

    def corrected(y: Vector, normal: Vector) -> Vector | None:
        guess = y
        for _ in range(7):
            residual, jacobian = at(y)
            step = np.linalg.solve(np.vstack([jacobian, normal]), -np.append(residual, normal @ (y - guess)))
            y = y + step
            if np.linalg.norm(step) < tolerance * (1 + np.linalg.norm(y)):
                return y
        return None

    def tangent(y: Vector, along: Vector) -> Vector:
        found = np.linalg.solve(np.vstack([at(y)[1], along]), np.append(np.zeros(len(y) - 1), 1.0))
        return found / np.linalg.norm(found)

    first = np.zeros(len(z))
    first[-1 if np.all(z[:-1] == 0) else 0] = 1.0
    y = corrected(z / scale, first)
    assert y is not None
    points, t, step = [y], tangent(y, first), 0.01
    while not ends(points[-1] * scale):
        new = corrected(points[-1] + step * t, t)
        if new is None:
            step /= 2
            continue
        after = tangent(new, t)
        turn = float(np.arccos(min(1.0, float(after @ t))))
        if turn > 3 * _TURN:
            step /= 2
            continue
        points.append(new)
        t, step = after, min(_LARGEST, step * min(2.0, max(0.5, _TURN / max(turn, 1e-6))))
    return np.array(points) * scale
