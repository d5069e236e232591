"""States that the mirror image of their plane, run backwards, leaves as they are: links in one vertical plane, moving across it.

With theta_k the angle of link k from the hanging vertical and r_k its rate across the plane y = 0,

    q_k = (sin theta_k, 0, cos theta_k),   t_k = dq_k / d theta_k,   q_k' = r_k y,   omega_k = -r_k t_k.

Small motions beside one are, as in `conical.turning`, even (changes of theta and r, among these states) or odd (dq_k = b_k y, d omega_k = c_k y).
With c_kj the inertia between links and P_k = sum_j c_kj q_j' the area dq ^ dP of two even ones is zero, and so is that of two odd ones, for the
mirror image run backwards turns its sign: G = (even dq ^ dP odd) is all there is of it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from phichain.records import Held
from phichain.system import Parameters, System, Vector

_Y = np.array([0.0, 1.0, 0.0])


@dataclass(frozen=True, eq=False)
class Fixed(Held):
    """A state of links in the plane y = 0 that move across it.

    Attributes:
        x: State (q, omega) (6 N,).
        along: t_k (N, 3).
        even: State directions of theta and r (6 N, 2 N).
        odd: Those of b and c (6 N, 2 N).
    """

    x: Vector
    along: Vector
    even: Vector
    odd: Vector


def fixed(theta: Vector, rates: Vector) -> Fixed:
    """The state of angles, rad, and rates across the plane, rad/s, (N,) each."""
    links = len(theta)
    sine, cosine, flat = np.sin(theta), np.cos(theta), np.zeros(links)
    out, along = np.stack([sine, flat, cosine], axis=-1), np.stack([cosine, flat, -sine], axis=-1)
    even, odd = np.zeros((2, 6 * links, 2 * links))
    for k in range(links):
        here, there = slice(3 * k, 3 * k + 3), slice(3 * (links + k), 3 * (links + k) + 3)
        even[here, k], even[there, k] = along[k], rates[k] * out[k]
        even[there, links + k] = -along[k]
        odd[here, k] = odd[there, links + k] = _Y
    return Fixed(np.concatenate([out.ravel(), (-rates[:, None] * along).ravel()]), along, even, odd)


def nearest(x: Vector) -> Fixed:
    """The state of the kind that is beside x (6 N,), which is one but for a little."""
    directions, spins = np.split(x.reshape(-1, 3), 2)
    theta = np.arctan2(directions[:, 0], directions[:, 2])
    along = np.stack([np.cos(theta), np.zeros(len(theta)), -np.sin(theta)], axis=-1)
    return fixed(theta, -np.sum(along * spins, axis=1))


def read(at: Fixed, columns: Vector) -> tuple[Vector, Vector]:
    """Changes of (theta, r) and of (b, c) (2 N, m) of small motions (6 N, m)."""
    links = len(at.along)
    moved, turned = np.split(columns.reshape(2 * links, 3, -1), 2)
    angles = np.einsum("ki,kim->km", at.along, moved)
    rates = -np.einsum("ki,kim->km", at.along, turned)
    return np.vstack([angles, rates]), np.vstack([moved[:, 1], turned[:, 1]])


def inertia_of(system: System, p: Parameters | None) -> Vector:
    """c_kj (N, N), kg m^2: the inertia between links, read off the straight chain across itself."""
    hanging = np.zeros(system.nq)
    hanging[2::3] = 1.0
    return np.asarray(system.function("mass_matrix")(hanging, **system.parameters(p)))[::3, ::3]


def momenta(inertia: Vector, x: Vector, columns: Vector) -> Vector:
    """dP (3 N, m) of small motions (6 N, m) beside the state x (6 N,)."""
    links = len(inertia)
    directions, spins = np.split(x.reshape(-1, 3), 2)
    moved, turned = np.split(columns.reshape(2 * links, 3, -1), 2)
    speeds = np.cross(turned, directions[:, :, None], axis=1) + np.cross(spins[:, :, None], moved, axis=1)
    return np.einsum("kj,jim->kim", inertia, speeds).reshape(3 * links, -1)


def area(inertia: Vector, x: Vector, one: Vector, other: Vector) -> Vector:
    """dq ^ dP of small motions (6 N, m) and (6 N, l) beside x: (m, l)."""
    size = 3 * len(inertia)
    return one[:size].T @ momenta(inertia, x, other) - momenta(inertia, x, one).T @ other[:size]


def about_vertical(x: Vector) -> Vector:
    """G x (6 N,): the change of a state that is turned about the vertical at 1 rad/s."""
    triples = x.reshape(-1, 3)
    return np.stack([-triples[:, 1], triples[:, 0], np.zeros(len(triples))], axis=-1).ravel()


def turned(columns: Vector, angle: float) -> Vector:
    """States or small motions (6 N,) or (6 N, m), turned about the vertical."""
    triples = columns.reshape(len(columns) // 3, 3, -1)
    cosine, sine = np.cos(angle), np.sin(angle)
    found = np.stack([cosine * triples[:, 0] - sine * triples[:, 1], sine * triples[:, 0] + cosine * triples[:, 1], triples[:, 2]], axis=1)
    return found.reshape(columns.shape)
