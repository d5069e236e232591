"""The 2^n straight equilibria q_k = s_k e_d of a chain, with their energies and types (paper B).

On a cart each is a family, one for every place of the cart. Its type follows from the energy: V has a strict
minimum in the links' directions where its second variation G of (19) is positive definite, and a chain
started near such an equilibrium stays near (Lagrange and Dirichlet: T + V is a Lyapunov function; on a cart,
in all variables but its place). Each negative direction of G is a way to fall. Without springs G is s_k g
mu_k: only the hanging chain is stable.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from typing import Any

import sympy

from phichain.errors import UnsupportedError
from phichain.mechanics.coefficients import total
from phichain.mechanics.display import plain
from phichain.mechanics.lagrange import Model
from phichain.mechanics.linearization import checked
from phichain.mechanics.symbols import gravity, parameter
from phichain.scene.keys import label


@dataclass(frozen=True)
class Equilibrium:
    """One straight equilibrium.

    Attributes:
        signs: s_k, +1 for a hanging link, -1 for an upright one.
        energy: V there (J), exact.
        falling: In how many directions V falls from here (the Morse index of V), links only.
        neutral: In how many directions V is flat to second order.
        kind: "minimum", "saddle", "maximum" or "degenerate".
    """

    signs: tuple[int, ...]
    energy: Any
    falling: int
    neutral: int
    kind: str

    @property
    def is_stable(self) -> bool:
        """Whether the energy proves stability in the sense of Lyapunov."""
        return self.kind == "minimum"

    def __str__(self) -> str:
        arrows = "".join("v" if s > 0 else "^" for s in self.signs)
        return f"{arrows}  V = {plain(self.energy)} J  {self.kind}, {self.falling} falling directions"


def equilibria(model: Model) -> Iterator[Equilibrium]:
    """Yield all 2^n straight equilibria, the hanging one first, the fully upright one last.

    Raises:
        UnsupportedError: See `equilibrium`.
    """
    for signs in product((1, -1), repeat=model.scene.links):
        yield equilibrium(model, signs)


def equilibrium(model: Model, signs: Sequence[int]) -> Equilibrium:
    """Return the straight equilibrium of the given signs with its energy and type.

    Raises:
        ArrayError: There is not one sign +1 or -1 per link.
        UnsupportedError: A planar chain with springs has links upright, or springs that rest elsewhere than along the link
            before (no equilibrium: the springs pull), or
            gravity and springs are runtime parameters, so the type is not decided.
    """
    s = checked(model, signs)
    scene = model.scene
    if scene.rest_angle is not None:
        raise UnsupportedError(
            label("rest_angle"), scene.rest_angle, "leaves no vertical equilibrium: springs pull where the chain is straight",
            "solve gravity_torque + joint_torque = 0 for the angles, or remove it",
        )  # fmt: skip
    if scene.is_planar and scene.stiffness is not None and -1 in s:
        raise UnsupportedError("s", s, "is no equilibrium: planar springs pull upright links", "use all +1")
    weight, spring = gravity(scene), parameter(scene, "stiffness")
    align = [inner * outer for inner, outer in zip((1, *s), s, strict=False)]
    stiff = [0 * k if scene.is_planar else k * (1 - a) for k, a in zip(spring, align, strict=True)]
    energy = total([*(-weight * sign * mu for sign, mu in zip(s, model.mu, strict=True)), *stiff])
    fall = [weight * sign * mu for sign, mu in zip(s, model.mu, strict=True)]
    bend = spring if scene.is_planar else tuple(k * a for k, a in zip(spring, align, strict=True))
    falling, neutral = _inertia_of_joints(fall, bend)
    ways = 1 if scene.is_planar else 2
    return Equilibrium(s, energy, ways * falling, ways * neutral, _kind(falling, neutral, scene.links))


def _kind(falling: int, neutral: int, links: int) -> str:
    if neutral:
        return "degenerate"
    return "minimum" if falling == 0 else "maximum" if falling == links else "saddle"


def _inertia_of_joints(fall: Sequence[Any], spring: Sequence[Any]) -> tuple[int, int]:
    """Return how many negative and zero pivots diag(fall) + (joint form of the springs) has, exactly.

    The tridiagonal form is eliminated from the tip, which keeps its inertia (Sylvester). A zero pivot with a
    coupling c makes the block [[0, c], [c, e]], one negative and one positive direction.
    """
    negative = zero = 0
    inner_terms = list(zip(fall, spring, (*spring[1:], Fraction(0)), strict=True))
    pivot_correction: Any = Fraction(0)
    k = len(inner_terms) - 1
    while k >= 0:
        weight, own, outer = inner_terms[k]
        pivot = weight + own + outer - pivot_correction
        sign = _sign(pivot)
        coupling = own if k > 0 else Fraction(0)
        if sign == 0 and coupling != 0:
            negative, pivot_correction, k = negative + 1, Fraction(0), k - 2
            continue
        negative, zero = negative + (sign < 0), zero + (sign == 0)
        pivot_correction = coupling**2 / pivot if sign else Fraction(0)
        k -= 1
    return negative, zero


def _sign(value: Any) -> int:
    """Return the sign of an exact number or of an expression whose sign its symbols decide.

    Raises:
        UnsupportedError: The sign depends on the values of runtime parameters.
    """
    decided = sympy.sign(sympy.sympify(value))
    if decided in (-1, 0, 1):
        return int(decided)
    raise UnsupportedError(
        "gravity", value, "decides the type at run time", "give gravity and springs as numbers"
    )
