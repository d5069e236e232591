"""Regulators of a sampled chain: z_{k+1} = A_d z_k + B_d u_k with u held between samples, and the discrete Riccati equation

    S = A_d^T S A_d - A_d^T S B_d (R + B_d^T S B_d)^-1 B_d^T S A_d + Q,    K = (R + B_d^T S B_d)^-1 B_d^T S A_d,

which minimises sum_k (z_k^T Q z_k + u_k^T R u_k). Held over T seconds, (A_d, B_d) are rows of exp([[A, B], [0, 0]] T): exact,
no matter how long T is. With short samples A_d is nearly the identity and a double would hold few digits of the difference:
everything is computed in twice the digits.

Source: E. K.-W. Chu, H.-Y. Fan, W.-W. Lin, C.-S. Wang, Structure-preserving algorithms for periodic discrete-time algebraic
Riccati equations, Int. J. Control 77 (2004) 767-788.
"""

from __future__ import annotations

import numpy as np

from phichain.control.equations import wide
from phichain.control.equations.detectable import demand_detectable
from phichain.control.equations.doubling import settled_wide
from phichain.control.equations.riccati import SOLVED, Riccati, by_blocks
from phichain.control.equations.wide import Wide
from phichain.control.weights import ordered, spectrum
from phichain.errors import ControlError
from phichain.system import Vector

GROWTH = 10.0
"""An unstable mode may grow by this factor between two samples: whatever is measured wrong grows as much before it is seen."""

_TERMS = 30
"""Terms of the exponential's series, of matrices smaller than 1/4: the last is far below 32 digits."""


def held(A: Vector, B: Vector, sample: float) -> tuple[Wide, Wide]:
    """A_d (n, n) and B_d (n, nu) of an input that is held for `sample` seconds."""
    n, nu = B.shape
    whole = np.zeros((n + nu, n + nu))
    whole[:n, :n], whole[:n, n:] = A, B
    flow = exponential(whole, sample)
    return flow[:n, :n], flow[:n, n:]


def exponential(matrix: Vector, seconds: float) -> Wide:
    """exp(matrix * seconds) (n, n), by its series after halving and by squaring."""
    size = float(np.max(np.sum(np.abs(matrix), axis=1), initial=0.0)) * seconds
    halvings = max(0, int(np.ceil(np.log2(4 * size)))) if size > 0 else 0
    small = Wide.of(matrix) * Wide.of(np.full_like(matrix, seconds / 2**halvings))
    one = Wide.of(np.eye(len(matrix)))
    flow = one
    for k in range(_TERMS, 0, -1):
        flow = one + small @ flow / Wide.of(np.full_like(matrix, float(k)))
    for _ in range(halvings):
        flow = flow @ flow
    return flow


def sampled_riccatis(A: Vector, B: Vector, Q: Vector, R: Vector, sample: float) -> list[Riccati]:
    """The stabilising solutions for chains z' = A z + B u whose input is held between samples.

    Args:
        A: Dynamics (count, n, n).
        B: Input (count, n, nu).
        Q: State weight (n, n), positive semidefinite, of every sample.
        R: Input weight (nu, nu), positive definite, of every sample.
        sample: Time from one sample to the next, s.

    Returns:
        S, K and the rest of each; `poles` are log(z) / sample of the closed loop's eigenvalues z, 1/s.

    Raises:
        ControlError: `sample` is no positive time, or too long for the fastest unstable mode; or there is no stabilising
            solution.
    """
    for one in A:
        demand_sample(one, sample)
    demand_detectable(A, np.broadcast_to(Q, A.shape))

    def solved(*stack: Vector) -> list[Riccati]:
        return [_solved(a, b, q, r, sample) for a, b, q, r in zip(*stack, strict=True)]

    try:
        with np.errstate(all="ignore"):
            return by_blocks(A, B, Q, R, solved)
    except np.linalg.LinAlgError as failure:
        raise ControlError(
            "sample", sample, f"leaves no stabilising solution: {failure}", "sample faster, weigh every state, or actuate more"
        ) from failure


def demand_sample(A: Vector, sample: float) -> None:
    """Refuse what is no time between samples, and one over which an unstable mode grows too much.

    Raises:
        ControlError: It is one of these.
    """
    if isinstance(sample, bool) or not isinstance(sample, int | float | np.floating) or not 0 < sample < np.inf:
        raise ControlError("sample", sample, "is no positive time", "give the time between two samples, s")
    fastest = float(np.max(np.linalg.eigvals(A).real, initial=0.0))
    if fastest * sample > np.log(GROWTH):
        limit = float(np.log(GROWTH) / fastest)
        raise ControlError(
            "sample", sample, f"is too long: between two samples the mode lambda = {fastest:.6g} 1/s grows by {np.exp(min(fastest * sample, 700.0)):.3g}",
            f"sample at least every {limit:.3g} s", mode=fastest, limit=limit,
        )  # fmt: skip


def _solved(A: Vector, B: Vector, Q: Vector, R: Vector, sample: float) -> Riccati:
    return discrete(*held(A, B, float(sample)), Q, R, sample)


def discrete(a: Wide, b: Wide, Q: Vector, R: Vector, sample: float) -> Riccati:
    """The stabilising solution for z_{k+1} = a z_k + b u_k, a sample every `sample` seconds; the rest as above.

    Raises:
        LinAlgError: There is none.
    """
    weight, cost = Wide.of(R), Wide.of(Q)
    S = settled_wide((a, b @ wide.inverse(weight) @ b.T, cost))
    inner = wide.inverse(weight + b.T @ S @ b)
    gains = inner @ (b.T @ S @ a)
    pulled = a.T @ S @ a
    residual = pulled - S - a.T @ S @ b @ gains + cost
    size = max(float(np.max(abs(part))) for part in (pulled, S, cost))
    root = wide.cholesky(S).T
    closed = root @ (a - b @ gains) @ wide.inverse(root)
    multipliers = spectrum(closed.high)
    poles = ordered(np.asarray(np.log(multipliers) / sample, dtype=complex))
    error = float(np.max(abs(residual))) / size
    if not (np.all(np.isfinite(gains.high)) and error < SOLVED and poles[0].real < 0):
        raise np.linalg.LinAlgError(f"its residual stays at {error:.2g} of its terms")
    return Riccati(S.high, gains.high, poles, error, 0, 0.0)
