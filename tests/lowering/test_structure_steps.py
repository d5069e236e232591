"""The structure-preserving steps as Programs: against dense momenta in many digits, symplectic, reversible, honest about convergence."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from phichain.ir import evaluate, unroll
from phichain.lowering import lower_function
from phichain.lowering.steps import variational as step_variational
from phichain.mechanics import derive
from phichain.scene import Scene
from tests.lowering.chains import Arguments, gap, label, random_arguments, scene
from tests.lowering.test_against_reference import error, truth

STEPS = ("step_lie4", "step_variational")
CHAINS = [
    scene(2, "planar", "fixed", "tip"),
    scene(3, "planar", "cart", "mid", "sprung", actuated="none", angles="absolute"),
    scene(3, "spatial", "fixed", "tip", "sprung"),
    scene(2, "spatial", "cart", "mid", actuated="none"),
    scene(3, "spatial", "cart", "tip", actuated="none"),
    scene(3, "planar", "cart", "mid", "geared", actuated="none"),
]
FREE = Scene("rotor", 1, mass=0.7, length=0.5, gravity=1e-30, want=["step_variational"])


def after(chain: Scene, name: str, state: Arguments, h: float) -> Arguments:
    """The state one step later, and the residual where there is one."""
    end = evaluate(lower_function(derive(chain), name, "loops"), state | {"h": np.array(h)})
    return state | {"q": end.pop("q_next"), "v": end.pop("v_next")} | end


def start(chain: Scene, seed: int = 1) -> Arguments:
    return random_arguments(chain, lower_function(derive(chain), "step_variational", "loops"), seed)


@pytest.mark.parametrize("name", STEPS)
@pytest.mark.parametrize("chain", CHAINS, ids=label)
def test_long_steps_are_those_of_the_reference(chain: Scene, name: str) -> None:
    """At 0.01 s the order in h of every term of the methods shows."""
    program = lower_function(derive(chain), name, "loops")
    arguments = start(chain) | {"h": np.array(0.01)}
    found, expected = evaluate(program, arguments), truth(chain, name, arguments)
    assert max(error(found[output], expected[output]) for output in found) < 1e-12


@pytest.mark.parametrize("mass", [[1.0, 1e-8, 1.0], [1.0, 1.0, 1e8]], ids=["light link", "heavy tip"])
@pytest.mark.parametrize("com", [None, [0.3, 0.8, 0.5]], ids=["tip", "mid"])
@pytest.mark.parametrize(("space", "base"), [("planar", "cart"), ("spatial", "fixed")])
def test_masses_may_spread_over_eight_decades(space: str, base: str, com: Any, mass: list[float]) -> None:
    """Bent at random and all but straight, with a step that resolves the light links."""
    keys: dict[str, Any] = {"cart_mass": 1.0} if base == "cart" else {}
    keys |= {"angles": "absolute"} if space == "planar" else {}
    chain = Scene(
        "hard", 3, space=space, base=base, mass=mass, length=[0.5, 1.3, 0.8], com=com, actuated="none", **keys
    )
    program = lower_function(derive(chain), "step_variational", "loops")
    for straightness in (0.0, 1e4):
        arguments = straightened(chain, start(chain), straightness) | {"h": np.array(7e-7)}
        found, expected = evaluate(program, arguments), truth(chain, "step_variational", arguments)
        assert max(error(found[output], expected[output]) for output in found) < 2e-13


def straightened(chain: Scene, state: Arguments, by: float) -> Arguments:
    """Links nearer to hanging."""
    if chain.is_planar:
        return state | {"q": state["q"] / (1 + by)}
    q, v = state["q"].reshape(-1, 3) + [0.0, 0.0, by], state["v"].reshape(-1, 3)
    q = q / np.linalg.norm(q, axis=1)[:, None]
    v = v - q * np.sum(q * v, axis=1)[:, None]
    return state | {"q": q.ravel(), "v": v.ravel()}


@pytest.mark.parametrize("name", STEPS)
@pytest.mark.parametrize("chain", CHAINS, ids=label)
def test_unrolled_is_with_loops(chain: Scene, name: str) -> None:
    loops = lower_function(derive(chain), name, "loops")
    arguments = start(chain) | {"h": np.array(0.01)}
    found, expected = evaluate(unroll(loops), arguments), evaluate(loops, arguments)
    for output in ("q_next", "v_next"):
        assert gap(found[output], expected[output]) < 1e-14


@pytest.mark.parametrize("base", ["fixed", "cart"])
def test_in_the_plane_lie4_is_runge_kutta(base: str) -> None:
    """Turns of the plane commute: rotation vectors are the angles, and no bracket is left."""
    chain = scene(2, "planar", base, "mid")
    one, other = (after(chain, name, start(chain), 0.01) for name in ("step", "step_lie4"))
    assert np.array_equal(one["q"], other["q"]) and np.array_equal(one["v"], other["v"])


def test_lie4_turns_steadily_without_error() -> None:
    """A link that gravity leaves alone goes round at its rate, by any step."""
    chain = Scene("rotor", 1, space="spatial", mass=0.7, length=0.5, gravity=1e-30)
    state = {"q": np.array([1.0, 0.0, 0.0]), "v": np.array([0.0, 1.5, 2.0])}
    end = after(chain, "step_lie4", state, 1.0)
    axis = np.array([0.0, 0.6, 0.8])
    expected = np.cos(2.5) * state["q"] + np.sin(2.5) * np.cross(axis, state["q"])
    assert gap(end["q"], expected) < 1e-15 and gap(end["v"], state["v"]) < 1e-15


def test_lie4_at_rest_stays_finite() -> None:
    """sin(x) / x at x = 0."""
    chain = replace(CHAINS[4], gravity=9.81)
    still = {"q": np.array([0.3, 0.1, *[0.0, 0.0, 1.0] * 3]), "v": np.zeros(11)}
    end = after(chain, "step_lie4", still, 0.01)
    assert np.array_equal(end["q"], still["q"]) and np.array_equal(end["v"], still["v"])


def momenta(chain: Scene, q: Any, v: Any) -> tuple[Any, Any]:
    """[x, q_k] as vectors and the momenta conjugate to them, from the velocities of the point masses; joint angles of rotors likewise."""
    size, cart = (2, int(chain.has_cart)) if chain.is_planar else (3, 2 * chain.has_cart)
    if chain.is_planar:
        shape = (
            np.tril(np.ones((chain.links, chain.links)))
            if chain.angles == "relative"
            else np.eye(chain.links)
        )
        phi, turning = shape @ q[cart:], shape @ v[cart:]
        unit = np.stack([np.sin(phi), np.cos(phi)], axis=1)
        rate = turning[:, None] * np.stack([np.cos(phi), -np.sin(phi)], axis=1)
    else:
        unit = q[cart:].reshape(-1, 3)
        rate = np.cross(v[cart:].reshape(-1, 3), unit)
    mass, length = np.array(chain.mass), np.array(chain.length)
    com = length if chain.com is None else np.array(chain.com)
    lever = np.tril(np.tile(length, (chain.links, 1)), -1) + np.diag(com)
    speed = lever @ rate
    speed[:, : size - 1] += np.pad(v[:cart], (0, size - 1 - cart))
    links = lever.T @ (mass[:, None] * speed)
    base = (chain.cart_mass or 0.0) * v[:cart] + (mass @ speed)[:cart]
    place, momentum = [q[:cart], unit.ravel()], [base, links.ravel()]
    if chain.armature is not None:
        assert chain.angles == "relative"
        place, momentum = [*place, q[cart:]], [*momentum, np.array(chain.armature) * v[cart:]]
    return np.concatenate(place), np.concatenate(momentum)


def two_form(chain: Scene, name: str, state: Arguments, pair: list[tuple[Any, Any]], h: float) -> float:
    """sum dp ^ dz of two variations of the state after a step of h (of 0: before it), by complex steps."""
    moved = []
    for dq, dv in pair:
        varied = state | {"q": state["q"] + 1e-30j * dq, "v": state["v"] + 1e-30j * dv}
        end = after(chain, name, varied, h) if h else varied
        place, momentum = momenta(chain, end["q"], end["v"])
        moved.append((place.imag / 1e-30, momentum.imag / 1e-30))
    (one, p_one), (two, p_two) = moved
    return float(p_one @ two - p_two @ one)


def variations(chain: Scene, state: Arguments) -> list[tuple[Any, Any]]:
    """Two random variations; in space they keep the vectors unit and the rates tangent."""
    rng = np.random.default_rng(5)
    pair = []
    for _ in range(2):
        dq, dv = rng.normal(size=chain.nq), rng.normal(size=chain.nv)
        if not chain.is_planar:
            cart = 2 * chain.has_cart
            q, omega = state["q"][cart:].reshape(-1, 3), state["v"][cart:].reshape(-1, 3)
            turn = rng.normal(size=q.shape)
            dq[cart:] = np.cross(turn, q).ravel()
            tilt = dv[cart:].reshape(-1, 3)
            tilt -= q * np.sum(q * tilt, axis=1)[:, None]
            dv[cart:] = (tilt + np.cross(turn, omega)).ravel()
        pair.append((dq, dv))
    return pair


@pytest.mark.parametrize("chain", CHAINS, ids=label)
def test_the_variational_step_is_symplectic(chain: Scene) -> None:
    """The canonical two-form of two variations is the same after a step; by `step` and `step_lie4` it is not."""
    state = start(chain)
    pair = variations(chain, state)
    h = 0.01
    before = two_form(chain, "step_variational", state, pair, 0.0)
    assert abs(two_form(chain, "step_variational", state, pair, h) - before) < 1e-11 * abs(before)
    assert abs(two_form(chain, "step_lie4", state, pair, 3 * h) - before) > 1e-9 * abs(before)


@pytest.mark.parametrize("chain", CHAINS, ids=label)
def test_the_variational_step_is_reversible(chain: Scene) -> None:
    """A step of -h leads back to round-off; by `step_lie4` to its error only."""
    state = start(chain)
    gaps = {}
    for name in STEPS:
        back = after(chain, name, after(chain, name, state, 0.01), -0.01)
        gaps[name] = max(gap(back["q"], state["q"]), gap(back["v"], state["v"]))
    assert gaps["step_variational"] < 1e-13
    assert gaps["step_lie4"] > 1e-11


@pytest.mark.parametrize("rate", [-80.0, -1e-3, 0.0, 1.0, 40.0, 70.0])
def test_a_free_link_turns_by_the_arcsine(rate: float) -> None:
    """Its discrete momentum m l^2 sin(turn) / h stays m l^2 rate, whatever the step."""
    end = after(FREE, "step_variational", {"q": np.array([0.4]), "v": np.array([rate])}, 0.01)
    assert abs(end["q"][0] - 0.4 - np.arcsin(0.01 * rate)) < 2e-15
    assert abs(end["v"][0] - rate) < 1e-13
    assert end["residual"] < 1e-15


def test_the_residual_grows_towards_steps_without_a_solution() -> None:
    """A turn near 90 degrees takes more iterations than there are, and none has the sine 1.2."""
    residuals = []
    for rate in (95.0, 99.0, 120.0):
        end = after(FREE, "step_variational", {"q": np.array([0.0]), "v": np.array([rate])}, 0.01)
        residuals.append(float(end["residual"]))
        if rate < 100:
            assert 0.1 < abs(end["q"][0] - np.arcsin(0.01 * rate)) / residuals[-1] < 10
    assert 1e-12 < residuals[0] < 1e-2 * residuals[1] and residuals[2] > 1


@pytest.mark.parametrize("chain", CHAINS[::2], ids=label)
def test_the_residual_is_the_error_of_too_few_iterations(
    chain: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Newton's method: each residual is about the square of the one before."""
    state, h = start(chain), 0.1
    enough = after(chain, "step_variational", state, h)
    assert enough["residual"] < 1e-15
    residuals = []
    for iterations in (1, 2, 3):
        monkeypatch.setattr(step_variational, "ITERATIONS", iterations)
        fewer = after(chain, "step_variational", state, h)
        residuals.append(float(fewer["residual"]))
        assert 0.05 < np.max(np.abs(fewer["q"] - enough["q"])) / residuals[-1] < 20
    assert residuals[1] < 3 * residuals[0] ** 2 and residuals[2] < 3 * residuals[1] ** 2
