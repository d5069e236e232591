"""The algebraic Riccati equation A^T S + S A - S B R^-1 B^T S + Q = 0, to round-off.

A Schur method (SciPy) gives a stabilising solution. Newton's iteration, which is Kleinman's (1968), then removes what
round-off it left: with K = R^-1 B^T S and the residual F of the equation, (A - B K)^T X + X (A - B K) = -F and
S <- S + X. Each step squares the error and none can lose stability. In this form, unlike Kleinman's own, only the
small correction X suffers from the conditioning of the Lyapunov equation: with residual and S in extended precision
the gains come out right to the last digits where the Schur method loses half of them (an inverted five-link chain).
Where long double is double, the iteration still ends, at the accuracy of a plain one.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import schur, solve_continuous_are, solve_continuous_lyapunov

from phichain.control.weights import solve, spectrum
from phichain.errors import ControlError
from phichain.records import Held
from phichain.system import Vector

Wide = NDArray[np.longdouble]

SOLVED = 1e-6
"""Relative residuals above this belong to no solution: those of solutions are near round-off."""

UNSEEN = 1e-10
"""A mode that the weights see by less than this share is as good as not weighed."""


@dataclass(frozen=True, eq=False)
class Riccati(Held):
    """A stabilising solution.

    Attributes:
        S: Cost matrix (n, n): z^T S z is the cost to go.
        K: Gains (nu, n): u = -K z.
        residual: Size of the equation's residual over the size of its terms, S in extended precision.
        iterations: Newton steps taken.
        change: Relative change of K in the last of them.
    """

    S: Vector
    K: Vector
    residual: float
    iterations: int
    change: float


def riccati(A: Vector, B: Vector, Q: Vector, R: Vector, max_iterations: int = 12) -> Riccati:
    """Solve the Riccati equation and refine it until the gains stop changing.

    Args:
        A: Dynamics (n, n).
        B: Input (n, nu).
        Q: State weight (n, n), positive semidefinite.
        R: Input weight (nu, nu), positive definite.
        max_iterations: Refinement steps allowed; three or four are usual.

    Raises:
        ControlError: There is no stabilising solution.
    """
    try:
        with np.errstate(all="ignore"), warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            return _refined(A, B, Q, R, max_iterations)
    except (np.linalg.LinAlgError, ValueError, OverflowError, FloatingPointError) as failure:
        sizes = tuple(float(np.max(np.abs(part))) for part in (Q, R))
        raise ControlError(
            "Q, R", sizes, f"lie beyond what the Riccati equation can be solved for: {failure}",
            "choose weights nearer to 1: their ratio alone matters", weights=sizes,
        ) from failure


def _refined(A: Vector, B: Vector, Q: Vector, R: Vector, max_iterations: int) -> Riccati:
    _demand_detectable(A, Q)
    equation = _Extended.of(A, B, Q, R)
    S = _first(A, B, Q, R).astype(np.longdouble)
    K = equation.gains(S)
    change, iterations = np.inf, 0
    while iterations < max_iterations and change > 0:
        closed = A - B @ K.astype(float)
        correction = solve_continuous_lyapunov(closed.T, -equation.residual(S).astype(float))
        refined = S + (correction + correction.T) / 2
        gains = equation.gains(refined)
        step = float(np.max(np.abs(gains - K)) / np.max(np.abs(gains)))
        # Quadratic convergence ends in a plateau of round-off: the first step that does not halve the last one.
        if step >= change / 2:
            break
        S, K, change, iterations = refined, gains, step, iterations + 1
    plain = K.astype(float)
    if not (np.all(np.isfinite(plain)) and np.all(np.isfinite(S.astype(float)))):
        raise OverflowError("the gains are not finite")
    _demand_stable(A - B @ plain)
    residual = equation.relative_residual(S)
    if not residual < SOLVED:
        raise OverflowError(f"its residual stays at {residual:.2g} of its terms")
    return Riccati(S.astype(float), plain, residual, iterations, change)


@dataclass(frozen=True, eq=False)
class _Extended(Held):
    """The equation's data in extended precision."""

    A: Wide
    B: Wide
    Q: Wide
    R_inverse: Wide

    @classmethod
    def of(cls, A: Vector, B: Vector, Q: Vector, R: Vector) -> _Extended:
        wide = [part.astype(np.longdouble) for part in (A, B, Q, R)]
        rough = np.linalg.inv(R).astype(np.longdouble)
        # One Newton step squares the error of a double inverse.
        return cls(wide[0], wide[1], wide[2], rough @ (2 * np.eye(len(R)) - wide[3] @ rough))

    def gains(self, S: Wide) -> Wide:
        """R^-1 B^T S."""
        return np.asarray(self.R_inverse @ (self.B.T @ S))

    def residual(self, S: Wide) -> Wide:
        """A^T S + S A - S B R^-1 B^T S + Q."""
        flow, pull = self.A.T @ S, self.B.T @ S
        return np.asarray(flow + flow.T - pull.T @ self.R_inverse @ pull + self.Q)

    def relative_residual(self, S: Wide) -> float:
        """The largest entry of the residual over the sum of the sizes of its terms."""
        flow, pull = self.A.T @ S, self.B.T @ S
        gain = pull.T @ self.R_inverse @ pull
        size = 2 * np.max(np.abs(flow)) + np.max(np.abs(gain)) + np.max(np.abs(self.Q))
        return float(np.max(np.abs(self.residual(S))) / size)


