"""Sections 6 and 12: one harmonic, and brake orbits."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from scipy.special import jv

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
from docs.figures.table import figure


@figure("harmonic-balance")
def harmonic_balance() -> Figure:
    """How Phi is swept: amplitudes outwards, kernels of every pair, moments inwards; and the kernels."""
    picture, (ax,) = canvas(8.6, 3.1, (0.0, 0.0, 0.66, 1.0))
    frame(ax, (0.0, 11.4), (0.0, 6.2))
    steps(ax, [(1.5, 4.9), (5.6, 4.9), (9.7, 4.9)], (2.9, 1.5),
          ("$A_1 \\dots A_N,\\ \\omega$\n(on a cart $X$)", "outwards:\n$B = S A$", "every pair $i < j$:\n$D = B_i - B_j$"), (INK, BLUE, INK))  # fmt: skip
    arrow(ax, (9.7, 4.15), (9.7, 2.85), "kept", color=GREEN, off=(0.55, 0.0), fontsize=8)
    box(ax, (9.7, 2.1), (2.9, 1.5), "$a(D),\\ s(D)$\nserve rows $i$ and $j$", color=GREEN, fill="#f0f8f2", fontsize=8.5)
    box(ax, (5.6, 2.1), (2.9, 1.5), "row $i$: $\\Sigma_j$, and\n$2 g\\mu_i J_1(B_i)$", color=INK, fontsize=8.5)
    box(ax, (1.5, 2.1), (2.9, 1.5), "inwards: $S^T$,\nsprings: $\\Phi$", color=ACCENT, fontsize=8.5)
    arrow(ax, (8.25, 2.1), (7.05, 2.1), color=SOFT)
    arrow(ax, (4.15, 2.1), (2.95, 2.1), color=ACCENT)
    words(ax, (5.7, 0.65), "$\\theta_k = A_k\\cos\\omega t$: what is left of the equations along $\\cos\\omega t$", color=SOFT, fontsize=8.5)
    right = panel(picture, (0.72, 0.17, 0.265, 0.75), "rad", "")
    z = np.linspace(0.0, 6.0, 121)
    right.plot(z, jv(0, z) - jv(2, z), color=GREEN, label="$a(D)$")
    right.plot(z, (jv(1, z) + jv(3, z)) / 2, color=ACCENT, label="$s(D)$")
    right.plot(z, 2 * jv(1, z), color=BLUE, label="$2 J_1(B)$")
    right.legend(fontsize=8)
    return picture


@figure("brake-orbit")
def brake_orbit() -> Figure:
    """A quarter of a brake orbit says all of it; where the numbers kappa tell events."""
    picture, (ax,) = canvas(8.6, 3.0, (0.47, 0.0, 0.53, 1.0))
    left = panel(picture, (0.07, 0.19, 0.37, 0.72), "time over $T$", "$\\theta$")
    t = np.linspace(0.0, 1.0, 241)
    quarter = t <= 0.25
    for size, third, color in ((1.0, 0.14, BLUE), (0.62, -0.16, ACCENT)):
        wave = size * np.cos(2 * np.pi * t) + third * np.cos(6 * np.pi * t)
        left.plot(t, wave, color=color, linewidth=0.9, linestyle="--")
        left.plot(t[quarter], wave[quarter], color=color, linewidth=2.2)
    left.axvline(0.25, color=GREEN, linewidth=1.0)
    left.axhline(0.0, color=INK, linewidth=0.8)
    left.set_xticks([0.0, 0.25, 0.5, 0.75, 1.0], ["0", "1/4", "1/2", "3/4", "1"])
    words(left, (0.4, 0.85), "$\\theta(T/4) = 0$", color=GREEN)
    words(left, (0.56, 0.3), "by symmetry", color=SOFT, fontsize=8.5)
    frame(ax, (-2.9, 2.9), (-1.75, 1.75))
    arrow(ax, (-2.75, 0.0), (2.75, 0.0), color=INK)
    words(ax, (2.55, -0.22), "$\\kappa$")
    for x, name in ((-1.0, "$-1$"), (1.0, "$1$")):
        ax.plot([x, x], [-0.1, 0.1], color=INK, linewidth=1.2)
        words(ax, (x - 0.02, -0.28), name)
    ax.plot([-1.0, 1.0], [0.0, 0.0], color=GREEN, linewidth=5, zorder=1)
    words(ax, (0.0, 0.3), "stable", color=GREEN, fontsize=8.5)
    words(ax, (-1.75, 1.1), "$\\mu = -1$: odd loss,\nunequal brakes", color=ACCENT, fontsize=8.5)
    arrow(ax, (-1.6, 0.75), (-1.05, 0.12), color=ACCENT)
    words(ax, (1.75, 1.1), "$\\mu = 1$: brake loss,\nanother family", color=BLUE, fontsize=8.5)
    arrow(ax, (1.6, 0.75), (1.05, 0.12), color=BLUE)
    arrow(ax, (-0.55, -0.75), (0.0, -0.2), color=SOFT)
    arrow(ax, (0.55, -0.75), (0.0, -0.2), color=SOFT)
    words(ax, (0.0, -1.05), "two that meet: Krein", color=SOFT, fontsize=8.5)
    words(ax, (0.0, -1.5), "$Q = (a\\ b;\\ c\\ d)$ over $T/4$:   $\\kappa = $ eig$(1 - 2 d^T a)$", fontsize=9)
    return picture
