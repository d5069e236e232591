"""Motions with losses: what comes to rest by dry friction, by every method that a user may take."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from mpmath import mp, mpf
from scipy.integrate import solve_ivp

from phichain import build
from phichain.fractional import propagation
from phichain.motion import simulate
from phichain.scene import Scene
from phichain.system import System, rhs
from tests.losses.collocation import Field, integrate, one_step
from tests.losses.dense import accelerations

STICKING = Scene("sticking", 1, base="cart", cart_mass=1.0, mass=0.5, length=0.7, friction=0.3, friction_speed=1e-3, cart_friction=1.5,
                 cart_friction_speed=1e-3, cart_damping=0.3, actuated="none",
                 want=("forward_dynamics", "state_jacobian", "energy", "propagate_stiff"))  # fmt: skip
START = np.array([0.0, 1.2, 0.5, -1.0])
#: The state after 2 s, by `integrate` on `dense.accelerations`: 24 to 36 digits, tolerances 1e-15 to 1e-26.
AFTER = {
    1e-1: [0.35311159407672075807, 0.052598925259932978905, 0.056357148408338993168, -1.1989560440965813257],
    1e-6: [0.3496278742118331065, 0.066744984999688758497, 0.014106514450788802195, -1.2734288116893048537],
    1e-3: [0.349821989009394631664737, 0.0667125923833830774889743, 0.014139449249308057514443, -1.27157108277975504865125],
}
#: The same of the braked swing after half a second, pushed by `PUSH`.
SWUNG = [
    0.39456340994206710881, 0.11891639118558993565, -0.69567842360423795754,
    0.78446257075116207094, -1.6784431629507698038, 2.9289044635180027055,
]  # fmt: skip
PUSH = np.array([0.5, 0.1, -0.2])
FLOWN = {"variational": True, "want": ("forward_dynamics", "propagate")}
BRAKED = Scene("braked_swing", 2, base="cart", cart_mass=1.3, cart_damping=0.4, mass=[0.7, 0.5], length=[0.6, 0.4], com=[0.3, 0.25],
               stiffness=[1.0, 0.5], rest_angle=[0.3, -0.4], damping=[0.02, 0.01], actuated="all", variational=True,
               want=("forward_dynamics", "energy", "propagate", "propagate_stiff", "propagate_batch", "step"))  # fmt: skip


def field(scene: Scene, u: tuple[float, ...] = ()) -> Field:
    """x' by the dense Lagrangian, what the references above were made with."""
    return lambda x: [*x[scene.nq :], *accelerations(scene, x[: scene.nq], x[scene.nq :], u)]


@pytest.mark.long
def test_the_references_can_be_made() -> None:
    """The first hundredth of a second of the braked swing, once more, by the emitted accelerations as well."""
    x = [0.1, 0.4, -0.9, 0.3, 1.0, -2.0]
    with mp.workdps(20):
        right = [float(y) for y in integrate(field(BRAKED, tuple(PUSH)), x, 0.01, mpf(10) ** -12, stages=3)]
    found = simulate(build(BRAKED), np.array(x), [0.0, 0.01], u=PUSH)
    assert np.max(np.abs(found.x[-1] - right)) < 1e-11


@pytest.mark.long
@pytest.mark.parametrize("speed", sorted(AFTER))
def test_what_sticks_ends_right(speed: float) -> None:
    """`auto` at every tolerance, and the stiff flow asked for by name."""
    system = build(replace(STICKING, friction_speed=speed, cart_friction_speed=speed))
    for tol, most in ((1e-6, 1e-5), (1e-9, 1e-8), (1e-12, 1e-10)):
        for method in ("auto", "rosenbrock"):
            found = simulate(system, START, [0.0, 2.0], tol=tol, method=method)
            assert found.status == "complete"
            assert np.max(np.abs(found.x[-1] - AFTER[speed])) < most, (tol, method)


@pytest.mark.long
@pytest.mark.parametrize("speed", sorted(AFTER)[1:])
def test_the_taylor_flow_sticks_as_well(speed: float) -> None:
    """At round-off, one at a time and many at once; its steps are as short as v_0 asks for."""
    scene = replace(STICKING, friction_speed=speed, cart_friction_speed=speed, want=("forward_dynamics", "propagate", "propagate_batch"))
    system = build(scene)
    found = system.propagate(START[:2], START[2:], 0.0, 2.0, 1e-16)
    assert np.max(np.abs(np.append(found.q, found.v) - AFTER[speed])) < 2e-13
    many = system.propagate_batch(np.tile(START[:2], (3, 1)), np.tile(START[2:], (3, 1)), 0.0, 2.0, 1e-16)
    assert np.max(np.abs(np.hstack([many.q, many.v]) - AFTER[speed])) < 2e-13


