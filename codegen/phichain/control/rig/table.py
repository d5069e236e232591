"""The regulators of several equilibria as one table, each with the ellipsoid in which its law may take over.

The cost to go V = z^T S z falls along the closed loop, so a level V <= rho is not left again. rho is the largest for which, within it,
no input reaches its limit and no angle of a link (in space the sine of its tilt) passes `reach`: the largest value of c^T z on
V <= rho is sqrt(rho c^T S^-1 c), so that

    rho = min over inputs (limit - |u_0|)^2 / (k S^-1 k^T)   and over angles reach^2 / (S^-1)_ii.

The level is V / rho = |L^T z|^2 with S / rho = L L^T, a sum of squares in any precision. Deviations in space are tilts, which do not
tell a link that hangs from one that stands: there a term of fourth order does.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import cho_solve

from phichain.control.gains import Gains
from phichain.errors import ArrayError, ControlError
from phichain.laws import GainTable, StateFeedback
from phichain.laws.numbers import Matrix
from phichain.system import Vector
from phichain.system.arrays import number

REACH: Final = 0.1
"""Largest angle within a level of 1, rad, unless another is given: linear laws are not made for more."""

LEAVE: Final = 4.0
"""Level at which an equilibrium is let go unless another is given: twice as far as it was taken up."""


def gain_table(
    every: Sequence[Gains],
    target: ArrayLike | None = None,
    *,
    limit: ArrayLike | None = None,
    reach: float = REACH,
    leave: float = LEAVE,
) -> GainTable:
    """One table of several regulators of a chain.

    Args:
        every: The regulators, such as `regulators(system, sample=0.001)`.
        target: Where the cart is to stand (cart,), m; the origin unless given.
        limit: Largest size of every input; no limit unless given.
        reach: Largest angle within a level of 1, rad, below a quarter turn.
        leave: Level above which an equilibrium that is held is let go, 1 or more.

    Raises:
        ControlError: They belong to different chains or periods, there is none, `reach` is no small angle, or one's cost is not
            positive definite in double precision.
        ArrayError: As `Gains.law`, or `leave` is less than 1.
    """
    angle, let_go = demand_table(every, reach, leave)
    laws = [one.law(target, limit=limit) for one in every]
    first, one = laws[0], every[0]
    return GainTable(
        name=first.name, digest=first.digest, state_names=first.state_names, state_units=first.state_units,
        input_names=first.input_names, input_units=first.input_units, wraps=first.wraps,
        signs=tuple(gains.s for gains in every), targets=tuple(law.target for law in laws), rest=tuple(law.rest for law in laws),
        gains=tuple(law.gains for law in laws),
        shapes=tuple(_shape(gains, law, angle, let_go) for gains, law in zip(every, laws, strict=True)),
        compared=tuple(range(one.cart, len(one.equilibrium))), low=first.low, high=first.high, leave=let_go, sample=first.sample, p=first.p,
    )  # fmt: skip


def demand_table(every: Sequence[Gains], reach: float, leave: float) -> tuple[float, float]:
    """The largest angle and the level that lets go, if a table can be made of these regulators with them; errors as of `gain_table`."""
    if not every:
        raise ControlError("table", [], "holds no regulator", "give one for each equilibrium")
    kinds = {(one.name, one.space, one.digest, one.sample, len(one.s), one.state_names) for one in every}
    if len(kinds) > 1:
        raise ControlError("table", sorted(str(kind[:4]) for kind in kinds), "mixes regulators of different chains or periods", "make them of one")
    angle = number("reach", reach, "give the largest angle, rad", ControlError)
    if not 0 < angle < np.pi / 2:
        raise ControlError("reach", reach, "is no angle between 0 and a quarter turn", "give the largest angle within a level of 1, rad")
    given = number("leave", leave, "give the level at which an equilibrium is let go", ControlError)
    if not 1 <= given < np.inf:
        raise ArrayError("leave", leave, "would let go before it takes up", "give a level of 1 or more")
    return angle, given


def _shape(gains: Gains, law: StateFeedback, reach: float, leave: float) -> Matrix:
    """W (n, nx): 2m rows, and in space one more for each link."""
    upper = ellipsoid(gains, gains.S, gains.K, law, reach)
    rows = upper @ gains.on_state(np.eye(len(upper))).gains
    if gains.space == "spatial":
        rows = np.vstack([rows, upright(gains, rows.shape[1], leave)])
    return tuple(map(tuple, rows.tolist()))


def ellipsoid(gains: Gains, S: Vector, K: Vector, law: StateFeedback, reach: float) -> Vector:
    """L^T (2m, 2m) with |L^T z|^2 the level of a deviation z.

    Of a regulator with integrals I the cost is of both: a level is then the least cost to go over all I, which that of both bounds.
    With I before z in the Cholesky factor of S its last block is the factor of S_zz - S_zI S_II^-1 S_Iz.

    Args:
        gains: The regulator: what its deviations are.
        S: Cost to go (n, n), of z and then of integrals.
        K: Gains (nu, n) likewise.
        law: Its inputs at rest and their limits.
        reach: Largest angle within a level of 1, rad.

    Raises:
        ControlError: S is not positive definite in double precision.
    """
    size, n = np.sqrt(np.diag(S)), len(gains.A)
    order = [*range(n, len(S)), *range(n)]
    try:
        # In units of its own diagonal the cost keeps its digits.
        factor = np.linalg.cholesky((S / np.outer(size, size))[np.ix_(order, order)])
    except np.linalg.LinAlgError:
        raise ControlError(
            "table", list(gains.s), "has a cost that double precision cannot tell from a singular one", "take fewer links, or weigh every state"
        ) from None
    back = np.argsort(order)
    inverse = cho_solve((factor, True), np.eye(len(size)))[np.ix_(back, back)] / np.outer(size, size)
    bounds = [reach**2 / inverse[i, i] for i in range(gains.cart, n // 2)]
    for row, rest, high in zip(K, law.rest, law.high, strict=True):
        if np.isfinite(high):
            bounds.append((high - abs(rest)) ** 2 / float(row @ inverse @ row))
    return np.asarray((size[:n, None] * factor[-n:, -n:]).T / np.sqrt(min(bounds)))


def upright(gains: Gains, nx: int, leave: float) -> Vector:
    """sqrt(leave) (q_k3 - s_k), of fourth order in a tilt: a link that points the other way has the level 4 leave by this alone."""
    rows = np.zeros((len(gains.s), nx))
    for k in range(len(gains.s)):
        rows[k, gains.cart + 3 * k + 2] = np.sqrt(leave)
    return rows
