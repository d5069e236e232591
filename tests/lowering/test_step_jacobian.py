"""A_d and B_d of one Runge-Kutta step: on a linear system they are the exponential's series, term by term."""

from __future__ import annotations

from math import factorial
from typing import Any

import numpy as np
import pytest

from phichain import build
from phichain.errors import UnsupportedError
from phichain.scene import Scene

WANT = ["forward_dynamics", "state_jacobian", "mass_matrix", "step", "step_jacobian"]


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


def test_a_spatial_chain_has_none_and_is_told_what_to_use() -> None:
    with pytest.raises(UnsupportedError, match=r"unit vectors have derivatives along tangents only.*propagate"):
        Scene("sphere", 2, space="spatial", mass=1.0, length=1.0, want=["step_jacobian"])
