"""Relative equilibria as a continuation problem, on the emitted forward dynamics and their Jacobian.

With the notation of `turning`, x stands still in its frame where f(x) - Omega G x = 0. All but its parts c, across the plane,
vanish by symmetry: n equations in n + 1 unknowns ([X,] theta_1 .. theta_N, Omega),

    F = C^T (f(x) - Omega G x),   dF/dz = C^T ((df/dx - Omega G) dx/dz - dOmega/dz G x),

where dx/d theta_k = even_a - Omega cos theta_k even_d and dx/d Omega = G x as a change of rates. One link: F = -(g / l) sin theta
+ Omega^2 sin theta cos theta, the conical pendulum.

Stability: in the pairs x+ = (a, d) and x- = (b, c) small motions are x-' = C x+, x+' = B x-, so that the squares s^2 of the
characteristic exponents are the eigenvalues of C B, each once for both of +-s. B u = 0 for the turning u = G x itself, which
is split off: what is left belongs to small motions at the same angular momentum.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from phichain.continuation import Evaluation, Problem
from phichain.continuation.problem import LateExtra, Multipliers
from phichain.orbits.conical.turning import Turning, turning
from phichain.records import Held
from phichain.system import Parameters, System, Vector
from phichain.system.state import rhs, rhs_jacobian

_MOST = 700.0
"""Exponents beyond which their growth in a turn is no double any more."""


@dataclass(frozen=True, eq=False)
class Beside(Held):
    """Small motions beside a relative equilibrium, in the turning frame and at its angular momentum.

    Attributes:
        squares: s^2 of the characteristic exponents (k,), 1/s^2, the largest real part first; a cart's free motion as a whole is left out.
        reduced: C B without the turning (2 n - 1, 2 n - 1): singular where the angular momentum turns.
        across: What draws the links back into their plane, without the turning (n - 1, n - 1).
    """

    squares: Multipliers
    reduced: Vector
    across: Vector


def conical_problem(system: System, p: Parameters | None = None, *, omega: float) -> Problem:
    """Relative equilibria in one vertical plane, as a problem with unknowns ([X,] theta_1 .. theta_N, Omega).

    Its multipliers are kappa = (lambda + 1/lambda) / 2 = cosh(s T) of one turn T = 2 pi / Omega, as those of other orbits.

    Args:
        system: A spatial chain without losses, with `forward_dynamics`, `state_jacobian` and `energy`.
        p: Runtime parameters.
        omega: A typical rate, rad/s: its size.
    """
    field, slope = rhs(system), rhs_jacobian(system)
    on_cart = int(system.has_cart)

    def evaluate(z: Vector) -> Evaluation:
        size = len(z) - 1
        if not (float(z[-1]) > 0 and np.all(np.isfinite(z))):
            return Evaluation(np.full(size, np.nan), np.full((size, size + 1), np.nan))
        at, rate = turning(system, z), float(z[-1])
        count, across = at.count, at.odd[:, at.count :].T
        linear = np.asarray(slope(0.0, at.x, None, p)) - rate * at.about
        residual = across @ (np.asarray(field(0.0, at.x, None, p)) - rate * at.spun)
        turned = np.cos(z[on_cart:-1])
        by_rate = at.even[:, count:] @ np.append(z[:on_cart], -np.sin(z[on_cart:-1]))
        moved = at.even[:, :count] + at.even[:, count:] * np.append(np.full(on_cart, rate), -rate * turned)
        jacobian = across @ np.column_stack([linear @ moved, linear @ by_rate - at.spun])

        def found() -> tuple[Multipliers, Beside]:
            beside = _beside(at, linear, rate, on_cart)
            return kappa(beside.squares, rate), beside

        return Evaluation(residual, jacobian, LateExtra(found))

    return Problem(
        evaluate=evaluate,
        names=(*["x"] * on_cart, *(f"theta_{k + 1}" for k in range(system.links)), "omega"),
        scale=np.append(np.ones(system.links + on_cart), float(np.exp2(np.round(np.log2(omega))))),
        energy=_energy(system, p),
    )


def kappa(squares: Multipliers, rate: float) -> Multipliers:
    """cosh(s T), T = 2 pi / Omega, from s^2: real and between -1 and 1 where s is imaginary."""
    turns = np.sqrt(squares.astype(complex)) * (2 * np.pi / rate)
    return np.asarray(np.cosh(np.minimum(turns.real, _MOST) + 1j * turns.imag), complex)


def _beside(at: Turning, linear: Vector, rate: float, on_cart: int) -> Beside:
    even_rows, odd_rows, count = at.even_rows, at.odd.T, at.count
    forth, back = odd_rows @ linear @ at.even, even_rows @ linear @ at.odd
    rest = _complement(odd_rows @ at.spun)
    reduced = rest.T @ forth @ back @ rest
    squares = np.linalg.eigvals(reduced).astype(complex)
    # A cart and its chain can drift as one: seen from the turning frame that has s = +-i Omega, twice.
    squares = squares[np.argsort(np.abs(squares + rate**2))[2 * on_cart :]]
    # b' comes back from c and b, c' from both: without c, what is left pulls b back.
    (to_a_b, to_a_c), (to_d_b, to_d_c) = (np.hsplit(part, 2) for part in np.vsplit(back, 2))
    pull = to_d_b - to_d_c @ np.linalg.solve(to_a_c, to_a_b)
    side = _complement((odd_rows @ at.spun)[:count])
    return Beside(squares[np.lexsort((squares.imag, -squares.real))], reduced, side.T @ pull @ side)


def _complement(vector: Vector) -> Vector:
    """Orthonormal columns across a vector that is not zero."""
    q, _ = np.linalg.qr(vector[:, None], mode="complete")
    return np.asarray(q[:, 1:])


def _energy(system: System, p: Parameters | None) -> Callable[[Vector], float]:
    """z -> T + V, J, counted from the hanging rest."""
    energy, parameters = system.function("energy"), system.parameters(p)
    hanging = np.zeros(system.nq)
    hanging[system.cart_size + 2 :: 3] = 1.0
    bottom = float(sum(energy(hanging, np.zeros(system.nv), **parameters)))

    def of(z: Vector) -> float:
        at = turning(system, np.asarray(z))
        return float(sum(energy(at.q, at.v, **parameters))) - bottom

    return of


def angular_momentum(system: System, z: Vector, p: Parameters | None = None) -> float:
    """J = 2 T / Omega about the vertical, kg m^2/s: turning as a whole, T is half Omega J."""
    at = turning(system, z)
    kinetic = float(system.energy(at.q, at.v, **system.parameters(p))[0])
    return 2 * kinetic / float(z[-1])
