"""Brake orbits of spatial chains in a plane: a planar chain's, with the multipliers of the whole motion in space."""

from __future__ import annotations

import numpy as np
import pytest

from phichain.continuation import Branch
from phichain.errors import UnsupportedError
from phichain.orbits import pick, trace
from phichain.orbits.in_plane import METHOD, NEEDED, plane_problem
from phichain.pipeline import build
from phichain.scene import Scene
from phichain.system import System
from tests.orbits.shot import uniform


def chain(**more) -> System:
    own = {"mass": 0.5, "length": 0.5, "com": 0.25, "space": "spatial", "want": NEEDED, "variational": True}
    return build(Scene("swing2", 2, **{**own, **more}))


@pytest.fixture(scope="module")
def family() -> Branch:
    return trace(chain(), method=METHOD, until="theta_1=-1.6")


@pytest.mark.long
def test_the_orbits_are_those_of_the_planar_chain(family: Branch) -> None:
    """The same frequencies at the same angles, by another flow; the same events where the plane is kept."""
    flat = trace(uniform(2), until="theta_1=-1.6")
    assert family.points[-1] == pytest.approx([flat.points[-1, 0], flat.points[-1, :2].sum(), flat.points[-1, 2]], rel=1e-11)
    assert family.energy[-1] == pytest.approx(flat.energy[-1], rel=1e-12)
    for kind in ("odd loss", "unequal brakes", "energy extremum", "fold omega", "brake loss"):
        own, other = ([event.z[-1] for event in branch.located(kind)] for branch in (family, flat))
        assert own == pytest.approx(other, abs=1e-9)
    # The in-plane kappa of both, at a place of one that the other comes by.
    at = pick(uniform(2), flat, "omega=3.7")
    beside = pick(chain(), family, "omega=3.7")
    assert min(np.abs(beside.kappa - at.kappa[0])) < 1e-9


def test_multipliers_are_those_of_the_whole_monodromy(family: Branch) -> None:
    """Over a whole period in space: eight multipliers, of which four are 1 by the flow, the energy and turns about the vertical."""
    system, found = chain(), pick(chain(), family, "omega=3.8")
    q, tangent = found.q[0].reshape(2, 3), np.zeros((12, 8))
    for k, link in enumerate(q):
        here = slice(3 * k, 3 * k + 3)
        basis = np.stack([np.cross([0.0, 1.0, 0.0], link), [0.0, 1.0, 0.0]], axis=1)
        tangent[here, 2 * k : 2 * k + 2] = basis
        tangent[6 + 3 * k : 9 + 3 * k, 4 + 2 * k : 6 + 2 * k] = basis
    whole = system.propagate(found.q[0], found.v[0], 0.0, found.period, 1e-16, transition=tangent).transition
    spectrum = np.linalg.eigvals(np.linalg.lstsq(tangent, whole, rcond=None)[0])
    own = spectrum[np.argsort(np.abs(spectrum - 1))[4:]]
    assert len(found.multipliers) == 4 and found.closure < 1e-12
    for value in own:
        assert np.min(np.abs(found.multipliers - value)) < 1e-7


def test_the_plane_is_lost_where_a_motion_across_it_comes_back(family: Branch) -> None:
    """mu = +1 or -1 of motions out of the plane, and nowhere else does their stability change."""
    events = family.located("plane loss")
    assert events and all(event.breaks and len(event.state) == 12 for event in events)
    problem = plane_problem(chain(), omega=4.0)
    for event in events:
        across = problem.evaluate(event.z).extra.found.across
        assert np.min(np.abs(np.abs(across.real) - 1)) < 1e-8
    inside = np.abs(np.array([problem.evaluate(z).extra.found.across[0].real for z in family.points])) < 1
    changes = np.flatnonzero(inside[1:] != inside[:-1])
    assert set(changes) <= {event.index for event in events}


def test_springs_between_directions_have_their_own_law() -> None:
    """Small swings follow planar springs, k theta; large ones k sin(theta): the energy of the start says which."""
    branch = trace(chain(stiffness=0.6), method=METHOD, until="theta_1=1")
    theta = branch.points[-1, :2]
    height = 9.81 * (0.375 * (1 - np.cos(theta[0])) + 0.125 * (1 - np.cos(theta[1])))
    springs = 0.6 * (2 - np.cos(theta[0]) - np.cos(theta[1] - theta[0]))
    assert branch.energy[-1] == pytest.approx(height + springs, rel=1e-12)
    assert pick(chain(stiffness=0.6), branch).closure < 1e-12


@pytest.mark.long
def test_on_a_cart_they_are_those_of_a_planar_cart() -> None:
    """Frequencies and kappa in the plane by the planar flow; all multipliers among those of the whole monodromy in space, a drift of the cart's included."""
    cart = {"base": "cart", "cart_mass": 0.8}
    system, flat = chain(**cart), uniform(2, **cart)
    found, other = (trace(one, method=how, until="energy=0.4") for one, how in ((system, METHOD), (flat, "shooting")))
    assert found.points[-1, -1] == pytest.approx(other.points[-1, -1], rel=1e-12)
    assert np.min(np.abs(found.multipliers[-1] - other.multipliers[-1, 0])) < 1e-9
    orbit = pick(system, found)
    assert orbit.closure < 1e-12
    nq, tangent = system.nq, np.zeros((system.nx, 12))
    tangent[:2, :2] = tangent[nq : nq + 2, 6:8] = np.eye(2)
    for k, link in enumerate(orbit.q[0][2:].reshape(2, 3)):
        basis = np.stack([np.cross([0.0, 1.0, 0.0], link), [0.0, 1.0, 0.0]], axis=1)
        tangent[2 + 3 * k : 5 + 3 * k, 2 + 2 * k : 4 + 2 * k] = tangent[nq + 2 + 3 * k : nq + 5 + 3 * k, 8 + 2 * k : 10 + 2 * k] = basis
    whole = system.propagate(orbit.q[0], orbit.v[0], 0.0, orbit.period, 1e-16, transition=tangent).transition
    spectrum = np.linalg.eigvals(np.linalg.lstsq(tangent, whole, rcond=None)[0])
    assert len(orbit.multipliers) == 4 and all(np.min(np.abs(spectrum - value)) < 1e-7 for value in orbit.multipliers)


def test_what_is_refused() -> None:
    with pytest.raises(UnsupportedError, match="is for spatial chains"):
        trace(uniform(2), method=METHOD)
    with pytest.raises(UnsupportedError, match="flow that carries derivatives"):
        trace(chain(variational=False), method=METHOD)
