"""The Jacobian of Phi in closed form: O(N^2) kernels, where differentiating the loops column by column takes O(N^3).

With R_i the rows of Phi in absolute amplitudes B (`lowering.harmonic.balance`), D = B_i - B_j and c_ij = l_i mu_j (i < j),

    dR_i/dB_j = w^2 c_ij (2 s B_j - s' B_j^2 - a + a' B_j)
    dR_i/dB_i = w^2 (sum_(j != i) c_ij (s' B_j^2 - a' B_j) - c_ii - mu_i a'(B_i) X) + g mu_i h'(B_i)
    dR_i/dX   = -w^2 mu_i a(B_i),      dR_0/dB_j = -w^2 mu_j (a + a' B_j + 2 s B_j + s' B_j^2)(B_j)

and dPhi/dA = S^T (dR/dB) S + springs - w^2 rotors. a and s' are even in D, a' and s odd: a pair i < j serves both rows.
"""

from __future__ import annotations

from collections.abc import Callable

import sympy

from phichain.harmonic import kernels
from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.ir.from_sympy import from_sympy
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.planar.geared import terms as rotors
from phichain.lowering.planar.geared.joint_form import with_joints
from phichain.lowering.planar.joints import absolute
from phichain.lowering.writers import writes
from phichain.scene import Scene


@writes("phi_jacobian")
def phi_jacobian(
    builder: Builder, scene: Scene, parameters: Parameters, amplitude: ArrayRef, omega: ArrayRef, out: ArrayRef
) -> None:
    """Write dPhi/d(amplitude, omega), shape (nv, nv + 1)."""
    _Jacobian(builder, scene, parameters, amplitude, omega[0]).write(out)


