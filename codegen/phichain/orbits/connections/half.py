"""Half a connection as a boundary value problem: from a saddle's unstable manifold to where a symmetry turns it back.

The hanging chain is symmetric under theta -> -theta and under reversal of time, and so is the chain that is reflected about any of its
equilibria: with c_k whole multiples of pi, (phi, phi')(t) -> (2 c - phi, phi')(-t) maps motions to motions. A motion that leaves phi_0
and comes to phi(T) = c therefore goes on to 2 c - phi_0: N conditions for the N unknowns T and a / |a|. What grows fast beside what
grows slowly is held by multiple shooting:

    x_0 = saddle(a), |a| = a_0;      x_{i+1} = flow(x_i, T / m);      phi(T) = c

solved by Newton's method on all of it at once, with the flow's transition columns for the Jacobian. Leaving the unstable manifold's
tangent at |a| costs |a|^3.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from phichain.errors import ConvergenceError
from phichain.orbits.connections.saddle import Saddle, leaving
from phichain.records import Held
from phichain.system import Parameters, System, Vector
from phichain.system.angles import scene_angles

#: How far from the saddle a connection starts, rad: the third power is round-off.
NEAR: Final = 2e-5
#: A stretch between nodes lets errors grow by the exponential of this at most.
_GROWTH: Final = 4.0
_ROUNDS: Final = 30
#: A residual with which Newton's method has arrived, when it gets no better.
_GOOD: Final = 1e-11
_STEPS: Final = 2000
"""Steps that a stretch is worth: where Newton asks for more it has gone astray."""
_EPS: Final = float(np.finfo(float).eps)


@dataclass(frozen=True, eq=False)
class Half(Held):
    """A motion from a saddle to where it is turned back.

    Attributes:
        start: Parts a of the unstable directions (N,).
        time: T, s.
        nodes: States (m + 1, 2 nq) at equal times from 0 to T.
        residual: The largest mismatch at nodes and end, of the states' sizes.
        plane: Orthonormal columns (2 nq, N) along the unstable manifold at the end.
    """

    start: Vector
    time: float
    nodes: Vector
    residual: float
    plane: Vector


def middle(system: System, origin: Saddle, turns: tuple[int, ...]) -> Vector:
    """Scene angles (N,) half way to so many whole turns of every link."""
    return scene_angles(system, origin.phi + np.pi * np.array(turns))


def joints_of(system: System, x: Vector) -> Vector:
    """Scene angles (..., N) of states (..., 2 nq)."""
    found: Vector = x[..., system.cart_size : system.nq]
    return found


def unpushed(system: System) -> dict[str, Vector]:
    """The argument u of a flow whose inputs, if it has any, stay zero."""
    return {"u": np.zeros(system.nu)} if system.nu else {}


def flown(system: System, x: Vector, time: float, p: Parameters | None, columns: bool) -> tuple[Vector, Vector]:
    """The state after a time, and what becomes of its variations; NaN where it does not come there."""
    nq = system.nq
    found = system.propagate(
        x[:nq], x[nq:], 0.0, time, _EPS, max_steps=_STEPS, **unpushed(system), **({"transition": np.eye(2 * nq)} if columns else {}), **system.parameters(p)
    )
    end = np.concatenate([found.q, found.v]) if found.outcome == "done" else np.full(2 * nq, np.nan)
    return end, found.transition if columns else np.empty(0)


def solve_half(system: System, origin: Saddle, goal: Vector, start: Vector, time: float, p: Parameters | None) -> Half:
    """Newton's method from a start and a time that nearly do.

    Raises:
        ConvergenceError: It does not converge.
    """
    many = max(1, int(np.ceil(origin.rates[0] * time / _GROWTH)))
    near, nodes = float(np.linalg.norm(start)), [leaving(system, origin, start, p)]
    for _ in range(many):
        nodes.append(flown(system, nodes[-1], time / many, p, False)[0])
    found = Half(np.array(start), time, np.array(nodes), np.inf, np.empty((2 * system.nq, 0)))
    best = found
    for _ in range(_ROUNDS):
        if not (0 < found.time < 2 * time and np.isfinite(found.nodes).all()):
            break
        step, found = _newton(system, origin, goal, found, near, p)
        before = best.residual
        if found.residual < before:
            best = found
        if best.residual < 4 * _EPS or (before < _GOOD and found.residual > before / 2):
            return replace(best, plane=_plane(system, origin, best, p))
        if not np.isfinite(step).all():
            break
        found = _stepped(system, origin, found, step, p)
    if best.residual < _GOOD:
        return replace(best, plane=_plane(system, origin, best, p))
    raise ConvergenceError(
        "connection", best.time, f"Newton's method came to a residual of {best.residual:.2g}", "start nearer, or look along fewer seconds",
        residual=best.residual,
    )  # fmt: skip


def _newton(system: System, origin: Saddle, goal: Vector, at: Half, near: float, p: Parameters | None) -> tuple[Vector, Half]:
    """The step (a, T, x_1 .. x_m), and the same motion with its residual."""
    many, size, links = len(at.nodes) - 1, 2 * system.nq, system.links
    unknowns = links + 1 + many * size
    jacobian, residual = np.zeros((unknowns, unknowns)), np.empty(unknowns)
    residual[0] = (at.start @ at.start - near**2) / near
    jacobian[0, :links] = 2 * at.start / near
    for i in range(many):
        end, columns = flown(system, at.nodes[i], at.time / many, p, True)
        rows, here = slice(1 + i * size, 1 + (i + 1) * size), links + 1 + i * size
        residual[rows] = end - at.nodes[i + 1]
        if i:
            jacobian[rows, here - size : here] = columns
        else:
            jacobian[rows, :links] = columns @ origin.directions
        jacobian[rows, links] = _slope(system, end, p) / many
        jacobian[rows, here : here + size] = -np.eye(size)
    last = slice(1 + many * size, unknowns)
    residual[last] = joints_of(system, at.nodes[-1]) - goal
    jacobian[last, unknowns - size + system.cart_size : unknowns - size + system.nq] = np.eye(links)
    scale = np.maximum(1.0, np.abs(at.nodes).max())
    try:
        step = np.asarray(np.linalg.solve(jacobian, -residual), dtype=np.float64)
    except np.linalg.LinAlgError:
        step = np.full(unknowns, np.nan)
    return step, replace(at, residual=float(np.max(np.abs(residual)) / scale))


def _stepped(system: System, origin: Saddle, at: Half, step: Vector, p: Parameters | None) -> Half:
    links = system.links
    start = at.start + step[:links]
    nodes = at.nodes.copy()
    nodes[0] = leaving(system, origin, start, p)
    nodes[1:] += step[links + 1 :].reshape(nodes[1:].shape)
    return replace(at, start=start, time=at.time + float(step[links]), nodes=nodes)


def _slope(system: System, x: Vector, p: Parameters | None) -> Vector:
    """x' of the state."""
    u = (np.zeros(system.nu),) if system.nu else ()
    nq = system.nq
    return np.concatenate([x[nq:], system.forward_dynamics(x[:nq], x[nq:], *u, **system.parameters(p))])


def _plane(system: System, origin: Saddle, at: Half, p: Parameters | None) -> Vector:
    """The unstable manifold's tangent at the end, made orthonormal after every stretch so that no direction is lost."""
    plane, many = origin.directions, len(at.nodes) - 1
    for node in at.nodes[:-1]:
        plane = np.linalg.qr(flown(system, node, at.time / many, p, True)[1] @ plane)[0]
    return plane
