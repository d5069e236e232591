"""Records on file that hold numbers which none can have: one typed error that names file, field and value, whatever the record and its form."""

from __future__ import annotations

import copy
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from phichain.continuation import Branch
from phichain.errors import ArrayError, OutputError
from phichain.orbits import Network, Orbit, pick, trace
from phichain.orbits.forced.response import Response
from tests.orbits.shot import uniform


@pytest.fixture(scope="module")
def family() -> Branch:
    return trace(uniform(2), until="theta_1=1.1")


def put(found: Any, place: tuple[Any, ...], value: Any) -> Any:
    """A copy with another value at a place."""
    changed = copy.deepcopy(found)
    at = changed
    for step in place[:-1]:
        at = at[step]
    at[place[-1]] = value
    return changed


def refused(read: Any, path: Path, field: str, value: float) -> None:
    with pytest.raises(OutputError) as caught:
        read(path)
    assert caught.value.field == field and (caught.value.value == value or np.isnan(value))
    assert str(path) in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("place", "field", "value"),
    [
        (("points", 3, "omega"), "points[3].omega", -1.0),
        (("points", 3, "omega"), "points[3].omega", 0.0),
        (("points", 2, "start", "q", 1), "points[2][1]", float("nan")),
        (("points", 2, "tangent", 0), "tangent[2][0]", float("inf")),
        (("points", 1, "residual"), "residual[1]", -1e-9),
        (("points", 1, "arclength"), "arclength[1]", float("-inf")),
        (("events", 0, "omega"), "events[0].omega", -2.0),
        (("events", 0, "start", "q", 0), "events[0].z[0]", float("inf")),
        (("scale", 1), "scale[1]", 0.0),
        (("tol",), "tol", -1.0),
        (("checkpoint", "step"), "step", float("nan")),
    ],
)
def test_families_and_networks(family: Branch, tmp_path: Path, place: tuple[Any, ...], field: str, value: float) -> None:
    path = family.to_json(tmp_path / "family.json")
    path.write_text(json.dumps(put(json.loads(path.read_text()), place, value)))
    refused(Branch.from_json, path, field, value)
    path = Network("two", (family, family), (), "whole", "").to_json(tmp_path / "network.json")
    path.write_text(json.dumps(put(json.loads(path.read_text()), ("branches", 1, *place), value)))
    refused(Network.from_json, path, f"branches[1].{field}", value)


def test_families_as_arrays(family: Branch, tmp_path: Path) -> None:
    points = family.points.copy()
    points[4, -1] = -3.0
    refused(Branch.from_npz, replace(family, points=points).to_npz(tmp_path / "f.npz"), "points[4].omega", -3.0)


@pytest.mark.parametrize(
    ("place", "field", "value"),
    [(("omega",), "omega", -1.0), (("samples", "q", 5, 1), "q[5][1]", float("nan")), (("samples", "t", 5), "t[5]", 0.0), (("turn",), "turn", float("inf"))],
)
def test_orbits(family: Branch, tmp_path: Path, place: tuple[Any, ...], field: str, value: float) -> None:
    orbit = pick(uniform(2), family, samples=9)
    path = orbit.to_json(tmp_path / "orbit.json")
    path.write_text(json.dumps(put(json.loads(path.read_text()), place, value)))
    refused(Orbit.from_json, path, field, value)
    refused(Orbit.from_npz, replace(orbit, omega=-1.0).to_npz(tmp_path / "orbit.npz"), "omega", -1.0)


def test_responses(tmp_path: Path) -> None:
    one = np.ones((2, 1))
    good = Response(
        "r", "s", "d", "1", "joint 1", "N m", 0.1, "shooting", ("theta_1",), np.array([1.0, 2.0]), one, one, one, one + 0j, one + 0j,
        np.zeros(2), np.zeros(2), np.arange(2.0), (), "points", "",
    )  # fmt: skip
    assert len(Response.from_npz(good.to_npz(tmp_path / "r.npz"))) == len(Response.from_json(good.to_json(tmp_path / "r.json"))) == 2
    bad = replace(good, omega=np.array([1.0, -2.0]))
    refused(Response.from_npz, bad.to_npz(tmp_path / "r.npz"), "omega[1]", -2.0)
    refused(Response.from_json, bad.to_json(tmp_path / "r.json"), "omega[1]", -2.0)


def test_a_family_of_another_shape_than_its_scene(family: Branch) -> None:
    """Consistent in itself and under the digest of the scene, but of one link fewer."""
    events = tuple(replace(event, z=event.z[1:]) for event in family.events)
    thin = replace(family, names=family.names[1:], points=family.points[:, 1:], tangent=family.tangent[:, 1:], scale=family.scale[1:], events=events)
    for use in (lambda: pick(uniform(2), thin), lambda: pick(uniform(2), thin, "event=1"), lambda: trace(uniform(2), until="theta_1=1.2", resume=thin)):
        with pytest.raises(ArrayError, match="have 2 unknowns, and there are 3 here: theta_1, theta_2, omega") as caught:
            use()
        assert caught.value.field == "branch.points"
