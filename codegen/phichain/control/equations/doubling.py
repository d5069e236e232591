"""The structure-preserving doubling of a Riccati equation, in doubles or in twice their digits.

A Cayley transform with gamma > 0 turns A^T S + S A - S G S + Q = 0 into a discrete equation with the same solution,

    W = (A - gamma)^T + Q (A - gamma)^-1 G,   A_0 = 1 + 2 gamma W^-T,
    G_0 = 2 gamma (A - gamma)^-1 G W^-1,      S_0 = 2 gamma W^-1 Q (A - gamma)^-1,

whose horizon doubles with every step: with E = (1 + G_k S_k)^-1

    A_(k+1) = A_k E A_k,   G_(k+1) = G_k + A_k E G_k A_k^T,   S_(k+1) = S_k + A_k^T S_k E A_k.

S_k rises to the stabilising solution quadratically: about eight steps of one inverse and a few products, a third of
the time of a Schur method. gamma is the geometric mean of the closed loop's eigenvalues, from one determinant.

Source: E. K.-W. Chu, H.-Y. Fan, W.-W. Lin, A structure-preserving doubling algorithm for continuous-time algebraic
Riccati equations, Linear Algebra Appl. 396 (2005) 55-80.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from phichain.control.equations import wide
from phichain.control.equations.blocks import turned
from phichain.control.equations.wide import Wide
from phichain.system import Vector

Terms = tuple[Any, Any, Any]
"""A_k, G_k and S_k."""

MOST = 40
"""Steps allowed: a horizon of 2^40 times 1/gamma."""


def doubled(A: Vector, G: Vector, Q: Vector) -> Vector:
    """The stabilising S (count, n, n) of a stack of equations in doubles, right to what their conditioning leaves of them.

    Each equation's digits are its own, whatever it is stacked with. One whose matrices on the way are singular, or whose
    steps do not settle, has NaN for its S.
    """
    one = np.eye(A.shape[-1])
    try:
        terms = _cayley(A, G, Q, _gamma(A, G, Q)[:, None, None], np.linalg.inv, one)
        return _stepped(terms, one)
    except np.linalg.LinAlgError:
        # One singular matrix stops the whole stack.
        if len(A) == 1:
            return np.full_like(Q, np.nan)
        return np.concatenate([doubled(*equation) for equation in zip(A[:, None], G[:, None], Q[:, None], strict=True)])


def doubled_wide(A: Wide, G: Wide, Q: Wide) -> Wide:
    """The stabilising S (n, n) of one equation in about 32 digits.

    Raises:
        LinAlgError: A matrix on the way is singular, or the steps do not settle.
    """
    gamma, one = float(_gamma(A.high, G.high, Q.high)), Wide.of(np.eye(len(A.high)))
    return settled_wide(_cayley(A, G, Q, gamma, wide.inverse, one))


def settled_wide(terms: Terms) -> Wide:
    """The S (n, n) at which doubling settles, in about 32 digits, from A_0, G_0 and S_0 of a discrete equation.

    Raises:
        LinAlgError: A matrix on the way is singular, or the steps do not settle.
    """
    one = Wide.of(np.eye(len(terms[0].high)))
    for _ in range(MOST):
        terms, rise = _step(terms, wide.inverse, one)
        size = abs(terms[2]).max()
        if not np.isfinite(size):
            break
        if abs(rise).max() <= 1e-30 * size:
            result: Wide = _symmetric(terms[2])
            return result
    raise np.linalg.LinAlgError("the doubling steps do not settle")


def _stepped(terms: Terms, one: Vector) -> Vector:
    """The settled S of a stack; an equation takes no steps beyond its own."""
    result = np.full(terms[2].shape, np.nan)
    left = np.arange(len(result))
    for _ in range(MOST):
        terms, rise = _step(terms, np.linalg.inv, one)
        size = np.max(np.abs(terms[2]), axis=(1, 2))
        settled = np.max(np.abs(rise), axis=(1, 2)) <= 1e-14 * size
        result[left[settled]] = _symmetric(terms[2][settled])
        going = ~settled & np.isfinite(size)
        if not np.all(going):
            left, terms = left[going], tuple(part[going] for part in terms)
        if not len(left):
            break
    return result


def _gamma(A: Vector, G: Vector, Q: Vector) -> Vector:
    hamiltonian = np.block([[A, -G], [-Q, -turned(A)]])
    return np.asarray(np.exp(np.linalg.slogdet(hamiltonian)[1] / hamiltonian.shape[-1]))


def _cayley(A: Any, G: Any, Q: Any, gamma: Any, inverse: Callable[[Any], Any], one: Any) -> Terms:
    """A_0, G_0 and S_0."""
    shifted = A - one * gamma
    back = inverse(shifted)
    forth = inverse(turned(shifted) + Q @ back @ G) * (gamma * 2)
    return one + turned(forth), back @ G @ forth, forth @ Q @ back


def _step(terms: Terms, inverse: Callable[[Any], Any], one: Any) -> tuple[Terms, Any]:
    """The next A_k, G_k and S_k, and what was added to S_k."""
    a, g, s = terms[0], _symmetric(terms[1]), _symmetric(terms[2])
    near = inverse(one + g @ s)
    ahead, across, back = a @ near, near @ a, turned(a)
    rise = back @ (s @ across)
    return (ahead @ a, g + ahead @ g @ back, s + rise), rise


def _symmetric(matrix: Any) -> Any:
    # Halves are exact in both kinds of number.
    return (matrix + turned(matrix)) * 0.5
