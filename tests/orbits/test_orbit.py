"""Single orbits of families: refined, with the multipliers of the whole monodromy, on file and as they are refused."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from phichain.continuation import Branch, Engine, follow, start_on
from phichain.errors import ArrayError, OutputError, UnsupportedError
from phichain.orbits import Orbit, pick, trace
from phichain.orbits.closed.kinds import problem_of
from phichain.pipeline import build
from phichain.scene import Scene
from phichain.system.state import rhs
from tests import tables
from tests.orbits.shot import uniform

CYCLES = json.loads((Path(__file__).parents[1] / "data" / "limit_cycles.json").read_text())["points"]
DOUBLE = [cycle for cycle in CYCLES if cycle["N"] == 2 and cycle["mode"] == 1]


@pytest.fixture(scope="module")
def family() -> Branch:
    return trace(uniform(2), until="theta_1=-2.5")


def complexes(pairs) -> np.ndarray:
    return np.array([complex(float(a), float(b)) for a, b in pairs])


@pytest.mark.parametrize("cycle", DOUBLE, ids=lambda c: c["theta0"][0])
def test_an_orbit_is_that_of_the_reference(family: Branch, cycle) -> None:
    """Period, energy and multipliers of orbits in quadruple precision, from the family's nearest points."""
    theta = np.array(cycle["theta0"], float)
    near = int(np.argmin(np.linalg.norm(family.points[:, :-1] - theta, axis=1))) + 1
    beside = replace(family, points=family.points[near - 2 :], arclength=family.arclength[near - 2 :], tangent=family.tangent[near - 2 :])
    found = pick(uniform(2), beside, f"theta_1={cycle['theta0'][0]}")
    assert found.q[0] == pytest.approx(theta, abs=1e-12)
    assert found.period == pytest.approx(float(cycle["period"]), rel=1e-12) and found.energy == pytest.approx(float(cycle["energy"]), rel=1e-12)
    wanted = complexes(cycle["floquet"])
    for value in wanted:
        assert np.min(np.abs(found.multipliers - value)) < 1e-8 * max(1.0, abs(value))
    assert found.is_stable == (cycle["linear_stability"] == "stable")
    assert found.closure < 1e-10 and found.error < 1e-11


def test_multipliers_are_those_of_the_whole_monodromy(family: Branch) -> None:
    system, found = uniform(2), pick(uniform(2), family, "theta_1=0.9")
    whole = system.propagate(found.q[0], found.v[0], 0.0, found.period, 1e-16, transition=np.eye(4)).transition
    spectrum = np.linalg.eigvals(whole)
    own = spectrum[np.argsort(np.abs(spectrum - 1))[2:]]
    for value in found.multipliers:
        assert np.min(np.abs(own - value)) < 1e-6


def test_every_kind_of_orbits_has_the_same_multipliers(family: Branch) -> None:
    """A brake orbit closed as one between two rests, and as one that is odd about its passage through the straight chain."""
    system, brake = uniform(2), pick(uniform(2), family, "theta_1=0.9", samples=5)
    for kind, z in (("unequal", np.append(brake.q[0], brake.omega)), ("odd", np.append(brake.v[1], brake.omega))):
        problem = problem_of(system, None, kind, z)
        start = start_on(problem, z, np.append(np.sign(z[:-1]), 0.0), Engine())
        some = follow(problem, start, replace(Engine(), options=replace(Engine().options, max_points=3)))
        found = pick(system, replace(some, closing=kind, method="shooting", digest=system.digest), "point=1")
        assert sorted(found.multipliers.imag) == pytest.approx(sorted(brake.multipliers.imag), rel=1e-6) and found.method == kind
        assert np.any(found.v[0]) == (kind == "odd") and found.closure < 1e-12
        with pytest.raises(ArrayError, match="use omega"):
            pick(system, replace(some, closing=kind, method="shooting", digest=system.digest), "amplitude=1")


@pytest.mark.parametrize(
    ("at", "what", "value"),
    [("amplitude=2", "amplitude", 2.0), ("energy=1.5", "energy", 1.5), ("omega=3.5", "omega", 3.5), ("theta_2=0.2", "theta_2", 0.2)],
)
def test_what_is_asked_for_is_met(family: Branch, at: str, what: str, value: float) -> None:
    found = pick(uniform(2), family, at)
    own = {"amplitude": np.abs(found.q[0]).max(), "energy": found.energy, "omega": found.omega, "theta_2": found.q[0, 1]}
    assert own[what] == pytest.approx(value, rel=1e-14 if what == "energy" else 0, abs=0)
    assert found.closure < 1e-13


