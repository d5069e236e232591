"""Orbits of a spatial chain that come back turned about the vertical, by shooting over half of what they take: x(T) = R(phi) x(0).

A chain that is free to turn about the vertical has the energy E and the momentum J about it, and its orbits come back turned: families of two
parameters, of which one quantity is held. Those that the mirror image of a vertical plane, run backwards, leaves as they are start in
that plane with their rates across it, and half of T later are in such a plane again, turned by phi / 2. With the notation of `fixed` and
the unknowns (theta_k, r_k, phi, omega), T = 2 pi / omega,

    y . R(-phi/2) q_k(T/2) = 0,   y . R(-phi/2) omega_k(T/2) = 0,   J - J_0 = 0 (or E, or phi, held)

are 2 N + 1 equations in 2 N + 2 unknowns. Between two states that a reversal leaves as they are nothing else is needed, as for `reversible`
orbits of planar chains: conserved quantities take no equation away, and need no unfolding.

One propagation gives all of it: with Q = [A B; C D] of even and odd small motions over T/2, seen from the turned plane, C is the Jacobian;
Q is symplectic, M(T) = R Q^-1 R Q with R = diag(1, -1), and kappa = (lambda + 1/lambda) / 2 = eig(1 + 2 G_0^-T B^T G_1 C). The flow f and
the turning u about the vertical are odd and B f = B u = 0: dE and dJ are left vectors of that matrix, and what is left is taken on the even
motions that change neither.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from phichain.continuation import Branch, Evaluation, Problem
from phichain.continuation.problem import LateExtra, Multipliers
from phichain.errors import ArrayError
from phichain.orbits.quarter import EPS, frequency_error, ordered, powers
from phichain.orbits.whirling.fixed import (
    Fixed,
    about_vertical,
    area,
    fixed,
    inertia_of,
    nearest,
    read,
    turned,
)
from phichain.records import Held
from phichain.system import Parameters, System, Vector
from phichain.system.state import rhs

HELD: Final = ("momentum", "energy", "turn")
"""What may be held along a family."""
_STEPS = 40_000


@dataclass(frozen=True, eq=False)
class WhirlMap(Held):
    """The variational equations over half of the orbit, in even and odd motions, seen from the turned plane.

    Attributes:
        a: Even to even (2 N, 2 N).
        b: Odd to even.
        c: Even to odd.
        d: Odd to odd.
        begun: The flow and the turning at the start, as odd motions (2 N, 2).
        ended: dE and dJ of even motions at the end (2 N, 2).
        slopes: dE and dJ by (theta, r) at the start (2 N, 2).
        momentum: J in its size, the trace of the inertia between links times omega.
        spread: Largest difference between both ends in angles or in rates over omega: nothing at a relative equilibrium.
        noise: What rounding may have left in the residual (2 N + 1,).
    """

    a: Vector
    b: Vector
    c: Vector
    d: Vector
    begun: Vector
    ended: Vector
    slopes: Vector
    momentum: float
    spread: float
    noise: Vector


def whirling_problem(system: System, p: Parameters | None = None, *, held: str, value: float, omega: float) -> Problem:
    """The problem with unknowns (theta_1 .. theta_N, r_1 .. r_N, phi, omega) and kappa of M(T), 2 N - 2 of them.

    Args:
        system: A spatial chain without losses on a fixed base, whose `propagate` carries derivatives along, with `forward_dynamics`,
            `mass_matrix` and `energy`.
        p: Runtime parameters.
        held: "momentum" (about the vertical), "energy" or "turn" (phi).
        value: Its value, kg m^2/s, J (from the hanging rest) or rad.
        omega: A frequency of the family, rad/s: its size.
    """
    flow, parameters, links, field = system.function("propagate"), system.parameters(p), system.links, rhs(system)
    size, nq = 2 * links + 1, system.nq
    inertia, height = inertia_of(system, p), energy_of(system, p)
    # A family on file has its sizes in powers of two, and what goes on with it is to have the same.
    omega = float(powers(np.array([omega]))[0])
    unit = {"momentum": float(np.trace(inertia)) * omega, "energy": float(np.trace(inertia)) * omega**2, "turn": 1.0}[held]

    def kept(z: Vector, at: Fixed, slopes: Callable[[], Vector]) -> tuple[float, Vector]:
        row = np.zeros(size + 1)
        if held == "turn":
            row[-2] = 1.0
            return float(z[-2]) - value, row
        now = momentum(inertia, at.x) if held == "momentum" else height(z)
        row[: 2 * links] = slopes()[:, 0 if held == "energy" else 1] / unit
        return (now - value) / unit, row

    def evaluate(z: Vector) -> Evaluation:
        rate, nothing = float(z[-1]), Evaluation(np.full(size, np.nan), np.full((size, size + 1), np.nan))
        if not (rate > 0 and np.all(np.isfinite(z))):
            return nothing
        at, half = fixed(z[:links], z[links : 2 * links]), np.pi / rate
        start = np.hstack([at.even, at.odd])
        found = flow(at.x[:nq], at.x[nq:], 0.0, half, EPS, max_steps=_STEPS, transition=start, **parameters)
        if found.outcome != "done":
            return nothing
        end = turned(np.concatenate([found.q, found.v]), -z[-2] / 2)
        columns = turned(np.asarray(found.transition), -z[-2] / 2)
        beside = nearest(end)
        even, odd = read(beside, columns)
        ahead, around = field(0.0, end, None, p), about_vertical(end)
        whole = np.stack([ahead, around], axis=1)
        gone = read(beside, whole)[1]

        def slopes() -> Vector:
            motions = np.stack([field(0.0, at.x, None, p), about_vertical(at.x)], axis=1)
            return -area(inertia, at.x, at.even, motions)

        jacobian = np.zeros((size, size + 1))
        jacobian[:-1, : 2 * links] = odd[:, : 2 * links]
        jacobian[:-1, -2], jacobian[:-1, -1] = -gone[:, 1] / 2, gone[:, 0] * (-half / rate)
        left, jacobian[-1] = kept(z, at, slopes)
        # y . q_k and y . omega_k of the end, which is a motion away from its plane.
        residual = np.append(read(beside, end[:, None])[1][:, 0], left)

        def made() -> tuple[Multipliers, WhirlMap]:
            own = slopes()
            first = read(at, np.stack([field(0.0, at.x, None, p), about_vertical(at.x)], axis=1))[1]
            begun, ended = area(inertia, at.x, at.even, at.odd), area(inertia, beside.x, beside.even, beside.odd)
            a, b, c, d = even[:, : 2 * links], even[:, 2 * links :], odd[:, : 2 * links], odd[:, 2 * links :]
            last = -area(inertia, beside.x, beside.even, whole)
            # The plane that is turned by half a turn more has all signs the other way.
            spread = min(_largest(side * fixed_unknowns(beside) - z[: 2 * links], rate) for side in (1.0, -1.0))
            carried = momentum(inertia, at.x) / (float(np.trace(inertia)) * rate)
            noise = np.abs(jacobian) @ np.abs(z) * (EPS * (1 + found.steps))
            across = np.linalg.qr(own, mode="complete")[0][:, 2:]
            whole_map = np.linalg.solve(begun.T, b.T @ ended @ c)
            kappa = 1 + 2 * np.linalg.eigvals(across.T @ whole_map @ across).astype(complex)
            return ordered(kappa) if links > 1 else np.empty(0, complex), WhirlMap(a, b, c, d, first, last, own, carried, spread, noise)

        return Evaluation(residual, jacobian, LateExtra(made))

    return Problem(
        evaluate=evaluate,
        names=(*(f"theta_{k + 1}" for k in range(links)), *(f"rate_{k + 1}" for k in range(links)), "turn", "omega"),
        scale=powers(np.concatenate([np.ones(links), np.full(links, omega), [1.0, omega]])),
        energy=height,
        error=frequency_error,
    )


def _largest(unknowns: Vector, rate: float) -> float:
    """The largest of angles and of rates over omega (2 N,)."""
    links = len(unknowns) // 2
    return float(max(np.max(np.abs(unknowns[:links])), np.max(np.abs(unknowns[links:])) / rate))


def whirling_of(system: System, p: Parameters | None, branch: Branch) -> Problem:
    """The problem that a family of them solves: what it holds has twelve digits (`held_value`)."""
    held = branch.closing.removesuffix(" held")
    return whirling_problem(system, p, held=held, value=held_value(system, p, held, branch.points[0]), omega=float(branch.scale[-1]))


def held_value(system: System, p: Parameters | None, held: str, z: Vector) -> float:
    """What is held along the family of an orbit z: in twelve digits, so that every orbit of it says the same number.

    Raises:
        ArrayError: Nothing of that name can be held.
    """
    if held not in HELD:
        raise ArrayError("hold", held, "is nothing that can be held along these families", f"use {', '.join(HELD)}")
    if held == "turn":
        return float(z[-2])
    value = momentum(inertia_of(system, p), state_of_whirl(z)) if held == "momentum" else energy_of(system, p)(z)
    return float(f"{value:.11e}")


def fixed_unknowns(at: Fixed) -> Vector:
    """(theta, r) (2 N,) of a state."""
    directions, spins = np.split(at.x.reshape(-1, 3), 2)
    return np.concatenate([np.arctan2(directions[:, 0], directions[:, 2]), -np.sum(at.along * spins, axis=1)])


def momentum(inertia: Vector, x: Vector) -> float:
    """J = sum_k e_3 . (q_k x P_k) of a state (6 N,), kg m^2/s."""
    directions, spins = np.split(x.reshape(-1, 3), 2)
    carried = inertia @ np.cross(spins, directions)
    return float(np.sum(directions[:, 0] * carried[:, 1] - directions[:, 1] * carried[:, 0]))


def state_of_whirl(z: Vector) -> Vector:
    """State (6 N,) at the start of the orbit z."""
    links = len(z) // 2 - 1
    return fixed(z[:links], z[links : 2 * links]).x


def energy_of(system: System, p: Parameters | None) -> Callable[[Vector], float]:
    """z -> T + V, J, counted from the hanging rest."""
    energy, parameters, nq = system.function("energy"), system.parameters(p), system.nq
    hanging = np.zeros(nq)
    hanging[2::3] = 1.0
    bottom = float(sum(energy(hanging, np.zeros(nq), **parameters)))

    def of(z: Vector) -> float:
        x = state_of_whirl(np.asarray(z))
        return float(sum(energy(x[:nq], x[nq:], **parameters))) - bottom

    return of
