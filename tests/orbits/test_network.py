"""Networks: what opens at the events of a family, followed by the problem of the symmetries that are left, and how it hangs together."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from phichain.continuation import Branch
from phichain.errors import ArrayError, ConvergenceError, OutputError, UnsupportedError
from phichain.orbits import Network, trace
from phichain.orbits.closed.kinds import KINDS, state_of
from phichain.orbits.closed.symmetries import recognised
from phichain.system import rhs
from tests.orbits.shot import uniform

UNTIL = "theta_1=-1.6"


@pytest.fixture(scope="module")
def network() -> Network:
    return trace(uniform(2), until=UNTIL, switch=True, limits={"max_points": 130})


def opened(network: Network, kind: str) -> tuple[Branch, int]:
    """The branch that an event of the first one opens, and its number."""
    first = network.branches[0]
    (to,) = {link.to for link in network.links if link.branch == 0 and link.how == "opens" and first.events[link.event].kind == kind}
    return network.branches[to], to


def closes(closing: str, z: np.ndarray) -> float:
    """How far the orbit is from closed after its period, by another integrator, in its size."""
    q, v = state_of(closing, z)
    start = np.concatenate([q, v])
    end = solve_ivp(rhs(uniform(2)), (0, 2 * np.pi / z[-1]), start, method="DOP853", rtol=1e-13, atol=1e-14).y[:, -1]
    return float(np.max(np.abs(end - start)) / np.max(np.abs(start)))


def test_both_points_with_mu_minus_one_are_switched_at(network: Network) -> None:
    """N = 2: what they open is traced, breaks what the event says, closes, and comes to the fourfold cover of mode 2."""
    ends = []
    for event, closing in (("odd loss", "odd"), ("unequal brakes", "unequal")):
        branch, to = opened(network, event)
        assert branch.closing == closing and len(branch) > 20
        assert np.max(branch.residual) < 1e-13
        for z in branch.points[3:-2:20]:
            assert closes(closing, z) < 2e-10
            assert recognised(uniform(2), None, *state_of(closing, z), float(z[-1])) == (closing, 1)
        assert "mirror image" in branch.reason and branch.events[-1].kind == "cover 4 of mode 2"
        (link,) = network.beyond(to, len(branch.events) - 1)
        assert link.how == "joins" and network.branches[link.to].closing == "quarter"
        ends.append(branch.events[-1].z[-1])
    # Two branches of the fourfold cover, a resonance 1 : 4.
    assert ends[0] == pytest.approx(ends[1], abs=1e-10)


def test_the_fourfold_cover_is_where_mode_two_has_a_fourth_root_of_one(network: Network) -> None:
    """mu^8 = 1 over half its own period: kappa = cos(2 pi k / 8)."""
    event = opened(network, "odd loss")[0].events[-1]
    family = trace(uniform(2), 2, until=("omega", 4 * event.z[-1]))
    assert abs(family.multipliers[-1, 0]) == pytest.approx(np.sqrt(0.5), abs=1e-8)


def test_orbits_of_every_branch_close(network: Network) -> None:
    """By residuals over a half or quarter period, to 1e-13 of their terms; and by another integrator where they are not very unstable."""
    for branch in network.branches:
        assert np.max(branch.residual[:-1]) < 1e-13
        if branch.closing in ("half", "whole"):
            known = np.max(np.abs(branch.multipliers), axis=1) < 1e3
            assert np.max(np.abs(branch.column("unfolding")[known])) < 1e-11
        mild = np.flatnonzero(np.max(np.abs(branch.multipliers), axis=1) < 10)
        for k in mild[5 : -3 : max(1, len(mild) // 2)]:
            assert closes(branch.closing, branch.points[k]) < 1e-9


def test_what_opens_at_a_cover_is_the_family_it_covers(network: Network) -> None:
    first = network.branches[0]
    (number,) = [k for k, event in enumerate(first.events) if event.kind == "cover 3 of mode 2"]
    links = network.beyond(0, number)
    assert [link.how for link in links] == ["runs through", "runs through"]
    ends = {network.branches[link.to].events[-1].kind for link in links}
    assert "back at rest" in ends
    for link in links:
        z = network.branches[link.to].points[0]
        assert z == pytest.approx(first.events[number].z * [1, 1, 3], abs=1e-9) or z == pytest.approx(
            first.events[number].z * [-1, -1, 3], abs=1e-9
        )
    (loss,) = [k for k, e in enumerate(first.events) if e.kind == "brake loss" and np.allclose(e.z, first.events[number].z)]
    (link,) = network.beyond(0, loss)
    assert link.how == "left" and "covers" in link.said


def test_beyond_the_loss_of_the_brake_nothing_rests(network: Network) -> None:
    branch, _ = opened(network, "brake loss")
    assert branch.closing == "half"
    event = next(e for e in network.branches[0].events if e.kind == "brake loss" and e.z[0] < -1)
    # A pitchfork: omega leaves with the square of the distance.
    away = np.abs(branch.column("omega")[:3] - event.z[-1]) / branch.arclength[1:4] ** 0
    assert np.all(away < 0.05) and recognised(uniform(2), None, *state_of("half", branch.points[6]), branch.points[6, -1])[0] == "half"


def test_every_event_says_what_goes_on_beyond(network: Network) -> None:
    for branch in network.branches:
        for event in branch.events:
            if event.kind in KINDS[branch.closing].opens:
                assert event.breaks and event.continues
    text = str(network)
    assert "opens [1]" in text and "runs through" in text and "generation 2" in text and network.status == "limits"


def same(a: Network, b: Network) -> None:
    assert a.links == b.links and (a.status, a.reason, a.name, a.digest) == (b.status, b.reason, b.name, b.digest)
    for one, other in zip(a.branches, b.branches, strict=True):
        assert np.array_equal(one.points, other.points) and np.array_equal(one.tangent, other.tangent)
        assert (one.reason, one.closing, one.name, one.step) == (other.reason, other.closing, other.name, other.step)
        assert [event.kind for event in one.events] == [event.kind for event in other.events]


def test_networks_on_file(network: Network, tmp_path: Path) -> None:
    path = network.to_json(tmp_path / "network.json")
    same(Network.from_json(path), network)
    # Gone on with, it is what it was: what was left for the limits is looked at again, once.
    same(trace(uniform(2), until=UNTIL, switch=True, resume=path, limits={"max_points": 130}), network)
    found = json.loads(path.read_text())
    assert found["kind"] == "network" and found["branches"][1]["closing"] == "odd"
    start = found["branches"][1]["points"][0]["start"]
    assert start["q"] == [0.0, 0.0] and start["v"] == network.branches[1].points[0, :-1].tolist()
    moving = next(row for row in found["branches"] if row["closing"] == "half")
    assert len(moving["points"][0]["start"]["v"]) == 2 and abs(moving["points"][0]["unfolding"]) < 1e-11
    text = path.read_text()
    for broken in (text[:900], '{"kind": "branch"}', text.replace('"to": 1', '"to": 99'), text.replace('"opens"', '"eats"')):
        path.write_text(broken)
        with pytest.raises(OutputError, match="no network can be read there"):
            Network.from_json(path)


@pytest.mark.parametrize("patience", [11, 33])
def test_a_network_goes_on_as_if_it_had_not_been_interrupted(patience: int, tmp_path: Path) -> None:
    """By Ctrl-C on the first branch and on another; to the same network, bit by bit."""
    options = {"until": "theta_1=1.1", "switch": True, "limits": {"max_points": 25}}
    left = patience

    def impatient(point, step) -> None:
        nonlocal left
        left -= 1
        if left == 0:
            raise KeyboardInterrupt

    first = trace(uniform(2), **options, progress=impatient)
    whole = trace(uniform(2), **options)
    assert first.status == "interrupted" and len(first) <= len(whole) == 2
    path = first.to_json(tmp_path / "network.json")
    same(trace(uniform(2), **options, resume=path), whole)


def test_a_branch_becomes_a_network() -> None:
    first = trace(uniform(2), until="theta_1=1.1")
    again = trace(uniform(2), until="theta_1=1.1", switch=True, resume=first, limits={"max_points": 8})
    assert len(again) == 2 and again.branches[1].closing == "odd" and np.array_equal(again.branches[0].points, first.points)


def test_a_saved_orbit_starts_its_family_again(network: Network, tmp_path: Path) -> None:
    """From points of four kinds of branches, back through their files, under the kind they had and with the same orbit."""
    for closing in ("quarter", "odd", "unequal", "half"):
        branch = next(b for b in network.branches if b.closing == closing)
        path = branch.to_json(tmp_path / f"{closing}.json")
        found = trace(uniform(2), start=f"{path}:11", limits={"max_points": 4})
        assert found.closing == closing and found.mode == 0
        z = branch.points[10]
        assert found.points[0, -1] == pytest.approx(z[-1], abs=1e-12)
        assert np.abs(found.points[0, :-1]) == pytest.approx(np.abs(z[:-1]), abs=1e-10)
        assert found.energy[1] > found.energy[0]


def test_a_rough_orbit_is_closed_first() -> None:
    exact = trace(uniform(2), until="theta_1=1.0").points[-1]
    for start in (
        {"q": exact[:2] + [0.01, -0.01], "v": [0, 0], "period": 2 * np.pi / exact[2] + 0.004},
        f"q={exact[0] - 0.005},{exact[1]}; period={2 * np.pi / exact[2]}",
    ):
        branch = trace(uniform(2), start=start, until="theta_1=1.1")
        assert branch.closing == "quarter" and branch.points[0] == pytest.approx(exact, abs=0.05)
        assert branch.residual[0] < 1e-14 and branch.points[-1, 0] == 1.1
    # From the middle of its motion, where it neither rests nor hangs straight.
    half = uniform(2).propagate(exact[:2], np.zeros(2), 0.0, 0.3, 1e-16)
    branch = trace(uniform(2), start={"q": half.q, "v": half.v, "omega": exact[2]}, limits={"max_points": 3})
    assert np.abs(branch.points[0]) == pytest.approx(np.abs(exact), abs=1e-9)


def test_a_family_from_an_orbit_goes_on(network: Network, tmp_path: Path) -> None:
    branch = next(b for b in network.branches if b.closing == "odd")
    whole = trace(uniform(2), start=(branch, 10), limits={"max_points": 12})
    first = trace(uniform(2), start=(branch, 10), limits={"max_points": 7})
    again = trace(uniform(2), resume=first.to_json(tmp_path / "a.json"), limits={"max_points": 6})
    assert np.array_equal(again.points, whole.points)


@pytest.mark.parametrize(
    ("start", "error", "words"),
    [
        ({"q": [1.0, 0.21], "period": 0.9}, ConvergenceError, "relative residual .* linear mode"),
        ({"q": [0, 0], "period": 1}, ArrayError, "hangs still"),
        ({"q": [1, 2, 3], "period": 1}, ArrayError, "start.q: must hold 2"),
        ({"q": [1, 2]}, ArrayError, "needs q and a period"),
        ({"q": [1, 2], "period": -1}, ArrayError, "start.period: must be positive"),
        ("nothing.json", OutputError, "no branch can be read there"),
        (3, ArrayError, "is no orbit"),
    ],
)
def test_starts_that_are_none_are_one_typed_error(start, error, words) -> None:
    with pytest.raises(error, match=words) as caught:
        trace(uniform(2), start=start)
    assert "\n" not in str(caught.value)


def test_what_does_not_switch_is_refused(network: Network) -> None:
    with pytest.raises(UnsupportedError, match="those of shooting"):
        trace(uniform(2), method="one harmonic", switch=True)
    with pytest.raises(UnsupportedError, match="lacks derivatives"):
        trace(uniform(2, variational=False), switch=True)
    with pytest.raises(ArrayError, match="generations"):
        trace(uniform(2), switch=True, generations=0)
    with pytest.raises(ArrayError, match="is a network"):
        trace(uniform(2), resume=network)
    with pytest.raises(ArrayError, match="do not start at a rest.*theta_1"):
        trace(uniform(2), start=(network.branches[1], 5), until="theta_1=1")
    with pytest.raises(ArrayError, match="no point of that branch"):
        trace(uniform(2), start=(network.branches[1], 5000))
    with pytest.raises(ArrayError, match="digest"):
        trace(uniform(1), start=network.branches[1])


def test_a_family_goes_on_where_its_phase_is_lost() -> None:
    """Mode 2 of two links, beyond its brake loss: where the least potential is one no longer the same family is taken up at another."""
    network = trace(uniform(2), 2, until="omega=5.3", switch=True, limits={"max_points": 90})
    first, second = network.branches[1:]
    assert first.closing == second.closing == "half" and first.events[-1].kind == "phase loss"
    assert [link.how for link in network.beyond(1, len(first.events) - 1)] == ["goes on"]
    # Nothing turns there but the place of the start: frequency, energy and kappa go on as they went.
    assert not [event for event in first.events[:-1] if abs(event.arclength - first.events[-1].arclength) < 1e-3]
    before = np.array([np.diff(first.points[-6:-2, -1])[-1], np.diff(first.energy[-6:-2])[-1]])
    after = np.array([second.points[2, -1] - second.points[0, -1], second.energy[2] - second.energy[0]])
    assert np.all(before * after > 0)
    # It is the last orbit before that place, closed elsewhere.
    assert second.points[0, -1] == pytest.approx(first.points[-2, -1], rel=1e-13)
    assert abs(second.multipliers[0, 0]) == pytest.approx(abs(first.multipliers[-2, 0]), rel=1e-9)


@pytest.mark.long
def test_a_chain_on_a_cart_switches_alike() -> None:
    """Beyond the loss of its brake the orbit comes back with the cart, by another integrator, and without momentum."""
    system = uniform(2, base="cart", cart_mass=0.4)
    network = trace(system, 2, until="amplitude=1.5", switch=True, limits={"max_points": 40})
    branch = network.branches[1]
    assert branch.closing == "half" and "symmetry loss" in [event.kind for event in branch.events]
    for z in branch.points[2::12]:
        q, v = state_of("half", z)
        end = solve_ivp(rhs(system), (0, 2 * np.pi / z[-1]), np.append(q, v), method="DOP853", rtol=1e-13, atol=1e-14).y[:, -1]
        assert end == pytest.approx(np.append(q, v), abs=1e-8)
        assert abs(system.mass_matrix(q)[0] @ v) < 1e-12


def test_two_period_doublings_are_the_ends_of_one_branch(network: Network) -> None:
    """Of the brake orbits between unequal rests: it ends at an orbit over twice, where it would run back through its image, and is a loop."""
    unequal = next(branch for branch in network.branches if branch.closing == "unequal")
    again = trace(uniform(2), start=(unequal, 2), until="omega=3.8", switch=True, limits={"max_points": 60})
    first, doubled = again.branches
    events = [k for k, event in enumerate(first.events) if event.kind == "period doubling"]
    assert [first.events[k].z[-1] for k in events] == pytest.approx([3.410370639, 3.710679544], abs=1e-8)
    assert [[link.how for link in again.beyond(0, k)] for k in events] == [["opens"], ["arrives"]]
    assert doubled.closing == "unequal" and "cover 2 of an orbit" in doubled.reason
    assert doubled.points[-1, -1] == pytest.approx(first.events[events[1]].z[-1] / 2, rel=1e-9)
    assert closes("unequal", doubled.points[len(doubled) // 2]) < 1e-9
