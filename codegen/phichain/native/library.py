"""From C sources to a loaded shared object, through the cache.

The bytes that are loaded are the bytes that were hashed: they are read once, verified, written to a folder
that belongs to this process alone, and loaded from there. Nobody can change the cache's file between the
check and the load, and no other process can evict the file that this one works with. The folder goes when the
process ends.
"""

from __future__ import annotations

import atexit
import ctypes
import hashlib
import json
import os
import secrets
from collections.abc import Mapping
from contextlib import AbstractContextManager
from functools import cache
from pathlib import Path
from typing import Final

from phichain.errors import CacheError, CompilerError
from phichain.files import reported
from phichain.native.cache import Cache
from phichain.native.compiler import Compiler, CompilerOptions, compile_shared, find_compiler

_FORMAT: Final = "phichain build 1"
_PRIVATE: Final[dict[tuple[Path, int], Path]] = {}


def shared_object(
    name: str, sources: Mapping[str, bytes], store: Cache, options: CompilerOptions | None = None
) -> Path:
    """Compile C sources, or find them compiled, and return a verified private copy of the shared object.

    Args:
        name: Prefix of the symbols.
        sources: Contents by file name.
        store: Where compiled objects are kept.
        options: How to compile.

    Returns:
        A file that this process alone uses and that lasts until it ends.

    Raises:
        CompilerError: The compiler is missing, failed or hung.
        CacheError: The cache's folder is not the owner's alone.
        OutputError: The disk is full or the cache cannot be written.
    """
    compiler = find_compiler(options)
    key = cache_key(compiler, sources)
    library = store.fetch(key)
    if library is None:
        with store.workspace() as folder:
            marked = {**sources, f"{name}_key.c": _key_source(name, key)}
            library = compile_shared(compiler, marked, folder, name)
        if key.encode() not in library:
            problem = f"wrote something that is no shared object of {name}"
            raise CompilerError("compiler", compiler.command[0], problem, "set CC to a working C compiler")
        store.store(key, library)
    return _private_copy(store, library)


def cache_key(compiler: Compiler, sources: Mapping[str, bytes]) -> str:
    """SHA-256 over all that may change the shared object: sources, flags, the compiler and its processor."""
    hashes = {name: hashlib.sha256(text).hexdigest() for name, text in sources.items()}
    text = json.dumps([_FORMAT, compiler.digest, hashes], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()


@cache
def load_library(path: Path) -> ctypes.CDLL:
    """Load a shared object once per process; its functions release the interpreter lock while they run.

    Raises:
        CacheError: The system refuses to load it.
    """
    try:
        return ctypes.CDLL(str(path))
    except OSError as error:
        remedy = "set PHICHAIN_CACHE to a folder on a disk that allows execution, or clear the cache"
        raise CacheError("library", str(path), f"the system cannot load it: {error}", remedy) from error


def _key_source(name: str, key: str) -> bytes:
    """C text that puts the cache key into the object, so that an object under a wrong key can be told."""
    return f'extern const char {name}_key[];\nconst char {name}_key[] = "{key}";\n'.encode()


def _private_copy(store: Cache, library: bytes) -> Path:
    folder = _private_folder(store)
    copy, aside = folder / f"{hashlib.sha256(library).hexdigest()}.so", folder / secrets.token_hex(8)
    if not copy.exists():
        with reported(folder):
            aside.write_bytes(library)
            os.replace(aside, copy)
    return copy


def _private_folder(store: Cache) -> Path:
    """This process's own folder for loaded objects; a forked child gets one of its own."""
    owner = (store.root, os.getpid())
    if owner not in _PRIVATE or not _PRIVATE[owner].is_dir():
        holder = store.workspace()
        _PRIVATE[owner] = holder.__enter__()
        atexit.register(_leave, holder, os.getpid())
    return _PRIVATE[owner]


def _leave(holder: AbstractContextManager[Path], process: int) -> None:
    # A forked child inherits the exit handlers of its parent, not the right to empty its parent's folder.
    if os.getpid() == process:
        holder.__exit__(None, None, None)
