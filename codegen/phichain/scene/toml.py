"""Scene files: TOML text in and out, without knowing what the keys mean."""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Mapping
from typing import Any

from phichain.errors import SceneError
from phichain.reading import MEBIBYTE, read_regular

LARGEST = MEBIBYTE
"""Bytes of a scene file: 4096 links with a number each for everything take less than half of it."""
DEEPEST = 32
"""Parts of a key; those of a scene have two."""

_PART = r"""(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')"""
_DEEP = re.compile(rf"(?<![\w-]){_PART}(?:[ \t]*+\.[ \t]*+{_PART}){{{DEEPEST}}}")


def read_toml(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Return the tables of a TOML file.

    Raises:
        SceneError: The file cannot be read, or is no TOML (the message says on which line).
    """
    field, remedy = "scene file", "give the path of a TOML file"
    if not isinstance(path, str | os.PathLike):
        raise SceneError(field, path, "is not a path", remedy)
    try:
        text = read_regular(path, LARGEST).decode()
        _demand_shallow(text)
        return tomllib.loads(text)
    except OSError as error:
        raise SceneError(field, os.fspath(path), f"cannot be read, {error.strerror}", remedy) from error
    except RecursionError as error:
        raise SceneError(field, os.fspath(path), "is nested too deeply", "use plain tables") from error
    except ValueError as error:  # TOMLDecodeError, text that is not UTF-8, integers of thousands of digits
        raise SceneError(field, os.fspath(path), f"is not TOML, {error}", "correct the file") from error


def _demand_shallow(text: str) -> None:
    """Refuse a key of very many parts, for which the parser takes time by the square of their number.

    Raises:
        RecursionError: There is one.
    """
    if _DEEP.search(text):
        raise RecursionError(f"a key of more than {DEEPEST} parts")


def write_toml(tables: Mapping[str, Any]) -> str:
    """Return TOML text of nested tables of strings, numbers and flat lists.

    A list of equal numbers is written as that number where a scene reads it as one for all links.
    """
    from tomli_w import dumps

    return dumps({key: _brief(value) for key, value in tables.items()})


def _brief(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _brief(entry) for key, entry in value.items()}
    equal = isinstance(value, list) and all(isinstance(entry, float) for entry in value) and len(set(value)) == 1
    return value[0] if equal else value
