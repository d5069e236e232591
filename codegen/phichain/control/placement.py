"""Pole placement: gains that give the closed loop the poles that are asked for, and gains from elsewhere as a record.

One input leaves no choice: with the controllability matrix C and the wanted characteristic polynomial p, K = e_n^T C^-1 p(A)
(Ackermann 1972). C of an upright chain is singular to a double, so this is computed in many digits. Several inputs leave a choice,
and the method of Tits and Yang in SciPy takes that with the least sensitive poles. Either way the poles that the rounded gains
really give are compared with those asked for.

Sources: J. Ackermann, Der Entwurf linearer Regelungssysteme im Zustandsraum, Regelungstechnik 20 (1972) 297-300; A. L. Tits,
Y. Yang, Globally convergent algorithms for robust pole assignment by state feedback, IEEE Trans. Automat. Control 41 (1996)
1432-1452.
"""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Sequence
from functools import partial
from typing import Final

import numpy as np
from mpmath import mp
from numpy.typing import ArrayLike
from scipy.linalg import solve_continuous_lyapunov, solve_discrete_lyapunov
from scipy.optimize import linear_sum_assignment
from scipy.signal import place_poles

from phichain.control.controllability import alternatives, demand_input, margins_of
from phichain.control.equations.blocks import Block, blocks, part
from phichain.control.equations.riccati import Riccati
from phichain.control.equations.sampled import demand_sample, held
from phichain.control.equilibria import demand_equilibria
from phichain.control.gains import Gains
from phichain.control.record import record
from phichain.control.weights import Spectrum, ordered, spectrum
from phichain.errors import ControlError
from phichain.system import Parameters, System, Vector
from phichain.system.arrays import real_numbers

PLACED: Final = 1e-3
"""A pole that is off by more than this share of its size is not where it was asked for."""

_DIGITS: Final = 120


def place(
    system: System,
    s: Sequence[int] | None,
    poles: ArrayLike,
    *,
    sample: float | None = None,
    p: Parameters | None = None,
) -> Gains:
    """The regulator of a vertical equilibrium whose closed loop has given poles.

    Args:
        system: As for `lqr`.
        s: The target: +1 hanging, -1 upright, per link; every link upright unless given.
        poles: 2m of them, 1/s, in the open left half plane, complex ones with their conjugates; of a chain in space m for either
            of its vertical planes are enough.
        sample: Time between two samples, s: the closed loop's eigenvalues are then exp(pole * sample); None for continuous time.
        p: Runtime parameters by name.

    Returns:
        The Gains, with the poles that they really give, and with S of the cost that Q = 1 and R = 1 would put on their motion.

    Raises:
        ControlError: The target is no equilibrium or uncontrollable; the poles are not as many, not stable or not in pairs; or
            gains in double precision cannot place them (says which is off, and by how much).
        AbsentFunctionError: The system has no `linearization`.
    """
    linear = demand_equilibria(system, [[-1] * system.links if s is None else s], p)[0]
    demand_input(linear)
    margins = margins_of(linear).demand(linear.s, partial(alternatives, system, linear.s, p))
    A, B = linear.first_order
    if sample is not None:
        demand_sample(A, sample)
        A, B = (matrix.high for matrix in held(A, B, float(sample)))
    K, achieved = placed(A, B, poles, sample)
    return record(system, linear, margins, _identity(A, B), _solution(A, B, K, achieved, sample), sample, p=p)


def placed(A: Vector, B: Vector, poles: ArrayLike, sample: float | None) -> tuple[Vector, Spectrum]:
    """Gains of a linear system, and the eigenvalues that they really give.

    Args:
        A: Dynamics (n, n), from sample to sample where there is one.
        B: Input (n, nu).
        poles: The poles, 1/s.
        sample: Time between two samples, s; None for continuous time.

    Raises:
        ControlError: As `place`.
    """
    wanted = _wanted(poles)
    K, asked, parts = _gains(A, B, wanted if sample is None else np.exp(wanted * sample))
    achieved = _matched(_eigenvalues(A - B @ K, parts), asked)
    _demand_placed(achieved, asked, sample)
    return K, achieved


