"""A law as `phichain controller`, `swingup` and `climb` left it in a folder: its C, how it is called, what it is for."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from phichain.emit.law.loop import Called
from phichain.errors import OutputError
from phichain.files import MANIFEST
from phichain.reading import parse_json, read_regular
from phichain.records import Held
from phichain.system import Vector

_LARGEST: Final = 2**26
"""Bytes that a file may have."""
_REMEDY: Final = "name a folder that phichain controller, swingup or climb wrote, untouched"


@dataclass(frozen=True, eq=False)
class LawOnFile(Held):
    """A law.

    Attributes:
        called: How it is called.
        sources: Its header and source by file name.
        scene: Name of its chain.
        digest: That scene's digest.
        kind: What the manifest calls it.
        inputs: Names of its inputs.
        measured: Names of what it measures.
        start: Where it begins (nx,), of laws that lead from one place to another; None of those that hold.
        targets: Where it leads (count, measured), as many as it knows.
        signs: Of tables the equilibria; empty otherwise.
        sample: From one call to the next, s; 0 where it is called all the time.
        duration: How long it leads, s; 0 of laws that hold.
    """

    called: Called
    sources: Mapping[str, str]
    scene: str
    digest: str
    kind: str
    inputs: tuple[str, ...]
    measured: tuple[str, ...]
    start: Vector | None
    targets: Vector
    signs: tuple[tuple[int, ...], ...]
    sample: float
    duration: float


def law_on_file(folder: Path | str) -> LawOnFile:
    """Read a law's folder, its files checked against the hashes of its manifest.

    Raises:
        OutputError: There is no law, or a file of it was edited or is missing.
    """
    place = Path(folder)
    try:
        found = parse_json(read_regular(place / MANIFEST, _LARGEST))
        name = str(found["name"])
        sources = {file: read_regular(place / file, _LARGEST).decode() for file in (f"{name}.h", f"{name}.c")}
        for file, text in sources.items():
            if found["files"][file] != "sha256:" + hashlib.sha256(text.encode()).hexdigest():
                raise OutputError("law", str(place / file), "was edited since it was generated", _REMEDY)
        return _law(found, name, sources)
    except (OSError, ValueError, KeyError, TypeError, IndexError, AttributeError, RecursionError) as failure:
        why = f"it lacks {failure}" if isinstance(failure, KeyError) else str(failure) or type(failure).__name__
        raise OutputError("law", str(place), f"no law can be read there: {why}", _REMEDY) from failure


def _law(found: Mapping[str, Any], name: str, sources: Mapping[str, str]) -> LawOnFile:
    kind, rows = found["kind"], found.get("state") or found["measured"]
    measured, start, reset = tuple(row[0] for row in rows), None, "&state"
    signs: tuple[tuple[int, ...], ...] = ()
    if kind in ("gain table", "output table"):
        how, targets = kind.removeprefix("gain "), [one["target"] for one in found["equilibria"]]
        signs = tuple(tuple(one["s"]) for one in found["equilibria"])
    elif kind == "swingup":
        how, start, targets = "trajectory", np.array([row[2] for row in rows], dtype=float), [[row[3] for row in rows]]
    elif kind == "climb":
        how, start, targets = "climb", np.zeros(len(rows)), [[row[2] for row in rows]]
    elif kind == "controller":
        how, targets = ("memory" if "measured" in found else "feedback"), [[row[2] for row in rows]]
    else:
        raise ValueError(f"its kind is {kind!r}")
    if kind in ("controller", "swingup") and found.get("observer"):
        reset = "&state, measured"
    return LawOnFile(
        Called(name, how, len(rows), reset), sources, found["scene"], found["digest"], kind, tuple(row[0] for row in _inputs(found)), measured, start,
        np.array(targets, dtype=float), signs, float(found["sample"]), float(found.get("duration", 0.0)),
    )  # fmt: skip


def _inputs(found: Mapping[str, Any]) -> list[Any]:
    return list(found["inputs"]) if "inputs" in found else [found["input"]]
