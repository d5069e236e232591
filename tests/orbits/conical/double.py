"""The double spherical pendulum by another road: its Lagrangian from positions, in polar angles, and its relative equilibria in closed form."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import mpmath
import sympy as sp

G = sp.Rational(981, 100)


@dataclass(frozen=True)
class Double:
    """Two point masses in space: masses, lengths and centres of mass as decimal texts."""

    mass: tuple[str, str]
    length: tuple[str, str]
    com: tuple[str, str]

    @cached_property
    def pencil(self):
        """(theta, Omega) -> gradient of the amended potential (2,), and L_vv, L_vq - L_qv, L_qq (4, 4) of polar angles (theta, psi)."""
        theta, psi = sp.symbols("theta1:3"), sp.symbols("psi1:3")
        rates = sp.symbols("thetadot1:3") + sp.symbols("psidot1:3")
        omega = sp.Symbol("Omega")
        coordinates = [*theta, *psi]

        def direction(k):
            return sp.Matrix([sp.sin(theta[k]) * sp.cos(psi[k]), sp.sin(theta[k]) * sp.sin(psi[k]), sp.cos(theta[k])])

        lagrangian, joint = 0, sp.zeros(3, 1)
        for k in range(2):
            place = joint + sp.Rational(self.com[k]) * direction(k)
            speed = place.jacobian(coordinates) * sp.Matrix(rates)
            lagrangian += sp.Rational(self.mass[k]) * (speed.dot(speed) / 2 + G * place[2])
            joint = joint + sp.Rational(self.length[k]) * direction(k)
        at = {psi[0]: 0, psi[1]: 0, rates[0]: 0, rates[1]: 0, rates[2]: omega, rates[3]: omega}
        gradient = sp.Matrix([sp.diff(lagrangian, a) for a in theta]).subs(at)
        by_rate = sp.Matrix([sp.diff(lagrangian, r) for r in rates])
        second = by_rate.jacobian(rates).subs(at)
        mixed = by_rate.jacobian(coordinates).subs(at)
        position = sp.hessian(lagrangian, coordinates).subs(at)
        arguments = (*theta, omega)
        return [sp.lambdify(arguments, part, "mpmath") for part in (gradient, second, mixed - mixed.T, position)]

    def squares(self, theta1, theta2, omega):
        """s^2 of det(s^2 L_vv + s (L_vq - L_qv) - L_qq) = 0 without the turning itself: the roots of a cubic, its coefficients first."""
        _, second, gyro, position = (part(theta1, theta2, omega) for part in self.pencil)
        nodes = [mpmath.mpf(k) * omega for k in range(1, 4)]
        lead = mpmath.det(second)
        values = [mpmath.det(s**2 * second + s * gyro - position) / s**2 - lead * s**6 for s in nodes]
        matrix = mpmath.matrix([[s**4, s**2, 1] for s in nodes])
        rest = mpmath.lu_solve(matrix, mpmath.matrix(values))
        coefficients = [lead, *rest]
        return coefficients, mpmath.polyroots(coefficients, maxsteps=500, extraprec=200)

    def momentum(self, theta1, theta2, omega):
        """J = dL / d psi' summed."""
        _, second, *_ = (part(theta1, theta2, omega) for part in self.pencil)
        return omega * sum(second[i, j] for i in (2, 3) for j in (2, 3))

    def turning(self, a):
        """The relative equilibrium with sin(theta_2) = a sin(theta_1), or None: (theta_1, theta_2, Omega).

        g mu_i sin(theta_i) = Omega^2 cos(theta_i) sum_j c_ij sin(theta_j) give cos(theta_1) = L cos(theta_2), and the sines follow.
        """
        (m1, m2), (l1, _), (r1, r2) = (tuple(map(mpmath.mpf, pair)) for pair in (self.mass, self.length, self.com))
        g = mpmath.mpf(981) / 100
        mu1, mu2 = m1 * r1 + l1 * m2, m2 * r2
        c11, c12, c22 = m1 * r1**2 + l1**2 * m2, l1 * mu2, m2 * r2**2
        pull1, pull2 = c11 + c12 * a, c12 + c22 * a
        ratio = mu1 * pull2 / (mu2 * a * pull1)
        if 1 - (a * ratio) ** 2 == 0:
            return None
        square = (1 - ratio**2) / (1 - (a * ratio) ** 2)
        if not (0 < square < 1 and a**2 * square < 1):
            return None
        sine = mpmath.sqrt(square)
        cosine1 = mpmath.sign(pull1) * mpmath.sqrt(1 - square)
        cosine2 = mpmath.sign(ratio) * mpmath.sign(pull1) * mpmath.sqrt(1 - (a * sine) ** 2)
        omega = mpmath.sqrt(g * mu1 / (cosine1 * pull1))
        return mpmath.atan2(sine, cosine1), mpmath.atan2(a * sine, cosine2), omega
