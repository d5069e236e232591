"""Stability of a driven periodic motion: its monodromy by Gauss's collocation along the series, and the events that multipliers tell.

Along q(tau) small deviations obey x' = A(t) x, A = [0 1; -M^-1 u_q, -M^-1 u_v], with u_q, u_v, M = u_a the emitted derivatives of the
inverse dynamics; four Gauss nodes a step (order 8), all steps at once. A motion with q(t + T/2) = -q(t) repeats after half a period:
with N = -Phi(T/2) the multipliers are lambda = nu^2, nu those of N, and det(N + 1) = 0 where the symmetry is lost.

    fold                one multiplier passes +1, omega turns              omega' = 0 along the branch
    symmetry breaking   one multiplier passes +1, its motion is unlike     det (N + 1) = 0
    period doubling     one multiplier passes -1                           det (Phi(T) + 1) = 0
    neimark-sacker      a pair passes the unit circle                      prod (nu_i nu_j - 1) = 0, the pair complex

A cart's place is nobody's matter, and one whose acceleration is given does not deviate: both are left out of x.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from phichain.continuation import BranchPoint, Fold, Point, Quantity, Special, TestFunction
from phichain.continuation.events import signed
from phichain.orbits.forced.forcing import Forcing
from phichain.orbits.harmonics.balance import inverse_of
from phichain.orbits.harmonics.basis import Basis
from phichain.records import Held
from phichain.system import Parameters, System, Vector
from phichain.system.power import is_lossy

_NODES: Final = 4
_FINE: Final = 3.0
"""Steps for a radian of the chain's own fastest swing."""


def _gauss() -> tuple[Vector, Vector, Vector]:
    """Nodes on (0, 1), weights, and the matrix of Gauss's collocation."""
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    places = (nodes + 1) / 2
    matrix = np.empty((_NODES, _NODES))
    for j in range(_NODES):
        others = np.delete(places, j)
        lagrange = np.polynomial.Polynomial.fromroots(others) / np.prod(places[j] - others)
        matrix[:, j] = lagrange.integ()(places)
    return places, weights / 2, matrix


_PLACES, _WEIGHTS, _MATRIX = _gauss()


@dataclass(frozen=True, eq=False)
class Linear(Held):
    """The linear map of deviations.

    Attributes:
        map: N = -Phi(T/2) where the motion is odd, Phi(T) elsewhere (k, k).
        is_half: Whether it is N.
    """

    map: Vector
    is_half: bool

    @cached_property
    def whole(self) -> Vector:
        """Phi(T) (k, k)."""
        return self.map @ self.map if self.is_half else self.map

    @cached_property
    def own(self) -> np.ndarray:
        """The eigenvalues of the map."""
        return np.linalg.eigvals(self.map).astype(complex)

    @cached_property
    def multipliers(self) -> np.ndarray:
        """Those of the whole period (k,), the largest first."""
        found = self.own**2 if self.is_half else self.own
        return np.asarray(found[np.lexsort((-found.imag, -found.real, -np.round(np.abs(found), 12)))], complex)


def deviating(system: System, forcing: Forcing) -> Vector:
    """Which entries of (q, v) deviate."""
    n, carts = system.nq, system.cart_size
    first = carts if forcing.told else 0
    return np.concatenate([np.arange(carts, n), n + np.arange(first, n)])


def linear_of_series(
    system: System, forcing: Forcing, basis: Basis, series: Vector, omega: float, p: Parameters | None
) -> Linear:
    """The map of a solution of the harmonic balance.

    Args:
        system: The chain.
        forcing: What drives it.
        basis: Functions of the phase.
        series: X (M, n).
        omega: rad/s.
        p: Runtime parameters.
    """
    is_half = basis.kind == "odd"
    span = np.pi if is_half else 2 * np.pi
    own = _rates(system, forcing, basis, series, omega, p, np.zeros(1))[0]
    swings = span * float(np.sqrt(np.max(np.abs(np.linalg.eigvals(own @ own))))) / omega
    steps = max((basis.highest + 1) * (1 if is_half else 2), int(np.ceil(_FINE * swings)))
    width = span / steps
    phase = (width * (np.arange(steps)[:, None] + _PLACES)).ravel()
    rates = _rates(system, forcing, basis, series, omega, p, phase)
    size = rates.shape[-1]
    maps = _collocated(rates.reshape(steps, _NODES, size, size), width / omega)
    whole = _product(maps)
    return Linear(-whole if is_half else whole, is_half)


