"""A JSON Schema of the scene file, from the table of its keys, by which editors complete and check one while it is written.

It knows keys, kinds, signs, choices and which keys belong together. What needs the numbers themselves, such as a list's length or a centre of mass
beyond its link, is said by `load_scene`.
"""

from __future__ import annotations

from typing import Any, Final

from phichain.contract.functions import ROWS
from phichain.scene.checks.name import LONGEST_NAME
from phichain.scene.checks.validate import MOST_LINKS, RUNTIME
from phichain.scene.described import BY_NAME, KEYS, Key
from phichain.scene.keys import PARAMETERS, REQUIRED, TABLES

DIALECT: Final = "https://json-schema.org/draft/2020-12/schema"


def scene_schema() -> dict[str, Any]:
    """The schema of a scene file, as nested tables for JSON."""
    tables = {table: _table(table) for table in TABLES}
    required = sorted({"name", *(table for table in TABLES if set(REQUIRED) & set(TABLES[table]))})
    return {
        "$schema": DIALECT,
        "title": "phichain scene",
        "description": "A chain of links under gravity: which one, and which functions of it are wanted.",
        "type": "object",
        "properties": {"name": _key(BY_NAME["name"]), **tables},
        "required": required,
        "additionalProperties": False,
        "allOf": [_belongs(key) for key in KEYS if key.only] + [_cart_mass()],
    }


def _table(table: str) -> dict[str, Any]:
    keys = [BY_NAME[name] for name in TABLES[table]]
    found: dict[str, Any] = {"type": "object", "properties": {key.name: _key(key) for key in keys}, "additionalProperties": False}
    required = [name for name in REQUIRED if name in TABLES[table]]
    return found | ({"required": required} if required else {})


def _key(key: Key) -> dict[str, Any]:
    text = key.text + (f", {key.unit}" if key.unit else "") + (f"; {key.default} unless given" if key.default else "")
    return {"description": text, **_value(key)}


def _value(key: Key) -> dict[str, Any]:
    """What a key may hold."""
    match key.kind:
        case "name":
            return {"type": "string", "pattern": "^[A-Za-z][A-Za-z0-9_]*$", "maxLength": LONGEST_NAME}
        case "count":
            return {"type": "integer", "minimum": 1, "maximum": key.most}
        case "place":
            return {"anyOf": [{"enum": list(key.choices)}, {"type": "integer", "minimum": 1, "maximum": MOST_LINKS}]}
        case "choice":
            return {"enum": list(key.choices)}
        case "derivatives":
            names = ["state", "forcing", *PARAMETERS]
            return {"anyOf": [{"type": "boolean"}, {"type": "array", "items": {"enum": names}, "minItems": 1, "uniqueItems": True}]}
        case "functions":
            return {"type": "array", "items": {"enum": list(ROWS)}, "minItems": 1}
        case "joints":
            joint = {"type": "integer", "minimum": 1, "maximum": MOST_LINKS}
            return {"anyOf": [{"enum": list(key.choices)}, {"type": "array", "items": joint, "minItems": 1, "uniqueItems": True}]}
        case _:
            return _number(key)


def _number(key: Key) -> dict[str, Any]:
    """A number, where it is the links' a list of them, and where it is a parameter the word for run time."""
    bounds = {"above zero": {"exclusiveMinimum": 0}, "zero or more": {"minimum": 0}, "any": {}}[key.sign]
    if key.name == "com":
        bounds = {"minimum": 0}  # a link with inertia may have its centre of mass at its joint
    number = {"type": "number", **bounds}
    if key.kind == "number":
        return number
    lists = [{"type": "array", "items": number, "minItems": 1, "maxItems": MOST_LINKS}] if key.is_per_link else []
    return {"anyOf": [number, *lists, {"const": RUNTIME}]}


def _home(name: str) -> str:
    return next(table for table, keys in TABLES.items() if name in keys)


def _has(name: str) -> dict[str, Any]:
    """A scene that has a key."""
    table = _home(name)
    return {"required": [table], "properties": {table: {"type": "object", "required": [name]}}}


def _is(name: str, word: str) -> dict[str, Any]:
    """A scene in which a key is a word, said or left out where that is its default."""
    table, said = _home(name), {"properties": {name: {"const": word}}}
    if BY_NAME[name].default == word:
        return {"properties": {table: said}}
    return {"required": [table], "properties": {table: {**said, "required": [name]}}}


def _belongs(key: Key) -> dict[str, Any]:
    """Whoever has the key has what it belongs to."""
    return {"if": _has(key.name), "then": {"allOf": [_is(name, word) for name, word in key.only]}}


def _cart_mass() -> dict[str, Any]:
    """A cart has a mass, unless its acceleration is what drives it."""
    cart = {"allOf": [_is("base", "cart"), {"not": _is("drive", "acceleration")}]}
    return {"if": cart, "then": _has("cart_mass")}
