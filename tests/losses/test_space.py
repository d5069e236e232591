"""Dry friction in space: one law along a vector, which is the plane's in every plane, smooth at rest, and what a Taylor flow expands."""

from __future__ import annotations

from dataclasses import replace
from random import Random
from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf
from scipy.integrate import solve_ivp

from phichain import build
from phichain.ir import evaluate
from phichain.lowering import lower_function
from phichain.lowering.series.run import expand
from phichain.lowering.series.spatial import spatial_series
from phichain.mechanics import derive
from phichain.motion import simulate
from phichain.scene import Scene
from phichain.system import rhs
from phichain.system.power import powers
from tests.losses.chains import braked
from tests.lowering.taylor_oracle import EXACT

FLOWN = ("forward_dynamics", "energy", "propagate")


def in_plane(chain: Scene, q: list[float], v: list[float], turn: float = 0.0) -> tuple[list[float], list[float]]:
    """A planar state, absolute angles, as one in space whose plane is turned about the vertical."""
    carts = int(chain.has_cart)
    c, s = np.cos(turn), np.sin(turn)
    place = [q[0] * c, q[0] * s] if carts else []
    speed = [v[0] * c, v[0] * s] if carts else []
    for angle, rate in zip(q[carts:], v[carts:], strict=True):
        place += [np.sin(angle) * c, np.sin(angle) * s, np.cos(angle)]
        speed += [-rate * s, rate * c, 0.0]
    return place, speed


@pytest.mark.parametrize("laws", ["fC", "fdCcm"])
def test_in_a_plane_it_is_the_friction_of_the_plane(laws: str) -> None:
    """Fast, at the slope of tanh, and so slow that a square of the rate is no number of the arithmetic."""
    plane = braked(3, "planar", laws, angles="absolute", actuated="none")
    space = braked(3, "spatial", laws, actuated="none")
    programs = [lower_function(derive(chain), "forward_dynamics", "loops") for chain in (plane, space)]
    source = Random(f"plane {laws}")
    for size in (30.0, 1.0, 1e-3, 1e-9, 1e-170):
        q, v = [source.uniform(-2, 2) for _ in range(4)], [size * source.uniform(-1, 1) for _ in range(4)]
        flat = evaluate(programs[0], {"q": q, "v": v})["a"]
        for turn in (0.0, 0.7):
            place, speed = in_plane(plane, q, v, turn)
            round_ = evaluate(programs[1], {"q": place, "v": speed})["a"]
            _, bent = in_plane(plane, q, list(flat), turn)
            assert np.max(np.abs(round_ - np.array(bent))) < 4e-14 * max(1.0, np.max(np.abs(flat)))


@pytest.mark.parametrize("real", ["double", "float"])
def test_at_rest_it_is_a_damper(real: str) -> None:
    """No rate at all, and rates from which nothing is left when squared: the slope is d + F / v_0, without NaN and with all digits."""
    chain = braked(2, "spatial", "fdCc", actuated="none", real=real)
    damper = replace(
        chain, friction=None, friction_speed=None, cart_friction=None, cart_friction_speed=None,
        damping=[d + f / chain.friction_speed for d, f in zip(chain.damping, chain.friction, strict=True)],
        cart_damping=chain.cart_damping + chain.cart_friction / chain.cart_friction_speed,
    )  # fmt: skip
    programs = [lower_function(derive(scene), "state_jacobian", "loops") for scene in (chain, damper)]
    q, _ = in_plane(braked(2, "planar", "fC"), [0.1, 0.4, -0.9], [0.0, 0.0, 0.0])
    for size in (0.0, 1e-25, 1e-12):
        v = [0.0 if size == 0 else size * entry for entry in (0.3, -0.2, *np.cross([1, 2, 0.5], q[2:5]), *np.cross([-1, 0.2, 2], q[5:8]))]
        kind = np.float32 if real == "float" else np.float64
        given = {"q": np.array(q, kind), "v": np.array(v, kind)}
        found, plain = (evaluate(program, given) for program in programs)
        for name in found:
            assert np.all(np.isfinite(found[name]))
            assert np.max(np.abs(found[name] - plain[name])) < 1e3 * np.finfo(kind).eps * np.max(np.abs(plain["dadv"]))


def test_it_takes_the_power_that_it_says() -> None:
    chain = braked(2, "spatial", "fCdcm", actuated="none", want=FLOWN)
    system = build(chain)
    found = simulate(system, _start(chain), [0.0, 1.0], method="taylor")
    lost = powers(system, found.x, np.zeros((len(found.x), 0)))
    slips = np.diff(found.x[:, chain.nq + 2 :].reshape(-1, 2, 3), axis=1, prepend=0.0)
    size, speed = np.linalg.norm(slips, axis=-1), np.linalg.norm(found.x[:, chain.nq : chain.nq + 2], axis=-1)
    by_hand = size**2 @ chain.damping + (size * np.tanh(size / chain.friction_speed)) @ chain.friction
    by_hand += 0.45 * speed**2 + 0.9 * speed * np.tanh(speed / chain.cart_friction_speed)
    assert np.allclose(lost.loss, by_hand, rtol=1e-13, atol=0)
    assert np.max(np.abs(found.balance)) < 1e-13


