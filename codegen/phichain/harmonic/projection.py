"""Phi: the equations of motion (15) projected on cos(omega t) along in-phase motion (17), for any N.

In-phase motion is theta_k = A_k cos(omega t), so phi_k = B_k cos(omega t) with B = S A, and on a cart x = X
cos(omega t). Put into (15), every term is cos or sin of (B_i - B_j) cos(omega t) times a trigonometric
polynomial. Its first Fourier coefficient needs three projections, which Jacobi-Anger closes in Bessel
functions (theory section 6); with D = B_i - B_j

    cos(D cos tau) cos tau    ->  a(D) = J_0(D) - J_2(D)
    sin(D cos tau) sin^2 tau  ->  s(D) = (J_1(D) + J_3(D)) / 2
    sin(B cos tau)            ->  2 J_1(B)

    Phi_i(phi) = omega^2 sum_j c_ij [-a(D) B_j + s(D) B_j^2] - omega^2 mu_i a(B_i) X + 2 g mu_i J_1(B_i)
    Phi_0      = -omega^2 M00 X - omega^2 sum_k mu_k [a(B_k) B_k + s(B_k) B_k^2]
    Phi(theta) = S^T Phi(phi) + springs,

the cart being a link of angle 0 that couples with mu_k. A spring adds k_k times the amplitude of its joint, a rotor -omega^2 A_k times it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

import sympy

from phichain.errors import UnsupportedError
from phichain.harmonic.series import COSINE, SINE_SQUARED, cosine_of, sine_of
from phichain.mechanics.coordinates import absolute_angles, joint_angles, joint_forces, pull_back
from phichain.mechanics.lagrange import Model, derive
from phichain.mechanics.symbols import expression, gravity, parameter
from phichain.scene import Scene

OMEGA = sympy.Symbol("omega", positive=True)
"""The frequency of the motion (rad/s)."""

_ORDER = 3
"""Harmonics beyond 1 + 2 cannot reach cos tau through sin^2 tau."""


@dataclass(frozen=True)
class Kernels:
    """The three projections as expressions, and the symbols they are written in.

    Attributes:
        difference: D = B_i - B_j, the difference of two links' amplitudes (rad); B_k for the cart's coupling.
        amplitude: B_i, a link's amplitude (rad).
        acceleration: a(D), to be multiplied by -omega^2 c_ij B_j.
        centripetal: s(D), to be multiplied by omega^2 c_ij B_j^2; it is odd in D.
        gravity: The projection of sin(B cos tau), to be multiplied by g mu_i.
    """

    difference: sympy.Symbol
    amplitude: sympy.Symbol
    acceleration: sympy.Expr
    centripetal: sympy.Expr
    gravity: sympy.Expr


@cache
def kernels() -> Kernels:
    """Return the three kernels, derived by projecting the Jacobi-Anger series on cos tau."""
    difference, amplitude = sympy.symbols("D B", real=True)
    return Kernels(
        difference=difference,
        amplitude=amplitude,
        acceleration=(cosine_of(difference, _ORDER) * COSINE).harmonic(1),
        centripetal=(sine_of(difference, _ORDER) * SINE_SQUARED).harmonic(1),
        gravity=sine_of(amplitude, _ORDER).harmonic(1),
    )


def amplitude_symbols(scene: Scene) -> tuple[sympy.Symbol, ...]:
    """Return the amplitudes in the contract's order: X (m) on a cart, then A_1 .. A_N (rad)."""
    cart = (sympy.Symbol("X", real=True),) if scene.has_cart else ()
    return cart + tuple(sympy.Symbol(f"A_{k}", real=True) for k in range(1, scene.links + 1))


def phi_expressions(of: Scene | Model) -> tuple[sympy.Expr, ...]:
    """Return Phi of a planar, undamped scene: Phi_0 (N) on a cart, then Phi_1 .. Phi_N (N m) of its angles.

    They are expressions in the `amplitude_symbols` and OMEGA; Phi = 0 is the single-harmonic balance of the
    unforced chain, whose orbits paper A calls limit cycles.

    Raises:
        UnsupportedError: The scene is spatial or damped.
    """
    model = of if isinstance(of, Model) else derive(of)
    scene = model.scene
    check_projectable(scene)
    symbols = amplitude_symbols(scene)
    carts = len(symbols) - scene.links
    return _Projection(model, symbols[:carts], symbols[carts:]).rows()


