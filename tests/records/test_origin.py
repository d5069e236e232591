"""Every file says where it comes from, and every column of a table its unit."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from phichain import __version__
from phichain.archive import META
from phichain.errors import OutputError
from phichain.motion import Trajectory
from phichain.origin import WROTE
from phichain.reading import read_rows
from phichain.records import write_csv
from phichain.scene.library import find_scene
from phichain.units import unit_of
from tests import tables
from tests.records.samples import RECORDS, trajectory


def above(path: Path) -> tuple[dict[str, Any], dict[str, str]]:
    """`meta` of an ECSV file, and the unit of every column."""
    head = [line[2:] for line in path.read_text().splitlines() if line.startswith("# ")]
    assert head[:4] == ["%ECSV 1.0", "---", 'delimiter: ","', "datatype:"]
    columns = [json.loads(line[2:]) for line in head if line.startswith("- ")]
    meta = json.loads(next(line for line in head if line.startswith("meta: "))[6:])
    assert [column["name"] for column in columns] == tables.lines(path)[0].split(",")
    return meta, {column["name"]: column.get("unit", "") for column in columns}


@pytest.mark.parametrize("kind", ("Trajectory", "Branch", "Gains", "Differintegral"))
def test_a_table_says_version_kind_and_all_texts_and_numbers_of_its_record(kind: str, tmp_path: Path) -> None:
    record = RECORDS[kind]()
    record.to_csv(tmp_path / "a.csv")
    meta, _ = above(tmp_path / "a.csv")
    assert (meta["phichain"], meta["record"]) == (__version__, kind)
    for field, value in vars(record).items():
        if isinstance(value, str | int) and value != "":
            assert meta[field] == value


def test_the_columns_of_a_motion_have_units(tmp_path: Path) -> None:
    _, units = above(trajectory().to_csv(tmp_path / "a.csv"))
    assert units == {
        "t": "s", "theta_1": "rad", "theta_2": "rad", "theta_dot_1": "rad/s", "theta_dot_2": "rad/s", "torque_1": "N m", "kinetic": "J",
        "potential": "J", "error": "",
    }  # fmt: skip


def test_whole_records_say_which_version_wrote_them_and_a_version_that_is_none_is_refused(tmp_path: Path) -> None:
    path = trajectory().to_npz(tmp_path / "a.npz")
    with np.load(path) as file:
        arrays = dict(file)
    meta = json.loads(str(arrays[META]))
    assert meta[WROTE] == __version__
    arrays[META] = np.asarray(json.dumps(meta | {WROTE: 7}))
    np.savez(path, **arrays)
    with pytest.raises(OutputError, match="is no version"):
        Trajectory.from_npz(path)


@pytest.mark.parametrize("scene", ("planar3", "planar3_cart", "paper_b"))
def test_every_state_and_input_has_its_unit(scene: str) -> None:
    chain = find_scene(scene)
    expected = {"x": "m", "theta": "rad", "q": "", "omega": "rad/s", "force": "N", "torque": "N m", "acceleration": "m/s^2"}
    for name in (*chain.q_names, *chain.v_names, *chain.u_names):
        word = name.partition("_")[0]
        assert unit_of(name) == ({"x": "m/s", "theta": "rad/s"}[word] if "_dot" in name else expected[word]), name


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("peak_theta_2", "rad"), ("amplitude_theta_1", "rad"), ("amplitude_x", "m"), ("phase_theta_1", "rad"), ("theta_1_dot_0", "rad/s"),
        ("theta_dot_2_residual", "rad/s"), ("torque_1", "N m"),
        *((name, "") for name in ("phase", "late", "radius", "beyond", "mass_1", "multiplier_1_re", "error", "q_1_3")),
    ],
)  # fmt: skip
def test_a_name_that_means_several_things_has_no_unit(name: str, unit: str) -> None:
    assert unit_of(name) == unit


def test_what_reads_tables_passes_over_the_comments(tmp_path: Path) -> None:
    write_csv(tmp_path / "a.csv", {"t": [0.0, 1.0], "torque_1": [0.5, 0.25]}, trajectory())
    assert read_rows(tmp_path / "a.csv", 10**6) == [["t", "torque_1"], ["0.0", "0.5"], ["1.0", "0.25"]]
