"""Phi as it is read: with J_n instead of besselj, and scaled as paper A prints it for one and two links.

(21), one link:    2 g J_1(A_1) - r_1 omega^2 A_1 = 0                      is Phi_1 / (m_1 r_1);
(22), two links, relative angles                                         are -2 Phi_1 and 2 Phi_2 / (m_2 r_2).
"""

from __future__ import annotations

import sympy
from sympy.printing.str import StrPrinter

from phichain.errors import UnsupportedError
from phichain.harmonic.projection import OMEGA, check_projectable, phi_expressions
from phichain.mechanics.lagrange import derive
from phichain.scene import Scene

_GENERAL = (
    "Phi_i(phi) = omega^2 sum_j c_ij [-(J0(D) - J2(D)) B_j + 1/2 (J1(D) + J3(D)) B_j^2] + 2 g mu_i J1(B_i)"
)
_GENERAL_CART = " - omega^2 mu_i (J0(B_i) - J2(B_i)) X"
_CART = (
    "Phi_0      = -omega^2 M00 X"
    " - omega^2 sum_k mu_k [(J0(B_k) - J2(B_k)) B_k + 1/2 (J1(B_k) + J3(B_k)) B_k^2]"
)
_WRITTEN_OUT = 3
_PRINTED = (1, 2)


def printed_equations(links: int) -> tuple[sympy.Expr, ...]:
    """Return the left sides of (21) or (22) of paper A in m_k, l_k, r_k, g, A_k and omega, expanded.

    Raises:
        UnsupportedError: The paper prints one and two links only.
    """
    if links not in _PRINTED:
        raise UnsupportedError(
            "links", links, "is not printed in paper A", "use phi_expressions, which takes any N"
        )
    chain = Scene("printed", links, mass="runtime", length="runtime", com="runtime", gravity="runtime")
    phi = phi_expressions(derive(chain))
    outermost = sympy.Symbol(f"m_{links}", positive=True) * sympy.Symbol(f"r_{links}", positive=True)
    scales = (1 / outermost,) if links == 1 else (sympy.Integer(-2), 2 / outermost)
    return tuple(sympy.expand(scale * row) for scale, row in zip(scales, phi, strict=True))


def phi_text(scene: Scene) -> str:
    """Return Phi of a scene as text: its form for any N, short chains in full, (21) or (22) where they apply.

    Raises:
        UnsupportedError: The scene is spatial or damped.
    """
    check_projectable(scene)
    lines = [
        "theta_k = A_k cos(omega t), B = S A, D = B_i - B_j"
        + (", x = X cos(omega t)" if scene.has_cart else ""),
        *([_CART] if scene.has_cart else []),
        _GENERAL + (_GENERAL_CART if scene.has_cart else ""),
        "Phi(theta) = S^T Phi(phi)" + (" + k_k times the amplitude of joint k" if scene.stiffness else ""),
    ]
    if scene.links <= _WRITTEN_OUT:
        first = 0 if scene.has_cart else 1
        lines += [
            "",
            *(f"Phi_{k} = {bessel_text(row)}" for k, row in enumerate(phi_expressions(scene), start=first)),
        ]
    if (
        scene.links in _PRINTED
        and not scene.has_cart
        and scene.angles == "relative"
        and scene.stiffness is None
    ):
        number = 20 + scene.links
        lines += [
            "",
            *(f"({number}) 0 = {bessel_text(_gathered(row))}" for row in printed_equations(scene.links)),
        ]
    return "\n".join(lines)


def bessel_text(value: sympy.Expr) -> str:
    """Return an expression as text, Bessel functions as J0(z), J1(z), ..., decimals at their shortest."""
    return str(_BesselPrinter({"full_prec": False}).doprint(value))


def phi_latex(scene: Scene) -> str:
    """Return Phi = 0 of a scene as one aligned block of LaTeX.

    Raises:
        UnsupportedError: The scene is spatial or damped.
    """
    rows = " \\\\ ".join(f"{sympy.latex(row)} &= 0" for row in phi_expressions(scene))
    return f"\\begin{{aligned}}{rows}\\end{{aligned}}"


class _BesselPrinter(StrPrinter):
    """SymPy's text printer with the papers' J_n."""

    def _print_besselj(self, value: sympy.besselj) -> str:
        return f"J{value.order}({self._print(value.argument)})"


def _gathered(value: sympy.Expr) -> sympy.Expr:
    """Return an expanded row with the inertial terms behind omega^2 and the weights behind g."""
    return sympy.collect(value, [OMEGA**2, sympy.Symbol("g", positive=True)])