def check_projectable(scene: Scene) -> None:
    """Refuse scenes without an in-phase motion.

    Raises:
        UnsupportedError: The scene is spatial or damped.
    """
    if not scene.is_planar:
        raise UnsupportedError(
            "space",
            scene.space,
            "has no scalar amplitude per link",
            "trace periodic orbits of its forward_dynamics",
        )
    if scene.damping is not None:
        raise UnsupportedError(
            "damping",
            scene.damping,
            "leaves no in-phase periodic motion",
            "remove it, or simulate forward_dynamics",
        )


class _Projection:
    """Phi of one model at given amplitudes, as lists of terms that are added once at the end."""

    def __init__(self, model: Model, cart: tuple[Any, ...], theta: tuple[Any, ...]) -> None:
        scene = model.scene
        self._angles, self._cart, self._theta = str(scene.angles), cart, theta
        self._links = range(scene.links)
        self._mu = [expression(entry) for entry in model.mu]
        self._c = [[expression(entry) for entry in row] for row in model.c]
        self._total_mass = expression(model.total_mass)
        self._gravity = expression(gravity(scene))
        self._stiffness = [expression(entry) for entry in parameter(scene, "stiffness")]
        self._armature = [expression(entry) for entry in parameter(scene, "armature")]
        self._B = absolute_angles(self._angles, theta)

    def rows(self) -> tuple[sympy.Expr, ...]:
        """Return Phi_0 on a cart, then S^T Phi(phi) plus springs and rotors."""
        bends = joint_angles(self._angles, self._theta)
        held = zip(self._stiffness, self._armature, bends, strict=True)
        springs = joint_forces(self._angles, [(k - rotor * OMEGA**2) * bend for k, rotor, bend in held])
        links = pull_back(self._angles, [self._link(i) for i in self._links])
        balance = [sympy.Add(*self._horizontal(X)) for X in self._cart]
        return (*balance, *(sympy.Add(*terms, spring) for terms, spring in zip(links, springs, strict=True)))

    def _link(self, i: int) -> tuple[sympy.Expr, ...]:
        """Return the terms of Phi_i(phi)."""
        B = self._B
        own = -self._c[i][i] * OMEGA**2 * B[i]
        inner = [self._c[i][j] * OMEGA**2 * self._inertia(i, j, 1) for j in range(i)]
        outer = [self._c[i][j] * OMEGA**2 * self._inertia(j, i, -1) for j in self._links[i + 1 :]]
        coupled = [-self._mu[i] * OMEGA**2 * self._kernel(i, None)[0] * X for X in self._cart]
        weight = self._gravity * self._mu[i] * kernels().gravity.xreplace({kernels().amplitude: B[i]})
        return (own, *inner, *outer, *coupled, weight)

    def _horizontal(self, X: Any) -> list[sympy.Expr]:
        """Return the terms of Phi_0, the balance of the horizontal force: D = 0 - B_k."""
        kernel = [self._kernel(k, None) for k in self._links]
        coupled = [
            -self._mu[k] * OMEGA**2 * (acceleration * self._B[k] + centripetal * self._B[k] ** 2)
            for k, (acceleration, centripetal) in enumerate(kernel)
        ]
        return [-self._total_mass * OMEGA**2 * X, *coupled]

    def _inertia(self, outer: int, inner: int, sign: int) -> sympy.Expr:
        """Return -a(D) B_j + s(D) B_j^2 for D = sign (B_outer - B_inner); j is the other link of Phi_i."""
        acceleration, centripetal = self._kernel(outer, inner)
        B = self._B[inner if sign > 0 else outer]
        return -acceleration * B + sign * centripetal * B**2

    def _kernel(self, outer: int, inner: int | None) -> tuple[sympy.Expr, sympy.Expr]:
        """Return a(D), s(D) at D = B_outer - B_inner, or at B_outer; a is even, s odd: a pair has one.

        SymPy writes J_n(-z) with quotients of powers of z, so the argument is turned to the side it leaves
        alone.
        """
        if (outer, inner) not in self._kernels:
            D = self._B[outer] - (0 if inner is None else self._B[inner])
            turned = D.could_extract_minus_sign()
            at = {kernels().difference: -D if turned else D}
            acceleration, centripetal = (
                kernel.xreplace(at) for kernel in (kernels().acceleration, kernels().centripetal)
            )
            self._kernels[outer, inner] = (acceleration, -centripetal if turned else centripetal)
        return self._kernels[outer, inner]

    @cached_property
    def _kernels(self) -> dict[tuple[int, int | None], tuple[sympy.Expr, sympy.Expr]]:
        return {}
