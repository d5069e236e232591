"""One link whose gravity is open until run time: the smallest scene that has everything a study varies."""

from __future__ import annotations

from typing import Any

import pytest

from phichain import Scene

SCENE = Scene("studied", 1, mass=1.0, length=1.0, gravity="runtime", want=("forward_dynamics", "energy"))


def tables(**changes: Any) -> dict[str, Any]:
    """A study of six tasks, with some of its tables changed."""
    return {
        "name": "six", "scene": SCENE, "task": {"run": "simulate", "t": 0.5, "tol": 1e-8, "error_estimate": False},
        "parameters": {"gravity": 9.81}, "grid": {"gravity": [9.81, 1.62], "task.lean": [0.1, 0.2, 0.3]}, **changes,
    }  # fmt: skip


@pytest.fixture(autouse=True)
def own_folder(tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """What a study writes without being told where goes into the test's folder."""
    monkeypatch.chdir(tmp_path)
