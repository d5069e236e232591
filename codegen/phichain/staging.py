"""Folders in which something is made before it is moved to its place: locked, and swept away where their owner was killed."""

from __future__ import annotations

import fcntl
import os
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path


@contextmanager
def staging(parent: Path, label: str, mode: int = 0o777) -> Iterator[Path]:
    """A fresh folder beside the target, on the same disk so that a rename can move it; gone afterwards.

    Its owner holds a lock on it. A staging folder of this label whose lock is free belonged to a process that
    was killed, and is removed first.

    Args:
        parent: An existing folder.
        label: What is being written; part of the hidden name.
        mode: Permissions, less the process's umask.
    """
    prefix = f".{label}.partial-"
    _sweep(parent, prefix)
    stage, lock = _locked_folder(parent, prefix, mode)
    try:
        yield stage
    finally:
        shutil.rmtree(stage, ignore_errors=True)
        os.close(lock)


def _sweep(parent: Path, prefix: str) -> None:
    for stale in parent.glob(f"{_literal(prefix)}*"):
        with suppress(OSError):
            lock = os.open(stale, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                shutil.rmtree(stale, ignore_errors=True)
            finally:
                os.close(lock)


def _literal(text: str) -> str:
    return "".join(f"[{letter}]" if letter in "*?[" else letter for letter in text)


def _locked_folder(parent: Path, prefix: str, mode: int) -> tuple[Path, int]:
    while True:
        stage = parent / f"{prefix}{secrets.token_hex(8)}"
        stage.mkdir(mode)
        with suppress(FileNotFoundError), _unmade(stage):
            lock = os.open(stage, os.O_RDONLY | os.O_DIRECTORY)
            if _lock(lock) and stage.exists():
                return stage, lock
            # A sweep in another process came between the folder and its lock.
            os.close(lock)


@contextmanager
def _unmade(stage: Path) -> Iterator[None]:
    """Remove an empty folder again when it cannot be used, as where too many files are open."""
    try:
        yield
    except OSError:
        with suppress(OSError):
            stage.rmdir()
        raise


def _lock(descriptor: int) -> bool:
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        # A disk without locks: nobody can sweep there either.
        return True
    return True
