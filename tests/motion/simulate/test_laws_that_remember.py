"""Laws that are no functions of (t, x) are noticed, whatever they remember; laws that are, however they are made, never."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from functools import cache, partial
from threading import Lock
from typing import Any

import numpy as np
import pytest

from phichain.errors import ArrayError
from phichain.motion import Table, simulate
from phichain.motion.inputs.afresh import Afresh
from phichain.motion.inputs.purity import Purity
from tests.motion.rigs import pair, pendulum

START = [0.4, 0.0]
METHODS = ("auto", "RK45", "Radau", "LSODA", "step")
SLOPE = np.array([-2.0, -1.0])
KEPT: dict[int, float] = {}
last: Any = None


def wanted(t: float, x: np.ndarray) -> float:
    return float(SLOPE @ x + 0.3 * np.sin(t))


def differentiating(is_signed: bool) -> Callable[..., Any]:
    seen: dict[str, Any] = {"x": None, "t": 0.0}

    def law(t: float, x: np.ndarray) -> Any:
        is_first = seen["x"] is None or (t == seen["t"] if is_signed else t <= seen["t"])
        rate = 0.0 if is_first else (x[0] - seen["x"]) / (t - seen["t"])
        seen["x"], seen["t"] = x[0], t
        return [-0.1 * rate]

    return law


def locked() -> Callable[..., Any]:
    """What holds a lock is not copied: it gives itself away by its answers."""
    law, lock = differentiating(False), Lock()

    def safe(t: float, x: np.ndarray) -> Any:
        with lock:
            return law(t, x)

    return safe


def keeping(memory: Any) -> Callable[..., Any]:
    def law(t: float, x: np.ndarray) -> Any:
        k = int(t / 0.02)
        if k not in memory:
            memory[k] = wanted(t, x)
        return [memory[k]]

    return law


class Keeping:
    def __init__(self) -> None:
        self.known: dict[int, float] = {}

    def __call__(self, t: float, x: np.ndarray) -> Any:
        return [self.known.setdefault(int(t / 0.02), wanted(t, x))]


def in_an_array() -> Callable[..., Any]:
    table = np.full(1000, np.nan)

    def law(t: float, x: np.ndarray) -> Any:
        k = int(t / 0.02)
        table[k] = wanted(t, x) if np.isnan(table[k]) else table[k]
        return table[k : k + 1]

    return law


def in_a_name() -> Callable[..., Any]:
    at, u = -1, 0.0

    def sampled(t: float, x: np.ndarray) -> float:
        nonlocal at, u
        if int(t / 0.02) > at:
            at, u = int(t / 0.02), wanted(t, x)
        return u

    return lambda t, x: [sampled(t, x)]


def in_the_module(t: float, x: np.ndarray) -> Any:
    return [KEPT.setdefault(int(t / 0.02), wanted(t, x))]


def named(t: float, x: np.ndarray) -> Any:
    global last
    last = 1 if last is None else last + 1
    return [last]


def in_a_queue() -> Callable[..., Any]:
    queue: deque[tuple[int, float]] = deque(maxlen=200)

    def law(t: float, x: np.ndarray) -> Any:
        k = int(t / 0.02)
        for at, u in queue:
            if at == k:
                return [u]
        queue.append((k, wanted(t, x)))
        return [queue[-1][1]]

    return law


def latching() -> Callable[..., Any]:
    """Answers alike until it has seen something; forgets nothing."""
    was: set[str] = set()

    def law(t: float, x: np.ndarray) -> Any:
        if x[0] < 0:
            was.add("below")
        return [0.2 if was else -0.2]

    return law


REMEMBERING: dict[str, Callable[[], Any]] = {
    "differentiates": lambda: differentiating(False), "differentiates either way": lambda: differentiating(True), "is locked": locked, "keeps by sample": lambda: keeping({}),
    "an object keeps": Keeping, "a method keeps": lambda: Keeping().__call__, "a partial keeps": lambda: partial(keeping({})), "an array keeps": in_an_array,
    "a name keeps": in_a_name, "a queue keeps": in_a_queue, "latches": latching,
}  # fmt: skip


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("kind", REMEMBERING)
def test_a_law_that_remembers_is_noticed(kind: str, method: str) -> None:
    options: dict[str, Any] = {"h": 0.01} if method == "step" else {}
    with pytest.raises(ArrayError, match="remembers earlier calls.*sample=Ts"):
        simulate(pendulum(), START, [0.0, 3.0], method, u=REMEMBERING[kind](), max_steps=2000, **options)


def test_what_a_module_keeps_is_noticed_and_its_copy_writes_nothing_there() -> None:
    KEPT.clear()
    with pytest.raises(ArrayError, match="remembers earlier calls"):
        simulate(pendulum(), START, [0.0, 3.0], "RK45", u=in_the_module, max_steps=2000)
    KEPT.clear()
    law = Afresh(in_the_module).law()
    assert law is not None and law(0.0, np.array(START)) == [wanted(0.0, np.array(START))] and not KEPT
    law = Afresh(named).law()
    assert law is not None and law(0.0, np.array(START)) == [1] and last is None


def test_beside_a_table_a_law_that_remembers_is_noticed_too() -> None:
    names = pair().u_names
    law = keeping({})
    u = {names[0]: Table([0, 1.0, 3.0], [0, 0.1, 0.0], "linear"), names[1]: lambda t, x: law(t, x[:2])}
    with pytest.raises(ArrayError, match="remembers earlier calls"):
        simulate(pair(), [0.4, 0.0, 0.0, 0.0], [0.0, 3.0], u=u, max_steps=2000)


def test_a_law_that_samples_may_remember() -> None:
    for kind in REMEMBERING.values():
        assert simulate(pendulum(), START, [0.0, 1.0], u=kind(), sample=0.02).status == "complete"


class Gains:
    def __init__(self) -> None:
        self.gains, self.room = SLOPE.copy(), np.zeros(2)

    def __call__(self, t: float, x: np.ndarray) -> Any:
        self.room[:] = self.gains * x
        return [self.room.sum()]


def memoised() -> Callable[..., Any]:
    known: dict[bytes, float] = {}
    return lambda t, x: [known.setdefault(x.tobytes() + np.float64(t).tobytes(), wanted(t, x))]


def counting() -> Callable[..., Any]:
    calls: list[float] = []

    def law(t: float, x: np.ndarray) -> Any:
        calls.append(t)
        return [wanted(t, x)]

    return law


def with_views() -> Callable[..., Any]:
    """A copy of an array and of a view of it would not be one memory."""
    room = np.zeros(3)
    head, tail = room[:2], room[2:]

    def law(t: float, x: np.ndarray) -> Any:
        head[:], tail[0] = SLOPE * x, np.sin(t)
        return [room.sum()]

    return law


def half_shared() -> Callable[..., Any]:
    """What is kept in a generator's hands cannot be copied; nor may the rest be."""
    def kept() -> Any:
        table: list[float] = []
        while True:
            table.append((yield table))

    keeper, known = kept(), dict[tuple[float, ...], int]()
    table = next(keeper)

    def law(t: float, x: np.ndarray) -> Any:
        key = (t, *x)
        if key not in known:
            known[key] = len(table)
            keeper.send(wanted(t, x))
        return [table[known[key]]]

    return law


