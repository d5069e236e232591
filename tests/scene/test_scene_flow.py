"""The table [flow] of a scene."""

from __future__ import annotations

import pytest

from phichain.errors import SceneError
from phichain.scene import Scene, scene_from_dict

TABLES = {
    "name": "pair",
    "chain": {"links": 2, "mass": 1, "length": 1},
    "functions": {"want": ["forward_dynamics", "propagate"]},
}


def test_variational_equations_are_asked_for_and_survive_the_file() -> None:
    asked = scene_from_dict(TABLES | {"flow": {"variational": True}})
    assert asked.variational
    assert "[flow]\nvariational = true\n" in asked.to_toml()
    assert scene_from_dict(asked.to_dict()) == asked


@pytest.mark.parametrize("flow", [{}, {"variational": False}])
def test_what_is_not_asked_for_leaves_no_trace(flow: dict[str, bool]) -> None:
    silent, absent = scene_from_dict(TABLES | {"flow": flow}), scene_from_dict(TABLES)
    assert silent == absent and silent.digest == absent.digest
    assert "flow" not in silent.to_dict() and not silent.variational


@pytest.mark.parametrize("value", [1, "yes", None, [True]])
def test_only_true_and_false_are_taken(value: object) -> None:
    with pytest.raises(SceneError, match="flow.variational: is neither true nor false"):
        scene_from_dict(TABLES | {"flow": {"variational": value}})


def test_without_the_flow_there_is_nothing_to_differentiate() -> None:
    with pytest.raises(SceneError, match='add "propagate" to want'):
        Scene("pair", 2, mass=1.0, length=1.0, variational=True)


def test_unknown_keys_of_the_table_are_refused() -> None:
    with pytest.raises(SceneError, match='did you mean "variational"'):
        scene_from_dict(TABLES | {"flow": {"variation": True}})
