"""Linear quadratic regulators of a chain about its vertical equilibria, one or all of them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from phichain.control.accuracy import gains_error
from phichain.control.controllability import alternatives, demand_input, margins_of_all
from phichain.control.equations.riccati import Riccati, riccatis
from phichain.control.equations.sampled import sampled_riccatis
from phichain.control.equilibria import at_rest, demand_equilibria
from phichain.control.gains import Gains
from phichain.control.linear import LinearSystem
from phichain.control.record import record
from phichain.control.weights import weight
from phichain.system import Parameters, System, Vector, given_system

EXACT = 1e-12
"""Matrices that are less accurate than this make gains whose error is worth an estimate."""

STACK = 128
"""Equilibria solved at once: enough to amortise Python, few enough to stay in a cache."""


def lqr(
    system: System,
    s: Sequence[int] | None = None,
    Q: ArrayLike | None = None,
    R: ArrayLike | None = None,
    *,
    sample: float | None = None,
    p: Parameters | None = None,
) -> Gains:
    """The linear quadratic regulator of a chain about one vertical equilibrium.

    Minimises int (z^T Q z + u^T R u) dt along (19); with `sample` the sum of z_k^T Q z_k + u_k^T R u_k over samples, the input
    held between them, the way from one to the next exact.

    Args:
        system: A chain with inputs and a `linearization`; `forward_dynamics` is used, when there, to check that it
            rests at the target.
        s: The target: +1 hanging, -1 upright, per link; every link upright unless given.
        Q: Weight of z = (x, x'): None (identity), a number, 2m diagonal entries, or a matrix.
        R: Weight of u: likewise.
        sample: Time between two samples, s; None for a regulator in continuous time.
        p: Runtime parameters by name.

    Returns:
        The Gains; `feedback(system, gains)` makes the control law of them, `gains.law()` one that C can be made of.

    Raises:
        ControlError: The target is no equilibrium or uncontrollable (names the mode and its margin), weights are not
            positive, there is no input or no stabilising solution; `sample` is no positive time, or so long that the
            fastest unstable mode grows tenfold meanwhile.
        AbsentFunctionError: The system has no `linearization`.
    """
    target = [-1] * given_system(system).links if s is None else s
    return _stack(system, demand_equilibria(system, [target], p), Q, R, sample, p)[0]


def regulators(
    system: System,
    every: Iterable[Sequence[int]] | None = None,
    Q: ArrayLike | None = None,
    R: ArrayLike | None = None,
    *,
    sample: float | None = None,
    p: Parameters | None = None,
) -> tuple[Gains, ...]:
    """The regulators about several vertical equilibria, each to the same bits as `lqr` gives, in a third of its time.

    What is done to one matrix is done to a stack of them: linearisation, margins, doubling and Newton's steps.

    Args:
        system: As for `lqr`.
        every: The targets; all vertical equilibria at which the chain rests unless given, the hanging one first.
        Q: Weight of z = (x, x'), the same about each: as for `lqr`.
        R: Weight of u: likewise.
        sample: Time between two samples, s, as for `lqr`.
        p: Runtime parameters by name.

    Raises:
        UnsupportedError: All of more than 2^16 equilibria.
        ControlError: As `lqr`, about the first target that fails.
        AbsentFunctionError: The system has no `linearization`.
    """
    targets = list(at_rest(system, p) if every is None else every)
    found: list[Gains] = []
    for start in range(0, len(targets), STACK):
        found += _stack(system, demand_equilibria(system, targets[start : start + STACK], p), Q, R, sample, p)
    return tuple(found)


def _stack(
    system: System, linear: Sequence[LinearSystem], Q: ArrayLike | None, R: ArrayLike | None, sample: float | None,
    p: Parameters | None,
) -> list[Gains]:  # fmt: skip
    """The regulators of one stack."""
    nu = demand_input(linear[0])
    reach = [
        margins.demand(one.s, partial(alternatives, system, one.s, p)) for margins, one in zip(margins_of_all(linear), linear, strict=True)
    ]
    A, B = (np.array(matrices) for matrices in zip(*(one.first_order for one in linear), strict=True))
    weights = weight("Q", Q, A.shape[-1], strict=False), weight("R", R, nu, strict=True)
    solutions = _solved(A, B, *weights, sample)

    def error(one: LinearSystem, K: Vector) -> float:
        if one.noise <= EXACT:
            return 0.0
        return gains_error(one, K, lambda a, b: _solved(a[None], b[None], *weights, sample)[0].K)

    return [
        record(system, one, margins, weights, solution, sample, error(one, solution.K), p)
        for one, margins, solution in zip(linear, reach, solutions, strict=True)
    ]


def _solved(A: Vector, B: Vector, Q: Vector, R: Vector, sample: float | None) -> list[Riccati]:
    return riccatis(A, B, Q, R) if sample is None else sampled_riccatis(A, B, Q, R, sample)
