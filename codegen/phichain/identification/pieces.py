"""Recorded inputs as stretches over which they are constant, for flows that hold their input."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from phichain.records import Held
from phichain.system import Vector


@dataclass(frozen=True, eq=False)
class Piece(Held):
    """A stretch of time with one input.

    Attributes:
        t0, t1: Where it begins and ends, s.
        u: The input (nu,).
        times: The measured times behind t0 and up to t1.
    """

    t0: float
    t1: float
    u: Vector
    times: Vector


def pieces(t: Vector, u: Vector, between: str, cuts: int) -> tuple[Piece, ...]:
    """Cut the inputs u(t_i) into pieces.

    Held rows are pieces as they are, equal neighbours in one. Of a line, each interval is cut into `cuts` parts of length h, and each part into
    halves with u = mean -+ h u' / 3, the fourth-order commutator-free scheme with two exponentials (Blanes and Moan 2006): its error per unit of
    time falls as h^4, and no right-hand side that moves with time is needed.

    Args:
        t: Times (m,), s.
        u: Inputs (m, nu).
        between: "held" or "linear".
        cuts: Parts of an interval between the rows of lines.
    """
    flat = between == "held" or not np.diff(u, axis=0).any()
    if flat:
        starts = np.concatenate([[0], 1 + np.flatnonzero(np.diff(u[:-1], axis=0).any(axis=1))])
        ends = [*starts[1:].tolist(), len(t) - 1]
        return tuple(
            Piece(float(t[a]), float(t[b]), u[a], t[a + 1 : b + 1]) for a, b in zip(starts.tolist(), ends, strict=True)
        )
    found, none = [], np.empty(0)
    for k in range(len(t) - 1):
        knots = np.linspace(t[k], t[k + 1], 2 * cuts + 1)
        rise = (u[k + 1] - u[k]) / cuts
        for part in range(cuts):
            mean, (a, b, c) = u[k] + (part + 0.5) * rise, knots[2 * part : 2 * part + 3].tolist()
            found += [Piece(a, b, mean - rise / 3, none), Piece(b, c, mean + rise / 3, none if part < cuts - 1 else t[k + 1 : k + 2])]
    return tuple(found)