def test_points_and_events_have_numbers(family: Branch) -> None:
    system = uniform(2)
    assert pick(system, family).q[0] == pytest.approx(family.points[-1, :-1], abs=1e-13)
    assert pick(system, family, "point=9").omega == pytest.approx(family.points[8, -1], rel=1e-14)
    cover = next(k for k, event in enumerate(family.events, 1) if event.kind.startswith("cover"))
    found = pick(system, family, f"event={cover}")
    assert np.array_equal(found.q[0], family.events[cover - 1].z[:-1]) and np.isnan(found.error)
    # Three traversals: after a third of the period it is where it was.
    assert found.q[80] == pytest.approx(found.q[0], abs=1e-9)


def test_one_harmonic_names_a_true_orbit() -> None:
    system = uniform(2)
    found = pick(system, trace(system, method="one harmonic", until="theta_1=0.6"), "theta_1=0.5")
    assert found.q[0, 0] == 0.5 and found.closure < 1e-14 and found.method == "quarter"


def test_series_over_a_period_name_their_orbit() -> None:
    system = uniform(1)
    branch = replace(trace(system, until="theta_1=1.5"), method="harmonics", closing="")
    assert pick(system, branch).omega == pytest.approx(3.812018988865347, rel=1e-14)


def test_a_conical_orbit_is_what_an_integrator_finds() -> None:
    own = {"mass": (1.0, 0.5), "length": (1.0, 2.0), "com": (1.0, 1.6)}
    system = build(Scene("conical2_3", 2, space="spatial", want=("forward_dynamics", "state_jacobian", "energy", "mass_matrix"), **own))
    found = pick(system, trace(system, 1, method="conical", until="theta_1=1"), samples=9)
    run = solve_ivp(rhs(system), (0, found.period), np.concatenate([found.q[0], found.v[0]]), "DOP853", found.t, rtol=1e-12, atol=1e-12)
    assert np.hstack([found.q, found.v]) == pytest.approx(run.y.T, abs=1e-8)
    assert found.is_stable and len(found.multipliers) == 6 and found.closure < 1e-13


def test_files_hold_the_whole_orbit(family: Branch, tmp_path: Path) -> None:
    for at in ("theta_1=0.9", "event=1"):
        found = pick(uniform(2), family, at, samples=7)
        text = found.to_json(tmp_path / "a.json").read_text()
        for read in (Orbit.from_json(tmp_path / "a.json"), Orbit.from_npz(found.to_npz(tmp_path / "a.npz"))):
            assert read.to_json(tmp_path / "b.json").read_text() == text
    lines = tables.lines(found.to_csv(tmp_path / "a.csv"))
    assert lines[0] == "t,theta_1,theta_2,theta_dot_1,theta_dot_2" and len(lines) == 8
    assert "<pre>" in found._repr_html_() and f"{found.energy:.15g} J" in found._repr_html_() and "<img" in found._repr_html_()
    for broken in (text[:-40], text.replace('"orbit"', '"branch"', 1), text.replace('"samples"', '"sample"'), text.replace('"mode": 1', '"mode": [1]'), text.replace('"scene": "', '"scene": -1, "was": "')):
        assert broken != text
        (tmp_path / "c.json").write_text(broken)
        with pytest.raises(OutputError, match="no orbit can be read there"):
            Orbit.from_json(tmp_path / "c.json")


def test_what_is_refused(family: Branch) -> None:
    with pytest.raises(ArrayError, match="another one"):
        pick(uniform(1), family)
    with pytest.raises(ArrayError, match=r"goes from 2\.75\d+ to 3\.99"):
        pick(uniform(2), family, "omega=40")
    with pytest.raises(ArrayError, match=f"none of this family's {len(family)} points"):
        pick(uniform(2), family, f"point={len(family) + 1}")
    with pytest.raises(ArrayError, match="is no quantity"):
        pick(uniform(2), family, "theta_9=1")
    with pytest.raises(UnsupportedError, match="is none whose orbits"):
        pick(uniform(2), replace(family, method="guessing"))
