"""Integral action: a regulator of a sampled chain together with integrals of what must not stay off.

With I_{k+1} = I_k + T C_i z_k beside z_{k+1} = A_d z_k + B_d u_k the discrete Riccati equation of both gives u = -K z - K_i I, and so
does pole placement.
A force that does not change, friction or a slope, then leaves no error of what is integrated.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import solve_discrete_lyapunov

from phichain.contract.words import known_names
from phichain.control.equations import wide as wide_matrices
from phichain.control.equations.sampled import discrete, held
from phichain.control.equations.wide import Wide
from phichain.control.gains import Gains
from phichain.control.placement import placed
from phichain.control.weights import Spectrum, ordered
from phichain.errors import ControlError
from phichain.records import Held
from phichain.system import Vector
from phichain.system.arrays import number

BLIND = 1e-9
"""Below this share the inputs cannot hold what is integrated where it is wanted."""


@dataclass(frozen=True, eq=False)
class Integrating(Held):
    """Gains on deviations and on integrals.

    Attributes:
        gains: The regulator without its integrals.
        integrated: Names of what is integrated (ni,), entries of the state x = (q, v).
        reads: Where they stand there.
        K: Gains on z (nu, 2m).
        K_i: Gains on the integrals (nu, ni).
        poles: Of the closed loop (2m + ni,), slowest first, 1/s.
        S: Cost to go of deviations and integrals (2m + ni, 2m + ni); of placed poles with weights of 1.
    """

    gains: Gains
    integrated: tuple[str, ...]
    reads: tuple[int, ...]
    K: Vector
    K_i: Vector
    poles: Spectrum
    S: Vector

    def __str__(self) -> str:
        return (
            f"integrals of {', '.join(self.integrated)}, slowest closed-loop eigenvalue {self.poles[0].real:.6g} 1/s, "
            f"largest gain {np.max(np.abs(np.hstack([self.K, self.K_i]))):.4g}"
        )


def with_integrals(gains: Gains, integrals: Mapping[str, float], poles: ArrayLike | None = None) -> Integrating:
    """The regulator of the same chain, weights and period, with integrals in its state.

    Args:
        gains: A sampled regulator.
        integrals: The weight of each integral by the name of what is integrated, a position of the state x.
        poles: Poles of the whole closed loop (2m + ni,), 1/s, to be placed instead; weights then say nothing.

    Raises:
        ControlError: The regulator is not sampled; a name is none of the positions; a weight is not positive; the inputs cannot
            hold all of them where they are wanted; or the poles cannot be placed.
    """
    if not gains.sample:
        raise ControlError("sample", None, "is what integral action needs: it adds up from sample to sample", "give the time between two")
    whole = gains.on_state(np.eye(gains.K.shape[1]))
    positions = whole.names[: len(whole.names) // 2]
    reads, weights = [], []
    for name, weight in integrals.items():
        if name not in positions:
            raise ControlError("integral", name, "is no position of this chain", known_names(name, positions))
        size = number("integral", weight, "give a positive weight", ControlError)
        if not 0 < size < np.inf:
            raise ControlError("integral", weight, f"is no positive weight of the integral of {name}", "give a positive one")
        reads.append(positions.index(name))
        weights.append(size)
    C = whole.gains[:, reads].T
    _demand_hold(gains, tuple(integrals), C)
    a, b = _joined(*held(gains.A, gains.B, gains.sample), C, gains.sample)
    n = len(gains.A)
    if poles is not None:
        K, values = placed(a.high, b.high, poles, gains.sample)
        closed = a.high - b.high @ K
        S = solve_discrete_lyapunov(closed.T, np.eye(len(closed)) + K.T @ K)
        return Integrating(
            gains, tuple(integrals), tuple(reads), *_parts(K, n), ordered(np.log(values.astype(complex)) / gains.sample), (S + S.T) / 2
        )
    try:
        found = discrete(a, b, _weights(gains.Q, weights), gains.R, gains.sample)
    except np.linalg.LinAlgError as failure:
        raise ControlError(
            "integral", dict(integrals), f"leaves no stabilising solution: {failure}", "weigh it less, or sample faster"
        ) from failure
    return Integrating(gains, tuple(integrals), tuple(reads), *_parts(found.K, n), found.poles, found.S)


def _parts(K: Vector, n: int) -> tuple[Vector, Vector]:
    return np.ascontiguousarray(K[:, :n]), np.ascontiguousarray(K[:, n:])


def _joined(a: Wide, b: Wide, C: Vector, sample: float) -> tuple[Wide, Wide]:
    """[[A_d, 0], [T C, 1]] and [B_d; 0]."""
    n, ni, nu = len(a.high), len(C), b.high.shape[1]
    below = Wide.of(C) * Wide.of(np.full_like(C, sample))
    left = wide_matrices.stacked(a, below)
    right = Wide.of(np.vstack([np.zeros((n, ni)), np.eye(ni)]))
    return Wide(np.hstack([left.high, right.high]), np.hstack([left.low, right.low])), wide_matrices.stacked(b, Wide.of(np.zeros((ni, nu))))


def _weights(Q: Vector, weights: list[float]) -> Vector:
    n, ni = len(Q), len(weights)
    found = np.zeros((n + ni, n + ni))
    found[:n, :n], found[n:, n:] = Q, np.diag(weights)
    return found


def _demand_hold(gains: Gains, names: tuple[str, ...], C: Vector) -> None:
    """[[A, B], [C, 0]] must have full row rank: else some offset of what is integrated cannot be brought about at rest."""
    if not len(C):
        raise ControlError("integral", [], "names nothing", "name a position, such as x")
    whole = np.block([[gains.A, gains.B], [C, np.zeros((len(C), gains.B.shape[1]))]])
    size = np.max(np.abs(whole), axis=1, keepdims=True)
    share = float(np.linalg.svd(whole / np.where(size > 0, size, 1.0), compute_uv=False)[-1]) if len(whole) <= whole.shape[1] else 0.0
    if share < BLIND:
        raise ControlError(
            "integral", list(names), f"cannot be held by {', '.join(gains.input_names)}: at rest they leave it no freedom (margin {share:.2g})",
            "integrate as many positions as there are inputs, such as the cart's", margin=share,
        )  # fmt: skip
