"""References of chains too long for the dense engine: the link-frame recursion in 80-bit arithmetic, extrapolated.

phichain's code for masses at the links' ends solves tensions instead, so no formula is shared.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import mpmath as mp
import numpy as np
from numpy.typing import NDArray

from benchmarks.chains import Chain
from benchmarks.peers.recursions import accelerations
from benchmarks.stability.cases.case import Case
from benchmarks.stability.means import engine

Wide = NDArray[np.longdouble]
_DIGITS = 40


def states(case: Case, step: float, columns: int, amount: float = 0.0, seed: int = 0) -> list[list[mp.mpf]]:
    """(q, v) at the case's times, by Gragg's method extrapolated on 2, 4, .. sub-steps.

    Args:
        case: A planar chain on a fixed base without springs.
        step: About the size of a step, s.
        columns: Of the table; the order is twice that.
        amount: Relative change of every entry of the state at the start and again at every time.
        seed: Of its signs.
    """
    scene = case.plain()
    chain = Chain("planar", scene.mass, scene.length, scene.com or scene.length, None, False)  # type: ignore[arg-type]
    signs = np.random.default_rng(seed)
    x = _changed(np.array([*case.q, *case.v], dtype=np.longdouble), amount, signs)
    found, t = [], 0.0
    for end in case.times:
        count = max(1, math.ceil((end - t) / step))
        h = (np.longdouble(end) - np.longdouble(t)) / count
        for _ in range(count):
            x = _extrapolated(chain, x, h, columns)
        with mp.workdps(_DIGITS):
            found.append([mp.mpf(np.format_float_scientific(value, precision=20)) for value in x])
        x, t = _changed(x, amount, signs), end
    return found


def acceleration_gap(case: Case, state: Sequence[mp.mpf]) -> float:
    """The recursion's accelerations at a state against the dense Lagrangian in binary128, max norm over max norm."""
    scene, x = case.plain(), [float(value) for value in state]
    chain = Chain("planar", scene.mass, scene.length, scene.com or scene.length, None, False)  # type: ignore[arg-type]
    half = len(x) // 2
    swept = _rate(chain, np.array(x, dtype=np.longdouble))[half:]
    dense = np.array([float(text) for text in engine.accelerations(scene, x)])
    return float(np.max(np.abs(swept - dense)) / np.max(np.abs(dense)))


def _changed(x: Wide, amount: float, signs: np.random.Generator) -> Wide:
    return x * (1 + np.longdouble(amount) * signs.choice([-1.0, 1.0], len(x)))


def _extrapolated(chain: Chain, x: Wide, h: np.longdouble, columns: int) -> Wide:
    """One step; the table of increments is built along its diagonals (Aitken-Neville in h^2).

    Increments, because the table's weights are large and would act on the round-off of the state itself.
    """
    first, row = _rate(chain, x), []
    for k in range(1, columns + 1):
        row = _next_row(row, _gragg(chain, x, first, h, 2 * k), k)
    return x + row[-1]


def _next_row(before: Sequence[Wide], start: Wide, k: int) -> list[Wide]:
    row = [start]
    for j, value in enumerate(before):
        factor = (np.longdouble(k) / np.longdouble(k - 1 - j)) ** 2 - 1
        row.append(row[-1] + (row[-1] - value) / factor)
    return row


def _gragg(chain: Chain, x: Wide, first: Wide, h: np.longdouble, count: int) -> Wide:
    """The modified midpoint rule with its smoothing step; what it adds to x."""
    small = h / count
    before, now = np.zeros_like(x), small * first
    for _ in range(count - 1):
        before, now = now, before + 2 * small * _rate(chain, x + now)
    return (before + now + small * _rate(chain, x + now)) / 2


def _rate(chain: Chain, x: Wide) -> Wide:
    half = len(x) // 2
    found = accelerations(chain, "link frame", list(x[:half]), list(x[half:]), [], np.sin, np.cos)
    return np.concatenate([x[half:], np.array(found, dtype=np.longdouble)])