def _rates(
    system: System, forcing: Forcing, basis: Basis, series: Vector, omega: float, p: Parameters | None, phase: Vector
) -> Vector:
    """A (K, k, k) at some phases."""
    value, slope, bend = basis.at(phase)
    q, v, a = value @ series, omega * (slope @ series), omega**2 * (bend @ series)
    function = inverse_of(system, p)
    if forcing.base.size:
        drive = forcing.amplitude * np.cos(phase)[:, None] * forcing.base
        _, by_q, by_v, by_a = system.function("inverse_and_jacobian")(q, v, a, drive, **system.parameters(p))
    else:
        _, by_q, by_v, by_a = function(q, v, a)
    first, carts, n = (system.cart_size if forcing.told else 0), system.cart_size, system.nq
    free = slice(first, n)
    inverse = np.linalg.inv(by_a[:, free, free])
    k, m = n - carts, n - first
    rates = np.zeros((len(phase), k + m, k + m))
    rates[:, :k, k + carts - first :] = np.eye(k)
    rates[:, k:, :k] = -inverse @ by_q[:, free, carts:]
    rates[:, k:, k:] = -inverse @ by_v[:, free, free]
    return rates


def _collocated(rates: Vector, width: float) -> Vector:
    """The maps (S, k, k) of all steps: K_i = A_i (x + h sum_j a_ij K_j)."""
    steps, nodes, size, _ = rates.shape
    system = np.eye(nodes * size) - width * (rates[:, :, :, None, :] * _MATRIX[:, None, :, None]).reshape(steps, nodes * size, nodes * size)
    stages = np.linalg.solve(system, rates.reshape(steps, nodes * size, size)).reshape(steps, nodes, size, size)
    return np.eye(size) + width * np.einsum("j,sjab->sab", _WEIGHTS, stages)


def _product(maps: Vector) -> Vector:
    """The last map times .. times the first, by halves."""
    while len(maps) > 1:
        rest = maps[-1:] if len(maps) % 2 else maps[:0]
        pairs = maps[: len(maps) - len(rest)]
        maps = np.concatenate([pairs[1::2] @ pairs[::2], rest])
    return np.asarray(maps[0])


SAID: Final[dict[str, tuple[str, str]]] = {
    "fold": ("no symmetry: the frequency turns, and one multiplier passes +1", "this branch"),
    "symmetry breaking": ("q(t + T/2) = -q(t)", "two motions that mirror each other, over the full period"),
    "branch point": ("no symmetry that is known: one multiplier passes +1", "another branch of the same period"),
    "period doubling": ("the period", "motions of twice the period"),
    "neimark-sacker": ("periodicity: a pair of multipliers passes the unit circle", "motions with a second frequency, which no method here follows"),
}
"""What every kind of event breaks, and what goes on beyond it."""


def _of(point: Point) -> Linear:
    found: Linear = point.extra.found
    return found


def plus_one(point: Point) -> float:
    """det (N + 1): a multiplier of the map passes -1."""
    linear = _of(point)
    return signed(linear.map + np.eye(len(linear.map)))


def on_circle(point: Point) -> float:
    """prod over pairs of (nu_i nu_j - 1), real."""
    own = _of(point).own
    rows, columns = np.triu_indices(len(own), 1)
    return float(np.prod(own[rows] * own[columns] - 1).real)


def tests_of(system: System, is_odd: bool) -> list[TestFunction]:
    """The test functions of a frequency response."""
    lost = Quantity(plus_one, "symmetry breaking") if is_odd else Quantity(plus_one, "period doubling")
    return [Fold(name="fold"), BranchPoint(), lost, *circle_of(system)]


def circle_of(system: System) -> list[TestFunction]:
    """Where a pair leaves the unit circle; without losses every multiplier has its inverse, and all pairs are on it all along."""
    return [Quantity(on_circle, "neimark-sacker")] if is_lossy(system) else []


def genuine(event: Special) -> bool:
    """False where the pair with product 1 is real: a saddle that is neutral, and no torus."""
    if event.kind != "neimark-sacker":
        return True
    found = event.multipliers
    rows, columns = np.triu_indices(len(found), 1)
    nearest = int(np.argmin(np.abs(found[rows] * found[columns] - 1)))
    return bool(abs(found[rows[nearest]].imag) > 1e-9)