def _start(chain: Scene, size: float = 1.0) -> np.ndarray:
    """A state that is in no plane; its rates are of that size."""
    source, carts = np.random.default_rng(4), 2 * chain.has_cart
    q, v = list(source.normal(size=carts)), list(size * source.normal(size=carts))
    for _ in range(chain.links):
        link = source.normal(size=3)
        link /= np.linalg.norm(link)
        q, v = [*q, *link], [*v, *(size * np.cross(link, source.normal(size=3)))]
    return np.array([*q, *v])


RUBBED: dict[str, dict[str, Any]] = {
    "tips": {"laws": "fC", "code": "loops", "actuated": "none"},
    "anywhere": {"laws": "fdkCcm", "actuated": "none"},
    "held": {"laws": "fcC", "com": [0.2, 0.0], "inertia": [0.1, 0.3], "actuated": "none"},
}


@pytest.mark.long
@pytest.mark.parametrize("name", RUBBED)
def test_the_taylor_flow_is_the_motion_and_its_columns_the_differences(name: str) -> None:
    """By tensions, by the articulated sweep and by moments; from rest, from rates below the last digit, and from fast ones."""
    chain = braked(2, "spatial", **RUBBED[name], want=FLOWN, variational=True)
    system, h = build(chain), 1e-4

    def end(x: np.ndarray) -> np.ndarray:
        found = system.propagate(x[: system.nq], x[system.nq :], 0.0, 0.5, 1e-16)
        return np.append(found.q, found.v)

    for size in (0.0, 1e-18, 5.0):
        x = _start(chain, size)
        right = solve_ivp(rhs(system), (0.0, 0.5), x, "DOP853", rtol=3e-14, atol=1e-15).y[:, -1]
        assert np.max(np.abs(end(x) - right)) < 4e-12
    x = _start(chain)
    found = system.propagate(x[: system.nq], x[system.nq :], 0.0, 0.5, 1e-16, transition=np.eye(system.nx)).transition
    along = rhs(system)(0.0, x)  # tangent to the states
    states = [solve_ivp(rhs(system), (0.0, s * h), x, "DOP853", rtol=3e-14, atol=1e-15).y[:, -1] for s in (-2, -1, 1, 2)]
    ends = [end(state) for state in states]
    slope = (8 * (ends[2] - ends[1]) - (ends[3] - ends[0])) / (12 * h)
    assert np.max(np.abs(found @ along - slope)) < 2e-9 * max(1.0, np.max(np.abs(slope)))


@pytest.mark.long
@pytest.mark.parametrize(("real", "slow"), [("float", 1e-3), ("double", 1e-8)])
def test_the_flow_stays_in_range_far_from_rest(real: str, slow: float) -> None:
    """Rates of order one over such speeds have squares whose powers are no numbers of the type; tanh is 1, and another speed changes nothing."""
    ends, x = [], _start(braked(1, "spatial", "f", "fixed"))
    for speed in (slow, 1e-2):
        chain = braked(1, "spatial", "f", "fixed", want=("propagate",), friction_speed=speed, real=real, variational=real == "double")
        system, columns = build(chain), {"transition": np.eye(6)} if real == "double" else {}
        ends.append(system.propagate(x[:3], x[3:], 0.0, 0.1, 1e-12 if columns else 1e-6, **columns))
        assert ends[-1].outcome == "done"
    near = 1e-13 if real == "double" else 3e-6
    assert np.max(np.abs(ends[0].v - ends[1].v)) < near and np.max(np.abs(ends[0].q - ends[1].q)) < near
    if real == "double":
        assert ends[0].transition is not None and np.max(np.abs(ends[0].transition - ends[1].transition)) < 1e-12


@pytest.mark.parametrize("speed", [3.0, 0.05, 1e-5])
def test_its_recurrence_through_rest_and_far_from_it(speed: float) -> None:
    """T = tanh(root s) / root s over orders of s, against the derivatives of the law itself in 60 digits."""
    chain = braked(1, "spatial", "f", "fixed", want=("propagate",), friction_speed=speed)
    x = _start(chain)
    with mp.workdps(60):
        made = expand(spatial_series(derive(chain)), EXACT, 9, [mpf(y) for y in x[:3]], [mpf(y) for y in np.cross(x[3:], x[:3])])
        spins = [[sum(_cross(made.state[j][:3], made.state[n - j][3:])[i] for j in range(n + 1)) for i in range(3)] for n in range(9)]

        def law(t: Any) -> Any:
            w = [sum(row[i] * t**n for n, row in enumerate(spins)) for i in range(3)]
            size = mp.sqrt(sum(y * y for y in w)) / speed
            return mp.tanh(size) / size

        true = mp.taylor(law, 0, 7)
        found = [row[3 + 4] for row in made.left]
        assert all(abs(a - b) < mpf(10) ** -25 * max(1, abs(b)) for a, b in zip(found[2:8], true[1:7], strict=True))


def _cross(a: list[Any], b: list[Any]) -> list[Any]:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
