"""Orbits of every kind in a parameter of the chain, against their own families traced at the other value."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from phichain.app.cli import app
from phichain.continuation import Branch, Evaluation, Fold, Options, Problem
from phichain.errors import ArrayError, OutputError, UnsupportedError
from phichain.orbits import respond, trace
from phichain.orbits.closed.kinds import KINDS, problem_of, state_of, unknowns_of
from phichain.orbits.closed.symmetries import recognised
from phichain.orbits.network.opening import Opening, first_points, opening_at
from phichain.orbits.parameter import knob_of, vary
from phichain.orbits.parameter.followed import closed_orbits
from phichain.orbits.parameter.held import value_of
from phichain.orbits.shooting import settings
from phichain.orbits.whirling import NEEDED
from phichain.orbits.whirling.fixed import turned
from phichain.pipeline import build
from phichain.scene import Scene
from phichain.system import System
from tests.orbits.whirling.monodromy import spectrum

R = "runtime"
SHORT = Options(step=2e-3, step_max=0.02, max_points=60, tol=1e-9)
WANT = ["propagate", "mass_matrix", "energy", "forward_dynamics"]
SPATIAL_P = {"length": [0.5, 0.5]}
RODS_P = {**SPATIAL_P, "gravity": 9.81}
DRIVEN_P = {"damping": [0.03, 0.01]}


@lru_cache
def rods() -> System:
    return build(Scene("turned_rods_too", 2, mass=0.5, length=R, com=0.25, gravity=R, want=WANT, variational=["length"]))


@lru_cache
def spatial() -> System:
    return build(Scene("turned_swing", 2, mass=0.5, length=R, com=0.25, space="spatial", want=NEEDED, variational=True))


@lru_cache
def driven() -> System:
    return build(
        Scene("turned_driven", 2, mass=0.5, length=0.5, com=0.25, actuated="none", damping=R, want=["propagate"], forced=1,
              variational=["state", "damping"])
    )  # fmt: skip


@lru_cache
def swings() -> Branch:
    return trace(rods(), 1, until="theta_1=-1.6", p=RODS_P)


@lru_cache
def cone() -> Branch:
    return trace(spatial(), method="conical", until="theta_1=0.8", p=SPATIAL_P)


def beyond(kind: str) -> dict[str, Any]:
    """The first orbit beyond the last event of the brake orbits that opens a kind: the brake loss before it is a cover."""
    event = [event for event in swings().events if KINDS["quarter"].opens.get(event.kind, ("", 1))[0] == kind][-1]
    opened = opening_at(rods(), RODS_P, swings(), event)
    assert isinstance(opened, Opening)
    _, points = first_points(rods(), RODS_P, opened, settings(None))
    z = points[0].y * problem_of(rods(), RODS_P, kind, opened.z).sizes
    return dict(zip("qv", state_of(kind, z), strict=True)) | {"omega": float(z[-1])}


def test_a_brake_orbit_beside_a_cover_is_one_from_anywhere_on_it() -> None:
    """It all but rests three times in half a period, and rests once; and where rests are lost at the cover no others lead on."""
    event = next(event for event in swings().events if event.kind == "brake loss")
    z = swings().points[event.index]
    assert np.max(np.abs(z - event.z)) < 0.1
    times = np.linspace(0.0, 2 * np.pi / z[-1], 13)
    run = rods().propagate(z[:2], np.zeros(2), 0.0, times[-1], 1e-16, times=times, p=RODS_P)
    assert {recognised(rods(), RODS_P, q, v, z[-1]) for q, v in zip(run.q_at, run.v_at, strict=True)} == {("quarter", 1)}
    opened = opening_at(rods(), RODS_P, swings(), event)
    assert isinstance(opened, Opening) and opened.around is not None and len(opened.around) == 23
    assert first_points(rods(), RODS_P, opened, settings(None))[1] == ["Newton reached no orbit beside it that its own family has not"]


@pytest.mark.long
@pytest.mark.parametrize(("kind", "hold"), [("odd", "theta_dot_1"), ("unequal", "energy"), ("half", "theta_1")])
def test_orbits_of_fewer_symmetries_come_back_over_their_period(kind: str, hold: str) -> None:
    """At the other length the start still comes back, as the flow of that chain says; and turned back it is the same orbit."""
    start = beyond(kind)
    there = vary(rods(), "length[1]", start, 0.502, hold=hold, p=RODS_P, options=SHORT)
    x, omega, p = there.states[-1], there.points[-1, -2], {**RODS_P, "length": [0.502, 0.5]}
    end = rods().propagate(x[:2], x[2:], 0.0, 2 * np.pi / omega, 1e-16, p=p)
    kept = there.energy if hold == "energy" else there.column(hold)
    assert there.closing.startswith(f"{kind}; {hold} = ") and there.points[-1, -1] == 0.502 and np.ptp(kept) < 1e-12
    assert np.concatenate([end.q, end.v]) == pytest.approx(x, abs=1e-11)
    back = vary(rods(), "length[1]", {"q": x[:2], "v": x[2:], "omega": omega}, 0.5, hold=hold, p=p, options=SHORT)
    assert back.points[-1, :-1] == pytest.approx(there.points[0, :-1], abs=1e-10)


@pytest.mark.parametrize("kind", ["quarter", "odd", "unequal", "half", "whole"])
def test_the_equations_change_with_the_parameter_as_their_differences_say(kind: str) -> None:
    """Off any orbit."""
    z = {"half": np.array([0.3, -0.2, 2.0, 1.0, 0.1, 4.0])}.get("half" if kind == "whole" else kind, np.array([0.6, 0.4, 4.0]))
    followed, (knob, values) = closed_orbits(rods(), kind, z, RODS_P), knob_of(rods(), "length[1]", RODS_P)
    ahead, behind = (followed.family(knob.turned(values, 0.5 + h)).evaluate(z).residual for h in (1e-5, -1e-5))
    assert followed.by_parameter(z, values, knob) == pytest.approx((ahead - behind) / 2e-5, rel=1e-6, abs=1e-7)


@pytest.mark.long
def test_spatial_orbits_are_those_of_the_other_chain() -> None:
    """Conical orbits and orbits in a plane against families traced at the other length; the place where the plane is lost, too."""
    p = {"length": [0.51, 0.5]}
    found = vary(spatial(), "length[1]", cone(), 0.51, hold="theta_1", p=SPATIAL_P)
    other = trace(spatial(), method="conical", until="theta_1=0.8", p=p)
    assert found.points[-1, :-1] == pytest.approx(other.points[-1], abs=1e-12) and found.method == "conical in length[1]"
    own, other = (trace(spatial(), method="in a plane", until="theta_1=0.9", p=values) for values in (SPATIAL_P, p))
    found = vary(spatial(), "length[1]", own, 0.51, hold="theta_1", p=SPATIAL_P)
    assert found.points[-1, :-1] == pytest.approx(other.points[-1], abs=1e-12)
    locus = vary(spatial(), "length[1]", (own, own.located("plane loss")[0]), 0.51, p=SPATIAL_P, options=SHORT)
    assert locus.points[-1, :-1] == pytest.approx(other.located("plane loss")[0].z, abs=1e-9)


def test_whirling_orbits_come_back_turned() -> None:
    """At the other length by that chain's flow; momentum and frequency held. The locus of a period doubling has lambda = -1 by the whole map."""
    family = trace(spatial(), method="whirling", start=cone(), until="theta_1=0.6", p=SPATIAL_P)
    p = {"length": [0.51, 0.5]}
    found = vary(spatial(), "length[1]", family, 0.51, hold="omega", p=SPATIAL_P)
    x, turn, omega = found.states[-1], *found.points[-1, -3:-1]
    end = spatial().propagate(x[:6], x[6:], 0.0, 2 * np.pi / omega, 1e-16, p=p)
    assert turned(np.concatenate([end.q, end.v]), -turn) == pytest.approx(x, abs=1e-11) and omega == pytest.approx(family.points[-1, -1])
    locus = vary(spatial(), "length[1]", (family, family.located("period doubling")[0]), 0.501, p=SPATIAL_P, options=SHORT)
    x, turn, omega = locus.states[-1], *locus.points[-1, -3:-1]
    assert locus.points[0, :-1] == pytest.approx(family.located("period doubling")[0].z, abs=1e-8)
    own = spectrum(spatial(), x, 2 * np.pi / omega, turn, {"p": {"length": [0.501, 0.5]}})
    # Two of them meet at -1, which a square root of rounding moves.
    assert np.sort(np.abs(own + 1))[:2] == pytest.approx([0, 0], abs=1e-4)


