"""The algebraic Riccati equation A^T S + S A - S B R^-1 B^T S + Q = 0, to round-off.

Parts that do not mix are solved apart, equal ones once (`control.equations.blocks`). For each, doubling (`control.equations.doubling`) gives
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
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import schur, solve_continuous_are

from phichain.control.equations import wide
from phichain.control.equations.blocks import alike, turned
from phichain.control.equations.detectable import demand_detectable
from phichain.control.equations.doubling import doubled, doubled_wide
from phichain.control.equations.newton import Equations, Loop, is_stable, refine, schur_form
from phichain.control.equations.wide import Wide
from phichain.control.weights import Spectrum, ordered, solve, spectrum
from phichain.errors import ControlError
from phichain.records import Held
from phichain.system import Vector

SOLVED = 1e-6
"""Relative residuals above this belong to no solution: those of solutions are near round-off."""

DIGITS = 30
"""Digits that a cost may spread over when it is computed in twice those of a double: two are left."""

ORDINARY = 1e12
"""Weights between this and its inverse are not to blame where a cost spreads over too many digits."""

LARGEST = 1e150
"""Weights above it are solved by their ratio: their squares overflow, and what LAPACK makes of that differs from build to build."""

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
    """Solve one Riccati equation and refine it until the gains stop changing.

    Args:
        A: Dynamics (n, n).
        B: Input (n, nu).
        Q: State weight (n, n), positive semidefinite.
        R: Input weight (nu, nu), positive definite.
        max_iterations: Refinement steps allowed; three or four are usual.

    Raises:
        ControlError: There is no stabilising solution.
    """
    return riccatis(A[None], B[None], Q, R, max_iterations)[0]


def riccatis(A: Vector, B: Vector, Q: Vector, R: Vector, max_iterations: int = 12) -> list[Riccati]:
    """The same for a stack of systems A (count, n, n), B (count, n, nu) under the same weights, each to the same bits.

    Raises:
        ControlError: One of them has no stabilising solution.
    """
    sizes = tuple(float(np.max(np.abs(part))) for part in (Q, R))
    share = _shared(*sizes)
    try:
        with np.errstate(all="ignore"), warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            found = by_blocks(A, B, Q / share, R / share, lambda a, b, q, r: _refined(a, b, q, r, max_iterations))
            return found if share == 1 else [_checked(replace(one, S=one.S * share)) for one in found]
    except (np.linalg.LinAlgError, ValueError, OverflowError, FloatingPointError) as failure:
        raise _beyond(sizes, failure) from failure


def _shared(state: float, control: float) -> float:
    """The power of two that weights of these sizes are divided by where one is too large for squares: their ratio alone matters.

    Raises:
        ControlError: The ratio itself is out of reach.
    """
    if max(state, control) <= LARGEST:
        return 1.0
    share = 2.0 ** np.floor(np.log2(control))
    if state / share > LARGEST or 0 < state / share < 1 / LARGEST:
        raise _beyond((state, control), f"a weight is {LARGEST:g} times the other or more")
    return float(share)


def _beyond(sizes: tuple[float, ...], why: object) -> ControlError:
    """Weights for which no solution can be computed."""
    problem, remedy = f"lie beyond what the Riccati equation can be solved for: {why}", "choose weights nearer to 1: their ratio alone matters"
    return ControlError("Q, R", sizes, problem, remedy, weights=sizes)


def by_blocks(A: Vector, B: Vector, Q: Vector, R: Vector, solver: Callable[..., list[Riccati]]) -> list[Riccati]:
    """The solutions of a stack whose parts that do not mix are solved apart, equal ones once.

    Args:
        A: Dynamics (count, n, n).
        B: Input (count, n, nu).
        Q: State weight (n, n).
        R: Input weight (nu, nu).
        solver: Solves a stack of parts, given as these four.
    """
    S, K = np.zeros_like(A), np.zeros_like(turned(B))
    parts: dict[int, list[Riccati]] = {}
    for group in alike((A, Q), B, R):
        solved = [solver(a, b, q, r) for a, q, b, r in group.problems]
        for block, member in zip(group.blocks, group.members, strict=True):
            signs, over = block.state_signs, block.input_signs
            costs = signs[:, :, None] * np.array([found.S for found in solved[member]]) * signs[:, None, :]
            gains = over[:, :, None] * np.array([found.K for found in solved[member]]) * signs[:, None, :]
            S[np.ix_(group.items, block.states, block.states)] = costs
            K[np.ix_(group.items, block.inputs, block.states)] = gains
        for at, k in enumerate(group.items.tolist()):
            parts[k] = [solved[member][at] for member in group.members]
    return [_joined(S[k], K[k], parts[k]) for k in range(len(A))]


def _joined(S: Vector, K: Vector, parts: Sequence[Riccati]) -> Riccati:
    return Riccati(
        S,
        K,
        ordered(np.concatenate([part.poles for part in parts])),
        max(part.residual for part in parts),
        max(part.iterations for part in parts),
        max(part.change for part in parts),
    )


def _refined(A: Vector, B: Vector, Q: Vector, R: Vector, max_iterations: int) -> list[Riccati]:
    """The solutions of a stack of equations, each checked."""
    demand_detectable(A, Q)
    equations = Equations.of(A, B, Q, R)
    start, loops = _first(A, B, Q, R)
    refined = refine(equations, A, B, start, loops, max_iterations)
    S, K = refined.S.astype(float), refined.K.astype(float)
    poles, residuals = _poles(A - B @ K), equations.relative_residual(refined.S)
    found = []
    for k in range(len(A)):
        one = Riccati(S[k], K[k], poles[k], float(residuals[k]), int(refined.iterations[k]), float(refined.change[k]))
        if not one.change < SETTLED or not one.poles[0].real < 0 or not one.residual < SOLVED:
            one = _in_twice_the_digits(equations.only(np.array([k])), A[k], B[k], Q[k], R[k])
        found.append(_checked(one))
    return found


def _poles(closed: Vector) -> list[Spectrum]:
    """The eigenvalues of a stack; NaN for all of them where entries of one are not finite."""
    fit = np.all(np.isfinite(closed), axis=(1, 2))
    values = np.full(closed.shape[:2], np.nan, dtype=complex)
    values[fit] = np.linalg.eigvals(closed[fit])
    return [ordered(row) for row in values]


def _checked(found: Riccati) -> Riccati:
    if not (np.all(np.isfinite(found.K)) and np.all(np.isfinite(found.S))):
        raise OverflowError("the gains are not finite")
    if not found.poles[0].real < 0:
        raise ControlError(
            "Q", float(found.poles[0].real), "leads to a closed loop that is not stable", "weigh every state, or actuate more"
        )
    if not found.residual < SOLVED:
        raise OverflowError(f"its residual stays at {found.residual:.2g} of its terms")
    return found


def _in_twice_the_digits(equation: Equations, A: Vector, B: Vector, Q: Vector, R: Vector) -> Riccati:
    a, b = Wide.of(A), Wide.of(B)
    pull = wide.inverse(Wide.of(R)) @ b.T
    try:
        S = doubled_wide(a, b @ pull, Wide.of(Q))
        # One of Newton's steps, whose Lyapunov equation is a Riccati equation without input.
        flow = a.T @ S
        error = flow + flow.T - S @ b @ pull @ S + Wide.of(Q)
        S = S + doubled_wide(a - b @ (pull @ S), Wide.of(np.zeros_like(A)), error)
    except np.linalg.LinAlgError:
        if all(1 / ORDINARY < np.max(np.abs(one)) < ORDINARY for one in (Q, R)):
            raise _too_many_digits(len(A), f"more than {DIGITS}", np.inf) from None
        raise
    K = (pull @ S).high
    _demand_digits(A, Q, S.high)
    root = wide.cholesky(S).T
    closed = root @ (a - b @ Wide.of(K)) @ wide.inverse(root)
    extended = S.high.astype(np.longdouble) + S.low
    return Riccati(S.high, K, spectrum(closed.high), float(equation.relative_residual(extended[None])[0]), 0, 0.0)


def _demand_digits(A: Vector, Q: Vector, S: Vector) -> None:
    """Refuse a cost that spreads over more digits than are computed.

    Its least eigenvalue is about q / 2 |A| with q that of the weight: what is lost is the largest against that.
    """
    least, largest_cost = float(np.linalg.eigvalsh(Q)[0]), float(np.max(np.abs(S)))
    if not (least > 0 and np.isfinite(largest_cost)):
        return
    lost = float(np.log10(largest_cost) + np.log10(2 * np.max(np.abs(A))) - np.log10(least))
    if lost > DIGITS:
        raise _too_many_digits(len(A), f"{lost:.0f}", lost)


def _too_many_digits(states: int, count: str, lost: float) -> ControlError:
    return ControlError(
        "s", f"{states} states", f"has a regulator whose cost spreads over {count} digits, of which {DIGITS} are computed",
        "take fewer links or longer ones, or let some of them hang", lost=lost, digits=DIGITS,
    )  # fmt: skip


def _first(A: Vector, B: Vector, Q: Vector, R: Vector) -> tuple[Vector, list[Loop | None]]:
    """Stabilising starts of a stack and the Schur forms of their closed loops; the refinement needs no more."""
    S = doubled(A, B @ solve(R, turned(B)), Q)
    closed = A - B @ solve(R, turned(B) @ S)
    fit = np.all(np.isfinite(closed), axis=(1, 2))
    loops = [schur_form(loop) if fits else None for loop, fits in zip(closed, fit, strict=True)]
    for k, loop in enumerate(loops):
        if not is_stable(loop):
            S[k] = _by_schur(A[k], B[k], Q[k], R[k])
            loops[k] = schur_form(A[k] - B[k] @ solve(R[k], B[k].T @ S[k]))
    return S, loops


def _by_schur(A: Vector, B: Vector, Q: Vector, R: Vector) -> Vector:
    try:
        return np.asarray(solve_continuous_are(A, B, Q, R), dtype=float)
    except (np.linalg.LinAlgError, ValueError):
        # SciPy judges its own result and gives up early.
        pass
    try:
        return ordered_schur(A, B, Q, R)
    except np.linalg.LinAlgError:
        return np.full_like(Q, np.nan)


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
