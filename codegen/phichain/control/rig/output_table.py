"""The regulators of several equilibria as one table with an observer for each, with integrals, or with both.

How long an observer is watched before its equilibrium is taken up: its error moves as e_{k+1} = (1 - L C) A_d e_k, and in units of
the ellipsoid, L^T e, no error is larger than a tenth of what it was after as many calls as the smallest k with
|L^T ((1 - L C) A_d)^k L^-T| <= 1/10.

An estimate trembles with the steps of its sensors even where the chain rests. With the covariance P of its error, a Lyapunov equation's, it
does so by sigma = |L^T P L|^(1/2) in units of the ellipsoid at most. That much is allowed for: an equilibrium is taken up at the level
(1 + sigma)^2, and let go above (sqrt(leave) + 3 sigma)^2.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike

from phichain.control.gains import Gains
from phichain.control.rig.integral import with_integrals
from phichain.control.rig.observer import Estimator, Sensors, estimator
from phichain.control.rig.output import output_law
from phichain.control.rig.table import LEAVE, REACH, demand_table, ellipsoid, upright
from phichain.errors import ControlError
from phichain.laws import OutputFeedback, OutputTable
from phichain.laws.numbers import less_turns
from phichain.system import Vector

FORGOTTEN: Final = 0.1
"""What is left of an estimate's error when it has settled."""

LONGEST: Final = 100_000
"""Calls that no observer may need to settle."""

TREMBLING: Final = 3.0
"""Standard deviations by which an estimate may tremble before its equilibrium is let go."""

_APART: Final = 1e-6
"""Equilibria that are measured to be closer than this, squared, cannot be told apart."""


def output_table(
    every: Sequence[Gains],
    observer: str | None = None,
    sensors: Sensors | None = None,
    integrals: Mapping[str, float] | None = None,
    target: ArrayLike | None = None,
    *,
    poles: ArrayLike | None = None,
    limit: ArrayLike | None = None,
    reach: float = REACH,
    leave: float = LEAVE,
) -> OutputTable:
    """One table of several sampled regulators of a chain, with observers, integrals or both.

    Args:
        every: The regulators, such as `regulators(system, sample=0.001)`.
        observer: "kalman" or "reduced"; None where the whole state is measured.
        sensors: What is measured and how well; of chains in space the vertical parts of links that are measured are read beside,
            as nothing else tells a link that hangs from one that stands.
        integrals: The weight of each integral by the name of what is integrated.
        target: Where the cart is to stand (cart,), m; the origin unless given.
        poles: Poles of each closed loop with its integrals, 1/s, to be placed instead of weights.
        limit: Largest size of every input; no limit unless given.
        reach: Largest angle within a level of 1, rad, below a quarter turn.
        leave: Level above which an equilibrium that is held is let go, 1 or more, but for what sensors alone make of it.

    Raises:
        ControlError: As `gain_table`, `estimator` and `with_integrals`; neither is asked for; what is measured does not tell two of the
            equilibria apart; or an observer does not settle.
        ArrayError: As `gain_table`.
    """
    angle, let_go = demand_table(every, reach, leave)
    if observer is None and not integrals:
        raise ControlError("observer, integrals", None, "are both left out", "give one, or take gain_table")
    laws, shapes, begins, observed = [], [], [], []
    for gains in every:
        estimate = None if observer is None else estimator(gains, sensors, observer)
        joined = with_integrals(gains, integrals, poles) if integrals else None
        law = output_law(gains, estimate, joined, target, limit=limit)
        S, K = (gains.S, gains.K) if joined is None else (joined.S, np.hstack([joined.K, joined.K_i]))
        upper = ellipsoid(gains, S, K, gains.law(target, limit=limit), angle)
        n = len(upper)
        begin = -np.linalg.solve(S[n:, n:], S[n:, :n]) if joined is not None else np.zeros((0, n))
        if estimate is None:
            rows, begin = upper @ gains.on_state(np.eye(n)).gains, begin @ gains.on_state(np.eye(n)).gains
            if gains.space == "spatial":
                rows = np.vstack([rows, upright(gains, rows.shape[1], let_go)])
        else:
            rows = upper
            law = _with_verticals(gains, law) if gains.space == "spatial" else law
        laws.append(law)
        shapes.append(tuple(map(tuple, rows.tolist())))
        begins.append(tuple(map(tuple, begin.tolist())))
        observed.append((estimate, upper))
    compared = tuple(i for i, k in enumerate(laws[0].reads) if every[0].cart <= k < len(every[0].equilibrium))
    _demand_told(laws, every, compared)
    settle = [0 if estimate is None else _settled(estimate, upper, gains) for (estimate, upper), gains in zip(observed, every, strict=True)]
    trembles = [0.0 if estimate is None else _tremble(estimate, upper) for estimate, upper in observed]
    take, leaving = ((1 + np.array(trembles)) ** 2, (np.sqrt(let_go) + TREMBLING * np.array(trembles)) ** 2)
    signs = tuple(gains.s for gains in every)
    return OutputTable(tuple(laws), signs, tuple(shapes), tuple(begins), compared, tuple(settle), tuple(take), tuple(leaving))


