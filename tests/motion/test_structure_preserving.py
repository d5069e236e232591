"""step_lie4 and step_variational as compiled code: orders, spheres, momenta, energies over long runs, and what simulate says."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from phichain.emit import library_files
from phichain.errors import ConvergenceError
from phichain.files import write_folder
from phichain.lowering import lower
from phichain.mechanics import derive
from phichain.motion import simulate
from phichain.native import Cache, CompilerOptions, build_folder
from phichain.scene import Scene
from phichain.system import System

Vector = NDArray[np.float64]
STEPS = {"step_lie4": 4, "step_variational": 2}
WANT = ["forward_dynamics", "energy", *STEPS]
SCENES: dict[str, dict[str, Any]] = {
    "plane_two": {"links": 2, "space": "planar", "mass": [1.0, 0.7], "length": [0.5, 0.6]},
    "space_two": {"links": 2, "space": "spatial", "mass": [1.0, 0.7], "length": [0.5, 0.6], "com": [0.4, 0.45]},
    "cart_three": {
        "links": 3, "space": "spatial", "base": "cart", "mass": [0.3, 0.4, 0.5], "length": [0.5, 0.6, 0.7],
        "cart_mass": 1.0,
    },
    "damped_two": {
        "links": 2, "space": "spatial", "mass": [1.0, 0.7], "length": [0.5, 0.6], "stiffness": [1.0, 2.0],
        "damping": [0.2, 0.1],
    },
    "driven_cart": {
        "links": 2, "space": "planar", "base": "cart", "mass": [0.6, 0.4], "length": [0.5, 0.6], "com": [0.3, 0.4],
        "cart_mass": 1.0, "damping": [0.2, 0.1], "stiffness": [1.0, 0.5], "actuated": "all", "angles": "absolute",
    },
    "geared_two": {
        "links": 2, "space": "planar", "mass": [1.0, 0.7], "length": [0.5, 0.6], "com": [0.3, 0.6], "inertia": [0.02, 0.0],
        "armature": [0.1, 0.05],
    },
}  # fmt: skip
QUICK = CompilerOptions(flags=("-std=c99", "-O1", "-ffp-contract=fast", "-fPIC", "-shared"))
CONSERVATIVE = ("plane_two", "space_two", "cart_three", "geared_two")


@pytest.fixture(scope="module")
def systems(tmp_path_factory: pytest.TempPathFactory) -> dict[str, System]:
    scratch = tmp_path_factory.mktemp("structure")
    return {name: built(Scene(name, want=WANT, **keys), scratch) for name, keys in SCENES.items()}


def built(scene: Scene, scratch: Path) -> System:
    folder = write_folder(scratch / scene.name, library_files(scene, lower(derive(scene))))
    return build_folder(folder, QUICK, Cache(scratch / "cache"))


def start(system: System) -> tuple[Vector, Vector]:
    """A swing of about 0.6 rad out of any plane, and turning."""
    cart = system.cart_size
    if system.is_planar:
        v = np.full(system.nv, 0.4)
        return np.concatenate([np.zeros(cart), 0.6 * np.linspace(1, 0.5, system.links)]), v
    q, v = np.zeros(system.nq), np.zeros(system.nv)
    v[:cart] = (0.3, -0.2)[:cart]
    unit, omega = q[cart:].reshape(-1, 3), v[cart:].reshape(-1, 3)
    for k in range(system.links):
        unit[k] = (0.5, 0.2 * k - 0.1, 0.8)
        unit[k] /= np.linalg.norm(unit[k])
        omega[k] = np.cross(unit[k], (0.3, 1.1 - 0.3 * k, 0.2))
    return q, v


def inputs(system: System) -> list[Vector]:
    return [np.linspace(0.4, -0.3, system.nu)] if system.nu else []


def walk(system: System, name: str, h: float, steps: int) -> Iterator[tuple[Vector, Vector, float]]:
    """The states after 1 .. steps steps, unforced, and the residual."""
    q, v = start(system)
    u, step = [np.zeros(system.nu)] if system.nu else [], system.function(name)
    for _ in range(steps):
        q, v, *residual = step(h, q, v, *u)
        yield q, v, float(residual[0]) if residual else 0.0


@pytest.mark.long
@pytest.mark.parametrize("method", STEPS)
@pytest.mark.parametrize("name", SCENES)
def test_the_order_of_convergence(systems: dict[str, System], name: str, method: str) -> None:
    system = systems[name]
    u = inputs(system)
    given: dict[str, Any] = {"u": u[0]} if u else {}
    exact = simulate(system, start(system), [0.0, 1.0], "DOP853", 1e-13, **given)
    errors = []
    for h in (0.01, 0.005, 0.0025):
        run = simulate(system, start(system), [0.0, 1.0], method, h=h, **given)
        errors.append(max(np.max(np.abs(run.q[-1] - exact.q[-1])), np.max(np.abs(run.v[-1] - exact.v[-1]))))
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert abs(orders[-1] - STEPS[method]) < 0.1, (errors, orders)


@pytest.mark.parametrize("method", STEPS)
@pytest.mark.parametrize("name", ["space_two", "cart_three"])
def test_unit_vectors_stay_unit_and_rates_tangent(systems: dict[str, System], name: str, method: str) -> None:
    system = systems[name]
    *_, (q, v, _) = walk(system, method, 0.01, 20_000)
    unit, omega = (array[system.cart_size :].reshape(-1, 3) for array in (q, v))
    assert np.max(np.abs(np.linalg.norm(unit, axis=1) - 1)) < 5e-16
    assert np.max(np.abs(np.sum(unit * omega, axis=1))) < 1e-14


@pytest.mark.parametrize(("name", "wandering"), [("plane_two", 1), ("space_two", 1), ("cart_three", 4), ("geared_two", 1)])
def test_the_energy_error_stays_bounded(systems: dict[str, System], name: str, wandering: float) -> None:
    """Over 1e5 steps it neither drifts nor grows; a step half as long has a quarter of it.

    Three links on a cart move chaotically, and reach regions where the same step is a longer one.
    """
    system = systems[name]
    zero = sum(system.energy(*start(system)))
    hanging = zero - system.energy(*hanging_rest(system))[1]

    def errors(h: float, steps: int) -> Vector:
        states = [
            (q, v) for i, (q, v, _) in enumerate(walk(system, "step_variational", h, steps)) if i % 7 == 0
        ]
        kinetic, potential = system.energy(*(np.array(part) for part in zip(*states, strict=True)))
        return (kinetic + potential - zero) / hanging

    long = errors(0.02, 100_000)
    early, quarter = np.max(np.abs(long[:571])), len(long) // 4
    assert np.max(np.abs(long)) < 1.05 * wandering * early
    assert abs(np.mean(long[-quarter:]) - np.mean(long[:quarter])) < 0.05 * wandering * early
    assert 3.5 < early / np.max(np.abs(errors(0.01, 4_000))) < 4.5


def hanging_rest(system: System) -> tuple[Vector, Vector]:
    q = np.zeros(system.nq)
    if not system.is_planar:
        q[system.cart_size :].reshape(-1, 3)[:, 2] = 1.0
    return q, np.zeros(system.nv)


def motion(system: System, q: Vector, v: Vector) -> tuple[Vector, Vector]:
    """Positions and velocities of cart and point masses, straight from the scene's numbers."""
    cart = system.cart_size
    length = np.array(SCENES[system.name]["length"])
    com = np.array(SCENES[system.name].get("com", length))
    unit = q[cart:].reshape(-1, 3)
    rate = np.cross(v[cart:].reshape(-1, 3), unit)
    lever = np.tril(np.tile(length, (system.links, 1)), -1) + np.diag(com)
    place, speed = lever @ unit, lever @ rate
    place[:, :cart] += q[:cart]
    speed[:, :cart] += v[:cart]
    return place, speed


