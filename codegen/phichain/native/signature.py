"""What a generated folder offers, read from its manifest.json: parameters, functions and their shapes."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import prod
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

from phichain.errors import OutputError
from phichain.files import LARGEST_MANIFEST, MANIFEST
from phichain.reading import MEBIBYTE, parse_json, read_regular

_IDENTIFIER: Final = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_REMEDY: Final = "generate the folder again with this version of phichain"
_MOST: Final = 2**32
_LARGEST_SOURCE: Final = 1024 * MEBIBYTE


@dataclass(frozen=True)
class Argument:
    """A named array (or, with the empty shape, a scalar).

    Attributes:
        may_be_zero: Of a runtime parameter: whether zero serves where only numbers above it do elsewhere.
        beside: Of a runtime com the links' numbers for inertia, and of a runtime inertia those for com, one of which must not be zero.
    """

    name: str
    shape: tuple[int, ...]
    may_be_zero: bool = field(default=False, compare=False)
    beside: tuple[float, ...] = field(default=(), compare=False)

    @property
    def size(self) -> int:
        """Number of entries."""
        return prod(self.shape)

    def __str__(self) -> str:
        return f"{self.name} {self.shape}" if self.shape else self.name


@dataclass(frozen=True)
class Signature:
    """One emitted function: C order is the parameter struct (if it takes one), inputs, outputs.

    Attributes:
        name: Contract name, e.g. ``forward_dynamics``.
        symbol: Its name in C.
        inputs: Arrays by const pointer, scalars by value.
        outputs: Always by pointer.
        parameters: The scene's runtime parameters in the order of the C struct.
        takes_parameters: Whether this function takes the struct.
        struct: Which one: "params", or "prepared", which was made of them.
    """

    name: str
    symbol: str
    inputs: tuple[Argument, ...]
    outputs: tuple[Argument, ...]
    parameters: tuple[Argument, ...]
    takes_parameters: bool
    struct: str = "params"

    def __str__(self) -> str:
        tail = ["p="] if self.takes_parameters else []
        arguments = ", ".join([argument.name for argument in self.inputs] + tail)
        return f"{self.name}({arguments}) -> {', '.join(argument.name for argument in self.outputs)}"


@dataclass(frozen=True)
class Manifest:
    """A generated folder in short.

    Attributes:
        folder: Where it stands; None for texts that stand nowhere.
        name: Name of the scene and prefix of all symbols.
        scene: The scene as a plain mapping.
        digest: The scene's canonical digest.
        real: ``"double"`` or ``"float"``.
        parameters: The runtime parameters in the order of the C struct.
        functions: Signatures by contract name.
        flows: Symbols of what runs over many steps, by contract name.
        files: SHA-256 by file name.
        texts: Those of its files that are at hand, manifest.json among them.
    """

    folder: Path | None
    name: str
    scene: Mapping[str, Any]
    digest: str
    real: str
    parameters: tuple[Argument, ...]
    functions: Mapping[str, Signature]
    flows: Mapping[str, str]
    files: Mapping[str, str]
    texts: Mapping[str, bytes] = field(repr=False)

    def source(self, name: str) -> bytes:
        """The content of one generated file, checked against the manifest.

        Raises:
            OutputError: It is missing or was changed since it was generated.
        """
        promised = self.files.get(name)
        if promised is None:
            raise _unreadable(self.folder, f"holds no {name}", f"generate it again with {name} asked for")
        content = self.texts.get(name) if self.folder is None else _read(self.folder / name, _LARGEST_SOURCE)
        if content is None:
            raise _unreadable(self.folder, f"holds no {name}", "hand it over with the others")
        if promised != f"sha256:{hashlib.sha256(content).hexdigest()}":
            raise _unreadable(
                self.folder, f"its {name} was changed since it was generated", _REMEDY, file=name
            )
        return content


def read_manifest(folder: Path | str) -> Manifest:
    """Read ``manifest.json`` of a generated folder.

    Raises:
        OutputError: There is none, or it is not one of ours.
    """
    path = Path(folder)
    return _parsed(path, {MANIFEST: _read(path / MANIFEST, LARGEST_MANIFEST)})


def manifest_of(texts: Mapping[str, bytes]) -> Manifest:
    """The manifest of a generated folder whose files are at hand and stand nowhere.

    Raises:
        OutputError: manifest.json is missing among them, or is not one of ours.
    """
    return _parsed(None, texts)


def _parsed(path: Path | None, texts: Mapping[str, bytes]) -> Manifest:
    try:
        return _manifest(path, parse_json(texts.get(MANIFEST, b"")), texts)
    except (ValueError, TypeError, KeyError, AttributeError, OverflowError) as error:
        raise _unreadable(path, f"its {MANIFEST} is not one of ours, {error!r}", _REMEDY) from None


def _manifest(folder: Path | None, data: Mapping[str, Any], texts: Mapping[str, bytes]) -> Manifest:
    if data["real"] not in ("double", "float"):
        raise ValueError(f"real is {data['real']!r}")
    parameters = tuple(_argument(entry) for entry in data["params"])
    chain = data["scene"].get("chain", {})
    if "inertia" in chain:
        parameters = tuple(
            replace(entry, may_be_zero=entry.name == "com", beside=_beside(entry, chain)) for entry in parameters
        )
    functions = {name: _signature(name, entry, parameters) for name, entry in data["functions"].items()}
    return Manifest(
        folder=folder,
        name=_identifier(data["name"]),
        scene=MappingProxyType(dict(data["scene"])),
        digest=data["digest"],
        real=data["real"],
        parameters=parameters,
        functions=MappingProxyType(functions),
        flows=MappingProxyType({name: _identifier(entry["symbol"]) for name, entry in data.get("flows", {}).items()}),
        files=MappingProxyType(dict(data["files"])),
        texts=MappingProxyType(dict(texts)),
    )


def _beside(parameter: Argument, chain: Mapping[str, Any]) -> tuple[float, ...]:
    other = chain.get({"com": "inertia", "inertia": "com"}.get(parameter.name, ""), "runtime")
    if other == "runtime":
        return ()
    return tuple(map(float, other if isinstance(other, list) else [other] * parameter.size))


def _signature(name: str, entry: Mapping[str, Any], parameters: tuple[Argument, ...]) -> Signature:
    return Signature(
        name=_identifier(name),
        symbol=_identifier(entry["symbol"]),
        inputs=tuple(_argument(item) for item in entry["inputs"]),
        outputs=tuple(_argument(item) for item in entry["outputs"]),
        parameters=parameters,
        takes_parameters=entry.get("params", False) is True,
    )


def _argument(entry: Mapping[str, Any]) -> Argument:
    shape = tuple(entry["shape"])
    if not all(type(size) is int and 0 < size < _MOST for size in shape):
        raise ValueError(f"{entry['name']} has shape {shape}")
    return Argument(_identifier(entry["name"]), shape)


def _identifier(text: str) -> str:
    # These names become C text and file names; nothing else may come through here.
    if not _IDENTIFIER.fullmatch(text):
        raise ValueError(f"{text!r} is not a C identifier")
    return text


def _read(path: Path, most: int) -> bytes:
    try:
        return read_regular(path, most)
    except OSError as error:
        problem = f"its {path.name} cannot be read: {error.strerror}"
        raise _unreadable(path.parent, problem, "name a folder that phichain generated") from error


def _unreadable(folder: Path | None, problem: str, remedy: str, **data: object) -> OutputError:
    return OutputError("folder", "texts in memory" if folder is None else str(folder), problem, remedy, **data)
