"""Every file of every kind of result says where it comes from: version, scene, runtime parameters, method, tolerance, mode."""

from __future__ import annotations

import importlib
import json
import pickle
import pkgutil
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import phichain
from phichain import __version__
from phichain.archive import META
from phichain.archive import VALUES as KEPT
from phichain.control import estimator, gain_table, lqr, output_law, regulators
from phichain.emit.law import law_files
from phichain.errors import ArrayError, OutputError
from phichain.motion import simulate
from phichain.orbits import Network, trace
from phichain.records import Valued
from phichain.report.style import save
from phichain.system import Numbers, System
from phichain.system.starts import leaning
from tests.handmade import planar, uniform_planar
from tests.records.samples import RECORDS, VALUES, branch, propagation, trajectory
from tests.report.test_shown_kinds import attraction, connection, mapped, network, orbit, plan

GIVEN = {"gravity": 9.81, "length": [0.3, 0.2]}


def at_run_time(system: System) -> System:
    """The same chain, whose functions are handed runtime parameters."""
    functions: dict[str, Callable[..., Any]] = {name: partial(_passing, call) for name, call in system.functions.items()}
    return replace(system, functions=functions, params=GIVEN, numbers=Numbers(length="runtime"), digest="d9")


def _passing(call: Callable[..., Any], *arguments: Any, p: Mapping[str, Any], **words: Any) -> Any:
    assert set(p) == set(GIVEN)
    return call(*arguments, **words)


CART = at_run_time(planar([0.1, 0.1], [0.3, 0.2], cart_mass=0.5, actuated="cart"))


def kept(path: Path) -> dict[str, Any]:
    """The small fields of an NPZ file, read without the package."""
    with np.load(path) as file:
        found: dict[str, Any] = json.loads(str(file[META]))
    return found


def every_kind() -> Iterator[type]:
    """All classes of results with parameters."""
    for module in pkgutil.walk_packages(phichain.__path__, "phichain."):
        if re.match(r"phichain\.(laws|motion\.trajectory|continuation\.branch|orbits|control|identification\.record|trials)", module.name):
            importlib.import_module(module.name)
    waiting = Valued.__subclasses__()
    while waiting:
        one = waiting.pop()
        waiting += one.__subclasses__()
        yield one


def test_every_kind_of_result_that_has_a_file_keeps_them_in_it() -> None:
    found = {kind for kind in every_kind() if hasattr(kind, "to_npz")}
    assert len(found) > 12
    for kind in found:
        schema = importlib.import_module(kind.__module__)._SCHEMA
        assert schema.fields.get("p") is KEPT, kind
    for name in ("family", "trajectory"):  # laws that have them of the regulator they end with
        assert importlib.import_module(f"phichain.laws.{name}")._SCHEMA.fields["p"] is KEPT


def joined() -> Network:
    """Two families, one of which opens at an event of the other."""
    found = network()
    return replace(found, links=(replace(found.links[0], how="opens"),))


MADE = (trajectory, branch, RECORDS["Gains"], orbit, plan, connection, attraction, mapped, joined)


@pytest.mark.parametrize("made", MADE, ids=lambda made: made.__name__)
def test_files_say_version_scene_and_parameters_and_are_read_back(made: Callable[[], Any], tmp_path: Path) -> None:
    record = replace(made(), p={"mass": [0.4, 0.3], "gravity": 9.81})
    assert record.p == VALUES and pickle.loads(pickle.dumps(record)).p == VALUES
    with pytest.raises(TypeError):
        record.p["gravity"] = 0.0
    values = {"mass": [0.4, 0.3], "gravity": 9.81}
    if hasattr(record, "to_npz"):
        path = record.to_npz(tmp_path / "a.npz")
        assert (kept(path)["phichain"], kept(path)["digest"], kept(path)["p"]) == (__version__, record.digest, values)
        assert type(record).from_npz(path).p == VALUES
    path = record.to_json(tmp_path / "a.json")
    found = json.loads(path.read_text())
    assert (found["phichain"], found["digest"], found["p"]) == (__version__, record.digest, values)
    if hasattr(record, "from_json"):
        assert type(record).from_json(path).p == VALUES
        path.write_text(path.read_text().replace('"gravity": 9.81', '"gravity": "much"'))
        with pytest.raises(OutputError, match="its p holds no numbers by name"):
            type(record).from_json(path)
    if hasattr(record, "to_csv"):
        (meta,) = [json.loads(line[8:]) for line in record.to_csv(tmp_path / "a.csv").read_text().splitlines() if line.startswith("# meta: ")]
        assert (meta["phichain"], meta["digest"], meta["p"]) == (__version__, record.digest, values)


