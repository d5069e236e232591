"""The zero of a smooth function between two places, from few values: that of the polynomial through all that is known, inside a bracket."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final

_NODES: Final = 7
"""Values that are interpolated: the ends of the bracket and those closest to it."""
_TURNS: Final = 100
"""Iterations for the zero of a polynomial: halving alone needs fewer."""
_LAST: Final = 4e-16
"""Moves of that zero, in units of itself, that are rounding."""
_PATIENCE: Final = 3
"""Values after which the bracket has to be half as long, or is halved."""
_TWO_ENDS: Final = 2
_ROUNDING: Final = 1e-11
"""Moves, in units of the place, below which one that does not shrink is rounding."""


def zero_between(
    of: Callable[[float], float], low: float, high: float, ends: tuple[float, float], spacing: float,
    beyond: Sequence[tuple[float, float]] = (), near: float = 0.0,
) -> float:  # fmt: skip
    """Where a function vanishes that has two signs.

    Interpolation through k values converges with order close to 2: about four values between for 14 digits, where Brent's
    method takes ten, and two where values beyond are known. A zero is taken when the next one would lie no further than `spacing` from it.

    Args:
        of: The function.
        low: One end.
        high: The other.
        ends: Its values there, of two signs.
        spacing: How far off the zero may be; rounding of the function may leave more.
        beyond: Places outside and the values there, where the function is known.
        near: How far the zero may lie from a place at which `of` was called: what the polynomial does not know is a small share of that.

    Returns:
        A place at which `of` was called, or one as near to such a place, or an end at which it vanishes.
    """
    known = [(low, ends[0]), (high, ends[1])]
    a, b = sorted(known)
    wanted, left, last_move = b[0] - a[0], _PATIENCE, float("inf")
    while a[1] != 0 and b[1] != 0:
        best = min(known, key=lambda pair: abs(pair[1]))
        place = _interpolated([*known, *beyond], a, b)
        move = abs(place - best[0])
        is_known = best not in ((low, ends[0]), (high, ends[1]))
        is_rounding = move < _ROUNDING * (1 + abs(place)) and 2 * move > last_move
        if len(known) > _TWO_ENDS + 1 and is_known and move <= near and a[0] < place < b[0]:
            return place
        if b[0] - a[0] <= spacing or (is_known and (move <= spacing or is_rounding)):
            if is_known:
                return best[0]
            place = (a[0] + b[0]) / 2
        elif left == 0:
            place, wanted, left = (a[0] + b[0]) / 2, (b[0] - a[0]) / 2, _PATIENCE
        elif not a[0] < place < b[0]:
            place = (a[0] + b[0]) / 2
        if not a[0] < place < b[0]:
            return min(a, b, key=lambda pair: abs(pair[1]))[0]  # no number lies between
        last_move = move if move < _ROUNDING * (1 + abs(place)) else float("inf")
        new = place, of(place)
        known.append(new)
        a, b = (new, b) if (new[1] < 0) == (a[1] < 0) else (a, new)
        left = left - 1 if b[0] - a[0] > wanted / 2 else _PATIENCE
        wanted = wanted if left < _PATIENCE else b[0] - a[0]
        if b[0] - a[0] <= spacing:
            return new[0]
    return a[0] if a[1] == 0 else b[0]


def foretold(known: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """Where a function vanishes between the last two of some places, by the polynomial through its values alone, and how far that is from what all but the first
    of them say: infinitely where there are no more than two."""
    a, b = known[-2:]
    place = _interpolated(known, a, b)
    return place, abs(place - _interpolated(known[1:], a, b)) if len(known) > _TWO_ENDS + 1 else float("inf")


def _interpolated(known: Sequence[tuple[float, float]], a: tuple[float, float], b: tuple[float, float]) -> float:
    """The zero inside the bracket of the polynomial through its ends and what is closest to them."""
    middle = (a[0] + b[0]) / 2
    nodes, close = [a, b], _ROUNDING * (1 + abs(middle))
    for pair in sorted(known, key=lambda pair: abs(pair[0] - middle)):
        # Values closer than rounding differ by rounding, and say nothing of a slope.
        for place, _ in nodes:
            if abs(pair[0] - place) <= close:
                break
        else:
            nodes.append(pair)
            if len(nodes) == _NODES:
                break
    places, weights = [place for place, _ in nodes], [value for _, value in nodes]
    for order in range(1, len(nodes)):
        for k in range(len(nodes) - 1, order - 1, -1):
            # Newton's divided differences.
            weights[k] = (weights[k] - weights[k - 1]) / (places[k] - places[k - order])
    low, high, falls = a[0], b[0], a[1] > 0
    x = a[0] - a[1] * (b[0] - a[0]) / (b[1] - a[1])
    for _ in range(_TURNS):
        value, slope = weights[-1], 0.0
        for k in range(len(nodes) - 2, -1, -1):
            slope = slope * (x - places[k]) + value
            value = value * (x - places[k]) + weights[k]
        if value == 0:
            break
        low, high = (x, high) if (value > 0) == falls else (low, x)
        ahead = x - value / slope if slope else low
        if abs(ahead - x) <= _LAST * abs(x):
            break
        x = ahead if low < ahead < high else (low + high) / 2
    return min(max(x, a[0]), b[0])
