"""One number of a chain that is turned: a runtime parameter, or one of its entries, such as mass[2]."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from phichain.errors import ArrayError, UnsupportedError
from phichain.system import Parameters, System, Vector
from phichain.system.arrays import reals

_POSITIVE: Final = ("mass", "length", "com", "cart_mass", "amplitude")
_NOT_NEGATIVE: Final = ("stiffness", "inertia", "armature")
_WORD: Final = re.compile(r"\s*(\w+)\s*(?:\[\s*(\d+)\s*\])?\s*$")


@dataclass(frozen=True)
class Knob:
    """A runtime parameter's entry.

    Attributes:
        name: the parameter.
        index: which of its numbers, from 0.
        size: how many it has.
        is_single: whether it is a number and no list, so that it has no index.
    """

    name: str
    index: int
    size: int
    is_single: bool

    def __str__(self) -> str:
        return self.name if self.is_single else f"{self.name}[{self.index + 1}]"

    def of(self, p: Parameters) -> float:
        """Its value."""
        return float(np.ravel(p[self.name])[self.index])

    def turned(self, p: Parameters, value: float) -> dict[str, Any]:
        """The parameters with another value of it."""
        entries = np.array(np.ravel(p[self.name]), float)
        entries[self.index] = value
        return {**p, self.name: float(entries[0]) if self.is_single else entries}

    def allows(self, value: float) -> bool:
        """Whether a chain can have the value."""
        return value > 0 if self.name in _POSITIVE else value >= 0 or self.name not in _NOT_NEGATIVE

    def direction(self, columns: int, at: int) -> dict[str, Vector]:
        """`along` of a flow that carries so many columns, it alone moving, in one of them."""
        row = np.zeros((self.size, columns))
        row[self.index, at] = 1.0
        return {self.name: row}


def demand_value(name: str, values: Mapping[str, Any]) -> None:
    """Refuse to turn what has no value.

    Raises:
        ArrayError: it has none.
    """
    if name not in values:
        raise ArrayError(f"p.{name}", None, "has no value to start from", f"pass p={{'{name}': ...}} with all other runtime parameters")


def knob_of(system: System, word: Any, p: Parameters | None = None, *, carried: bool = True) -> tuple[Knob, dict[str, Any]]:
    """The knob that a word means, and all runtime parameters of the system.

    Args:
        system: whose flow carries derivatives by the parameter.
        word: a name, with [K] for entry K, from 1, of a parameter per link.
        p: runtime parameters that differ from the system's.
        carried: whether the flow has to carry derivatives by it; else a parameter that comes at run time serves.

    Raises:
        ArrayError: the word is no parameter's name, or the chain has no such entry.
        UnsupportedError: the flow carries no derivatives by it, or it does not come at run time.
    """
    found = _WORD.match(word) if isinstance(word, str) else None
    if found is None:
        raise ArrayError("parameter", word, "is no parameter's name", 'give one such as "gravity" or "mass[2]"')
    name, entry = found.groups()
    values: Mapping[str, Any] = system.parameters(p).get("p", {})
    if not carried and name not in values:
        has = f"those that come at run time are {', '.join(values)}" if values else "none of its parameters comes at run time"
        raise UnsupportedError("parameter", word, f"cannot be turned on '{system.name}': {has}", 'set it to "runtime" in the scene, and give its value')
    if carried and name not in system.varied:
        known = [known for known in system.varied if known not in ("amplitude", "omega")]
        has = f"its flow carries derivatives by {', '.join(known)}" if known else "its flow carries derivatives by the state alone"
        raise UnsupportedError(
            "parameter", word, f"cannot be turned on '{system.name}': {has}",
            f'set it to "runtime" in the scene and name it there: [flow] variational = ["state", "{name}"]',
        )  # fmt: skip
    size = system.varied[name] if carried else np.size(values[name])
    demand_value(name, values)
    is_single = np.ndim(reals(f"p.{name}", values[name], "give real numbers")) == 0
    if entry is None and size > 1:
        raise ArrayError("parameter", word, f"is {size} numbers", f"say which, as {name}[1]")
    index = int(entry or 1) - 1
    if not 0 <= index < size:
        raise ArrayError("parameter", word, "is no entry of it", f"use {name}[1] to {name}[{size}]")
    return Knob(name, index, size, is_single), dict(values)
