"""Section 5 in the plane: the articulated sweep, its Jacobians, rotors at the joints."""

from __future__ import annotations

import itertools

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from docs.figures.drawing import (
    ACCENT,
    BLUE,
    GREEN,
    SOFT,
    angle,
    arrow,
    canvas,
    frame,
    joint,
    link,
    mass,
    places,
    turned,
    wall,
    words,
)
from docs.figures.sweep import Sweep, beside
from docs.figures.table import figure

LEAN = 0.7
"""How far the sketched link leans, rad."""


def link_frame(ax: Axes, at: float = 0.55) -> tuple[tuple[float, float], tuple[float, float]]:
    """One link in its own frame: e_x along it, e_y along its tangent; returns its joint and its tip."""
    frame(ax, (-1.0, 2.35), (-2.75, 1.4))
    start, end = places((0.0, 0.6), (LEAN,), (2.4,))
    x, y = turned(LEAN)
    link(ax, start, end)
    joint(ax, start)
    mass(ax, (start[0] + at * 2.4 * x, start[1] + at * 2.4 * y))
    arrow(ax, start, (start[0] + 0.75 * x, start[1] + 0.75 * y), color=SOFT)
    arrow(ax, start, (start[0] - 0.75 * y, start[1] + 0.75 * x), color=SOFT)
    words(ax, (start[0] + 0.55, start[1] - 0.95), "$e_x$", color=SOFT)
    words(ax, (start[0] + 0.85, start[1] + 0.4), "$e_y$", color=SOFT)
    return start, end


@figure("articulated")
def articulated() -> Figure:
    """Masses before the ends, in the plane: inertia and force inwards, accelerations outwards."""
    picture, ax = beside(
        Sweep(
            carried="$A,\\, E$\n$b,\\, k$",
            step="$D = 1 + A_{yy}$\neliminate $\\ddot\\phi_k$,\nturn",
            kept="$A_{xy}/D,\\ w^2$\n$(\\lambda - 1)/D$",
            base="cart:\n\n$(m_c + A_{yy})\\,\\ddot x$\n$= u - b_y$\n$+\\, g A_{xy}$\n\n\nwall:\n\n$a = -g e_d$",
            returned="$a$",
            result="$a_y + \\ddot\\phi_k$\nat once, and\n$\\ddot\\phi_k$",
        )
    )
    start, end = link_frame(ax)
    arrow(ax, (end[0] + 0.08, end[1] - 0.12), (end[0] + 0.3, end[1] - 0.75), "$A a + b$", color=ACCENT, off=(-0.62, -0.05))
    arrow(ax, start, (start[0] - 0.6, start[1] + 0.25), "$a$", color=BLUE, off=(-0.05, 0.24))
    angle(ax, start, 1.45, 0.0, LEAN, "", color=ACCENT)
    words(ax, (0.32, -1.15), "$w,\\, \\tau$", color=ACCENT)
    return picture


@figure("jacobian-plane")
def jacobian_plane() -> Figure:
    """What turning one joint does: one pair of numbers inwards, one state outwards."""
    picture, (ax,) = canvas(8.6, 3.2)
    frame(ax, (-1.2, 12.8), (-2.3, 2.9))
    wall(ax, (0.0, 2.1), 0.9)
    joints = [(0.0, 2.1), (2.0, 1.0), (4.2, 1.2), (6.4, 0.5), (8.7, 1.0), (11.0, 0.4)]
    for start, end in itertools.pairwise(joints):
        link(ax, start, end)
        mass(ax, ((start[0] + end[0]) / 2, (start[1] + end[1]) / 2))
    for k, place in enumerate(joints[:-1]):
        joint(ax, place, 0.12 if k == 3 else 0.08)
    words(ax, (6.4, 1.05), "joint $k$ turns\na little", color=ACCENT, fontsize=8.5)
    for left, right in ((4.35, 6.1), (2.15, 3.95), (0.2, 1.8)):
        arrow(ax, (right, -0.35), (left, -0.35), color=ACCENT)
    words(ax, (3.2, -0.02), "$f_{k} = T^T f_{k+1}$", color=ACCENT, fontsize=9)
    words(ax, (3.2, -0.95), "inside: force $\\eta_k$ at joint $k - 1$, turn $-\\zeta_k$ of link $k - 1$\n"
          "row $i$ is the product of pairs $-\\eta_k \\cdot Y_i - \\zeta_k$", color=ACCENT, fontsize=8.5)  # fmt: skip
    for left, right in ((6.7, 8.5), (8.95, 10.8)):
        arrow(ax, (left, -0.35), (right, -0.35), color=BLUE)
    words(ax, (8.75, -0.02), "$X_{k+1} = T X_k + \\dots$", color=BLUE, fontsize=9)
    words(ax, (9.5, -0.95), "beyond: one state goes over\neach link once, $\\alpha_i = \\varphi - \\rho_i \\cdot X_i$", color=BLUE, fontsize=8.5)
    words(ax, (5.7, -1.9), "kept of every joint before:  $T_k,\\ \\rho_k,\\ n_k,\\ 1/D_k$ and its mobility  "
          "$\\Omega_{k+1} = T\\, \\Omega_k T^T + n n^T / D$", color=GREEN, fontsize=8.5)  # fmt: skip
    return picture


@figure("rotors")
def rotors() -> Figure:
    """Rotors at the joints: a force and a moment per acceleration and turning."""
    picture, ax = beside(
        Sweep(
            carried="$X, z, h$\n$S,\\, \\delta$; $p$",
            step="$D = P + A_k$\neliminate $\\alpha_k$,\nrotor in series",
            kept="$B_{f\\alpha}/D$\n$P/D,\\ A_k/D$",
            base="cart:\n\nits force and\nits mass\n\n\nwall:\n\n$a = -g e_d$,\n$\\alpha_0 = 0$",
            returned="$a,\\ \\alpha_{k-1}$",
            result="$\\ddot\\vartheta_k$ at once,\n$\\alpha_k = \\alpha_{k-1}$\n$+\\, \\ddot\\vartheta_k$",
        )
    )
    start, end = link_frame(ax)
    joint(ax, start, 0.24)
    joint(ax, start, 0.07)
    words(ax, (-0.55, 0.45), "$A_k$", color=ACCENT)
    arrow(ax, (end[0] + 0.08, end[1] - 0.12), (end[0] + 0.28, end[1] - 0.75), "$(f, n) = K (a, \\alpha) + p$", color=ACCENT, off=(-1.3, -0.42), fontsize=8.5)
    before = -0.5
    x, y = turned(before)
    link(ax, (start[0] - 0.8 * x, start[1] - 0.8 * y), (start[0] - 0.24 * x, start[1] - 0.24 * y))
    words(ax, (0.85, 1.25), "$\\alpha_{k-1}$", color=BLUE)
    angle(ax, start, 1.4, before, LEAN, "", color=SOFT)
    words(ax, (0.25, -1.15), "$\\vartheta_k$", color=SOFT)
    return picture
