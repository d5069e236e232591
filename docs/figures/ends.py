"""Section 5: eliminations from both ends of the chain towards its middle."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

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
    joint,
    link,
    mass,
    wall,
    words,
)
from docs.figures.table import figure

_COLUMNS = (1.4, 3.6, 5.8, 8.0, 10.2)
_NAMES = ("$k = 1$", "$2$", "middle", "$N - 1$", "$N$")


@dataclass(frozen=True)
class Fronts:
    """Two eliminations that meet, in the symbols of their section.

    Attributes:
        base: what the side of the base hands on.
        tip: what the side of the tip hands on.
        base_step: what one link does on the side of the base, and on that of the tip.
        tip_step: the same there.
        meeting: what is solved where they meet.
        back: what goes back to the base, and to the tip.
        forth: the same there.
        base_result: what comes out of a link on the side of the base.
        tip_result: the same on the other.
    """

    base: str
    tip: str
    base_step: str
    tip_step: str
    meeting: str
    back: str
    forth: str
    base_result: str
    tip_result: str


def draw_fronts(ax: Axes, fronts: Fronts) -> None:
    """Draw two eliminations into an area."""
    ax.set_xlim(0.2, 11.4)
    ax.set_ylim(0.2, 5.1)
    for x, name in zip(_COLUMNS, _NAMES, strict=True):
        words(ax, (x, 4.9), name, color=SOFT, fontsize=8.5)
    box(ax, (_COLUMNS[2], 2.55), (1.35, 3.9), fronts.meeting, color=INK, fontsize=8.5)
    for k, x in enumerate(_COLUMNS):
        if k == 2:
            continue
        on_base = k < 2
        box(ax, (x, 4.0), (1.4, 1.0), fronts.base_step if on_base else fronts.tip_step, color=GREEN if on_base else ACCENT, fontsize=8.0)
        box(ax, (x, 1.1), (1.4, 1.0), fronts.base_result if on_base else fronts.tip_result, color=BLUE, fontsize=8.0)
        arrow(ax, (x, 3.5), (x, 1.6), color=SOFT)
        words(ax, (x + 0.34, 2.55), "kept", color=SOFT, fontsize=8)
    for left, right in itertools.pairwise(_COLUMNS):
        a, b = left + 0.7, right - 0.7
        on_base = right <= _COLUMNS[2]
        text, color = (fronts.base, GREEN) if on_base else (fronts.tip, ACCENT)
        ends = ((a, 4.0), (b, 4.0)) if on_base else ((b, 4.0), (a, 4.0))
        arrow(ax, *ends, text, color=color, off=(0.0, 0.33), fontsize=8.0)
        ends = ((b, 1.1), (a, 1.1)) if on_base else ((a, 1.1), (b, 1.1))
        arrow(ax, *ends, fronts.back if on_base else fronts.forth, color=BLUE, off=(0.0, 0.3), fontsize=8.0)


def _beside(fronts: Fronts) -> tuple[Figure, Axes]:
    figure, (sketch, area) = canvas(8.6, 3.3, (0.005, 0.02, 0.23, 0.96), (0.235, 0.02, 0.765, 0.96))
    draw_fronts(area, fronts)
    return figure, sketch


@figure("tensions")
def tensions() -> Figure:
    """The tridiagonal system of the tensions, factored from both ends."""
    picture, ax = _beside(
        Fronts(
            base="$t_k,\\ \\beta_k$",
            tip="$Y_k,\\ \\beta_k$",
            base_step="$t_{k+1}$ from\n$s_{k+1}^2,\\ t_k$",
            tip_step="$Y_{k-1}$ from\n$s_k^2,\\ z_k$",
            meeting="both slacks\n\nadd up:\n\n$\\lambda_k$ of\nthe middle",
            back="$\\lambda_{k+1}$",
            forth="$\\lambda_{k-1}$",
            base_result="$\\lambda_k$, then\n$l_k\\dot\\omega_k$",
            tip_result="$\\lambda_k$, then\n$l_k\\dot\\omega_k$",
        )
    )
    frame(ax, (-1.4, 1.9), (-2.6, 1.9))
    before, here, beyond = (-0.55, 1.35), (0.35, 0.1), (-0.3, -1.75)
    link(ax, before, here, width=3.0)
    link(ax, here, beyond, width=3.0)
    for place, name, side in ((before, "$m_{k-1}$", -0.5), (here, "$m_k$", 0.55), (beyond, "$m_{k+1}$", 0.6)):
        mass(ax, place, 0.13)
        words(ax, (place[0] + side, place[1]), name)
    arrow(ax, here, (0.35 - 0.46, 0.1 + 0.64), color=ACCENT)
    words(ax, (-0.75, 0.42), "$-\\lambda_k q_k$", color=ACCENT)
    arrow(ax, here, (0.35 - 0.29, 0.1 - 0.82), color=BLUE)
    words(ax, (-0.75, -0.55), "$\\lambda_{k+1} q_{k+1}$", color=BLUE)
    arrow(ax, here, (0.35, -0.95), color=SOFT)
    words(ax, (1.05, -0.75), "$m_k g e_d$", color=SOFT)
    return picture


@figure("both-ends")
def both_ends() -> Figure:
    """The articulated sweep from both ends: a mobility from the base, an inertia from the tip."""
    picture, ax = _beside(
        Fronts(
            base="$W,\\, F$\n$a_0,\\, h$",
            tip="$A,\\, E$\n$b,\\, k$",
            base_step="$D = 1 +$\n$\\lambda^2 W_{xx}$",
            tip_step="$D = 1 +$\n$A_{yy}$",
            meeting="$f = A a + b$\n$a = a_0 - W f$\n\n$\\Delta = 1$\n$+\\,\\mathrm{tr}(A W)$\n$+\\, E F$",
            back="$f_x,\\ t$",
            forth="$a$",
            base_result="$a_y,\\ g_y,\\ g_x$\nand $\\ddot\\phi$",
            tip_result="$a_y + \\ddot\\phi$\nand $\\ddot\\phi$",
        )
    )
    frame(ax, (-1.5, 1.8), (-2.4, 2.1))
    wall(ax, (-0.9, 1.75), 0.7)
    joints = [(-0.9, 1.75), (-0.2, 0.95), (0.1, 0.0), (0.75, -0.85), (0.6, -1.95)]
    for start, end in itertools.pairwise(joints):
        link(ax, start, end)
        mass(ax, ((start[0] + end[0]) / 2, (start[1] + end[1]) / 2), 0.08)
    for place in joints[:-1]:
        joint(ax, place)
    arrow(ax, joints[2], (0.95, 0.35), "$f$", color=ACCENT, off=(0.1, 0.25))
    arrow(ax, joints[2], (-0.75, -0.3), "$a$", color=BLUE, off=(-0.1, -0.25))
    words(ax, (0.75, 1.15), "$a_0 - W f$", color=GREEN)
    words(ax, (-0.35, -1.35), "$A a + b$", color=ACCENT)
    return picture


@figure("jacobian-tensions")
def jacobian_tensions() -> Figure:
    """The blocks of the Jacobian by tensions: three diagonals with parts of their own, products of two vectors beyond."""
    picture, (ax, side) = canvas(8.6, 3.2, (0.02, 0.03, 0.36, 0.9), (0.4, 0.0, 0.6, 1.0))
    links = 7
    frame(ax, (-0.9, links + 0.1), (-0.1, links + 0.75))
    for i in range(links):
        for j in range(links):
            near = abs(i - j) <= 1
            color = "#dfe5ee" if near else ("#fbe9df" if i > j else "#e2e9fb")
            ax.add_patch(_cell(j, links - 1 - i, color))
    column = 2
    ax.add_patch(_cell(column, 0, "none", links))
    words(ax, (column + 0.5, links + 0.4), "$q_j$", fontsize=9)
    for i in range(links):
        text = {0: "$V_i$", 5: "$Z_i$", 6: "$Z_i$", 4: "$Z_i$"}.get(i, "")
        words(ax, (column + 0.5, links - 0.5 - i), text, fontsize=8)
    words(ax, (-0.5, links / 2), "$\\dot\\omega_i$", fontsize=9)
    frame(side, (0.0, 10.0), (0.0, 6.2))
    for row, (text, color) in enumerate((
        ("a change of $q_j$ loads the rows $j - 1,\\ j,\\ j + 1$ of the tensions' system", INK),
        ("beyond:  $G_{i+1,j} = e_{i+1} G_{ij}$,   block $= Z_i\\,(\\partial\\Lambda_{i-1}/\\partial q_j)^T$", ACCENT),
        ("before:  $G_{i-1,j} = d_{i-1} G_{ij}$,   block with $V_i$ likewise", BLUE),
        ("beside:  $-\\hat F_i$,  $\\Lambda_{i-1}\\hat q_i$,  $\\rho_{i+1}\\Lambda_{i+1}\\hat q_i$ are added", SOFT),
        ("kept of each link:  $\\Lambda_i,\\ G_{ii},\\ e_i,\\ d_i,\\ Z_i,\\ V_i$", GREEN),
    )):  # fmt: skip
        words(side, (0.2, 5.3 - 1.1 * row), text, color=color, ha="left", fontsize=9)
    return picture


def _cell(x: float, y: float, color: str, height: float = 1.0) -> Rectangle:
    """A cell of a matrix, or the outline of a column."""
    edge, width = (INK, 1.4) if color == "none" else ("white", 1.0)
    return Rectangle((x, y), 1.0, height, facecolor=color, edgecolor=edge, linewidth=width)
