"""Brake orbits by shooting over a quarter period: theta(0) = theta_0 at rest, theta(T/4) = 0.

The hanging chain is symmetric under theta -> -theta and under reversal of time, so a motion that starts at rest and hangs straight
after a quarter period is periodic: theta(t + T/2) = -theta(t). One propagation of the variational equations beside it,

    dq(T/4) = A dq_0 + B dv_0,   dv(T/4) = C dq_0 + D dv_0,

gives the Jacobian of the residual and, in the canonical coordinates L^T q and L^(-1) p with M = L L^T at either end,

    a = L_1^T A L_0^-T,   b = L_1^T B L_0^-T,   c = L_1^T C L_0^-T,   d = L_1^T D L_0^-T

(dM = 0 where the chain hangs straight, and v_0 = 0), the stability of the orbit: the half map P = -M(T/2), reduced by the symmetries,
is R Q^-1 R Q with Q = [a b; c d] symplectic and R = diag(-1, 1), so that its upper left block is 2 d^T a - 1 and

    kappa = (mu + 1/mu) / 2 = eig(1 - 2 d^T a),   lambda = mu^2:

multipliers pair by construction. The flow itself has kappa = 1, its left vector dV(q_0), and is split off; a cart's free translation
is taken out by its momentum, which is zero.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from phichain.continuation import Evaluation, Point, Problem
from phichain.continuation.linear import are_finite, bordered, cholesky, eigenvalues, size, solve
from phichain.continuation.problem import LateExtra, Multipliers
from phichain.orbits.single_harmonic import energy_of_amplitude
from phichain.records import Held
from phichain.system import Parameters, System, Vector
from phichain.system.propagation import carrier

EPS = float(np.finfo(float).eps)
_TOLERANCE = 256 * EPS
"""That of the flow, which aims 2^8 below it in every step: at rounding."""
_STEPS = 20_000
"""Steps of a quarter period that are worth taking: where Newton asks for more it has gone astray."""


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


def quarter_problem(system: System, p: Parameters | None = None, *, omega: float, shape: Vector, tol: float = _TOLERANCE) -> Problem:
    """theta(T/4; q_0) = 0 as a continuation problem with unknowns (q_0, omega), T = 2 pi / omega.

    A cart starts where its centre of mass is above the place at which the chain hangs straight: x(T/4) = 0.

    Args:
        system: A planar, undamped system whose `propagate` carries derivatives along, with `mass_matrix`.
        p: Runtime parameters.
        omega: Frequency of the linear mode, rad/s: its size.
        shape: Shape of the mode (nq,); a cart counts in units of its share.
        tol: Tolerance of the flow.

    Raises:
        AbsentFunctionError: A function is missing.
    """
    flow, mass_of = system.function("propagate"), system.function("mass_matrix")
    parameters, carts, nq = system.parameters(p), system.cart_size, system.nq
    still = np.zeros(nq)
    identity = np.eye(2 * nq)
    _, at_rest = _inertia(np.asarray(mass_of(still, **parameters)), carts)
    end = _root(at_rest).T
    carry = carrier(flow, 2 * (nq - carts), tol, _STEPS, parameters)

    def evaluate(z: Vector) -> Evaluation:
        omega = float(z[-1])
        if not (omega > 0 and are_finite(z)):
            return _nothing(nq)
        quarter, start = np.pi / (2 * omega), z[:-1]

        def inertia() -> tuple[Vector, Vector]:
            return _inertia(np.asarray(mass_of(start, **parameters)), carts)

        columns = _columns(inertia()[0], nq) if carts else identity
        outcome, q, v, transition, steps = carry(start, still, quarter, columns)
        if outcome != "done":
            return _nothing(nq)
        jacobian = np.zeros((nq, nq + 1))
        jacobian[:carts, :carts] = 1.0
        jacobian[:, carts:nq] = transition[:nq, : nq - carts]
        jacobian[:, nq] = v * (-quarter / omega)

        def blocks() -> tuple[Multipliers, QuarterMap]:
            noise = np.abs(jacobian) @ np.abs(z) * (EPS * (1 + steps))
            found_map = quarter_map(transition, v[carts:], _root(inertia()[1]), end, carts, noise)
            return found_map.kappa(), found_map

        return Evaluation(q, jacobian, LateExtra(blocks))

    sizes = np.abs(np.concatenate([shape[:carts], np.ones(nq - carts), [omega]]))
    return Problem(
        evaluate=evaluate,
        names=(*(system.q_names or tuple(f"q_{k + 1}" for k in range(nq))), "omega"),
        scale=powers(np.where(sizes > 0, sizes, 1.0)),
        energy=energy_of_amplitude(system, p),
        error=frequency_error,
    )


def powers(sizes: Vector) -> Vector:
    """The nearest powers of two: dividing by them and multiplying again loses nothing."""
    return np.exp2(np.round(np.log2(sizes)))


def _nothing(nq: int) -> Evaluation:
    """What is known where the chain cannot be followed."""
    return Evaluation(np.full(nq, np.nan), np.full((nq, nq + 1), np.nan))


def _inertia(mass: Vector, carts: int) -> tuple[Vector, Vector]:
    """dx' / d theta' (carts, N) at no momentum, and the inertia matrix (N, N) that is left for the angles."""
    if not carts:
        return np.empty((0, len(mass))), mass
    share = -mass[:1, 1:] / mass[0, 0]
    return share, mass[1:, 1:] + mass[1:, :1] @ share


def _root(inertia: Vector) -> Vector:
    """L with M = L L^T."""
    return cholesky(inertia)


def _columns(share: Vector, nq: int) -> Vector:
    """Derivatives (2 nq, 2 N) of the start by the angles and by their rates, the cart's momentum staying zero."""
    carts, links = share.shape
    columns = np.zeros((2 * nq, 2 * links))
    columns[carts:nq, :links] = columns[nq + carts :, links:] = np.eye(links)
    columns[nq : nq + carts, links:] = share
    return columns


