"""Where scenes come from: files, tables, and the paper's standard chain."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from os import PathLike
from typing import Any

from phichain.contract.functions import PLANAR_FUNCTIONS
from phichain.errors import SceneError
from phichain.scene.checks.validate import link_count
from phichain.scene.keys import flatten
from phichain.scene.scene import Scene
from phichain.scene.toml import read_toml


def load_scene(path: str | PathLike[str]) -> Scene:
    """Read a scene from a TOML file.

    Raises:
        SceneError: The file cannot be read, is no TOML, or describes no valid scene.
        UnsupportedError: A wanted function does not exist for such a scene.
    """
    return scene_from_dict(read_toml(path))


def given_scene(value: object) -> Scene:
    """Return a scene that a caller handed over, or say what he must do to what is none.

    Raises:
        SceneError: It is no `Scene`, such as the path of a scene file.
    """
    if isinstance(value, Scene):
        return value
    raise SceneError("scene", value, "is not a Scene", "load a file with load_scene(path), or make a Scene")


def scene_from_dict(tables: Mapping[str, Any]) -> Scene:
    """Make a scene from nested tables such as `Scene.to_dict` and a TOML file hold.

    Raises:
        SceneError: A table, key or value is not valid.
        UnsupportedError: A wanted function does not exist for such a scene.
    """
    return Scene(**flatten(tables))


def with_functions(scene: Scene, functions: Iterable[str], variational: bool = False) -> Scene:
    """The same chain with more functions wanted, and its flow carrying derivatives along where that is asked.

    Raises:
        UnsupportedError: A function does not exist for such a scene.
    """
    tables = scene.to_dict()
    tables["functions"] = {"want": sorted({*scene.want, *functions})}
    if variational:
        tables["flow"] = {"variational": True}
    return scene_from_dict(tables)


def standard_scene(links: int) -> Scene:
    """Return paper A's chain of N links: m = l = 1/N, com = l/2, relative angles, a torque at every joint.

    It is the scene of `make generate N=...`, with every planar function wanted.

    Raises:
        SceneError: `links` is not a whole number from 1 to 4096.
    """
    links = link_count(links)
    return Scene(
        f"planar{links}",
        links,
        mass=1.0 / links,
        length=1.0 / links,
        com=0.5 / links,
        actuated="all",
        want=PLANAR_FUNCTIONS,
    )
