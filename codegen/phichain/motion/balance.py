"""The books of a run: E(t) - E(0) - work + loss is zero, and what it is instead tells how well the motion was integrated.

Work is what the inputs do on the chain, loss what dampers take from it: integrals of powers along the motion. Within a step the
state is as the method interpolates it; the powers at Gauss's points of the step, taken as a polynomial through them, give the
integrals from the step's start to anywhere within, exact for polynomials of twice that degree at its end.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import groupby
from typing import Final

import numpy as np
from numpy.polynomial import legendre

from phichain.motion.inputs.piece import Control
from phichain.records import Held
from phichain.system import Parameters, System, Vector
from phichain.system.power import is_lossy, powers

#: Points in a step of the Taylor flow: its series converge to seven times as far as the step goes, and this many leave 1e-17.
MANY: Final = 12
#: Points in a step of other methods, whose interpolants are of order 8 at most.
FEW: Final = 5
#: Points that wait at most before their powers are computed.
MOST_WAITING: Final = 8192


class _Rule:
    """Gauss's points of a step, and the integral of the polynomial through them."""

    def __init__(self, count: int) -> None:
        """Tabulate for a number of points."""
        points, weights = legendre.leggauss(count)
        self.fractions = (1 + points) / 2
        scaled = (2 * np.arange(count)[:, None] + 1) / 2 * legendre.legvander(points, count - 1).T * weights
        #: From values at the points to the Legendre coefficients of half the integral from -1.
        self.integral = legendre.legint(scaled, lbnd=-1, axis=0) / 2


RULES: Final = {count: _Rule(count) for count in (FEW, MANY)}


@dataclass(frozen=True, eq=False)
class _Block(Held):
    """Steps that were booked together: their ends (k + 1,), and states and inputs at `count` points of each."""

    knots: Vector
    count: int
    states: Vector
    inputs: Vector


class Account:
    """Work and loss along one run, booked step by step."""

    def __init__(self, system: System, p: Parameters | None) -> None:
        """Open the books of a chain."""
        self.system, self.p = system, p
        self._owed: list[Callable[[], None]] = []
        self._waiting: list[_Block] = []
        self._points = 0
        self._starts: list[Vector] = []
        self._widths: list[Vector] = []
        self._integrals: list[Vector] = []

    def owe(self, entries: Callable[[], None]) -> None:
        """Have entries made when somebody reads the books."""
        self._owed.append(entries)

    def points(self, knots: Vector, count: int) -> Vector:
        """Times (k count,) within the k steps between knots at which `book` wants the states."""
        times: Vector = (knots[:-1, None] + np.diff(knots)[:, None] * RULES[count].fractions).ravel()
        return times

    def book(self, knots: Vector, count: int, states: Vector, control: Control | Vector) -> None:
        """Enter steps that follow one another.

        Args:
            knots: Where they begin and end (k + 1,), s.
            count: Points in each.
            states: The states at `points` (k count, nx).
            control: The input meanwhile: one vector, or u(t, x).
        """
        if callable(control):
            times = self.points(knots, count).tolist()
            u = np.array([control(t, x) for t, x in zip(times, states, strict=True)]).reshape(len(times), -1)
        else:
            u = np.broadcast_to(control, (len(states), self.system.nu))
        self._waiting.append(_Block(knots, count, states, u))
        self._points += len(states)
        if self._points >= MOST_WAITING:
            self._settle()

    def at(self, t: Vector) -> tuple[Vector, Vector]:
        """Work and loss (m,) from the start to times within the run, J."""
        while self._owed:
            self._owed.pop(0)()
        self._settle()
        if not self._starts:
            return np.zeros(len(t)), np.zeros(len(t))
        starts, widths, integrals = map(np.concatenate, (self._starts, self._widths, self._integrals))
        way = 1.0 if widths[0] >= 0 else -1.0
        step = np.clip(np.searchsorted(way * starts, way * t, side="right") - 1, 0, len(starts) - 1)
        # A step too short for the clock is over where it begins.
        part = np.divide(t - starts[step], widths[step], out=np.ones(len(t)), where=widths[step] != 0)
        inside = np.clip(2 * part - 1, -1.0, 1.0)
        whole = np.cumsum(integrals.sum(axis=1), axis=0)
        result = np.concatenate([np.zeros((1, 2)), whole])[step + (inside == 1.0)]
        within = np.flatnonzero(np.abs(inside) < 1)
        if within.size:
            result[within] += np.einsum("mj,mjk->mk", legendre.legvander(inside[within], MANY), integrals[step[within]])
        work, loss = result.T
        return work, loss

    def _settle(self) -> None:
        """Compute the powers of what waits, all at once, and integrate them step by step."""
        if not self._waiting:
            return
        waiting, self._waiting, self._points = self._waiting, [], 0
        with np.errstate(all="ignore"):  # a run that leaves the finite numbers is told elsewhere
            flow = powers(
                self.system, np.concatenate([block.states for block in waiting]),
                np.concatenate([block.inputs for block in waiting]), self.p,
            )  # fmt: skip
        both, at = np.stack([flow.work, flow.loss], axis=-1), 0
        for count, blocks in groupby(waiting, lambda block: block.count):
            spans = [(block.knots[:-1], np.diff(block.knots)) for block in blocks]
            starts, widths = (np.concatenate(part) for part in zip(*spans, strict=True))
            powers_of = both[at : at + count * len(starts)].reshape(-1, count, 2)
            at += count * len(starts)
            integrals = np.zeros((len(starts), MANY + 1, 2))
            integrals[:, : count + 1] = widths[:, None, None] * (RULES[count].integral @ powers_of)
            for known, more in ((self._starts, starts), (self._widths, widths), (self._integrals, integrals)):
                known.append(more)


def opened(system: System, p: Parameters | None, u: Vector | None, is_driven: bool) -> Account | None:
    """An account where work is done or lost and the system knows its energy, else None.

    Args:
        system: The chain.
        p: Runtime parameters by name.
        u: The input where it is constant.
        is_driven: Whether there are inputs.
    """
    works = is_driven and (u is None or bool(np.any(u)))
    if not system.has("energy") or not (works or is_lossy(system)):
        return None
    return Account(system, p)

