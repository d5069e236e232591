"""Forward dynamics where it is hard: masses, lengths, postures and rates over many decades."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from benchmarks.stability.cases.case import Case

PI = 3.141592653589793


def _planar(
    name: str,
    title: str,
    seed: int,
    links: int,
    q: Sequence[float] | None = None,
    rate: float = 1.0,
    **chain: Any,
) -> Case:
    """A planar chain at random angles (or at q), rates of about `rate`."""
    rng = np.random.default_rng(seed)
    size = links + int(chain.get("base") == "cart")
    angles = rng.uniform(-PI, PI, size) if q is None else np.asarray(q, dtype=float)
    rates = rate * rng.standard_normal(size)
    means = chain.pop("means", "oracle")
    return Case(
        name, title, "dynamics", {"links": links, "mass": 1.0, "length": 1.0, "actuated": "none", **chain},
        tuple(angles.tolist()), tuple(rates.tolist()), means=means,
    )  # fmt: skip


def _spatial(
    name: str, title: str, seed: int, links: int, q: Any = None, rate: float = 1.0, **chain: Any
) -> Case:
    """A spatial chain at random directions (or at q), tangent rates of about `rate`."""
    rng = np.random.default_rng(seed)
    q = rng.standard_normal((links, 3)) if q is None else np.asarray(q, dtype=float)
    q = q / np.linalg.norm(q, axis=1)[:, None]
    w = rate * rng.standard_normal((links, 3))
    w -= np.sum(w * q, axis=1)[:, None] * q
    on_cart = [0.0, 0.0] if chain.get("base") == "cart" else []
    means = chain.pop("means", "oracle")
    return Case(
        name, title, "dynamics",
        {"links": links, "space": "spatial", "mass": 1.0, "length": 1.0, "actuated": "none", **chain},
        (*on_cart, *q.ravel().tolist()), (*on_cart, *w.ravel().tolist()), means=means,
    )  # fmt: skip


def cases() -> list[Case]:
    """All of them."""
    wide, light = [1e8, 1.0] * 3, {"base": "cart", "cart_mass": 1e-6}
    poles = [[0, 0, 1], [0, 0, -1], [1, 0, 0], [0, 1, 0]]
    return [
        _planar("D01", "masses 1e8 and 1 in turn, N = 6", 1, 6, mass=wide),
        _planar("D02", "lengths 1e-4 .. 1e4, N = 5", 2, 5, length=np.logspace(-4, 4, 5).tolist()),
        _planar(
            "D03", "masses 1e-8 .. 1e8 on lengths 1e4 .. 1e-4, mass half way, N = 12", 3, 12,
            mass=np.logspace(-8, 8, 12).tolist(), length=np.logspace(4, -4, 12).tolist(),
            com=(np.logspace(4, -4, 12) / 2).tolist(),
        ),
        _planar("D04", "N = 256, masses half way", 4, 256, length=1 / 256, mass=1 / 256, com=1 / 512, means="engine"),
        _spatial("D05", "N = 256 in space, on a cart", 5, 256, length=1 / 256, mass=1 / 256, base="cart", cart_mass=0.5,
                 means="engine"),
        _planar("D06", "inverted chain, 1e-9 rad off, N = 16", 6, 16, q=[PI + 1e-9, *([1e-9] * 15)], rate=1e-9),
        _planar("D07", "folded chain, masses 1 and 1e-4, N = 12", 7, 12, q=[0.3, *([PI] * 11)], mass=[1.0, 1e-4] * 6),
        _planar("D08", "angles of 1e6 rad, N = 4", 8, 4, q=[1e6, -1e6 + 0.5, 1e6 + 1.0, 123456.789], com=0.5),
        _planar("D09", "rates of 1e4 rad/s on a cart, N = 4", 9, 4, rate=1e4, com=0.5, base="cart", cart_mass=0.7),
        _planar("D10", "cart of 1e-6, N = 4", 10, 4, com=0.5, **light),
        _planar("D11", "cart of 1e6, N = 4", 11, 4, com=0.5, base="cart", cart_mass=1e6),
        _spatial("D12", "links at both poles and along the horizon, fixed base", 12, 4, q=poles),
        _spatial("D13", "links at both poles and along the horizon, cart of 1e-6, masses half way", 13, 4, q=poles, com=0.5,
                 **light),
        _planar("D14", "masses at 1e-8 of the links' lengths, N = 3", 14, 3, com=1e-8),
        _spatial("D15", "straight chain in space, 1e-7 rad off, light inside, N = 8", 15, 8, rate=1e-3,
                 q=[[1e-7 * (-1) ** k, 0, 1] for k in range(8)], mass=[1e-8] * 7 + [1.0]),
        _planar("D16", "springs of 1e12 and dampers of 1e6, N = 4", 16, 4, stiffness=1e12, damping=1e6),
        _planar("D17", "single precision, paper A's chain of four", 17, 4, mass=0.25, length=0.25, com=0.125, real="float"),
        _spatial("D18", "single precision, paper B's chain of five", 18, 5, mass=0.1, length=0.1, base="cart",
                 cart_mass=0.5, real="float"),
    ]  # fmt: skip
