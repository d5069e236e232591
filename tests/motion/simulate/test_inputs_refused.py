"""Inputs that cannot be meant: one clear typed error each, before the run where it can be told before, else with its time."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from phichain.errors import ArrayError, ConvergenceError, PhichainError, ToleranceError, UnsupportedError
from phichain.motion import Table, simulate
from phichain.system import System
from tests.handmade import uniform_planar
from tests.motion.rigs import cart_pole, pair, pendulum

ROWS = Table([0.0, 0.5, 1.0], [0.1, 0.2, 0.3])


def still(t: float, x: np.ndarray) -> list[float]:
    return [0.1]


@pytest.mark.parametrize(
    ("arguments", "error", "words"),
    [
        ({"u": Table([0.0, 0.9], [1, 2])}, ArrayError, "ends before the run"),
        ({"u": Table([0.1, 1.0], [1, 2])}, ArrayError, "begins after the run"),
        ({"u": Table([0.0, 0.9], [1, 2]), "t": [1.0, 0.0]}, ArrayError, "ends before the run"),
        ({"u": {"torque_1": Table([0.0, 0.9], [1, 2], "linear")}}, ArrayError, r"u\.torque_1.*ends before the run"),
        ({"u": Table([0.0, 1.0], [[1, 2], [3, 4]])}, ArrayError, "1 input in every row"),
        ({"u": {"torque_1": Table([0.0, 1.0], [[1, 2], [3, 4]])}}, ArrayError, r"u\.torque_1\.values"),
        ({"u": {"torque_2": 1.0}}, ArrayError, "torque_2.*did you mean torque_1"),
        ({"u": {"force": 1.0}}, ArrayError, "is the name of no input"),
        ({"u": {}}, ArrayError, "names no input"),
        ({"u": {3: 1.0}}, ArrayError, "is the name of no input"),
        ({"u": {"torque_1": [1.0, 2.0]}}, ArrayError, "finite number"),
        ({"u": {"torque_1": np.nan}}, ArrayError, "finite number"),
        ({"u": {"torque_1": "strong"}}, ArrayError, "real numbers"),
        ({"u": {"torque_1": lambda t, x: [1.0, 2.0]}}, ArrayError, "one number"),
        ({"u": lambda t, x: [np.nan if t > 0.3 else 0.0]}, ArrayError, r"not finite at t = 0\.[3-9]"),
        ({"u": lambda t, x: [0.0] * (1 + (t > 0.3))}, ArrayError, r"no answer of a control law at t = 0\.[3-9]"),
        ({"u": lambda t, x: ["much"]}, ArrayError, "real numbers"),
        ({"u": lambda t, x: [1j]}, ArrayError, "real numbers"),
        ({"u": lambda t, x: [np.inf if t > 0.3 else 0.0], "sample": 0.1}, ArrayError, r"not finite at t = 0\.[34]"),
        ({"u": still, "sample": 0.0}, ToleranceError, "sample: must be positive"),
        ({"u": still, "sample": -0.1}, ToleranceError, "sample: must be positive"),
        ({"u": still, "sample": np.nan}, ToleranceError, "sample: must be positive"),
        ({"u": still, "sample": "often"}, ToleranceError, "sample"),
        ({"u": still, "sample": 1e-14}, ToleranceError, "round-off"),
        ({"u": still, "sample": 0.1, "t": [1.0, 0.0]}, UnsupportedError, "backwards"),
        ({"u": still, "sample": 0.1, "delay": -0.1}, ToleranceError, "must not be negative"),
        ({"u": still, "sample": 0.1, "delay": np.inf}, ToleranceError, "delay"),
        ({"u": still, "delay": 0.1}, UnsupportedError, "give sample= too"),
        ({"u": ROWS, "delay": 0.1}, UnsupportedError, "shift the times of a table"),
        ({"u": still, "limit": 0.0}, ArrayError, "leaves nothing"),
        ({"u": still, "limit": -1.0}, ArrayError, "leaves nothing"),
        ({"u": still, "limit": (1.0, -1.0)}, ArrayError, "leaves nothing"),
        ({"u": still, "limit": np.nan}, ArrayError, "leaves nothing"),
        ({"u": still, "limit": ([1.0, 2.0], 3.0)}, ArrayError, "neither a number nor a pair"),
        ({"u": still, "limit": [1.0]}, ArrayError, "neither a number nor a pair"),
        ({"u": still, "limit": {"force": 1.0}}, ArrayError, "limit: is the name of no input"),
        ({"u": still, "limit": "soft"}, ArrayError, "real numbers"),
        ({"u": still, "method": "taylor"}, UnsupportedError, "sample=Ts"),
        ({"u": still, "method": "rosenbrock"}, UnsupportedError, "sample=Ts"),
        ({"u": still, "method": "cvodes"}, UnsupportedError, "sample=Ts"),
        ({"u": Table(ROWS.times, ROWS.values, "linear"), "method": "taylor"}, UnsupportedError, "DOP853"),
    ],
)
def test_bad_inputs_are_one_typed_error(arguments: dict[str, Any], error: type[PhichainError], words: str) -> None:
    call = {"t": [0.0, 1.0], **arguments}
    with pytest.raises(error, match=words) as caught:
        simulate(pendulum(), [0.4, 0.0], call.pop("t"), call.pop("method", "auto"), **call)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        (([], []), "no list of times"),
        ((0.0, [1.0]), "no list of times"),
        (([[0.0, 1.0]], [1.0]), "no list of times"),
        (([0.0, 1.0], [1.0]), "2 rows"),
        (([0.0, 1.0], 1.0), "2 rows"),
        (([0.0, 1.0, 1.0], [1, 2, 3]), "do not rise from row 2 to row 3"),
        (([0.0, 2.0, 1.0], [1, 2, 3]), "do not rise from row 2 to row 3"),
        (([0.0, np.nan], [1, 2]), r"u\.times.*row 2"),
        (([0.0, 1.0], [[1.0, 2.0], [1.0, np.inf]]), r"u\.values.*row 2"),
        (([0.0, 1.0], ["a", "b"]), "real numbers"),
        (([0.0, 1.0], [1j, 2]), "real numbers"),
        (([0.0, 1.0], [1, 2], "cubic"), "held or linear"),
    ],
)
def test_bad_tables_are_refused_where_they_are_made(fields: tuple[Any, ...], words: str) -> None:
    with pytest.raises(ArrayError, match=words):
        Table(*fields)


def test_a_table_is_its_own_and_nobody_writes_to_it() -> None:
    times, values = np.array([0.0, 1.0]), np.array([[1.0], [2.0]])
    table = Table(times, values)
    values[0] = 9.0
    assert table.values[0, 0] == 1.0
    with pytest.raises(ValueError, match="read-only"):
        table.values[0] = 3.0


def test_a_table_may_end_where_the_run_does_but_for_round_off() -> None:
    times = np.arange(11) * 0.1
    assert times[3] != 0.3
    assert simulate(pendulum(), [0.4, 0.0], [0.0, 0.3], u=Table(times[:4], np.ones(4))).status == "complete"
    late = Table([1e-17, 0.3 * (1 - 2e-16)], [1.0, 1.0])
    assert simulate(pendulum(), [0.4, 0.0], [0.0, 0.3], u=late).t[-1] == 0.3


def test_inputs_to_a_chain_without_any_are_refused() -> None:
    for more in ({"u": {"force": 1.0}}, {"limit": 1.0}, {"u": ROWS}):
        with pytest.raises(ArrayError):
            simulate(uniform_planar(2), [0.4, 0, 0, 0], 1.0, **more)


def remembering(law: Any, period: float) -> Any:
    kept: dict[str, Any] = {}

    def closure(t: float, x: np.ndarray) -> Any:
        if "t" not in kept or t - kept["t"] >= period:
            kept.update(t=t, u=law(t, x))
        return kept["u"]

    return closure


@pytest.mark.parametrize("method", ["auto", "DOP853", "RK45", "Radau", "LSODA"])
@pytest.mark.parametrize("period", [0.01, 0.1])
def test_a_law_that_remembers_its_last_call_is_noticed(method: str, period: float) -> None:
    """On the first round's code it ended at x = -165 m with status "complete"."""
    pushed = remembering(lambda t, x: [20.0 * x[0] - 80.0 * (x[1] - np.pi) + 20 * x[2] - 15.0 * x[3]], period)
    with pytest.raises(ArrayError, match="remembers earlier calls.*sample=Ts"):
        simulate(cart_pole(), [0.0, np.pi - 0.2, 0.0, 0.0], [0.0, 10.0], method, u=pushed, max_steps=3000)


