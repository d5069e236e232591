"""The reference against vectors from outside this project, and against the laws of mechanics."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf

from phichain.errors import ArrayError, SceneError, UnsupportedError
from phichain.reference import reference, tangent_directions
from phichain.scene import Scene
from tests.mechanics.chains import (
    CART,
    JOINTS,
    OFFSET,
    SCENES,
    SIZES,
    configuration_rate,
    planar,
    scenes,
    state,
)
from tests.reference_cases import ReferenceCase, extreme, relative_error, vectors, vectors_more


@pytest.fixture(autouse=True)
def working_precision() -> Iterator[None]:
    """Do the arithmetic of these tests in 100 digits."""
    with mp.workdps(100):
        yield


@pytest.mark.parametrize("case", vectors() + vectors_more() + extreme(), ids=str)
def test_outputs_agree_with_the_published_vectors(case: ReferenceCase) -> None:
    for function, expected in case.expected.items():
        found = reference(case.scene, function, case.inputs, digits=30)
        for name, values in expected.items():
            assert relative_error(found[name], values) < 1e-22, (function, name)


@scenes
def test_energy_changes_by_the_power_of_inputs_and_dampers(scene: Scene) -> None:
    inputs = state(scene)
    flow = {
        "q": configuration_rate(scene, inputs),
        "v": reference(scene, "forward_dynamics", inputs, 100)["a"],
    }
    h = mpf(10) ** -30

    def energy_after(time: Any) -> Any:
        moved = {n: [x + time * y for x, y in zip(inputs[n], flow[n], strict=True)] for n in "qv"}
        return sum(reference(scene, "energy", moved, digits=100).values())

    change = (energy_after(h) - energy_after(-h)) / (2 * h)
    assert relative_error([change], [power(scene, inputs)]) < 1e-40


def power(scene: Scene, inputs: dict[str, list[Any]]) -> Any:
    """Return the power of the inputs minus what the dampers take, d_k |relative spin|^2."""
    v, u = list(inputs["v"]), list(inputs["u"])
    carts = (1 if scene.is_planar else 2) if scene.has_cart else 0
    driven = (list(range(carts)) if scene.has_force else []) + [carts + j - 1 for j in scene.actuated_joints]
    supplied = sum(u[i] * v[j] for i, j in enumerate(driven))
    if not isinstance(scene.damping, tuple):
        return supplied
    if scene.is_planar:
        theta_dot = v[carts:]
        absolute = {
            "relative": [sum(theta_dot[: k + 1]) for k in range(3)],
            "absolute": theta_dot,
            "adjacent": [theta_dot[0], theta_dot[1] + theta_dot[0], theta_dot[2] + theta_dot[1]],
        }[str(scene.angles)]
        spins = [[w] for w in absolute]
    else:
        spins = [v[k : k + 3] for k in range(carts, len(v), 3)]
    before = [[mpf(0)] * len(spins[0]), *spins]
    gaps = [
        sum((a - b) ** 2 for a, b in zip(*pair, strict=True)) for pair in zip(spins, before, strict=False)
    ]
    return supplied - sum(d * gap for d, gap in zip(scene.damping, gaps, strict=True))


@scenes
def test_mass_matrix_coriolis_and_gravity_make_up_the_equations_of_motion(scene: Scene) -> None:
    """Without joints, (15) and (16) read M a + N + G = B u."""
    free = Scene("a", scene.links, scene.space, scene.base, mass=scene.mass, length=scene.length,
                 com=scene.com, cart_mass=scene.cart_mass, angles=scene.angles, actuated=scene.actuated)  # fmt: skip
    inputs = state(free)
    with mp.workdps(60):
        M, N, G = (
            reference(free, function, inputs)[name]
            for function, name in (("mass_matrix", "M"), ("coriolis", "N"), ("gravity_torque", "G"))
        )
        a = reference(free, "forward_dynamics", inputs)["a"]
        balance = [
            sum(m * x for m, x in zip(row, a, strict=True)) + n + g for row, n, g in zip(M, N, G, strict=True)
        ]
        carts = (1 if free.is_planar else 2) if free.has_cart else 0
        driven = (list(range(carts)) if free.has_force else []) + [
            carts + j - 1 for j in free.actuated_joints
        ]
        for target, push in zip(driven, inputs["u"], strict=True):
            balance[target] -= push
        assert max(map(abs, balance)) < 1e-45


@pytest.mark.parametrize("cart", [{}, CART], ids=["fixed", "cart"])
def test_a_spatial_chain_in_a_vertical_plane_stays_there_and_moves_as_the_planar_one(
    cart: dict[str, Any],
) -> None:
    """q = (sin phi, 0, cos phi), omega = phi' e_2: no acceleration out of the plane, damped or not."""
    damped = {"damping": JOINTS["damping"]}
    flat = Scene("a", **SIZES, **OFFSET, **damped, **cart, angles="absolute")
    deep = Scene("a", space="spatial", **SIZES, **OFFSET, **damped, **cart)
    inputs, carts = state(flat), flat.nq - 3
    still = [mpf(0)] * carts
    pushed = {
        "q": inputs["q"][:carts]
        + still
        + [x for phi in inputs["q"][carts:] for x in (mp.sin(phi), mpf(0), mp.cos(phi))],
        "v": inputs["v"][:carts]
        + still
        + [x for rate in inputs["v"][carts:] for x in (mpf(0), rate, mpf(0))],
        "u": inputs["u"] + still,
    }
    planar = reference(flat, "forward_dynamics", inputs)["a"]
    lifted = planar[:carts] + still + [x for rate in planar[carts:] for x in (mpf(0), rate, mpf(0))]
    assert relative_error(reference(deep, "forward_dynamics", pushed)["a"], lifted) < 1e-45


