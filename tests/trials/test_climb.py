"""Up a family of orbits: rungs against an integrator of their own, gains across by multipliers, the compiled law in closed loop, refusals."""

from __future__ import annotations

import json
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from phichain import build, climb, generate_climb, trace
from phichain.app.cli import main
from phichain.continuation import Branch
from phichain.emit.stencil import stencils_folder
from phichain.errors import ArrayError, ControlError, OutputError, UnsupportedError
from phichain.laws import FamilyLaw
from phichain.orbits.climb import gravity_torque
from phichain.orbits.climb.across import asked_between, by_phase, gains_across
from phichain.orbits.climb.design import NEEDED, STRAY, fineness
from phichain.orbits.climb.effort import torques
from phichain.orbits.climb.ladder import Ladder, finer
from phichain.orbits.climb.motion import Equations
from phichain.scene.library import find_scene
from phichain.trials import Climbed
from phichain.trials.climb import driven_at

STRICT = ("cc", "-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", "-pedantic-errors", "-Wconversion", "-Wdouble-promotion")
SCENE = find_scene("planar2")
SHOT = ("mass_matrix", "energy", "forward_dynamics")
G, M, L = 9.81, 0.5, 0.5


@pytest.fixture(scope="module")
def branch() -> Branch:
    """The family of mode 2, whose energy rises all the way to the upright chain."""
    return traced("energy=9.808")


def traced(until: str) -> Branch:
    """As the command traces: by a flow that carries derivatives, under the digest of the scene that was named."""
    system = build(replace(SCENE, want=(*SHOT, "propagate"), variational=True, actuated="none"))
    found = trace(replace(system, digest=SCENE.digest), 2, until=until)
    assert isinstance(found, Branch)
    return found


@pytest.fixture(scope="module")
def found(branch: Branch) -> Climbed:
    return climb(SCENE, branch, share=0.05, runs=4, seconds=90.0)


def double(x: np.ndarray, torque: tuple[float, float] = (0.0, 0.0)) -> np.ndarray:
    """Two rods' worth of point masses at their middles, from the textbook: relative angles, the masses' positions; torques at both joints."""
    a, b = x[0], x[0] + x[1]
    wa, wb = x[2], x[2] + x[3]
    r = L / 2
    c = np.array([[M * r**2 + M * L**2, M * L * r * np.cos(a - b)], [M * L * r * np.cos(a - b), M * r**2]])
    s = M * L * r * np.sin(a - b)
    force = np.array([-s * wb**2 - G * (M * r + M * L) * np.sin(a), s * wa**2 - G * M * r * np.sin(b)])
    acc = np.linalg.solve(c, force + np.array([torque[0] - torque[1], torque[1]]))
    return np.array([wa, wb - wa, acc[0], acc[1] - acc[0]])


@pytest.mark.long
def test_every_kind_of_rung_is_a_motion_of_the_chain(found: Climbed) -> None:
    """From a brake, half a period on: its mirror image. Near the top, part by part: nothing but parts can be followed."""
    law = found.climb.law
    assert len(law.states) == 48 and np.all(law.states[0] == 0)
    assert law.states.shape[1] > 49 and np.max(asked_between(law.states[1:], law.gains[1:])) <= STRAY * law.limit
    for k in (1, 12, 25):
        way = solve_ivp(lambda t, x: double(x), (0, law.periods[k] / 2), law.states[k, 0], rtol=1e-11, atol=1e-12)
        assert np.allclose(way.y[:, -1], -law.states[k, 0], atol=1e-5)
        assert np.allclose(law.states[k, -1], -law.states[k, 0], atol=1e-6)
    quarter, period = found.climb.ladder.states[-1], found.climb.ladder.periods[-1]
    h = period / 4 / (len(quarter) - 1)
    for i in range(0, len(quarter) - 1, 40):
        way = solve_ivp(lambda t, x: double(x), (0, h), quarter[i], rtol=1e-11, atol=1e-13)
        assert np.allclose(way.y[:, -1], quarter[i + 1], atol=1e-7)
    assert np.allclose(quarter[-1, :2], 0, atol=1e-7) and np.max(np.abs(quarter[0] - found.climb.ladder.target)) < 0.01


def test_rates_and_energies_are_those_of_the_orbits(found: Climbed) -> None:
    law = found.climb.law
    for k in (3, 20, 47):
        x = law.states[k]
        a, b, wa, wb = x[:, 0], x[:, 0] + x[:, 1], x[:, 2], x[:, 2] + x[:, 3]
        kinetic = M / 2 * (L / 2 * wa) ** 2 + M / 2 * ((L * wa) ** 2 + (L / 2 * wb) ** 2 + L * L * wa * wb * np.cos(a - b))
        height = M * L / 2 * (1 - np.cos(a)) + M * (L * (1 - np.cos(a)) + L / 2 * (1 - np.cos(b)))
        assert np.allclose(kinetic + G * height, law.energies[k], rtol=1e-4)
        # A half period in the phase's own rates.
        even = np.linspace(0, 1, x.shape[0])
        assert np.trapezoid(1 / law.rates[k], even) == pytest.approx(law.periods[k] / 2, rel=2e-2)