def with_gains(
    system: System, s: Sequence[int] | None, K: ArrayLike, *, sample: float | None = None, p: Parameters | None = None
) -> Gains:
    """Gains from elsewhere, python-control or a data sheet, as a record: u = -K z in the order of `linearize(system, s).state_names`.

    Args:
        system: As for `lqr`.
        s: The target; every link upright unless given.
        K: Gains (nu, 2m).
        sample: Time between two samples, s, that they were made for; None for continuous time.
        p: Runtime parameters by name.

    Raises:
        ControlError: The target is no equilibrium, K has another shape or is not finite, or the closed loop is not stable.
        AbsentFunctionError: The system has no `linearization`.
    """
    linear = demand_equilibria(system, [[-1] * system.links if s is None else s], p)[0]
    demand_input(linear)
    A, B = linear.first_order
    given = np.atleast_2d(real_numbers("K", K, "give the gains of every input, row by row"))
    if given.shape != B.T.shape or not np.all(np.isfinite(given)):
        raise ControlError("K", given.shape, f"must hold finite numbers of shape {B.T.shape}", "give one for each input and state")
    if sample is not None:
        demand_sample(A, sample)
        A, B = (matrix.high for matrix in held(A, B, float(sample)))
    values = spectrum(A - B @ given)
    largest = float(np.max(values.real if sample is None else np.abs(values)))
    if not largest < (0 if sample is None else 1):
        raise ControlError("K", given, f"leads to a closed loop that is not stable: an eigenvalue at {largest:.6g}", "check its order and signs")
    return record(system, linear, margins_of(linear), _identity(A, B), _solution(A, B, given, values, sample), sample, p=p)


def _identity(A: Vector, B: Vector) -> tuple[Vector, Vector]:
    return np.eye(len(A)), np.eye(B.shape[1])


def _wanted(poles: ArrayLike) -> Spectrum:
    try:
        given = np.atleast_1d(np.asarray(poles, dtype=complex)).ravel()
    except (TypeError, ValueError):
        raise ControlError("poles", poles, "holds something that is no number", "write them like -2, -3, -4+1j, -4-1j") from None
    if not np.all(np.isfinite(given)) or not np.all(given.real < 0):
        raise ControlError("poles", given.tolist(), "are not all in the open left half plane", "give negative real parts")
    if Counter(given.tolist()) != Counter(given.conj().tolist()):
        raise ControlError("poles", given.tolist(), "hold a complex one without its conjugate", "give both of each pair")
    return given


def _gains(A: Vector, B: Vector, wanted: Spectrum) -> tuple[Vector, Spectrum, tuple[Block, ...]]:
    """K (nu, n), the poles of the whole closed loop that it is to have, and its parts that do not mix."""
    n, nu = B.shape
    parts = blocks((A[None],), B[None])[0][1]
    single = all(len(block.inputs) == 1 for block in parts)
    sizes = [len(block.states) for block in parts]
    shared = single and len(wanted) < n and all(size == len(wanted) for size in sizes)
    if len(wanted) != n and not shared:
        fewer = f", or {sizes[0]} for each of {len(parts)} planes" if len(parts) > 1 else ""
        raise ControlError("poles", len(wanted), f"are not as many as states: {n}{fewer}", f"give {n}")
    dealt = [wanted] * len(parts) if shared else _dealt(wanted, sizes)
    if not single or dealt is None:
        # Gains of the whole mix its parts.
        return _several(A, B, wanted), wanted, ()
    K = np.zeros((nu, n))
    for block, own in zip(parts, dealt, strict=True):
        inner, drive = part(A, block.states, block.states), part(B, block.states, block.inputs)
        K[np.ix_(block.inputs, block.states)] = _ackermann(inner, drive, own)
    return K, np.concatenate(dealt), parts


def _dealt(wanted: Spectrum, sizes: Sequence[int]) -> list[Spectrum] | None:
    """The poles dealt out to the parts by rising size, conjugates together; None where pairs do not come out even."""
    hands: list[list[complex]] = [[] for _ in sizes]
    for pole in sorted((p for p in wanted.tolist() if p.imag >= 0), key=lambda p: (abs(p), p.imag)):
        given = [pole, pole.conjugate()] if pole.imag else [pole]
        open_hands = [k for k, size in enumerate(sizes) if len(hands[k]) + len(given) <= size]
        if not open_hands:
            return None
        hands[min(open_hands, key=lambda k: len(hands[k]))] += given
    return [np.array(hand) for hand in hands]