@planar
def test_inverse_dynamics_undoes_forward_dynamics(scene: Scene) -> None:
    full = Scene("a", scene.links, base=scene.base, mass=scene.mass, length=scene.length, com=scene.com,
                 cart_mass=scene.cart_mass, angles=scene.angles, actuated="all", damping=scene.damping,
                 stiffness=scene.stiffness)  # fmt: skip
    inputs = state(full)
    inputs["u"] = reference(full, "inverse_dynamics", inputs)["u"]
    assert relative_error(reference(full, "forward_dynamics", inputs)["a"], inputs["a"]) < 1e-40


def test_digits_are_those_asked_for() -> None:
    case = vectors()[-1]
    coarse, fine = (
        reference(case.scene, "forward_dynamics", case.inputs, digits)["a"] for digits in (20, 70)
    )
    assert 1e-24 < relative_error(coarse, fine) < 1e-19


def test_runtime_parameters_are_read_from_params() -> None:
    numbers: dict[str, Any] = {
        "mass": [1.0, 2.0],
        "length": [0.5, 0.25],
        "com": [0.4, 0.25],
        "stiffness": [1.0, 3.0],
    }
    fixed = Scene("a", 2, **numbers, gravity=1.6, base="cart", cart_mass=3.0)
    runtime = Scene(
        "a", 2, **dict.fromkeys(numbers, "runtime"), gravity="runtime", base="cart", cart_mass="runtime"
    )
    inputs = state(fixed)
    params = {**{key: np.array(value) for key, value in numbers.items()}, "gravity": 1.6, "cart_mass": 3.0}
    found = reference(runtime, "forward_dynamics", inputs, params=params)
    assert found == reference(fixed, "forward_dynamics", inputs)
    with pytest.raises(SceneError, match="runtime parameter without a value"):
        reference(runtime, "forward_dynamics", inputs)


def test_single_precision_inputs_are_exact() -> None:
    scene = SCENES["planar"]
    single = {
        name: np.array([float(x) for x in values], dtype=np.float32) for name, values in state(scene).items()
    }
    double = {name: values.astype(float) for name, values in single.items()}
    assert reference(scene, "forward_dynamics", single) == reference(scene, "forward_dynamics", double)


@pytest.mark.parametrize(
    ("name", "function", "changes", "error", "message"),
    [
        ("planar", "forward", {}, UnsupportedError, "choose one of forward_dynamics"),
        ("spatial", "phi", {}, UnsupportedError, "planar scenes"),
        ("planar", "project", {}, UnsupportedError, "spatial scenes"),
        ("planar", "energy", {"v": [1.0]}, ArrayError, "has 1 entries"),
        ("planar", "energy", {"v": None}, ArrayError, "argument of energy"),
        ("planar", "energy", {"v": [0.0, float("nan"), 0.0]}, ArrayError, "not finite"),
        ("spatial", "energy", {"q": [0.0] * 9}, ArrayError, "link 1 has length 0"),
    ],
)
def test_bad_requests_get_one_clear_error(
    name: str, function: str, changes: dict[str, Any], error: type[Exception], message: str
) -> None:
    scene = SCENES[name]
    with pytest.raises(error, match=message):
        reference(scene, function, {**state(scene), **changes})


def test_planar_scenes_have_no_tangent_directions() -> None:
    with pytest.raises(UnsupportedError, match="dadq"):
        tangent_directions(SCENES["planar"], [0.0] * 3, [0.0] * 3)
