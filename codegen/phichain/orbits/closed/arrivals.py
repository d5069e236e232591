"""Where families come to orbits of more symmetries, or to shorter ones that they run through."""

from __future__ import annotations

import numpy as np

from phichain.continuation import Branch
from phichain.orbits.closed.kinds import state_of, unknowns_of
from phichain.orbits.closed.symmetries import recognised, taken_up
from phichain.orbits.symmetry import BRANCH_POINT
from phichain.system import Parameters, System, Vector


def shorter_orbit(system: System, p: Parameters | None, kind: str, z: Vector) -> tuple[str, Vector]:
    """The orbit that another one runs through, once or several times, under the kind that it belongs to."""
    q, v = state_of(kind, z)
    omega = float(z[-1])
    own, times = recognised(system, p, q, v, omega)
    if own == kind:
        return own, np.append(z[:-1], times * omega)
    return own, unknowns_of(own, *taken_up(system, p, own, q, v, times * omega), times * omega)


def arrival(system: System, p: Parameters | None, branch: Branch) -> tuple[str, Vector] | None:
    """The orbit, and its kind, at which a branch has ended because it gains a symmetry there; None where it
    has not."""
    if branch.status != "event" or not branch.events[-1].kind.startswith((BRANCH_POINT, "cover")):
        return None
    return shorter_orbit(system, p, branch.closing, branch.events[-1].z)
