"""Orbits that come back turned about the vertical, with no symmetry left, by shooting over all of what they take: x(T) = R(phi) x(0).

Unknowns are the state x = (q_k, omega_k) in space, alpha_k and beta_k, eps_1 and eps_2, phi and omega, T = 2 pi / omega. With x^ the state whose
links have length one and no rate about themselves,

    R(-phi) x(T; x^) - x + (alpha_k q_k, beta_k q_k + eps_1 omega_k + eps_2 (e_3 - (e_3.q_k) q_k)) = 0,   q_k.q_k = 1,   q_k.omega_k = 0,
    J - J_0 = 0 (or E, or phi, held).

Orbits are taken up where one link, K, is highest or lowest, in the plane y = 0: y . q_K = y . omega_K = 0 are no unknowns. alpha, beta and eps are zero on every
orbit: x^ has no component along the links, and of the equations of closing two follow from the others, for energy and momentum come back by
themselves; a damper and a drive about the vertical unfold them (their effects on both are independent but where the chain turns as a whole).

The map of small motions is symplectic in dq ^ dP. It fixes the flow f and the turning u; on what is orthogonal to both in that form, but
for both themselves, is S with kappa = (lambda + 1/lambda) / 2 = eig (S + S^-1) / 2, S^-1 = Omega^-1 S^T Omega: every one twice.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from phichain.continuation import Branch, Evaluation, Problem
from phichain.continuation.problem import LateExtra, Multipliers
from phichain.orbits.quarter import EPS, frequency_error, ordered, powers
from phichain.orbits.whirling.fixed import about_vertical, area, inertia_of, turned
from phichain.orbits.whirling.problem import momentum
from phichain.records import Held
from phichain.system import Parameters, System, Vector
from phichain.system.state import rhs

METHOD: Final = "unmirrored"
_STEPS = 40_000


@dataclass(frozen=True, eq=False)
class FreeMap(Held):
    """What is known of an orbit besides its equations.

    Attributes:
        slopes: dE and dJ by the unknowns of the state (6 N - 2, 2).
        noise: What rounding may have left in the residual (8 N + 1,).
    """

    slopes: Vector
    noise: Vector


@dataclass(frozen=True, eq=False)
class Lost(Held):
    """Where a family begins.

    Attributes:
        z: Unknowns there (8 N + 2,).
        shape: How it leaves (8 N + 2,), the largest change of a direction, or of a rate over omega, 1.
        held: What is held, as along the family that it leaves.
        value: Its value.
        link: The link, from 0, that takes orbits up.
    """

    z: Vector
    shape: Vector
    held: str
    value: float
    link: int

    @classmethod
    def along(cls, z: Vector, shape: Vector, links: int, held: str, value: float, link: int) -> Lost:
        """The same with a shape of any size and either sign: linear algebra's own sign is each processor's, and the way begins the same on all."""
        whole = np.zeros(8 * links + 4)
        whole[unknowns(links, link)] = shape
        nq = 3 * links
        largest = max(np.max(np.abs(whole[:nq])), np.max(np.abs(whole[nq : 2 * nq])) / z[-1])
        leading = whole[np.argmax(np.abs(whole) > 0.25 * np.max(np.abs(whole)))]
        return cls(z, shape / np.copysign(largest, leading), held, value, link)


def unmirrored_problem(
    system: System, p: Parameters | None = None, *, held: str, value: float, omega: float, link: int
) -> Problem:
    """The problem with kappa of R(-phi) M(T), 2 N - 2 of them.

    Args:
        system: A spatial chain without losses on a fixed base, with what `whirling` families call.
        p: Runtime parameters.
        held: "momentum" about the vertical, "energy" or "turn".
        value: Its value.
        omega: A frequency of the family, rad/s: its size.
        link: K, from 0.
    """
    flow, parameters, links, field = system.function("propagate"), system.parameters(p), system.links, rhs(system)
    nq, nx, size = system.nq, system.nx, 8 * links + 1
    inertia, omega = inertia_of(system, p), float(powers(np.array([omega]))[0])
    unit = {"momentum": float(np.trace(inertia)) * omega, "energy": float(np.trace(inertia)) * omega**2, "turn": 1.0}[held]
    # Columns of the whole unknowns without those that the phase and the turning take away.
    free = unknowns(links, link)
    tall = energy_of(system, p)

    def slopes_of(at: Vector, columns: Vector) -> Vector:
        return -area(inertia, at, columns, np.stack([field(0.0, at, None, p), about_vertical(at)], axis=1))

    def evaluate(z: Vector) -> Evaluation:
        rate, nothing = float(z[-1]), Evaluation(np.full(size, np.nan), np.full((size, size + 1), np.nan))
        z = whole_of(z, links, link)
        if not (rate > 0 and np.all(np.isfinite(z)) and np.all(np.linalg.norm(z[:nq].reshape(links, 3), axis=1) > 0)):
            return nothing
        x, along, about, (damped, driven) = z[:nx], z[nx : nx + links], z[nx + links : nx + 2 * links], z[-4:-2]
        at, columns = projected(x)
        found = flow(at[:nq], at[nq:], 0.0, 2 * np.pi / rate, EPS, max_steps=_STEPS, transition=columns, **parameters)
        if found.outcome != "done":
            return nothing
        end = turned(np.concatenate([found.q, found.v]), -z[-2])
        q, spins, moved = at[:nq].reshape(links, 3), at[nq:].reshape(links, 3), columns[:nq].reshape(links, 3, nx)
        lift = np.array([0.0, 0.0, 1.0]) - q[:, 2:] * q
        lifted = -q[:, 2:, None] * moved - moved[:, 2:, :] * q[:, :, None]
        jacobian = np.zeros((size, size + 3))
        jacobian[:nx, :nx] = turned(np.asarray(found.transition), -z[-2]) - np.eye(nx)
        jacobian[:nq, :nx] += (along[:, None, None] * moved).reshape(nq, nx)
        jacobian[nq:nx, :nx] += (about[:, None, None] * moved + driven * lifted).reshape(nq, nx) + damped * columns[nq:]
        for k in range(links):
            here = slice(3 * k, 3 * k + 3)
            jacobian[here, nx + k] = jacobian[nq + here.start : nq + here.stop, nx + links + k] = q[k]
            jacobian[nx + k, here] = 2 * x[here]
            jacobian[nx + links + k, here], jacobian[nx + links + k, nq + here.start : nq + here.stop] = x[nq + here.start : nq + here.stop], x[here]
        jacobian[nq:nx, -4], jacobian[nq:nx, -3] = at[nq:], lift.ravel()
        jacobian[:nx, -2], jacobian[:nx, -1] = -about_vertical(end), field(0.0, end, None, p) * (-2 * np.pi / rate**2)
        residual = np.empty(size)
        residual[:nq] = end[:nq] - x[:nq] + (along[:, None] * q).ravel()
        residual[nq:nx] = end[nq:] - x[nq:] + (about[:, None] * q + damped * spins + driven * lift).ravel()
        own, rates = x[:nq].reshape(links, 3), x[nq:].reshape(links, 3)
        residual[nx : nx + links], residual[nx + links : nx + 2 * links] = np.sum(own * own, axis=1) - 1, np.sum(own * rates, axis=1)
        if held == "turn":
            residual[-1], jacobian[-1, -2] = z[-2] - value, 1.0
        else:
            now = momentum(inertia, at) if held == "momentum" else tall(at)
            residual[-1], jacobian[-1, :nx] = (now - value) / unit, slopes_of(at, columns)[:, 0 if held == "energy" else 1] / unit

        whole_jacobian = jacobian

        def made() -> tuple[Multipliers, FreeMap]:
            noise = np.abs(whole_jacobian) @ np.abs(z) * (EPS * (1 + found.steps))
            basis = _tangent(at)
            whole = turned(np.asarray(found.transition), -z[-2]) @ basis
            motions = np.stack([field(0.0, at, None, p), about_vertical(at)], axis=1)
            return _kappa(inertia, at, basis, whole, motions), FreeMap(slopes_of(at, columns)[free[: nx - 2]], noise)

        return Evaluation(residual, np.ascontiguousarray(jacobian[:, free]), LateExtra(made))

    names = (*system.q_names, *system.v_names) if system.q_names and system.v_names else tuple(f"x_{k + 1}" for k in range(nx))
    more = (*(f"along_{k + 1}" for k in range(links)), *(f"about_{k + 1}" for k in range(links)), "damped", "driven", "turn", "omega")
    named = (*names, *more)
    sizes = powers(np.concatenate([np.ones(nq), np.full(nq, omega), np.ones(links), np.full(links, omega), [1.0, omega, 1.0, omega]]))
    return Problem(
        evaluate=evaluate, names=tuple(named[k] for k in free), scale=sizes[free], error=frequency_error,
        energy=lambda z: tall(projected(whole_of(np.asarray(z), links, link)[:nx])[0]),
    )  # fmt: skip


def unknowns(links: int, link: int) -> list[int]:
    """Which of (x, alpha, beta, eps, phi, omega) (8 N + 4) are unknowns, where link K takes the orbit up."""
    taken = (3 * link + 1, 3 * (links + link) + 1)
    return [k for k in range(8 * links + 4) if k not in taken]


def whole_of(z: Vector, links: int, link: int) -> Vector:
    """(x, alpha, beta, eps, phi, omega) (8 N + 4,) of the unknowns."""
    whole = np.zeros(8 * links + 4)
    whole[unknowns(links, link)] = z
    return whole


def state_of_free(z: Vector, link: int) -> Vector:
    """State (6 N,) at the start of the orbit z that link K takes up."""
    links = (len(z) - 2) // 8
    return projected(whole_of(z, links, link)[: 6 * links])[0]


def projected(x: Vector) -> tuple[Vector, Vector]:
    """x^ (6 N,) and its derivatives (6 N, 6 N)."""
    half = len(x) // 2
    at, columns = np.empty(len(x)), np.zeros((len(x), len(x)))
    for k in range(0, half, 3):
        here, there = slice(k, k + 3), slice(half + k, half + k + 3)
        length = float(np.linalg.norm(x[here]))
        q = x[here] / length
        across = np.eye(3) - np.outer(q, q)
        moved, own = across / length, float(q @ x[there])
        at[here], at[there] = q, x[there] - own * q
        columns[here, here], columns[there, there] = moved, across
        columns[there, here] = -own * moved - np.outer(q, x[there] @ moved)
    return at, columns


def _tangent(at: Vector) -> Vector:
    """Small motions (6 N, 4 N) of a state: displacements with the rates turned along, and rates."""
    half = len(at) // 2
    basis = np.zeros((2 * half, 4 * (half // 3)))
    for k in range(half // 3):
        here, there = slice(3 * k, 3 * k + 3), slice(half + 3 * k, half + 3 * k + 3)
        q, spin = at[here], at[there]
        across = np.linalg.qr(q[:, None], mode="complete")[0][:, 1:]
        basis[here, 2 * k : 2 * k + 2] = basis[there, 2 * (half // 3) + 2 * k : 2 * (half // 3) + 2 * k + 2] = across
        basis[there, 2 * k : 2 * k + 2] = -np.outer(q, spin @ across)
    return basis


def _kappa(inertia: Vector, at: Vector, basis: Vector, whole: Vector, motions: Vector) -> Multipliers:
    """kappa (2 N - 2,), the largest real part first."""
    form = area(inertia, at, basis, basis)
    inside = np.linalg.lstsq(basis, np.hstack([whole, motions]), rcond=None)[0]
    mapped, fixed = inside[:, :-2], inside[:, -2:]
    # Orthogonal to flow and turning in the form, and across both.
    rows = np.vstack([fixed.T @ form, fixed.T])
    _, _, right = np.linalg.svd(rows)
    across = right[4:].T
    if not across.size:
        return np.empty(0, complex)
    own = np.linalg.lstsq(np.hstack([across, fixed]), mapped @ across, rcond=None)[0][:-2]
    left = across.T @ form @ across
    both = (own + np.linalg.solve(left, own.T @ left)) / 2
    remaining = [complex(value) for value in np.linalg.eigvals(both)]
    found = []
    while remaining:
        one = remaining.pop()
        other = remaining.pop(int(np.argmin([abs(one - value) for value in remaining])))
        found.append((one + other) / 2)
    return ordered(np.array(found, complex))


def energy_of(system: System, p: Parameters | None) -> Callable[[Vector], float]:
    """x -> T + V, J, counted from the hanging rest."""
    energy, parameters, nq = system.function("energy"), system.parameters(p), system.nq
    hanging = np.zeros(nq)
    hanging[2::3] = 1.0
    bottom = float(sum(energy(hanging, np.zeros(nq), **parameters)))

    return lambda x: float(sum(energy(x[:nq], x[nq:], **parameters))) - bottom


def problem_of_branch(system: System, p: Parameters | None, branch: Branch) -> Problem:
    """The problem that a family of them solves, by what its record says."""
    held, value, link = read_closing(branch.closing)
    return unmirrored_problem(system, p, held=held, value=value, omega=float(branch.scale[-1]), link=link)


def closing_of(held: str, value: float, link: int) -> str:
    """What a Branch says of how its orbits are closed."""
    return f"{held} held at {value!r}, taken up by link {link + 1}"


def read_closing(closing: str) -> tuple[str, float, int]:
    """What is held, at which value, and the link from 0 that takes the orbit up."""
    held, _, more = closing.partition(" held at ")
    value, _, link = more.partition(", taken up by link ")
    return held, float(value), int(link) - 1
