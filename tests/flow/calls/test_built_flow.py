"""The flow from a scene's wish to `simulate`: generated, compiled, loaded, chosen."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from phichain.emit.left_out import OTHERS
from phichain.emit.selftest.flow import exact_motion
from phichain.errors import UnsupportedError
from phichain.files import MANIFEST
from phichain.motion import simulate
from phichain.pipeline import build, generate
from phichain.scene import Scene, scene_from_dict


def chain(*want: str, **more: Any) -> Scene:
    table = {"links": 2, "mass": 0.5, "length": 0.5, "com": 0.25, **more}
    return scene_from_dict({"name": "built", "chain": table, "functions": {"want": list(want)}})


def test_a_folder_of_the_flow_alone_holds_nothing_else(tmp_path: Path) -> None:
    folder = generate(chain("propagate"), tmp_path)
    assert not (folder / "built_casadi.py").exists()
    record = json.loads((folder / MANIFEST).read_text())
    assert record["functions"] == {} and list(record["flows"]) == ["propagate"]
    code = (folder / "built.c").read_text()
    assert code.count("\nvoid ") == 0 and "built_propagate(" in code
    with pytest.raises(UnsupportedError, match="holds nothing that CasADi could call"):
        generate(chain("propagate"), tmp_path, with_casadi_c=True)


def test_the_flow_is_left_out_unless_wanted(tmp_path: Path) -> None:
    folder = generate(chain("forward_dynamics"), tmp_path)
    for file in ("built.h", "built.c"):
        assert "propagate" not in (folder / file).read_text()
    assert json.loads((folder / MANIFEST).read_text())["left_out"]["other functions"] == OTHERS


def test_auto_takes_the_flow_and_says_so() -> None:
    scene = chain("forward_dynamics", "energy", "propagate")
    inputs = {"q": [0.4, -0.2], "v": [0.5, 1.0]}
    exact = exact_motion(scene, {}, inputs, 0.015625)
    assert exact is not None
    run = simulate(build(scene), (inputs["q"], inputs["v"]), [0.0, 0.01, 0.015625], tol=1e-13)
    assert run.method == "taylor" and "auto took taylor" in run.reason
    assert np.max(np.abs(run.q[-1] - np.array(exact["q"], dtype=float))) < 2e-16
    assert np.max(np.abs(run.v[-1] - np.array(exact["v"], dtype=float))) < 1e-15
    assert run.counts["order"] > 10


def test_runtime_parameters_reach_the_flow() -> None:
    system = build(chain("forward_dynamics", "energy", "propagate", mass="runtime"))
    start, p = ([0.4, -0.2], [0.5, 1.0]), {"mass": [0.3, 0.9]}
    taylor, other = (
        simulate(system, start, [0.0, 2.0], method=name, tol=1e-12, p=p) for name in ("taylor", "DOP853")
    )
    assert np.max(np.abs(taylor.q[-1] - other.q[-1])) < 1e-9


def test_a_tolerance_below_round_off_is_raised_and_said() -> None:
    run = simulate(
        build(chain("forward_dynamics", "propagate")), np.array([0.1, 0.0, 0.0, 0.0]), 1.0, "taylor", 1e-30
    )
    assert "was raised to 2.2e-16, the round-off floor of taylor" in run.reason
