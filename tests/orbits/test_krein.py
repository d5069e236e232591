"""Krein's signatures: of Hamiltonians that are known, and collisions so close to each other that no step parts them."""

from __future__ import annotations

import numpy as np
import pytest

from phichain.orbits import linear_modes, quarter_problem, trace
from phichain.orbits.krein import signs, signs_of_symplectic
from phichain.orbits.periodic import half_problem
from tests.orbits.shot import uniform


def test_signs_of_oscillators_are_those_of_their_energies() -> None:
    """H = sum e_k w_k (p^2 + q^2) / 2: at a quarter of a period each turns by e_k w_k t, the way its energy says."""
    turns, ways = np.array([0.3, 0.5, 1.1]), np.array([1, -1, 1])
    c, s = np.diag(np.cos(turns)), np.diag(np.sin(turns) * ways)
    assert signs(c, -s, c) == tuple((-ways[::-1]).tolist())
    whole = np.block([[c, s], [-s, c]])
    found = signs_of_symplectic(whole)
    assert found is not None and found in (tuple(ways.tolist()), tuple((-ways).tolist()))
    mixed = np.kron(np.eye(2), np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0])
    assert signs_of_symplectic(mixed @ whole @ mixed.T) == found


def test_off_the_axis_there_are_no_signs() -> None:
    turn = np.array([[0.9, -0.3], [0.3, 0.9]])
    assert signs(np.eye(2), np.eye(2), 0.5 * turn) is None


def test_both_forms_agree_along_a_family_on_who_passes_whom() -> None:
    """N = 4: relative signs from quarter blocks and from the half map, whichever of both signs a form calls positive."""
    system = uniform(4)
    branch = trace(system, 2, until="amplitude=0.3", limits={"max_points": 30})
    modes = linear_modes(system)
    quarter = quarter_problem(system, omega=modes.omega[1], shape=modes.shapes[:, 1])
    for z in branch.points[4::6]:
        blocks = quarter.evaluate(z).extra.found
        end = system.propagate(z[:-1], np.zeros(4), 0.0, np.pi / (2 * z[-1]), 1e-16)
        half = half_problem(system, omega=z[-1]).evaluate(np.concatenate([end.q, end.v, [0.0, z[-1]]]))
        one, other = signs(blocks.a, blocks.c, blocks.d), signs_of_symplectic(half.extra.found.symplectic)
        assert one is not None and other is not None and len(one) == 3
        # Re mu = kappa, whose sine has the sign of Im mu on the half that is looked at.
        assert other in (one, tuple(-sign for sign in one))


@pytest.mark.parametrize("step_max", [0.1, 0.03])
def test_collisions_come_in_pairs_whatever_the_step(step_max: float) -> None:
    """Kappa is real beyond the second as before the first, complex between: at each two of them are one."""
    branch = trace(uniform(4), 2, until="amplitude=0.65", limits={"step_max": step_max})
    found = branch.located("krein")
    assert len(found) % 2 == 0
    for event in found:
        apart = np.abs(event.multipliers[:, None] - event.multipliers[None, :]) + np.eye(3)
        assert np.min(apart) < 1e-4