def _with_verticals(gains: Gains, law: OutputFeedback) -> OutputFeedback:
    """The same law, which reads the vertical parts of the links that it measures too, and makes nothing of them."""
    assert law.observer is not None
    whole, links = gains.law(), len(gains.s)
    more = [gains.cart + 3 * k + 2 for k in range(links) if {gains.cart + 3 * k, gains.cart + 3 * k + 1} & set(law.reads)]
    none = np.zeros((len(gains.A), len(more)))
    widened: dict[str, Any] = {name: np.hstack([getattr(law.observer, name), none]) for name in ("correction", "start")}
    observer = replace(law.observer, **widened, seen=np.vstack([law.observer.seen, none.T]))  # type: ignore[arg-type]
    return replace(
        law, observer=observer, reads=(*law.reads, *more), offsets=(*law.offsets, *(whole.target[k] for k in more)),
        measured_names=(*law.measured_names, *(whole.state_names[k] for k in more)),
        measured_units=(*law.measured_units, *(whole.state_units[k] for k in more)), wraps=(*law.wraps, *(False for _ in more)),
    )  # fmt: skip


def _tremble(estimate: Estimator, upper: Vector) -> float:
    """The largest standard deviation of an estimate in units of the ellipsoid."""
    return float(np.sqrt(max(0.0, np.linalg.eigvalsh(upper @ estimate.covariance @ upper.T)[-1])))


def _settled(estimate: Estimator, upper: Vector, gains: Gains) -> int:
    errors = (np.eye(len(upper)) - estimate.L @ estimate.seen) @ estimate.advance
    step = np.linalg.solve(upper.T, (upper @ errors).T).T
    left = np.eye(len(step))
    for calls in range(LONGEST):
        if np.linalg.norm(left, 2) <= FORGOTTEN:
            return calls
        left = step @ left
        if not np.all(np.isfinite(left)):
            break
    raise ControlError(
        "observer", list(gains.s), f"does not forget its first error within {LONGEST} calls: its slowest pole is {estimate.poles[0].real:.2g} 1/s",
        "let the disturbance be larger, or measure more",
    )  # fmt: skip


def _demand_told(laws: Sequence[OutputFeedback], every: Sequence[Gains], compared: tuple[int, ...]) -> None:
    """Each equilibrium must be measured to be another one."""
    offsets = np.array([[law.offsets[k] for k in compared] for law in laws]).reshape(len(laws), -1)
    for i in range(len(laws)):
        away = less_turns(offsets[i + 1 :] - offsets[i], [laws[0].wraps[k] for k in compared])
        same = np.flatnonzero(np.sum(away**2, axis=-1) < _APART)
        if len(same):
            raise ControlError(
                "measured", list(laws[0].measured_names), f"do not tell {list(every[i].s)} from {list(every[i + 1 + int(same[0])].s)}",
                "measure the angles of more links, or make tables of equilibria that differ in what is measured",
            )  # fmt: skip