def rubbing() -> Iterator[Scene]:
    """Chains that between them take every branch of the recurrence of dry friction: joints, carts, rotors, loops, numbers at run time."""
    links, dry = {"mass": [0.7, 0.5], "length": [0.6, 0.4], "com": [0.3, 0.25]}, {"friction": [0.2, 0.1], "friction_speed": 0.5}
    cart = {"base": "cart", "cart_mass": 1.3, "cart_friction": 0.6, "cart_friction_speed": 0.4, "actuated": "none"}
    yield Scene("rubbed_one", 1, mass=0.7, length=0.6, com=0.3, friction=0.2, friction_speed=0.5, stiffness=1.0, damping=0.1, **FLOWN)
    yield Scene("rubbed_pair", 2, **links, **dry, angles="adjacent", **FLOWN)
    yield Scene("rubbed_cart", 2, **links, **cart, damping=0.05, code="loops", **FLOWN)
    yield Scene("rubbed_geared", 2, **links, **dry, **cart, armature=[0.03, 0.01], angles="absolute", **FLOWN)


@pytest.mark.long
@pytest.mark.parametrize("scene", list(rubbing()), ids=lambda scene: scene.name)
def test_the_taylor_flow_with_friction_is_the_motion_and_its_columns_the_differences(scene: Scene) -> None:
    system, h = build(scene), 1e-4
    x = np.linspace(0.9, -0.7, system.nx)
    right = solve_ivp(lambda t, y: rhs(system)(t, y), (0.0, 0.5), x, "DOP853", rtol=3e-14, atol=1e-15).y[:, -1]

    def end(y: np.ndarray) -> np.ndarray:
        found = system.propagate(y[: system.nq], y[system.nq :], 0.0, 0.5, 1e-16)
        return np.append(found.q, found.v)

    assert np.max(np.abs(end(x) - right)) < 2e-12
    found = system.propagate(x[: system.nq], x[system.nq :], 0.0, 0.5, 1e-16, transition=np.eye(system.nx)).transition
    units = h * np.eye(system.nx)
    slopes = [(8 * (end(x + e) - end(x - e)) - (end(x + 2 * e) - end(x - 2 * e))) / (12 * h) for e in units]
    assert np.max(np.abs(found - np.array(slopes).T)) < 2e-9


def test_auto_sees_what_will_come_to_rest() -> None:
    """Nothing is stiff while it slides: the place at rest decides, and a friction so steep is the stiff flow's."""
    mild, steep = (
        build(replace(STICKING, friction_speed=speed, cart_friction_speed=speed)) for speed in (0.1, 1e-6)
    )
    found = simulate(mild, START, [0.0, 2.0], tol=1e-9)
    assert found.method == "DOP853" and "not stiff" in found.reason
    found = simulate(steep, START, [0.0, 2.0], tol=1e-9)
    assert found.method == "rosenbrock" and "at rest" in found.reason
    assert np.max(np.abs(found.x[-1] - AFTER[1e-6])) < 1e-8


@pytest.mark.parametrize("stages", [2, 3])
def test_the_collocation_is_of_its_order(stages: int) -> None:
    """Radau IIA of s stages has order 2 s - 1 on a swing in 30 digits."""
    with mp.workdps(30):
        errors = []
        for steps in (8, 16):
            x = [mpf(1), mpf(0)]
            for _ in range(steps):
                x = one_step(lambda y: [y[1], -y[0]], x, mpf(1) / steps, stages)
            errors.append(abs(x[0] - mp.cos(1)) + abs(x[1] + mp.sin(1)))
    assert abs(float(mp.log(errors[0] / errors[1], 2)) - (2 * stages - 1)) < 0.2


@pytest.fixture(scope="module")
def braked() -> System:
    return build(BRAKED)