def test_horizontal_momentum_is_kept_to_rounding(systems: dict[str, System]) -> None:
    system = systems["cart_three"]
    mass = np.array(SCENES["cart_three"]["mass"])

    def momentum(q: Vector, v: Vector) -> Vector:
        return 1.0 * v[:2] + (mass @ motion(system, q, v)[1])[:2]

    first = momentum(*start(system))
    *_, (q, v, _) = walk(system, "step_variational", 0.01, 20_000)
    assert np.max(np.abs(momentum(q, v) - first)) < 2e-13
    *_, (q, v, _) = walk(system, "step_lie4", 0.01, 2_000)
    assert np.max(np.abs(momentum(q, v) - first)) > 1e-9


@pytest.mark.parametrize("name", ["space_two", "cart_three"])
def test_angular_momentum_about_the_vertical_is_kept_to_rounding(
    systems: dict[str, System], name: str
) -> None:
    """About the origin, with the cart's own part."""
    system = systems[name]
    mass = np.array(SCENES[name]["mass"])

    def spin(q: Vector, v: Vector) -> float:
        place, speed = motion(system, q, v)
        moments = place[:, 0] * speed[:, 1] - place[:, 1] * speed[:, 0]
        return float(mass @ moments + (q[0] * v[1] - q[1] * v[0] if system.has_cart else 0.0))

    first = spin(*start(system))
    *_, (q, v, _) = walk(system, "step_variational", 0.01, 20_000)
    assert abs(first) > 0.1 and abs(spin(q, v) - first) < 1e-12 * (1 + np.max(np.abs(q)))


