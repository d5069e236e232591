"""The keys of a scene: which table of the TOML file holds which key, and how an error names them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from phichain.contract.words import nearest
from phichain.errors import SceneError
from phichain.scene.words import answer_of, answer_of_part

TABLES: Final[dict[str, tuple[str, ...]]] = {
    "chain": (
        "links", "space", "base", "mass", "length", "com", "inertia", "cart_mass", "cart_damping", "cart_friction",
        "cart_friction_speed", "drive", "gravity",
    ),
    "joints": ("angles", "damping", "stiffness", "rest_angle", "friction", "friction_speed", "armature", "actuated"),
    "functions": ("want",),
    "flow": ("variational",),
    "forcing": ("forced", "axis"),
    "target": ("real", "code", "trig", "trig_hook", "stack_max", "flash_max"),
}
"""The tables of a scene and their keys; `name` stands before the first table."""

REQUIRED: Final = ("name", "links", "mass", "length")
"""The keys without a default value."""

PARAMETERS: Final = (
    "mass", "length", "com", "cart_mass", "gravity", "damping", "stiffness",
    "inertia", "armature", "friction", "cart_damping", "cart_friction", "rest_angle",
)  # fmt: skip
"""The physical parameters in the order of the emitted `NAME_params`."""

PER_LINK: Final = (
    "mass", "length", "com", "damping", "stiffness", "inertia", "armature", "friction", "rest_angle",
)  # fmt: skip
"""The parameters that hold one number per link."""

POSITIVE: Final = ("mass", "length", "com", "cart_mass")
"""The parameters that must be above zero."""

NOT_NEGATIVE: Final = ("damping", "stiffness", "inertia", "armature", "friction", "cart_damping", "cart_friction")
"""The parameters that must not be below zero."""

_LABELS: Final = {"name": "name"} | {key: f"{table}.{key}" for table, keys in TABLES.items() for key in keys}

_PLANNED_TABLES: Final = {
    "control": "the function controller",
    "fractional": "fractional operators",
}

_FORCED: Final = 'write forced = K for the torque at joint K, forced = "cart" or forced = "base"'
_FORCES: Final = ("torque", "torques", "joint", "joints", "force", "acceleration", "cart", "base", "at", "input")
_PASSED: Final = "pass forcing=(amplitude, omega) to propagate: A cos(omega t)"
_OF_THE_FLOW: Final = dict.fromkeys(("amplitude", "omega", "frequency", "angular_frequency", "w", "a"), _PASSED) | {
    "phase": "start the flow at t = phase / omega: A cos(omega t)"
}


def label(key: str) -> str:
    """Return a key as a scene file names it: `mass` is `chain.mass`."""
    return _LABELS[key]


def flatten(tables: Mapping[str, Any]) -> dict[str, Any]:
    """Check the tables of a scene and return their keys side by side: `{"name": ..., "links": ..., ...}`.

    Raises:
        SceneError: A table or key is unknown (one spelled much alike is given, or what a scene holds of what it means), stands in the wrong table,
            belongs to functions that this version does not have, or a required key is missing.
    """
    if not isinstance(tables, Mapping):
        raise SceneError("scene", tables, "is not a table", "give a mapping of the scene's tables")
    flat: dict[str, Any] = {}
    for key, value in tables.items():
        if key == "name":
            flat["name"] = value
        elif key in TABLES:
            flat |= _table(key, value)
        else:
            raise _unknown_key("", key, value)
    for key in REQUIRED:
        if key not in flat:
            raise SceneError(label(key), None, "is missing", f"add the key {label(key)}")
    return flat


def _table(table: str, entries: object) -> dict[str, Any]:
    """Return one table's keys after checking that each belongs there."""
    if not isinstance(entries, Mapping):
        raise SceneError(table, entries, "is not a table", f"write [{table}] and its keys below it")
    for key, value in entries.items():
        if key not in TABLES[table]:
            raise _unknown_key(table, key, value)
    if table == "forcing" and "forced" not in entries:
        raise SceneError(label("forced"), None, "is missing", _FORCED)
    return dict(entries)


def _unknown_key(table: str, key: object, value: object) -> SceneError:
    """Return the error for a key that its table does not know."""
    name = str(key)
    where = f"{table}.{name}" if table else name
    if not table and name in _PLANNED_TABLES:
        problem = f"is a table for {_PLANNED_TABLES[name]}, which this version does not have"
        return SceneError(where, value, problem, f"remove [{name}]")
    if table == "forcing" and name in _OF_THE_FLOW:
        return SceneError(where, value, "is an argument of the flow, not of a scene", _OF_THE_FLOW[name], nearest=None)
    if table == "forcing" and name in _FORCES:
        return SceneError(where, value, "is not how a scene says what is forced", _FORCED, nearest=None)
    if name in _LABELS:
        best = _LABELS[name]
        home = f"in [{best.split('.')[0]}]" if "." in best else "before the first table"
        return SceneError(where, value, "stands in the wrong place", f"write {name} {home}", nearest=best)
    answer = answer_of(name)
    if answer is not None:
        return SceneError(where, value, answer.problem, answer.remedy, nearest=None)
    valid = TABLES[table] if table else ("name", *TABLES)
    near = nearest(name, valid)
    answer = answer_of_part(name) if near is None else None
    if answer is not None:
        return SceneError(where, value, answer.problem, answer.remedy, nearest=None)
    holder = f"[{table}]" if table else "a scene"
    guess = f'did you mean "{near}"? The' if near else "the"
    remedy = f"{guess} keys of {holder} are {', '.join(valid)}"
    return SceneError(where, value, "is not a key of a scene", remedy, nearest=near)
