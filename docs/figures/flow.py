"""Section 10: the Taylor flow, order by order."""

from __future__ import annotations

import math

import numpy as np
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
    frame,
    panel,
    steps,
    words,
)
from docs.figures.ends import Fronts, draw_fronts
from docs.figures.planar import link_frame
from docs.figures.sweep import Sweep, beside
from docs.figures.table import figure


@figure("taylor-step")
def taylor_step() -> Figure:
    """A step of the flow: one factorisation, a back substitution an order, sums between them."""
    picture, (ax,) = canvas(8.6, 2.9)
    frame(ax, (0.0, 16.0), (0.0, 5.4))
    box(ax, (1.75, 3.2), (2.9, 1.9), "flow_factor\n\n$M(q_0)$ in $O(N)$:\nheld numbers", color=GREEN, fill="#f0f8f2", fontsize=8.5)
    box(ax, (6.2, 3.2), (2.9, 1.9), "sums\n\n$s_n = \\Sigma_j\\, a_j b_{n-j}$\none lane a product", color=INK, fontsize=8.5)
    box(ax, (10.4, 3.2), (2.7, 1.9), "flow_order\n\n$x_{n+1}$ by back\nsubstitution", color=ACCENT, fontsize=8.5)
    box(ax, (14.4, 3.2), (2.5, 1.9), "last two terms:\nlength $h$\n\n$x(t + h)$", color=BLUE, fontsize=8.5)
    arrow(ax, (3.2, 3.2), (4.75, 3.2), "$n = 0$", color=SOFT, off=(0.0, 0.3))
    arrow(ax, (7.65, 3.2), (9.05, 3.2), color=SOFT)
    arrow(ax, (11.75, 3.2), (13.15, 3.2), "$\\leq 22$", color=SOFT, off=(0.0, 0.3))
    arrow(ax, (10.4, 4.15), (6.2, 4.15), "next order: rows $a_{n+1},\\ b_{n+1}$", color=ACCENT, off=(0.0, 0.95), connectionstyle="arc3,rad=0.22")
    arrow(ax, (14.4, 2.25), (1.75, 2.25), "slope of the series against $f$ at the end; next step begins with that $f$", color=BLUE, off=(0.0, -1.55), connectionstyle="arc3,rad=-0.14")
    arrow(ax, (2.9, 2.25), (9.2, 2.25), "held", color=GREEN, off=(0.0, -0.62), connectionstyle="arc3,rad=0.14")
    return picture


@figure("taylor-plane")
def taylor_plane() -> Figure:
    """Order n of a chain in the plane: forces inwards by Q, accelerations outwards by its transpose."""
    picture, ax = beside(
        Sweep(
            carried="$p_n$",
            step="$p' = Q\\,p$\n$+\\ C''_n$ and\n$\\tau_n$ beside",
            kept="from the step:\n$Q,\\ 1/D$",
            base="cart:\n\n$m r^2 \\to m_c$\n$l \\to 1$\n\n\nwall:\n\n$a_n = 0$\nfrom $n = 1$ on",
            returned="$a_n$",
            result="$Q^T a$ + beside\n$w_{n+1},\\ S''_n$\nand $H_n$",
        )
    )
    start, _end = link_frame(ax)
    ax.plot([start[0], start[0] + 1.0], [start[1], start[1] - 2.75], color=SOFT, linewidth=1.0, linestyle=(0, (4, 3)))
    words(ax, (0.2, -1.55), "direction at\nthe step's start", color=SOFT, fontsize=7.5)
    words(ax, (1.12, -1.85), "$\\psi$", color=ACCENT)
    words(ax, (0.62, 1.25), "$C = \\cos\\psi,\\ S = \\sin\\psi$", color=ACCENT, fontsize=8.5)
    return picture


@figure("order-and-step")
def order_and_step() -> Figure:
    """Which terms decide the length of a step; where an event is looked for within it."""
    picture = Figure(figsize=(8.6, 2.9))
    left = panel(picture, (0.08, 0.19, 0.38, 0.7), "order $n$", "size of term $n$ over the motion")
    n = np.arange(23)
    for ratio, color, name in ((0.19, BLUE, "a step that is kept"), (0.31, ACCENT, "a step that is too long")):
        left.semilogy(n, ratio**n * (1 + 0.5 * np.cos(2.1 * n)), color=color, marker="o", markersize=3, label=name)
    left.axhline(1e-15, color=INK, linewidth=1.0, linestyle="--")
    words(left, (3.2, 6e-17), "local error $\\varepsilon$", fontsize=8)
    left.set_ylim(1e-18, 3.0)
    left.legend(fontsize=8, loc="upper right")
    right = panel(picture, (0.56, 0.19, 0.42, 0.7), "$u$ within a step", "event's scalar")
    u = np.linspace(0.0, 1.0, 201)
    g = _scalar(u)
    right.plot(u, g, color=BLUE)
    right.axhline(0.0, color=INK, linewidth=1.0)
    looks = np.linspace(0.0, 1.0, 5)
    right.plot(looks, _scalar(looks), "o", color=GREEN, markersize=5)
    turn = u[int(np.argmin(g))]
    right.plot([turn], [g.min()], "s", color=ACCENT, markersize=5)
    words(right, (turn + 0.02, g.min() - 0.2), "turning point, looked at too", color=ACCENT, fontsize=8)
    words(right, (0.32, 0.95), "looks", color=GREEN, fontsize=8)
    right.set_ylim(-0.5, 1.75)
    return picture


