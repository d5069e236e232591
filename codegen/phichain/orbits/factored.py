"""Linear modes of a planar chain from factors of its inertia and stiffness, each frequency to its own last digits.

With x the sideways places of the masses (and of the cart) and phi the links' angles, small oscillations about hanging have

    T = x'^T W x' / 2,   V = |F phi|^2 / 2,   phi = C x,

W the masses, F the roots of g mu_k at the links and of the springs at the joints. The frequencies are the singular values of
F C W^(-1/2), every entry of which is a product of the scene's numbers or a sum without cancellation, so that it is right to
the last digits. Rows and columns are scaled over decades where masses and springs are, and one-sided Jacobi rotations find
the singular values of such a matrix to high relative accuracy, where an eigensolver loses the digits of the ratio of masses:
a light mass above a heavy one disappears in the sums of the inertia matrix.

A link with inertia moves as one with a point mass m' at its centre of percussion r' and another e at its joint, which belongs to
the link before or to the cart. From the tip, with e the mass that the next link leaves at this one's end,

    a = m r + l e,   b = m r^2 + J + l^2 e,   r' = b / a,   m' = a^2 / b,   e <- ((m + e) J + m e (l - r)^2) / b,

all sums of positive terms; gravity keeps pulling at the true masses.

Motors' rotors add |sqrt(A) D phi'|^2 / 2 with D phi the joints' angles. Then T = |G y'|^2 / 2 with y = W^(1/2) x and
G = [I; sqrt(A) D C W^(-1/2)] = Q R, and the matrix is F C W^(-1/2) R^(-1): R is no worse conditioned than rotors outweigh links,
whatever the springs are.

Source: J. Demmel, M. Gu, S. Eisenstat, I. Slapnicar, K. Veselic, Z. Drmac, Computing the singular value decomposition with
high relative accuracy, Linear Algebra Appl. 299 (1999) 21-80.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular
from scipy.linalg.lapack import dgejsv

from phichain.records import Held
from phichain.system import Parameters, System, Vector
from phichain.system.angles import scene_angles

_SCALED = 0
"""LAPACK's JOBA = C, of rows that fall in size: its F, whose accuracy is that of the matrix with scaled rows and columns, but for sorting them
itself, which wakes the threads of OpenBLAS for a matrix of two rows and costs up to milliseconds."""


@dataclass(frozen=True, eq=False)
class Chain(Held):
    """A planar chain that hangs stably, in numbers; rigid links as the point masses that move alike (theory section 1).

    Attributes:
        mass: m'_k (N,), positive: the mass itself without inertia.
        length: l_k (N,), positive.
        com: r'_k (N,), positive: where the mass is without inertia.
        short: (r'_k - l_k) / r'_k (N,).
        cart: What moves with the cart (1,), or nothing (0,).
        weight: g mu_k (N,), not negative.
        spring: k_k (N,), not negative; all of one of the two are positive.
        rotor: A_k (N,), not negative.
    """

    mass: Vector
    length: Vector
    com: Vector
    short: Vector
    cart: Vector
    weight: Vector
    spring: Vector
    rotor: Vector

    @classmethod
    def of(cls, system: System, p: Parameters | None) -> Chain | None:
        """The chain of a planar system; None where its numbers are not known, or it does not hang stably."""
        # A number that is not known is none, and no comparison below holds for it.
        given = np.empty((6, system.links))
        missing = np.nan if system.joints.armature is not None else 0.0, np.nan if system.numbers.inertia is not None else 0.0
        named = zip(("mass", "length", "com", "stiffness", "armature", "inertia"), (np.nan, np.nan, np.nan, 0.0, *missing), strict=True)
        for row, (name, default) in zip(given, named, strict=True):
            row[:] = system.number(name, p, default)
        mass, length, com, spring, rotor, inertia = given
        gravity, cart = system.number("gravity", p, np.nan), np.array([system.number("cart_mass", p, np.nan)] if system.cart_size else [])
        com = np.where(np.isnan(com), length, com)
        beyond = np.zeros_like(mass)
        beyond[:-1] = mass[:0:-1].cumsum()[::-1]
        weight = gravity * (mass * com + length * beyond)
        held = (weight > 0).all() or (spring > 0).all()
        if not (held and (weight >= 0).all() and (given[3:] >= 0).all()):
            return None
        with np.errstate(divide="ignore", invalid="ignore"):
            short = (com - length) / com
        if inertia.any():
            mass, com, short, left = _points(mass, length, com, inertia)
            cart = cart + left
        sizes = np.concatenate([mass, length, com, cart])
        if not ((sizes > 0) & np.isfinite(sizes)).all():
            return None
        return cls(mass, length, com, short, cart, weight, spring, rotor)

    def angles(self) -> Vector:
        """C (N, carts + N): the links' angles of sideways places of cart and masses.

        With s_k the place of joint k, phi_k = (x_k - s_k) / r_k and s_(k+1) = (l_k x_k - (l_k - r_k) s_k) / r_k: no sum.
        """
        carts, links = len(self.cart), len(self.mass)
        found, joint = np.zeros((links, carts + links)), np.zeros(carts + links)
        joint[:carts] = 1.0
        for k in range(links):
            found[k] = -joint / self.com[k]
            found[k, carts + k] = 1 / self.com[k]
            joint = joint * self.short[k]
            joint[carts + k] = self.length[k] / self.com[k]
        return found


def _points(mass: Vector, length: Vector, com: Vector, spin: Vector) -> tuple[Vector, Vector, Vector, float]:
    """Masses, places and (r - l) / r of the point masses that move as rigid links do, and the mass left at joint 0: no difference.

    A link that turns about its own centre of mass has its point at infinity, and no modes by this road.
    """
    point, place, short, left = np.zeros_like(mass), np.zeros_like(mass), np.zeros_like(mass), 0.0
    for k in reversed(range(len(mass))):
        m, l, r, own = mass[k], length[k], com[k], spin[k]
        first, second = m * r + l * left, m * r * r + own + l * l * left
        with np.errstate(divide="ignore", invalid="ignore"):
            point[k], place[k] = first * first / second, np.divide(second, first)
        short[k] = (own - m * r * (l - r)) / second
        left = (m * (own + left * (l - r) ** 2) + left * own) / second
    return point, place, short, left


def factored_modes(system: System, p: Parameters | None = None) -> tuple[Vector, Vector] | None:
    """Frequencies (k,), rad/s, rising, and shapes (nq, k) of a planar chain; None where `Chain.of` finds none."""
    chain = Chain.of(system, p)
    if chain is None:
        return None
    carts, links = len(chain.cart), len(chain.mass)
    angles, roots = chain.angles(), np.sqrt(np.concatenate([chain.cart, chain.mass]))
    bends = angles.copy()
    bends[1:] -= angles[:-1]
    rows = np.concatenate([np.sqrt(chain.weight)[:, None] * angles, np.sqrt(chain.spring)[:, None] * bends])
    rows, turned = rows / roots, np.eye(len(roots))
    if chain.rotor.any():
        triangle = np.linalg.qr(np.vstack([turned, np.sqrt(chain.rotor)[:, None] * bends / roots]), mode="r")
        rows, turned = (solve_triangular(triangle, part.T, trans="T").T for part in (rows, turned))
    falling = (-np.abs(rows).max(axis=1)).argsort(kind="stable")
    scaled, _, right, scale, _, failed = dgejsv(np.asfortranarray(rows[falling]), joba=_SCALED)
    if failed:
        return None
    omega = scaled * (scale[1] / scale[0])
    # The last of a cart's is its free translation.
    moving = np.arange(links)[::-1]
    places = turned @ right[:, moving] / roots[:, None]
    phi = angles @ places
    return omega[moving], np.concatenate([places[:carts], np.ascontiguousarray(scene_angles(system, phi.T).T)])
