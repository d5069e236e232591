"""What callers' functions and numbers may not do to a motion: every value from the list of what was once believed."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from phichain import build, lqr, simulate
from phichain.errors import ArrayError, ControlError, PhichainError, ToleranceError
from phichain.motion import Event
from phichain.scene import Scene
from phichain.system import System
from tests.handmade import uniform_planar

WANT = ("forward_dynamics", "energy", "state_jacobian", "linearization", "propagate", "propagate_batch", "propagate_stiff")
RUNTIME = Scene(
    "trusting", 2, base="cart", cart_mass="runtime", mass="runtime", length="runtime", damping="runtime", stiffness="runtime",
    gravity="runtime", want=WANT,
)  # fmt: skip
P = {
    "cart_mass": 1.0, "mass": np.ones(2), "length": np.ones(2), "damping": np.zeros(2), "stiffness": np.zeros(2), "gravity": 9.81,
}  # fmt: skip
Q, V = np.array([0.0, 1.0, -0.5]), np.array([0.5, 0.0, 0.25])
GRID = np.linspace(0.0, 1.0, 5)


@pytest.fixture(scope="module")
def system() -> System:
    return build(RUNTIME)


@pytest.mark.long
@pytest.mark.parametrize("name", ["propagate", "propagate_stiff", "propagate_batch"])
@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"lost": np.full(7, np.nan)}, ArrayError, "lost: is not finite"),
        ({"lost": np.nan}, ArrayError, "lost: "),
        ({"lost": [np.inf] + [0.0] * 6}, ArrayError, "lost: is not finite"),
        ({"lost": np.zeros(3)}, ArrayError, "lost: "),
        ({"max_steps": 2**64}, ToleranceError, "max_steps: must be at most 18446744073709551615"),
        ({"max_steps": -1}, ToleranceError, "max_steps: must be at least 0"),
        ({"max_steps": 1.5}, ToleranceError, "max_steps: is not a whole number"),
        ({"max_steps": float("nan")}, ToleranceError, "max_steps: is not a whole number"),
    ],
)
def test_flows_take_what_they_can_go_on_from(
    system: System, name: str, options: dict[str, Any], error: type[PhichainError], words: str
) -> None:
    is_batch = name.endswith("batch")
    if is_batch and np.ndim(options.get("lost")) == 1:
        options = {"lost": np.array([options["lost"]])}
    state = (Q[None], V[None]) if is_batch else (Q, V)
    with pytest.raises(error, match=f"^{name}.{words}"):
        getattr(system, name)(*state, 0.0, 1.0, 1e-10, p=P, **options)


def test_the_largest_budget_and_none_are_budgets(system: System) -> None:
    right = system.propagate(Q, V, 0.0, 1.0, 1e-10, p=P)
    most = system.propagate(Q, V, 0.0, 1.0, 1e-10, p=P, max_steps=2**64 - 1)
    assert most.outcome == "done" and most.q.tobytes() == right.q.tobytes()
    none = system.propagate(Q, V, 0.0, 1.0, 1e-10, p=P, max_steps=0)
    assert (none.outcome, none.steps, none.t) == ("step budget", 0, 0.0)


BAD_PARAMETERS = [
    *((name, value) for name in ("mass", "length", "cart_mass") for value in (-1.0, 0.0, np.nan, np.inf)),
    *((name, value) for name in ("damping", "stiffness") for value in (-1.0, np.nan, np.inf)),
    ("gravity", np.nan),
    ("gravity", -np.inf),
]


@pytest.mark.parametrize(("name", "value"), BAD_PARAMETERS)
def test_runtime_parameters_are_what_a_scene_could_hold(system: System, name: str, value: float) -> None:
    p = {**P, name: np.broadcast_to(value, np.shape(P[name])).copy()}
    rows, u = np.array([Q, Q]), [0.0]
    calls: list[Callable[[], Any]] = [
        lambda: system.forward_dynamics(Q, V, np.zeros(1), p=p),
        lambda: system.forward_dynamics(rows, V, u, p=p),
        lambda: system.energy(Q.tolist(), V, p={**p, "mass": list(p["mass"])}),
        lambda: system.propagate(Q, V, 0.0, 1.0, 1e-10, p=p),
        lambda: system.propagate_batch(rows, rows, 0.0, 1.0, 1e-10, p=p),
        lambda: simulate(system, (Q, V), GRID, p=p),
        lambda: simulate(system, (Q, V), GRID, "DOP853", p=p),
        lambda: lqr(system, p=p),
    ]
    for call in calls:
        with pytest.raises(ArrayError, match=rf"p\['{name}'\]: is (not positive|negative|not finite)"):
            call()
    # The refused set leaves nothing behind, and the right one is still taken.
    assert np.isfinite(system.forward_dynamics(Q, V, np.zeros(1), p=P)).all()


def test_parameters_are_looked_at_whenever_they_change(system: System) -> None:
    p = {**P, "mass": np.ones(2)}
    system.forward_dynamics(Q, V, np.zeros(1), p=p)
    p["mass"][1] = -1.0
    with pytest.raises(ArrayError, match=r"p\['mass'\]: is not positive"):
        system.forward_dynamics(Q, V, np.zeros(1), p=p)
    with pytest.raises(ArrayError, match=r"p\['mass'\]: is not positive"):
        system.forward_dynamics(Q, V, np.zeros(1), p=p)


def test_single_precision_knows_its_range() -> None:
    small = build(Scene("small_trusting", 1, mass="runtime", length=1.0, real="float", want=("forward_dynamics", "propagate")))
    for mass in (1e300, 1e-60):
        with pytest.raises(ArrayError, match=r"p\['mass'\]: is not (finite|positive)"):
            small.forward_dynamics([0.5], [0.0], p={"mass": [mass]})
    with pytest.raises(ArrayError, match=r"propagate\.t_end: is outside the range of float32"):
        small.propagate([0.5], [0.0], 0.0, 1e300, 1e-5, p={"mass": [1.0]})


@pytest.mark.parametrize("x0", [np.zeros(6, complex), (Q + 1j, V), (Q, V.astype(complex)), ["0"] * 6, [None] * 6, object()])
def test_a_start_that_is_no_real_state(system: System, x0: Any) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(ArrayError, match="does not hold real numbers"):
            simulate(system, x0, GRID, p=P)


METHODS = ("DOP853", "Radau", "LSODA", "taylor")


@pytest.mark.parametrize("method", METHODS)
def test_an_event_that_writes_into_the_state_changes_nothing(system: System, method: str) -> None:
    def watching(t: float, x: np.ndarray) -> float:
        return float(x[1])

    def writing(t: float, x: np.ndarray) -> float:
        value = float(x[1])
        x[1] = 99.0
        return value

    motions = [simulate(system, (Q, V), [0.0, 1.0], method, p=P, events=Event("e", event)) for event in (watching, writing)]
    assert motions[0].x.tobytes() == motions[1].x.tobytes() and motions[0].events
    assert [e.x.tobytes() for e in motions[0].events] == [e.x.tobytes() for e in motions[1].events]


@pytest.mark.parametrize("method", ["DOP853", "Radau", "BDF", "LSODA"])
def test_a_law_that_writes_into_the_state_or_keeps_its_answer_changes_nothing(system: System, method: str) -> None:
    held = np.zeros(1)

    def clean(t: float, x: np.ndarray) -> np.ndarray:
        return np.array([np.sin(t) - x[1]])

    def dirty(t: float, x: np.ndarray) -> np.ndarray:
        held[0] = np.sin(t) - x[1]
        x[:] = 99.0
        return held

    motions = [simulate(system, (Q, V), GRID, method, tol=1e-6, p=P, u=law) for law in (clean, dirty)]
    assert motions[0].x.tobytes() == motions[1].x.tobytes()
    assert np.asarray(motions[0].u).tobytes() == np.asarray(motions[1].u).tobytes()


def test_a_start_that_is_written_to_later_is_the_caller_s_own(system: System) -> None:
    x0, p = np.concatenate([Q, V]), {**P, "mass": np.ones(2)}

    def law(t: float, x: np.ndarray) -> list[float]:
        x0[:] = 7.0
        return [0.0]

    motion = simulate(system, x0, GRID, "DOP853", p=p, u=law)
    np.testing.assert_array_equal(motion.x[0], np.concatenate([Q, V]))


@pytest.mark.parametrize("answer", [None, "1", [1.0, 2.0], 1j, [[1.0]], {}, object(), [None]])
def test_a_law_whose_later_answers_are_none(system: System, answer: Any) -> None:
    with pytest.raises(ArrayError, match="^u: "):
        simulate(system, (Q, V), GRID, "DOP853", p=P, u=lambda t, x: [0.0] if t == 0.0 else answer)


@pytest.mark.parametrize("answer", [None, "1", [1.0, 2.0], 1j, [], {}, object(), np.nan])
def test_an_event_whose_later_answers_are_none(system: System, answer: Any) -> None:
    with pytest.raises(ArrayError, match="^event 'e': "):
        simulate(system, (Q, V), GRID, p=P, events=Event("e", lambda t, x: 1.0 if t == 0.0 else answer))


def test_what_a_callback_raises_is_its_caller_s(system: System) -> None:
    def law(t: float, x: np.ndarray) -> np.ndarray:
        raise ZeroDivisionError("mine")

    with pytest.raises(ZeroDivisionError, match="mine"):
        simulate(system, (Q, V), GRID, "DOP853", p=P, u=law)


@pytest.mark.parametrize(
    "weights",
    [{"Q": 1e300}, {"R": 1e-300}, {"Q": 1e308}, {"R": 1e-150}, {"R": 1e300}, {"Q": np.full(6, 1e308)}, {"Q": 1e150}, {"R": 5e-324},
     {"Q": 1e30}],
)  # fmt: skip
def test_weights_beyond_the_arithmetic_are_one_sentence(weights: dict[str, Any]) -> None:
    """No linear algebra of the equation survives them."""
    system = build(Scene("weighed", 2, base="cart", cart_mass=1.0, mass=1.0, length=1.0, want=("forward_dynamics", "linearization")))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(ControlError) as caught:
            lqr(system, **weights)
    assert "\n" not in str(caught.value) and caught.value.remedy


@pytest.mark.parametrize("size", [1e-300, 1e300])
def test_only_the_ratio_of_the_weights_counts(size: float) -> None:
    system = build(Scene("weighed", 2, base="cart", cart_mass=1.0, mass=1.0, length=1.0, want=("forward_dynamics", "linearization")))
    np.testing.assert_allclose(lqr(system, Q=size, R=size).K, lqr(system, Q=1.0, R=1.0).K, rtol=1e-10)


def test_weights_near_the_edge_are_solved() -> None:
    """One upright link with a torque: the Riccati equation in closed form."""
    pendulum = uniform_planar(1, actuated="all")
    for ratio in (1e-6, 1.0, 1e6, 1e9):
        gains = lqr(pendulum, [-1], [ratio, ratio], 1.0)
        linear = gains.A, gains.B
        # theta'' = g theta + b u with the same weight on theta and theta'.
        g, b = linear[0][1, 0], linear[1][1, 0]
        first = (g + np.sqrt(g**2 + b**2 * ratio)) / b
        second = np.sqrt(ratio + 2 * first / b)
        np.testing.assert_allclose(gains.K, [[first, second]], rtol=1e-9)
