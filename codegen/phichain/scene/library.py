"""Scenes by name: the word a user types on the command line becomes a Scene.

A word is a file, the name of a bundled scene, or `planarN` for paper A's chain of N links.
"""

from __future__ import annotations

import re
from difflib import get_close_matches
from pathlib import Path

from phichain.errors import SceneError
from phichain.scene import Scene, load_scene, standard_scene

_PACKAGE = Path(__file__).resolve().parents[1]


def scenes_folder() -> Path:
    """The folder of the bundled scenes: beside the package's modules in a wheel, at the top of a checkout."""
    inside = _PACKAGE / "scenes"
    return inside if inside.is_dir() else _PACKAGE.parents[1] / "scenes"


def bundled_scenes() -> dict[str, Path]:
    """The bundled scenes by name, sorted."""
    return {path.stem: path for path in sorted(scenes_folder().glob("*.toml"))}


def find_scene(word: str) -> Scene:
    """Return the scene that a word names: a TOML file, a bundled scene, or `planarN`.

    Raises:
        SceneError: Nothing has that name (the nearest bundled one is given), or the file holds no valid scene.
        UnsupportedError: A wanted function does not exist for such a scene.
    """
    bundled = bundled_scenes()
    if word in bundled:
        return load_scene(bundled[word])
    standard = re.fullmatch(r"planar([-+]?[\d.]{1,20})", word)
    if standard:
        return standard_scene(_number(standard[1]))
    if Path(word).suffix == ".toml" or Path(word).is_file():
        return load_scene(word)
    known = [*bundled, "planar4"]
    close = get_close_matches(word, known, n=1)
    guess = f'did you mean "{close[0]}"? ' if close else ""
    remedy = f"{guess}give a TOML file, planarN, or one of {', '.join(bundled)}"
    raise SceneError("scene", word, "no scene has that name", remedy, nearest=close[0] if close else None)


def _number(text: str) -> int:
    """The whole number in a text; anything else goes on as it is, for `standard_scene` to refuse."""
    try:
        return int(text)
    except ValueError:
        return text  # type: ignore[return-value]
