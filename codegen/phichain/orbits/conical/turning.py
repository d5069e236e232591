"""A spatial chain that turns about the vertical with all its links in one vertical plane, and its motions beside that.

In the frame that turns at Omega with the plane y = 0, link k stands still at the angle theta_k from the hanging vertical,

    q_k = (sin theta_k, 0, cos theta_k),   t_k = dq_k / d theta_k = (cos theta_k, 0, -sin theta_k),
    omega_k = Omega (e_3 - (e_3.q_k) q_k) = -Omega sin theta_k t_k.

Seen from that frame the equations of motion are xi' = f(xi) - Omega G xi, G the turning about e_3, for f knows no direction. Small
motions have the coordinates

    dq_k = a_k t_k + b_k y,   d omega_k = d_k t_k + c_k y + Omega sin theta_k a_k q_k,

the last term keeping omega_k.q_k = 0. The mirror image of the plane, run backwards, is a motion of the chain again: it keeps (a, d) and
turns the signs of (b, c), so that the linear equations take each of the two pairs to the other.

A cart stands at (X, 0) and moves with Omega (0, X): its a, b, c, d belong to dx_1, dx_2, dx_1', dx_2'.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from phichain.records import Held
from phichain.system import System, Vector


@dataclass(frozen=True, eq=False)
class Turning(Held):
    """The chain of unknowns z = ([X,] theta_1 .. theta_N, Omega), in the frame that turns with it.

    Attributes:
        q: Configuration (nq,).
        v: Rates (nv,).
        even: State directions (nx, 2 n) of a and d; n = N, and one more on a cart.
        odd: Those of b and c (nx, 2 n).
        spun: G x (nx,): the state's rate of change when it is turned about e_3 at 1 rad/s.
        about: G (nx, nx).
    """

    q: Vector
    v: Vector
    even: Vector
    odd: Vector
    spun: Vector
    about: Vector

    @property
    def x(self) -> Vector:
        """State (nx,)."""
        return np.concatenate([self.q, self.v])

    @property
    def count(self) -> int:
        """n."""
        return self.even.shape[1] // 2

    @property
    def even_rows(self) -> Vector:
        """What reads a and d off a small motion (2 n, nx): d omega_k along q_k belongs to a_k and counts only once."""
        rows = self.even.copy()
        rows[len(self.q) :, : self.count] = 0.0
        return rows.T


def turning(system: System, z: Vector) -> Turning:
    """The chain at z."""
    carts, links, nq = system.cart_size, system.links, system.nq
    theta, rate = z[-1 - links : -1], float(z[-1])
    sine, cosine = np.sin(theta), np.cos(theta)
    flat = np.zeros(links)
    out = np.stack([sine, flat, cosine], axis=-1)
    along = np.stack([cosine, flat, -sine], axis=-1)
    q, v = np.zeros(nq), np.zeros(system.nv)
    q[carts:], v[carts:] = out.ravel(), (-rate * sine[:, None] * along).ravel()
    count = links + (carts > 0)
    even, odd = np.zeros((system.nx, 2 * count)), np.zeros((system.nx, 2 * count))
    if carts:
        q[0], v[1] = z[0], rate * z[0]
        even[0, 0] = even[nq + 1, count] = odd[1, 0] = odd[nq, count] = 1.0
    for k in range(links):
        here, column = slice(carts + 3 * k, carts + 3 * k + 3), k + (carts > 0)
        there = slice(nq + here.start, nq + here.stop)
        even[here, column] = even[there, count + column] = along[k]
        even[there, column] = rate * sine[k] * out[k]
        odd[here.start + 1, column] = odd[there.start + 1, count + column] = 1.0
    about = _about(carts, links)
    return Turning(q, v, even, odd, about @ np.concatenate([q, v]), about)


def _about(carts: int, links: int) -> Vector:
    """G: e_3 x on every triple, the same in the plane for a cart."""
    size = carts + 3 * links
    about = np.zeros((2 * size, 2 * size))
    for part in (0, size):
        firsts = [part] * (carts > 0) + [part + carts + 3 * k for k in range(links)]
        for first in firsts:
            about[first, first + 1], about[first + 1, first] = -1.0, 1.0
    return about
