"""The zero of a smooth function between two places, from few values: inverse interpolation through all that is known, inside a bracket."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final

_NODES: Final = 5
"""Values that are interpolated: those closest to the zero."""
_PATIENCE: Final = 3
"""Values after which the bracket has to be half as long, or is halved."""
_ROUNDING: Final = 1e-11
"""Moves, in units of the place, below which one that does not shrink is rounding."""


def zero_between(of: Callable[[float], float], low: float, high: float, ends: tuple[float, float], spacing: float) -> float:
    """Where a function vanishes that has two signs.

    Interpolation through k values converges with order close to 2: about four values between for 14 digits, where Brent's
    method takes ten. A zero is taken when the next one would lie no further than `spacing` from it.

    Args:
        of: The function.
        low: One end.
        high: The other.
        ends: Its values there, of two signs.
        spacing: How far off the zero may be; rounding of the function may leave more.

    Returns:
        A place at which `of` was called, or an end at which it vanishes.
    """
    known = [(low, ends[0]), (high, ends[1])]
    a, b = sorted(known)
    wanted, left, last_move = b[0] - a[0], _PATIENCE, float("inf")
    while a[1] != 0 and b[1] != 0:
        best = min(known, key=lambda pair: abs(pair[1]))
        place = _interpolated(known, a[0], b[0])
        move = abs(place - best[0])
        is_known = best not in ((low, ends[0]), (high, ends[1]))
        is_rounding = move < _ROUNDING * (1 + abs(place)) and 2 * move > last_move
        if b[0] - a[0] <= spacing or (is_known and (move <= spacing or is_rounding)):
            if is_known:
                return best[0]
            place = (a[0] + b[0]) / 2
        elif left == 0:
            place, wanted, left = (a[0] + b[0]) / 2, (b[0] - a[0]) / 2, _PATIENCE
        last_move = move if move < _ROUNDING * (1 + abs(place)) else float("inf")
        new = place, of(place)
        known.append(new)
        a, b = (new, b) if (new[1] < 0) == (a[1] < 0) else (a, new)
        left = left - 1 if b[0] - a[0] > wanted / 2 else _PATIENCE
        wanted = wanted if left < _PATIENCE else b[0] - a[0]
        if b[0] - a[0] <= spacing:
            return new[0]
    return a[0] if a[1] == 0 else b[0]


def _interpolated(known: Sequence[tuple[float, float]], low: float, high: float) -> float:
    """The zero of the inverse function through the least values, fewer of them where it leaves the bracket; its middle at last."""
    least = sorted(known, key=lambda pair: abs(pair[1]))[:_NODES]
    for count in range(len(least), 1, -1):
        values = [value for _, value in least[:count]]
        if len(set(values)) < count:
            continue
        places = [place for place, _ in least[:count]]
        for order in range(1, count):
            for k in range(count - order):
                # Neville's scheme at the value zero.
                places[k] = (values[k] * places[k + 1] - values[k + order] * places[k]) / (values[k] - values[k + order])
        if low < places[0] < high:
            return places[0]
    return (low + high) / 2
