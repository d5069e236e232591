"""How a Model prints: as text for a terminal, as LaTeX for a notebook or a paper."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Protocol

import sympy

from phichain.mechanics.symbols import expression
from phichain.scene import Scene

_WRITTEN_OUT = {"planar": 3, "spatial": 1}
"""Up to how many links the equations are printed in full."""

_COLUMNS = 6
"""How many coefficients of a row are printed."""

_ANGLES = {
    "absolute": "phi_k = theta_k",
    "relative": "phi_k = theta_1 + ... + theta_k",
    "adjacent": "phi_k = theta_k + theta_{k-1}",
}


class Mechanics(Protocol):
    """What is printed of a `Model`."""

    @property
    def scene(self) -> Scene: ...
    @property
    def mu(self) -> tuple[Any, ...]: ...
    @property
    def c(self) -> tuple[tuple[Any, ...], ...]: ...
    @property
    def total_mass(self) -> Any: ...
    @property
    def kinetic(self) -> sympy.Expr: ...
    @property
    def potential(self) -> sympy.Expr: ...
    @property
    def equations(self) -> tuple[sympy.Eq, ...]: ...


@dataclass(frozen=True)
class _Forms:
    """The pieces of T, V and one link's equation in index form; what the scene lacks is left out."""

    kinetic: str
    kinetic_cart: str
    potential: str
    springs: str
    equation: str
    equation_cart: str
    equation_joints: str
    joint: str
    joint_springs: str
    joint_dampers: str
    joint_friction: str
    cart_row: str
    cart_damper: str
    cart_friction: str
    bend: str
    """What springs see of a joint whose spring rests along the link before."""
    rest: str
    """What is subtracted where it does not."""
    driven_row: str
    kinetic_moving: str
    equation_moving: str
    kinetic_rotors: str = ""
    joint_rotors: str = ""
    directions: tuple[str, str, str, str, str] | None = None
    """The same equation in q_i'' alone, (15) of paper B: its head, what a cart or a moving base adds, its end, what joints add."""


_TEXT = {
    "planar": _Forms(
        kinetic="T = 1/2 sum_ij c_ij cos(phi_i - phi_j) phi_i' phi_j'",
        kinetic_cart=" + x' sum_k mu_k cos(phi_k) phi_k' + 1/2 M00 x'^2",
        potential="V = -g sum_k mu_k cos(phi_k)",
        springs=" + 1/2 sum_k k_k (phi_k - phi_{k-1})^2",
        equation="tau_i = sum_j c_ij [cos(phi_i - phi_j) phi_j'' + sin(phi_i - phi_j) phi_j'^2]"
        " + g mu_i sin(phi_i)",
        equation_cart=" + mu_i cos(phi_i) x''",
        equation_joints=" + J_i - J_{i+1}",
        joint="J_k =",
        joint_springs=" + k_k (phi_k - phi_{k-1})",
        joint_dampers=" + d_k (phi_k' - phi_{k-1}')",
        joint_friction=" + F_k tanh((phi_k' - phi_{k-1}') / v_0)",
        cart_row="F = M00 x'' + sum_k mu_k [cos(phi_k) phi_k'' - sin(phi_k) phi_k'^2]",
        kinetic_rotors=" + 1/2 sum_k A_k (phi_k' - phi_{k-1}')^2",
        joint_rotors=" + A_k (phi_k'' - phi_{k-1}'')",
        cart_damper=" + d_0 x'",
        cart_friction=" + F_0 tanh(x' / v_0)",
        bend="(phi_k - phi_{k-1})",
        rest=" - alpha_k",
        driven_row="x'' = b",
        kinetic_moving=" + sum_k mu_k (c_1 cos(phi_k) - c_2 sin(phi_k)) phi_k' + 1/2 M00 |c|^2",
        equation_moving=" + mu_i (b_1 cos(phi_i) - b_2 sin(phi_i))",
    ),
    "spatial": _Forms(
        kinetic="T = 1/2 sum_ij c_ij q_i'.q_j'",
        kinetic_cart=" + x'.sum_k mu_k C^T q_k' + 1/2 M00 |x'|^2",
        potential="V = -g sum_k mu_k e_3.q_k",
        springs=" + sum_k k_k (1 - q_{k-1}.q_k)",
        equation="0 = c_ii omega_i' - sum_{j != i} c_ij q_i x (q_j x omega_j' + |omega_j|^2 q_j)"
        " - g mu_i q_i x e_3",
        equation_cart=" + mu_i q_i x C x''",
        equation_joints=" + (I - q_i q_i^T) (J_i - J_{i+1})",
        joint="J_k =",
        joint_springs=" + k_k q_{k-1} x q_k",
        joint_dampers=" + d_k (omega_k - omega_{k-1})",
        joint_friction=" + F_k tanh(|w_k| / v_0) w_k / |w_k|, w_k = omega_k - omega_{k-1}",
        cart_row="u = M00 x'' + sum_k mu_k C^T q_k''",
        cart_damper=" + d_0 x'",
        cart_friction=" + F_0 tanh(|x'| / v_0) x' / |x'|",
        bend="",
        rest="",
        driven_row="x'' = b",
        kinetic_moving=" + c.sum_k mu_k q_k' + 1/2 M00 |c|^2",
        equation_moving=" + mu_i q_i x b",
        directions=(
            "0 = c_ii (q_i'' + |q_i'|^2 q_i) + (I - q_i q_i^T) (sum_{j != i} c_ij q_j'' - g mu_i e_3",
            " + mu_i C x''",
            " + mu_i b",
            ")",
            " + (J_i - J_{i+1}) x q_i",
        ),
    ),
}

