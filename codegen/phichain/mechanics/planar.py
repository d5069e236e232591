"""T, V and the equations (15) of a planar chain as SymPy expressions in the scene's own angles.

With q_k = (sin phi_k, cos phi_k) the products of the general form become q_i'.q_j' = cos(phi_i - phi_j)
phi_i' phi_j' and C^T q_k' = cos(phi_k) phi_k', and phi = S theta throughout (theory section 2). In phi, row i
of the equations is

    sum_j c_ij [cos(phi_i - phi_j) phi_j'' + sin(phi_i - phi_j) phi_j'^2]
        + mu_i cos(phi_i) x'' + g mu_i sin(phi_i),

to which rotors add A_i (phi_i'' - phi_{i-1}'') - A_{i+1} (phi_{i+1}'' - phi_i''),

and the rows of theta are S^T times those. Nothing is simplified or expanded on the way.
"""

from __future__ import annotations

from fractions import Fraction
from functools import cached_property
from itertools import combinations

import sympy

from phichain.mechanics.coefficients import Coefficients
from phichain.mechanics.coordinates import (
    absolute_angles,
    joint_angles,
    joint_forces,
    pull_back,
    pull_back_matrix,
)
from phichain.mechanics.symbols import ChainSymbols, Show, expression

Expressions = tuple[sympy.Expr, ...]


