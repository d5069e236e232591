"""Points of files, which count from 1 wherever a text names them: as a start of a family, of a run in a parameter, and as an orbit."""

from __future__ import annotations

from pathlib import Path

import pytest

from phichain.continuation import Branch
from phichain.errors import ArrayError, OutputError
from phichain.orbits import pick, trace
from phichain.orbits.closed.start import given
from phichain.orbits.parameter.starting import started
from phichain.orbits.whirling.starts import given_family
from tests.orbits.shot import uniform


def test_points_of_files_count_from_one(tmp_path: Path) -> None:
    system = uniform(1)
    branch = trace(system, 1, until="theta_1=0.2")
    assert isinstance(branch, Branch)
    branch.to_json(tmp_path / "f.json")
    for number, index in (("1", 0), ("3", 2), (str(len(branch)), -1), ("-1", -1)):
        z = branch.points[index]
        q, _, omega = given(system, f"{tmp_path / 'f.json'}:{number}")
        assert (*q, omega) == tuple(z)
        assert tuple(started(system, f"{tmp_path / 'f.json'}:{number}", None, {})[1]) == pytest.approx(tuple(z))
        assert given_family(f"{tmp_path / 'f.json'}:{number}", ("shooting",))[1] in (index, index + len(branch))
        if number != "-1":
            assert pick(system, branch, f"point={number}").omega == pytest.approx(omega, rel=1e-12)
    for start in (given, lambda system, start: started(system, start, None, {}), lambda system, start: given_family(start)):
        with pytest.raises(ArrayError, match="count points from 1"):
            start(system, f"{tmp_path / 'f.json'}:0")
        for no_place in ("--1", "²", "1-"):
            with pytest.raises(OutputError, match=r"f\.json:"):
                start(system, f"{tmp_path / 'f.json'}:{no_place}")
