"""The reference against vectors from outside this project, and against the laws of mechanics."""

from __future__ import annotations

import random
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf

from phichain.errors import ArrayError, SceneError, UnsupportedError
from phichain.mechanics.reference import reference, tangent_directions
from phichain.scene import Scene
from tests.reference_cases import ReferenceCase, extreme, flat, relative_error, vectors, vectors_more

JOINTS: dict[str, Any] = {"damping": [0.3, 0.1, 0.2], "stiffness": [2.0, 0.5, 1.5]}
SIZES: dict[str, Any] = {"links": 3, "mass": [0.7, 1.1, 0.4], "length": [0.5, 0.8, 0.3]}
OFFSET: dict[str, Any] = {"com": [0.2, 0.8, 0.1]}
CART: dict[str, Any] = {"base": "cart", "cart_mass": 0.9}
SCENES = {
    "planar": Scene("a", **SIZES, **OFFSET, actuated="all"),
    "adjacent": Scene("a", **SIZES, **OFFSET, **JOINTS, angles="adjacent", actuated="all"),
    "absolute-cart": Scene("a", **SIZES, **JOINTS, **CART, angles="absolute", actuated="all"),
    "relative-cart": Scene("a", **SIZES, **OFFSET, **JOINTS, **CART, actuated=[2, 3]),
    "spatial": Scene("a", space="spatial", **SIZES, **OFFSET, **JOINTS),
    "spatial-cart": Scene("a", space="spatial", **SIZES, **JOINTS, **CART),
}


@pytest.fixture(autouse=True)
def working_precision() -> Iterator[None]:
    """Do the arithmetic of these tests in 100 digits."""
    with mp.workdps(100):
        yield


scenes = pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES.keys())
planar = pytest.mark.parametrize("scene", [s for s in SCENES.values() if s.is_planar])
spatial = pytest.mark.parametrize("scene", [s for s in SCENES.values() if not s.is_planar])


def state(scene: Scene, seed: int = 1) -> dict[str, list[Any]]:
    """Return random inputs; spatial ones exactly consistent to 100 digits."""
    draw = random.Random(seed)
    sizes = {"q": scene.nq, "v": scene.nv, "u": scene.nu, "a": scene.nv}
    inputs = {name: [mpf(draw.uniform(-1.5, 1.5)) for _ in range(size)] for name, size in sizes.items()}
    if not scene.is_planar:
        exact = reference(scene, "project", inputs, digits=100)
        inputs |= {"q": exact["q_out"], "v": exact["v_out"]}
    return inputs


def configuration_rate(scene: Scene, inputs: dict[str, list[Any]]) -> list[Any]:
    """Return q' by plain cross products."""
    if scene.is_planar:
        return inputs["v"]
    carts = 2 if scene.has_cart else 0
    rate = list(inputs["v"][:carts])
    for k in range(carts, scene.nq, 3):
        (a, b, c), (x, y, z) = inputs["v"][k : k + 3], inputs["q"][k : k + 3]
        rate += [b * z - c * y, c * x - a * z, a * y - b * x]
    return rate


@pytest.mark.parametrize("case", vectors() + vectors_more() + extreme(), ids=str)
def test_outputs_agree_with_the_published_vectors(case: ReferenceCase) -> None:
    for function, expected in case.expected.items():
        found = reference(case.scene, function, case.inputs, digits=30)
        for name, values in expected.items():
            assert relative_error(found[name], values) < 1e-22, (function, name)


@scenes
def test_energy_changes_by_the_power_of_inputs_and_dampers(scene: Scene) -> None:
    inputs = state(scene)
    flow = {"q": configuration_rate(scene, inputs), "v": reference(scene, "forward_dynamics", inputs, 100)["a"]}
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
    gaps = [sum((a - b) ** 2 for a, b in zip(*pair, strict=True)) for pair in zip(spins, before, strict=False)]
    return supplied - sum(d * gap for d, gap in zip(scene.damping, gaps, strict=True))


@scenes
def test_mass_matrix_coriolis_and_gravity_make_up_the_equations_of_motion(scene: Scene) -> None:
    """Without joints, (15) and (16) read M a + N + G = B u."""
    free = Scene("a", scene.links, scene.space, scene.base, mass=scene.mass, length=scene.length, com=scene.com,
                 cart_mass=scene.cart_mass, angles=scene.angles, actuated=scene.actuated)  # fmt: skip
    inputs = state(free)
    with mp.workdps(60):
        M, N, G = (
            reference(free, function, inputs)[name]
            for function, name in (("mass_matrix", "M"), ("coriolis", "N"), ("gravity_torque", "G"))
        )
        a = reference(free, "forward_dynamics", inputs)["a"]
        balance = [sum(m * x for m, x in zip(row, a, strict=True)) + n + g for row, n, g in zip(M, N, G, strict=True)]
        carts = (1 if free.is_planar else 2) if free.has_cart else 0
        driven = (list(range(carts)) if free.has_force else []) + [carts + j - 1 for j in free.actuated_joints]
        for target, push in zip(driven, inputs["u"], strict=True):
            balance[target] -= push
        assert max(map(abs, balance)) < 1e-45


