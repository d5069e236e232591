"""Section 8: the Lie-group step and the variational step."""

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
    chart,
    frame,
    joint,
    mass,
    panel,
    sphere,
    steps,
    words,
)
from docs.figures.table import figure


@figure("lie4")
def lie4() -> Figure:
    """Rates live in the plane across q(0); rotations carry them to where the stages are."""
    picture, (ax, flow) = canvas(8.6, 3.2, (0.0, 0.0, 0.33, 1.0), (0.33, 0.0, 0.67, 1.0))
    frame(ax, (-1.75, 1.85), (-1.75, 2.1))
    sphere(ax, (0.0, 0.0), 1.35)
    chart(ax, [(-0.95, 1.0), (0.55, 1.0), (1.15, 1.75), (-0.35, 1.75)])
    start, end = (0.1, 1.33), (1.12, 0.66)
    arrow(ax, (0.0, 0.0), start, color=BLUE)
    words(ax, (-0.36, 0.75), "$q_k(0)$", color=BLUE)
    arrow(ax, (0.0, 0.0), end, "$q_k$", color=BLUE, off=(0.28, -0.2))
    arrow(ax, start, (0.85, 1.55), "$\\eta_k$", color=ACCENT, off=(0.05, 0.28))
    arrow(ax, end, (1.62, 0.15), "$\\omega_k$", color=ACCENT, off=(0.1, 0.25))
    arrow(ax, (0.3, 1.22), (1.02, 0.8), color=GREEN, connectionstyle="arc3,rad=-0.2")
    words(ax, (0.42, 0.78), "$R_k$", color=GREEN)
    frame(flow, (0.0, 10.6), (0.1, 5.75))
    words(flow, (5.3, 5.4), "each of four stages, on every link", color=SOFT, fontsize=8.5)
    texts = ("$\\Theta,\\ \\eta$\nfrom the slopes\nbefore", "$R = \\exp\\hat\\Theta$\n$q = R\\,q(0)$\n$\\omega = R\\,\\eta$", "forward\ndynamics:\n$\\dot\\omega(q, \\omega)$", "$\\dot\\eta = R^T\\dot\\omega$\n$\\dot\\Theta = \\eta + \\frac{1}{2}\\Theta\\times\\eta$\n$+\\ \\dots$")
    steps(flow, [(1.15, 3.9), (3.8, 3.9), (6.45, 3.9), (9.3, 3.9)], (2.0, 1.55), texts, (INK, GREEN, BLUE, ACCENT))
    arrow(flow, (9.3, 3.1), (1.15, 3.1), "stages 2 to 4", color=SOFT, off=(0.0, -1.05), connectionstyle="arc3,rad=-0.14")
    steps(flow, [(3.4, 0.95), (7.7, 0.95)], (3.6, 1.0), ("sums with $\\frac{1}{6}, \\frac{1}{3}, \\frac{1}{3}, \\frac{1}{6}$", "one rotation: $q(h),\\ \\omega(h)$"), (INK, GREEN))
    return picture


