"""Section 5 in space: the articulated sweep on unit vectors, and the shorter one by mobilities."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from docs.figures.drawing import ACCENT, BLUE, GREEN, SOFT, arrow, frame, joint, link, mass, words
from docs.figures.sweep import Sweep, beside
from docs.figures.table import figure


def _links(ax: Axes) -> tuple[tuple[float, float], tuple[float, float], tuple[float, float]]:
    """Two links: the joint of the first, the joint between, the tip."""
    frame(ax, (-1.25, 2.1), (-2.75, 1.5))
    start, middle, end = (-0.6, 0.9), (0.55, -0.55), (1.1, -2.2)
    for a, b in ((start, middle), (middle, end)):
        link(ax, a, b)
        mass(ax, (a[0] + 0.6 * (b[0] - a[0]), a[1] + 0.6 * (b[1] - a[1])))
        joint(ax, a)
    return start, middle, end


@figure("articulated-space")
def articulated_space() -> Figure:
    """The inertia beyond a joint in its axial, mixed and tangent parts; outwards an acceleration and what stretches the chain."""
    picture, ax = beside(
        Sweep(
            carried="$\\alpha, \\nu, G$\n$g$; $c, d, \\rho$",
            step="$D = \\det($\n$\\beta^2 P + \\Gamma)$\neliminate $\\dot\\omega_k$",
            kept="$\\sigma,\\ 1/D,$\nwhat $y'$ needs",
            base="cart:\n\nas a link\nof direction\n$e_3$ would\n\n\nwall:\n\n$a = -g e_3$",
            returned="$a,\\ y$",
            result="$z$ from $y$,\n$a'$ and $y'$,\n$\\dot\\omega_k$",
        )
    )
    start, middle, _end = _links(ax)
    arrow(ax, middle, (middle[0] + 0.27, middle[1] - 0.82), "$o$", color=SOFT, off=(0.25, 0.0))
    arrow(ax, middle, (middle[0] - 0.12, middle[1] - 0.95), "$u = o + \\nu$", color=ACCENT, off=(-0.72, -0.25))
    arrow(ax, start, (start[0] + 0.5, start[1] - 0.63), "$q$", color=BLUE, off=(-0.28, -0.1))
    arrow(ax, middle, (1.45, -0.1), "$A a + f$", color=ACCENT, off=(0.12, 0.32))
    words(ax, (0.45, 1.3), "$A = \\alpha\\, u u^T + G$", color=GREEN)
    return picture


@figure("mobilities")
def mobilities() -> Figure:
    """One weighted square and one constraint a link: its multiplier pulls along the chain."""
    picture, ax = beside(
        Sweep(
            carried="$u, \\alpha, c$\n$G,\\, d$",
            step="$T = b I + G$\n$E,\\ D,\\ W q$\neliminate $s$",
            kept="$\\alpha',\\ c',\\ v,$\n$W q,\\ W$",
            base="cart:\n\n$m_c I + A$\non its two\ndirections\n\n\nwall:\n\n$a = -g e_3$",
            returned="$a$",
            result="$s$, then $a'$,\n$\\dot\\omega_k = q\\times$\n$(a' - a)/l$",
        )
    )
    start, middle, _ = _links(ax)
    arrow(ax, start, (start[0] - 0.4, start[1] + 0.35), "$a$", color=BLUE, off=(0.1, 0.25))
    arrow(ax, middle, (middle[0] + 0.75, middle[1] + 0.1), "$a'$", color=BLUE, off=(0.15, 0.22))
    arrow(ax, middle, (middle[0] - 0.5, middle[1] + 0.63), "$s\\,q$", color=ACCENT, off=(0.4, 0.2))
    words(ax, (-0.05, -1.35), "$q\\cdot(a' - a)$\n$= -l w^2$", color=GREEN, fontsize=8.5)
    words(ax, (0.75, 1.2), "$A' = \\alpha' v v^T + G'$", color=ACCENT, fontsize=8.5)
    return picture
