"""One axis of a study: which key takes which values, in a grid or in samples."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from phichain.errors import StudyError
from phichain.system.arrays import whole

MOST_VALUES: Final = 20_000_000
"""Values of one axis, and tasks of one study: their keys and values take some 4 GB of the process that hands them out."""
Value = float | int | str | bool

_RANGE: Final = ("from", "to", "count", "scale")
_DRAWN: Final = (("low", "high", "scale"), ("mean", "deviation"), ("choices",))


@dataclass(frozen=True)
class Axis:
    """A key and the values it takes.

    Attributes:
        key: What is varied: `chain.mass[2]`, `task.tol`.
        values: The values, in order.
    """

    key: str
    values: tuple[Value, ...]

    def __len__(self) -> int:
        return len(self.values)

    @property
    def is_number(self) -> bool:
        """Whether every value is a number."""
        return all(isinstance(value, int | float) and not isinstance(value, bool) for value in self.values)


def grid_axis(key: str, given: Any) -> Axis:
    """An axis of a grid: a list of values, or {from, to, count, scale = "linear" or "log"}.

    Raises:
        StudyError: It is neither, is empty, or names a value twice.
    """
    field = f"grid.{key}"
    if isinstance(given, Mapping):
        values: tuple[Value, ...] = tuple(_range(field, given))
    elif isinstance(given, list | tuple | np.ndarray):
        values = tuple(_plain(field, value) for value in given)
    else:
        values = (_plain(field, given),)
    if not values:
        raise StudyError(field, given, "holds no value", "list at least one")
    if len(set(values)) < len(values):
        raise StudyError(field, given, "holds a value twice", "list every value once")
    return Axis(key, values)


def drawn_axis(key: str, given: Any, count: int, seed: int, unit: np.ndarray | None = None) -> Axis:
    """An axis of samples: {low, high, scale}, {mean, deviation} or {choices}.

    Every axis draws from a stream of its own, named by seed and key, one number after the other: more samples begin with
    the fewer ones, and one axis more changes no other.

    Args:
        key: What is varied.
        given: How it is distributed.
        count: How many samples.
        seed: Names the streams.
        unit: Places in [0, 1) to use instead of the stream's (count,), of a Sobol sequence.

    Raises:
        StudyError: There is no such distribution, or its numbers make none.
    """
    field = f"samples.{key}"
    if not isinstance(given, Mapping) or not any(set(given) <= set(kind) and kind[0] in given for kind in _DRAWN):
        raise StudyError(
            field, given, "is no distribution", "write {low = 0, high = 1}, {mean = 0, deviation = 1} or {choices = [1, 2]}"
        )
    stream = np.random.default_rng(int.from_bytes(hashlib.sha256(f"{seed} {key}".encode()).digest()[:8], "little"))
    if "mean" in given:
        mean, deviation = _number(field, given, "mean"), _number(field, given, "deviation", 1.0)
        if deviation < 0:
            raise StudyError(f"{field}.deviation", deviation, "is negative", "use zero or a number above it")
        # The inverse of the normal distribution keeps the order of a Sobol sequence; the stream's own is used otherwise.
        normal = stream.standard_normal(count) if unit is None else _normal(unit)
        return Axis(key, tuple((mean + deviation * normal).tolist()))
    places = stream.random(count) if unit is None else unit
    if "choices" in given:
        choices = grid_axis(key, given["choices"]).values
        return Axis(key, tuple(choices[int(place * len(choices))] for place in places))
    low, high = _number(field, given, "low"), _number(field, given, "high")
    if not low < high:
        raise StudyError(field, dict(given), "has a low end that is not below the high one", "exchange them")
    if _is_log(field, given, low):
        return Axis(key, tuple(np.exp(math.log(low) + places * (math.log(high) - math.log(low))).tolist()))
    return Axis(key, tuple((low + places * (high - low)).tolist()))


def sobol(axes: int, count: int, seed: int) -> np.ndarray:
    """The first points of a scrambled Sobol sequence, (count, axes) in [0, 1)."""
    import warnings

    from scipy.stats import qmc

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # counts that are no power of two lose balance, which the docs say
        points: np.ndarray = qmc.Sobol(axes, scramble=True, seed=seed).random(count)
    return np.minimum(points, np.nextafter(1.0, 0.0))


def _normal(unit: np.ndarray) -> np.ndarray:
    from scipy.special import ndtri

    found: np.ndarray = ndtri(np.clip(unit, 2.0**-60, 1 - 2.0**-53))
    return found


def _range(field: str, given: Mapping[str, Any]) -> list[float]:
    if not set(given) <= set(_RANGE) or not {"from", "to", "count"} <= set(given):
        raise StudyError(field, dict(given), "is no range", 'write {from = 0, to = 1, count = 11}, and scale = "log" if wanted')
    first, last = _number(field, given, "from"), _number(field, given, "to")
    count = whole(f"{field}.count", given["count"], 1, MOST_VALUES, "split it: several studies with a store each (docs/studies.md)", StudyError)
    if _is_log(field, given, min(first, last)):
        return [float(value) for value in np.geomspace(first, last, count)]
    return [float(value) for value in np.linspace(first, last, count)]


def _is_log(field: str, given: Mapping[str, Any], low: float) -> bool:
    scale = given.get("scale", "linear")
    if scale not in ("linear", "log"):
        raise StudyError(f"{field}.scale", scale, "is no scale", 'use "linear" or "log"')
    if scale == "log" and low <= 0:
        raise StudyError(field, dict(given), "has no logarithm at its low end", "begin above zero")
    return bool(scale == "log")


def _number(field: str, given: Mapping[str, Any], name: str, default: float | None = None) -> float:
    value = given.get(name, default)
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise StudyError(f"{field}.{name}", value, "is no finite number", "use a number")
    return float(value)


def _plain(field: str, value: Any) -> Value:
    plain = value.item() if hasattr(value, "item") else value
    if isinstance(plain, float) and not math.isfinite(plain):
        raise StudyError(field, value, "is not finite", "use finite numbers")
    if not isinstance(plain, int | float | str):
        raise StudyError(field, value, "is no single number or word", "vary one entry, such as chain.mass[2]")
    return plain
