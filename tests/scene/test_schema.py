"""The table of the keys and the JSON Schema made from it agree with what scenes really are."""

from __future__ import annotations

import inspect
import json
import tomllib
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from phichain import Scene
from phichain.errors import PhichainError
from phichain.scene.described import BY_NAME, KEYS
from phichain.scene.keys import REQUIRED, TABLES
from phichain.scene.library import bundled_scenes
from phichain.scene.load import scene_from_dict
from phichain.scene.schema import scene_schema

VALIDATOR = jsonschema.Draft202012Validator(scene_schema())


def test_the_schema_is_one() -> None:
    jsonschema.Draft202012Validator.check_schema(scene_schema())
    assert json.loads(json.dumps(scene_schema())) == scene_schema()


def test_every_key_has_one_row_and_every_row_a_key() -> None:
    assert [key.name for key in KEYS] == ["name", *(name for keys in TABLES.values() for name in keys)]
    assert all(key.text and key.since for key in KEYS)
    parameters = inspect.signature(Scene.__init__).parameters
    for key in KEYS:
        default = parameters[key.name].default
        assert (key.name in REQUIRED) == (default is inspect.Parameter.empty), key.name
        if key.kind == "choice" and isinstance(default, str):
            assert key.default == default, key.name
        if key.name in ("gravity", "variational"):
            assert key.default == str(default).lower(), key.name


@pytest.mark.parametrize("path", bundled_scenes().values(), ids=lambda path: path.stem)
def test_every_bundled_scene_is_valid(path: Path) -> None:
    tables = tomllib.loads(path.read_text())
    VALIDATOR.validate(tables)
    VALIDATOR.validate(scene_from_dict(tables).to_dict())


def scene(**tables: Any) -> dict[str, Any]:
    whole: dict[str, Any] = {"name": "tried", "chain": {"links": 2, "mass": 1.0, "length": [1.0, 0.5]}}
    for table, keys in tables.items():
        whole[table] = {**whole.get(table, {}), **keys}
    return whole


GOOD = (
    scene(), scene(chain={"mass": "runtime"}), scene(chain={"base": "cart", "cart_mass": 1}), scene(joints={"actuated": [1]}),
    scene(chain={"base": "cart", "drive": "acceleration"}), scene(chain={"space": "spatial"}), scene(chain={"base": "moving", "gravity": -1.0}),
    scene(chain={"inertia": [0.1, 0.0], "com": [0.0, 0.2]}), scene(joints={"stiffness": 2.0, "rest_angle": [0.1, -0.1]}),
    scene(functions={"want": ["propagate", "energy"]}, flow={"variational": True}),
)  # fmt: skip
BAD = (
    {**scene(), "gravity": 9.81}, scene(chain={"mass": 0.0}), scene(chain={"mass": "run"}), scene(chain={"links": 0}), scene(chain={"links": 2.5}),
    scene(chain={"cart_mass": 1.0}), scene(chain={"base": "cart"}), scene(chain={"base": "rail"}), scene(chain={"space": "spatial"}, joints={"angles": "relative"}),
    scene(chain={"space": "spatial"}, joints={"armature": 1.0}), scene(joints={"damping": -1.0}), scene(joints={"actuated": "some"}),
    scene(joints={"actuated": []}), scene(functions={"want": ["forward"]}), scene(flow={"variational": 1}), scene(target={"real": "single"}),
    {"chain": scene()["chain"]}, {"name": "2nd", "chain": scene()["chain"]}, {"name": "no_mass", "chain": {"links": 1, "length": 1.0}},
)  # fmt: skip


@pytest.mark.parametrize("tables", GOOD, ids=str)
def test_what_is_a_scene_is_valid(tables: dict[str, Any]) -> None:
    scene_from_dict(tables)
    assert VALIDATOR.is_valid(tables)


@pytest.mark.parametrize("tables", BAD, ids=str)
def test_what_is_no_scene_is_not_valid(tables: dict[str, Any]) -> None:
    with pytest.raises(PhichainError):
        scene_from_dict(tables)
    assert not VALIDATOR.is_valid(tables)


def test_every_sentence_on_a_key_names_its_choices() -> None:
    for key in KEYS:
        assert all(word in key.holds for word in key.choices)
    assert BY_NAME["mass"].holds.startswith("a number for all links")
