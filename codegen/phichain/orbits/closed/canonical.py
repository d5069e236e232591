"""Canonical coordinates of perturbations anywhere on a motion, and the pairs of multipliers of a symplectic
map, paired by construction.

With M the inertia of the angles (on a cart: what is left of it at no momentum), M = L L^T and G e = (dM e)
theta', a perturbation (e, e') of angles and rates is

    q~ = L^T e,   p~ = L^(-1) (M e' + G e),

canonical, for p = M theta'. So a map P between perturbations is symplectic there. Along an orbit of energy H
with the flow f it fixes f and dH = -J f: on the complement W of both, a complex subspace with (q~, p~) as q~
+ i p~, the rest of it is S = W^T P W, again symplectic, and

    kappa = (mu + 1/mu) / 2 = eig (S - J S^T J) / 2,

every one of them twice with two vectors, so that round-off moves it by no more than round-off.
"""

from __future__ import annotations

import numpy as np

from phichain.continuation.problem import Multipliers
from phichain.orbits.quarter import complement, ordered
from phichain.system import Parameters, System, Vector
from phichain.system.angles import scene_angles


def inertia_slopes(system: System, p: Parameters | None, q: Vector, v: Vector) -> tuple[Vector, Vector]:
    """M (nq, nq) at q, and (dM/dtheta_l) v as columns (nq, N), exactly.

    In the links' own angles phi the entries of M are constants times 1, cos(phi_k) and cos(phi_j - phi_k),
    and constants: half the difference of M a quarter turn of phi_l ahead and behind is the derivative of row
    and column l, without differencing.
    """
    mass_of, parameters, carts = system.function("mass_matrix"), system.parameters(p), system.cart_size
    links = system.links
    # theta = back phi.
    back = np.column_stack([scene_angles(system, axis) for axis in np.eye(links)])
    full = np.eye(system.nq)
    full[carts:, carts:] = back
    own = np.linalg.solve(full, v)
    slopes = np.empty((system.nq, links))
    for k in range(links):
        turn = np.zeros(system.nq)
        turn[carts:] = back[:, k] * (np.pi / 2)
        ahead, behind = (np.asarray(mass_of(q + sign * turn, **parameters)) for sign in (1.0, -1.0))
        beside = full.T @ (ahead - behind) @ full / 2
        at = carts + k
        row = beside[at].copy()
        row[at] = 0.0
        column = row * own[at]
        column[at] = row @ own
        slopes[:, k] = column
    # Columns along phi_k -> along theta_l, rows of phi -> rows of theta.
    turned = np.linalg.solve(full.T, slopes) @ np.linalg.inv(back)
    return np.asarray(mass_of(q, **parameters)), turned


def frame(system: System, p: Parameters | None, q: Vector, v: Vector) -> tuple[Vector, Vector]:
    """Canonical coordinates at a state of no momentum.

    Returns:
        (2 nq, 2 N): the perturbation of (q, v) that each canonical one is, the cart's place and momentum
        kept; and (2 N, 2 nq): the canonical coordinates of a perturbation.
    """
    carts, nq, links = system.cart_size, system.nq, system.links
    mass, slopes = inertia_slopes(system, p, q, v)
    share = -mass[:carts, carts:] / mass[0, 0] if carts else np.empty((0, links))
    inertia = mass[carts:, carts:] + mass[carts:, :carts] @ share
    bend = slopes[carts:] + share.T @ slopes[:carts]
    root = np.linalg.cholesky(inertia)
    inverse = np.linalg.inv(root)
    out = np.zeros((2 * nq, 2 * links))
    out[carts:nq, :links] = inverse.T
    out[nq + carts :, links:] = inverse.T
    out[nq + carts :, :links] = -inverse.T @ inverse @ bend @ inverse.T
    out[nq : nq + carts] = share @ out[nq + carts :]
    if carts:
        out[nq : nq + carts] -= slopes[:carts] @ out[carts:nq] / mass[0, 0]
    back = np.zeros((2 * links, 2 * nq))
    back[:links, carts:nq] = root.T
    back[links:, carts:nq] = inverse @ bend
    back[links:, nq + carts :] = root.T
    return out, back


def across(flow: Vector) -> Vector:
    """Orthonormal columns (2 N, 2 N - 2) across the flow and the energy's gradient, as canonical as the
    coordinates."""
    links = len(flow) // 2
    unit = flow[:links] + 1j * flow[links:]
    own = complement(unit / np.linalg.norm(unit))
    return np.block([[own.real, -own.imag], [own.imag, own.real]])


def pairs(symplectic: Vector) -> Multipliers:
    """kappa (k,) of a symplectic map (2 k, 2 k), the largest real part first."""
    half = len(symplectic) // 2
    a, b, c, d = symplectic[:half, :half], symplectic[:half, half:], symplectic[half:, :half], symplectic[half:, half:]
    both = np.block([[a + d.T, b - b.T], [c - c.T, d + a.T]]) / 2
    left = [complex(value) for value in np.linalg.eigvals(both)]
    found = []
    while left:
        one = left.pop()
        other = left.pop(int(np.argmin([abs(one - value) for value in left])))
        found.append((one + other) / 2)
    kappa = np.array(found, complex)
    return ordered(kappa)
