"""The books of a run: E(t) - E(0) - work + loss is zero, and what it is instead tells how well the motion was integrated.

Work is what the inputs do on the chain, loss what dampers take from it: integrals of powers along the motion. Within a step the
state is as the method interpolates it; the powers at Gauss's points of the step, taken as a polynomial through them, give the
integrals from the step's start to anywhere within, exact for polynomials of twice that degree at its end.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.polynomial import legendre

from phichain.motion.inputs.piece import Control
from phichain.system import Parameters, System, Vector
from phichain.system.power import is_lossy, powers

#: Points in a step of an emitted flow: its series converge to seven times as far as the step goes, and this many leave 1e-17.
MANY: Final = 12
#: Points in a step of other methods, whose interpolants are of order 8 at most.
FEW: Final = 7
#: Points that are kept before their powers are computed, all at once.
BLOCK: Final = 4096


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


class Account:
    """Work and loss along one run, booked step by step."""

    def __init__(self, system: System, p: Parameters | None) -> None:
        """Open the books of a chain."""
        self.system, self.p = system, p
        self._waiting: list[tuple[Vector, Vector, Vector, Vector]] = []
        self._points = 0
        self._starts: list[Vector] = []
        self._widths: list[Vector] = []
        self._integrals: list[Vector] = []

    def points(self, start: float, stop: float, count: int) -> Vector:
        """Times (count,) within a step at which `book` wants the states."""
        times: Vector = start + (stop - start) * RULES[count].fractions
        return times

    def book(self, start: float, stop: float, times: Vector, states: Vector, control: Control | Vector) -> None:
        """Enter one step.

        Args:
            start: Its start, s.
            stop: Its end, s.
            times: The points of it (count,), s.
            states: The states there (count, nx).
            control: The input during the step: one vector, or u(t, x).
        """
        if callable(control):
            u = np.array([control(float(t), x) for t, x in zip(times, states, strict=True)]).reshape(len(times), -1)
        else:
            u = np.broadcast_to(control, (len(times), self.system.nu))
        self._waiting.append((np.array([start, stop]), times, states, u))
        self._points += len(times)
        if self._points >= BLOCK:
            self._settle()

    def at(self, t: Vector) -> tuple[Vector, Vector]:
        """Work and loss (m,) from the start to times within the run, J."""
        self._settle()
        if not self._starts:
            return np.zeros(len(t)), np.zeros(len(t))
        starts, widths = np.concatenate(self._starts), np.concatenate(self._widths)
        way = 1.0 if widths[0] >= 0 else -1.0
        step = np.clip(np.searchsorted(way * starts, way * t, side="right") - 1, 0, len(starts) - 1)
        inside = np.clip(2 * (t - starts[step]) / widths[step] - 1, -1.0, 1.0)
        integrals = np.concatenate(self._integrals)
        whole = np.cumsum(integrals.sum(axis=1), axis=0)
        before = np.concatenate([np.zeros((1, 2)), whole[:-1]])
        part = np.einsum("mj,mjk->mk", legendre.legvander(inside, MANY), integrals[step])
        part[inside == -1.0] = 0.0  # which a sum over the series is to round-off alone
        work, loss = (before[step] + part).T
        return work, loss

    def _settle(self) -> None:
        """Compute the powers of what waits, and integrate them step by step."""
        if not self._waiting:
            return
        spans, times, states, inputs = zip(*self._waiting, strict=True)
        with np.errstate(all="ignore"):  # a run that leaves the finite numbers is told elsewhere
            flow = powers(self.system, np.concatenate(states), np.concatenate(inputs), self.p)
        both, at = np.stack([flow.work, flow.loss], axis=-1), 0
        integrals = np.zeros((len(spans), MANY + 1, 2))
        for k, (span, points) in enumerate(zip(spans, times, strict=True)):
            count = len(points)
            integrals[k, : count + 1] = (span[1] - span[0]) * (RULES[count].integral @ both[at : at + count])
            at += count
        ends = np.array(spans)
        self._starts.append(ends[:, 0])
        self._widths.append(ends[:, 1] - ends[:, 0])
        self._integrals.append(integrals)
        self._waiting, self._points = [], 0


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

