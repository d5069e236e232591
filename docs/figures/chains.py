"""Sections 1 to 4: the chain, its angles, its bases, its joints."""

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
    angle,
    arrow,
    canvas,
    cart,
    chain,
    frame,
    joint,
    link,
    mass,
    panel,
    places,
    spring,
    turned,
    wall,
    words,
)
from docs.figures.table import figure


@figure("chain")
def one_chain() -> Figure:
    """A chain on a cart: lengths, places of the masses, unit vectors, and the place of mass a."""
    picture, (ax,) = canvas(7.4, 3.5)
    frame(ax, (-3.6, 6.2), (-4.45, 0.65))
    joints = places((0.0, 0.0), (0.75, 0.25, 0.95), (1.7, 1.5, 1.9))
    masses = chain(ax, joints, 0.62, base="cart")
    for k, (start, at) in enumerate(zip(joints, masses, strict=False), 1):
        words(ax, (at[0] + 0.1, at[1] + 0.34), f"$m_{k}$")
        lean = (0.75, 0.25, 0.95)[k - 1]
        x, y = turned(lean)
        end = start[0] + 0.62 * x, start[1] + 0.62 * y
        arrow(ax, start, end, f"$q_{k}$", color=BLUE, off=(-0.3 * math.cos(lean), -0.3 * math.sin(lean)))
    words(ax, (0.0, 0.37), "$m_0$")
    last, end, lean = joints[2], joints[3], 0.95
    off = -0.34 * math.cos(lean), -0.34 * math.sin(lean)
    ends = [(place[0] + 1.1 * off[0], place[1] + 1.1 * off[1]) for place in (last, masses[2])]
    arrow(ax, ends[0], ends[1], "$r_3$", color=SOFT, off=(-0.14, -0.18), arrowstyle="<|-|>", mutation_scale=7)
    near = [(place[0] + 2.1 * off[0], place[1] + 2.1 * off[1]) for place in (last, end)]
    arrow(ax, near[0], near[1], "$l_3$", color=SOFT, off=(-0.14, -0.18), arrowstyle="<|-|>", mutation_scale=7)
    arrow(ax, (-2.9, 0.0), (-0.5, 0.0), "$C x$", color=SOFT, off=(0.0, 0.24))
    arrow(ax, (-2.9, 0.0), masses[2], color=GREEN, linewidth=1.0, linestyle=(0, (4, 3)))
    words(ax, (-1.15, -2.6), "$r_3 = C x + l_1 q_1 + l_2 q_2 + r_3 q_3$", color=GREEN, fontsize=9)
    arrow(ax, (5.2, -0.5), (5.2, -1.5), "$e_d,\\ g$", off=(0.42, 0.0))
    arrow(ax, (-2.9, 0.0), (-2.9, -0.8), "", color=INK)
    arrow(ax, (-2.9, 0.0), (-2.1, 0.0), "", color=INK)
    words(ax, (-3.2, -0.7), "$e_d$")
    words(ax, (-2.2, 0.25), "$e_1$")
    return picture


@figure("rigid-links")
def rigid_links() -> Figure:
    """From the tip to the base: a rigid link becomes a point at its centre of percussion and a mass at its joint."""
    picture, (ax,) = canvas(7.4, 2.7)
    frame(ax, (-0.5, 10.6), (-1.75, 2.3))
    wall(ax, (1.0, 1.72), 0.6)
    for x, name in ((1.0, "link $k - 1$"), (4.4, "link $k$"), (7.8, "link $k + 1$")):
        link(ax, (x, 1.5), (x + 2.6, 1.5), width=13)
        joint(ax, (x, 1.5))
        mass(ax, (x + 1.25, 1.5), 0.07)
        words(ax, (x + 1.6, 2.05), f"{name}: $m,\\ r,\\ J,\\ l$", fontsize=8)
    for x in (1.0, 4.4, 7.8):
        link(ax, (x, -0.5), (x + 2.6, -0.5), width=2.5)
        mass(ax, (x + 1.75, -0.5), 0.13)
        words(ax, (x + 1.85, -0.95), "$m' = a^2/b$", fontsize=8.5)
        mass(ax, (x, -0.5), 0.1, ACCENT)
        arrow(ax, (x, -1.25), (x + 1.75, -1.25), "$r' = b/a$", color=SOFT, off=(0.0, -0.22), arrowstyle="<|-|>", mutation_scale=6, fontsize=8.5)
        arrow(ax, (x + 1.3, 1.2), (x + 1.3, -0.22), color=GREEN)
    for x in (1.0, 4.4, 7.8):
        words(ax, (x - 0.02, -0.95), "$e'$", color=ACCENT, fontsize=9)
    for left, right in ((3.6, 4.3), (7.0, 7.7)):
        arrow(ax, (right + 0.06, -0.32), (left + 0.02, 1.18), "becomes\nits $e$", color=ACCENT, off=(-0.62, -0.1), fontsize=8)
    words(ax, (0.12, -0.5), "to the cart,\nor nobody", color=ACCENT, fontsize=7.5, ha="center")
    return picture


