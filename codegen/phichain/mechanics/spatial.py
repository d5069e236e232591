"""T, V and the equations (15) and (16)-(17) of a spatial chain as SymPy expressions in components.

Links are unit vectors q_k with q_k' = omega_k x q_k (17) and omega_k.q_k = 0. The Lagrangian and (15) are
written in q_k and its rates, (16) in omega_k. Signs and hats follow theory section 7 where the print slips.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import cached_property
from itertools import combinations
from typing import Any

import sympy

from phichain.contract.chain import LEAST_SQUARE
from phichain.mechanics.coefficients import Coefficients
from phichain.mechanics.symbols import ChainSymbols, Show, expression

_vector = sympy.ImmutableDenseMatrix

_DOWN = _vector([0, 0, 1])
"""e_3, along gravity."""


class SpatialExpressions:
    """The expressions of one spatial chain, each made when first asked for."""

    def __init__(self, chain: Coefficients, symbols: ChainSymbols, show: Show = expression) -> None:
        scene = self._scene = chain.scene
        self._symbols = symbols
        self._links = range(scene.links)
        self._mu = [show(entry) for entry in chain.mu]
        self._c = [[show(entry) for entry in row] for row in chain.c]
        self._total_mass = show(chain.total_mass)
        self._gravity = show(chain.gravity)
        self._stiffness = [show(entry) for entry in chain.stiffness]
        self._damping = [show(entry) for entry in chain.damping]
        self._cart_damping = show(chain.cart_damping)
        self._friction, self._cart_friction = [show(entry) for entry in chain.friction], show(chain.cart_friction)
        self._speeds = [show(Fraction(speed or 1)) for speed in (scene.friction_speed, scene.cart_friction_speed)]
        self._least = show(LEAST_SQUARE)
        self._q = [_vector(link) for link in symbols.links]
        self._omega = [_vector(rate) for rate in symbols.omega]

    @cached_property
    def kinetic(self) -> sympy.Expr:
        """T = 1/2 M00 |x'|^2 + x'.sum mu_k C^T q_k' + 1/2 sum c_ij q_i'.q_j'."""
        rates = self._symbols.link_rates
        terms = [self._c[k][k] * _dot(rates[k], rates[k]) / 2 for k in self._links]
        terms += [self._c[i][j] * _dot(rates[i], rates[j]) for i, j in combinations(self._links, 2)]
        speed = self._symbols.base_rate
        if speed:
            terms.append(self._total_mass * _dot(speed, speed) / 2)
            terms += [self._mu[k] * _dot(speed, [rates[k][axis] for axis in self._symbols.base_axes]) for k in self._links]
        return sympy.Add(*terms)

    @cached_property
    def potential(self) -> sympy.Expr:
        """V = -g sum mu_k e_3.q_k + sum k_k (1 - q_{k-1}.q_k), q_0 = e_3."""
        fall = [-self._gravity * self._mu[k] * self._q[k][2] for k in self._links]
        springs = [
            k * (1 - _dot(inner, outer))
            for k, inner, outer in zip(self._stiffness, [_DOWN, *self._q], self._q, strict=False)
        ]
        return sympy.Add(*fall, *springs)

    @cached_property
    def mass_matrix(self) -> sympy.ImmutableDenseMatrix:
        """The matrix of (16): M00 I_2, -mu_j C^T hat(q_j), mu_i hat(q_i) C, c_ii I_3, -c_ij hat(q_i) hat(q_j)."""
        hats = [_hat(link) for link in self._q]
        blocks = [
            [
                self._c[i][i] * sympy.eye(3) if i == j else -self._c[i][j] * hats[i] * hats[j]
                for j in self._links
            ]
            for i in self._links
        ]
        if self._symbols.cart:
            top = [-self._mu[j] * hats[j][:2, :] for j in self._links]
            blocks = [[block.T, *row] for block, row in zip(top, blocks, strict=True)]
            blocks = [[self._total_mass * sympy.eye(2), *top], *blocks]
        rows = [sympy.ImmutableDenseMatrix.hstack(*row) for row in blocks]
        return sympy.ImmutableDenseMatrix.vstack(*rows)

    @cached_property
    def coriolis(self) -> sympy.ImmutableDenseMatrix:
        """Velocity terms of (16): -sum mu_j |omega_j|^2 C^T q_j, -sum_{j != i} c_ij |omega_j|^2 q_i x q_j."""
        squares = [_dot(rate, rate) for rate in self._omega]
        inward = [square * link for square, link in zip(squares, self._q, strict=True)]
        cart = [-_sum(self._mu[j] * inward[j] for j in self._links)[:2, :]] if self._symbols.cart else []
        rows = [
            -self._q[i].cross(_sum(self._c[i][j] * inward[j] for j in self._links if j != i))
            for i in self._links
        ]
        return sympy.ImmutableDenseMatrix.vstack(*cart, *rows)

    @cached_property
    def gravity_torque(self) -> sympy.ImmutableDenseMatrix:
        """The gravity terms of (16): -mu_i g q_i x e_3."""
        cart = [sympy.zeros(2, 1)] if self._symbols.cart else []
        rows = [-self._mu[k] * self._gravity * self._q[k].cross(_DOWN) for k in self._links]
        return sympy.ImmutableDenseMatrix.vstack(*cart, *rows)

    @cached_property
    def joint_torque(self) -> sympy.ImmutableDenseMatrix:
        """What springs, dampers and dry friction ask for: couple_i = P_i (J_i - J_{i+1}), and d_0 x' of the cart,

        J_k = k_k q_{k-1} x q_k + d_k w + F_k tanh(|w| / v_0) w / |w|, w = omega_k - omega_{k-1}; P_i = I - q_i q_i^T only turns the neighbours'
        rates, the rest is orthogonal to q_i already.
        """
        still = sympy.zeros(3, 1)
        chain = [(_DOWN, still), *zip(self._q, self._omega, strict=True), (_DOWN, still)]
        couples = [self._across(k, k, *chain[k]) + self._across(k, k + 1, *chain[k + 2]) for k in self._links]
        drag = self._drag()
        cart = [sympy.Matrix(drag)] if drag else []
        return sympy.ImmutableDenseMatrix.vstack(*cart, *couples)

    def _across(self, k: int, joint: int, neighbour: Any, spin: Any) -> sympy.ImmutableDenseMatrix:
        """Return the couple of one joint on link k, towards the neighbour there; the tip has none."""
        if joint == len(self._links):
            return sympy.zeros(3, 1)
        link, rate = self._q[k], self._omega[k]
        slip = rate - spin + link * _dot(link, spin)
        resisted = self._damping[joint] + self._share(self._friction[joint], self._speeds[0], rate - spin)
        return self._stiffness[joint] * neighbour.cross(link) + resisted * slip

    def _drag(self) -> list[sympy.Expr]:
        """What resists the cart."""
        speed = self._symbols.cart_rate
        resisted = self._cart_damping + self._share(self._cart_friction, self._speeds[1], speed)
        return [resisted * rate for rate in speed]

    def _share(self, force: Any, v_0: Any, slip: Sequence[Any]) -> sympy.Expr:
        """F tanh(|w| / v_0) / |w|, with a little in the root as R has it."""
        if force == 0:
            return sympy.S.Zero
        ratio = sympy.sqrt(sympy.Add(*[y**2 for y in slip]) / v_0**2 + self._least)
        return force / v_0 * sympy.tanh(ratio) / ratio

    @cached_property
    def base_torque(self) -> sympy.ImmutableDenseMatrix:
        """What the acceleration b of a moving base asks for: mu_i q_i x b."""
        cart = [sympy.zeros(2, 1)] if self._symbols.cart else []
        return sympy.ImmutableDenseMatrix.vstack(
            *cart, *[mu * link.cross(self._given()) for mu, link in zip(self._mu, self._q, strict=True)]
        )

    def _given(self) -> sympy.ImmutableDenseMatrix:
        """b of a moving base, zero on others."""
        if not self._scene.is_moving:
            return sympy.zeros(3, 1)
        return _vector(self._symbols.along_base(self._symbols.base_acceleration))

    @cached_property
    def equations(self) -> tuple[sympy.Eq, ...]:
        """(16): M [x''; omega'] + velocity, gravity and joint terms = [u; 0], with (17); x'' = b for a driven cart."""
        accelerations = sympy.Matrix(self._symbols.a)
        left = self.mass_matrix * accelerations + self.coriolis + self.gravity_torque + self.joint_torque + self.base_torque
        left = [*self._symbols.cart_acceleration, *left[2:]] if self._scene.is_driven else left
        return tuple(sympy.Eq(a, b, evaluate=False) for a, b in zip(left, self._right(), strict=True))

    @cached_property
    def unit_vector_equations(self) -> tuple[sympy.Eq, ...]:
        """(15): M00 x'' + sum mu_k C^T q_k'' + d_0 x' = u, and for every link, with P_i = I - q_i q_i^T = -hat(q_i)^2,

        c_ii (q_i'' + |q_i'|^2 q_i) + P_i (mu_i C x'' + sum_{j != i} c_ij q_j'' - mu_i g e_3) + couple_i x q_i
        = 0,

        where couple_i is what the springs and dampers ask for, with omega_k = q_k x q_k'.
        """
        symbols, accelerations = self._symbols, [_vector(entry) for entry in self._symbols.link_accelerations]
        push = _vector([*symbols.cart_acceleration, 0]) if symbols.cart else self._given()
        rows: list[Any] = []
        if symbols.cart:
            sway = _sum(mu * entry for mu, entry in zip(self._mu, accelerations, strict=True))
            rows = [a + b for a, b in zip(self._total_mass * push + sway, self._drag(), strict=False)]
            if self._scene.is_driven:
                rows = list(symbols.cart_acceleration)
        rates = [_vector(rate) for rate in symbols.link_rates]
        spins = {
            entry: value
            for omega, link, rate in zip(self._omega, self._q, rates, strict=True)
            for entry, value in zip(omega, link.cross(rate), strict=True)
        }
        couples = self.joint_torque[len(rows) :, :].xreplace(spins)
        for i, link in enumerate(self._q):
            free = self._mu[i] * push - self._mu[i] * self._gravity * _DOWN
            free += _sum(self._c[i][j] * accelerations[j] for j in self._links if j != i)
            inward = _dot(rates[i], rates[i]) * link
            tangent = free - link * _dot(link, free)
            couple = _vector(couples[3 * i : 3 * i + 3, :])
            rows += list(self._c[i][i] * (accelerations[i] + inward) + tangent + couple.cross(link))
        return tuple(sympy.Eq(a, b, evaluate=False) for a, b in zip(rows, self._right(), strict=True))

    def _right(self) -> list[sympy.Expr]:
        """Return [u; 0]."""
        carts = list(self._symbols.force or (self._symbols.base_acceleration if self._scene.is_driven else ())) or [sympy.S.Zero] * len(self._symbols.cart)
        return carts + [sympy.S.Zero] * (3 * len(self._links))


def _dot(a: Sequence[Any], b: Sequence[Any]) -> sympy.Expr:
    return sympy.Add(*[x * y for x, y in zip(a, b, strict=True)])


def _hat(v: sympy.ImmutableDenseMatrix) -> sympy.ImmutableDenseMatrix:
    """Return the matrix of v x ."""
    return _vector([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def _sum(terms: Any) -> sympy.ImmutableDenseMatrix:
    return sum(terms, sympy.zeros(3, 1))
