"""Sections 7, 11 and 13: slips of both papers, the proof, and how far a simulation can see."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from scipy.special import gamma

from docs.figures.drawing import (
    ACCENT,
    BLUE,
    GREEN,
    INK,
    SOFT,
    arrow,
    box,
    canvas,
    chain,
    frame,
    panel,
    places,
    words,
)
from docs.figures.table import figure


@figure("errata")
def errata() -> Figure:
    """Two of the slips: which angle is the absolute one, and how long a memory must be."""
    picture, (ax,) = canvas(8.6, 3.0, (0.0, 0.0, 0.5, 1.0))
    frame(ax, (-1.2, 5.3), (-3.5, 1.0))
    for left, lean, color, name in ((0.0, (0.4, 0.4, 0.4, 0.4), GREEN, "the text's:\n$\\phi_j = \\theta_1 + \\dots + \\theta_j$"), (3.1, (0.4, 0.4, 0.0, 0.0), ACCENT, "as printed:\n$\\theta_j + \\theta_{j-1}$")):
        chain(ax, places((left, 0.0), lean, (0.75,) * 4), 0.5)
        words(ax, (left + 0.75, 0.68), name, color=color, fontsize=8.5)
    words(ax, (2.1, -3.25), "the same $\\theta = (0.4, 0, 0, 0)$ rad", color=SOFT, fontsize=8.5)
    right = panel(picture, (0.6, 0.19, 0.38, 0.7), "$\\alpha$", "memory $L$")
    alpha, forgotten = np.linspace(0.08, 0.92, 85), 0.1
    right.semilogy(alpha, 1 / (forgotten**2 * gamma(alpha)), color=ACCENT, linestyle="--", label="as printed")
    right.semilogy(alpha, (1 / (forgotten * gamma(1 - alpha))) ** (1 / alpha), color=GREEN, label="what forgets 0.1 at most")
    right.set_ylim(1.0, 1e10)
    right.legend(fontsize=8)
    return picture


@figure("proof")
def proof() -> Figure:
    """The Programs and the Lagrangian, evaluated at one random point of a field; their difference must be zero."""
    picture, (ax,) = canvas(8.6, 3.0)
    frame(ax, (0.0, 16.0), (0.0, 5.6))
    box(ax, (1.5, 2.8), (2.4, 1.3), "scene\nSHA-256", color=INK, fontsize=8.5)
    box(ax, (5.1, 4.5), (2.9, 1.2), "Programs\n(what is printed as C)", color=ACCENT, fontsize=8.5)
    box(ax, (5.1, 1.1), (2.9, 1.2), "Model: $T,\\ V,\\ R$", color=BLUE, fontsize=8.5)
    box(ax, (5.1, 2.8), (2.9, 1.2), "random point modulo\n$p = 2^{61} - 1$", color=GREEN, fill="#f0f8f2", fontsize=8.5)
    box(ax, (10.0, 4.5), (3.2, 1.2), "$\\dot\\omega,\\ \\ddot q$: integers\nmodulo $p$", color=ACCENT, fontsize=8.5)
    box(ax, (10.0, 1.1), (3.2, 1.2), "$T$ and $V$ with\n$\\alpha^2 = \\beta^2 = 0$", color=BLUE, fontsize=8.5)
    box(ax, (14.4, 2.8), (2.7, 1.7), "$W(\\delta x) - u\\cdot\\delta x$\n\n$= 0$, exactly", color=INK, fontsize=8.5)
    for end in (4.5, 2.8, 1.1):
        arrow(ax, (2.7, 2.8), (3.65, end), color=SOFT)
    for y, color in ((4.5, ACCENT), (1.1, BLUE)):
        arrow(ax, (6.55, y), (8.4, y), color=color)
        arrow(ax, (6.55, 2.8), (8.4, y + (-0.35 if y > 2 else 0.35)), color=GREEN)
        arrow(ax, (11.6, y), (13.05, 3.3 if y > 2 else 2.3), color=color)
    words(ax, (9.9, 2.8), "rates, inputs, points of circles,\none random $\\delta x$", color=GREEN, fontsize=8.5)
    words(ax, (14.2, 0.95), "three points; a wrong Program\npasses one with $d/p$", color=SOFT, fontsize=8)
    return picture


@figure("horizon")
def horizon() -> Figure:
    """A neighbour that is pushed and brought back; what it says of the error, and until when a run holds."""
    picture = Figure(figsize=(8.6, 2.9))
    left = panel(picture, (0.06, 0.19, 0.4, 0.7), "time", "")
    t = np.linspace(0.0, 6.0, 241)
    path = 0.5 * np.sin(1.3 * t) + 0.2 * np.sin(2.9 * t)
    left.plot(t, path, color=INK, label="the run")
    for start in range(5):
        part = (t >= start * 1.2) & (t <= start * 1.2 + 1.2)
        off = 0.035 * np.exp(1.9 * (t[part] - start * 1.2)) * (1 if start % 2 else -1)
        left.plot(t[part], path[part] + off, color=ACCENT, linewidth=1.1, label="a neighbour, brought back" if not start else None)
    left.set_yticks([])
    left.set_ylim(-1.0, 1.35)
    left.legend(fontsize=8, loc="upper right")
    right = panel(picture, (0.57, 0.19, 0.41, 0.7), "time, s", "error")
    t = np.linspace(0.0, 60.0, 241)
    grown = np.minimum(2e-15 * np.exp(0.62 * t) * (1 + 0.4 * np.sin(1.7 * t)), 1.0)
    right.semilogy(t, grown, color=ACCENT, label="estimated")
    right.axhline(1e-4, color=INK, linewidth=1.0, linestyle="--")
    until = float(t[np.argmax(grown > 1e-4)])
    right.axvline(until, color=GREEN, linewidth=1.2)
    words(right, (until - 1.0, 3e-12), "holds_until", color=GREEN, ha="right", fontsize=8.5)
    words(right, (14.0, 6e-4), "what was asked", fontsize=8.5)
    words(right, (57.0, 3e-2), "lost", color=SOFT, fontsize=8.5)
    right.set_ylim(1e-16, 10.0)
    return picture