@pytest.mark.parametrize("name", CONSERVATIVE)
def test_a_run_comes_back(systems: dict[str, System], name: str) -> None:
    system = systems[name]
    q0, v0 = start(system)
    out = simulate(system, (q0, v0), [0.0, 2.0], "step_variational", h=0.01)
    back = simulate(system, (out.q[-1], out.v[-1]), [2.0, 0.0], "step_variational", h=0.01)
    assert max(np.max(np.abs(back.q[-1] - q0)), np.max(np.abs(back.v[-1] - v0))) < 1e-12


def test_the_trajectory_tells_the_residual(systems: dict[str, System]) -> None:
    system = systems["plane_two"]
    run = simulate(system, start(system), 1.0, "step_variational", h=0.01)
    assert "largest residual of step_variational" in run.reason and "not enough" not in run.reason
    turning = np.zeros(2), np.array([9.5, 0.0])  # 0.95 is near the largest sine of a turn there is
    coarse = simulate(system, turning, 0.1, "step_variational", h=0.1)
    assert coarse.status in ("complete", "doubtful") and "its iteration was not enough, shorten h" in coarse.reason
    with pytest.raises(ConvergenceError, match=r"does not converge with h = 0.1 s.*shorten h"):
        simulate(system, (turning[0], 1.2 * turning[1]), 0.1, "step_variational", h=0.1)


def test_single_precision_is_the_same_step(tmp_path: Path, systems: dict[str, System]) -> None:
    for name in ("space_two", "driven_cart"):
        for code in ("loops", "unrolled"):
            scene = Scene(f"{name}_{code}", want=list(STEPS), real="float", code=code, **SCENES[name])
            single, double = built(scene, tmp_path), systems[name]
            q, v = start(double)
            for method in STEPS:
                found = single.function(method)(0.01, q, v, *inputs(double))
                exact = double.function(method)(0.01, q, v, *inputs(double))
                assert found[0].dtype == np.float32
                assert all(np.max(np.abs(a - b)) < 3e-6 for a, b in zip(found, exact, strict=True)), (
                    name,
                    code,
                    method,
                )
