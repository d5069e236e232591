"""State feedback about a target, with whole turns of angles and limits of the inputs taken into account."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from phichain.archive import NUMBER, TEXT, VALUES, Array, Schema, names, real
from phichain.errors import ArrayError
from phichain.laws.numbers import as_numbers, less_turns, read_law
from phichain.records import Valued, write_npz

Vector = NDArray[np.float64]

_NUMBERS = {"target": real("nx"), "rest": real("nu"), "gains": real("nu", "nx"), "low": real("nu"), "high": real("nu")}
_ARRAYS = {**_NUMBERS, "wraps": Array(np.bool_, ("nx",))}
_WORDS = {
    "name": TEXT,
    "digest": TEXT,
    "p": VALUES,
    "state_names": names("nx"),
    "state_units": names("nx"),
    "input_names": names("nu"),
    "input_units": names("nu"),
}
_PLAIN = {"sample": replace(NUMBER, default=0.0)}
_SCHEMA = Schema("StateFeedback", _ARRAYS, {**_WORDS, **_PLAIN}, filled=("nx", "nu"))


@dataclass(frozen=True)
class StateFeedback(Valued):
    """u = clip(u_0 - K w(x - x_target), low, high), where w takes whole turns from the angles that are to be wrapped.

    It has no state and its cost is fixed: `lowering.laws.state_feedback` writes it as a Program.

    Attributes:
        name: The scene it belongs to.
        digest: That scene's canonical digest; empty for a chain that was made by hand.
        state_names: Names of what is measured, x = (q, v), nx of them.
        state_units: Their units.
        input_names: Names of u, nu of them.
        input_units: Their units.
        target: x_target (nx,).
        rest: u_0 (nu,), the input that keeps the chain at the target.
        gains: K (nu, nx), row by row.
        wraps: For every entry of x whether its deviation counts modulo a full turn, in [-pi, pi).
        low: Least inputs (nu,); -inf for one without a limit.
        high: Largest inputs (nu,); inf for one without a limit.
        sample: Time between two calls, s, over which the inputs are held; 0 where it is called all the time.

    Raises:
        ArrayError: Shapes that do not fit, numbers that are not finite, or limits that leave nothing.
    """

    name: str
    digest: str
    state_names: tuple[str, ...]
    state_units: tuple[str, ...]
    input_names: tuple[str, ...]
    input_units: tuple[str, ...]
    target: tuple[float, ...]
    rest: tuple[float, ...]
    gains: tuple[tuple[float, ...], ...]
    wraps: tuple[bool, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]
    sample: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        nx, nu = len(self.state_names), len(self.input_names)
        shapes = {"target": (nx,), "rest": (nu,), "gains": (nu, nx), "low": (nu,), "high": (nu,)}
        for field, shape in shapes.items():
            infinite = field in ("low", "high")
            object.__setattr__(self, field, as_numbers(f"law.{field}", getattr(self, field), shape, infinite))
        for field, size in (("state_units", nx), ("input_units", nu), ("wraps", nx)):
            if len(getattr(self, field)) != size:
                raise ArrayError(f"law.{field}", getattr(self, field), f"must hold {size} entries", "give one for each")
        object.__setattr__(self, "wraps", tuple(map(bool, self.wraps)))
        if not 0 <= self.sample < np.inf:
            raise ArrayError("law.sample", self.sample, "is no time between two calls", "give seconds, or 0 for none")
        for name, low, high in zip(self.input_names, self.low, self.high, strict=True):
            if not low < high:
                raise ArrayError(
                    "law.low, law.high", (low, high), f"leave nothing for {name}", "give a lower limit below the upper one"
                )

    def __call__(self, t: float, x: ArrayLike) -> Vector:
        """u (..., nu) at states (..., nx), so that `simulate(..., u=law)` takes the record itself; t is not looked at."""
        away = less_turns(np.asarray(x, dtype=float) - np.array(self.target), self.wraps)
        return np.clip(np.array(self.rest) - away @ np.array(self.gains).T, self.low, self.high)

    def __str__(self) -> str:
        limited = sum(np.isfinite(self.low) | np.isfinite(self.high))
        return (
            f"{self.name}: state feedback from {len(self.state_names)} measured quantities to {', '.join(self.input_names)}, "
            f"{sum(self.wraps)} wrapped, {limited} limited"
        )

    def to_npz(self, path: Path | str) -> Path:
        """Write the whole record; `from_npz` reads it back."""
        arrays: dict[str, Any] = {name: np.array(getattr(self, name)) for name in _NUMBERS}
        arrays["wraps"] = np.array(self.wraps, dtype=bool)
        return write_npz(path, arrays, {name: getattr(self, name) for name in (*_WORDS, *_PLAIN)} | {"kind": _SCHEMA.kind})

    @classmethod
    def from_npz(cls, path: Path | str) -> StateFeedback:
        """Read what `to_npz` wrote.

        Raises:
            OutputError: The file is missing, holds no StateFeedback, or one that does not fit together.
        """
        return read_law(path, _SCHEMA, lambda arrays, said: cls(**arrays, **said))
