"""What the folders of all laws have in common: numbers as C and JSON write them, inputs with their limits, build file, manifest."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Mapping
from math import isfinite
from typing import Any, Final, Protocol

from phichain._version import __version__
from phichain.emit.render import render
from phichain.files import MANIFEST
from phichain.ir.nodes import Program
from phichain.ir.passes import count_operations
from phichain.origin import plain


class Limited(Protocol):
    """A law, or a part of one, that names its inputs and limits them."""

    @property
    def input_names(self) -> tuple[str, ...]: ...
    @property
    def input_units(self) -> tuple[str, ...]: ...
    @property
    def low(self) -> tuple[float, ...]: ...
    @property
    def high(self) -> tuple[float, ...]: ...


class Owned(Protocol):
    """A law of some scene."""

    @property
    def name(self) -> str: ...
    @property
    def digest(self) -> str: ...
    @property
    def p(self) -> Mapping[str, Any]: ...


BYTES: Final = {"double": 8, "float": 4}
"""Bytes of a number of each type."""


def literal(value: float, real: str) -> str:
    """A hexadecimal constant: the number itself, whatever reads it."""
    text = re.sub(r"\.?0*p", "p", value.hex()) if value else "0.0"
    return f"{text}F" if real == "float" else text


def bound(value: float) -> float | None:
    """A limit as JSON has it; none where it is infinite."""
    return value if isfinite(value) else None


MANNERS = (
    "SI units throughout. The functions keep nothing but what stands in the state, which its caller owns, allocate nothing, and may be "
    "called from several threads at once, each with a state of its own."
)
"""How functions with a state behave."""


def described_inputs(law: Limited, width: int = 0) -> list[str]:
    """What every entry of u is, with its limits."""
    rows = []
    for j, (what, unit, *edges) in enumerate(zip(law.input_names, law.input_units, law.low, law.high, strict=True)):
        bounds = [f"{side} {edge:.9g}" for side, edge in zip(("at least", "at most"), edges, strict=True) if isfinite(edge)]
        rows.append(f"{f'u[{j}]':{width}}  {', '.join([f'{what}, {unit}', *bounds])}")
    return rows


def padded(rows: list[str]) -> list[str]:
    """Rows of one length, as `render` lays them out in a comment."""
    width = max(map(len, rows))
    return [row.ljust(width).rstrip() for row in rows]


def listed_inputs(law: Limited) -> list[list[str | float | None]]:
    """The same for a manifest: name, unit, least, largest."""
    return [[name, unit, bound(low), bound(high)] for name, unit, low, high in zip(law.input_names, law.input_units, law.low, law.high, strict=True)]


def listed_operations(program: Program) -> dict[str, int]:
    """How many operations a call takes, in all and by kind."""
    counted = count_operations(program)
    return {"total": sum(counted.values()), **dict(sorted(counted.items()))}


def whole_folder(kind: str, name: str, law: Owned, real: str, record: Mapping[str, Any], files: Mapping[str, str]) -> dict[str, str]:
    """The files of a law's folder, with its build file and its manifest.

    Args:
        kind: What it is.
        name: Name of the folder.
        law: What it is of: it names its scene, the digest of that and the runtime parameters that it was made for.
        real: Type of its C.
        record: What the manifest says of this kind of law.
        files: The other files by name.
    """
    built = {**files, "CMakeLists.txt": render("CMakeLists.txt.j2", name=name, upper=name.upper(), hook=None)}
    hashes = {file: "sha256:" + hashlib.sha256(text.encode()).hexdigest() for file, text in sorted(built.items())}
    head = {"kind": kind, "name": name, "scene": law.name, "digest": law.digest or "of no scene", "generator": {"phichain": __version__}, "real": real}
    head |= {"p": plain(law.p)} if law.p else {}
    return built | {MANIFEST: json.dumps({**head, **record, "files": hashes}, indent=2, ensure_ascii=True) + "\n"}