@planar
def test_inverse_dynamics_undoes_forward_dynamics(scene: Scene) -> None:
    full = Scene("a", scene.links, base=scene.base, mass=scene.mass, length=scene.length, com=scene.com,
                 cart_mass=scene.cart_mass, angles=scene.angles, actuated="all", damping=scene.damping,
                 stiffness=scene.stiffness)  # fmt: skip
    inputs = state(full)
    inputs["u"] = reference(full, "inverse_dynamics", inputs)["u"]
    assert relative_error(reference(full, "forward_dynamics", inputs)["a"], inputs["a"]) < 1e-40


@planar
def test_state_jacobian_is_the_difference_quotient_of_forward_dynamics(scene: Scene) -> None:
    inputs, h = state(scene), mpf(10) ** -20
    found = reference(scene, "state_jacobian", inputs)
    for name, output in (("q", "dadq"), ("v", "dadv"), ("u", "dadu")):
        for column in range(len(inputs[name])):
            moved = []
            for step in (h, -h):
                entries = [mpf(entry) for entry in inputs[name]]
                with mp.workdps(80):
                    entries[column] += step
                moved.append(reference(scene, "forward_dynamics", {**inputs, name: entries}, digits=60)["a"])
            with mp.workdps(80):
                quotient = [(a - b) / (2 * h) for a, b in zip(*moved, strict=True)]
            assert relative_error([row[column] for row in found[output]], quotient) < 1e-30


@spatial
def test_tangents_span_the_states_and_the_jacobian_is_linear_in_them(scene: Scene) -> None:
    """The derivative along the motion itself is the sum of those along the directions that make it up."""
    inputs = state(scene)
    directions = tangent_directions(scene, inputs["q"], inputs["v"])
    rows = reference(scene, "state_jacobian", inputs)["tangent"]
    assert len(rows) == len(directions) == 2 * (2 * scene.links + (2 if scene.has_cart else 0))
    flow = configuration_rate(scene, inputs) + reference(scene, "forward_dynamics", inputs)["a"]
    basis = np.array([[float(entry) for entry in (*dq, *dv)] for dq, dv in directions])
    weights, residual, rank, _ = np.linalg.lstsq(basis.T, np.array([float(entry) for entry in flow]), rcond=None)
    assert rank == len(directions) and np.max(residual, initial=0.0) < 1e-24
    h = mpf(10) ** -15
    ahead, behind = (
        reference(scene, "forward_dynamics", {
            "q": [a + d * b for a, b in zip(inputs["q"], flow[: scene.nq], strict=True)],
            "v": [a + d * b for a, b in zip(inputs["v"], flow[scene.nq :], strict=True)],
            "u": inputs["u"],
        })["a"]
        for d in (h, -h)
    )  # fmt: skip
    jerk = [float((a - b) / (2 * h)) for a, b in zip(ahead, behind, strict=True)]
    np.testing.assert_allclose(weights @ np.array([[float(e) for e in row] for row in rows]), jerk, rtol=1e-12)


@scenes
@pytest.mark.parametrize("signs", [(1, 1, 1), (-1, 1, -1), (-1, -1, -1)])
def test_linearization_is_the_tangent_of_forward_dynamics(scene: Scene, signs: tuple[int, ...]) -> None:
    """M x'' + D x' + G x = B u against the Jacobian at the equilibrium, angles and rotations alike."""
    linear = reference(scene, "linearization", {"s": signs})
    M, G, B = (np.array([[float(e) for e in row] for row in linear[name]]) for name in "MGB")
    D = np.array([[float(e) for e in row] for row in linear["D"]]) if "D" in linear else np.zeros_like(M)
    rest = {"v": [0.0] * scene.nv, "u": [0.0] * scene.nu}
    carts = scene.nv - (1 if scene.is_planar else 3) * scene.links
    if scene.is_planar:
        with mp.workdps(120):
            phi = [mp.pi * (s < 0) for s in signs]
        theta = {"relative": np.diff([0, *phi]), "absolute": phi, "adjacent": [phi[0], phi[1] - phi[0], phi[2] - phi[1] + phi[0]]}
        found = reference(scene, "state_jacobian", {"q": [0.0] * carts + list(theta[str(scene.angles)]), **rest})
        slope = [np.array([[float(e) for e in row] for row in found[name]]) for name in ("dadq", "dadv", "dadu")]
    else:
        links = [entry for s in signs for entry in (0.0, 0.0, float(s))]
        found = reference(scene, "state_jacobian", {"q": [0.0] * carts + links, **rest})
        slope = _in_rotations(scene, [0.0] * carts + links, found)
    for matrix, part in zip((-G, -D, B), slope, strict=True):
        np.testing.assert_allclose(np.linalg.solve(M, matrix), part, atol=1e-13 * np.abs(matrix).max(initial=1) / 0.01)