def test_the_taylor_flow_of_a_braked_chain_is_the_motion_of_the_dense_lagrangian(braked: System) -> None:
    """Cart damper and springs that rest elsewhere, one at a time and many at once; the stiff flow to its tolerance."""
    x, u, right = np.array([0.1, 0.4, -0.9, 0.3, 1.0, -2.0]), PUSH, np.array(SWUNG)
    q, v = x[:3], x[3:]
    found = braked.propagate(q, v, 0.0, 0.5, 1e-16, u=u)
    assert np.max(np.abs(np.append(found.q, found.v) - right)) < 1e-13
    many = braked.propagate_batch(np.tile(q, (5, 1)), np.tile(v, (5, 1)), 0.0, 0.5, 1e-16, u=np.tile(u, (5, 1)))
    assert np.max(np.abs(np.hstack([many.q, many.v]) - right)) < 1e-13
    stiff = braked.propagate_stiff(q, v, 0.0, 0.5, 1e-10, u=u)
    assert np.max(np.abs(np.append(stiff.q, stiff.v) - right)) < 1e-8


def test_columns_are_the_differences_of_the_braked_flow(braked: System) -> None:
    x, h = np.array([0.1, 0.4, -0.9, 0.3, 1.0, -2.0]), 1e-4

    def end(y: np.ndarray) -> np.ndarray:
        found = braked.propagate(y[:3], y[3:], 0.0, 0.4, 1e-16, u=np.zeros(3))
        return np.append(found.q, found.v)

    found = braked.propagate(x[:3], x[3:], 0.0, 0.4, 1e-16, u=np.zeros(3), transition=np.eye(6)).transition
    units = h * np.eye(6)
    # Central differences of order 4.
    slopes = [(8 * (end(x + e) - end(x - e)) - (end(x + 2 * e) - end(x - 2 * e))) / (12 * h) for e in units]
    assert np.max(np.abs(found - np.array(slopes).T)) < 1e-9


def test_a_braked_spatial_cart_slows_down() -> None:
    """Links that hang still and a cart of mass m among them all: x' decays as exp(-d t / m) where no link swings."""
    scene = Scene("braked_trolley", 1, space="spatial", base="cart", cart_mass=2.0, cart_damping=1.5, mass=1e-12, length=0.5,
                  gravity=0.0, want=("forward_dynamics", "propagate", "propagate_batch", "propagate_stiff"))  # fmt: skip
    system = build(scene)
    q, v = np.array([0.0, 0.0, 0.0, 0.0, 1.0]), np.array([0.8, -0.4, 0.0, 0.0, 0.0])
    right = v[:2] * np.exp(-0.75 * 0.6)
    for name, tol in (("propagate", 1e-16), ("propagate_stiff", 1e-12)):
        found = system.function(name)(q, v, 0.0, 0.6, tol, u=np.zeros(2))
        assert np.max(np.abs(found.v[:2] - right)) < 1e-9


def test_many_states_at_once_are_each_of_them() -> None:
    """tanh lane by lane, in either type, with numbers at run time as well."""
    for real, most in (("double", 1e-14), ("float", 1e-6)):
        scene = replace(STICKING, links=2, mass=[0.5, 0.3], length=[0.7, 0.6], friction="runtime", friction_speed=0.4, cart_friction_speed=0.6,
                        real=real, want=("forward_dynamics", "forward_dynamics_batch"))  # fmt: skip
        system, rng = build(scene), np.random.default_rng(3)
        q, v = rng.normal(size=(2, 37, 3))
        p = {"p": {"friction": [0.2, 0.5]}}
        many = np.asarray(system.function("forward_dynamics_batch")(q, v, **p))
        each = np.array([system.forward_dynamics(*state, **p) for state in zip(q, v, strict=True)])
        assert np.max(np.abs(many - each)) < most * np.max(np.abs(each))


def test_forces_of_a_motion_add_up() -> None:
    """M a + N + G is what inputs, joints and the cart's brakes do, at every sample of a motion."""
    scene = replace(STICKING, links=2, mass=[0.5, 0.3], length=[0.7, 0.6], angles="adjacent", friction=[0.2, 0.1], friction_speed=0.4,
                    cart_friction_speed=0.6, stiffness=[1.0, 0.5], rest_angle=[0.3, -0.2], damping=0.05,
                    want=("forward_dynamics", "mass_matrix", "coriolis", "gravity_torque"))  # fmt: skip
    system = build(scene)
    motion = simulate(system, [0.0, 0.5, -0.4, 0.3, 1.0, -2.0], np.linspace(0.0, 0.5, 11), tol=1e-10)
    total = propagation(system, motion, [1.0], [0.0]).forces["total"]
    needed = np.array([system.mass_matrix(q) @ a for q, a in zip(motion.q, motion.a, strict=True)])
    assert np.max(np.abs(total - needed)) < 1e-12 * np.max(np.abs(needed))