@pytest.mark.long
@pytest.mark.parametrize(("parameter", "value"), [("damping[1]", 0.031), ("amplitude", 0.102)])
def test_folds_of_a_driven_chain(parameter: str, value: float) -> None:
    """Both folds followed in a damper and in the forcing's amplitude are those of the response there."""
    at = {"omega": (3.6, 4.0), "method": "shooting"}
    own = respond(driven(), None, 0.1, p=DRIVEN_P, **at)
    p, amplitude = (DRIVEN_P, value) if parameter == "amplitude" else ({"damping": [value, 0.01]}, 0.1)
    other = respond(driven(), None, amplitude, p=p, **at)
    assert len(own.located("fold")) == 2
    for one, two in zip(own.located("fold"), other.located("fold"), strict=True):
        locus = vary(driven(), parameter, (own, one), value, p=DRIVEN_P)
        assert locus.closing == "forced, 1, 0.1; fold" and locus.points[-1, -2] == pytest.approx(two.omega, abs=1e-9)
    # Of held frequency the motion is that of the other response, where it comes by.
    held = vary(driven(), parameter, (own, 5), value, p=DRIVEN_P)
    end = driven().propagate(
        held.states[-1, :2], held.states[-1, 2:], 0.0, np.pi / own.omega[5], 1e-16, forcing=(amplitude, own.omega[5]), p=p
    )
    assert np.append(end.q, end.v) == pytest.approx(-held.states[-1], abs=1e-11)


