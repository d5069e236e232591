"""Stencils: C that compiles by itself, of which a scene takes what it needs.

A stencil is written for names that begin with `phi_` (the scene's), `stem_` and `wide_` (those of one instance of it) and for
features, `#if WITH_TURNS ... #else ... #endif`. `instance` puts names in and leaves out what the scene has no use for.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Final

from phichain.errors import EmissionError
from phichain.identity import beside

PASSED: Final = ("NEWEST", "FORCE", "AFTER", "VARIES")
"""Words around an argument, `FORCE(&force) `, that functions of some scenes alone are given."""

_FEATURE = re.compile(r"#if (!?)(WITH_\w+)$")


def stencils_folder() -> Path:
    """The folder of the stencils: inside the package in a wheel, at the top of a checkout."""
    return beside("stencils")


def instance(stencil: str, names: Mapping[str, str], features: Mapping[str, bool]) -> str:
    """The text of a stencil for one scene.

    Args:
        stencil: its file's name without the ending.
        names: what stands for each name; one that ends in `_` stands for the beginning of others, and one that is
            replaced by nothing takes the blank behind it along.
        features: which of the `WITH_` features the scene has.

    Raises:
        EmissionError: the stencil asks for a feature that is not among them.
    """
    return _named("".join(_chosen(_text(stencil), features)), names)


@cache
def _text(stencil: str) -> str:
    return (stencils_folder() / f"{stencil}.c").read_text(encoding="utf-8")


def _chosen(text: str, features: Mapping[str, bool]) -> list[str]:
    """The lines that a scene with these features keeps."""
    lines: list[str] = []
    open_: list[bool | None] = []  # whether what follows is kept; None inside conditions of the C preprocessor
    for line in text.splitlines(keepends=True):
        word = line.strip()
        found = _FEATURE.match(word)
        if found:
            if found[2] not in features:
                raise EmissionError("stencil", found[2], "is no feature", f"known are {', '.join(sorted(features))}")
            open_.append(features[found[2]] is not (found[1] == "!"))
        elif word.startswith("#if"):
            open_.append(None)
        if word == "#else" and open_[-1] is not None:
            open_[-1] = not open_[-1]
            continue
        is_ours = bool(found) or (word == "#endif" and open_[-1] is not None)
        if not is_ours and False not in open_:
            lines.append(line)
        if word == "#endif":
            open_.pop()
    return lines


def _named(text: str, names: Mapping[str, str]) -> str:
    """The text with its names put in: whole ones first, since they may begin like others. What is put in may hold further names,
    but a scene's own name in it is none of them, even where it begins like one."""
    for word in PASSED:
        text = re.sub(rf"\b{word}\(([^()]*)\) ", r"\1, " if names.get(word) else "", text)
    own = names.get("phi_", "")[:-1]
    hidden = [] if not own or f"{own}_" in names else [(own, "\ue000"), (own.upper(), "\ue001")]
    for name, value in sorted(names.items(), key=lambda item: item[0].endswith("_")):
        put = value
        for word, mark in hidden:
            put = re.sub(rf"\b{word}(?=_|\b)", mark, put)
        text = re.sub(rf"\b{_pattern(name, value)}", put.replace("\\", r"\\"), text)
    for word, mark in hidden:
        text = text.replace(mark, word)
    return text


def _pattern(name: str, value: str) -> str:
    """A name, and the blank behind it where what is put in is nothing or ends in one; or the beginning of longer ones."""
    blank = " ?" if not value or value.endswith(" ") else ""
    return name + (r"(?=\w)" if name.endswith("_") else rf"\b{blank}")


def at_once(text: str, names: Mapping[str, str]) -> str:
    """The same where what is put in holds no further names, so that it is not looked at again, whatever it is called."""
    ordered = sorted(names, key=lambda name: (name.endswith("_"), -len(name)))
    every = "|".join(f"({_pattern(name, names[name])})" for name in ordered)
    return re.sub(rf"\b(?:{every})", lambda found: names[ordered[(found.lastindex or 1) - 1]], text)