@figure("variational")
def variational() -> Figure:
    """A step between two configurations, multipliers along the links at either end."""
    picture, (ax, flow) = canvas(8.6, 3.2, (0.0, 0.0, 0.36, 1.0), (0.36, 0.0, 0.64, 1.0))
    frame(ax, (-2.0, 2.2), (-2.15, 1.75))
    joint(ax, (-0.2, 1.2))
    first, second = (-1.15, -1.05), (1.05, -0.97)
    for lean in (k / 30 for k in range(-27, 28, 2)):
        x, y = math.sin(lean), -math.cos(lean)
        ax.plot([-0.2 + 2.44 * x, -0.2 + 2.44 * math.sin(lean + 0.03)], [1.2 + 2.44 * y, 1.2 - 2.44 * math.cos(lean + 0.03)], color=SOFT, linewidth=1.0)
    for place, name, side in ((first, "$z_0$", -0.3), (second, "$z_1$", 0.3)):
        ax.plot([-0.2, place[0]], [1.2, place[1]], color="#c3cad4", linewidth=3.0, zorder=1)
        mass(ax, place, 0.12)
        words(ax, (place[0] + side, place[1] - 0.1), name)
    arrow(ax, first, second, "$h\\,w$", color=BLUE, off=(0.1, 0.25))
    arrow(ax, first, (first[0] + 0.28, first[1] + 0.68), color=ACCENT)
    words(ax, (first[0] - 0.1, first[1] + 0.72), "$\\lambda q_0$", color=ACCENT)
    arrow(ax, second, (second[0] - 0.36, second[1] + 0.64), color=ACCENT)
    words(ax, (second[0] + 0.12, second[1] + 0.72), "$\\kappa q_1$", color=ACCENT)
    arrow(ax, first, (first[0] + 0.85, first[1] - 0.55), color=GREEN)
    words(ax, (first[0] + 1.05, first[1] - 0.72), "$\\dot z_0$", color=GREEN)
    arrow(ax, second, (second[0] + 0.8, second[1] + 0.45), color=GREEN)
    words(ax, (second[0] + 0.92, second[1] + 0.68), "$\\dot z_1$", color=GREEN)
    frame(flow, (0.0, 10.4), (0.0, 6.0))
    box(flow, (2.0, 4.6), (3.3, 1.7), "$M a = F_0 - V' + \\lambda q_0$\n$(q_0 + h w)\\cdot a = \\dots$", color=ACCENT, fontsize=8.5)
    box(flow, (6.9, 4.6), (3.0, 1.7), "$w = \\dot z_0 + \\frac{h}{2}\\,a$\nso that $|q_0 + h w| = 1$", color=BLUE, fontsize=8.5)
    arrow(flow, (3.65, 4.95), (5.4, 4.95), "$a_0$", color=SOFT, off=(0.0, 0.3))
    arrow(flow, (5.4, 4.25), (3.65, 4.25), "Newton: 5 calls", color=SOFT, off=(0.0, -0.32), fontsize=8)
    steps(flow, [(1.75, 1.55), (5.2, 1.55), (8.7, 1.55)], (2.9, 1.6),
          ("$z_1 = z_0 + h w$\nresidual, unit\nvectors", "$M a_1 = F_1 - V'$\n$+\\ \\kappa q_1$\nthe sixth call", "$\\dot z_1 = w + \\frac{h}{2} a_1$\nacross $q_1$"), (GREEN, ACCENT, BLUE))  # fmt: skip
    arrow(flow, (6.9, 3.75), (1.75, 2.35), color=SOFT)
    return picture


@figure("structure")
def structure() -> Figure:
    """The energy of a pendulum (m = l = g = 1, at rest at 1.5 rad) by the classical method and by the variational one, steps of 0.7."""
    picture = Figure(figsize=(7.4, 2.5))
    ax = panel(picture, (0.1, 0.2, 0.87, 0.72), "time, s", "energy less its start, J")
    count, h = 600, 0.7
    start = -math.cos(1.5)
    for run, color, name in ((_variational, BLUE, "step_variational"), (_classical, ACCENT, "step: classical Runge-Kutta")):
        energy = np.array(run(count, h)) - start
        ax.plot(h * np.arange(count + 1), energy, color=color, linewidth=0.7, label=name)
    ax.set_ylim(-0.42, 0.16)
    ax.legend(fontsize=8, loc="upper right", ncols=2)
    return picture


def _classical(count: int, h: float) -> list[float]:
    """Energies of phi'' = -sin phi by Runge and Kutta's method."""
    x, found = np.array((1.5, 0.0)), [-math.cos(1.5)]
    for _ in range(count):
        slopes = [_slope(x)]
        for part in (0.5, 0.5, 1.0):
            slopes.append(_slope(x + part * h * slopes[-1]))
        x = x + h / 6 * (slopes[0] + 2 * slopes[1] + 2 * slopes[2] + slopes[3])
        found.append(0.5 * x[1] ** 2 - math.cos(x[0]))
    return found


def _slope(x: np.ndarray) -> np.ndarray:
    return np.array((x[1], -math.sin(x[0])))


def _variational(count: int, h: float) -> list[float]:
    """The same by multipliers along the unit vector at either end; e is along gravity."""
    e, q, v = np.array((0.0, 1.0)), np.array((math.sin(1.5), math.cos(1.5))), np.zeros(2)
    found = [float(-q @ e)]
    for _ in range(count):
        free = q + h * v + h * h / 2 * e
        along = free @ q
        q_next = free + (math.sqrt(along * along - free @ free + 1) - along) * q
        v = (q_next - q) / h + h / 2 * e
        q, v = q_next, v - (v @ q_next) * q_next
        found.append(float(v @ v / 2 - q @ e))
    return found
