"""How the spatial chain answers small forces and elongations: what Jacobians are made of (docs/theory.md, section 5).

With the joints' accelerations a and the multipliers s of the links as unknowns (`spatial.mobilities`), q_k and omega_k enter link k alone:
moved by dq and domega it is pushed at its ends by the pair of forces p = s dq and lengthened by e = -dq.(a' - a) - 2 l omega.domega.
A link hands a perturbation y of its joint's acceleration on as P y, and turns by omega' = J (P - I) y, J = q x / l, where

    P = alpha w v^T - kappa W,   w = W q,   alpha = 1 / q.w

With its joint held it answers (p, e) by the acceleration C p + alpha w e of its end, C = W - alpha w w^T, and by the force
(I - P)^T p + alpha v e on its joint. The mobility of a joint, all of the chain on both its sides included, is
Omega' = P Omega P^T + C from link to link, and that of the cart at the base.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from phichain.ir.builder import Expr, Index
from phichain.lowering.algebra.matrix import Matrix, minus, outer, plus, transposed
from phichain.lowering.algebra.vector import Vector, cross, scale


@dataclass(frozen=True)
class Link:
    """A link's answers.

    Attributes:
        q: its direction.
        inverse_length: 1 / l.
        axial: alpha.
        axis: w.
        stretch: v.
        turned_axis: J w.
        held: C.
        carried: -kappa W, None where the mass is at the link's end.
        multiplier: s.
    """

    q: Vector
    inverse_length: Expr
    axial: Expr
    axis: Vector
    stretch: Vector
    turned_axis: Vector
    held: Matrix
    carried: Matrix | None
    multiplier: Expr


class Answers(Protocol):
    """The answers of all links; `rank` is that of P."""

    rank: int

    def link(self, k: Index) -> Link:
        """The answers of link k."""

    def turned_before(self, k: Index) -> Vector:
        """J_k w_{k-1}, where P has rank one."""

    def base(self, cart_mass: Expr) -> Matrix:
        """The mobility of the cart."""


def turning(link: Link) -> Matrix:
    """J (P - I)."""
    x, y, z = scale(link.inverse_length, link.q)
    nothing = x.builder.lift(0)
    hat: Matrix = (nothing, -z, y), (z, nothing, -x), (-y, x, nothing)
    whole = minus(outer(scale(link.axial, link.turned_axis), link.stretch), hat)
    if link.carried is None:
        return whole
    return plus(whole, transposed(tuple(cross((x, y, z), column) for column in transposed(link.carried))))
