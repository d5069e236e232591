"""The single-harmonic balance against the averaged Lagrangian: Phi_k = -2 d<L>/dA_k, with the Bessel functions as atoms.

Along theta = A cos tau, x = X cos tau, tau = omega t, integration by parts in the average over a period turns the first harmonic of the
equations of motion into a gradient. With B = S A, D = B_i - B_j and Jacobi and Anger's expansions

    <cos(D cos tau) sin^2 tau> = J_1(D) / D,    <cos(B cos tau)> = J_0(B),
    <L> = omega^2 / 2 [M00 X^2 / 2 + 2 X sum mu_k B_k K(B_k) + sum_ij c_ij B_i B_j K(B_i - B_j) + rotors] + g sum mu_k J_0(B_k) - springs / 2,

K(z) = J_1(z) / z, K(0) = 1/2, K'(z) = -J_2(z) / z. None of the kernels that `harmonic` projects takes part.
"""

from __future__ import annotations

from phichain.mechanics.coordinates import absolute_angles, joint_angles
from phichain.proof.case import Case, proves
from phichain.proof.modular.field import HALF, PRIME, Vector, dot
from phichain.proof.modular.points import Bessel
from phichain.proof.positions import Chain

Kernel = tuple[int, int, int]
"""K(z) = J_1(z) / z with its first two derivatives."""


def kernel_at(bessel: Bessel, z: int) -> Kernel:
    """K' = -J_2 / z = -z y; K'' = -J_1 / z + 3 J_2 / z^2 = 3 y - K, with K and y = J_2 / z^2 regular at zero."""
    value, y = bessel.shape(z)
    return value, -z * y % PRIME, 3 * y - value


