"""The cache of compiled shared objects: content-addressed, owner-only, verified at every read.

::

    ROOT/KEY/library.so     the shared object
    ROOT/KEY/record.json    its key, SHA-256 and size
    ROOT/.*.partial-*       what a process is working on (removed when its process is gone)

KEY is a SHA-256 over all sources, the flags and the compiler's identity. An entry is written aside and put in
place by one rename, so two processes that build the same thing need no lock: the first one wins, and both
hold the same.

An entry that does not match its record (a disk error, a stray hand) is never loaded: it is dropped with a
warning and the caller builds it again. This guards against damage and mix-ups; against a person who can
already write files as the owner of the cache nothing here could, which is why other users are kept out by the
folder's permissions.
"""

from __future__ import annotations

import errno
import hashlib
import json
import os
import re
import stat
import sys
import time
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from phichain.errors import CacheError
from phichain.files import reported, write_synced
from phichain.reading import MEBIBYTE, parse_json, read_regular
from phichain.staging import staging

VARIABLE: Final = "PHICHAIN_CACHE"
_LIBRARY: Final = "library.so"
_RECORD: Final = "record.json"
_KEY: Final = re.compile(r"[0-9a-f]{64}")
_OWNER_ONLY: Final = 0o700
_LARGEST_LIBRARY: Final = 1024 * MEBIBYTE
_LARGEST_RECORD: Final = 64 * 1024


class CacheWarning(UserWarning):
    """A damaged cache entry was dropped."""


@dataclass(frozen=True)
class CacheInfo:
    """What a cache holds.

    Attributes:
        root: Its folder.
        entries: Number of shared objects.
        size: Bytes they take.
        limit: Bytes above which the least recently used ones are evicted.
    """

    root: Path
    entries: int
    size: int
    limit: int

    def __str__(self) -> str:
        mebi = 2.0**20
        return f"{self.root}: {self.entries} entries, {self.size / mebi:.1f} of {self.limit / mebi:.0f} MiB"


@dataclass(frozen=True)
class Cache:
    """A folder of shared objects by key.

    Attributes:
        root: The folder; made when missing, with permissions for its owner alone.
        limit: Bytes above which the least recently used entries are evicted.
    """

    root: Path
    limit: int = 256 * 2**20

    def fetch(self, key: str) -> bytes | None:
        """The verified bytes under a key, or None when they have to be built.

        Warns:
            CacheWarning: The entry did not match its record; it is gone now.

        Raises:
            CacheError: The cache's folder is not the owner's alone.
        """
        self.prepare()
        entry = self.root / key
        try:
            library, record = _read(entry)
        except FileNotFoundError:
            if not entry.exists():
                return None
            fault = "it is incomplete"
        except (OSError, ValueError) as error:
            fault = f"it cannot be read, {error}"
        else:
            fault = _fault(key, library, record)
            if not fault:
                _touch(entry)
                return library
        self.drop(key)
        warnings.warn(
            f"dropped the damaged cache entry {key[:16]} ({fault}); it is built again", CacheWarning, 2
        )
        return None

    def store(self, key: str, library: bytes) -> None:
        """Put a shared object in place; where another process was faster, its equal content stays.

        Raises:
            CacheError: The cache's folder is not the owner's alone.
            OutputError: The disk is full.
        """
        record = {"key": key, "sha256": hashlib.sha256(library).hexdigest(), "size": len(library)}
        with self.workspace() as stage:
            write_synced(stage / _LIBRARY, library)
            write_synced(stage / _RECORD, json.dumps(record, indent=1).encode())
            try:
                os.rename(stage, self.root / key)
            except OSError as error:
                if error.errno not in (errno.ENOTEMPTY, errno.EEXIST):
                    raise
        self._evict(keep=key)

    @contextmanager
    def workspace(self) -> Iterator[Path]:
        """A private temporary folder inside the cache.

        Raises:
            CacheError: The cache's folder is not the owner's alone.
            OutputError: The folder cannot be written.
        """
        self.prepare()
        with reported(self.root), staging(self.root, "work", _OWNER_ONLY) as folder:
            yield folder

    def drop(self, key: str) -> None:
        """Remove an entry, if it is there; nobody sees it half removed."""
        with self.workspace() as stage, suppress(FileNotFoundError):
            os.rename(self.root / key, stage / key)

    def info(self) -> CacheInfo:
        """How much the cache holds; a cache that does not exist yet is empty."""
        entries = self._entries()
        return CacheInfo(self.root, len(entries), sum(entry.size for entry in entries), self.limit)

    def clear(self) -> int:
        """Remove every entry and return how many there were."""
        entries = self._entries()
        for entry in entries:
            self.drop(entry.key)
        return len(entries)

    def prepare(self) -> None:
        """Make the folder when it is missing and check that nobody else can reach into it.

        Raises:
            CacheError: It belongs to somebody else or is open to others.
            OutputError: It cannot be made.
        """
        with reported(self.root):
            self.root.parent.mkdir(parents=True, exist_ok=True)
            with suppress(FileExistsError):
                self.root.mkdir(_OWNER_ONLY)
            found = os.stat(self.root)
        if not stat.S_ISDIR(found.st_mode):
            raise CacheError(
                "cache", str(self.root), "is not a folder", f"set {VARIABLE} to a folder of your own"
            )
        if found.st_uid != os.geteuid():
            problem = "belongs to another user, who could swap the code you run"
            raise CacheError("cache", str(self.root), problem, f"set {VARIABLE} to a folder of your own")
        mode = stat.S_IMODE(found.st_mode)
        if mode & 0o077:
            problem = f"is open to other users (mode {mode:04o}), who could swap the code you run"
            remedy = f"say chmod 700 {self.root}, or set {VARIABLE} to a folder of your own"
            raise CacheError("cache", str(self.root), problem, remedy, mode=mode)

    def _entries(self) -> list[_Entry]:
        """All entries, the least recently used first."""
        entries = []
        with suppress(FileNotFoundError), os.scandir(self.root) as found:
            for item in found:
                if _KEY.fullmatch(item.name):
                    entries.append(_entry(item))
        return sorted(entries, key=lambda entry: entry.used)

    def _evict(self, keep: str) -> None:
        entries = self._entries()
        excess = sum(entry.size for entry in entries) - self.limit
        for entry in entries:
            if excess <= 0:
                return
            if entry.key != keep:
                self.drop(entry.key)
                excess -= entry.size


