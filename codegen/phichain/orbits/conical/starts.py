"""Where conical families begin: at the chain's equilibria, and where they turn so fast that gravity no longer counts.

At the equilibrium with link k hanging (s_k = 1) or standing (s_k = -1) a family begins at every Omega with K a = Omega^2 M a, K and M those
of small motions there: as many as links hang, for gravity pulls these alone back. From the hanging chain they begin at its linear modes.

As Omega grows without bound, cos theta_i sum_j c_ij sin theta_j = 0: a link lies flat, or sum_j c_ij sin theta_j = 0. With the flat
links' sines +-1 the others' solve a linear system, and where they lie between -1 and 1 their cosines may have either sign.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.linalg import eig

from phichain.continuation import Engine, Problem, start_on
from phichain.errors import ConvergenceError, UnsupportedError
from phichain.orbits.conical.problem import conical_problem
from phichain.orbits.modes import demand_conserved
from phichain.records import Held
from phichain.system import Parameters, System, Vector

METHOD = "conical"
NEEDED = ("forward_dynamics", "state_jacobian", "energy", "mass_matrix")
"""Functions that conical families call."""
MOST_LINKS = 6
"""Links of the longest chain all of whose beginnings are listed: there are N 2^(N - 1) at equilibria, and more where they lie flat."""
FASTEST = 5.0
"""Rate up to which families are followed, and at which those begin that come from infinity, in the hanging chain's fastest frequency."""
_HALVINGS = 9
"""Rates between that one and where gravity is a millionth of what turns the links out."""
_STRAY = 0.5
"""Change of an angle, rad, that no halving of the rate makes on one family."""
_REAL = 1e-9
"""Relative size below which an imaginary part is rounding, and Omega^2 that of a cart's drift."""


@dataclass(frozen=True, eq=False)
class Start(Held):
    """Where a family begins.

    Attributes:
        omega: Rate there, rad/s.
        base: Its unknowns without Omega (n,): an equilibrium, or the angles of links that lie flat.
        shape: How the family leaves an equilibrium (n,), largest angle 1; zero where it comes from infinity.
        where: The same in words.
    """

    omega: float
    base: Vector
    shape: Vector
    where: str

    @property
    def is_flat(self) -> bool:
        """True where the family comes from Omega without bound."""
        return not np.any(self.shape)


def conical_starts(system: System, p: Parameters | None = None) -> tuple[Start, ...]:
    """All beginnings in the order in which they are numbered: hanging by rising Omega, folded, and from infinity.

    Chains of more than `MOST_LINKS` links list those of the hanging chain alone.

    Raises:
        UnsupportedError: The system is planar, loses energy, lacks a function, or nothing draws the hanging chain back.
    """
    demand_conical(system)
    problem = conical_problem(system, p, omega=1.0)
    every = system.links <= MOST_LINKS
    signs = sorted(product((1, -1), repeat=system.links), key=lambda s: sum(k < 0 for k in s)) if every else [(1,) * system.links]
    found = [start for s in signs for start in _from_equilibrium(system, problem, s)]
    if not found or found[0].base.any():
        raise UnsupportedError(
            "system", system.name, "does not hang stably, so that nothing turns about the vertical from there", "check gravity and springs"
        )
    hanging = [start for start in found if not start.base.any()]
    folded = sorted((start for start in found if start.base.any()), key=lambda start: (np.sum(start.base > 1), start.omega))
    fastest = FASTEST * max(start.omega for start in hanging)
    flat = _from_infinity(system, p) if every else ()
    brought = [_brought_down(problem, base, fastest) for base in flat]
    return (*hanging, *folded, *(start for start in brought if start is not None))


def demand_conical(system: System) -> None:
    """Refuse a system that has no conical families, or lacks what they need.

    Raises:
        UnsupportedError: It is planar, loses energy, or lacks a function.
    """
    if system.is_planar:
        raise UnsupportedError(
            "method", METHOD, "needs links that can turn about the vertical, and this chain stays in its plane",
            'use space = "spatial", or method = "shooting" for its swinging',
        )  # fmt: skip
    demand_conserved(system)
    absent = [name for name in NEEDED if not system.has(name)]
    if absent:
        raise UnsupportedError(
            "method", METHOD, f"system '{system.name}' lacks the functions {', '.join(absent)}",
            f"build its scene with [functions] want = {list(NEEDED)}",
        )  # fmt: skip


