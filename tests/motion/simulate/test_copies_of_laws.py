"""Copies of laws: of what they are made, that they share nothing that is written to, and that one that is not its law accuses nobody."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, ClassVar, Generic, Self, TypeVar

import numpy as np
import pytest

from phichain.motion import simulate
from phichain.motion.inputs.afresh import Afresh
from tests.motion.rigs import pendulum
from tests.motion.simulate.test_laws_that_remember import PURE as LAWS
from tests.motion.simulate.test_laws_that_remember import START, keeping, wanted

SLOPE = np.array([-2.0, -1.0])


class Kind:
    pass


STRONG = Kind()


def with_a_bound_builtin() -> Callable[..., Any]:
    """`push` belongs to the list: both are copied, or neither."""
    seen: list[float] = []
    push = seen.append

    def law(t: float, x: np.ndarray) -> Any:
        push(float(SLOPE @ x))
        return [seen[-1]]

    return law


class Plain:
    def law(self, t: float, x: np.ndarray) -> Any:
        return [-2 * x[0] - x[1]]


class Stronger(Plain):
    def law(self, t: float, x: np.ndarray) -> Any:
        return [-4 * x[0] - 2 * x[1]]


def of_a_base() -> Callable[..., Any]:
    """The base's, of an object whose own is another one."""
    return super(Stronger, Stronger()).law


def with_methods_that_close() -> Callable[..., Any]:
    """What a method closes over is the class's, and not copied with the object."""
    told: list[float] = []

    class Law:
        def __init__(self) -> None:
            self.count = 0

        def __call__(self, t: float, x: np.ndarray) -> Any:
            told.append(-2 * x[0] - x[1])
            self.count += 1
            return [told[self.count - 1]]

    return Law()


class ByKind:
    """Asks which object it holds: a copy of it would be another one."""

    def __init__(self) -> None:
        self.kind = STRONG

    def __call__(self, t: float, x: np.ndarray) -> Any:
        return [-2 * x[0] if self.kind is STRONG or x[0] > 0.39 else -x[0]]


class ByOwnKind:
    WEAK: ClassVar[Any] = Kind()

    def __init__(self) -> None:
        self.kind = self.WEAK

    def law(self, t: float, x: np.ndarray) -> Any:
        return [-x[0] if self.kind is self.WEAK or x[0] > 0.39 else -2 * x[0]]


def by_its_place() -> Callable[..., Any]:
    """What asks where its objects lie has another one for a copy."""
    gains = Kind()
    known = {id(gains): 2.0}
    return lambda t, x: [-known.get(id(gains), 1.0) * x[0] - x[1]]


PURE: dict[str, Callable[[], Any]] = {
    "a bound builtin": with_a_bound_builtin, "of a base": of_a_base, "methods that close": with_methods_that_close, "by kind": ByKind,
    "by its own kind": lambda: ByOwnKind().law, "by its place": by_its_place,
}  # fmt: skip


@pytest.mark.parametrize("kind", PURE)
def test_a_copy_accuses_no_function_of_time_and_state(kind: str) -> None:
    assert simulate(pendulum(), START, [0.0, 1.0], "RK45", u=PURE[kind]()).status == "complete"


def test_a_copy_of_a_bound_builtin_writes_to_its_own() -> None:
    log: list[float] = []
    push = log.append

    def pushing(t: float, x: np.ndarray) -> Any:
        push(t)
        return [0.0]

    law = Afresh(pushing).law()
    assert law is not None and law(0.0, np.array(START)) == [0.0] and not log


T = TypeVar("T")
known = Kind()


@dataclass
class Keeping:
    known: dict[int, float] = field(default_factory=dict)

    def __call__(self, t: float, x: np.ndarray) -> Any:
        return [self.known.setdefault(0, x[0])]


@dataclass(slots=True)
class Slotted:
    known: dict[int, float] = field(default_factory=dict)

    def __call__(self, t: float, x: np.ndarray) -> Any:
        return [self.known.setdefault(0, x[0])]


class Common(ABC, Generic[T]):
    PLACES: ClassVar[tuple[int, ...]] = (0, 1)

    def __init__(self) -> None:
        self.known: dict[int, float] = {}

    @property
    def first(self) -> int:
        return self.PLACES[0]

    @staticmethod
    def like(x: np.ndarray) -> float:
        return float(x[0])

    @abstractmethod
    def __call__(self, t: float, x: np.ndarray) -> Any: ...


class Own(Common[int]):
    def __init__(self) -> None:
        super().__init__()

    def __call__(self, t: float, x: np.ndarray) -> Any:
        return [self.known.setdefault(self.first, self.like(x))]


@pytest.mark.parametrize("kind", [Keeping, Slotted, Own])
def test_objects_of_usual_classes_are_copied(kind: Callable[[], Any]) -> None:
    """An attribute may be called as something of its module is, and bases be a library's."""
    for law in (one := kind(), one.__call__):
        afresh = Afresh(law)
        assert law(0.0, np.array([1.0, 0.0])) == [1.0]
        copy = afresh.law()
        assert copy is not None and copy(0.0, np.array([2.0, 0.0])) == [2.0] and law(0.0, np.array([2.0, 0.0])) == [1.0]
        one.known.clear()


class Single:
    """One object for all: a copy would be the law itself, and put back to what it was."""

    one: ClassVar[Any] = None

    def __new__(cls) -> Self:
        if cls.one is None:
            cls.one = super().__new__(cls)
        return cls.one

    def __init__(self) -> None:
        self.asked = 0

    def __call__(self, t: float, x: np.ndarray) -> Any:
        self.asked += 1
        return [-x[1]]


class Logged(deque[float]):
    """Tells how it is copied itself."""

    def __reduce__(self) -> Any:
        raise AssertionError("asked how it is copied")


class Told:
    """Tells what it is made of itself."""

    def __getnewargs__(self) -> Any:
        raise AssertionError("asked what it is made of")


def test_copying_runs_nothing_of_the_caller_and_changes_nothing() -> None:
    asked = Single()
    before = Afresh(asked)
    for k in range(5):
        asked(0.1 * k, np.array(START))
    assert before.law() is None and asked.asked == 5
    for held in (Logged(), Told()):

        def law(t: float, x: np.ndarray, held: Any = held) -> Any:
            return [0.0]

        assert Afresh(law).law() is None


def test_what_cannot_be_copied_whole_is_not_copied() -> None:
    for kind in ("views", "half shared", "cached", "jitted", "looked up"):
        if kind != "looked up":
            assert Afresh(LAWS[kind]()).law() is None
    large = np.zeros(2**20)
    assert Afresh(lambda t, x: large[:1]).law() is None

    class Closing:
        def __call__(self, t: float, x: np.ndarray) -> Any:
            return [0.0]

        def __del__(self) -> None:
            raise AssertionError("a copy has been made and forgotten")

    held = [Closing.__new__(Closing)]
    assert Afresh(lambda t, x: held[0](t, x)).law() is None
    del Closing.__del__


def test_a_copy_remembers_what_the_law_did_and_nothing_later() -> None:
    law = keeping(memory := {0: 7.0})
    afresh = Afresh(law)
    law(0.05, np.array(START))
    for _ in range(2):
        copy = afresh.law()
        assert copy is not None and copy is not law
        assert copy(0.0, np.zeros(2)) == [7.0] and copy(0.05, np.zeros(2)) == [wanted(0.05, np.zeros(2))]
    assert memory == {0: 7.0, 2: wanted(0.05, np.array(START))}
