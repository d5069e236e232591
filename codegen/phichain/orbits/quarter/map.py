"""The quarter map of a brake orbit in canonical coordinates: what its stability is read off."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from phichain.continuation.linear import eigenvalues, size, solve
from phichain.continuation.problem import Multipliers
from phichain.records import Held
from phichain.system import Vector


@dataclass(frozen=True, eq=False)
class QuarterMap(Held):
    """The variational equations over a quarter period, in canonical coordinates of the N angles.

    Attributes:
        a: d theta(T/4) / d theta_0 (N, N).
        b: d theta(T/4) / d p_0 (N, N).
        c: d p(T/4) / d theta_0 (N, N).
        d: d p(T/4) / d p_0 (N, N).
        rate: Unit vector along the rates at T/4 (N,): the left null vector of d.
        force: Unit vector along dV at q_0 (N,): the right null vector of d.
        slope: dV / d theta at theta_0 (N,), J, in the scene's angles.
        noise: What rounding may have left in q(T/4) (nq,).
    """

    a: Vector
    b: Vector
    c: Vector
    d: Vector
    rate: Vector
    force: Vector
    slope: Vector
    noise: Vector

    def test(self, name: str, of: Callable[[QuarterMap], float]) -> float:
        """A test function of the map, by its name."""
        return of(self)

    def kappa(self) -> np.ndarray:
        """The N - 1 numbers (mu + 1/mu) / 2 besides the flow's own, the largest real part first."""
        if len(self.force) == 1:
            return np.empty(0, complex)
        across = complement(self.force)
        return ordered(1 - 2 * eigenvalues((self.d @ across).T @ (self.a @ across)))


def complement(unit: Vector) -> Vector:
    """Orthonormal columns (N, N - 1) across a unit vector, real or complex: a reflection that turns it into an axis, without that axis."""
    if len(unit) == 2:
        return np.array([[-unit[1]], [unit[0]]]).conj()
    largest = int(np.abs(unit).argmax())
    normal = unit.copy()
    normal[largest] += unit[largest] / abs(unit[largest])
    others = [k for k in range(len(unit)) if k != largest]
    columns = normal[:, None] * (normal[others].conj() * (-2 / (normal.conj() @ normal)))
    columns[others, range(len(others))] += 1.0
    return columns


def ordered(kappa: Multipliers) -> Multipliers:
    """The largest real part first."""
    return kappa if len(kappa) == 1 else kappa[np.lexsort((kappa.imag, -kappa.real))]


def quarter_map(transition: Vector, rate: Vector, root: Vector, end: Vector, noise: Vector) -> QuarterMap:
    """The map in canonical coordinates.

    Args:
        transition: Derivatives of (q, v) at T/4 by the angles and rates at the start (2 N, 2 N).
        rate: Rates of the angles at T/4 (N,).
        root: L_0 of the start's inertia (N, N).
        end: L_1^T of the straight chain's (N, N).
        noise: What rounding may have left in q(T/4) (nq,).
    """
    links = len(rate)
    # Rows of angles and of rates, each by columns of angles and of rates.
    both = (end @ transition.reshape(2, links, 2 * links)).reshape(4 * links, links)
    (a, b), (c, d) = solve(root, both.T).T.reshape(2, links, 2, links).swapaxes(1, 2)
    moving = end @ rate
    force = c.T @ moving
    return QuarterMap.made(
        a=a, b=b, c=c, d=d, rate=_unit(moving), force=_unit(force), slope=root @ force, noise=noise
    )  # fmt: skip


def _unit(vector: Vector) -> Vector:
    length = size(vector)
    return vector / length if length > 0 else vector
