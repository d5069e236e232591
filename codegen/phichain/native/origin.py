"""Where compiled callables come from: enough to make the same ones in another process, which is how a System is pickled."""

from __future__ import annotations

import hashlib
import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Final

from phichain.native.cache import Cache
from phichain.native.compiler import CompilerOptions

_MADE: Final[dict[str, Mapping[str, Callable[..., Any]]]] = {}


@dataclass(frozen=True)
class Origin:
    """The files a System was compiled from, and how.

    Attributes:
        texts: Contents by file name, manifest.json among them.
        options: How they are compiled.
        cache: Where compiled objects are kept.
    """

    texts: Mapping[str, bytes] = field(repr=False)
    options: CompilerOptions | None
    cache: Cache | None

    def functions(self) -> Mapping[str, Callable[..., Any]]:
        """The callables, made once per process.

        Raises:
            PhichainError: They cannot be compiled here.
        """
        from phichain.native.load import build_files

        key = hashlib.sha256(repr((sorted(self.texts.items()), self.options)).encode()).hexdigest()
        if key not in _MADE:
            _MADE[key] = build_files(self.texts, self.options, self.cache).functions
        return _MADE[key]

    def __reduce__(self) -> tuple[Any, ...]:
        packed = {name: zlib.compress(text) for name, text in self.texts.items()}
        return _unpacked, (packed, self.options, self.cache)


def _unpacked(packed: Mapping[str, bytes], options: CompilerOptions | None, cache: Cache | None) -> Origin:
    return Origin({name: zlib.decompress(text) for name, text in packed.items()}, options, cache)


@dataclass(frozen=True)
class Made:
    """One callable of an origin; called, it is that callable.

    Attributes:
        origin: What it was made from.
        name: Its contract name.
    """

    origin: Origin
    name: str

    def __call__(self) -> Callable[..., Any]:
        return self.origin.functions()[self.name]


def mark(functions: Mapping[str, Callable[..., Any]], origin: Origin) -> None:
    """Let every callable say what it was made from; `System` asks when it is pickled."""
    for name, function in functions.items():
        function.made_by = Made(origin, name)  # type: ignore[attr-defined]
