"""The reference's Jacobians, projections and steps against difference quotients, quadrature and orders."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf

from phichain.reference import reference, tangent_directions
from phichain.scene import Scene
from tests.mechanics.chains import configuration_rate, planar, scenes, spatial, state
from tests.reference_cases import flat, relative_error


@pytest.fixture(autouse=True)
def working_precision() -> Iterator[None]:
    """Do the arithmetic of these tests in 100 digits."""
    with mp.workdps(100):
        yield


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
    weights, residual, rank, _ = np.linalg.lstsq(
        basis.T, np.array([float(entry) for entry in flow]), rcond=None
    )
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
    np.testing.assert_allclose(
        weights @ np.array([[float(e) for e in row] for row in rows]), jerk, rtol=1e-12
    )


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
        theta = {
            "relative": np.diff([0, *phi]),
            "absolute": phi,
            "adjacent": [phi[0], phi[1] - phi[0], phi[2] - phi[1] + phi[0]],
        }
        found = reference(
            scene, "state_jacobian", {"q": [0.0] * carts + list(theta[str(scene.angles)]), **rest}
        )
        slope = [
            np.array([[float(e) for e in row] for row in found[name]]) for name in ("dadq", "dadv", "dadu")
        ]
    else:
        links = [entry for s in signs for entry in (0.0, 0.0, float(s))]
        found = reference(scene, "state_jacobian", {"q": [0.0] * carts + links, **rest})
        slope = _in_rotations(scene, [0.0] * carts + links, found)
    for matrix, part in zip((-G, -D, B), slope, strict=True):
        np.testing.assert_allclose(
            np.linalg.solve(M, matrix), part, atol=1e-13 * np.abs(matrix).max(initial=1) / 0.01
        )


def _in_rotations(scene: Scene, q: list[float], found: dict[str, Any]) -> list[Any]:
    """Return the tangent Jacobian at rest in the coordinates [x; C^T xi_k] of (19)."""
    carts, half = (2 if scene.has_cart else 0), 2 * scene.links + (2 if scene.has_cart else 0)
    keep = list(range(carts)) + [carts + 3 * k + axis for k in range(scene.links) for axis in range(2)]
    rows = np.array([[float(e) for e in row] for row in found["tangent"]])[:, keep]
    rates = np.array(
        [[float(e) for e in dv] for _, dv in tangent_directions(scene, q, [0.0] * scene.nv)[half:]]
    )[:, keep]
    dadu = np.array([[float(e) for e in row] for row in found["dadu"]]).reshape(scene.nv, scene.nu)[keep]
    # The rotation about axis b moves xi by b, as the rate direction (0, b) moves xi' by b.
    return [np.linalg.solve(rates, rows[:half]).T, np.linalg.solve(rates, rows[half:]).T, dadu]


def test_phi_is_the_projection_integral_of_the_paper() -> None:
    """(17) put into (15) and projected on cos(omega t) with an adaptive quadrature, N = 2, on a cart."""
    scene = Scene(
        "a", 2, base="cart", mass=[1.0, 0.5], length=[0.4, 0.6], com=[0.3, 0.6], cart_mass=0.8, stiffness=0.7
    )
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
        expected = [
            mp.quad(lambda t, k=k: force(t)[k], mp.linspace(0, 2 * mp.pi, 5)) / mp.pi for k in range(3)
        ]
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
            ahead, behind = (
                reference(scene, "phi", {"amplitude": at[:2], "omega": at[2]}, 80)["phi"] for at in moved
            )
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
