"""Newton's iteration on a stack of Riccati equations, with S and residuals in extended precision.

The steps solve (A - B K)^T X + X (A - B K) = -F by the Schur form of the closed loop. Once K is right to six digits the
last form serves on: it is then off by a millionth, and so is the correction.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dgees, dtrsyl

from phichain.control.equations.blocks import Indices, turned
from phichain.records import Held
from phichain.system import Vector

Extended = NDArray[np.longdouble]
Loop = tuple[Vector, Vector]
"""The Schur form of a closed loop: the triangle and the vectors."""

STEADY = 1e-6
"""Gains that changed by less than this share keep the Schur form."""


@dataclass(frozen=True, eq=False)
class Equations(Held):
    """A stack of equations in extended precision.

    Attributes:
        A: Dynamics (count, n, n).
        B: Inputs (count, n, nu).
        Q: State weights (count, n, n).
        R_inverse: Inverses of the input weights (count, nu, nu).
    """

    A: Extended
    B: Extended
    Q: Extended
    R_inverse: Extended

    @classmethod
    def of(cls, A: Vector, B: Vector, Q: Vector, R: Vector) -> Equations:
        """The equations of doubles."""
        wide = [part.astype(np.longdouble) for part in (A, B, Q, R)]
        rough = np.linalg.inv(R).astype(np.longdouble)
        # One Newton step squares the error of a double inverse.
        return cls(wide[0], wide[1], wide[2], rough @ (2 * np.eye(R.shape[-1]) - wide[3] @ rough))

    def only(self, items: Indices) -> Equations:
        """Those of the stack."""
        return Equations(self.A[items], self.B[items], self.Q[items], self.R_inverse[items])

    def gains(self, S: Extended) -> Extended:
        """R^-1 B^T S."""
        return np.asarray(self.R_inverse @ (turned(self.B) @ S))

    def residual(self, S: Extended) -> Extended:
        """A^T S + S A - S B R^-1 B^T S + Q."""
        flow, gain = self._terms(S)
        return np.asarray(flow + turned(flow) - gain + self.Q)

    def relative_residual(self, S: Extended) -> Vector:
        """The largest entry of each residual over the sum of the sizes of its terms (count,)."""
        flow, gain = self._terms(S)
        size = 2 * largest(flow) + largest(gain) + largest(self.Q)
        return np.asarray(largest(flow + turned(flow) - gain + self.Q) / size, dtype=float)

    def _terms(self, S: Extended) -> tuple[Extended, Extended]:
        pull = turned(self.B) @ S
        return turned(self.A) @ S, turned(pull) @ (self.R_inverse @ pull)


@dataclass(frozen=True, eq=False)
class Refined(Held):
    """What the iteration leaves of a stack.

    Attributes:
        S: Solutions (count, n, n).
        K: Gains (count, nu, n).
        iterations: Steps taken (count,).
        change: Relative change of K in the last of them (count,); infinite where no closed loop had a Schur form.
    """

    S: Extended
    K: Extended
    iterations: Indices
    change: Vector


def refine(equations: Equations, A: Vector, B: Vector, start: Vector, loops: list[Loop | None], most: int) -> Refined:
    """Newton's iteration until the gains stop changing; no equation's digits depend on what it is stacked with.

    Args:
        equations: The stack.
        A: Its dynamics in doubles.
        B: Its inputs in doubles.
        start: Stabilising S (count, n, n).
        loops: The Schur forms of the closed loops that the start makes; None leaves an equation as it is.
        most: Steps allowed.
    """
    S = start.astype(np.longdouble)
    K = equations.gains(S)
    iterations, change = np.zeros(len(S), dtype=np.intp), np.full(len(S), np.inf)
    loops = list(loops)
    live = np.array([k for k, loop in enumerate(loops) if loop is not None], dtype=np.intp)
    while len(live):
        stale = live[(iterations[live] > 0) & (change[live] > STEADY)]
        for k, closed in zip(stale, A[stale] - B[stale] @ K[stale].astype(float), strict=True):
            loops[k] = schur_form(closed)
            change[k] = change[k] if loops[k] else np.inf
        live = np.array([k for k in live if loops[k] is not None], dtype=np.intp)
        if not len(live):
            break
        those = equations.only(live)
        refined = S[live] + _corrections([loops[k] for k in live], those.residual(S[live]).astype(float))
        gains = those.gains(refined)
        step = (largest(gains - K[live]) / largest(gains)).astype(float)
        # Quadratic convergence ends in a plateau of round-off: the first step that does not halve the last one. The
        # first may lift the gains' error, as it is S that it mends.
        taken = (iterations[live] <= 1) | (step < change[live] / 2)
        to = live[taken]
        S[to], K[to], change[to] = refined[taken], gains[taken], step[taken]
        iterations[to] += 1
        live = live[taken & (step > 0) & (iterations[live] < most)]
    return Refined(S, K, iterations, change)


def schur_form(closed: Vector) -> Loop | None:
    """The real Schur form of one closed loop (n, n); None where there is none."""
    triangle, _, _, _, vectors, _, info = dgees(lambda *_: None, closed)
    return None if info else (triangle, vectors)


def is_stable(loop: Loop | None) -> bool:
    """Whether there is a Schur form and its eigenvalues lie in the open left half plane."""
    # LAPACK's blocks of order two have equal diagonal entries, the real part of their pair.
    return loop is not None and bool(np.all(np.diagonal(loop[0]) < 0))


def largest(matrices: NDArray[np.floating]) -> NDArray[np.floating]:
    """The largest size of an entry of each matrix (count,)."""
    return np.asarray(np.max(np.abs(matrices), axis=(-2, -1)))


def _corrections(loops: list[Loop | None], errors: Vector) -> Vector:
    """X of (A - B K)^T X + X (A - B K) = -F for a stack."""
    vectors = np.array([loop[1] for loop in loops if loop])
    right = turned(vectors) @ errors @ vectors
    parts = np.empty_like(right)
    for part, loop, error in zip(parts, loops, right, strict=True):
        if loop:
            solution, scale, _ = dtrsyl(loop[0], loop[0], -error, trana="T")
            part[...] = solution / scale
    found = vectors @ parts @ turned(vectors)
    return (found + turned(found)) / 2
