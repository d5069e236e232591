"""The file of a study: TOML tables in, a Plan out, every slip one sentence."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike, fspath
from pathlib import Path
from typing import Any, Final

from phichain.contract.words import nearest
from phichain.errors import SceneError, StudyError
from phichain.scene.library import find_scene
from phichain.scene.load import scene_from_dict
from phichain.scene.scene import Scene
from phichain.scene.toml import read_toml
from phichain.studies.axis import MOST_VALUES, Axis, drawn_axis, grid_axis, sobol
from phichain.studies.plan import Plan
from phichain.studies.point import Base
from phichain.studies.task import count, task_of
from phichain.system.arrays import whole

_TABLES: Final = ("name", "scene", "task", "parameters", "grid", "samples")
LONGEST_NAME: Final = 80
_OF_SAMPLES: Final = ("count", "seed", "method")


def load_plan(path: str | PathLike[str]) -> Plan:
    """Read a study from a TOML file; a scene's file is looked for beside it.

    Raises:
        StudyError: The file describes no study.
        SceneError: It cannot be read, is no TOML, or its scene is none.
    """
    try:
        tables = read_toml(path)
    except SceneError as refusal:
        raise StudyError("study file", refusal.value, refusal.problem, refusal.remedy) from refusal
    return plan_of(tables, Path(fspath(path)).parent)


def plan_of(tables: Mapping[str, Any], folder: Path | None = None) -> Plan:
    """Make a study from nested tables, such as its TOML file holds.

    Args:
        tables: name, scene (a Scene, a word as on the command line, a file or tables), task, parameters, grid, samples.
        folder: Where a scene's file is looked for; the working folder unless given.

    Raises:
        StudyError: A table, key or value is not valid.
        SceneError: The scene is none.
    """
    if not isinstance(tables, Mapping):
        raise StudyError("study", tables, "is no table", "give a file, or a mapping of the study's tables")
    for key, value in tables.items():
        if key not in _TABLES:
            near = nearest(str(key), _TABLES)
            guess = f'did you mean "{near}"? The' if near else "the"
            raise StudyError(str(key), value, "is not a key of a study", f"{guess} keys are {', '.join(_TABLES)}")
    if "scene" not in tables:
        raise StudyError("scene", None, "is missing", 'name one, such as scene = "planar4"')
    scene = _scene(tables["scene"], folder)
    given = _table(tables, "task")
    if "run" not in given:
        raise StudyError("task.run", None, "is missing", 'say what to do at every point, such as run = "simulate" in [task]')
    task = task_of(given["run"])
    options = task.checked({name: value for name, value in given.items() if name != "run"})
    base = Base(scene, task.name, options, _parameters(scene, _table(tables, "parameters")))
    grid = tuple(grid_axis(str(base.place(key)), value) for key, value in _flat(_table(tables, "grid")).items())
    drawn = _flat(_table(tables, "samples"))
    samples = _samples({key if key in _OF_SAMPLES else str(base.place(key)): value for key, value in drawn.items()})
    axes = [axis.key for axis in (*grid, *samples)]
    if len(set(axes)) < len(axes):
        raise StudyError("study", ", ".join(axes), "varies a key twice", "let one axis vary it")
    document = {**tables, "scene": scene.to_dict(), "grid": {axis.key: list(axis.values) for axis in grid}}
    plan = Plan(_name(tables.get("name", "study")), base, grid, samples, document)
    _demand_parameters(plan)
    return plan


def _scene(given: Any, folder: Path | None) -> Scene:
    if isinstance(given, Scene):
        return given
    if isinstance(given, Mapping):
        return scene_from_dict(given)
    if not isinstance(given, str):
        raise StudyError("scene", given, "names no scene", 'write a file, a bundled scene or planarN, such as scene = "planar4"')
    beside = None if folder is None else folder / given
    return find_scene(str(beside) if beside is not None and beside.is_file() else given)


def _name(given: Any) -> str:
    if not isinstance(given, str) or not given.strip() or len(given) > LONGEST_NAME or not given.isprintable():
        raise StudyError("name", given, "is no name of a study", f"use a few words of at most {LONGEST_NAME} characters")
    return given


def _table(tables: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    entries = tables.get(name, {})
    if not isinstance(entries, Mapping):
        raise StudyError(name, entries, "is no table", f"write [{name}] and its keys below it")
    return entries


def _flat(tables: Mapping[str, Any]) -> dict[str, Any]:
    """Keys of axes: `chain.mass` may be one quoted word or a key of a table."""
    found: dict[str, Any] = {}
    for key, value in tables.items():
        if key in ("chain", "joints", "target", "task") and isinstance(value, Mapping):
            found |= {f"{key}.{name}": entry for name, entry in value.items()}
        else:
            found[key] = value
    return found


def _samples(given: dict[str, Any]) -> tuple[Axis, ...]:
    axes = {key: value for key, value in given.items() if key not in _OF_SAMPLES}
    if not given:
        return ()
    if not axes:
        raise StudyError("samples", list(given), "vary nothing", "name what is drawn, such as chain.mass = {low = 1, high = 2}")
    if "count" not in given:
        raise StudyError("samples.count", None, "is missing", "say how many samples")
    number = count(1, MOST_VALUES)("samples.count", given["count"])
    seed = whole("samples.seed", given.get("seed", 0), 0, 2**63 - 1, "use a whole number from 0 on", StudyError)
    method = given.get("method", "random")
    if method not in ("random", "sobol"):
        raise StudyError("samples.method", method, "is no way to draw", 'use "random" or "sobol"')
    places = sobol(len(axes), number, seed).T if method == "sobol" else [None] * len(axes)
    return tuple(drawn_axis(key, value, number, seed, unit) for (key, value), unit in zip(axes.items(), places, strict=True))


def _parameters(scene: Scene, given: Mapping[str, Any]) -> dict[str, Any]:
    shapes = scene.runtime_shapes
    found: dict[str, Any] = {}
    for name, value in given.items():
        if name not in shapes:
            remedy = f"its runtime parameters are {', '.join(shapes)}" if shapes else "remove it: the scene has none"
            raise StudyError(f"parameters.{name}", value, "is no runtime parameter of the scene", remedy)
        entries = value if isinstance(value, list | tuple) else [value]
        if any(isinstance(entry, bool) or not isinstance(entry, int | float) for entry in entries):
            raise StudyError(f"parameters.{name}", value, "does not hold numbers", "give a number, or a list of one per link")
        found[name] = [float(entry) for entry in entries] if isinstance(value, list | tuple) else float(value)
    return found


def _demand_parameters(plan: Plan) -> None:
    """Refuse a study that leaves a runtime parameter without a value, or gives it a word."""
    for axis, place in zip((*plan.grid, *plan.samples), plan.resolver.places, strict=True):
        if place.kind == "parameter" and not axis.is_number:
            raise StudyError(axis.key, list(axis.values), "does not hold numbers alone", "use numbers")
    varied = {place.name for place in plan.resolver.places if place.kind == "parameter" and place.entry is None}
    for name in plan.base.scene.runtime_shapes:
        if name not in plan.base.parameters and name not in varied:
            raise StudyError(f"parameters.{name}", None, "has no value", f"give it in [parameters], or vary {name} in the grid")