def _scalar(u: np.ndarray) -> np.ndarray:
    """A scalar with two zeros between two looks."""
    return np.asarray(4.0 * (u - 0.63) ** 2 - 0.045)


@figure("taylor-columns")
def taylor_columns() -> Figure:
    """The same back substitution serves the state and every column of derivatives."""
    picture, (ax,) = canvas(8.6, 2.9)
    frame(ax, (0.0, 16.0), (0.0, 5.4))
    box(ax, (1.9, 2.7), (3.2, 3.6), "held by the step:\n\n$M(q_0)$ factored\n\nserves the state\nand every column", color=GREEN, fill="#f0f8f2", fontsize=8.5)
    rows = ((4.25, BLUE, "$x$", "$s_n = \\sum_{j \\geq 0} a_j\\, b_{n-j}$", "$x_{n+1}$"),
            (2.55, ACCENT, "$d_1$", "$\\sum_{j \\geq -1} da_j\\, b_{n-j} + \\sum_{j \\geq 0} a_j\\, db_{n-j}$", "$d\\,x_{n+1}$"),
            (0.95, ACCENT, "$d_2 \\dots$", "the same, side by side in lanes", "$d\\,x_{n+1}$"))  # fmt: skip
    for y, color, name, text, out in rows:
        words(ax, (4.5, y - 0.12), name, color=color, fontsize=10)
        box(ax, (8.0, y), (5.2, 1.1), text, color=color, fontsize=8.5)
        box(ax, (13.9, y), (2.0, 1.1), out, color=color, fontsize=9)
        arrow(ax, (10.6, y), (12.9, y), "flow_order", color=SOFT, off=(0.0, 0.27), fontsize=8)
    for y in (4.25, 2.55, 0.95):
        arrow(ax, (3.55, y + 0.3), (5.4, y + 0.3), color=GREEN)
    for y in (2.55, 0.95):
        words(ax, (15.55, y), "$P$", fontsize=10)
    return picture


@figure("dry-series")
def dry_series() -> Figure:
    """Dry friction in a series: what order n + 1 needs is there when order n is done; the poles that bound a step."""
    picture, (ax,) = canvas(8.6, 2.9, (0.0, 0.0, 0.6, 1.0))
    frame(ax, (0.0, 9.6), (0.0, 5.4))
    steps(ax, [(1.45, 3.7), (4.8, 3.7), (8.1, 3.7)], (2.5, 1.7),
          ("order $n$ gives\n$z_{n+1}$, so\n$d_{n+1}$", "$y_{n+1}$ from\n$s_0 d_{n+1}$ and\nknown sums", "$s_{n+1}$ from\n$y_0 y_{n+1}$ and\nknown sums"), (BLUE, ACCENT, ACCENT))  # fmt: skip
    arrow(ax, (8.1, 2.85), (1.45, 2.85), "order $n + 1$ asks for the torque $F\\,y_{n+1}$", color=GREEN, off=(0.0, -1.1), connectionstyle="arc3,rad=-0.16")
    words(ax, (4.8, 0.6), "$y = \\tanh z,\\quad s = 1 - y^2,\\quad y' = s\\,z'$", fontsize=9)
    right = panel(picture, (0.7, 0.2, 0.28, 0.7), "Re $v\\,/\\,v_0$", "Im $v\\,/\\,v_0$")
    circle = np.linspace(0.0, 2 * math.pi, 121)
    right.plot(np.pi / 2 * np.cos(circle), np.pi / 2 * np.sin(circle), color=BLUE, linewidth=1.0)
    right.plot([0.0, 0.0], [np.pi / 2, -np.pi / 2], "x", color=ACCENT, markersize=7, markeredgewidth=1.8)
    words(right, (0.0, 2.05), "poles of tanh, $\\pi v_0 / 2$ away", color=ACCENT, fontsize=8)
    right.plot([-2.6, 2.6], [0.0, 0.0], color=INK, linewidth=1.2)
    right.set_xlim(-2.6, 2.6)
    right.set_ylim(-2.4, 2.4)
    return picture


@figure("taylor-space")
def taylor_space() -> Figure:
    """Order n of a chain in space, masses at the ends: one tridiagonal matrix, factored once a step."""
    picture, (sketch, area) = canvas(8.6, 3.3, (0.005, 0.02, 0.23, 0.96), (0.235, 0.02, 0.765, 0.96))
    draw_fronts(
        area,
        Fronts(
            base="load",
            tip="load",
            base_step="$r_k$ from $B_k$\nand $q_0\\cdot q''_n$",
            tip_step="$r_k$ from $B_k$\nand $q_0\\cdot q''_n$",
            meeting="pivots are\nheld: only\n\nright sides\n\nrun",
            back="$\\mu_{k+1}$",
            forth="$\\mu_{k-1}$",
            base_result="$\\mu_k$, then\n$(q''_k)_n$",
            tip_result="$\\mu_k$, then\n$(q''_k)_n$",
        ),
    )
    frame(sketch, (-1.5, 1.7), (-2.4, 2.0))
    words(sketch, (0.05, 1.3), "$(\\mu q)_n = \\mu_n q_0 + Y$", color=ACCENT, fontsize=9)
    words(sketch, (0.05, 0.35), "three convolutions:\n$Y$, by components", color=SOFT, fontsize=8.5)
    words(sketch, (0.05, -0.75), "$q_0\\cdot q''_n = -\\frac{1}{2}(n+1)(n+2) S$", color=BLUE, fontsize=9)
    words(sketch, (0.05, -1.65), "three halves:\n$S$, from $q\\cdot q = 1$", color=SOFT, fontsize=8.5)
    return picture