def test_chance_and_clocks_are_no_functions_of_time_and_state() -> None:
    noise = np.random.default_rng(0)
    counted = iter(range(10**6))
    for law in (lambda t, x: [noise.normal()], lambda t, x: [1e-6 * next(counted)]):
        with pytest.raises(ArrayError, match="two answers"):
            simulate(pendulum(), [0.4, 0.0], [0.0, 1.0], u=law, max_steps=500)
    table = iter(range(10**6))
    by_name = {pair().u_names[0]: Table([0, 1.0], [0, 1.0], "linear"), pair().u_names[1]: lambda t, x: 1e-3 * next(table)}
    with pytest.raises(ArrayError, match="two answers"):
        simulate(pair(), [0.4, 0.0, 0.0, 0.0], [0.0, 1.0], u=by_name, max_steps=500)


def test_a_law_that_begins_to_remember_later_is_noticed() -> None:
    """At the start it always gives the same; what it said at its last step it says no more."""
    late = remembering(lambda t, x: [-x[1]], 0.02)
    with pytest.raises(ArrayError, match="two answers"):
        simulate(pendulum(), [0.4, 0.0], [0.0, 2.0], u=lambda t, x: [0.0] if t < 0.3 else late(t, x), max_steps=3000)


def test_pure_laws_are_left_in_peace_even_where_round_off_differs() -> None:
    last = iter(range(10**6))
    shaky = lambda t, x: [0.1 * x[0] * (1 + 1e-16 * (next(last) % 7))]
    assert simulate(pendulum(), [0.4, 0.0], [0.0, 1.0], u=shaky).status == "complete"


@pytest.mark.parametrize("more", [{}, {"sample": 0.05}])
def test_a_law_that_writes_to_its_state_or_its_answer_changes_nothing(more: dict[str, float]) -> None:
    answer = np.zeros(1)

    def writes(t: float, x: np.ndarray) -> np.ndarray:
        answer[0] = -x[1]
        x[:] = 99.0
        return answer

    wild = simulate(pendulum(), [0.4, 0.0], [0.0, 1.0], u=writes, **more)
    tame = simulate(pendulum(), [0.4, 0.0], [0.0, 1.0], u=lambda t, x: [-x[1]], **more)
    assert np.array_equal(wild.x, tame.x) and np.array_equal(wild.u, tame.u)


def test_a_blow_up_under_a_law_is_still_a_blow_up() -> None:
    functions = {"forward_dynamics": lambda q, v, u: v**2 + 0 * u}
    system = System("blow", "planar", "fixed", 1, 1, 1, 1, functions=functions)
    with np.errstate(all="ignore"), pytest.raises(ConvergenceError, match="leaves every bound"):
        simulate(system, [0.0, 1.0], [0.0, 2.0], "RK45", 1e-6, u=lambda t, x: [x[1]])
