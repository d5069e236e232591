"""Results that know their chain show themselves: orbits, plans, connections, regions, networks."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from phichain import __version__
from phichain.app.summaries import printed, summary
from phichain.continuation import Special
from phichain.control.reach import Attraction, AttractionMap
from phichain.control.swing_up import Plan
from phichain.errors import ArrayError, OutputError, UnsupportedError
from phichain.identification import Fit
from phichain.orbits import Network, Orbit
from phichain.orbits.connections import Connection
from phichain.orbits.forced.response import Response
from phichain.orbits.network.record import Link
from tests.records.samples import branch

T = np.linspace(0.0, 2.0, 41)
SWING = np.column_stack([0.5 * np.cos(np.pi * T), 0.2 * np.cos(np.pi * T)])
CHAIN: dict[str, Any] = {"lengths": np.array([1.0, 0.5]), "angles": "relative"}


def orbit() -> Orbit:
    kappa = np.array([0.3 + 0j])
    return Orbit(
        "pair", "d", "quarter", 1, "planar", np.pi, 1.5, kappa, np.array([0.3 + 0.95j, 0.3 - 0.95j]), 1e-12, 1e-14, T, SWING, -SWING,
        ("theta_1", "theta_2"), ("theta_dot_1", "theta_dot_2"), **CHAIN,
    )  # fmt: skip


def plan() -> Plan:
    x = np.column_stack([0.1 * np.sin(T), np.pi * T / 2, 0.1 * np.cos(T), np.full(41, np.pi / 2)])
    return Plan(
        "pole", "d", T, x, np.sin(T[:-1])[:, None], ("x", "theta_1", "x_dot", "theta_dot_1"), ("force",), (1,), (-1,), np.array([2.0]), 0.5,
        0.05, "none", True, 3, 1.0, 0.0, 0.0, lengths=np.array([0.0, 0.7]), angles="relative",
    )  # fmt: skip


def connection() -> Connection:
    turned = np.column_stack([np.pi + np.pi * np.tanh(3 * T - 3), 0 * T])
    return Connection(
        "pair", "d", (-1, -1), (1, 1), T - 1, turned, 0 * turned, np.ones(2), np.ones(2) / np.sqrt(2), 1e-15, 1e-13, 0.0, 0.4,
        ("theta_1", "theta_2"), ("theta_dot_1", "theta_dot_2"), **CHAIN,
    )  # fmt: skip


def attraction() -> Attraction:
    one, two = np.ones(2), np.array([[1, 1], [-1, -1]])
    return Attraction("pair", "d", two, np.array([1.2, 0.03]), one, np.array([1.2, 0.03]), np.eye(2), np.zeros(2, int), 20, 20, np.zeros(2, int), one, np.ones(2, int), 15.0, 1e-3, 0)


def mapped() -> AttractionMap:
    axis = np.linspace(-0.1, 0.1, 5)
    return AttractionMap("pair", "d", (1, 1), ("xi_1", "xi_2"), axis, np.ones((5, 5), int), np.ones((5, 5)), 15.0)


def network() -> Network:
    found = replace(
        branch(), name="pair, mode 1", names=("theta_1", "theta_2", "omega"), energy=np.array([0.1, 0.2, 0.3]), closing="quarter", points=np.arange(1.0, 10.0).reshape(3, 3),
    )  # fmt: skip
    found = replace(found, events=(Special("period doubling", 1, found.points[1], 0.5, 1e-12, found.multipliers[0]),))
    return Network("pair", (found, found), (Link(0, 0, "period doubling", 1, "followed"),), "whole", "all followed")


@pytest.mark.parametrize("made", (orbit, plan, connection, attraction, mapped, network), ids=lambda made: made.__name__)
def test_it_draws_itself_and_shows_itself_in_a_notebook(made: Any) -> None:
    record = made()
    drawing = record.plot()
    assert drawing.axes and all(axes.get_xlabel() or axes.get_ylabel() or axes.lines or axes.patches or axes.collections for axes in drawing.axes)
    shown = record._repr_html_()
    assert "data:image/png;base64," in shown and str(record).split("\n")[0][:10] in shown.replace("&#x27;", "'")
    assert repr(record).startswith(f"<{type(record).__name__} ") and "array(" not in repr(record)


@pytest.mark.parametrize("made", (orbit, plan), ids=lambda made: made.__name__)
def test_axes_of_ones_own_get_the_links(made: Any) -> None:
    from matplotlib.figure import Figure

    axes = Figure().subplots()
    assert made().plot(ax=axes) is axes and len(axes.lines) >= 1


@pytest.mark.parametrize("made", (connection, attraction, mapped, network), ids=lambda made: made.__name__)
def test_what_has_several_panels_takes_no_axes(made: Any) -> None:
    with pytest.raises(UnsupportedError, match="several panels"):
        made().plot(ax=object())


@pytest.mark.parametrize("made", (orbit, plan, connection), ids=lambda made: made.__name__)
def test_it_moves(made: Any, tmp_path: Path) -> None:
    assert made().animate(tmp_path / "a.gif", **({} if made is orbit else {"seconds": 0.5, "fps": 8})).read_bytes()[:3] == b"GIF"


def test_an_orbit_plays_at_a_pace_of_ones_own_too(tmp_path: Path) -> None:
    assert "<script" in orbit().animate(tmp_path / "a.html").read_text()
    assert orbit().animate(tmp_path / "b.gif", seconds=0.5, fps=6).stat().st_size > 1000


@pytest.mark.parametrize("made", (orbit, plan, connection), ids=lambda made: made.__name__)
def test_how_it_is_drawn_survives_its_file(made: Any, tmp_path: Path) -> None:
    record = made()
    back = type(record).from_npz(record.to_npz(tmp_path / "a.npz"))
    assert np.array_equal(back.lengths, record.lengths) and back.angles == "relative"
    bare = replace(record, lengths=None, angles="")
    back = type(record).from_npz(bare.to_npz(tmp_path / "b.npz"))
    assert back.lengths is None
    with pytest.raises(ArrayError, match="is not known of this"):
        back.plot()
    assert "<img" not in back._repr_html_(), "a notebook shows the words"


def test_json_of_an_orbit_keeps_how_it_is_drawn_and_is_not_believed(tmp_path: Path) -> None:
    path = orbit().to_json(tmp_path / "a.json")
    back = Orbit.from_json(path)
    assert np.array_equal(back.lengths, CHAIN["lengths"]) and back.angles == "relative"
    for old, new in (('"relative"', '"sideways"'), ("1.0,\n  0.5\n ]", "1.0\n ]")):
        text = path.read_text()
        assert old in text
        (tmp_path / "b.json").write_text(text.replace(old, new))
        with pytest.raises(OutputError, match="its angles are|its lengths do not fit"):
            Orbit.from_json(tmp_path / "b.json")


def test_an_orbit_has_named_axes() -> None:
    data = orbit().to_xarray()
    assert data["q"].dims == ("t", "q_name") and data.attrs["omega"] == np.pi and data["t"].attrs["units"] == "s"


def test_every_kind_of_result_has_named_axes_and_says_where_it_comes_from() -> None:
    swing = plan().to_xarray()
    assert swing["x"].sel(state="theta_1").values.tolist() == plan().x[:, 1].tolist() and swing["u"].sel(input="force")[-1] == plan().u[-1, 0]
    assert connection().to_xarray()["q"].sel(q_name="theta_2").values.tolist() == connection().q[:, 1].tolist()
    region = mapped().to_xarray()
    assert region["verdict"].dims == ("xi_2", "xi_1") and region["xi_1"].values.tolist() == mapped().axis.tolist()
    assert attraction().to_xarray()["s"].values.tolist() == [[1, 1], [-1, -1]]
    tree = network().to_xarray()
    assert np.array_equal(tree["branch_1"]["omega"], network().branches[1].column("omega")) and json.loads(tree.attrs["links"])["0"]["to"] == 1
    line = np.arange(3.0)
    column = line[:, None]
    answer = Response(
        "driven", "pair", "d", "1", "joint 1", "N m", 0.1, "shooting", ("theta_1",), line + 1, column, column, column + 2, column + 1j, np.ones((3, 2)), line,
        line, line, (), "points", "as asked",
    )  # fmt: skip
    assert answer.to_xarray()["peak"].sel(name="theta_1").values.tolist() == [2, 3, 4] and answer.to_xarray()["omega"].attrs["units"] == "rad/s"
    square = np.eye(2)
    fit = Fit(
        "pair", "d", ("gravity", "theta_1(0)"), 1, line[:2], line[:2], square, square, line[:2], line[:2], ("theta_1",), line, column, column - 1, line[:1],
        "taylor", 3, 0.1, p={"gravity": 9.8},
    )  # fmt: skip
    assert fit.to_xarray()["residual"].sel(column="theta_1").values.tolist() == [1, 1, 1] and fit.to_xarray()["values"].sel(unknown="theta_1(0)") == 1
    for record in (plan(), connection(), mapped(), attraction(), network(), answer, fit):
        said = record.to_xarray().attrs
        assert (said["phichain"], said["record"], said["name"]) == (__version__, type(record).__name__, record.name)


@pytest.mark.parametrize("made", (orbit, connection, attraction, mapped, network), ids=lambda made: made.__name__)
def test_programs_get_it_as_one_line_of_json(made: Any) -> None:
    record = made()
    line = printed(summary(record))
    found = json.loads(line)
    assert "\n" not in line and (found["record"], found["phichain"]) == (type(record).__name__, __version__)
    expected = {
        "Orbit": ("period", 2.0), "Connection": ("turns", [1, 1]), "AttractionMap": ("home", 1.0), "Network": ("status", "whole"),
        "Attraction": ("equilibria", [
            {"s": s, "radius": radius, "beyond": 1.0, "usual": radius, "failed": 0, "share": 1.0, "runs": 1} for s, radius in (([1, 1], 1.2), ([-1, -1], 0.03))
        ]),
    }  # fmt: skip
    name, value = expected[type(record).__name__]
    assert found[name] == value