@pytest.mark.long
def test_where_multipliers_collide() -> None:
    """The krein locus of three links, where the discriminant bends sharply, ends at the collision that the family there meets by itself."""
    chain = build(Scene("turned_three", 3, mass=1 / 3, length=R, com=1 / 6, want=WANT, variational=["length"]))
    own, other = (
        trace(chain, 2, until="amplitude=2.45", p={"length": [1 / 3, middle, 1 / 3]}) for middle in (1 / 3, 0.3336)
    )
    locus = vary(chain, "length[2]", (own, own.located("krein")[0]), 0.3336, p={"length": [1 / 3] * 3}, options=SHORT)
    assert locus.points[-1, :-1] == pytest.approx(other.located("krein")[0].z, abs=1e-10)
    assert np.abs(np.diff(locus.multipliers, axis=1)).max() < 1e-5 and np.abs(locus.multipliers.real).max() < 1


def test_functions_of_the_tangent_have_one_sign_whichever_way_it_is_found() -> None:
    """On the circle the tangent is (-y, x), or the other way round; what is held goes on smoothly where that changes."""
    circle = Problem(lambda z: Evaluation(np.array([z @ z - 1]), 2 * z[None, :]), ("x", "y"))
    angles = np.linspace(0.1, 6.2, 62)
    places = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    own = np.array([value_of(Fold(0), circle, z, circle.evaluate(z)) for z in places])
    assert own == pytest.approx(-places[:, 1], abs=1e-15)


def test_a_crossing_is_followed_as_the_event_that_it_is() -> None:
    """Where odd orbits meet their own mirror image brake orbits lose theirs; a crossing of two families of one kind has no locus."""
    event = swings().located("odd loss")[0]
    kept = unknowns_of("odd", np.zeros(2), rods().propagate(
        event.z[:2], np.zeros(2), 0.0, np.pi / (2 * event.z[-1]), 1e-16, p=RODS_P).v, event.z[-1])  # fmt: skip
    crossing = replace(event, kind="branch point", z=kept)
    family = replace(swings(), closing="odd")
    own, other = (
        vary(rods(), "length[1]", start, 0.502, p=RODS_P, options=SHORT) for start in ((swings(), event), (family, crossing))
    )
    # An orbit and its mirror image are half a period apart: which rest is found first is a matter of rounding.
    assert other.closing == "quarter; odd loss" and np.abs(other.points[-1]) == pytest.approx(np.abs(own.points[-1]), abs=1e-9)
    with pytest.raises(ArrayError, match="opens into a gap"):
        vary(rods(), "length[1]", (swings(), replace(event, kind="branch point", z=swings().points[30])), 0.502, p=RODS_P)