def test_gains_across_bring_small_errors_down_and_leave_the_phase_free(branch: Branch, found: Climbed) -> None:
    """Held across two periods on the textbook's equations, an error shrinks; along the orbit K is blind."""
    law = found.climb.law
    k = int(np.argmin(np.abs(law.energies - 1.96)))
    slopes = np.array([double(x) for x in law.states[k]])
    for i in range(len(slopes)):
        assert abs(law.gains[k, i] @ slopes[i]) < 1e-6 * np.linalg.norm(law.gains[k, i]) * np.linalg.norm(slopes[i])
    system = build(replace(driven_at(SCENE, 1), want=NEEDED))
    equations, ladder = Equations(system), found.climb.ladder
    at = int(np.argmin(np.abs(ladder.energies - law.energies[k])))
    states, times, _ = by_phase(equations, ladder.states[at : at + 1], ladder.periods[at : at + 1], law.weights, law.states.shape[1])
    assert np.allclose(states[0], law.states[k], rtol=0, atol=1e-12)
    t = times[0]
    gains = gains_across(equations, law.states[k : k + 1], t[None], law.slowness[k : k + 1], 5 / found.climb.torque**2)[0]
    _, D = equations.carried(law.states[k, :-1], np.diff(t), 8)
    whole = np.eye(4)
    for i in range(len(D)):
        whole = (D[i, :, :4] - np.outer(D[i, :, 4], gains[i])) @ whole
    sizes = np.sort(np.abs(np.linalg.eigvals(whole)))
    assert sizes[-1] == pytest.approx(1.0, abs=0.01) and sizes[-2] < 0.9


def test_the_compiled_law_climbs_and_holds_within_its_limit(found: Climbed) -> None:
    runs, law = found.runs, found.climb.law
    assert runs.share == 1.0 and len(runs.held) == 4 and np.max(runs.settled) < 80
    assert law.limit == pytest.approx(0.05 * G * (M * L / 2 + M * L + M * L / 2), rel=1e-12)
    assert np.max(runs.largest[:, 1]) <= law.limit * (1 + 1e-6)
    assert np.allclose(np.abs(np.cos(runs.ends[:, 0])), 1, atol=1e-3) and np.all(np.cos(runs.ends[:, 0]) < 0)
    assert found.energy[0] == pytest.approx(0, abs=1e-12) and found.energy[-1] == pytest.approx(2 * G * 0.5, rel=1e-3)


def test_its_folder_passes_its_own_test_and_says_its_bytes(found: Climbed, tmp_path: Path) -> None:
    folder = generate_climb(found.climb.law, tmp_path)
    subprocess.run([*STRICT, "planar2_climb.c", "selftest.c", "-o", "selftest", "-lm"], cwd=folder, check=True)
    assert subprocess.run(["./selftest"], cwd=folder, check=False).returncode == 0
    manifest = json.loads((folder / "manifest.json").read_text())
    assert manifest["table_bytes"] == 4 * 48 * ((found.climb.law.states.shape[1] + 2) * 9 + 2) and f"_BYTES  {manifest['table_bytes']} " in (folder / "planar2_climb.h").read_text()
    text = (folder / "planar2_climb.c").read_text()
    assert text.count("u[0] = side *") == 1
    (folder / "planar2_climb.c").write_text(text.replace("u[0] = side *", "u[0] = -side *"))
    subprocess.run(["cc", "-O1", "planar2_climb.c", "selftest.c", "-o", "spoilt", "-lm"], cwd=folder, check=True)
    assert subprocess.run(["./spoilt"], cwd=folder, check=False).returncode > 0


def between(ladder: Ladder, energy: float) -> Ladder:
    """Two orbits of a ladder, one below the energy and one above."""
    k = int(np.searchsorted(ladder.energies, energy))
    return replace(ladder, states=ladder.states[k - 1 : k + 1], periods=ladder.periods[k - 1 : k + 1], energies=ladder.energies[k - 1 : k + 1])


