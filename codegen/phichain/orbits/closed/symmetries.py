"""Which symmetries an orbit has, found by following it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np

from phichain.orbits.closed.states import field
from phichain.orbits.periodic import least_potential
from phichain.orbits.quarter import EPS
from phichain.system import Parameters, System, Vector, acceleration

_CLOSE: Final = 1e-5
"""Distance, in sizes of the orbit, below which two of its states are one, and a least speed is a rest."""
RANK: Final = {"whole": 0, "half": 1, "odd": 1, "unequal": 1, "quarter": 2}
"""How many symmetries each kind has."""
_MOST: Final = 99
"""Traversals that are looked for."""
_SAMPLES: Final = 240
_ALIKE: Final = 0.1
"""Samples of dips, in the largest size, that one and the same depth may have."""
_ROUNDS: Final = 4


class Motion:
    """An orbit by its start, looked at over its period.

    Attributes:
        period: T, s.
    """

    def __init__(self, system: System, p: Parameters | None, q: Vector, v: Vector, omega: float) -> None:
        """Keep it; nothing is computed."""
        self._system, self._parameters = system, system.parameters(p)
        self._start = np.asarray(q, float), np.asarray(v, float)
        self.period = 2 * np.pi / omega

    def at(self, times: Vector) -> tuple[Vector, Vector]:
        """q (m, nq) and v (m, nq) at rising times, s, from 0 to T."""
        inner = np.clip(times, 0.0, self.period)
        found = self._system.propagate(
            *self._start, 0.0, max(float(inner[-1]), EPS), EPS, times=inner, max_steps=100_000, **self._parameters
        )
        return found.q_at, found.v_at

    def least(self, size: Callable[[Vector, Vector], Vector]) -> tuple[float, float]:
        """When a size (m,) of states (m, nq), (m, nq) is least over the period, and what it is there in the
        largest on the way."""
        times = np.linspace(0.0, self.period, _SAMPLES)
        values = size(*self.at(times))
        largest = float(np.max(values))
        beside = np.minimum(np.append(values[1:], np.inf), np.append(np.inf, values[:-1]))
        # Dips beside a cover are as good as alike: which is the least its samples do not tell.
        dips = np.flatnonzero((values <= beside) & (values < values.min() + _ALIKE * largest))
        return min((self._dip(size, times, int(k), largest) for k in dips), key=lambda found: found[1])

    def _dip(self, size: Callable[[Vector, Vector], Vector], times: Vector, k: int, largest: float) -> tuple[float, float]:
        """The least of a size beside one of its samples: when, and what it is in the largest."""
        for _ in range(_ROUNDS):
            times = np.linspace(times[max(k - 1, 0)], times[min(k + 1, len(times) - 1)], 24)
            values = size(*self.at(times))
            k = int(np.argmin(values))
        return float(times[k]), float(values[k]) / largest

    def comes_back(self, sign: float) -> bool:
        """Whether theta(T/2) = sign theta(0), rates too: mirrored for -1, over already for 1."""
        return bool(self._misses(np.array([self.period / 2]), sign)[0] < _CLOSE)

    def traversals(self) -> int:
        """How often it runs through a shorter orbit; 1 where it does not."""
        counts = np.arange(_MOST, 1, -1)
        back = counts[self._misses(self.period / counts, 1.0) < _CLOSE]
        return int(back[0]) if back.size else 1

    def _misses(self, times: Vector, sign: float) -> Vector:
        """How far the states at some times are from the start, or from its mirror image, in its size (m,)."""
        omega = 2 * np.pi / self.period
        q, v = self.at(times)
        off = np.hstack([q - sign * self._start[0], (v - sign * self._start[1]) / omega])
        own = np.concatenate([self._start[0], self._start[1] / omega])
        return np.asarray(np.max(np.abs(off), axis=1) / np.max(np.abs(own)))


def angles(system: System) -> Callable[[Vector, Vector], Vector]:
    """The size of the angles: zero where the chain is straight."""
    return lambda q, v: np.linalg.norm(q[:, system.cart_size :], axis=1)


def rates(system: System) -> Callable[[Vector, Vector], Vector]:
    """The size of the rates: zero at a rest."""
    return lambda q, v: np.linalg.norm(v[:, system.cart_size :], axis=1)


def recognised(system: System, p: Parameters | None, q: Vector, v: Vector, omega: float) -> tuple[str, int]:
    """The kind that an orbit belongs to by its symmetries, and how often it runs through a shorter orbit,
    which has them."""
    times = Motion(system, p, q, v, omega).traversals()
    motion = Motion(system, p, q, v, omega * times)
    mirrored = motion.comes_back(-1.0)
    if motion.least(rates(system))[1] < _CLOSE:
        return ("quarter" if mirrored else "unequal"), times
    if mirrored:
        return "half", times
    return ("odd" if motion.least(angles(system))[1] < _CLOSE else "whole"), times


def gains(kind: str, found: tuple[str, int]) -> bool:
    """Whether an orbit that families of a kind have come to is one at which they turn into their own mirror
    image: it has more symmetries, or is over twice."""
    return RANK[found[0]] > RANK[kind] or found[1] % 2 == 0


def taken_up(system: System, p: Parameters | None, kind: str, q: Vector, v: Vector, omega: float) -> tuple[Vector, Vector]:
    """The state of an orbit from which its kind takes it up: a rest, the straight chain, or the least
    potential.

    Args:
        system: The chain.
        p: Runtime parameters.
        kind: The kind of orbits.
        q: A state of the orbit (nq,).
        v: Its rates (nq,).
        omega: Frequency, rad/s.
    """
    motion = Motion(system, p, q, v, omega)
    still = np.zeros(system.nq)
    if kind in ("quarter", "unequal"):
        return _settled(system, p, motion, rates(system), lambda x: (x[1], acceleration(system, *x, None, p)))[0], still
    if kind == "odd":
        return still, _settled(system, p, motion, angles(system), lambda x: (x[0], x[1]))[1]
    own, phase = system.function("energy"), least_potential(system, p)

    def potential(q: Vector, v: Vector) -> Vector:
        levels = [float(own(one, still, **system.parameters(p))[1]) for one in (still, *q)]
        return np.array(levels[1:]) - levels[0]

    def off(x: tuple[Vector, Vector]) -> tuple[Vector, Vector]:
        value, slope = phase(np.concatenate(x))
        return np.array([value]), np.array([slope @ field(system, p, *x)])

    return _settled(system, p, motion, potential, off)


def _settled(
    system: System,
    p: Parameters | None,
    motion: Motion,
    size: Callable[[Vector, Vector], Vector],
    off: Callable[[tuple[Vector, Vector]], tuple[Vector, Vector]],
) -> tuple[Vector, Vector]:
    """The state at which a size is least and what is to vanish there does, by Newton in the time; `off` gives
    it and its rate."""
    found = motion.at(np.array([motion.least(size)[0]]))
    state = found[0][0], found[1][0]
    for _ in range(_ROUNDS):
        left, rate = off(state)
        moved = system.propagate(*state, 0.0, -float(left @ rate) / float(rate @ rate), EPS, **system.parameters(p))
        state = moved.q, moved.v
    return state
