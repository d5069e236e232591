"""Orbits of twice the period, where those that come back turned have a multiplier -1.

With M the map of small motions over T, turned back, and M v = -v, the orbit taken twice, x(2T) = R(2 phi) x(0), has the map M^2 and M^2 v = v: beside
the tangent of its own family, which changes omega or phi, the Jacobian of 2T has the null vector v, which to first order changes neither. The new
family leaves along v. T later it has left along -v, so that both ways out are one family, and where it comes back to an orbit taken twice it ends.
"""

from __future__ import annotations

import numpy as np

from phichain.continuation import Branch, Special
from phichain.errors import UnsupportedError
from phichain.orbits.quarter import EPS
from phichain.orbits.unmirrored.problem import Lost, read_closing, state_of_free, unmirrored_problem
from phichain.orbits.whirling.fixed import turned
from phichain.system import Parameters, System, Vector

_SINGULAR = 1e-6
"""Relative size below which a singular value is zero: events are located to about 1e-10."""


def beyond_doubling(system: System, branch: Branch, event: Special, p: Parameters | None) -> Lost:
    """Where the family of twice the period begins, what was held being held: of a turn that was held, twice the turn.

    Args:
        system: The chain.
        branch: A family of unmirrored orbits.
        event: One of its period doublings.
        p: Runtime parameters.

    Raises:
        UnsupportedError: Only one family passes there.
    """
    held, value, link = read_closing(branch.closing)
    value = 2 * value if held == "turn" else value
    z = event.z.copy()
    z[-2:] *= 2.0, 0.5
    problem = unmirrored_problem(system, p, held=held, value=value, omega=float(z[-1]), link=link)
    _, sizes, rows = np.linalg.svd(problem.at(z / problem.sizes).jacobian)
    if sizes[-1] > _SINGULAR * sizes[0]:
        raise UnsupportedError("start", event.kind, "is where only one family passes", "start from another event")
    null = rows[-2:].T * problem.sizes[:, None]
    shape = null @ np.linalg.svd(null[-2:] / np.array([[1.0], [z[-1]]]))[2][-1]
    return Lost.along(z, shape, system.links, held, value, link)


def twice(system: System, p: Parameters | None, z: Vector, link: int) -> float:
    """How far an orbit is from one that is taken twice: its state after half of its period, turned back, from its start."""
    x, omega = state_of_free(z, link), float(z[-1])
    found = system.propagate(x[: system.nq], x[system.nq :], 0.0, np.pi / omega, EPS, **system.parameters(p))
    off = turned(np.concatenate([found.q, found.v]), -z[-2] / 2) - x
    off[system.nq :] /= omega
    return float(np.max(np.abs(off)))
