"""Where a family is to be followed to: one quantity of the start that has to reach a value, and to lie exactly there."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from phichain.continuation import Level, Problem
from phichain.continuation.events import ENERGY
from phichain.errors import ArrayError
from phichain.system import System, Vector
from phichain.system.arrays import number

LARGEST: Final = ("largest angle", 0)
"""What a compiled problem calls it."""
_PLACE: Final = re.compile(r"-?\d+|event=.*")
"""What names a point or an event behind a file."""
_REMEDY = 'write for example "theta_1=2.5", "amplitude=2.5", "omega=3" or "energy=1.5"'


@dataclass(frozen=True)
class Target:
    """A quantity and its value.

    Attributes:
        what: "theta_K", "amplitude" (the largest angle), "omega" or "energy".
        value: rad, rad/s or J.
        name: What the end is called; "WHAT = VALUE" unless said.
    """

    what: str
    value: float
    name: str = ""

    def __str__(self) -> str:
        return self.name or f"{self.what} = {self.value!r}"

    def level(self, system: System, problem: Problem, carts: int | None = None) -> Level:
        """The terminal test of a family with unknowns (q_0, omega), the first `carts` of them the cart's."""
        carts = system.cart_size if carts is None else carts
        scalar, held = self._scalar(problem, carts)
        return Level(scalar, self.value, str(self), held=held, of=self._of(problem, carts, system.cart_size))

    def _of(self, problem: Problem, carts: int, own: int) -> tuple[str, int] | None:
        """What a compiled problem calls the quantity, whose largest angle leaves out the cart's own unknowns alone."""
        if self.what in ("omega", "energy"):
            return ("unknown", problem.unknowns - 1) if self.what == "omega" else ENERGY
        if self.what == "amplitude":
            return LARGEST if carts == own else None
        return "unknown", self._at(carts)

    def _at(self, carts: int) -> int:
        """The unknown that an angle is."""
        return carts + int(self.what.removeprefix("theta_")) - 1

    def _scalar(
        self, problem: Problem, carts: int
    ) -> tuple[Callable[[Vector], float], Callable[[Vector], tuple[int, float]] | None]:
        value = self.value
        if self.what == "omega":
            return (lambda z: float(z[-1])), (lambda z: (len(z) - 1, value))
        if self.what == "energy":
            assert problem.energy is not None
            return problem.energy, None
        if self.what == "amplitude":

            def largest(z: Vector) -> tuple[int, float]:
                k = carts + int(np.argmax(np.abs(z[carts:-1])))
                return k, float(np.copysign(value, z[k]))

            return (lambda z: float(np.max(np.abs(z[carts:-1])))), largest
        at = self._at(carts)
        return (lambda z: float(z[at])), (lambda z: (at, value))


def target_of(system: System, until: Any) -> Target | None:
    """The target of `until`: "WHAT=VALUE", {"WHAT": VALUE}, ("WHAT", VALUE), or None.

    Raises:
        ArrayError: It is none of these, names no quantity of the family, or a value that is no number or never reached.
    """
    if until is None or isinstance(until, Target):
        return until
    if isinstance(until, str):
        what, equals, text = until.partition("=")
        pair: Any = (what.strip(), text) if equals else ()
    elif isinstance(until, Mapping):
        pair = next(iter(until.items())) if len(until) == 1 else ()
    else:
        pair = tuple(until) if isinstance(until, tuple | list) else ()
    if len(pair) != 2:
        raise ArrayError("until", until, "is no WHAT=VALUE", _REMEDY)
    what, value = pair
    known = [f"theta_{k + 1}" for k in range(system.links)] + ["amplitude", "omega", "energy"]
    if what not in known:
        raise ArrayError("until", what, f"is no quantity of this family, which has {', '.join(known)}", _REMEDY)
    try:
        value = float(value) if isinstance(value, str) else number("until", value, "give a finite value")
    except ValueError:
        value = float("nan")
    if not np.isfinite(value):
        raise ArrayError("until", until, "has no finite value", _REMEDY)
    if what in ("amplitude", "omega", "energy") and value <= 0:
        raise ArrayError("until", until, f"is never reached: {what} is positive", _REMEDY)
    if what == "energy" and not system.has("energy"):
        raise ArrayError("until", until, "needs the energy of the chain", 'add "energy" to [functions] want of the scene')
    return Target(what, value)


def placed(name: str) -> tuple[str, str]:
    """The file and the point or event that FILE.json:POINT and FILE.json:event=K name; "" for the latter where it is a file alone."""
    path, colon, place = name.rpartition(":")
    return (path, place) if colon and _PLACE.fullmatch(place) else (name, "")


def point_index(number: str) -> int:
    """The index of the point that stands behind a file's name, as in FILE.json:POINT: counted from 1, or from the end, where -1 is the last.

    Raises:
        ArrayError: It is 0.
    """
    count = int(number)
    if count == 0:
        raise ArrayError("start", number, "is no point", "count points from 1, or from the end: -1 is the last")
    return count - 1 if count > 0 else count