_LATEX = {
    "planar": _Forms(
        kinetic=r"T &= \tfrac12 \sum_{i,j} c_{ij} \cos(\phi_i - \phi_j)\, \dot\phi_i \dot\phi_j",
        kinetic_cart=r" + \dot x \sum_k \mu_k \cos(\phi_k)\, \dot\phi_k + \tfrac12 M_{00} \dot x^2",
        potential=r"V &= -g \sum_k \mu_k \cos\phi_k",
        springs=r" + \tfrac12 \sum_k k_k (\phi_k - \phi_{k-1})^2",
        equation=r"\tau_i &= \sum_j c_{ij} \left[\cos(\phi_i - \phi_j)\, \ddot\phi_j"
        r" + \sin(\phi_i - \phi_j)\, \dot\phi_j^2\right] + g \mu_i \sin\phi_i",
        equation_cart=r" + \mu_i \cos(\phi_i)\, \ddot x",
        equation_joints=" + J_i - J_{i+1}",
        joint="J_k &=",
        joint_springs=r" + k_k (\phi_k - \phi_{k-1})",
        joint_dampers=r" + d_k (\dot\phi_k - \dot\phi_{k-1})",
        joint_friction=r" + F_k \tanh\frac{\dot\phi_k - \dot\phi_{k-1}}{v_0}",
        cart_row=r"F &= M_{00} \ddot x + \sum_k \mu_k \left[\cos(\phi_k)\, \ddot\phi_k - \sin(\phi_k)\, \dot\phi_k^2\right]",
        kinetic_rotors=r" + \tfrac12 \sum_k A_k (\dot\phi_k - \dot\phi_{k-1})^2",
        joint_rotors=r" + A_k (\ddot\phi_k - \ddot\phi_{k-1})",
        cart_damper=r" + d_0 \dot x",
        cart_friction=r" + F_0 \tanh\frac{\dot x}{v_0}",
        bend=r"(\phi_k - \phi_{k-1})",
        rest=r" - \alpha_k",
        driven_row=r"\ddot x &= b",
        kinetic_moving=r" + \sum_k \mu_k (c_1 \cos\phi_k - c_2 \sin\phi_k)\, \dot\phi_k + \tfrac12 M_{00} \|c\|^2",
        equation_moving=r" + \mu_i (b_1 \cos\phi_i - b_2 \sin\phi_i)",
    ),
    "spatial": _Forms(
        kinetic=r"T &= \tfrac12 \sum_{i,j} c_{ij}\, \dot q_i \cdot \dot q_j",
        kinetic_cart=r" + \dot x \cdot \sum_k \mu_k C^T \dot q_k + \tfrac12 M_{00} \|\dot x\|^2",
        potential=r"V &= -g \sum_k \mu_k\, e_3 \cdot q_k",
        springs=r" + \sum_k k_k (1 - q_{k-1} \cdot q_k)",
        equation=r"0 &= c_{ii} \dot\omega_i - \sum_{j \ne i} c_{ij}\, q_i \times"
        r" \left(q_j \times \dot\omega_j + \|\omega_j\|^2 q_j\right) - g \mu_i\, q_i \times e_3",
        equation_cart=r" + \mu_i\, q_i \times C \ddot x",
        equation_joints=r" + (I - q_i q_i^T)(J_i - J_{i+1})",
        joint="J_k &=",
        joint_springs=r" + k_k\, q_{k-1} \times q_k",
        joint_dampers=r" + d_k (\omega_k - \omega_{k-1})",
        joint_friction=r" + F_k \tanh\frac{\|w_k\|}{v_0} \frac{w_k}{\|w_k\|},\ w_k = \omega_k - \omega_{k-1}",
        cart_row=r"u &= M_{00} \ddot x + \sum_k \mu_k C^T \ddot q_k",
        cart_damper=r" + d_0 \dot x",
        cart_friction=r" + F_0 \tanh\frac{\|\dot x\|}{v_0} \frac{\dot x}{\|\dot x\|}",
        bend="",
        rest="",
        driven_row=r"\ddot x &= b",
        kinetic_moving=r" + c \cdot \sum_k \mu_k\, \dot q_k + \tfrac12 M_{00} \|c\|^2",
        equation_moving=r" + \mu_i\, q_i \times b",
        directions=(
            (
                r"0 &= c_{ii} (\ddot q_i + \|\dot q_i\|^2 q_i)"
                r" + (I - q_i q_i^T) \Big(\sum_{j \ne i} c_{ij} \ddot q_j - g \mu_i e_3"
            ),
            r" + \mu_i C \ddot x",
            r" + \mu_i b",
            r"\Big)",
            r" + (J_i - J_{i+1}) \times q_i",
        ),
    ),
}


