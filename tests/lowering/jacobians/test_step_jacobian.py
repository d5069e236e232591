"""A_d and B_d of one Runge-Kutta step: on a linear system they are the exponential's series, term by term."""

from __future__ import annotations

from math import factorial
from typing import Any

import numpy as np
import pytest

from phichain import build
from phichain.emit.selftest.cases import make_selftest
from phichain.ir.evaluate import evaluate
from phichain.lowering import lower
from phichain.lowering.lower import lower_function
from phichain.mechanics import derive
from phichain.reference import reference
from phichain.scene import Scene
from tests.lowering.chains import random_arguments

WANT = ["forward_dynamics", "state_jacobian", "mass_matrix", "step", "step_jacobian"]


@pytest.mark.long
@pytest.mark.parametrize("code", ["unrolled", "loops"])
@pytest.mark.parametrize(
    "chain",
    [{"links": 3, "actuated": "all", "damping": 0.1}, {"links": 2, "base": "cart", "cart_mass": 1.5, "stiffness": 2.0}],
    ids=["fixed", "cart"],
)
def test_at_an_equilibrium_it_is_the_exponential_to_order_four(chain: dict[str, Any], code: str) -> None:
    """A_d = sum_{k <= 4} (h F)^k / k!, B_d = sum_{k <= 3} h^{k+1} F^k G / (k+1)!, with x' = F x + G u there."""
    system = build(Scene("sampled", mass=0.4, length=0.5, com=0.3, want=WANT, code=code, **chain), prove=False)
    n, nu, h = system.nv, system.nu, 0.03
    rest = np.zeros(n), np.zeros(n), np.zeros(nu)
    dadq, dadv, dadu = system.state_jacobian(*rest)
    slope = np.block([[np.zeros((n, n)), np.eye(n)], [dadq, dadv]])
    push = np.vstack([np.zeros((n, nu)), dadu])
    powers = [np.linalg.matrix_power(h * slope, k) for k in range(5)]
    a = sum(power / factorial(k) for k, power in enumerate(powers))
    b = h * sum(power / factorial(k + 1) for k, power in enumerate(powers[:4])) @ push
    q_next, v_next, found_a, found_b = system.step_jacobian(h, *rest)
    assert np.max(np.abs(found_a - a)) < 1e-14 * np.max(np.abs(a))
    assert np.max(np.abs(found_b - b)) < 1e-14 * np.max(np.abs(b))
    assert not np.any(q_next) and not np.any(v_next)


def test_its_step_is_the_step_and_an_undamped_chain_keeps_volume() -> None:
    """In (q, p) the motion keeps volumes: det A_d det M(q_next) / det M(q) = 1 but for the step's error."""
    system = build(Scene("volume", 3, mass=0.4, length=0.5, com=0.3, want=WANT), prove=False)
    q, v = np.array([0.4, -1.1, 2.0]), np.array([1.0, 0.3, -0.7])
    lost = []
    for h in (0.02, 0.01):
        *ends, a = system.step_jacobian(h, q, v)
        assert all(np.max(np.abs(x - y)) < 1e-15 for x, y in zip(ends, system.step(h, q, v), strict=True))
        volumes = [np.linalg.det(system.mass_matrix(angles)) for angles in (q, ends[0])]
        lost.append(abs(np.linalg.det(a) * volumes[1] / volumes[0] - 1))
    assert lost[1] < 1e-4 and lost[0] > 20 * lost[1]


@pytest.fixture(scope="module", params=[{}, {"base": "cart", "cart_mass": 1.3}], ids=["fixed", "cart"])
def sphere(request: pytest.FixtureRequest) -> Any:
    chain = {"mass": [0.7, 0.4], "length": [0.5, 0.8], "com": [0.3, 0.5], **request.param}
    want = ["forward_dynamics", "step", "step_jacobian", "project", "propagate"]
    return build(Scene("sphere", 2, space="spatial", want=want, code="loops", variational=True, **chain), prove=False)


def away(system: Any) -> tuple[np.ndarray, np.ndarray, list[np.ndarray]]:
    """A state of unit vectors and tangent rates, and inputs."""
    source = np.random.default_rng(1)
    q, v = system.project(source.normal(size=system.nq), source.normal(size=system.nv))
    return q, v, [source.normal(size=system.nu)] if system.nu else []


@pytest.mark.long
def test_on_the_sphere_it_is_the_motions_own_derivative_to_order_four(sphere: Any) -> None:
    """Along tangents A_d is the transition matrix of the Taylor flow but for the step's error, one thirty-second at half the step."""
    (q, v, u), n = away(sphere), sphere.nv
    gaps, held = [], {"u": u[0]} if u else {}
    for h in (0.02, 0.01):
        q_next, v_next, a, *b = sphere.step_jacobian(h, q, v, *u)
        ends = sphere.step(h, q, v, *u)
        assert max(np.max(np.abs(q_next - ends[0])), np.max(np.abs(v_next - ends[1]))) < 1e-15
        tangent = consistent(sphere, q, v)
        flow = sphere.propagate(q, v, 0.0, h, 1e-15, transition=np.eye(2 * n), **held).transition
        gaps.append(np.max(np.abs((a - flow) @ tangent)))
        assert np.max(np.abs(a - a @ tangent)) < 1e-9  # what is no tangent moves nothing
        for matrix, i in ((part, i) for part in b for i in range(sphere.nu)):
            push = np.eye(sphere.nu)[i] * 1e-6
            ahead, behind = (np.concatenate(sphere.step(h, q, v, u[0] + way * push)) for way in (1, -1))
            np.testing.assert_allclose(matrix[:, i], (ahead - behind) / 2e-6, atol=1e-10)
    assert gaps[1] < 1e-6 and 24 < gaps[0] / gaps[1] < 40


def consistent(system: Any, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """D project(q, v) by differences."""
    size = len(q)
    columns = []
    for way in np.eye(2 * size) * 1e-6:
        ends = [np.concatenate(system.project(q + sign * way[:size], v + sign * way[size:])) for sign in (1, -1)]
        columns.append((ends[0] - ends[1]) / 2e-6)
    return np.array(columns).T


def test_on_the_sphere_it_is_what_fifty_digits_say() -> None:
    chain = Scene("one", 1, space="spatial", mass=0.7, length=0.5, damping=0.1, stiffness=0.4, want=["step_jacobian"])
    program = lower_function(derive(chain), "step_jacobian", "loops")
    arguments = random_arguments(chain, program, seed=3) | {"h": np.array(1e-4)}
    expected = reference(chain, "step_jacobian", arguments, 30, {})
    found = evaluate(program, arguments)
    assert np.max(np.abs(found["A"] - np.array(expected["A"], float))) < 1e-14


def test_the_self_test_of_a_spatial_chain_judges_it() -> None:
    """On a cart, where reference and sweep part off the spheres by h^3 of the ends: of B, which is of size h, more than of A."""
    scene = Scene(
        "judged", 1, space="spatial", base="cart", actuated="cart", mass="runtime", length="runtime", com="runtime", cart_mass="runtime", code="loops", want=["step_jacobian"],
    )  # fmt: skip
    found = make_selftest(scene, lower(derive(scene)))
    assert [case.function for case in found.cases] == ["step_jacobian"] * 3 and float(found.tolerances["step_jacobian"]) < 1e-12