def looked_up() -> Callable[..., Any]:
    from scipy.interpolate import CubicSpline

    spline = CubicSpline(np.linspace(-7, 7, 50), np.cos(np.linspace(-7, 7, 50)))
    return lambda t, x: [float(spline(np.clip(x[0], -6, 6)))]


@cache
def cached(t: float, angle: float, rate: float) -> float:
    return wanted(t, np.array([angle, rate]))


def jitted() -> Callable[..., Any]:
    numba = pytest.importorskip("numba")
    found = numba.njit(lambda t, a, b: -a - b + 0.1 * np.sin(t))
    return lambda t, x: [found(t, x[0], x[1])]


def first_bound_later() -> Callable[..., Any]:
    law = lambda t, x: [helped(x)]
    helped = lambda x: float(SLOPE @ x)
    return law


PURE: dict[str, Callable[[], Any]] = {
    "plain": lambda: lambda t, x: [-x[1]], "numpy": lambda: lambda t, x: SLOPE @ x[None, :].T, "an object with room": Gains, "a method": lambda: Gains().__call__,
    "a partial": lambda: partial(lambda gain, t, x: [gain * x[0]], -2.0), "memoised": memoised, "counting": counting, "views": with_views, "half shared": half_shared,
    "looked up": looked_up, "cached": lambda: lambda t, x: [cached(t, *x)], "jitted": jitted, "of time": lambda: lambda t, x: [0.3 * np.sin(3 * t)],
    "a table of its own": lambda: lambda t, x: [[0.1, -0.2, 0.3][int(2 * t) % 3]], "bound later": first_bound_later, "constant": lambda: lambda t, x: [0.25],
}  # fmt: skip


@pytest.mark.long
@pytest.mark.parametrize("kind", PURE)
def test_a_function_of_time_and_state_is_left_in_peace(kind: str) -> None:
    for method in ("auto", "RK45", "LSODA", "step"):
        options: dict[str, Any] = {"h": 0.01} if method == "step" else {}
        run = simulate(pendulum(), START, [0.0, 1.0], method, u=PURE[kind](), **options)
        assert run.t[-1] == 1.0 and (method == "step" or run.status == "complete")


def test_questions_are_few() -> None:
    """Two for each step, and two more after 1, 2, 4, ... of them; those of copies are not the law's."""
    asked: list[float] = []

    def law(t: float, x: np.ndarray) -> np.ndarray:
        asked.append(t)
        return np.zeros(1)

    pure = Purity(law, 0.0, np.zeros(2))
    for k in range(1000):
        pure.look(0.1 * (k + 1), np.zeros(2))
    assert len(asked) == 1 + 2 * 1000 + 2 * 10
