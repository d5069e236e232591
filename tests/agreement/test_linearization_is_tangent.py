"""(19) against the exact tangent of the emitted forward dynamics, at every equilibrium of paper B's chain."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from phichain.pipeline import build
from phichain.scene.library import find_scene
from phichain.system import System

LINKS = 5


@pytest.fixture(scope="module")
def chain() -> System:
    return build(find_scene("paper_b"))


@pytest.mark.long
@pytest.mark.parametrize("signs", list(product((1.0, -1.0), repeat=LINKS)))
def test_linearisation_is_the_tangent_of_the_nonlinear_code(chain: System, signs: tuple[float, ...]) -> None:
    """With q_k = s_k e_3 + xi_k x s_k e_3, omega_k' = xi_k'': the xi-part of dadq and dadu is -M^-1 G and M^-1 B."""
    s = np.array(signs)
    inertia, gravity, force = chain.linearization(s)
    q, v, u = np.zeros(2 + 3 * LINKS), np.zeros(2 + 3 * LINKS), np.zeros(2)
    q[4::3] = s
    dadq, _, dadu = chain.state_jacobian(q, v, u)

    size = 2 + 2 * LINKS
    to_state, rows = np.zeros((q.size, size)), [0, 1]
    to_state[:2, :2] = np.eye(2)
    for k in range(LINKS):
        first, column = 2 + 3 * k, 2 + 2 * k
        to_state[first, column + 1], to_state[first + 1, column] = s[k], -s[k]
        rows += [first, first + 1]

    tangent = -np.linalg.solve(inertia, gravity)
    np.testing.assert_allclose((dadq @ to_state)[rows], tangent, atol=1e-12 * np.abs(tangent).max())
    driven = np.linalg.solve(inertia, force)
    np.testing.assert_allclose(dadu[rows], driven, atol=1e-12 * np.abs(driven).max())
