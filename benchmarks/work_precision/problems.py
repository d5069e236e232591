"""The motions that integrators are timed on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.stability.cases.case import Case


@dataclass(frozen=True)
class Work:
    """A motion with what is tried on it.

    Attributes:
        case: The chain, its start, and the time it is followed to; its reference is in references.json.
        words: What it stands for.
        forms: heyoka's formulations, best guesses of an expert.
        stiff: Whether explicit methods are left out.
    """

    case: Case
    words: str
    forms: tuple[str, ...]
    stiff: bool = False


def _chain_a(links: int) -> dict[str, object]:
    part = 1.0 / links
    return {"links": links, "mass": part, "length": part, "com": part / 2, "actuated": "none"}


def _released(name: str, title: str, links: int, angle: float, end: float) -> Case:
    q = (angle, *([0.0] * (links - 1)))
    return Case(name, title, "motion", _chain_a(links), q, (0.0,) * links, times=(end,))


def _tumbling() -> Case:
    """Paper B, Fig. 2: near the saddle (-, -, +, +, +), the cart rolling at 0.1 m/s."""
    side, down = float(np.sin(np.radians(1.0))), float(np.cos(np.radians(1.0)))
    links = np.array([[0, 0, -1], [-side, 0, -down], [side, 0, down], [0, 0, 1], [0, 0, 1]])
    chain = {"links": 5, "space": "spatial", "base": "cart", "mass": 0.1, "length": 0.1, "cart_mass": 0.5,
             "actuated": "none"}  # fmt: skip
    q, v = (0.0, 0.0, *links.ravel().tolist()), (0.1, 0.0, *([0.0] * 15))
    return Case(
        "W4", "n = 5 in space on a cart, paper B's Fig. 2, T = 2 s", "motion", chain, q, v, times=(2.0,)
    )


def _stiff() -> Case:
    chain = {
        "links": 2,
        "mass": 1.0,
        "length": 1.0,
        "damping": [0.0, 3e6],
        "stiffness": [0.0, 1e13],
        "actuated": "none",
    }
    return Case("W5", "spring of 1e13 with a damper, N = 2, T = 5 s", "motion", chain, (1.0, 1e-3), (0.0, 0.0),
                times=(5.0,), means="radau")  # fmt: skip


def problems() -> list[Work]:
    """All of them."""
    planar, small = ("link frame",), ("closed form", "link frame")
    return [
        Work(_released("W1", "N = 2, theta = (0.4, 0), T = 100 s", 2, 0.4, 100.0), "regular", small),
        Work(_released("W2", "N = 2, theta = (2, 0), T = 10 s", 2, 2.0, 10.0), "chaotic", small),
        Work(_tumbling(), "spatial", ("tension",)),
        Work(_stiff(), "stiff", small, stiff=True),
        Work(
            _released("W3", "N = 8, theta = (0.4, 0, ...), T = 100 s", 8, 0.4, 100.0), "eight links", planar
        ),
    ]


def cases() -> list[Case]:
    """Their cases, for make_references."""
    return [work.case for work in problems()]
