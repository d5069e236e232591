"""What a study can do at each of its points: a registry, one file a task, of what it needs, takes and leaves."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib import import_module
from pkgutil import iter_modules
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from phichain.contract.words import nearest
from phichain.errors import PhichainError, StudyError, printable
from phichain.system.arrays import positive, whole

if TYPE_CHECKING:
    from phichain.scene import Scene
    from phichain.studies.point import Point
    from phichain.system import System

PENDING, DONE, FAILED = 0, 1, 2
STATUS: Final = ("pending", "done", "failed")
"""Status of a task by its number in the store."""
LONGEST_FAILURE: Final = 400


@dataclass(frozen=True)
class Output:
    """One thing that a task leaves.

    Attributes:
        text: What it is.
        dims: Names and lengths of its dimensions besides that of the tasks.
        units: Its units; empty for pure numbers.
        meanings: Words for the values of a code, in order from 0; empty for numbers.
    """

    text: str
    dims: Mapping[str, int] = field(default_factory=dict)
    units: str = ""
    meanings: tuple[str, ...] = ()

    @property
    def dtype(self) -> np.dtype[Any]:
        """Type of its values: doubles, or small codes."""
        return np.dtype(np.uint8 if self.meanings else np.float64)

    @property
    def size(self) -> int:
        """Bytes of one task."""
        return self.dtype.itemsize * int(np.prod([1, *self.dims.values()]))


@dataclass(frozen=True)
class Option:
    """One thing that a task takes, besides the scene and its parameters.

    Attributes:
        default: What stands where nothing is said.
        check: Returns the value in its one form, or raises.
        text: What it is, with units.
    """

    default: Any
    check: Callable[[str, Any], Any]
    text: str


Row = dict[str, Any]
"""What a task left at one point, by the names of its outputs."""


@dataclass(frozen=True)
class Failure:
    """Why a task left nothing.

    Attributes:
        text: One line.
        is_final: Whether trying again would be refused again: what phichain refuses on purpose.
    """

    text: str
    is_final: bool


@dataclass(frozen=True)
class Task:
    """What is done at every point.

    Attributes:
        name: How a study names it.
        text: What it computes.
        options: What it takes.
        needs: Functions that its scene must have, given the options.
        outputs: What it leaves of a scene with these options.
        labels: Coordinates of its outputs' dimensions.
        run: Does it at several points of one System, and leaves a row or a failure for each.
        chunk: How many results the store keeps in one piece, and a worker computes at a time unless told otherwise.
        is_variational: Whether the flow has to carry derivatives along.
    """

    name: str
    text: str
    options: Mapping[str, Option]
    needs: Callable[[Scene, Mapping[str, Any]], Sequence[str]]
    outputs: Callable[[Scene, Mapping[str, Any]], Mapping[str, Output]]
    labels: Callable[[Scene, Mapping[str, Any]], Mapping[str, Sequence[Any]]]
    run: Callable[[System, Sequence[Point]], list[Row | Failure]]
    chunk: int
    is_variational: bool = False

    def checked(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """All options, defaults filled in, in their one form.

        Raises:
            StudyError: There is no option of that name.
            PhichainError: A value is none that it could have.
        """
        for name in given:
            if name not in self.options:
                near = nearest(name, self.options)
                guess = f'did you mean "{near}"? The' if near else "the"
                raise StudyError(f"task.{name}", given[name], f"is no option of {self.name}", f"{guess} options are {', '.join(self.options)}")
        return {name: self.one(name, given[name]) if name in given else option.default for name, option in self.options.items()}

    def one(self, name: str, value: Any) -> Any:
        """The value of one option in its one form."""
        option = self.options[name]
        return value if value is None and option.default is None else option.check(f"task.{name}", value)


def each(one: Callable[[System, Point], Row]) -> Callable[[System, Sequence[Point]], list[Row | Failure]]:
    """Points one after the other; what fails leaves its reason and the others alone."""
    return lambda system, points: [attempt(one, system, point) for point in points]


def attempt(one: Callable[[System, Point], Row], system: System, point: Point) -> Row | Failure:
    """One point, or why it failed."""
    try:
        return one(system, point)
    except Exception as failure:  # noqa: BLE001 - a task of thousands may fail in any way and must not take the others along
        return failed(failure)


def failed(failure: BaseException) -> Failure:
    """An exception as it is recorded."""
    kind = "" if isinstance(failure, PhichainError) else f"{type(failure).__name__}: "
    return Failure(printable(f"{kind}{failure}")[:LONGEST_FAILURE], isinstance(failure, PhichainError))


@cache
def tasks() -> Mapping[str, Task]:
    """Every task by its name, as `phichain.studies.tasks` holds them, a `TASK` in each module."""
    package = import_module("phichain.studies.tasks")
    found: Iterable[Task] = (import_module(f"{package.__name__}.{module.name}").TASK for module in iter_modules(package.__path__))
    return {task.name: task for task in sorted(found, key=lambda task: task.name)}


def task_of(name: Any) -> Task:
    """The task of that name.

    Raises:
        StudyError: There is none.
    """
    known = tasks()
    if isinstance(name, str) and name in known:
        return known[name]
    raise StudyError("task.run", name, "is no task of a study", f"use one of {', '.join(known)}")


def number(name: str, value: Any) -> float:
    """A finite number."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not np.isfinite(value):
        raise StudyError(name, value, "is no finite number", "use a number")
    return float(value)


def above_zero(name: str, value: Any) -> float:
    """A number above zero."""
    return positive(name, number(name, value), "use a number above zero", StudyError)


def share(name: str, value: Any) -> float:
    """A number from 0 and below 1."""
    given = number(name, value)
    if not 0 <= given < 1:
        raise StudyError(name, value, "is no share from 0 and below 1", "write for example 0.1 for ten per cent")
    return given


def from_zero(name: str, value: Any) -> float:
    """A number from zero."""
    given = number(name, value)
    if given < 0:
        raise StudyError(name, value, "is below zero", "use a number from 0")
    return given


def count(least: int, most: int) -> Callable[[str, Any], int]:
    """A whole number in a range."""
    return lambda name, value: whole(name, value, least, most, f"use a whole number from {least} to {most}", StudyError)


def word(name: str, value: Any) -> str:
    """A word."""
    if not isinstance(value, str):
        raise StudyError(name, value, "is no word", "write it in quotes")
    return value


def truth(name: str, value: Any) -> bool:
    """True or false."""
    if not isinstance(value, bool):
        raise StudyError(name, value, "is neither true nor false", "write true or false")
    return value


def numbers(name: str, value: Any) -> list[float]:
    """A list of numbers."""
    if not isinstance(value, list | tuple):
        raise StudyError(name, value, "is no list of numbers", "write them like [0.5, 0]")
    return [number(f"{name}[{k}]", entry) for k, entry in enumerate(value, 1)]