def test_a_run_is_gone_on_with_bit_by_bit(tmp_path: Path) -> None:
    whole = vary(rods(), "length[1]", (swings(), 20), 0.55, hold="energy", p=RODS_P, options=SHORT)
    begun = vary(rods(), "length[1]", (swings(), 20), 0.55, hold="energy", p=RODS_P, options=replace(SHORT, max_points=3))
    for path in (begun.to_json(tmp_path / "b.json"), begun.to_npz(tmp_path / "b.npz")):
        on = vary(rods(), "length[1]", None, 0.55, resume=path, p=RODS_P, options=SHORT)
        assert on.points.tolist() == whole.points.tolist() and on.closing == whole.closing and str(on) == str(whole)
    stands = float(begun.points[-1, -1])
    with pytest.raises(ArrayError, match="lies behind that run, which stands at .* and goes on to larger values") as caught:
        vary(rods(), "length[1]", None, stands - 1e-6, resume=begun, p=RODS_P, progress=lambda *_: pytest.fail("a step was taken"))
    assert caught.value.field == "until" and f"{stands!r}" in str(caught.value) and "\n" not in str(caught.value)
    for parameter, p, words in (("length[2]", RODS_P, "is not what that run turned"), ("length[1]", {"length": [0.5, 0.5], "gravity": 9.0}, "other parameters")):
        with pytest.raises(ArrayError, match=words):
            vary(rods(), parameter, None, 0.55, resume=begun, p=p)
    with pytest.raises(ArrayError, match="is no run in a parameter"):
        vary(rods(), "length[1]", None, 0.55, resume=swings(), p=RODS_P)


@pytest.mark.long
def test_the_command_draws_goes_on_and_starts_anywhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "rods.toml").write_text(
        'name = "turned_rods_cli"\n[chain]\nlinks = 2\nmass = 0.5\nlength = 0.5\ncom = 0.25\n[functions]\nwant = ["propagate"]\n'
    )

    def run(*words: str) -> Any:
        answer = CliRunner().invoke(app, ["vary", "rods.toml", "--parameter", "length[1]", *words])
        assert answer.exit_code == 0, answer.output
        return answer.output

    said = json.loads(run("--until", "0.52", "--at", "energy=1", "--out", "a.json", "--out", "a.png", "--max-points", "3", "--json"))
    assert said["points"] == 3 and said["last"]["length[1]"] > 0.5 and (tmp_path / "a.png").read_bytes()[:4] == b"\x89PNG"
    assert "length[1] = 0.52" in run("--until", "0.52", "--resume", "a.json", "--out", "b.npz")
    assert np.ptp(Branch.from_npz(tmp_path / "b.npz").energy) < 1e-12
    assert "length[1] = 0.51" in run("--until", "0.51", "--start", "q=0.7,0.2062; v=0,0; period=1.6568", "--hold", "omega", "--step-max", "0.05")


def test_what_cannot_be_started(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="no branch can be read there"):
        vary(rods(), "length[1]", str(tmp_path / "none.json:3"), 0.6, p=RODS_P)
    with pytest.raises(UnsupportedError, match="cannot be turned on 'turned_swing': those that come at run time are length"):
        vary(spatial(), "mass[1]", cone(), 0.6, p=SPATIAL_P)
    with pytest.raises(ArrayError, match="is nothing that can be held here"):
        vary(spatial(), "length[1]", cone(), 0.6, hold="brake loss", p=SPATIAL_P)
    with pytest.raises(ArrayError, match="is the scene of that response"):
        vary(rods(), "length[1]", respond(driven(), None, 0.1, (3.0, 3.1), method="shooting", p=DRIVEN_P), 0.6, p=RODS_P)
