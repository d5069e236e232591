"""The linearisation (19) about the straight equilibria q_k = s_k e_d, s_k = +1 hanging, -1 upright.

    M x'' + D x' + G x = B u

Spatial coordinates are [x; C^T xi_1; ...] with delta q_k = xi_k x q_k and xi_k.e_3 = 0, planar ones [x; delta
theta]. In rotations of links the second variations of T and V give (theory section 3, with C^T hat(e_3) C =
J)

    M = [[M00 I_2, -s_j mu_j J], [s_i mu_i J, s_i s_j c_ij I_2]],  G_ii = s_i g mu_i I_2,
    J = [[0, -1], [1, 0]],

and in the plane M00, s_j mu_j, s_i s_j c_ij and s_i g mu_i, pulled back to the scene's angles. Springs add to
G and dampers make D, by the form sum_k w_k (xi_k - xi_{k-1})^2; dry friction F tanh(v / v_0) is a damper F / v_0 there, and that of
the cart with its damper D's first entry. A spatial spring counts with the sign s_{k-1}
s_k. A planar chain with springs has no equilibrium with links upright, nor anywhere vertical where springs rest elsewhere
(`rest_angle`), unless constant joint torques hold it: (19) then describes small motions about the held position.

Over a base that is given its acceleration, x'' = b holds by itself: M has nothing between cart and links, and B
has it instead, with the other sign. Up and down enters in second order only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import sympy

from phichain.errors import ArrayError
from phichain.mechanics.coordinates import pull_back, pull_back_matrix
from phichain.mechanics.lagrange import Model
from phichain.mechanics.symbols import Coefficient, cart_law, gravity, parameter
from phichain.scene import Scene

QUARTER_TURN = ((0, -1), (1, 0))
"""J = C^T hat(e_3) C, the cross product with e_3 seen in the horizontal plane."""


@dataclass(frozen=True)
class Linearization:
    """The matrices of (19), exact rationals or expressions in s_k and runtime parameters.

    Attributes:
        signs: s_1 .. s_N, numbers or symbols.
        M: Inertia, n x n, n = 2 N + 2 (spatial; 2 N on a fixed base) or nq (planar).
        D: Damping, n x n, zeros without dampers and dry friction.
        G: Stiffness of gravity and springs, n x n.
        B: Input, n x nu.
    """

    signs: tuple[Any, ...]
    M: sympy.ImmutableDenseMatrix
    D: sympy.ImmutableDenseMatrix
    G: sympy.ImmutableDenseMatrix
    B: sympy.ImmutableDenseMatrix


def linearize(model: Model, signs: Sequence[int] | None = None) -> Linearization:
    """Return (19) at the equilibrium of the given signs, or with the signs as symbols s_1 .. s_N.

    Raises:
        ArrayError: There is not one sign +1 or -1 per link.
    """
    scene = model.scene
    s = (
        tuple(sympy.Symbol(f"s_{k + 1}") for k in range(scene.links))
        if signs is None
        else checked(model, signs)
    )
    spring, damper = _sympy(parameter(scene, "stiffness")), _sympy(_slopes(scene))
    if not scene.is_planar:
        spring = [k * inner * outer for k, inner, outer in zip(spring, (1, *s), s, strict=False)]
    fall = [sign * _exact(gravity(scene)) * mu for sign, mu in zip(s, _sympy(model.mu), strict=True)]
    form = _joint_form(spring)
    stiff = [
        [entry + fall[i] if i == j else entry for j, entry in enumerate(row)] for i, row in enumerate(form)
    ]
    return Linearization(
        signs=s,
        M=_inertia(model, s),
        D=_with_drag(model, _in_coordinates(model, _joint_form(damper))),
        G=_in_coordinates(model, stiff),
        B=_input(model, s),
    )


def _slopes(scene: Scene) -> list[Coefficient]:
    """What joints resist per rate at rest: d_k + F_k / v_0."""
    pairs = zip(parameter(scene, "damping"), parameter(scene, "friction"), strict=True)
    return [d + force / Fraction(scene.friction_speed or 1) for d, force in pairs]


def _with_drag(model: Model, damping: sympy.ImmutableDenseMatrix) -> sympy.ImmutableDenseMatrix:
    """The same with d_0 + F_0 / v_0 on the cart's diagonal."""
    scene, carts = model.scene, len(model.symbols.cart)
    drag = cart_law(scene, "cart_damping") + cart_law(scene, "cart_friction") / Fraction(scene.cart_friction_speed or 1)
    matrix = sympy.Matrix(damping)
    for i in range(carts):
        matrix[i, i] = _exact(drag)
    return sympy.ImmutableDenseMatrix(matrix)


