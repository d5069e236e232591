"""connections: the motions that lead from the upright chain back to it, after whole turns of its links."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np
from scipy.linalg import subspace_angles

from phichain.errors import ArrayError, ConvergenceError, UnsupportedError
from phichain.orbits.connections.half import NEAR, Half, flown, middle, solve_half, unpushed
from phichain.orbits.connections.record import Connection
from phichain.orbits.connections.saddle import Saddle, saddle
from phichain.orbits.connections.search import starts
from phichain.system import Parameters, System, Vector
from phichain.system.arrays import positive, whole
from phichain.system.drawn import looks

MOST_LINKS: Final = 2
NEEDED: Final = ("forward_dynamics", "propagate", "mass_matrix", "linearization", "energy")
"""What a system must have."""
#: Half a connection is looked for over the time in which the slowest direction grows to size one, and this many growth times more.
_LONGER: Final = 9.0
_POINTS: Final = 48
"""Outputs a stretch between nodes."""
#: Two half connections whose times differ by less are one.
_SAME: Final = 1e-8
_FARTHER: Final = 2.0


def connections(
    system: System, turns: Sequence[int] | None = None, p: Parameters | None = None, *, s: Sequence[int] | None = None, longest: float | None = None
) -> tuple[Connection, ...]:
    """The symmetric connections of the upright chain with itself that turn its links by whole turns, the quickest first.

    The equations are conservative, so a connection leads to an equilibrium of the same energy: to the same one, whole turns of its links on.
    It is the intersection of an unstable and a stable manifold; those that are symmetric about their middle are found here. Motions from all
    around the saddle give the starts of a boundary value problem on the emitted flow.

    Args:
        system: A conservative planar chain of one or two links on a fixed base or a free cart, with `NEEDED`, its flow variational.
        turns: Whole turns of every link's absolute angle; one of each unless given.
        p: Runtime parameters.
        s: The equilibrium; upright unless given.
        longest: Half the time in which to look, s, from and to where the linear motion takes over.

    Returns:
        What was found, perhaps nothing.

    Raises:
        ControlError: s is no equilibrium, or has fewer unstable directions than links.
        UnsupportedError: More than two links, or a chain that is not conservative and planar.
        ArrayError: turns are no whole numbers, one a link and not all zero.
        AbsentFunctionError: A function is missing.
    """
    for name in NEEDED:
        system.function(name)
    if system.links > MOST_LINKS:
        raise UnsupportedError("links", system.links, "has unstable manifolds that are searched for one and two links", "use a shorter chain")
    wanted = _turns(system, turns)
    origin = saddle(system, [-1] * system.links if s is None else s, p)
    slowest = float(origin.rates[-1])
    span = (math.log(1 / NEAR) + _LONGER) / slowest if longest is None else positive("longest", longest, "give seconds")
    goal, found = middle(system, origin, wanted), dict[float, Half]()
    for start, time in starts(system, origin, goal, span, p):
        try:
            half = solve_half(system, origin, goal, start, time, p)
        except ConvergenceError:
            continue
        if not any(abs(half.time - known) < _SAME for known in found):
            found[half.time] = half
    return tuple(_whole(system, origin, goal, wanted, found[time], p) for time in sorted(found))


def _turns(system: System, turns: Sequence[int] | None) -> tuple[int, ...]:
    remedy = "give a whole number of turns for every link, not all zero"
    given = [1] * system.links if turns is None else list(turns)
    if len(given) != system.links or not any(given):
        raise ArrayError("turns", given, "does not say how far every link turns", remedy)
    return tuple(whole("turns", entry, -8, 8, remedy, ArrayError) for entry in given)


def _whole(system: System, origin: Saddle, goal: Vector, turns: tuple[int, ...], half: Half, p: Parameters | None) -> Connection:
    """Both halves: the second is the first, reflected and backwards."""
    nq, times = system.nq, np.linspace(0.0, half.time / (len(half.nodes) - 1), _POINTS + 1)
    x = np.vstack([*(_stretch(system, node, times, p) for node in half.nodes[:-1]), half.nodes[-1]])
    t = np.linspace(-half.time, 0.0, len(x))
    last = x[-1, :nq].copy()
    last[system.cart_size :] = goal
    q, v = x[:, :nq], x[:, nq:]
    energies = np.sum(system.energy(q, v, **system.parameters(p)), axis=0)
    rest = float(np.sum(system.energy(origin.x[:nq], origin.x[nq:], **system.parameters(p))))
    return Connection(
        name=system.name, digest=system.digest, s=origin.s, turns=turns, t=np.concatenate([t, -t[-2::-1]]),
        q=np.vstack([q, (2 * last - q)[-2::-1]]), v=np.vstack([v, v[-2::-1]]), rates=origin.rates, start=half.start / np.linalg.norm(half.start),
        residual=half.residual, error=_error(system, origin, goal, half, p), energy=float(np.max(np.abs(energies - rest))),
        transversality=_transversality(system, half, origin, p), q_names=system.q_names, v_names=system.v_names, p=system.values(p), **looks(system, p),
    )  # fmt: skip


def _stretch(system: System, node: Vector, times: Vector, p: Parameters | None) -> Vector:
    """States from a node on, the end left out."""
    nq = system.nq
    found = system.propagate(node[:nq], node[nq:], 0.0, float(times[-1]), 1e-16, times=times[1:-1], **unpushed(system), **system.parameters(p))
    return np.vstack([node, np.hstack([found.q_at, found.v_at])])


def _error(system: System, origin: Saddle, goal: Vector, half: Half, p: Parameters | None) -> float:
    """How far the rates half way move when the motion leaves the saddle's linear neighbourhood earlier: that costs its third power."""
    ahead = np.log(_FARTHER) / origin.rates
    # Where the direction that carries the motion has grown to the larger distance.
    later = float(ahead[np.argmax(np.abs(half.start))])
    end = flown(system, half.nodes[0], later, p, False)[0] - origin.x
    start = np.asarray(np.linalg.lstsq(origin.directions, end, rcond=None)[0], dtype=np.float64)
    other = solve_half(system, origin, goal, start, half.time - later, p)
    return float(np.max(np.abs(other.nodes[-1][system.nq :] - half.nodes[-1][system.nq :])))


def _transversality(system: System, half: Half, origin: Saddle, p: Parameters | None) -> float:
    """The second angle between the unstable manifold and its image under the reflection, in the metric of the kinetic energy.

    The first one is zero, along the motion itself; rates count over the fastest growth rate.
    """
    if system.links == 1:
        return math.nan
    nq = system.nq
    root = np.linalg.cholesky(np.asarray(system.mass_matrix(half.nodes[-1][:nq], **system.parameters(p)))).T
    weights = np.zeros((2 * nq, 2 * nq))
    weights[:nq, :nq], weights[nq:, nq:] = root * origin.rates[0], root
    unstable = weights @ half.plane
    stable = unstable * np.repeat([-1.0, 1.0], nq)[:, None]
    return float(np.sort(subspace_angles(unstable, stable))[1])
