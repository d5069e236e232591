"""Brake orbits of spatial chains off any plane, by shooting over a quarter period: at rest at q_0, hanging straight after T/4.

The hanging chain comes to itself by half a turn about the vertical, and motions run backwards are motions: one that starts at rest and hangs straight
after a quarter period comes to its image by half a turn after T/2, q(t + T/2) = R(pi) q(t), and is back after T. Angles of link k are those
of q_k in the chart of the sphere about the vertical,

    q_k = (sin(rho) a_k / rho, sin(rho) b_k / rho, cos rho),   rho^2 = a_k^2 + b_k^2,

which are theta_k = a_k, b_k = 0 in the plane y = 0. Turned about the vertical an orbit is another one: b of one link, K, is kept zero. At rest
there is no angular momentum, so that sum_k (x_k P_ky - y_k P_kx) = 0 at T/4 whatever the start is, one of the 2 N equations x_k = y_k = 0
follows from the others, and eps unfolds it:

    x_k + eps n_kx = 0,   y_k + eps n_ky = 0,   n_k = (P_ky, -P_kx) / |P|,   eps = 0 on every orbit.

The blocks of the quarter map and kappa = (mu + 1/mu) / 2 = eig(1 - 2 d^T a) are as in `quarter`, with 2 N displacements. Besides the flow, d g = 0
with the force g, the turning u about the vertical has a u = 0: what is left of kappa is taken across both.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from phichain.continuation import Evaluation, Problem
from phichain.continuation.problem import LateExtra, Multipliers
from phichain.orbits.quarter import EPS, QuarterMap, frequency_error, ordered, powers, quarter_map
from phichain.orbits.whirling.fixed import inertia_of
from phichain.system import Parameters, System, Vector

METHOD: Final = "in space"
_STEPS = 20_000
_SMALL = 1e-4
"""Angles below which sin(rho) / rho is its series, to round-off."""


@dataclass(frozen=True, eq=False)
class SpaceMap(QuarterMap):
    """The quarter map of 2 N displacements.

    Attributes:
        turning: Unit vector of the turning about the vertical at the start (2 N,): the right null vector of a.
    """

    turning: Vector

    def kappa(self) -> Multipliers:
        """The 2 N - 2 numbers besides those of the flow and of the turning, the largest real part first."""
        own = np.stack([self.force, self.turning], axis=1)
        across = np.linalg.qr(own, mode="complete")[0][:, 2:]
        if not across.size:
            return np.empty(0, complex)
        return ordered(1 - 2 * np.linalg.eigvals((self.d @ across).T @ (self.a @ across)).astype(complex))


def space_problem(system: System, p: Parameters | None = None, *, omega: float, kept: int) -> Problem:
    """The problem with unknowns (a_1 .. a_N, b_k of all links but one, eps, omega).

    Args:
        system: A spatial chain on a fixed base whose `propagate` carries derivatives along, with `mass_matrix` and `energy`.
        p: Runtime parameters.
        omega: A frequency of the family, rad/s: its size.
        kept: The link, from 0, that starts in the plane y = 0.
    """
    flow, mass_of, energy = (system.function(name) for name in ("propagate", "mass_matrix", "energy"))
    parameters, links, still = system.parameters(p), system.links, np.zeros(system.nv)
    inertia = inertia_of(system, p)
    end_root = np.linalg.cholesky(np.kron(inertia, np.eye(2))).T
    free = [*range(0, 2 * links, 2), *(2 * k + 1 for k in range(links) if k != kept)]
    size = 2 * links
    bottom = float(sum(energy(state_at_rest(links, np.zeros(size)), still, **parameters)))

    def evaluate(z: Vector) -> Evaluation:
        rate = float(z[-1])
        if not (rate > 0 and np.all(np.isfinite(z))):
            return Evaluation(np.full(size, np.nan), np.full((size, size + 1), np.nan))
        pairs = pairs_of(z, kept)
        q = state_at_rest(links, pairs)
        quarter = np.pi / (2 * rate)
        moved, spun, slopes = _beside(links, q, pairs)
        columns = np.zeros((system.nx, 2 * size))
        columns[: system.nq, :size], columns[system.nq :, size:] = moved, spun
        found = flow(q, still, 0.0, quarter, EPS, max_steps=_STEPS, transition=columns, **parameters)
        if found.outcome != "done":
            return Evaluation(np.full(size, np.nan), np.full((size, size + 1), np.nan))
        ended, spins = found.q.reshape(links, 3), found.v.reshape(links, 3)
        speeds = np.cross(spins, ended)[:, :2]
        carried = inertia @ speeds
        across = np.stack([carried[:, 1], -carried[:, 0]], axis=1).ravel()
        across = across / np.linalg.norm(across)
        horizontal = np.asarray(found.transition[: system.nq]).reshape(links, 3, -1)[:, :2].reshape(size, -1)
        jacobian = np.column_stack([(horizontal[:, :size] @ slopes)[:, free], across, speeds.ravel() * (-quarter / rate)])
        residual = ended[:, :2].ravel() + z[-2] * across

        def maps() -> tuple[Multipliers, SpaceMap]:
            noise = np.abs(jacobian) @ np.abs(z) * (EPS * (1 + found.steps))
            turned = np.asarray(found.transition[system.nq :]).reshape(links, 3, -1)
            # Where the chain hangs straight dq' = d omega x e_3.
            rates = np.stack([turned[:, 1], -turned[:, 0]], axis=1).reshape(size, -1)
            root = np.linalg.cholesky(spun.T @ np.asarray(mass_of(q, **parameters)) @ spun)
            own = quarter_map(np.vstack([horizontal, rates]), speeds.ravel(), root, end_root, noise)
            about = np.cross([0.0, 0.0, 1.0], q.reshape(links, 3)).ravel()
            turn = root.T @ (moved.T @ about)
            space = SpaceMap(**vars(own), turning=turn / np.linalg.norm(turn))
            return space.kappa(), space

        return Evaluation(residual, jacobian, LateExtra(maps))

    def height(z: Vector) -> float:
        return float(sum(energy(state_at_rest(links, pairs_of(z, kept)), still, **parameters))) - bottom

    names = [f"{'theta' if k % 2 == 0 else 'across'}_{k // 2 + 1}" for k in free]
    return Problem(
        evaluate=evaluate, names=(*names, "unfolding", "omega"), scale=powers(np.append(np.ones(size), omega)), energy=height, error=frequency_error,
    )  # fmt: skip


def pairs_of(z: Vector, kept: int) -> Vector:
    """(a_1, b_1, a_2, b_2, ..) (2 N,) of unknowns."""
    links = len(z) // 2
    pairs = np.zeros(2 * links)
    pairs[::2] = z[:links]
    pairs[[2 * k + 1 for k in range(links) if k != kept]] = z[links : 2 * links - 1]
    return pairs


def closing_of(kept: int) -> str:
    """What a Branch says of how its orbits are closed."""
    return f"{METHOD}, in the plane link {kept + 1}"


def kept_of(closing: str) -> int:
    """The link, from 0, that starts in the plane y = 0, by that."""
    return int(closing.rpartition(" ")[2]) - 1


def state_at_rest(links: int, pairs: Vector) -> Vector:
    """q (3 N,) of (a_k, b_k)."""
    both = pairs.reshape(links, 2)
    rho = np.linalg.norm(both, axis=1)
    return np.column_stack([both * _sinc(rho)[:, None], np.cos(rho)]).ravel()


def _sinc(rho: Vector) -> Vector:
    return np.where(rho < _SMALL, 1 - rho**2 / 6, np.sin(rho) / np.where(rho > 0, rho, 1.0))


def _beside(links: int, q: Vector, pairs: Vector) -> tuple[Vector, Vector, Vector]:
    """Displacements and rates across every link (3 N, 2 N), as they belong to each other, and the first by (a, b) (2 N, 2 N)."""
    moved, spun, slopes = np.zeros((3 * links, 2 * links)), np.zeros((3 * links, 2 * links)), np.zeros((2 * links, 2 * links))
    for k, (link, (a, b)) in enumerate(zip(q.reshape(links, 3), pairs.reshape(links, 2), strict=True)):
        rho = float(np.hypot(a, b))
        ratio = float(_sinc(np.array([rho]))[0])
        # d ratio / d rho over rho.
        bend = (np.cos(rho) - ratio) / rho**2 if rho > 1e-2 else -1 / 3 + rho**2 / 30 - rho**4 / 840
        chart = np.array([[ratio + bend * a * a, bend * a * b], [bend * a * b, ratio + bend * b * b], [-ratio * a, -ratio * b]])
        basis, turns = np.linalg.qr(chart)
        # Of one handedness all along: determinants of the blocks are looked at.
        basis = basis * np.sign(np.diag(turns))
        here, there = slice(3 * k, 3 * k + 3), slice(2 * k, 2 * k + 2)
        moved[here, there] = basis
        # omega = q x q'.
        spun[here, there] = np.cross(link, basis.T).T
        slopes[there, there] = basis.T @ chart
    return moved, spun, slopes
