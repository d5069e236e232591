"""Radau IIA of any order in any number of digits, on equations x' = f(x): for references that nothing of phichain takes part in."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

from mpmath import lu_solve, matrix, mp, mpf, polyroots

Field = Callable[[Sequence[Any]], list[Any]]


@cache
def tableau(stages: int, digits: int) -> tuple[list[Any], list[list[Any]]]:
    """(c, A) of the method: collocation at the zeros of the (s-1)-st derivative of x^(s-1) (x - 1)^s."""
    with mp.workdps(3 * digits):
        coefficients = [mpf(0)] * stages + [mpf(0)] * stages  # of x^(2s-1) downwards
        for j in range(stages + 1):
            coefficients[j] = mp.binomial(stages, j) * (-1) ** j
        powers = list(range(2 * stages - 1, -1, -1))
        for _ in range(stages - 1):
            coefficients = [c * p for c, p in zip(coefficients, powers, strict=True)][:-1]
            powers = [p - 1 for p in powers][:-1]
        nodes = sorted(mp.re(x) for x in polyroots(coefficients, maxsteps=500, extraprec=400))
        vandermonde = matrix([[c**j for c in nodes] for j in range(stages)])
        rows = [list(lu_solve(vandermonde, matrix([c ** (j + 1) / (j + 1) for j in range(stages)]))) for c in nodes]
        return nodes, rows


def one_step(f: Field, x: list[Any], h: Any, stages: int) -> list[Any] | None:
    """The end of one step, by Newton's method with the Jacobian at its start; None where that does not converge."""
    size, (_, A) = len(x), tableau(stages, mp.dps)
    slope, small = f(x), mpf(10) ** (-mp.dps // 3)
    columns = [[(b - a) / small for a, b in zip(slope, f([y + small * (i == j) for i, y in enumerate(x)]), strict=True)] for j in range(size)]
    whole = matrix(stages * size, stages * size)
    for i in range(stages):
        for j in range(stages):
            for row in range(size):
                for column in range(size):
                    whole[i * size + row, j * size + column] = mpf(i == j and row == column) - h * A[i][j] * columns[column][row]
    inverse = whole**-1
    z = [[mpf(0)] * size for _ in range(stages)]
    last = mpf("inf")
    for _ in range(60):
        rates = [f([a + b for a, b in zip(x, own, strict=True)]) for own in z]
        left = [z[i][r] - h * sum(A[i][j] * rates[j][r] for j in range(stages)) for i in range(stages) for r in range(size)]
        change = inverse * matrix(left)
        z = [[z[i][r] - change[i * size + r] for r in range(size)] for i in range(stages)]
        moved = max(map(abs, change))
        if moved < mpf(10) ** (5 - mp.dps):
            return [a + b for a, b in zip(x, z[-1], strict=True)]
        if moved > 2 * last:
            return None
        last = moved
    return None


def integrate(f: Field, x: Sequence[Any], t: Any, tolerance: Any, stages: int = 7, first: Any = "0.01") -> list[Any]:
    """x(t); each step is compared with two of half its length, and the better end is kept."""
    x, now, h, end = [mpf(y) for y in x], mpf(0), mpf(first), mpf(t)
    while now < end:
        h = min(h, end - now)
        whole, middle = one_step(f, x, h, stages), one_step(f, x, h / 2, stages)
        halves = None if middle is None else one_step(f, middle, h / 2, stages)
        if whole is None or halves is None:
            h /= 4
            continue
        error = max(abs(a - b) for a, b in zip(whole, halves, strict=True)) / tolerance
        if error <= 1:
            x, now = halves, now + h
        h *= min(mpf(3), max(mpf("0.2"), mpf("0.8") * error ** (-mpf(1) / (2 * stages)))) if error else 3
    return x
