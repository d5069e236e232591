"""The planar angles as one linear map phi = S theta (theory section 2), and what it does to forces.

phi_k is the absolute angle of link k from the hanging vertical; theta_k is what the scene calls its angle:

* "absolute": phi_k = theta_k;
* "relative": phi_k = theta_1 + ... + theta_k, theta_k measured from link k-1 (what the text of paper A says);
* "adjacent": phi_k = theta_k + theta_{k-1} (what the formula below (14) of paper A says literally).

With phi = S theta forces pull back as tau_theta = S^T tau_phi and the inertia as M_theta = S^T M_phi S.
Everything here takes numbers, arrays or SymPy expressions alike, and costs O(N) for vectors.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import accumulate, pairwise
from operator import add
from typing import Any

Matrix = tuple[tuple[Any, ...], ...]


def angle_map(angles: str, links: int) -> tuple[tuple[int, ...], ...]:
    """Return S as zeros and ones, N x N: the identity, ones below the diagonal, or two diagonals."""
    reach = {"absolute": 0, "adjacent": 1, "relative": links}[angles]
    return tuple(tuple(int(0 <= i - j <= reach) for j in range(links)) for i in range(links))


def absolute_angles(angles: str, theta: Sequence[Any]) -> tuple[Any, ...]:
    """Return phi = S theta (rad); the same map takes rates, accelerations and amplitudes."""
    if angles == "absolute":
        return tuple(theta)
    if angles == "relative":
        return tuple(accumulate(theta))
    return (theta[0], *map(add, theta[1:], theta))


def scene_angles(angles: str, phi: Sequence[Any]) -> tuple[Any, ...]:
    """Return theta = S^-1 phi (rad)."""
    if angles == "absolute":
        return tuple(phi)
    if angles == "relative":
        return joint_angles("absolute", phi)
    return tuple(accumulate(phi, lambda inner, angle: angle - inner))


def joint_angles(angles: str, theta: Sequence[Any]) -> tuple[Any, ...]:
    """Return the deflection of every joint, phi_k - phi_{k-1} (rad), which springs and dampers see."""
    if angles == "relative":
        return tuple(theta)
    if angles == "absolute":
        return (theta[0], *(outer - inner for outer, inner in zip(theta[1:], theta, strict=False)))
    return (*theta[:2], *(outer - inner for outer, inner in zip(theta[2:], theta, strict=False)))


def pull_back(angles: str, force: Sequence[Any]) -> tuple[Any, ...]:
    """Return S^T force: generalised forces conjugate to phi (N m) turned into those conjugate to theta."""
    if angles == "absolute":
        return tuple(force)
    if angles == "relative":
        return tuple(accumulate(reversed(force)))[::-1]
    return (*map(add, force, force[1:]), force[-1])


def joint_forces(angles: str, moments: Sequence[Any]) -> tuple[Any, ...]:
    """Return the forces conjugate to theta of moments that act across the joints (N m).

    Joint k loads its outer link with moment k and its inner one with the opposite: tau_phi,k = T_k - T_{k+1}.
    """
    return pull_back(angles, couples(moments))


def couples(moments: Sequence[Any]) -> tuple[Any, ...]:
    """Return tau_phi,k = T_k - T_{k+1} (N m), the forces conjugate to phi of moments across the joints."""
    return (*(own - outer for own, outer in pairwise(moments)), moments[-1])


def pull_back_matrix(angles: str, matrix: Sequence[Sequence[Any]]) -> Matrix:
    """Return S^T matrix S, in O(N^2)."""
    half = [pull_back(angles, column) for column in zip(*matrix, strict=True)]
    return tuple(pull_back(angles, row) for row in zip(*half, strict=True))