def test_a_table_of_signals_says_its_chain_and_not_the_signals(tmp_path: Path) -> None:
    propagation().to_csv(tmp_path / "a.csv", "psi", 0)
    (line,) = [line for line in (tmp_path / "a.csv").read_text().splitlines() if line.startswith("# meta: ")]
    assert json.loads(line[8:])["params"] == {"mass": [0.4, 0.3], "gravity": 9.81} and "psi" not in line and "forces" not in line


def test_what_runs_with_parameters_says_them() -> None:
    motion = simulate(CART, leaning(CART, 0.1), np.linspace(0, 0.1, 3), tol=1e-6, p={"gravity": 1.62})
    expected = {"gravity": 1.62, "length": (0.3, 0.2)}
    assert motion.p == expected and motion.resample(5).p == expected
    # What the caller does to its own mapping afterwards is no matter of the run.
    mine: dict[str, Any] = {"gravity": 1.62}
    later = simulate(CART, leaning(CART, 0.1), np.linspace(0, 0.1, 3), tol=1e-6, p=mine)
    mine["gravity"] = 0.0
    assert later.p == expected
    link = at_run_time(uniform_planar(1))
    family = trace(replace(link, params={**GIVEN, "length": 0.5}), 1, 0.2, method="one harmonic")
    assert family.p == {"gravity": 9.81, "length": 0.5} and family.tol == 1e-11 and (family.digest, family.mode) == ("d9", 1)


def test_laws_say_what_their_gains_were_made_for_down_to_the_manifest_of_their_c(tmp_path: Path) -> None:
    gains = lqr(CART, sample=0.01)
    expected = {"gravity": 9.81, "length": (0.3, 0.2)}
    laws = (gains.law(), gain_table(regulators(CART, [[-1, -1], [1, 1]], sample=0.01)), output_law(gains, estimator(gains)))
    for law in laws:
        assert law.p == expected == type(law).from_npz(law.to_npz(tmp_path / "law.npz")).p
        assert type(law).from_npz(tmp_path / "law.npz") == law and hash(law) is not None
        files = law_files(law, "double")
        assert json.loads(files["manifest.json"])["p"] == {"gravity": 9.81, "length": [0.3, 0.2]}
        assert "p" not in json.loads(law_files(replace(law, p={}), "double")["manifest.json"])


def test_a_family_is_gone_on_with_at_its_own_parameters_alone() -> None:
    chain = replace(at_run_time(uniform_planar(1)), params={"gravity": 9.81, "length": 0.5})
    begun = trace(chain, 1, 1.0, method="one harmonic", limits={"max_points": 5})
    with pytest.raises(ArrayError, match=r"resume\.p\.gravity: is the gravity of that family, and 1\.62 is given here"):
        trace(chain, 1, 1.0, method="one harmonic", resume=begun, p={"gravity": 1.62})
    each = trace(chain, 1, 1.0, method="one harmonic", resume=begun, p={"length": [0.5]})
    assert len(each) > len(begun), "a list of the same numbers is the same"
    old = replace(begun, p={})
    assert len(trace(chain, 1, 1.0, method="one harmonic", resume=old, p={"gravity": 9.81})) == len(each), "files from before say nothing"