class Averaged:
    """<L> of a chain at amplitudes and a frequency, differentiated along directions."""

    def __init__(self, chain: Chain, bessel: Bessel, amplitude: Vector, omega: int) -> None:
        """Evaluate the kernels at all B_k and B_i - B_j."""
        self._chain, self._omega, self._carts = chain, omega, chain.point.carts
        self._amplitude = amplitude
        self._swing = self._absolute(amplitude)
        links = range(len(self._swing))
        self._own = [kernel_at(bessel, z) for z in self._swing]
        self._pairs = [
            [kernel_at(bessel, (self._swing[i] - self._swing[j]) % PRIME) for j in range(i)] for i in links
        ]

    def _absolute(self, amplitude: Vector) -> Vector:
        angles = absolute_angles(str(self._chain.point.scene.angles), amplitude[self._carts :])
        return [entry % PRIME for entry in angles]

    def mixed(self, one: Vector, other: Vector | None, frequency: int) -> int:
        """d<L> along `one`; or, where there is a second direction, the derivative of that along (other, frequency)."""
        kinetic, slope = self._kinetic(one, other)
        kinetic += self._joints("armature", one, self._amplitude)
        slope += 0 if other is None else self._joints("armature", one, other)
        square = self._omega * self._omega
        if other is None:
            return (square * HALF * kinetic + self._weight(one, None) - self._springs(one, self._amplitude)) % PRIME
        inertial = square * HALF * slope + self._omega * frequency * kinetic
        return (inertial + self._weight(one, other) - self._springs(one, other)) % PRIME

    def _kinetic(self, one: Vector, other: Vector | None) -> tuple[int, int]:
        """The derivative of the bracket along `one`, and of that along `other`."""
        chain, carts, swing = self._chain, self._carts, self._swing
        second = other if other is not None else [0] * len(one)
        a, b = self._absolute(one), self._absolute(second)
        first, mixed, lengths = 0, 0, chain.per_link("length")
        for i, pairs in enumerate(self._pairs):
            # The kernel at D = 0 is 1/2; both orders of a pair count.
            first += chain.moments[i] * swing[i] * a[i]
            mixed += chain.moments[i] * b[i] * a[i]
            row, row_mixed = 0, 0
            for j, (value, slope, bend) in enumerate(pairs):
                product, apart = swing[i] * swing[j] % PRIME, a[i] - a[j]
                along = swing[i] * a[j] + a[i] * swing[j]
                row += lengths[j] * ((along * value + product * (slope * apart % PRIME)) % PRIME)
                if other is not None:
                    moved, across = b[i] - b[j], swing[i] * b[j] + b[i] * swing[j]
                    bent = slope * ((along * moved + across * apart) % PRIME)
                    both = (a[i] * b[j] + b[i] * a[j]) * value
                    row_mixed += lengths[j] * ((both + bent + product * (bend * (apart * moved % PRIME) % PRIME)) % PRIME)
            first += 2 * chain.mu[i] * (row % PRIME)
            mixed += 2 * chain.mu[i] * (row_mixed % PRIME)
        for cart in range(carts):
            place, shift, drift = self._amplitude[cart], one[cart], second[cart]
            first += chain.total_mass * place * shift
            mixed += chain.total_mass * drift * shift
            for k, (kernel, kernel_slope, kernel_bend) in enumerate(self._own):
                # f(B) = B K(B), f' = K + B K', f'' = 2 K' + B K''
                value, slope = swing[k] * kernel, kernel + swing[k] * kernel_slope
                bend = 2 * kernel_slope + swing[k] * kernel_bend
                first += 2 * chain.mu[k] * ((shift * value + place * slope * a[k]) % PRIME)
                turned = shift * slope * b[k] + drift * slope * a[k] + place * bend * a[k] * b[k]
                mixed += 2 * chain.mu[k] * (turned % PRIME)
        return first % PRIME, mixed % PRIME

    def _weight(self, one: Vector, other: Vector | None) -> int:
        """g sum mu_k J_0(B_k), J_0' = -z K, J_0'' = -K - z K'."""
        a, total = self._absolute(one), 0
        b = None if other is None else self._absolute(other)
        for k, ((value, bend, _), z, mu) in enumerate(zip(self._own, self._swing, self._chain.mu, strict=True)):
            slope = -z * value if b is None else -(value + z * bend) * b[k]
            total += mu * (slope * a[k] % PRIME)
        return self._chain.single("gravity") * (total % PRIME)

    def _springs(self, one: Vector, other: Vector) -> int:
        """The derivative of <springs> = 1/4 sum k_k bend_k^2 along `one`, at amplitudes `other`."""
        return HALF * self._joints("stiffness", one, other)

    def _joints(self, law: str, one: Vector, other: Vector) -> int:
        """sum law_k bend_k other_k of two vectors of amplitudes, at the joints."""
        angles = str(self._chain.point.scene.angles)
        bends, others = (joint_angles(angles, vector[self._carts :]) for vector in (one, other))
        return dot(self._chain.per_link(law), [a * b for a, b in zip(bends, others, strict=True)])


def _averaged(case: Case) -> tuple[Averaged, Vector, int]:
    """<L> at the amplitudes and the frequency of a point, made once for phi and its derivatives."""
    amplitude, omega = case.point.free("amplitude"), case.point.free("omega", 1)[0]
    if "averaged" not in case.chain.kept:
        case.chain.kept["averaged"] = Averaged(case.chain, case.point.bessel, amplitude, omega)
    return case.chain.kept["averaged"], amplitude, omega


@proves("phi")
def phi(case: Case) -> None:
    """Phi.one = -2 d<L> along one."""
    average, amplitude, omega = _averaged(case)
    out = case.run(case.point.given(amplitude=amplitude, omega=[omega]))["out"]
    case.zero("out", lambda one: dot(out, one) + 2 * average.mixed(one, None, 0), case.point.free("one"))


@proves("phi_jacobian")
def phi_jacobian(case: Case) -> None:
    """one^T (dPhi/dA other + dPhi/domega frequency) = -2 times the second derivative of <L>."""
    average, amplitude, omega = _averaged(case)
    other, frequency = case.point.free("other"), case.point.free("frequency", 1)[0]
    given = case.point.given(amplitude=amplitude, omega=[omega])
    column = case.times(given, {"out": [*other, frequency]})["out"]
    case.zero(
        "a row of out, out", lambda one: dot(column, one) + 2 * average.mixed(one, other, frequency), case.point.free("one")
    )