@pytest.mark.long
@pytest.mark.parametrize("joint", [1, 2])
def test_the_torque_from_orbit_to_orbit_is_the_least_that_leads_there(found: Climbed, joint: int) -> None:
    """Pulses on the textbook's equations, one after the other: of all sums of them that end across the orbit the least square."""
    two = between(found.climb.ladder, 2.0)
    system = build(replace(driven_at(SCENE, joint), want=NEEDED))
    weights = np.array([1.0, 1.0, 0.05, 0.05])
    given = torques(Equations(system), two.states, two.periods, weights)[0]
    start, period, count = two.states[0, 0], two.periods[0], 64
    ends, size = [], 1e-4
    for pulse in range(count + 1):
        x = start
        for part in ((0.0, pulse / count), (pulse / count, min(pulse + 1, count) / count), (min(pulse + 1, count) / count, 1.0)):
            push = [0.0, 0.0]
            push[joint - 1] = size if part[0] == pulse / count and part[1] > part[0] and part[1] <= (pulse + 1) / count else 0.0
            if part[1] > part[0]:
                span = (part[0] * period, part[1] * period)
                x = solve_ivp(lambda t, y, push=tuple(push): double(y, push), span, x, rtol=1e-10, atol=1e-12).y[:, -1]
        ends.append(x)
    scale = np.sqrt(weights)
    flow = scale * double(start)
    across = np.linalg.svd(np.eye(4) - np.outer(flow, flow) / (flow @ flow))[0][:, :3]
    reach = across.T @ (scale[:, None] * (np.array(ends[:-1]) - ends[-1]).T) / size
    u = np.linalg.lstsq(reach, across.T @ (scale * (two.states[1, 0] - start)), rcond=None)[0]
    assert given == pytest.approx(np.sqrt(np.mean(u**2)), rel=0.03)
    # In gravity torques of its own, joint 2 is asked for far more than joint 1.
    assert (given / gravity_torque(system, joint) > 0.1) == (joint == 2)


def test_orbits_in_between_are_orbits(found: Climbed) -> None:
    two, system = between(found.climb.ladder, 2.0), build(replace(driven_at(SCENE, 1), want=NEEDED))
    more = finer(system, Equations(system), two, np.array([3]))
    assert len(more.states) == 4 and np.all(np.diff(more.energies) > 0) and np.array_equal(more.states[[0, -1]], two.states)
    for k in (1, 2):
        way = solve_ivp(lambda t, x: double(x), (0, more.periods[k] / 2), more.states[k, 0], rtol=1e-11, atol=1e-12)
        assert np.allclose(way.y[:, -1], -more.states[k, 0], atol=1e-6)


@pytest.mark.long
def test_joint_2_leads_the_chain_beyond_the_orbit_that_it_hardly_moves(branch: Branch) -> None:
    """At 2 J, where a joule takes joint 2 fifty times the periods of its whole limit that it takes joint 1, rungs are dense and rise slowly."""
    found = climb(SCENE, branch, share=0.2, joint=2, runs=2, seconds=85.0)
    law = found.climb.law
    steep = (1.4 < law.energies) & (law.energies < 2.4)
    assert np.sum(steep) >= 6 and np.all(law.rises[steep] < 0.4) and np.mean(np.diff(law.energies[steep])) < 0.7 * law.energies[-1] / len(law.states)
    assert np.max(law.rises) == 1 and found.runs.share == 1


def test_a_law_on_file_is_the_same_record(found: Climbed, tmp_path: Path) -> None:
    law = found.climb.law
    again = FamilyLaw.from_npz(law.to_npz(tmp_path / "law.npz"))
    assert again.catch == law.catch and (again.pace, again.tube) == (law.pace, law.tube)
    assert all(np.array_equal(getattr(again, name), getattr(law, name)) for name in ("states", "rates", "gains", "slowness", "rises", "shape"))
    with pytest.raises(OutputError, match="holds a Runs, not a FamilyLaw"):
        FamilyLaw.from_npz(found.runs.to_npz(tmp_path / "runs.npz"))
    with pytest.raises(ArrayError, match="energies not rising"):
        replace(law, energies=law.energies[::-1])


def test_the_command_refuses_what_leads_nowhere(branch: Branch, found: Climbed, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = branch.to_json(tmp_path / "family.json")
    with pytest.raises(SystemExit) as ended:
        main(["climb", "planar3", "--branch", str(file)])
    assert ended.value.code and "another one" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        main(["climb", "planar2", "--branch", str(file), "--limit", "-1"])
    assert "limit: must be positive" in capsys.readouterr().err
    low = traced("energy=3")
    with pytest.raises(UnsupportedError, match="no equilibrium is near its last brake"):
        climb(SCENE, low)
    fallen = replace(branch, energy=np.array(branch.energy)[::-1])
    with pytest.raises(UnsupportedError, match="its energy falls from there"):
        climb(SCENE, fallen)
    with pytest.raises(ControlError, match="too small for the damping"):
        found.climb.demand_room(np.array([0.05, 0.05]))
    found.climb.demand_room(np.array([1e-4, 1e-4]))
    with pytest.raises(ControlError, match="no joint of this chain"):
        driven_at(SCENE, 3)


def test_tables_are_finer_the_weaker_the_input() -> None:
    """As many rungs and nodes as were measured to serve at 5, 2 and 1 %, and never fewer than at 5 %."""
    assert [fineness(share) for share in (0.5, 0.05, 0.02, 0.01, 1e-4)] == [(48, 49), (48, 49), (96, 97), (161, 97), (240, 97)]


def test_the_stencils_compile_alone() -> None:
    words = ["-fsyntax-only", "-Wsign-conversion", "-Wshadow", "-Wundef", f"-I{stencils_folder()}"]
    subprocess.run([*STRICT, *words, str(stencils_folder() / "laws" / "climb_alone.c")], check=True)