def text(model: Mechanics) -> str:
    """Return a model as text: the form of any such chain, its coefficients, and short chains written out."""
    scene = model.scene
    links = "1 link" if scene.links == 1 else f"{scene.links} links"
    head = f"{scene.space} chain of {links} on a {_base(scene)}, {_coordinates(scene)}"
    lines = [head, *_general(model, _TEXT[scene.space]), "", *_coefficients(model)]
    if scene.links <= _WRITTEN_OUT[scene.space]:
        lines += ["", f"T = {plain(model.kinetic)}", f"V = {plain(model.potential)}", ""]
        lines += [f"{plain(equation.lhs)} = {plain(equation.rhs)}" for equation in model.equations]
    return "\n".join(lines)


def latex(model: Mechanics) -> str:
    """Return a model as one aligned LaTeX block: the general form, or short chains in full."""
    if model.scene.links <= _WRITTEN_OUT[model.scene.space]:
        rows = [f"T &= {sympy.latex(expression(model.kinetic))}", f"V &= {sympy.latex(expression(model.potential))}"]
        rows += [
            f"{sympy.latex(equation.rhs)} &= {sympy.latex(equation.lhs)}" for equation in model.equations
        ]
    else:
        mu, c = (
            sympy.Matrix([[expression(x) for x in row] for row in table]) for table in ([model.mu], model.c)
        )
        rows = [
            *_general(model, _LATEX[model.scene.space]),
            f"\\mu &= {sympy.latex(mu)}",
            f"c &= {sympy.latex(c)}",
        ]
        rows += [] if model.scene.base_law.rests else [f"M_{{00}} &= {sympy.latex(expression(model.total_mass))}"]
    return "\\begin{aligned}" + " \\\\ ".join(rows) + "\\end{aligned}"


def plain(value: Any) -> str:
    """Return an expression or a coefficient as text, decimals without trailing zeros."""
    return str(sympy.sstr(expression(value), full_prec=False))


def _general(model: Mechanics, forms: _Forms) -> list[str]:
    """Return T, V, a link's equation (in space also without angular velocities) and the cart's, in index form."""
    scene = model.scene
    sprung, damped, rubbed, geared = (
        getattr(scene, name) is not None for name in ("stiffness", "damping", "friction", "armature")
    )
    is_tied = sprung or damped or rubbed or geared
    kinetic = forms.kinetic + forms.kinetic_cart * scene.has_cart + forms.kinetic_moving * scene.is_moving
    kinetic += forms.kinetic_rotors * geared
    potential = forms.potential + forms.springs * sprung
    equation = forms.equation + forms.equation_cart * scene.has_cart + forms.equation_moving * scene.is_moving
    equation += forms.equation_joints * is_tied
    joint = forms.joint_springs * sprung + forms.joint_dampers * damped + forms.joint_friction * rubbed
    joint += forms.joint_rotors * geared
    if scene.rest_angle is not None:
        away = f"{forms.bend[:-1]}{forms.rest})"
        potential, joint = potential.replace(forms.bend, away), joint.replace(forms.bend, away)
    lines = [kinetic, potential, equation]
    if forms.directions is not None:
        head, cart, moving, end, joints = forms.directions
        lines.append(head + cart * scene.has_cart + moving * scene.is_moving + end + joints * is_tied)
    if scene.is_driven:
        lines.append(forms.driven_row)
    elif scene.has_cart:
        braked = (scene.cart_damping is not None, scene.cart_friction is not None)
        lines.append(forms.cart_row + forms.cart_damper * braked[0] + forms.cart_friction * braked[1])
    return [*lines, *([forms.joint + joint.removeprefix(" +")] if joint else [])]


def _base(scene: Scene) -> str:
    """Return what the base is."""
    return scene.base_law.noun


def _coordinates(scene: Scene) -> str:
    """Return what the coordinates are."""
    if scene.is_planar:
        return f"{scene.angles} angles, {_ANGLES[str(scene.angles)]}"
    return "unit vectors, q_k' = omega_k x q_k"


def _coefficients(model: Mechanics) -> list[str]:
    """Return mu_k, c_ij and M00, shortened for long chains."""
    lines = [f"mu = {_row(model.mu)}"]
    lines += [f"{'c  =' if i == 0 else '    '} {_row(row)}" for i, row in enumerate(model.c[:_COLUMNS])]
    lines += ["     ..."] if len(model.c) > _COLUMNS else []
    return lines if model.scene.base_law.rests else [*lines, f"M00 = {plain(model.total_mass)}"]


def _row(entries: Iterable[Any]) -> str:
    known = list(entries)
    shown = [plain(entry) for entry in known[:_COLUMNS]] + (["..."] if len(known) > _COLUMNS else [])
    return f"[{', '.join(shown)}]"