def _ackermann(A: Vector, B: Vector, wanted: Spectrum) -> Vector:
    n = len(A)
    with mp.workdps(_DIGITS):
        a, column = mp.matrix(A.tolist()), mp.matrix(B[:, 0].tolist())
        reach = mp.zeros(n, n)
        for k in range(n):
            for i in range(n):
                reach[k, i] = column[i]
            column = a * column
        last = mp.zeros(n, 1)
        last[n - 1] = 1
        row = mp.lu_solve(reach, last).T
        for pole in wanted:
            row = row * a - mp.mpc(complex(pole)) * row
        return np.array([[float(mp.re(row[0, i])) for i in range(n)]])


def _several(A: Vector, B: Vector, wanted: Spectrum) -> Vector:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return np.asarray(place_poles(A, B, wanted).gain_matrix, dtype=float)
    except ValueError as failure:
        raise ControlError("poles", wanted.tolist(), f"cannot be placed: {failure}", "repeat none more often than there are inputs") from None


def _eigenvalues(closed: Vector, parts: Sequence[Block]) -> Spectrum:
    """Eigenvalues of gains that are given, whatever the closed loop's conditioning: in many digits."""
    each = [part(closed, block.states, block.states) for block in parts] or [closed]
    return np.concatenate([_precise_eigenvalues(one) for one in each])


def _precise_eigenvalues(matrix: Vector) -> Spectrum:
    with mp.workdps(2 * len(matrix) + 30):
        found = mp.eig(mp.matrix(matrix.tolist()), left=False, right=False)
        return np.array([complex(mp.chop(value, tol=mp.mpf(10) ** -20)) for value in found])


def _matched(achieved: Spectrum, asked: Spectrum) -> Spectrum:
    """Achieved poles in the order of those asked for, so that their distances are least."""
    rows, columns = linear_sum_assignment(np.abs(asked[:, None] - achieved[None]))
    return achieved[columns[np.argsort(rows)]]


def _demand_placed(achieved: Spectrum, asked: Spectrum, sample: float | None) -> None:
    size = np.abs(asked) if sample is None else np.maximum(np.abs(np.log(asked)), 1e-300)
    off = np.abs(achieved - asked) if sample is None else np.abs(np.log(achieved / asked))
    share = off / size
    worst = int(np.argmax(share))
    stable = bool(np.all(achieved.real < 0) if sample is None else np.all(np.abs(achieved) < 1))
    if share[worst] > PLACED or not stable:
        wanted, got = ((value if sample is None else np.log(value) / sample) for value in (asked[worst], achieved[worst]))
        raise ControlError(
            "poles", complex(np.round(wanted, 12)), f"cannot be placed by gains in double precision: {got:.6g} is what they give, {share[worst]:.2g} off",
            "spread the poles, or weigh the states with lqr instead", off=float(share[worst]),
        )  # fmt: skip


def _solution(A: Vector, B: Vector, K: Vector, values: Spectrum, sample: float | None) -> Riccati:
    """The record's solution: S of the Lyapunov equation with Q = R = 1, and its residual."""
    closed, cost = A - B @ K, np.eye(len(A)) + K.T @ K
    if sample is None:
        S = solve_continuous_lyapunov(closed.T, -cost)
        residual, poles = closed.T @ S + S @ closed + cost, values
        terms = max(float(np.max(np.abs(closed.T @ S))), float(np.max(np.abs(cost))))
    else:
        S = solve_discrete_lyapunov(closed.T, cost)
        residual, poles = closed.T @ S @ closed - S + cost, np.log(values.astype(complex)) / sample
        terms = float(np.max(np.abs(S)))
    S = (S + S.T) / 2
    return Riccati(S, K, ordered(poles.astype(complex)), float(np.max(np.abs(residual))) / terms, 0, 0.0)
