"""Section 9: implicit steps, and the linear systems of their stages."""

from __future__ import annotations

from matplotlib.figure import Figure

from docs.figures.drawing import (
    ACCENT,
    BLUE,
    GREEN,
    INK,
    SOFT,
    arrow,
    box,
    canvas,
    chart,
    frame,
    sphere,
    words,
)
from docs.figures.planar import link_frame
from docs.figures.sweep import Sweep, beside
from docs.figures.table import figure


@figure("rosenbrock")
def rosenbrock() -> Figure:
    """One factorisation serves the eight stages of a step."""
    picture, (ax,) = canvas(8.6, 2.7)
    frame(ax, (0.0, 15.0), (0.0, 4.7))
    box(ax, (1.75, 2.35), (2.7, 2.6), "once a step:\n\n$J = f'(y_0)$\n$I - g J,\\ \\ g = \\gamma h$\nfactored in $O(N)$", color=GREEN, fill="#f0f8f2", fontsize=8.5)
    for k, x in enumerate((4.6, 6.2, 7.8, 9.4, 11.0)):
        dots = k == 3
        name = ("$U_1$", "$U_2$", "$U_3$", "$\\cdots$", "$U_8$")[k]
        if dots:
            words(ax, (x, 2.9), name, fontsize=12, color=SOFT)
            continue
        box(ax, (x, 2.9), (1.1, 0.9), name, color=ACCENT, fontsize=9)
        arrow(ax, (3.1, 1.35), (x, 2.45), color=GREEN, linewidth=0.9, mutation_scale=7)
    for a, b in ((5.15, 5.65), (6.75, 7.25), (8.35, 9.0), (9.8, 10.45)):
        arrow(ax, (a, 2.9), (b, 2.9), color=SOFT)
    words(ax, (7.8, 4.1), "right side of stage $i$:  $\\gamma\\,(h f(y_0 + \\sum_j a_{ij} U_j) + \\sum_j c_{ij} U_j)$", color=ACCENT, fontsize=8.5)
    words(ax, (7.2, 0.75), "one sweep inwards and one outwards for each", color=GREEN, fontsize=8.5)
    box(ax, (13.5, 3.4), (2.3, 1.0), "$y_1 = y_0 + \\sum m_i U_i$", color=BLUE, fontsize=8.5)
    box(ax, (13.5, 1.6), (2.3, 1.0), "$U_8 = y_1 - \\hat y_1$:\nhow long is $h$?", color=INK, fontsize=8.5)
    arrow(ax, (11.55, 3.0), (12.35, 3.4), color=BLUE)
    arrow(ax, (11.55, 2.7), (12.35, 1.8), color=INK)
    return picture


@figure("implicit-plane")
def implicit_plane() -> Figure:
    """The linearised chain, swept as the chain is: a matrix without symmetry, once; a vector for every right side."""
    picture, ax = beside(
        Sweep(
            carried="$\\Lambda$, once\nthen $\\lambda$",
            step="shift $l - r$, $m$\nand $R$, shift $r$\njoint $s$, turn",
            kept="$1/(D + s)$, $u$, $w$\n$n$, $R$",
            base="cart:\n\n$m_c + \\Lambda_{yy}$\nand its drag\n\n\nwall:\n\n$\\delta\\ddot r = 0$",
            returned="$\\delta\\ddot r,\\ x$",
            result="$x_k - x_{k-1}$\nthen $k_v,\\ k_q$\nof the joint",
        )
    )
    start, end = link_frame(ax)
    arrow(ax, (end[0] + 0.08, end[1] - 0.12), (end[0] + 0.3, end[1] - 0.75), "$\\delta F,\\ \\delta N$", color=ACCENT, off=(-0.75, -0.3))
    arrow(ax, start, (start[0] - 0.6, start[1] + 0.25), "$\\delta\\ddot r$", color=BLUE, off=(-0.05, 0.28))
    words(ax, (-0.1, -0.95), "$x_k = J_v\\,(k_q, k_v)$\n$\\delta q = P + g^2 x$\n$\\delta v = r_v + g x$", color=GREEN, fontsize=8.5, ha="center")
    return picture


@figure("implicit-space")
def implicit_space() -> Figure:
    """The chart of a step in space: projections across the unit vectors at its start."""
    picture, (ax, side) = canvas(8.6, 2.9, (0.0, 0.0, 0.42, 1.0), (0.42, 0.0, 0.58, 1.0))
    frame(ax, (-2.2, 2.4), (-1.5, 2.1))
    sphere(ax, (0.0, 0.0), 1.35)
    chart(ax, [(-1.3, 1.0), (0.9, 1.0), (1.75, 1.8), (-0.45, 1.8)])
    top, q = (0.15, 1.34), (0.98, 0.85)
    shadow = (0.98, 1.42)
    arrow(ax, (0.0, 0.0), top, "$q_0$", color=INK, off=(-0.28, 0.0))
    arrow(ax, (0.0, 0.0), q, "$q$", color=BLUE, off=(0.25, -0.15))
    arrow(ax, top, shadow, "$s$", color=ACCENT, off=(0.0, 0.22))
    ax.plot([q[0], shadow[0]], [q[1], shadow[1]], color=SOFT, linewidth=0.9, linestyle=(0, (3, 3)))
    arrow(ax, top, (-0.55, 1.58), "$\\sigma$", color=GREEN, off=(0.0, 0.22))
    words(ax, (1.72, 1.05), "tangent\nplane", color=SOFT, fontsize=8)
    frame(side, (0.0, 10.0), (0.0, 5.8))
    rows = (
        ("$s = P_0 q,\\quad \\sigma = P_0 \\omega$", INK),
        ("back:  $q = s + \\sqrt{1 - |s|^2}\\ q_0$,   so $|q| = 1$", BLUE),
        ("and  $\\omega = \\sigma - q_0\\,(\\sigma\\cdot q)/(q_0\\cdot q)$,   so $\\omega\\cdot q = 0$", BLUE),
        ("the sweep of the plane with vectors across $q_0$ in place of scalars,", ACCENT),
        ("joints tie the $x$ of neighbours by $3\\times 3$ matrices", ACCENT),
        ("a link that turns by a right angle within a step leaves the chart", SOFT),
    )
    for row, (text, color) in enumerate(rows):
        words(side, (0.1, 5.2 - 0.9 * row), text, color=color, ha="left", fontsize=9)
    return picture
