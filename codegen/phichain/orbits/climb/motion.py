"""Motions of many states at once, with their derivatives by state and input: the classical Runge-Kutta method on the emitted equations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from phichain.system import System, Vector


@dataclass(frozen=True)
class Equations:
    """x' = f(x) of a chain with one input, at rest, and its derivatives by state and input.

    Attributes:
        system: The chain, with `forward_dynamics` and `state_jacobian`.
    """

    system: System

    def rate(self, x: Vector, u: Vector | None = None) -> Vector:
        """f (..., nx) at states (..., nx), with inputs (...); none unless given."""
        half, flat = self.system.nq, x.reshape(-1, x.shape[-1])
        a = self.system.forward_dynamics(flat[:, :half], flat[:, half:], np.zeros((len(flat), 1)) if u is None else u.reshape(-1, 1))
        return np.concatenate([flat[:, half:], a], axis=1).reshape(x.shape)

    def slopes(self, x: Vector) -> tuple[Vector, Vector]:
        """A (count, nx, nx) and B (count, nx) at states (count, nx)."""
        half = self.system.nq
        dq, dv, du = self.system.state_jacobian(x[:, :half], x[:, half:], np.zeros((len(x), self.system.nu)))
        A, B = np.zeros((len(x), 2 * half, 2 * half)), np.zeros((len(x), 2 * half))
        A[:, :half, half:] = np.eye(half)
        A[:, half:, :half], A[:, half:, half:], B[:, half:] = dq, dv, du[:, :, 0]
        return A, B

    def step(self, x: Vector, h: Vector, u: Vector | None = None) -> Vector:
        """States (..., nx) one step of sizes h (...) on, inputs (...) held meanwhile."""
        h = np.asarray(h)[..., None]
        first = self.rate(x, u)
        second = self.rate(x + h / 2 * first, u)
        third = self.rate(x + h / 2 * second, u)
        return np.asarray(x + h / 6 * (first + 2 * (second + third) + self.rate(x + h * third, u)))

    def carried(self, x: Vector, t: Vector, steps: int) -> tuple[Vector, Vector]:
        """States (count, nx) times t (count,) on, and derivatives (count, nx, nx + 1) by the states and the input, held meanwhile."""
        count, nx = x.shape
        h, D = (np.asarray(t) / steps)[:, None], np.zeros((count, nx, nx + 1))
        D[:, :, :nx] = np.eye(nx)

        def moved(at: Vector, columns: Vector) -> tuple[Vector, Vector]:
            A, B = self.slopes(at)
            after = A @ columns
            after[:, :, nx] += B
            return self.rate(at), after

        for _ in range(steps):
            k1, d1 = moved(x, D)
            k2, d2 = moved(x + h / 2 * k1, D + h[:, :, None] / 2 * d1)
            k3, d3 = moved(x + h / 2 * k2, D + h[:, :, None] / 2 * d2)
            k4, d4 = moved(x + h * k3, D + h[:, :, None] * d3)
            x = x + h / 6 * (k1 + 2 * (k2 + k3) + k4)
            D = D + h[:, :, None] / 6 * (d1 + 2 * (d2 + d3) + d4)
        return x, D
