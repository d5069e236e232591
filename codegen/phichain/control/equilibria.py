"""The 2^n vertical equilibria: states, energies, eigenstructure, types.

Every link hangs (s_k = +1) or stands (s_k = -1). Hanging throughout is a minimum of the potential energy, up to the
cart's free translation, and the energy is kept: it is stable in the sense of Lyapunov. Every other one has a direction
in which the potential falls, hence a real pair +-lambda: a saddle (a spring stiff enough changes that, and the
stiffness matrix tells).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.linalg import eigh

from phichain.control.linear import LinearSystem, linearize, linearized
from phichain.control.weights import Spectrum, spectrum
from phichain.errors import ControlError, UnsupportedError
from phichain.records import Held
from phichain.system import Parameters, System, Vector
from phichain.system.vertical import Signs, configuration

MOST_LINKS = 16
"""2^16 equilibria are listed in one go; more would only fill memory."""


@dataclass(frozen=True, eq=False)
class Equilibrium(Held):
    """One vertical equilibrium.

    Attributes:
        s: Directions of the links, +1 hanging, -1 upright.
        q: Configuration (nq,), the cart at the origin.
        energy: Potential energy, J, or None without an `energy` function.
        squares: Undamped lambda^2 (m,), 1/s^2, rising: negative swings, positive falls, zero moves freely.
        poles: Open-loop eigenvalues (2m,), by falling real part.
        falling: Number of directions in which the potential energy falls.
    """

    s: Signs
    q: Vector
    energy: float | None
    squares: Vector
    poles: Spectrum
    falling: int

    @property
    def kind(self) -> str:
        """ "stable" (a minimum of the energy: in the sense of Lyapunov), or "saddle"."""
        return "saddle" if self.falling else "stable"

    def __str__(self) -> str:
        energy = "" if self.energy is None else f", V = {self.energy:.6g} J"
        arrows = "".join("-" if sign > 0 else "+" for sign in self.s)
        return f"{arrows} {self.kind}, {self.falling} falling direction(s){energy}"


def equilibria(system: System, p: Parameters | None = None) -> tuple[Equilibrium, ...]:
    """All vertical equilibria, the hanging one first and the inverted one last.

    A planar chain with springs rests only where they are relaxed: there the others are left out.

    Raises:
        UnsupportedError: More than 16 links.
        AbsentFunctionError: The system has no `linearization`.
    """
    return tuple(equilibrium(system, s, p) for s in at_rest(system, p))


def equilibrium(system: System, s: Sequence[int], p: Parameters | None = None) -> Equilibrium:
    """One vertical equilibrium.

    Raises:
        ControlError: s is no equilibrium of this system.
        AbsentFunctionError: The system has no `linearization`.
    """
    linear = demand_equilibrium(system, s, p)
    signs = linear.s
    q = configuration(system, signs)
    energy = None
    if system.has("energy"):
        energy = float(system.energy(q, np.zeros(system.nv), **system.parameters(p))[1])
    squares = -eigh(linear.G, linear.M, eigvals_only=True)[::-1]
    return Equilibrium(signs, q, energy, squares, spectrum(linear.first_order[0]), _falling(linear))


def _falling(linear: LinearSystem) -> int:
    """Negative directions of G among the links; by Sylvester's law as many as unstable modes."""
    links = linear.G[linear.cart :, linear.cart :]
    return int(np.sum(np.linalg.eigvalsh(links) < 0))


def demand_equilibrium(system: System, s: Sequence[int], p: Parameters | None = None) -> LinearSystem:
    """(19) at an equilibrium at which the chain really rests.

    Raises:
        ControlError: s is not one sign per link, or the chain accelerates there (a planar spring pulls, say).
    """
    return demand_equilibria(system, [s], p)[0]


def demand_equilibria(system: System, every: Sequence[Sequence[int]], p: Parameters | None = None) -> list[LinearSystem]:
    """(19) at several of them; errors as in `demand_equilibrium`, of the first that is none."""
    found = linearized(system, every, p)
    for linear in found:
        pull = _pull(system, linear.s, p)
        if pull > _slack(linear):
            raise ControlError(
                "s",
                list(linear.s),
                f"is no equilibrium of this chain: released there it accelerates by {pull:.3g} rad/s^2",
                "choose a direction of the links in which its springs are relaxed",
                acceleration=pull,
            )
    return found


def at_rest(system: System, p: Parameters | None = None) -> Iterator[Signs]:
    """The vertical equilibria at which the chain rests, the hanging one first and the inverted one last.

    Raises:
        UnsupportedError: More than 16 links.
        AbsentFunctionError: The system has no `linearization`.
    """
    if system.links > MOST_LINKS:
        raise UnsupportedError(
            "links",
            system.links,
            f"2^{system.links} equilibria are too many to list",
            "ask for one by its directions s",
        )
    for s in product((1, -1), repeat=system.links):
        # Where the system cannot tell, and where nothing pulls, the slack need not be known.
        pull = _pull(system, s, p)
        if pull == 0 or pull <= _slack(linearize(system, s, p)):
            yield s


def _pull(system: System, s: Signs, p: Parameters | None) -> float:
    """Largest acceleration when released at rest; 0 when the system cannot tell."""
    if not system.has("forward_dynamics"):
        return 0.0
    u = (np.zeros(system.nu),) if system.nu else ()
    q, v = configuration(system, s), np.zeros(system.nv)
    return float(np.max(np.abs(system.forward_dynamics(q, v, *u, **system.parameters(p)))))


def _slack(linear: LinearSystem) -> float:
    """Accelerations that the rounding of pi explains: |M^-1 G| times a small angle."""
    angle = max(1e-9, 100 * linear.noise)
    return angle * max(1.0, float(np.max(np.abs(linear.first_order[0][len(linear.M) :]))))