def checked(model: Model, signs: Sequence[int]) -> tuple[int, ...]:
    """Return the signs of an equilibrium as plain integers.

    Raises:
        ArrayError: There is not one sign +1 or -1 per link.
    """
    links = model.scene.links
    if len(signs) != links or any(s not in (-1, 1) for s in signs):
        raise ArrayError(
            "s", tuple(signs), "is no choice of signs", f"give +1 (hanging) or -1 (upright) {links} times"
        )
    return tuple(int(s) for s in signs)


def _inertia(model: Model, s: Sequence[Any]) -> sympy.ImmutableDenseMatrix:
    """Return M: the quadratic form of T in [x', xi'] at the equilibrium."""
    scene, links = model.scene, range(model.scene.links)
    # s_k^2 = 1 also where the signs are symbols.
    turns = [[_exact(model.c[i][j]) * (1 if i == j else s[i] * s[j]) for j in links] for i in links]
    inner = _in_coordinates(model, turns)
    if not scene.has_cart:
        return inner
    border = _border(model, s)
    carts = border.rows
    corner = sympy.eye(carts) * (1 if scene.is_driven else _exact(model.total_mass))
    if scene.is_driven:
        border = sympy.zeros(*border.shape)
    matrix = sympy.Matrix(inner)
    matrix[:carts, :carts], matrix[:carts, carts:], matrix[carts:, :carts] = corner, border, border.T
    return sympy.ImmutableDenseMatrix(matrix)


def _border(model: Model, s: Sequence[Any]) -> sympy.Matrix:
    """Return the part of M between horizontal motions of the base and the links."""
    mu = [sign * entry for sign, entry in zip(s, _sympy(model.mu), strict=True)]
    if model.scene.is_planar:
        return sympy.Matrix([pull_back(str(model.scene.angles), mu)])
    turn = sympy.Matrix(QUARTER_TURN)
    return sympy.Matrix.hstack(*[-entry * turn for entry in mu])


def _in_coordinates(model: Model, form: Sequence[Sequence[Any]]) -> sympy.ImmutableDenseMatrix:
    """Return a form in the links' rotations in the coordinates of (19): S^T F S or F times I_2, no cart."""
    scene = model.scene
    block = pull_back_matrix(str(scene.angles), form) if scene.is_planar else _doubled(form)
    carts = len(model.symbols.cart)
    matrix = sympy.zeros(carts + len(block), carts + len(block))
    matrix[carts:, carts:] = sympy.Matrix(block)
    return sympy.ImmutableDenseMatrix(matrix)


def _doubled(form: Sequence[Sequence[Any]]) -> list[list[Any]]:
    """Return the Kronecker product of a form and I_2."""
    return [[entry * int(a == b) for entry in row for b in (0, 1)] for row in form for a in (0, 1)]


def _joint_form(weights: Sequence[Any]) -> list[list[Any]]:
    """Return the matrix of sum_k w_k (xi_k - xi_{k-1})^2, xi_0 = 0, in absolute rotations."""
    links = range(len(weights))
    beyond = [*weights[1:], sympy.S.Zero]
    return [
        [
            weights[i] + beyond[i] if i == j else -weights[max(i, j)] if abs(i - j) == 1 else sympy.S.Zero
            for j in links
        ]
        for i in links
    ]


def _input(model: Model, s: Sequence[Any]) -> sympy.ImmutableDenseMatrix:
    """Return B: what drives the base, then the actuated angles; in space the rotations take no input."""
    scene = model.scene
    carts = len(model.symbols.cart)
    rows = carts + (1 if scene.is_planar else 2) * scene.links
    forces = sympy.Matrix(rows, len(scene.driven), lambda i, j: int(i == scene.driven[j]))
    if not scene.base_accelerations:
        return sympy.ImmutableDenseMatrix(forces)
    given = sympy.zeros(rows, scene.base_accelerations)
    border = _border(model, s)
    given[:carts, :carts] = sympy.eye(carts)
    for column, axis in enumerate(scene.told_axes):
        if axis < border.rows:
            given[carts:, column] = -border[axis, :].T
    return sympy.ImmutableDenseMatrix.hstack(given, forces)


def _exact(value: Any) -> sympy.Expr:
    """Return a coefficient as a SymPy number without rounding."""
    return sympy.sympify(value)


def _sympy(values: Sequence[Any]) -> list[sympy.Expr]:
    return [_exact(value) for value in values]