@figure("angles")
def angles() -> Figure:
    """The same chain in absolute, relative and adjacent angles."""
    picture, areas = canvas(7.4, 2.9, *((k / 3, 0.0, 1 / 3, 1.0) for k in range(3)))
    lean = (0.4, 1.2, 0.3)
    for kind, ax in zip(("absolute", "relative", "adjacent"), areas, strict=True):
        frame(ax, (-1.0, 2.7), (-3.6, 0.75))
        joints = places((0.0, 0.0), lean, (1.15, 1.15, 1.15))
        chain(ax, joints, 0.5)
        words(ax, (0.9, 0.55), f'"{kind}"', fontsize=9)
        since_before = 0.0
        for k, place in enumerate(joints[:-1]):
            since = 0.0 if kind == "absolute" or not k else lean[k - 1]
            if kind == "adjacent" and k:
                since = lean[k - 1] - since_before
            since_before = since
            x, y = turned(since)
            ax.plot([place[0], place[0] + 0.95 * x], [place[1], place[1] + 0.95 * y], color=SOFT, linewidth=0.9, linestyle=(0, (4, 3)))
            radius = 0.62
            angle(ax, place, radius, since, lean[k], color=ACCENT)
            middle = (since + lean[k]) / 2
            x, y = turned(middle)
            out = 0.92
            words(ax, (place[0] + out * x, place[1] + out * y), f"$\\theta_{k + 1}$", color=ACCENT, fontsize=9)
    words(areas[0], (0.3, -3.4), "$\\theta_k = \\phi_k$")
    words(areas[1], (0.3, -3.4), "$\\theta_k = \\phi_k - \\phi_{k-1}$")
    words(areas[2], (0.3, -3.4), "$\\phi_k = \\theta_k + \\theta_{k-1}$")
    return picture


def _tilted(x: float, y: float, z: float) -> tuple[float, float]:
    """A place in space as the picture has it; z counts downwards."""
    return x + 0.45 * y, -z + 0.28 * y


@figure("cart-chain")
def cart_chain() -> Figure:
    """Unit vectors and angular velocities of a chain in space, on a cart that moves in the plane."""
    picture, (ax,) = canvas(7.4, 3.3)
    frame(ax, (-2.7, 7.3), (-3.4, 1.05))
    plane = [_tilted(*corner) for corner in ((-1.6, -1.2, 0.2), (2.4, -1.2, 0.2), (2.4, 1.6, 0.2), (-1.6, 1.6, 0.2))]
    ax.fill([x for x, _ in plane], [y for _, y in plane], color="#f3f5f8")
    cart(ax, (0.0, 0.0))
    q = [np.array((0.55, 0.25, 0.8)), np.array((-0.3, 0.6, 0.74))]
    q = [entry / np.linalg.norm(entry) for entry in q]
    middle, tip = 1.7 * q[0], 1.7 * q[0] + 1.7 * q[1]
    joints = [(0.0, 0.0), _tilted(*middle), _tilted(*tip)]
    chain(ax, joints, 1.0, base="none")
    for k, (start, vector) in enumerate(zip(joints, q, strict=False), 1):
        end = start[0] + 0.9 * _tilted(*vector)[0], start[1] + 0.9 * _tilted(*vector)[1]
        arrow(ax, start, end, f"$q_{k}$", color=BLUE, off=(0.3, 0.1))
        spin = np.cross(vector, np.array((0.1, -1.0, 0.3)))
        spin = _tilted(*(0.75 * spin / np.linalg.norm(spin)))
        arrow(ax, start, (start[0] + spin[0], start[1] + spin[1]), color=ACCENT)
        words(ax, (start[0] + 1.3 * spin[0], start[1] + 1.3 * spin[1] + 0.05), f"$\\omega_{k}$", color=ACCENT)
    arrow(ax, (-1.6, 0.0), (-0.5, 0.0), "$u$", color=GREEN, off=(0.0, 0.2))
    origin = (-2.1, -2.0)
    for vector, name in (((0.8, 0, 0), "$e_1$"), ((0, 1.1, 0), "$e_2$"), ((0, 0, 0.8), "$e_3,\\ g$")):
        x, y = _tilted(*vector)
        arrow(ax, origin, (origin[0] + x, origin[1] + y))
        words(ax, (origin[0] + 1.32 * x + (0.22 if "3" in name else 0.0), origin[1] + 1.32 * y), name)
    for row, (text, color) in enumerate((
        ("$\\dot q_k = \\omega_k \\times q_k$    (17)", INK),
        ("(15): $(q, \\dot q) \\to \\ddot q_k$", BLUE),
        ("$q_i \\times$ row $i$  $\\downarrow$      $\\uparrow$  row $i$ $\\times\\ q_i$", SOFT),
        ("(16): $(q, \\omega) \\to \\dot\\omega_k$", ACCENT),
        ("(19): small motions about $q_k = s_k e_3$", GREEN),
    )):  # fmt: skip
        words(ax, (3.3, 0.15 - 0.68 * row), text, color=color, ha="left", fontsize=10)
    return picture