def quarter_map(transition: Vector, rate: Vector, root: Vector, end: Vector, carts: int, noise: Vector) -> QuarterMap:
    """The map in canonical coordinates.

    Args:
        transition: Derivatives of (q, v) at T/4 by the angles and rates at the start (2 nq, 2 N).
        rate: Rates of the angles at T/4 (N,).
        root: L_0 of the start's inertia (N, N).
        end: L_1^T of the straight chain's (N, N).
        carts: Coordinates of the cart at the head of q and of v.
        noise: What rounding may have left in q(T/4) (nq,).
    """
    nq, links = len(transition) // 2, len(rate)
    # Rows of angles and of rates, each by columns of angles and of rates.
    both = (end @ transition.reshape(2, nq, 2 * links)[:, carts:]).reshape(4 * links, links)
    (a, b), (c, d) = solve(root, both.T).T.reshape(2, links, 2, links).swapaxes(1, 2)
    moving = end @ rate
    force = c.T @ moving
    return QuarterMap.made(
        a=a, b=b, c=c, d=d, rate=_unit(moving), force=_unit(force), slope=root @ force, noise=noise
    )  # fmt: skip


def _unit(vector: Vector) -> Vector:
    length = size(vector)
    return vector / length if length > 0 else vector


def frequency_error(point: Point) -> float:
    """How far off omega may be, relative: what rounding left in the residual, through [J; t]^-1.

    Beside a branch point this grows with the inverse of the distance, as the error does; at one nothing is known, NaN.
    """
    axis = np.zeros(len(point.y))
    axis[-1] = 1.0
    try:
        row = solve(bordered(point.jacobian, point.tangent).T, axis)
    except np.linalg.LinAlgError:
        return float("nan")
    noise: Any = point.extra.found.noise
    return float(np.abs(row[:-1]) @ noise / abs(point.y[-1]))