def _in_rotations(scene: Scene, q: list[float], found: dict[str, Any]) -> list[Any]:
    """Return the tangent Jacobian at rest in the coordinates [x; C^T xi_k] of (19)."""
    carts, half = (2 if scene.has_cart else 0), 2 * scene.links + (2 if scene.has_cart else 0)
    keep = list(range(carts)) + [carts + 3 * k + axis for k in range(scene.links) for axis in range(2)]
    rows = np.array([[float(e) for e in row] for row in found["tangent"]])[:, keep]
    rates = np.array([[float(e) for e in dv] for _, dv in tangent_directions(scene, q, [0.0] * scene.nv)[half:]])[:, keep]
    dadu = np.array([[float(e) for e in row] for row in found["dadu"]]).reshape(scene.nv, scene.nu)[keep]
    # The rotation about axis b moves xi by b, as the rate direction (0, b) moves xi' by b.
    return [np.linalg.solve(rates, rows[:half]).T, np.linalg.solve(rates, rows[half:]).T, dadu]


def test_phi_is_the_projection_integral_of_the_paper() -> None:
    """(17) put into (15) and projected on cos(omega t) with an adaptive quadrature, N = 2, on a cart."""
    scene = Scene("a", 2, base="cart", mass=[1.0, 0.5], length=[0.4, 0.6], com=[0.3, 0.6], cart_mass=0.8, stiffness=0.7)
    amplitude, omega = [mpf(x) for x in (0.2, 0.9, -1.4)], mpf(3.25)

    def force(tau: Any) -> list[Any]:
        c, s = mp.cos(tau), mp.sin(tau)
        inputs = {
            "q": [x * c for x in amplitude],
            "v": [-x * omega * s for x in amplitude],
            "a": [-x * omega**2 * c for x in amplitude],
        }
        return [u * c for u in reference(scene, "inverse_dynamics", inputs, digits=25)["u"]]

    with mp.workdps(25):
        expected = [mp.quad(lambda t, k=k: force(t)[k], mp.linspace(0, 2 * mp.pi, 5)) / mp.pi for k in range(3)]
    found = reference(scene, "phi", {"amplitude": amplitude, "omega": omega})["phi"]
    assert relative_error(found, expected) < 1e-20


def test_phi_jacobian_is_the_difference_quotient_of_phi() -> None:
    scene = Scene("a", 2, mass=1.0, length=0.5)
    inputs: dict[str, Any] = {"amplitude": [0.9, -1.4], "omega": 3.25}
    found = reference(scene, "phi_jacobian", inputs)["dphi"]
    h = mpf(2) ** -60
    with mp.workdps(80):
        point = [mpf(0.9), mpf(-1.4), mpf(3.25)]
        for column in range(3):
            moved = [[x + (h * d if i == column else 0) for i, x in enumerate(point)] for d in (1, -1)]
            ahead, behind = (reference(scene, "phi", {"amplitude": at[:2], "omega": at[2]}, 80)["phi"] for at in moved)
            quotient = [(a - b) / (2 * h) for a, b in zip(ahead, behind, strict=True)]
            assert relative_error([row[column] for row in found], quotient) < 1e-30


@scenes
def test_step_is_of_order_four(scene: Scene) -> None:
    """The local error of one step of h against two of h/2 falls by 2^5."""
    inputs = {**state(scene), "h": 0.0}

    def gap(h: float) -> Any:
        whole = reference(scene, "step", {**inputs, "h": h})
        half = reference(scene, "step", {**inputs, "h": h / 2})
        twice = reference(scene, "step", {**inputs, "h": h / 2, "q": half["q_next"], "v": half["v_next"]})
        return max(abs(a - b) for a, b in zip(flat(whole.values()), flat(twice.values()), strict=True))

    assert float(mp.log(gap(1e-4) / gap(5e-5), 2)) == pytest.approx(5, abs=0.01)


def test_digits_are_those_asked_for() -> None:
    case = vectors()[-1]
    coarse, fine = (reference(case.scene, "forward_dynamics", case.inputs, digits)["a"] for digits in (20, 70))
    assert 1e-24 < relative_error(coarse, fine) < 1e-19


def test_runtime_parameters_are_read_from_params() -> None:
    numbers: dict[str, Any] = {"mass": [1.0, 2.0], "length": [0.5, 0.25], "com": [0.4, 0.25], "stiffness": [1.0, 3.0]}
    fixed = Scene("a", 2, **numbers, gravity=1.6, base="cart", cart_mass=3.0)
    runtime = Scene("a", 2, **dict.fromkeys(numbers, "runtime"), gravity="runtime", base="cart", cart_mass="runtime")
    inputs = state(fixed)
    params = {**{key: np.array(value) for key, value in numbers.items()}, "gravity": 1.6, "cart_mass": 3.0}
    found = reference(runtime, "forward_dynamics", inputs, params=params)
    assert found == reference(fixed, "forward_dynamics", inputs)
    with pytest.raises(SceneError, match="runtime parameter without a value"):
        reference(runtime, "forward_dynamics", inputs)


def test_single_precision_inputs_are_exact() -> None:
    scene = SCENES["planar"]
    single = {name: np.array([float(x) for x in values], dtype=np.float32) for name, values in state(scene).items()}
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