def _from_equilibrium(system: System, problem: Problem, s: tuple[int, ...]) -> list[Start]:
    """The beginnings at one equilibrium, by rising Omega: dF/dz there is J_0 + Omega^2 J_2."""
    on_cart = int(system.has_cart)
    base = np.concatenate([np.zeros(on_cart), np.where(np.array(s) > 0, 0.0, np.pi)])
    # Sines of pi are not zero to the last digit; the residual does not enter here.
    once, twice = (problem.evaluate(np.append(base, rate)).jacobian[:, :-1] for rate in (1.0, 2.0))
    by_square = (twice - once) / 3
    squares, shapes = eig(once - by_square, -by_square)
    size = np.max(np.abs(squares), initial=0.0)
    real = np.abs(squares.imag) <= _REAL * size
    words = "hanging" if min(s) > 0 else "links " + ", ".join(str(k + 1) for k, sign in enumerate(s) if sign < 0) + " standing"
    starts = []
    for k in np.flatnonzero(real & (squares.real > _REAL * size)):
        shape = shapes[:, k].real
        largest = shape[on_cart + int(np.argmax(np.abs(shape[on_cart:])))]
        starts.append(Start(float(np.sqrt(squares[k].real)), base, shape / largest, words))
    return sorted(starts, key=lambda start: start.omega)


def _brought_down(problem: Problem, base: Vector, omega: float) -> Start | None:
    """The family that tends to `base` as Omega grows, at `omega`; at a larger rate where it turns above that.

    None where the limit is degenerate, as for links of one length that lie folded onto each other: Newton strays from there.
    """
    axis = np.append(np.zeros(len(base)), -1.0)
    found = None
    at = base
    for rate in omega * 2.0 ** np.arange(_HALVINGS, -1, -1):
        try:
            new = start_on(problem, np.append(at, rate), axis, Engine(), fixed=True).z(problem)[:-1]
        except ConvergenceError:
            break
        if np.max(np.abs(new - at)) > _STRAY:
            break
        at, found = new, Start(float(rate), new, np.zeros(len(base)), "from infinity")
    return found


def _from_infinity(system: System, p: Parameters | None) -> Iterator[Vector]:
    """Where families tend to as Omega grows without bound (n,), each once of two mirror images."""
    coupling, shift = _couplings(system, p)
    for kinds in product((1.0, -1.0, None), repeat=system.links):
        flat = np.array([kind is not None for kind in kinds])
        if not flat.any() or next(kind for kind in kinds if kind) < 0:
            continue
        sines = np.array([kind or 0.0 for kind in kinds])
        free = np.flatnonzero(~flat)
        sines[free] = -np.linalg.solve(coupling[np.ix_(free, free)], coupling[np.ix_(free, flat)] @ sines[flat])
        if np.any(np.abs(sines[free]) >= 1):
            continue
        for hangs in product((True, False), repeat=len(free)):
            theta = np.arcsin(np.clip(sines, -1.0, 1.0))
            theta[free] = np.where(hangs, theta[free], np.pi - theta[free])
            yield np.concatenate([shift @ np.sin(theta), theta])


def _couplings(system: System, p: Parameters | None) -> tuple[Vector, Vector]:
    """c_ij (N, N), and what the cart's place is in the sines (0 or 1, N); a free cart gives way, which takes its part off c."""
    hanging = np.zeros(system.nq)
    hanging[system.cart_size + 2 :: 3] = 1.0
    mass = np.asarray(system.function("mass_matrix")(hanging, **system.parameters(p)))
    turning = np.arange(system.cart_size + 1, system.nv, 3)
    links = mass[np.ix_(turning, turning)]
    if not system.has_cart:
        return links, np.empty((0, system.links))
    shared = mass[0, turning]
    return links - np.outer(shared, shared) / mass[0, 0], -shared[None, :] / mass[0, 0]
