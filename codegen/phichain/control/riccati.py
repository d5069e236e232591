"""The algebraic Riccati equation A^T S + S A - S B R^-1 B^T S + Q = 0, to round-off.

Parts that do not mix are solved apart, equal ones once (`control.blocks`). For each, doubling (`control.doubling`) gives
a stabilising solution. Newton's iteration, which is Kleinman's (1968), then removes what round-off it left: with
K = R^-1 B^T S and the residual F of the equation, (A - B K)^T X + X (A - B K) = -F and S <- S + X. Each step squares
the error and none can lose stability. In this form, unlike Kleinman's own, only the small correction X suffers from the
conditioning of the Lyapunov equation: with residual and S in extended precision the gains come out right to the last
digits where doubles alone lose half of them (an inverted five-link chain). Where long double is double, the
iteration still ends, at the accuracy of a plain one.

Where that does not settle (fourteen links upright lose all digits of a double), doubling is repeated in twice the
digits, and the closed loop's poles are found in coordinates in which it only loses cost: with S = L L^T the matrix
L^T (A - B K) L^-T has a negative definite symmetric part, so that its eigenvalues lie where they must.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import schur, solve_continuous_are
from scipy.linalg.lapack import dgees, dtrsyl

from phichain.control import wide
from phichain.control.blocks import blocks
from phichain.control.doubling import doubled, doubled_wide
from phichain.control.weights import Spectrum, ordered, solve, spectrum
from phichain.control.wide import Wide
from phichain.errors import ControlError
from phichain.records import Held
from phichain.system import Vector

Extended = NDArray[np.longdouble]

SOLVED = 1e-6
"""Relative residuals above this belong to no solution: those of solutions are near round-off."""

UNSEEN = 1e-10
"""A mode that the weights see by less than this share is as good as not weighed."""

SETTLED = 1e-9
"""Gains that the last Newton step still changed by more than this share need more digits."""


@dataclass(frozen=True, eq=False)
class Riccati(Held):
    """A stabilising solution.

    Attributes:
        S: Cost matrix (n, n): z^T S z is the cost to go.
        K: Gains (nu, n): u = -K z.
        poles: Eigenvalues (n,) of A - B K, slowest first.
        residual: Size of the equation's residual over the size of its terms, S in extended precision.
        iterations: Newton steps taken.
        change: Relative change of K in the last of them.
    """

    S: Vector
    K: Vector
    poles: Spectrum
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
            return _by_blocks(A, B, Q, R, max_iterations)
    except (np.linalg.LinAlgError, ValueError, OverflowError, FloatingPointError) as failure:
        sizes = tuple(float(np.max(np.abs(part))) for part in (Q, R))
        raise ControlError(
            "Q, R", sizes, f"lie beyond what the Riccati equation can be solved for: {failure}",
            "choose weights nearer to 1: their ratio alone matters", weights=sizes,
        ) from failure


def _by_blocks(A: Vector, B: Vector, Q: Vector, R: Vector, max_iterations: int) -> Riccati:
    S, K = np.zeros_like(A), np.zeros_like(B.T)
    solved: dict[bytes, Riccati] = {}
    poles, parts = [], []
    for block in blocks((A, Q), B, R):
        part = block.square(A), block.across(B), block.square(Q), block.over_inputs(R)
        key = b"".join(matrix.tobytes() for matrix in part)
        if key not in solved:
            solved[key] = _refined(*part, max_iterations)
        found = solved[key]
        signs = block.state_signs
        S[np.ix_(block.states, block.states)] = signs[:, None] * found.S * signs
        K[np.ix_(block.inputs, block.states)] = block.input_signs[:, None] * found.K * signs
        poles.append(found.poles)
        parts.append(found)
    return Riccati(
        S,
        K,
        ordered(np.concatenate(poles)),
        max(part.residual for part in parts),
        max(part.iterations for part in parts),
        max(part.change for part in parts),
    )


def _refined(A: Vector, B: Vector, Q: Vector, R: Vector, max_iterations: int) -> Riccati:
    _demand_detectable(A, Q)
    equation = _Extended.of(A, B, Q, R)
    try:
        found = _by_newton(equation, A, B, _first(A, B, Q, R), max_iterations)
    except np.linalg.LinAlgError:
        found = None
    if found is None or not found.change < SETTLED or not found.poles[0].real < 0 or not found.residual < SOLVED:
        found = _in_twice_the_digits(equation, A, B, Q, R)
    if not (np.all(np.isfinite(found.K)) and np.all(np.isfinite(found.S))):
        raise OverflowError("the gains are not finite")
    if not found.poles[0].real < 0:
        raise ControlError(
            "Q", float(found.poles[0].real), "leads to a closed loop that is not stable", "weigh every state, or actuate more"
        )
    if not found.residual < SOLVED:
        raise OverflowError(f"its residual stays at {found.residual:.2g} of its terms")
    return found


def _by_newton(equation: _Extended, A: Vector, B: Vector, start: Vector, max_iterations: int) -> Riccati:
    S = start.astype(np.longdouble)
    K = equation.gains(S)
    change, iterations = np.inf, 0
    while iterations < max_iterations and change > 0:
        triangle, vectors = _schur(A - B @ K.astype(float))
        turned = vectors.T @ equation.residual(S).astype(float) @ vectors
        part, scale, _ = dtrsyl(triangle, triangle, -turned, trana="T")
        correction = vectors @ (part / scale) @ vectors.T
        refined = S + (correction + correction.T) / 2
        gains = equation.gains(refined)
        step = float(np.max(np.abs(gains - K)) / np.max(np.abs(gains)))
        # Quadratic convergence ends in a plateau of round-off: the first step that does not halve the last one. The
        # first may lift the gains' error, as it is S that it mends.
        if iterations > 1 and not step < change / 2:
            break
        S, K, change, iterations = refined, gains, step, iterations + 1
    plain = K.astype(float)
    return Riccati(S.astype(float), plain, spectrum(A - B @ plain), equation.relative_residual(S), iterations, change)


def _in_twice_the_digits(equation: _Extended, A: Vector, B: Vector, Q: Vector, R: Vector) -> Riccati:
    a, b = Wide.of(A), Wide.of(B)
    pull = wide.inverse(Wide.of(R)) @ b.T
    S = doubled_wide(a, b @ pull, Wide.of(Q))
    # One of Newton's steps, whose Lyapunov equation is a Riccati equation without input.
    flow = a.T @ S
    error = flow + flow.T - S @ b @ pull @ S + Wide.of(Q)
    S = S + doubled_wide(a - b @ (pull @ S), Wide.of(np.zeros_like(A)), error)
    K = (pull @ S).high
    root = wide.cholesky(S).T
    closed = root @ (a - b @ Wide.of(K)) @ wide.inverse(root)
    extended = S.high.astype(np.longdouble) + S.low
    return Riccati(S.high, K, spectrum(closed.high), equation.relative_residual(extended), 0, 0.0)


def _schur(closed: Vector) -> tuple[Vector, Vector]:
    triangle, _, _, _, vectors, _, info = dgees(lambda *_: None, closed)
    if info:
        raise np.linalg.LinAlgError("the closed loop has no Schur form")
    return triangle, vectors


@dataclass(frozen=True, eq=False)
class _Extended(Held):
    """The equation's data in extended precision."""

    A: Extended
    B: Extended
    Q: Extended
    R_inverse: Extended

    @classmethod
    def of(cls, A: Vector, B: Vector, Q: Vector, R: Vector) -> _Extended:
        wide = [part.astype(np.longdouble) for part in (A, B, Q, R)]
        rough = np.linalg.inv(R).astype(np.longdouble)
        # One Newton step squares the error of a double inverse.
        return cls(wide[0], wide[1], wide[2], rough @ (2 * np.eye(len(R)) - wide[3] @ rough))

    def gains(self, S: Extended) -> Extended:
        """R^-1 B^T S."""
        return np.asarray(self.R_inverse @ (self.B.T @ S))

    def residual(self, S: Extended) -> Extended:
        """A^T S + S A - S B R^-1 B^T S + Q."""
        flow, pull = self.A.T @ S, self.B.T @ S
        return np.asarray(flow + flow.T - pull.T @ self.R_inverse @ pull + self.Q)

    def relative_residual(self, S: Extended) -> float:
        """The largest entry of the residual over the sum of the sizes of its terms."""
        flow, pull = self.A.T @ S, self.B.T @ S
        gain = pull.T @ self.R_inverse @ pull
        size = 2 * np.max(np.abs(flow)) + np.max(np.abs(gain)) + np.max(np.abs(self.Q))
        return float(np.max(np.abs(self.residual(S))) / size)


def _first(A: Vector, B: Vector, Q: Vector, R: Vector) -> Vector:
    """A stabilising start; the refinement needs no more."""
    try:
        S = doubled(A, B @ solve(R, B.T), Q)
        if np.all(np.linalg.eigvals(A - B @ solve(R, B.T @ S)).real < 0):
            return S
    except np.linalg.LinAlgError:
        pass
    try:
        return np.asarray(solve_continuous_are(A, B, Q, R), dtype=float)
    except (np.linalg.LinAlgError, ValueError):
        # SciPy judges its own result and gives up early.
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
    if np.linalg.eigvalsh(Q)[0] > UNSEEN * np.max(np.abs(Q)):
        return
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
