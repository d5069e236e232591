"""Motions that are long, stiff, fast, nearly unstable, or lead a step control astray."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from benchmarks.stability.cases.case import Case

PI = 3.141592653589793
G = 9.81


def _case(
    name: str, title: str, times: Sequence[float], q: Sequence[float], v: Sequence[float] | None = None, *,
    kind: str = "motion", means: str = "extrapolation", side: float | None = None, slow: bool = False, **chain: Any,
) -> Case:  # fmt: skip
    """A planar chain of unit masses and lengths unless said otherwise; at rest unless rates are given."""
    on_cart = int(chain.get("base") == "cart")
    full = {"links": len(q) - on_cart, "mass": 1.0, "length": 1.0, "actuated": "none", **chain}
    rates = [0.0] * len(q) if v is None else v
    floats = [tuple(float(x) for x in values) for values in (q, rates, times)]
    return Case(name, title, kind, full, floats[0], floats[1], (), floats[2], means, side, slow)


def _spatial(
    name: str, title: str, times: Sequence[float], q: Any, w: Any, *, means: str = "extrapolation", slow: bool = False,
    **chain: Any,
) -> Case:  # fmt: skip
    """A spatial chain; directions are normalised and rates made tangent."""
    q, w = np.asarray(q, dtype=float), np.asarray(w, dtype=float)
    q = q / np.linalg.norm(q, axis=1)[:, None]
    w = w - np.sum(w * q, axis=1)[:, None] * q
    on_cart = [0.0, 0.0] if chain.get("base") == "cart" else []
    full = {"links": len(q), "space": "spatial", "mass": 1.0, "length": 1.0, "actuated": "none", **chain}
    state = (*on_cart, *q.ravel().tolist()), (*on_cart, *w.ravel().tolist())
    return Case(name, title, "motion", full, *state, (), tuple(float(t) for t in times), means, None, slow)


def one_link() -> list[Case]:
    """A single link: near the separatrix and over many periods, against elliptic functions."""
    turn = 2 * np.sqrt(G)  # the rate at the bottom that just reaches the top
    period = 16.155483000352195  # of amplitude 3.14 rad, about: only a time to stop at
    return [
        _case("S01", "N = 1 from rest at the last double below pi", (5, 12, 14), [np.nextafter(PI, 0)], means="elliptic", side=14),
        _case("S02", "N = 1, 1e-12 below the separatrix", (5, 10, 20), [0.0], [turn * (1 - 1e-12)], means="elliptic", side=20),
        _case("S03", "N = 1, 1e-12 above the separatrix", (5, 10, 20), [0.0], [turn * (1 + 1e-12)], means="elliptic", side=20),
        _case("S04", "N = 1, 3.1 rad, 1000 periods, at mid-swing", (3.6, 3602.4), [3.1], means="elliptic", slow=True),
        _case("S05", "N = 1, 3.14 rad, 20 periods", (10, 20 * period), [3.14], means="elliptic"),
    ]  # fmt: skip


def regular_and_chaotic() -> list[Case]:
    """Several links without stiffness: long, folded, inverted, fast, wide of range, chaotic."""
    half = {"mass": 0.5, "length": 0.5, "com": 0.25}
    quarter = {"mass": 0.25, "length": 0.25, "com": 0.125}
    return [
        _case("S06", "energy over 1e4 s, N = 2 at 0.4 rad", (1e4,), [0.4, 0.0], kind="energy", means="constant", slow=True, **half),
        _case("S07", "energy over 1e4 s, N = 4 at 0.4 rad", (1e4,), [0.4, 0, 0, 0], kind="energy", means="constant", slow=True, **quarter),
        _case("S08", "energy over 100 s, N = 4 at 2 rad (chaotic)", (100,), [2.0, 0, 0, 0], kind="energy", means="constant", **quarter),
        _case("S09", "chaotic, N = 2 at 2 rad, 10 s", (5, 10), [2.0, 0.0], **half),
        _case("S10", "angles of 1e6 rad, N = 2, 10 s", (1, 10), [1e6, 1e6], **half),
        _case("S11", "rates of 1e4 rad/s, N = 2, 0.01 s", (0.001, 0.01), [0.3, 1.0], [1e4, -2e4], **half),
        _case("S12", "folded chain of 8 released, 1 s", (0.5, 1), [1.2, *([PI] * 7)]),
        _case("S13", "inverted chain of 4, 1e-3 rad off, 2 s", (1, 2), [PI - 1e-3, 0, 0, 0]),
        _case("S14", "heavy tip, 1e8 : 1, N = 2, 5 s", (1, 5), [1.0, 0.5], mass=[1.0, 1e8]),
        _case("S15", "light tip, 1e-8 : 1, N = 2, 5 s", (1, 5), [1.0, 0.5], mass=[1.0, 1e-8]),
        _case("S16", "lengths 1 and 1e-8, N = 2, 0.01 s", (0.001, 0.01), [1.0, 0.5], length=[1.0, 1e-8]),
        _case("S17", "N = 64 released from the horizontal, 0.2 s", (0.05, 0.2), [PI / 2, *([0] * 63)], length=1 / 64, mass=1 / 64, slow=True),
        _case("S37", "N = 256 released from the horizontal, 0.02 s", (0.01, 0.02), [PI / 2, *([0] * 255)], length=1 / 256,
              mass=1 / 256, means="sweep", slow=True),
        _case("S18", "N = 16 released from the horizontal, 1 s", (0.5, 1), [PI / 2, *([0] * 15)], length=1 / 16, mass=1 / 16),
        _case("S20", "cart of 1e-6, N = 2, 2 s", (0.5, 2), [0.0, 0.5, 0.3], base="cart", cart_mass=1e-6, **half),
        _case("S21", "cart of 1e6, N = 2, 2 s", (0.5, 2), [0.0, 0.5, 0.3], base="cart", cart_mass=1e6, **half),
        _case("S22", "single precision, N = 2 at 0.4 rad, 10 s", (1, 10), [float(np.float32(0.4)), 0.0], real="float", **half),
    ]  # fmt: skip


def stiff() -> list[Case]:
    """Joint springs of 1e3 and 1e6 times the gravity frequency, dampers, overdamped joints."""
    hard, soft = G * 1e12, G * 1e6  # k = (ratio sqrt(g/l))^2 m l^2 with m = l = 1
    rest = {"mass": 1.0, "length": 1.0}
    return [
        _case("S23", "spring at 1e3 x the gravity frequency, undamped, N = 2, 1 s", (0.1, 1), [1.0, 1e-3], stiffness=[0, soft], **rest),
        _case("S24", "spring at 1e6 x the gravity frequency, undamped, N = 2, 0.1 ms", (1e-5, 1e-4), [1.0, 1e-6], stiffness=[0, hard], **rest),
        _case("S25", "spring at 1e3 x, half critically damped, N = 2, 5 s", (0.01, 5), [1.0, 1e-3], stiffness=[0, soft],
              damping=[0, float(np.sqrt(soft / 2))], means="radau", **rest),
        _case("S26", "spring at 1e6 x, critically damped, N = 2, 5 s", (1e-4, 5), [1.0, 1e-6], stiffness=[0, hard],
              damping=[0, float(2 * np.sqrt(hard / 2))], means="radau", **rest),
        _case("S27", "overdamped joints, d = 1e6, N = 2, 1e4 s", (1, 1e4), [1.0, 0.5], damping=1e6, means="radau", **rest),
        _case("S28", "overdamped joints with springs, N = 4, 100 s", (0.1, 100), [1.0, 0.5, -0.5, 0.2], damping=1e4,
              stiffness=1e3, means="radau", **rest),
        _case("S29", "springs and dampers at both joints, masses 1e4 apart, N = 2, 2 s", (0.1, 2), [0.5, 0.2],
              mass=[1.0, 1e-4], length=1.0, stiffness=1e4, damping=10.0, means="radau"),
    ]  # fmt: skip


def spatial() -> list[Case]:
    """Unit vectors through both poles, along the horizon, whirling, on light and heavy carts."""
    lean = float(np.sin(0.7)), float(np.cos(0.7))
    fig2 = {"mass": 0.1, "length": 0.1, "base": "cart", "cart_mass": 0.5}
    return [
        _spatial("S30", "fixed base, n = 1, a loop through both poles, 5 s", (1, 5), [[0, 0, 1]], [[7.0, 0, 0]]),
        _spatial("S31", "fixed base, n = 2, along the horizon at 30 rad/s, 2 s", (0.5, 2), [[1, 0, 0], [0, 1, 0]],
                 [[0, 0, 30], [0, 0, 30]], length=0.5),
        _spatial("S32", "whirling at 1e3 rad/s, n = 2 on a cart, 0.1 s", (0.01, 0.1), [[1, 0, 1e-5], [1, 0, 1e-5]],
                 [[0, 0, 1e3], [0, 0, 1e3]], base="cart", cart_mass=2.0),
        _spatial("S33", "cart of 1e-6, n = 2, 1 s", (0.2, 1), [[lean[0], 0, lean[1]], [0, 0.2, 0.9]],
                 [[0, 1, 0], [1, 0, 0]], base="cart", cart_mass=1e-6),
        _spatial("S34", "cart of 1e6, n = 2, 2 s", (0.5, 2), [[lean[0], 0, lean[1]], [0, 0.2, 0.9]],
                 [[0, 1, 0], [1, 0, 0]], base="cart", cart_mass=1e6),
        _spatial("S35", "n = 5 of paper B on a cart, links up and level, 2 s", (0.5, 2),
                 [[0, 0, -1], [1, 0, 0], [0, 1, 0], [0, 0, 1], [-1, 0, 0]],
                 [[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0], [0, 0, 1]], **fig2),
        _spatial("S36", "springs at 1e3 x the gravity frequency with dampers, n = 2, 1 s", (0.1, 1),
                 [[lean[0], 0, lean[1]], [lean[0], 0.01, lean[1]]], [[0, 1, 0], [0, 1, 0]],
                 stiffness=[0, G * 1e6], damping=[0, 2e3], means="radau"),
    ]  # fmt: skip


def cases() -> list[Case]:
    """All of them."""
    return [*one_link(), *regular_and_chaotic(), *stiff(), *spatial()]
