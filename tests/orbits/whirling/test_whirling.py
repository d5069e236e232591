"""Orbits that come back turned: the spherical pendulum in closed form, two links by another integrator, and where families begin and end."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ellipk

from phichain.continuation import Branch
from phichain.errors import ArrayError, UnsupportedError
from phichain.orbits import Orbit, pick, trace
from phichain.orbits.conical import conical_problem
from phichain.orbits.whirling import NEEDED, whirling_problem, whirls_of
from phichain.orbits.whirling.fixed import turned
from phichain.pipeline import build
from phichain.scene import Scene
from phichain.system import System
from phichain.system.state import rhs
from tests.orbits.shot import uniform
from tests.orbits.whirling.spherical import period_and_turn

MASS, LENGTH = 0.5, 0.5


@lru_cache
def chain(links: int) -> System:
    com = {1: LENGTH, 2: 0.25}[links]
    # The name of two links is that of tests of orbits in a plane, which have the same chain.
    return build(Scene(f"swing{links}", links, mass=MASS, length=LENGTH, com=com, space="spatial", want=NEEDED, variational=True))


@lru_cache
def cone(links: int) -> Branch:
    return trace(chain(links), method="conical", until="theta_1=0.8")


@lru_cache
def swings() -> Branch:
    return trace(chain(2), method="in a plane", until="theta_1=0.9")


@lru_cache
def double(hold: str = "momentum", until: str = "theta_1=0.5") -> Branch:
    return trace(chain(2), method="whirling", start=cone(2), hold=hold, until=until)


@pytest.mark.parametrize(("hold", "until"), [("momentum", "theta_1=0.35"), ("turn", "energy=3"), ("energy", None)])
def test_one_link_is_the_spherical_pendulum(hold: str, until: str | None) -> None:
    """Frequency and turn of every orbit by elliptic integrals of its energy and momentum, whatever is held; and what is held stays."""
    found = trace(chain(1), method="whirling", start=cone(1), hold=hold, until=until)
    held = {"momentum": found.momentum, "energy": found.energy, "turn": found.column("turn")}[hold]
    assert np.ptp(held) < 1e-13 * abs(held[0])
    own = zip(found.points[:-1], found.energy[:-1], found.momentum[:-1], strict=True)
    for z, energy, momentum in own:
        period, turn = period_and_turn(energy, momentum, MASS, LENGTH)
        assert z[-1] == pytest.approx(2 * np.pi / period, rel=1e-13)
        assert np.angle(np.exp(1j * (turn - z[-2]))) == pytest.approx(0, abs=2e-11)
    if until is None:
        assert found.reason == "ended in a plane" and found.points[-1, -2] == pytest.approx(np.pi, abs=1e-12)
        # The planar pendulum swings twice in one of its periods.
        amplitude = np.arccos(1 - found.energy[-1] / (MASS * 9.81 * LENGTH))
        assert found.points[-1, -1] == pytest.approx(np.pi * np.sqrt(9.81 / LENGTH) / ellipk(np.sin(amplitude / 2) ** 2), rel=1e-12)
    else:
        assert found.status == "event" and np.max(found.error) < 1e-11


def test_from_a_plane_to_the_conical_pendulum() -> None:
    """Of one energy: from orbits in a plane to the conical one, which has the most momentum; cos theta = g / (l Omega^2) there."""
    begun = trace(chain(1), method="in a plane", until="theta_1=1")
    found = trace(chain(1), method="whirling", start=begun, hold="energy")
    assert found.reason == "ended back at a conical orbit" and abs(found.momentum[-1]) == np.max(np.abs(found.momentum))
    theta, rate, turn, omega = found.points[-1]
    spin = abs(rate / np.sin(theta))
    assert np.cos(theta) == pytest.approx(9.81 / (LENGTH * spin**2), rel=1e-7)
    assert omega**2 == pytest.approx(spin**2 * (1 + 3 * np.cos(theta) ** 2), rel=1e-7)
    # It turns the other way: by -2 pi spin / omega, which is 2 pi more.
    assert rate < 0 and turn == pytest.approx(2 * np.pi - 2 * np.pi * spin / omega, rel=1e-7)


def test_families_begin_with_the_exponents_of_the_conical_orbit() -> None:
    """|s| of both, found apart; and as many as a chain of two links has: three, its momentum held."""
    begun = whirls_of(chain(2), cone(2))
    z = cone(2).points[-1]
    squares = conical_problem(chain(2), omega=4.0).evaluate(z).extra.found.squares
    assert [whirl.z[-1] for whirl in begun] == pytest.approx(np.sort(np.sqrt(-squares.real)), rel=1e-9)
    for number, whirl in enumerate(begun, 1):
        first = trace(chain(2), number, method="whirling", start=cone(2), limits={"max_points": 2}).points[0]
        assert first[-2:] == pytest.approx(whirl.z[-2:], rel=2e-3)


@pytest.mark.parametrize("hold", ["momentum", "turn"])
def test_two_links_come_back_turned_by_another_integrator(hold: str) -> None:
    found, field = double(hold), rhs(chain(2))
    for k in (len(found) // 2, -1):
        z, x = found.points[k], found.states[k]
        own = solve_ivp(field, (0, 2 * np.pi / z[-1]), x, "DOP853", rtol=1e-13, atol=1e-13).y[:, -1]
        assert turned(own, -z[-2]) == pytest.approx(x, abs=2e-11 * np.max(np.abs(x)))
    assert np.max(found.residual) < 1e-13 and np.max(np.abs(np.diff(found.momentum if hold == "momentum" else found.column("turn")))) < 1e-13


def test_multipliers_are_those_of_the_whole_monodromy() -> None:
    """Over a whole period, turned back: four of eight multipliers are 1, the others pair as kappa says."""
    found = pick(chain(2), double(), "theta_1=0.6")
    q, tangent = found.q[0].reshape(2, 3), np.zeros((12, 8))
    spins = found.v[0].reshape(2, 3)
    for k, link in enumerate(q):
        here, there = slice(3 * k, 3 * k + 3), slice(6 + 3 * k, 9 + 3 * k)
        basis = np.stack([np.cross([0.0, 1.0, 0.0], link), [0.0, 1.0, 0.0]], axis=1)
        tangent[here, 2 * k : 2 * k + 2] = tangent[there, 4 + 2 * k : 6 + 2 * k] = basis
        tangent[there, 2 * k : 2 * k + 2] = -np.outer(link, spins[k] @ basis)
    whole = chain(2).propagate(found.q[0], found.v[0], 0.0, found.period, 1e-16, transition=tangent).transition
    spectrum = np.linalg.eigvals(np.linalg.lstsq(tangent, turned(np.asarray(whole), -found.turn), rcond=None)[0])
    own = spectrum[np.argsort(np.abs(spectrum - 1))[4:]]
    assert len(found.multipliers) == 4 and found.closure < 1e-12
    for value in own:
        assert np.min(np.abs(found.multipliers - value)) < 1e-6


def test_events_do_not_depend_on_the_steps() -> None:
    coarse = double(until="theta_1=0.45")
    fine = trace(chain(2), method="whirling", start=cone(2), until="theta_1=0.45", limits={"step_max": 0.03})
    assert [event.kind for event in coarse.events] == [event.kind for event in fine.events]
    assert {"period doubling", "krein"} <= {event.kind for event in coarse.events}
    for one, two in zip(coarse.events, fine.events, strict=True):
        assert one.z == pytest.approx(two.z, abs=1e-8)


def test_orbits_that_lose_their_plane_begin_to_whirl() -> None:
    """Where a plane is lost, at no momentum: the family leaves it at the frequency of the orbit, and closes."""
    event = swings().located("plane loss")[0]
    found = trace(chain(2), method="whirling", start=(swings(), event), limits={"max_points": 12})
    assert np.max(np.abs(found.momentum)) < 1e-12 and found.points[0, -1] == pytest.approx(event.z[-1], rel=1e-3)
    # Out of any plane: the first link's rate across the plane of the start is no rounding, and grows.
    assert np.all(np.diff(np.abs(found.column("rate_1"))) > 0) and abs(found.points[-1, 2]) > 0.2
    orbit = pick(chain(2), found)
    assert orbit.closure < 1e-12 and abs(orbit.turn) < 1.0


def test_a_family_is_gone_on_with_bit_by_bit(tmp_path) -> None:
    whole = double()
    begun = trace(chain(2), method="whirling", start=cone(2), until="theta_1=0.5", limits={"max_points": 5})
    begun.to_json(tmp_path / "w.json")
    on = trace(chain(2), method="whirling", resume=tmp_path / "w.json", until="theta_1=0.5")
    assert np.array_equal(on.points, whole.points) and str(on).splitlines()[1:] == str(whole).splitlines()[1:]
    orbit = pick(chain(2), on, "energy=4")
    again = Orbit.from_json(orbit.to_json(tmp_path / "o.json"))
    assert again.turn == orbit.turn == Orbit.from_npz(orbit.to_npz(tmp_path / "o.npz")).turn and "turned by" in str(orbit)


def test_the_jacobian_is_that_of_the_residual() -> None:
    """Off any orbit, by differences, whatever is held."""
    z = np.array([0.7, 0.9, 2.0, 5.0, 0.8, 6.0])
    for held in ("momentum", "energy", "turn"):
        problem = whirling_problem(chain(2), held=held, value=0.3, omega=4.0)
        own = problem.evaluate(z).jacobian
        steps = 1e-6 * np.eye(6)
        rough = np.array([(problem.evaluate(z + h).residual - problem.evaluate(z - h).residual) / 2e-6 for h in steps]).T
        assert own == pytest.approx(rough, abs=1e-6)


def test_what_is_refused() -> None:
    with pytest.raises(UnsupportedError, match="spatial chains on a fixed base"):
        trace(uniform(2), method="whirling", start=cone(2))
    with pytest.raises(ArrayError, match="nothing that whirling families begin at"):
        trace(chain(2), method="whirling")
    with pytest.raises(ArrayError, match="digest of that branch's scene"):
        trace(chain(2), method="whirling", start=cone(1))
    with pytest.raises(ArrayError, match="can be held"):
        trace(chain(1), method="whirling", start=cone(1), hold="height")
    with pytest.raises(ArrayError, match="is for whirling families"):
        trace(chain(1), method="conical", hold="energy")
    with pytest.raises(ArrayError, match="1 .. 3"):
        trace(chain(2), 4, method="whirling", start=cone(2))
    with pytest.raises(ArrayError, match="begin at"):
        whirls_of(chain(2), (cone(2), "event"))