@dataclass(frozen=True)
class _Entry:
    key: str
    size: int
    used: int


def default_cache(environment: Mapping[str, str] | None = None) -> Cache:
    """The user's cache: ``$PHICHAIN_CACHE``, else ``phichain`` in the platform's cache folder.

    That folder is ``$XDG_CACHE_HOME``, else ``~/Library/Caches`` on macOS and ``~/.cache`` elsewhere.

    Raises:
        CacheError: The user has no home folder and names none.
    """
    variables = os.environ if environment is None else environment
    chosen, shared = variables.get(VARIABLE, ""), variables.get("XDG_CACHE_HOME", "")
    if chosen:
        return Cache(Path(os.path.abspath(os.path.expanduser(chosen))))
    if not os.path.isabs(shared):
        shared = os.path.expanduser("~/Library/Caches" if sys.platform == "darwin" else "~/.cache")
    if not os.path.isabs(shared):
        raise CacheError(
            "cache", shared, "there is no home folder to keep it in", f"set {VARIABLE} to a folder"
        )
    return Cache(Path(shared, "phichain"))


def _read(entry: Path) -> tuple[bytes, Any]:
    """Both files of an entry, through its descriptor: of one and the same entry even if it is replaced."""
    folder = os.open(entry, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)

    try:
        library = read_regular(_LIBRARY, _LARGEST_LIBRARY, folder)
        return library, parse_json(read_regular(_RECORD, _LARGEST_RECORD, folder))
    finally:
        os.close(folder)


def _fault(key: str, library: bytes, record: Any) -> str:
    """What is wrong with an entry; empty when nothing is.

    The object carries its own key as text: a genuine object that came under another entry's name is told
    apart even when somebody rewrote the record as well.
    """
    if not isinstance(record, dict) or record.get("key") != key:
        return "its record is that of another entry"
    if record.get("sha256") != hashlib.sha256(library).hexdigest():
        return "its content is not what its record says"
    if key.encode() not in library:
        return "its content was built for another key"
    return ""


def _touch(entry: Path) -> None:
    now = time.time_ns()
    with suppress(OSError):
        os.utime(entry / _RECORD, ns=(now, now))


def _entry(item: os.DirEntry[str]) -> _Entry:
    size, used = 0, 0
    # Another process may evict the entry meanwhile; what is gone counts nothing.
    with suppress(OSError):
        size = sum(os.stat(Path(item.path, name)).st_size for name in (_LIBRARY, _RECORD))
        used = os.stat(Path(item.path, _RECORD)).st_mtime_ns
    return _Entry(item.name, size, used)
