"""Orbits and events in a parameter of the chain: closed forms, families at the other end, and back to the start."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from scipy.special import ellipk
from typer.testing import CliRunner

from phichain.app.cli import app
from phichain.continuation import Branch, Options
from phichain.errors import ArrayError, ConvergenceError, UnsupportedError
from phichain.orbits import pick, trace
from phichain.orbits.closed.start import given
from phichain.orbits.parameter import vary
from phichain.pipeline import build
from phichain.scene import Scene

R = "runtime"
NEEDED = ["propagate", "mass_matrix", "energy"]
ONE_P = {"length": [0.5], "gravity": 9.81}
PAIR_P = {"mass": [1.0, 1.0], "length": [1.0, 1.0]}
COARSE = Options(step=0.02, step_max=0.2, max_points=200, tol=1e-9)
SHORT = Options(step=2e-3, step_max=0.02, max_points=200, tol=1e-9)


@pytest.fixture(scope="module")
def one() -> Any:
    return build(Scene("turned_one", 1, mass=1.0, length=R, gravity=R, want=NEEDED, variational=["length", "gravity"]))


@pytest.fixture(scope="module")
def pair() -> Any:
    return build(Scene("turned_pair", 2, mass=R, length=R, gravity=9.81, want=NEEDED, variational=["mass", "length"]))


@pytest.fixture(scope="module")
def family(pair: Any) -> Branch:
    return trace(pair, 1, until="theta_1=-1.0", p=PAIR_P)


def pendulum(amplitude: float, length: float, gravity: float) -> float:
    return float(np.sqrt(gravity / length) * np.pi / (2 * ellipk(np.sin(amplitude / 2) ** 2)))


def test_a_pendulum_of_held_amplitude_obeys_the_elliptic_integral(one: Any) -> None:
    start = trace(one, until="amplitude=2.0", p=ONE_P)
    branch = vary(one, "length", start, 2.0, p=ONE_P)
    assert branch.status == "event" and branch.points[-1][-1] == 2.0 and branch.events[-1].kind == "length[1] = 2.0"
    assert branch.names == ("theta_1", "omega", "length[1]")
    for theta, omega, length in branch.points:
        assert theta == 2.0 and omega == pytest.approx(pendulum(2.0, length, 9.81), rel=2e-13)
    assert branch.error is not None and branch.error.max() < 1e-13


def test_held_energy_and_frequency(one: Any) -> None:
    start = trace(one, until="amplitude=1.0", p=ONE_P)
    held = vary(one, "gravity", start, 4.0, hold="energy", p=ONE_P)
    assert held.energy is not None
    np.testing.assert_allclose(held.energy, held.energy[0], rtol=1e-12)
    for theta, omega, gravity in held.points:
        assert gravity * 0.5 * (1 - np.cos(theta)) == pytest.approx(9.81 * 0.5 * (1 - np.cos(1.0)), rel=1e-12)
        assert omega == pytest.approx(pendulum(theta, 0.5, gravity), rel=2e-13)
    slow = vary(one, "gravity", start, 5.0, hold="omega", p=ONE_P)
    assert "gravity = 5.0 was not reached" in slow.reason and slow.events[-1].kind == "back at rest"
    assert slow.points[-1][-1] == pytest.approx(0.5 * start.points[-1][1] ** 2, rel=1e-4)


@pytest.mark.long
def test_two_links_come_back_whatever_the_steps(pair: Any, family: Branch) -> None:
    """There and back again to the same orbit; two step limits a factor ten apart agree."""
    start = family.points[25]
    there = vary(pair, "mass[2]", (start[:2], start[2]), 2.0, p=PAIR_P)
    fine = vary(pair, "mass[2]", (start[:2], start[2]), 2.0, p=PAIR_P, options=Options(step=0.005, step_max=0.01, max_points=999, tol=1e-9))
    np.testing.assert_allclose(fine.points[-1], there.points[-1], rtol=0, atol=1e-13)
    q, omega = there.points[-1][:2], there.points[-1][2]
    back = vary(pair, "mass[2]", (q, omega), 1.0, p={**PAIR_P, "mass": [1.0, 2.0]})
    np.testing.assert_allclose(back.points[-1][:3], start, rtol=0, atol=1e-12)
    half = pair.propagate(q, [0.0, 0.0], 0.0, np.pi / omega, 1e-15, p={**PAIR_P, "mass": [1.0, 2.0]})
    np.testing.assert_allclose(half.q, -q, atol=1e-13)


@pytest.mark.parametrize(("kind", "atol"), [("brake loss", 1e-8), ("fold amplitude 2", 1e-8)])
def test_a_locus_ends_where_the_family_there_has_its_event(pair: Any, family: Branch, kind: str, atol: float) -> None:
    """Two parameters: an event followed in a length is the event that a family traced at the other length meets."""
    begun = family if kind.startswith("fold") else trace(pair, 1, until="theta_1=-2.5", p=PAIR_P)
    event = next(event for event in begun.events if event.kind == kind)
    locus = vary(pair, "length[2]", event, 1.05, hold=kind, p=PAIR_P, options=COARSE)
    assert locus.points[-1][-1] == 1.05
    other = trace(pair, 1, until="theta_1=-2.5", p={**PAIR_P, "length": [1.0, 1.05]}) if kind == "brake loss" else trace(
        pair, 1, until="amplitude=1.2", p={**PAIR_P, "length": [1.0, 1.05]}
    )
    met = [event.z for event in other.events if event.kind == kind]
    assert min(np.abs(z - locus.points[-1][:3]).max() for z in met) < atol


@pytest.fixture(scope="module")
def rods() -> Any:
    return build(Scene("turned_rods", 2, mass=0.5, length=R, com=0.25, gravity=9.81, want=NEEDED, variational=["length"]))


@pytest.fixture(scope="module")
def ends(rods: Any) -> tuple[Branch, Branch]:
    """The family at both ends of the loci: the first link 0.5 m and 0.505 m long."""
    return tuple(trace(rods, 1, until="theta_1=-1.3", p={"length": [length, 0.5]}) for length in (0.5, 0.505))


@pytest.mark.long
@pytest.mark.parametrize("kind", ["fold omega", "energy extremum", "odd loss", "unequal brakes", "cover 3 of mode 2"])
def test_loci_join_the_events_of_two_families(rods: Any, ends: tuple[Branch, Branch], kind: str) -> None:
    """From the event at one length to the same one at another, which a family traced there has found by itself."""
    own, other = (next(event for event in branch.events if event.kind == kind) for branch in ends)
    locus = vary(rods, "length[1]", own, 0.505, hold=kind, p={"length": [0.5, 0.5]}, options=SHORT)
    assert locus.points[-1, -1] == 0.505 and len(locus) > 2
    times = 3 if kind.startswith("cover") else 1
    at = locus.points[-1, :3] / [1.0, 1.0, times]
    met = [event.z for event in ends[1].events if event.kind == kind]
    assert min(np.abs(z - at).max() for z in met) < 2e-8 and np.abs(other.z - own.z).max() > 1e-4


def test_trace_goes_on_in_a_parameter(pair: Any) -> None:
    branch = trace(pair, 1, until="theta_1=0.5", parameter="length[1]=1.2", p=PAIR_P)
    assert branch.names[-1] == "length[1]" and branch.points[-1][0] == pytest.approx(0.5, abs=1e-15) and branch.points[-1][-1] == 1.2


@pytest.mark.parametrize(
    ("parameter", "until", "more", "error", "words"),
    [
        ("gravity", 3.0, {}, UnsupportedError, 'cannot be turned on \'turned_pair\': its flow carries derivatives by mass, length'),
        ("mass", 3.0, {}, ArrayError, "is 2 numbers"),
        ("mass[3]", 3.0, {}, ArrayError, "is no entry of it"),
        ("mass[0]", 3.0, {}, ArrayError, "is no entry of it"),
        (3, 3.0, {}, ArrayError, "is no parameter's name"),
        ("mass[2]", -1.0, {}, ArrayError, "is no value that mass[2] can have"),
        ("mass[2]", 1.0, {}, ArrayError, "is where the run starts"),
        ("mass[2]", 3.0, {"hold": "theta_3"}, ArrayError, "is nothing that can be held here"),
        ("mass[2]", 3.0, {"start": ([0.1], 2.0)}, ArrayError, "is no brake orbit (q_0, omega) of 2 coordinates at rest"),
        ("mass[2]", 3.0, {"start": 7}, ArrayError, "is no orbit"),
        ("mass[2]", 3.0, {"start": ([2.0, -2.0], 9.0)}, ConvergenceError, "is no orbit of 'turned_pair' at these parameters"),
        ("mass[2]", 3.0, {"p": {"length": [1.0, 1.0]}}, ArrayError, "has no value to start from"),
    ],
)  # fmt: skip
def test_what_cannot_be_followed(
    pair: Any, family: Branch, parameter: Any, until: float, more: dict[str, Any], error: type[Exception], words: str
) -> None:
    options = {"start": family, "p": PAIR_P} | more
    with pytest.raises(error) as caught:
        vary(pair, parameter, options.pop("start"), until, **options)
    assert words in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.long
def test_the_command(tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "chain.toml").write_text(
        'name = "turned_one"\n[chain]\nlinks = 1\nmass = 1.0\nlength = 0.5\n[functions]\nwant = ["propagate"]\n'
    )
    answer = CliRunner().invoke(
        app, ["vary", "chain.toml", "--parameter", "length", "--until", "0.6", "--at", "amplitude=1", "--out", "f.npz"]
    )
    assert answer.exit_code == 0, answer.output
    assert "length[1] = 0.6" in answer.output
    told = CliRunner().invoke(app, ["vary", "--help"]).output
    assert all(ending in told for ending in (".csv", ".npz", ".json", ".png"))
    found = Branch.from_npz(tmp_path / "f.npz")
    assert found.points[-1][1] == pytest.approx(pendulum(1.0, 0.6, 9.81), rel=1e-12)


def test_a_run_on_file_says_which_chain_every_point_is_of(one: Any, tmp_path: Any) -> None:
    branch = vary(one, "gravity", ([1.0], pendulum(1.0, 0.5, 9.81)), 9.0, p=ONE_P)
    text = json.loads(branch.to_json(tmp_path / "b.json").read_text())
    assert [row["parameter"]["gravity"] for row in text["points"]] == branch.points[:, -1].tolist()
    assert [row["omega"] for row in text["points"]] == branch.points[:, 1].tolist()
    for again in (Branch.from_json(tmp_path / "b.json"), Branch.from_npz(branch.to_npz(tmp_path / "b.npz"))):
        assert again.points.tolist() == branch.points.tolist() and again.names == branch.names and again.closing == branch.closing
    with pytest.raises(UnsupportedError, match="none whose orbits are refined here"):
        pick(one, branch, p=ONE_P)
    with pytest.raises(ArrayError, match="no orbits of the whole equations of one chain"):
        given(one, branch)
