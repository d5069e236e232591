"""A table of gains: the regulators of several equilibria, and what a supervisor needs to say which of them is near."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from phichain.archive import NUMBER, TEXT, VALUES, Array, Schema, names, real, whole
from phichain.errors import ArrayError
from phichain.laws.numbers import Matrix, Row, as_numbers, less_turns, read_law
from phichain.records import Valued, write_npz

Vector = NDArray[np.float64]

_NUMBERS: Final = {
    "targets": real("count", "nx"), "rest": real("count", "nu"), "gains": real("count", "nu", "nx"),
    "shapes": real("count", "n", "nx"), "low": real("nu"), "high": real("nu"),
}  # fmt: skip
_WHOLE: Final = {"signs": whole("count", "links"), "compared": whole("positions")}
_WORDS: Final = {
    "name": TEXT, "digest": TEXT, "p": VALUES, "state_names": names("nx"), "state_units": names("nx"), "input_names": names("nu"),
    "input_units": names("nu"),
}  # fmt: skip
_PLAIN: Final = {"sample": NUMBER, "leave": NUMBER}
_SCHEMA: Final = Schema(
    "GainTable",
    {**_NUMBERS, **_WHOLE, "wraps": Array(np.bool_, ("nx",))},
    {**_WORDS, **_PLAIN},
    filled=("count", "nx", "nu", "n", "links", "positions"),
)


@dataclass(frozen=True)
class GainTable(Valued):
    """u = clip(u_0 - K w(x - x_target), low, high) with the row of the equilibrium that is near.

    A supervisor holds at most one of them. The level of equilibrium e is |W_e w(x - x_e)|^2, an ellipsoid in which its linear
    closed loop stays, whose inputs do not reach their limits and whose angles stay small, where the level is at most 1. The one
    whose links are closest is taken up where its level is at most 1, and let go where that passes `leave`.

    Attributes:
        name: The scene it belongs to.
        digest: That scene's canonical digest; empty for a chain that was made by hand.
        state_names: Names of x = (q, v), nx of them.
        state_units: Their units.
        input_names: Names of u, nu of them.
        input_units: Their units.
        wraps: For every entry of x whether its deviation counts modulo a full turn.
        signs: The equilibria (count, links): +1 hanging, -1 upright.
        targets: x_e (count, nx).
        rest: u_0 of each (count, nu).
        gains: K of each (count, nu, nx).
        shapes: W of each (count, n, nx).
        compared: Entries of x that say how far the links are from those of an equilibrium.
        low: Least inputs (nu,); -inf for one without a limit.
        high: Largest inputs (nu,); inf for one without a limit.
        leave: Level above which an equilibrium that is held is let go, 1 or more.
        sample: Time between two calls, s; 0 where it is called all the time.

    Raises:
        ArrayError: Shapes that do not fit, numbers that are not finite, or limits that leave nothing.
    """

    name: str
    digest: str
    state_names: tuple[str, ...]
    state_units: tuple[str, ...]
    input_names: tuple[str, ...]
    input_units: tuple[str, ...]
    wraps: tuple[bool, ...]
    signs: tuple[tuple[int, ...], ...]
    targets: Matrix
    rest: Matrix
    gains: tuple[Matrix, ...]
    shapes: tuple[Matrix, ...]
    compared: tuple[int, ...]
    low: Row
    high: Row
    leave: float
    sample: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        nx, nu, count = len(self.state_names), len(self.input_names), len(self.signs)
        n = len(self.shapes[0]) if count else 0
        sizes = {
            "targets": (count, nx), "rest": (count, nu), "gains": (count, nu, nx), "shapes": (count, n, nx), "low": (nu,), "high": (nu,),
        }  # fmt: skip
        for field, shape in sizes.items():
            infinite = field in ("low", "high")
            object.__setattr__(self, field, as_numbers(f"table.{field}", getattr(self, field), shape, infinite))
        signs = tuple(tuple(int(sign) for sign in row) for row in self.signs)
        if not signs or len(set(signs)) < count:
            raise ArrayError("table.signs", signs, "hold no equilibrium, or one twice", "give each once")
        object.__setattr__(self, "signs", signs)
        object.__setattr__(self, "compared", tuple(map(int, self.compared)))
        object.__setattr__(self, "wraps", tuple(map(bool, self.wraps)))
        if len(self.wraps) != nx or not all(0 <= k < nx for k in self.compared):
            raise ArrayError("table.wraps, table.compared", (len(self.wraps), self.compared), "do not fit the state", "give one for each")
        if not 1 <= self.leave < np.inf:
            raise ArrayError("table.leave", self.leave, "lets go before it takes up", "give a level of 1 or more")
        for name, low, high in zip(self.input_names, self.low, self.high, strict=True):
            if not low < high:
                raise ArrayError("table.low, table.high", (low, high), f"leave nothing for {name}", "give a lower limit below the upper one")

    def __str__(self) -> str:
        return f"{self.name}: gains of {len(self.signs)} equilibria from {len(self.state_names)} measured quantities to {', '.join(self.input_names)}"

    def level(self, which: int, x: ArrayLike) -> Vector:
        """|W w(x - x_e)|^2 (...) of states (..., nx) for one equilibrium."""
        return np.asarray(np.sum((self._away(which, x) @ np.array(self.shapes[which]).T) ** 2, axis=-1))

    def closest(self, x: ArrayLike) -> int:
        """The equilibrium whose links are closest to those of one state (nx,)."""
        at = list(self.compared)
        return int(np.argmin([np.sum(self._away(k, x)[at] ** 2) for k in range(len(self.signs))]))

    def supervise(self, held: int, x: ArrayLike) -> tuple[int, float]:
        """Which equilibrium is held after a call at the state x (nx,), -1 for none, and the level that decided.

        Args:
            held: Which was held before, -1 for none.
            x: The state.
        """
        if held >= 0 and (level := float(self.level(held, x))) <= self.leave:
            return held, level
        near = self.closest(x)
        level = float(self.level(near, x))
        return (near if level <= 1 else -1), level

    def inputs(self, which: int, x: ArrayLike) -> Vector:
        """u (..., nu) of one equilibrium's law at states (..., nx); zero within limits for none."""
        if which < 0:
            return np.clip(np.zeros(len(self.low)), self.low, self.high)
        wanted = np.array(self.rest[which]) - self._away(which, x) @ np.array(self.gains[which]).T
        return np.clip(wanted, self.low, self.high)

    def _away(self, which: int, x: ArrayLike) -> Vector:
        away = np.asarray(x, dtype=float) - np.array(self.targets[which])
        return less_turns(away, self.wraps)

    def to_npz(self, path: Path | str) -> Path:
        """Write the whole record; `from_npz` reads it back."""
        arrays: dict[str, Any] = {name: np.array(getattr(self, name), dtype=float) for name in _NUMBERS}
        arrays |= {name: np.array(getattr(self, name), dtype=np.int64) for name in _WHOLE}
        arrays["wraps"] = np.array(self.wraps, dtype=bool)
        return write_npz(path, arrays, {name: getattr(self, name) for name in (*_WORDS, *_PLAIN)} | {"kind": _SCHEMA.kind})

    @classmethod
    def from_npz(cls, path: Path | str) -> GainTable:
        """Read what `to_npz` wrote.

        Raises:
            OutputError: The file is missing, holds no GainTable, or one that does not fit together.
        """
        return read_law(path, _SCHEMA, lambda arrays, said: cls(**arrays, **said))