class _Jacobian:
    def __init__(
        self, builder: Builder, scene: Scene, parameters: Parameters, amplitude: ArrayRef, omega: Expr
    ) -> None:
        self.builder, self.scene, self.parameters, self.omega = builder, scene, parameters, omega
        self.cart = amplitude[0] if scene.has_cart else None
        self.own = amplitude.shifted(int(scene.has_cart))
        self.swing = absolute(builder, scene, "swing", self.own)
        self.squared = builder.let("omega_squared", omega * omega)
        found = kernels()
        self._kernels = {
            "a": (found.acceleration, found.difference),
            "s": (found.centripetal, found.difference),
            "h": (found.gravity, found.amplitude),
        }

    def kernel(self, name: str, at: Expr, slope: bool = False) -> Expr:
        """One of the three kernels or its derivative."""
        expression, symbol = self._kernels[name]
        return from_sympy(self.builder, sympy.diff(expression, symbol) if slope else expression, {symbol: at})

    def write(self, out: ArrayRef) -> None:
        """The rows of the links, turned into the scene's angles, and the cart's."""
        scene, links = self.scene, self.scene.links
        width, first = scene.nv + 1, int(scene.has_cart)
        slope, rest = self._rows()
        by_angle, turned = (self.builder.array(name, links * links) for name in ("slope_by_angle", "slope_of_angles"))
        with self.builder.loop("i", 0, links) as loop:
            i = loop.index
            self._gathered(lambda j: slope[i * links + j], lambda j, value: by_angle.__setitem__(i * links + j, value))
        with self.builder.loop("m", 0, links) as loop:
            m = loop.index
            self._gathered(lambda i: by_angle[i * links + m], lambda i, value: turned.__setitem__(i * links + m, value))
        with_joints(
            self.builder, scene, self._joint_weight(), turned, out, lambda i, j: (i + first) * width + first + j
        )
        for column, values in rest.items():
            self._gathered(
                lambda i, values=values: values[i],  # type: ignore[misc]
                lambda i, value, column=column: out.__setitem__((i + first) * width + column, value),  # type: ignore[misc]
            )
        if self.cart is not None:
            self._cart_row(out, width, self.cart)

    def _gathered(self, read: Callable[[Index], Expr], write: Callable[[Index, Expr], None]) -> None:
        """S^T x of a vector x over the links: what `to_generalised` does to forces."""
        with self.builder.loop("k", self.scene.links - 1, -1, -1) as loop:
            k = loop.index
            value = own = read(k)
            if self.scene.angles != "absolute":
                beyond = loop.carry("beyond", 0)
                value = own + beyond
                loop.follow(beyond, own if self.scene.angles == "adjacent" else value)
            write(k, value)

    def _rows(self) -> tuple[ArrayRef, dict[int, ArrayRef]]:
        """dR_i/dB_j (N x N), and by column of the result dR_i/dX and dR_i/dw."""
        builder, links, parameters = self.builder, self.scene.links, self.parameters
        slope, own, value = self._pairs()
        diagonal, by_omega = builder.array("diagonal", links), builder.array("by_omega", links)
        by_cart = builder.array("by_cart", links) if self.cart is not None else None
        couple = rotors.couples(builder, self.scene, parameters, "rotor_couple", self.own)
        with builder.loop("i", 0, links) as loop:
            i = loop.index
            swing, mu = self.swing[i], parameters.mu[i]
            total, turn = self._summed(value, i), self._summed(own, i)
            total, turn = total - parameters.c_diagonal[i] * swing, turn - parameters.c_diagonal[i]
            if couple is not None:
                total = total - couple[i]
            if by_cart is not None and self.cart is not None:
                even = builder.let("own_kernel", self.kernel("a", swing))
                total = total - mu * (even * self.cart)
                turn = turn - mu * (self.kernel("a", swing, slope=True) * self.cart)
                by_cart[i] = -(self.squared * (mu * even))
            fall = parameters.gravity * mu * self.kernel("h", swing, slope=True)
            diagonal[i] = self.squared * turn + fall
            by_omega[i] = 2 * self.omega * total
        rest = {self.scene.nv: by_omega} | ({0: by_cart} if by_cart is not None else {})
        with builder.loop("i", 0, links) as loop:
            slope[loop.index * links + loop.index] = diagonal[loop.index]
        return slope, rest

    def _pairs(self) -> tuple[ArrayRef, ArrayRef, ArrayRef]:
        """For i != j, at i N + j: dR_i/dB_j, and what B_j adds to dR_i/dB_i and to R_i, the latter two over w^2."""
        builder, links = self.builder, self.scene.links
        names = ("pair_slope", "pair_own", "pair_value")
        slope, own, value = (builder.array(name, links * links) for name in names)
        with builder.loop("i", 0, links) as rows, builder.loop("j", rows.index + 1, links) as columns:
            i, j = rows.index, columns.index
            apart = builder.let("apart", self.swing[i] - self.swing[j])
            even, odd = builder.let("even", self.kernel("a", apart)), builder.let("odd", self.kernel("s", apart))
            even_slope = builder.let("even_slope", self.kernel("a", apart, slope=True))
            odd_slope = builder.let("odd_slope", self.kernel("s", apart, slope=True))
            couple = builder.let("couple", self.parameters.length[i] * self.parameters.mu[j])
            for row, column, sign in ((i, j, 1), (j, i, -1)):
                other, at = self.swing[column], row * links + column
                turning = odd_slope * other - sign * even_slope
                own[at] = couple * (turning * other)
                value[at] = couple * ((sign * odd * other - even) * other)
                slope[at] = self.squared * (couple * ((2 * sign) * odd * other - turning * other - even))
        return slope, own, value

    def _summed(self, parts: ArrayRef, i: Index) -> Expr:
        """The sum over j != i of what stands at i N + j."""
        with self.builder.loop("j", 0, i) as loop:
            inner = loop.carry("inner", 0)
            loop.follow(inner, inner + parts[i * self.scene.links + loop.index])
        with self.builder.loop("j", i + 1, self.scene.links) as loop:
            outer = loop.carry("outer", 0)
            loop.follow(outer, outer + parts[i * self.scene.links + loop.index])
        return inner + outer

    def _joint_weight(self) -> Callable[[Index], Expr] | None:
        """k_k - w^2 A_k of springs and rotors; None where there are none."""
        stiffness, armature = self.parameters.stiffness, self.parameters.armature
        if armature is None:
            return None if stiffness is None else stiffness.__getitem__

        def weight(k: Index) -> Expr:
            inertial = self.squared * armature[k]
            return -inertial if stiffness is None else stiffness[k] - inertial

        return weight

    def _cart_row(self, out: ArrayRef, width: int, cart: Expr) -> None:
        builder, links, mu = self.builder, self.scene.links, self.parameters.mu
        row = builder.array("cart_row", links)
        lean = self.parameters.total_mass * cart
        with builder.loop("j", 0, links) as loop:
            j = loop.index
            total = loop.carry("lean", lean)
            swing = self.swing[j]
            even, odd = self.kernel("a", swing), self.kernel("s", swing)
            even_slope, odd_slope = self.kernel("a", swing, slope=True), self.kernel("s", swing, slope=True)
            row[j] = -(self.squared * (mu[j] * (even + (even_slope + 2 * odd + odd_slope * swing) * swing)))
            loop.follow(total, total + mu[j] * ((even + odd * swing) * swing))
        out[0] = -(self.squared * self.parameters.total_mass)
        out[width - 1] = -(2 * self.omega * total)
        self._gathered(lambda j: row[j], lambda j, value: out.__setitem__(j + 1, value))
