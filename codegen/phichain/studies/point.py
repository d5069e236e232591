"""One point of a study: what the values of its axes make of the scene, the parameters and the options, and the key of that."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from phichain._version import __version__
from phichain.contract.words import nearest
from phichain.errors import StudyError
from phichain.scene.keys import PARAMETERS, PER_LINK, TABLES, label
from phichain.scene.load import scene_from_dict, with_functions
from phichain.scene.scene import Scene
from phichain.studies.axis import Value
from phichain.studies.task import task_of

KEY_SIZE: Final = 32
"""Bytes of a key."""
_FORMAT: Final = "phichain study point 1"
_KEY: Final = re.compile(r"(?:(\w+)\.)?(\w+)(?:\[([1-9]\d{0,6})\])?")
_SCENE_KEYS: Final = {key: table for table, keys in TABLES.items() if table not in ("functions", "flow") for key in keys}


@dataclass(frozen=True)
class Place:
    """What an axis varies.

    Prints as its key in full: `chain.mass[2]`, `task.tol`.

    Attributes:
        kind: "scene" (a new chain for every value), "parameter" (of run time) or "option" (of the task).
        name: The key, parameter or option.
        entry: Which entry of its list, counted from 0; None for all of it.
    """

    kind: str
    name: str
    entry: int | None

    def __str__(self) -> str:
        whole = f"task.{self.name}" if self.kind == "option" else label(self.name)
        return whole if self.entry is None else f"{whole}[{self.entry + 1}]"


@dataclass(frozen=True)
class Base:
    """What a study holds fast: the chain, the task with its options, and the values of runtime parameters.

    Attributes:
        scene: The chain.
        task: Name of the task.
        options: Its options, defaults filled in.
        parameters: Values of runtime parameters, by name.
    """

    scene: Scene
    task: str
    options: Mapping[str, Any]
    parameters: Mapping[str, Any]

    def place(self, key: str) -> Place:
        """What a key of an axis means here.

        Raises:
            StudyError: It means nothing: no scene key, parameter or option has that name, or it has no such entry.
        """
        match = _KEY.fullmatch(key)
        table, name, entry = match.groups() if match else (None, key, None)
        index = None if entry is None else int(entry) - 1
        if table == "task":
            task_of(self.task).checked({name: self.options.get(name)})
            self._demand_entry(key, index, self.options.get(name))
            return Place("option", name, index)
        if name not in _SCENE_KEYS or table not in (None, _SCENE_KEYS[name]):
            raise _unknown(key, name, self.task)
        is_runtime = name in PARAMETERS and getattr(self.scene, name) == "runtime"
        kept = self.parameters.get(name) if is_runtime else getattr(self.scene, name)
        if index is not None and is_runtime and kept is not None and not isinstance(kept, list):
            kept = [kept] * self.scene.links
        self._demand_entry(key, index, kept)
        return Place("parameter" if is_runtime else "scene", name, index)

    def _demand_entry(self, key: str, index: int | None, kept: Any) -> None:
        if index is None:
            return
        if not isinstance(kept, list | tuple):
            raise StudyError("study", key, "varies one entry of what is no list here", "give the whole list first, or leave the [k] out")
        if index >= len(kept):
            raise StudyError("study", key, f"has no such entry: the list holds {len(kept)}", f"use [1] to [{len(kept)}]")


@dataclass(frozen=True)
class Point:
    """What one task computes.

    Attributes:
        scene: The chain, with the functions that the task calls.
        digest: Its digest.
        parameters: Values of its runtime parameters, or None where it has none.
        options: Options of the task.
        key: SHA-256 over all that and the version.
    """

    scene: Scene
    digest: str
    parameters: dict[str, Any] | None
    options: dict[str, Any]
    key: bytes


class Resolver:
    """Makes points of a study from the values of its axes; chains that it has met before it does not make again."""

    def __init__(self, base: Base, keys: tuple[str, ...]) -> None:
        """Take what the study holds fast, and what varies.

        Raises:
            StudyError: A key means nothing.
        """
        self.base, self.task = base, task_of(base.task)
        self.places = [base.place(key) for key in keys]
        self._of_scene = [k for k, place in enumerate(self.places) if place.kind == "scene"]
        self._others = [k for k, place in enumerate(self.places) if place.kind != "scene"]
        self._scenes: dict[tuple[Value, ...], tuple[Scene, str, str]] = {}

    def __call__(self, values: tuple[Value, ...]) -> Point:
        """The point where the axes have these values, in the order of the keys.

        Raises:
            PhichainError: They make no chain, or an option is none that it could be.
        """
        scene, digest, prefix = self.scene(tuple(values[k] for k in self._of_scene))
        parameters = {name: _spread(name, value, scene.links) for name, value in self.base.parameters.items()}
        options = dict(self.base.options)
        for k in self._others:
            place, value = self.places[k], values[k]
            if place.kind == "option":
                options[place.name] = self.task.one(place.name, _with_entry(options[place.name], place.entry, value))
            else:
                kept = _spread(place.name, parameters.get(place.name), scene.links)
                parameters[place.name] = _spread(place.name, _with_entry(kept, place.entry, float(value)), scene.links)
        said = json.dumps([parameters, options], sort_keys=True)
        return Point(scene, digest, parameters or None, options, hashlib.sha256(f"{prefix} {said}".encode()).digest())

    def scene(self, values: tuple[Value, ...]) -> tuple[Scene, str, str]:
        """The chain for the values of those axes that make one, its digest, and what a key begins with."""
        if values not in self._scenes:
            tables = self.base.scene.to_dict()
            for k, value in zip(self._of_scene, values, strict=True):
                place = self.places[k]
                table = tables.setdefault(_SCENE_KEYS[place.name], {})
                if place.name == "links":
                    _let_go(tables)
                table[place.name] = _with_entry(table.get(place.name), place.entry, value)
            varied = scene_from_dict(tables) if values else self.base.scene
            needed = with_functions(varied, self.task.needs(varied, self.base.options), self.task.is_variational)
            digest = needed.digest
            self._scenes[values] = needed, digest, f"{_FORMAT} {__version__} {self.task.name} {digest}"
        return self._scenes[values]


def _with_entry(kept: Any, entry: int | None, value: Any) -> Any:
    """A value, or the list that it is one entry of."""
    if entry is None:
        return value
    return [*kept[:entry], value, *kept[entry + 1 :]]


def _spread(name: str, value: Any, links: int) -> Any:
    """A runtime value: one number is meant for all links, as in a scene file."""
    return [value] * links if name in PER_LINK and isinstance(value, int | float) else value


def _let_go(tables: dict[str, Any]) -> None:
    """Lists of equal numbers as that number, which is meant for any number of links."""
    for table in tables.values():
        if isinstance(table, dict):
            for key, value in table.items():
                if key in PER_LINK and isinstance(value, list) and len(set(value)) == 1:
                    table[key] = value[0]


def _unknown(key: str, name: str, task: str) -> StudyError:
    options = [f"task.{option}" for option in task_of(task).options]
    known = [label(known) for known in _SCENE_KEYS] + options
    near = nearest(key, known) or nearest(f"task.{name}", options) or (nearest(name, _SCENE_KEYS) and label(str(nearest(name, _SCENE_KEYS))))
    if name in _SCENE_KEYS:
        near = label(name)
    guess = f'did you mean "{near}"? ' if near else ""
    return StudyError("study", key, "is no key of a scene and no option of the task", f"{guess}write chain.mass, joints.damping[2] or {options[0]}")