@figure("given-base")
def given_base() -> Figure:
    """A base that is pushed, and two that are told where to go."""
    picture, areas = canvas(7.4, 2.5, *((k / 3, 0.0, 1 / 3, 1.0) for k in range(3)))
    titles = ("a cart that is pushed:\n$u$ is a force", 'drive = "acceleration":\n$u = \\ddot x$', 'base = "moving":\n$u$ begins with $b$')
    for k, (ax, title) in enumerate(zip(areas, titles, strict=True)):
        frame(ax, (-2.1, 2.1), (-2.2, 1.4))
        joints = places((0.0, 0.0), (0.5, -0.2), (0.8, 0.8))
        chain(ax, joints, 1.0, base="none" if k == 2 else "cart")
        words(ax, (0.0, 1.12), title, fontsize=8.5)
    arrow(areas[0], (-1.5, 0.0), (-0.5, 0.0), "$u$", color=ACCENT, off=(0.0, 0.2))
    words(areas[0], (0.0, -2.02), "$\\ddot x$ is a result", color=BLUE, fontsize=8.5)
    arrow(areas[1], (0.5, 0.0), (1.5, 0.0), "$\\ddot x$", color=ACCENT, off=(0.0, 0.24))
    words(areas[1], (0.0, -2.02), "the force is what inverse dynamics says", color=BLUE, fontsize=8)
    arrow(areas[2], (0.0, 0.0), (0.85, 0.3), "$b$", color=ACCENT, off=(-0.05, 0.25))
    words(areas[2], (0.0, -2.02), "a wall under the gravity $g e_d - b$", color=BLUE, fontsize=8)
    return picture


@figure("joints")
def joints() -> Figure:
    """Spring, damper and rotor at a joint; dry friction against the relative rate."""
    picture, (ax,) = canvas(7.4, 2.7, (0.0, 0.0, 0.55, 1.0))
    frame(ax, (-1.9, 3.0), (-2.3, 0.95))
    start, inner, outer = (-1.25, 0.45), 0.95, 0.35
    bend = (start[0] + 1.6 * turned(inner)[0], start[1] + 1.6 * turned(inner)[1])
    end = (bend[0] + 1.9 * turned(outer)[0], bend[1] + 1.9 * turned(outer)[1])
    link(ax, start, bend)
    link(ax, bend, end)
    x, y = turned(inner)
    ax.plot([bend[0], bend[0] + 1.3 * x], [bend[1], bend[1] + 1.3 * y], color=SOFT, linewidth=0.9, linestyle=(0, (4, 3)))
    angle(ax, bend, 1.0, outer, inner, "$\\vartheta_k$", color=ACCENT, away=0.22)
    spring(ax, bend, 0.42, outer, inner, color=GREEN)
    joint(ax, start)
    joint(ax, bend, 0.2)
    joint(ax, bend, 0.06)
    words(ax, (start[0] - 0.2, -0.35), "link $k - 1$", fontsize=8.5)
    words(ax, (end[0] - 0.62, end[1] + 0.35), "link $k$", fontsize=8.5)
    rows = (("spring  $k_k\\vartheta_k$", GREEN), ("damper  $d_k\\dot\\vartheta_k$", BLUE), ("friction  $F_k\\tanh(\\dot\\vartheta_k/v_0)$", ACCENT), ("rotor  $A_k\\ddot\\vartheta_k$", INK))
    for row, (text, color) in enumerate(rows):
        words(ax, (1.15, 0.6 - 0.36 * row), text, color=color, fontsize=9, ha="left")
    curve = panel(picture, (0.66, 0.2, 0.32, 0.7), "$\\dot\\vartheta\\,/\\,v_0$", "torque $/\\,F$")
    rate = np.linspace(-4.0, 4.0, 161)
    curve.plot(rate, np.tanh(rate), color=ACCENT)
    curve.plot(rate[60:101], rate[60:101], color=SOFT, linewidth=1.0, linestyle="--")
    words(curve, (2.6, 0.3), "slope $F/v_0$ at rest", color=SOFT, fontsize=8)
    words(curve, (2.4, -0.55), "$F\\,\\tanh(v/v_0)$", color=ACCENT)
    return picture