class PlanarExpressions:
    """The expressions of one planar chain, each made when first asked for."""

    def __init__(self, chain: Coefficients, symbols: ChainSymbols, show: Show = expression) -> None:
        scene = chain.scene
        self._scene, self._symbols, self._angles = scene, symbols, str(scene.angles)
        self._links = range(scene.links)
        self._mu = [show(entry) for entry in chain.mu]
        self._c = [[show(entry) for entry in row] for row in chain.c]
        self._total_mass = show(chain.total_mass)
        self._gravity = show(chain.gravity)
        self._stiffness = [show(entry) for entry in chain.stiffness]
        self._damping = [show(entry) for entry in chain.damping]
        self._armature = [show(entry) for entry in chain.armature]
        self._friction = [show(entry) for entry in chain.friction]
        self._rest_angle = [show(entry) for entry in chain.rest_angle]
        self._cart_laws = show(chain.cart_damping), show(chain.cart_friction)
        self._speeds = [show(Fraction(speed or 1)) for speed in (scene.friction_speed, scene.cart_friction_speed)]

    @cached_property
    def phi(self) -> Expressions:
        """The absolute angles in terms of theta."""
        return absolute_angles(self._angles, self._symbols.theta)

    @cached_property
    def phi_dot(self) -> Expressions:
        """Their rates."""
        return absolute_angles(self._angles, self._symbols.theta_dot)

    @cached_property
    def phi_ddot(self) -> Expressions:
        """Their accelerations."""
        return absolute_angles(self._angles, self._symbols.theta_ddot)

    @cached_property
    def kinetic(self) -> sympy.Expr:
        """1/2 M00 x'^2 + x' sum mu_k cos(phi_k) phi_k' + 1/2 sum c_ij cos(phi_i - phi_j) phi_i' phi_j' + rotors; c for x' on a moving base."""
        rate = self.phi_dot
        terms = [self._c[i][i] * rate[i] ** 2 / 2 for i in self._links]
        terms += [self._c[i][j] * sympy.cos(self._difference(j, i)) * rate[i] * rate[j]
                  for i, j in combinations(self._links, 2)]  # fmt: skip
        for axis, speed in zip(self._symbols.base_axes, self._symbols.base_rate, strict=True):
            terms.append(self._total_mass * speed**2 / 2)
            terms += [speed * self._mu[k] * self._tangent(k)[axis] * rate[k] for k in self._links]
        slips = joint_angles(self._angles, self._symbols.theta_dot)
        terms += [rotor * slip**2 / 2 for rotor, slip in zip(self._armature, slips, strict=True)]
        return sympy.Add(*terms)

    @cached_property
    def potential(self) -> sympy.Expr:
        """V = -g sum mu_k cos(phi_k) + 1/2 sum k_k (phi_k - phi_{k-1} - alpha_k)^2."""
        fall = [-self._gravity * self._mu[k] * sympy.cos(self.phi[k]) for k in self._links]
        bends = self._bends
        springs = [k * bend**2 / 2 for k, bend in zip(self._stiffness, bends, strict=True)]
        return sympy.Add(*fall, *springs)

    @cached_property
    def mass_matrix(self) -> sympy.ImmutableDenseMatrix:
        """I of (15): S^T [c_ij cos(phi_i - phi_j) + rotors] S, bordered by M00 and mu_k cos(phi_k) on a cart."""
        cosines = [[self._c[i][j] * self._cosine(i, j) for j in self._links] for i in self._links]
        for k, rotor in enumerate(self._armature):
            cosines[k][k] += rotor
            if k:
                cosines[k - 1][k - 1] += rotor
                cosines[k][k - 1] -= rotor
                cosines[k - 1][k] -= rotor
        inertia = [list(row) for row in pull_back_matrix(self._angles, cosines)]
        for _ in self._symbols.cart:
            border = pull_back(self._angles, [self._mu[k] * sympy.cos(self.phi[k]) for k in self._links])
            inertia = [[self._total_mass, *border]] + [
                [b, *row] for b, row in zip(border, inertia, strict=True)
            ]
        return sympy.ImmutableDenseMatrix(inertia)

    @cached_property
    def coriolis(self) -> sympy.ImmutableDenseMatrix:
        """N of (15): sum_j c_ij sin(phi_i - phi_j) phi_j'^2; the cart's is -sum mu_k sin(phi_k) phi_k'^2."""
        rows = [
            sympy.Add(
                *[self._c[i][j] * self._sine(i, j) * self.phi_dot[j] ** 2 for j in self._links if j != i]
            )
            for i in self._links
        ]
        drag = [-self._mu[k] * sympy.sin(self.phi[k]) * self.phi_dot[k] ** 2 for k in self._links]
        cart = [sympy.Add(*drag) for _ in self._symbols.cart]
        return sympy.ImmutableDenseMatrix([*cart, *pull_back(self._angles, rows)])

    @cached_property
    def gravity_torque(self) -> sympy.ImmutableDenseMatrix:
        """G of (15): g mu_i sin(phi_i) pulled back; nothing on the cart."""
        rows = [self._gravity * self._mu[k] * sympy.sin(self.phi[k]) for k in self._links]
        cart = [sympy.S.Zero for _ in self._symbols.cart]
        return sympy.ImmutableDenseMatrix([*cart, *pull_back(self._angles, rows)])

    @cached_property
    def joint_torque(self) -> sympy.ImmutableDenseMatrix:
        """What springs, dampers and dry friction ask for, as forces of theta, and what resists the cart.

        Across joint k k_k bend_k + d_k bend_k' + F_k tanh(bend_k' / v_0), on the cart d_0 x' + F_0 tanh(x' / v_0).
        """
        rates = joint_angles(self._angles, self._symbols.theta_dot)
        speed, cart_speed = self._speeds
        laws = zip(self._stiffness, self._damping, self._friction, self._bends, rates, strict=True)
        moments = [k * bend + d * rate + f * sympy.tanh(rate / speed) for k, d, f, bend, rate in laws]
        damping, friction = self._cart_laws
        cart = [damping * rate + friction * sympy.tanh(rate / cart_speed) for rate in self._symbols.cart_rate]
        return sympy.ImmutableDenseMatrix([*cart, *joint_forces(self._angles, moments)])

    @property
    def _bends(self) -> list[sympy.Expr]:
        """What springs see: the joints' angles less those at which they rest."""
        bends = joint_angles(self._angles, self._symbols.theta)
        return [bend - rest for bend, rest in zip(bends, self._rest_angle, strict=True)]

    @cached_property
    def base_torque(self) -> sympy.ImmutableDenseMatrix:
        """What the acceleration b of a moving base asks for: mu_k b.(cos phi_k, -sin phi_k), pulled back."""
        given = self._symbols.along_base(self._symbols.base_acceleration) if self._scene.is_moving else ()
        rows = [
            sympy.Add(*[b * self._mu[k] * along for b, along in zip(given, self._tangent(k), strict=False)])
            for k in self._links
        ]
        cart = [sympy.S.Zero for _ in self._symbols.cart]
        return sympy.ImmutableDenseMatrix([*cart, *pull_back(self._angles, rows)])

    def _tangent(self, k: int) -> Expressions:
        """dq_k / dphi_k."""
        return sympy.cos(self.phi[k]), -sympy.sin(self.phi[k])

    @cached_property
    def equations(self) -> tuple[sympy.Eq, ...]:
        """(15): I a + N + G + joints = generalised force, one equation per coordinate; x'' = b for a driven cart."""
        symbols, scene = self._symbols, self._scene
        left = (
            self.mass_matrix * sympy.Matrix(symbols.a)
            + self.coriolis
            + self.gravity_torque
            + self.joint_torque
            + self.base_torque
        )
        push = {
            joint - 1: torque for joint, torque in zip(scene.actuated_joints, symbols.torque, strict=True)
        }
        carts = [symbols.force[0] if symbols.force else sympy.S.Zero for _ in symbols.cart]
        right = carts + [push.get(k, sympy.S.Zero) for k in self._links]
        if scene.is_driven:
            left, right = [*symbols.cart_acceleration, *left[1:]], [*symbols.base_acceleration, *right[1:]]
        return tuple(sympy.Eq(a, b, evaluate=False) for a, b in zip(left, right, strict=True))

    def _difference(self, i: int, j: int) -> sympy.Expr:
        return self.phi[i] - self.phi[j]

    def _cosine(self, i: int, j: int) -> sympy.Expr:
        return sympy.cos(self._difference(max(i, j), min(i, j)))

    def _sine(self, i: int, j: int) -> sympy.Expr:
        return sympy.sin(self._difference(i, j))