PICTURES: dict[str, Callable[[Path], str]] = {
    ".png": lambda path: str(Image.open(path).info["Description"]),
    ".svg": lambda path: re.search(r"<dc:description>(.*?)</dc:description>", path.read_text(), re.DOTALL)[1].replace("&quot;", '"'),  # type: ignore[index]
    ".pdf": lambda path: re.search(rb"/Subject \((.*?)(?<!\\)\)", path.read_bytes(), re.DOTALL)[1].decode("latin-1").replace("\\", ""),  # type: ignore[index]
    ".gif": lambda path: bytes(Image.open(path).info["comment"]).decode(),
    ".html": lambda path: re.search(r'<script type="application/json" id="origin">(.*?)</script>', path.read_text(), re.DOTALL)[1],  # type: ignore[index]
}
"""Kind of file -> where its reader finds what the picture is of."""


@pytest.mark.long
@pytest.mark.parametrize("kind", PICTURES)
@pytest.mark.parametrize("made", (trajectory, orbit), ids=lambda made: made.__name__)
def test_pictures_say_it_where_their_kind_of_file_has_room(kind: str, made: Callable[[], Any], tmp_path: Path) -> None:
    record = replace(made(), p=VALUES)
    path = tmp_path / f"a{kind}"
    if kind in (".gif", ".html"):
        record.animate(path, **({} if made is orbit else {"seconds": 0.2, "fps": 10}))
    else:
        save(record.plot(), path, dpi=40, of=record)
    said = json.loads(PICTURES[kind](path))
    assert (said["phichain"], said["record"], said["digest"], said["method"]) == (__version__, type(record).__name__, record.digest, record.method)
    assert said["p"] == {"mass": [0.4, 0.3], "gravity": 9.81}
    if kind == ".gif":
        with Image.open(path) as moving:
            moving.seek(moving.n_frames - 1)  # type: ignore[attr-defined]


def test_a_picture_of_several_says_all_and_one_of_nothing_the_version(tmp_path: Path) -> None:
    record = trajectory()
    several = json.loads(PICTURES[".png"](save(record.plot(), tmp_path / "a.png", dpi=40, of=[record, branch()])))
    assert [one["record"] for one in several] == ["Trajectory", "Branch"]
    assert json.loads(PICTURES[".png"](save(record.plot(), tmp_path / "a.png", dpi=40))) == {"phichain": __version__}


def test_named_arrays_say_it_too() -> None:
    said = replace(trajectory(), p=VALUES).to_xarray().attrs
    assert (said["phichain"], said["digest"], said["method"], said["tol"]) == (__version__, "d1", "taylor", 1e-9)
    assert json.loads(said["p"]) == {"mass": [0.4, 0.3], "gravity": 9.81}
    assert all(field.name != "p" or field.kw_only for field in fields(Network))


def test_every_kind_of_result_is_text_for_other_programs(tmp_path: Path) -> None:
    record = trajectory()
    found = json.loads(record.to_json(tmp_path / "a.json").read_text())
    assert (found["kind"], found["phichain"], found["p"]) == ("trajectory", __version__, {"mass": [0.4, 0.3], "gravity": 9.81})
    assert np.array_equal(found["q"], record.q) and found["q_names"] == ["theta_1", "theta_2"] and "refine" not in found
    assert found["events"] == [{"name": "low", "t": 0.5, "x": record.events[0].x.tolist(), "doubtful": True}]
    regulator = RECORDS["Gains"]()
    poles = json.loads(regulator.to_json(tmp_path / "b.json").read_text())["poles"]
    assert [complex(*pair) for pair in poles] == regulator.poles.tolist()
    for other in (plan(), connection(), attraction(), mapped()):
        assert json.loads(other.to_json(tmp_path / "c.json").read_text())["digest"] == "d"