def _first(A: Vector, B: Vector, Q: Vector, R: Vector) -> Vector:
    try:
        return np.asarray(solve_continuous_are(A, B, Q, R), dtype=float)
    except (np.linalg.LinAlgError, ValueError):
        # SciPy judges its own result and gives up early; the refinement needs no more than a stabilising start.
        return ordered_schur(A, B, Q, R)


def ordered_schur(A: Vector, B: Vector, Q: Vector, R: Vector) -> Vector:
    """S from the stable invariant subspace of the Hamiltonian matrix (Laub 1979): another route to the same matrix.

    Raises:
        ControlError: Half of its eigenvalues are not in the open left half plane.
    """
    n = len(A)
    hamiltonian = np.block([[A, -B @ solve(R, B.T)], [-Q, -A.T]])
    _, vectors, stable = schur(hamiltonian, output="real", sort="lhp")
    if stable != n:
        raise ControlError(
            "Q",
            Q,
            "leaves a mode on the imaginary axis: there is no stabilising solution",
            "weigh every state, or actuate more",
        )
    S = np.linalg.solve(vectors[:n, :n].T, vectors[n:, :n].T).T
    return np.asarray((S + S.T) / 2, dtype=float)


def _demand_detectable(A: Vector, Q: Vector) -> None:
    """Refuse a Q that does not see a mode on the imaginary axis: no cost, so no gain, would ever damp it."""
    values = spectrum(A)
    size, weights = float(np.max(np.abs(values), initial=0.0)) or 1.0, Q / np.max(np.abs(Q))
    for value in values[np.abs(values.real) <= 1e-6 * size]:
        pencil = np.vstack([(A - value * np.eye(len(A))) / size, weights])
        margin = float(np.linalg.svd(pencil, compute_uv=False)[-1])
        if margin < UNSEEN:
            raise ControlError(
                "Q",
                Q,
                f"does not weigh the mode lambda = {value:.6g} 1/s, which would stay undamped",
                "weigh every coordinate",
                mode=complex(value),
                margin=margin,
            )


def _demand_stable(closed: Vector) -> None:
    slowest = float(np.max(np.linalg.eigvals(closed).real))
    if not slowest < 0:
        raise ControlError(
            "Q", slowest, "leads to a closed loop that is not stable", "weigh every state, or actuate more"
        )
