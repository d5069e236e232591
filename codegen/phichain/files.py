"""Writing files and folders whole or not at all.

Everything phichain writes goes through here: bytes are written aside, forced to disk, and put in place by one
rename. A full disk, a refused permission or a killed process therefore leaves what was there before, never a
part of what should have come. A process that is killed outright cannot tidy up; what it left aside (a hidden
folder ``.NAME.partial-...``) is recognised by its free lock and removed by the next write beside it.
"""

from __future__ import annotations

import ctypes
import errno
import os
import shutil
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path, PurePosixPath
from typing import Final

from phichain.errors import OutputError
from phichain.reading import MEBIBYTE, parse_json, read_regular
from phichain.staging import staging

MANIFEST: Final = "manifest.json"
#: What a self-test links with where sines and cosines are left to the user.
SELFTEST_HOOK: Final = "selftest_hook.c"
LARGEST_MANIFEST: Final = 64 * MEBIBYTE

# Importing the generated CasADi module leaves its bytecode in the folder; nobody would miss it.
_DISPOSABLE: Final = "__pycache__"
_ATTEMPTS: Final = 8
_REMEDIES: Final = {
    errno.ENOSPC: "free some space on this disk, or write to another one",
    errno.EDQUOT: "free some of your quota, or write to another disk",
    errno.EFBIG: "raise the file size limit of this process",
    errno.EACCES: "choose a folder you may write to",
    errno.EPERM: "choose a folder you may write to",
    errno.EROFS: "choose a folder on a disk that is not read-only",
    errno.ENOTDIR: "choose a path that does not lead through a file",
    errno.EEXIST: "choose a path that is not taken by a file",
    errno.ENAMETOOLONG: "choose a shorter name",
}


def write_folder(target: Path | str, files: Mapping[str, bytes | str]) -> Path:
    """Put a generated folder in place whole, replacing the previous one in a single step.

    A folder that is there already is replaced only when it is ours, that is, when it holds a
    ``manifest.json`` which lists its files. Files that somebody else put into it are carried over.

    Args:
        target: The folder to write, ``DIR/NAME``; missing parents are made (and unmade if the writing fails).
        files: Contents by path relative to the folder; text is written as UTF-8.

    Returns:
        The folder's resolved path.

    Raises:
        OutputError: The folder cannot be written, is not ours, or holds someone's file of the same name; what
            was there before is still there.
    """
    folder = Path(os.path.realpath(target))
    contents = {_checked(name): _encoded(data) for name, data in files.items()}
    with reported(folder), _parents(folder.parent), staging(folder.parent, folder.name) as stage:
        for name, data in contents.items():
            write_synced(stage / name, data)
        _sync_tree(stage)
        _install(stage, folder, frozenset(contents))
        _sync(folder.parent)
    return folder


def write_file(target: Path | str, data: bytes | str) -> Path:
    """Write one file whole, replacing a previous one in a single step.

    Raises:
        OutputError: The file cannot be written; a previous one is still there, unchanged.
    """
    path = Path(os.path.realpath(target))
    with reported(path), _parents(path.parent), staging(path.parent, path.name) as stage:
        write_synced(stage / "file", _encoded(data))
        os.replace(stage / "file", path)
        _sync(path.parent)
    return path


@contextmanager
def reported(path: Path) -> Iterator[None]:
    """Turn what the operating system says about writing `path` into an `OutputError` with a remedy."""
    try:
        yield
    except OSError as error:
        remedy = _REMEDIES.get(error.errno or 0, "choose another folder")
        problem = f"cannot be written: {error.strerror or error}"
        raise OutputError("output", str(path), problem, remedy, errno=error.errno) from error


def write_synced(path: Path, data: bytes) -> None:
    """Write a new file and force it to disk; raises OSError as the system does."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with open(path, "xb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())


def _checked(name: str) -> str:
    path = PurePosixPath(name)
    if not name or path.is_absolute() or ".." in path.parts or path.as_posix() != name:
        raise OutputError(
            "files", name, "a generated file's name must be a plain relative path", "use NAME.c or a/b"
        )
    return name


def _encoded(data: bytes | str) -> bytes:
    return data.encode() if isinstance(data, str) else data


@contextmanager
def _parents(folder: Path) -> Iterator[None]:
    """Make the missing folders above a target, and remove those again when the writing fails."""
    missing = [path for path in (folder, *folder.parents) if not path.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        yield
    except BaseException:
        for path in missing:
            with suppress(OSError):
                path.rmdir()
        raise


def _install(stage: Path, folder: Path, names: frozenset[str]) -> None:
    """Move the finished stage to its place; another process may be doing the same."""
    for _ in range(_ATTEMPTS):
        if os.path.lexists(folder) and not _is_empty(folder):
            _carry_over(folder, stage, names)
            _swap(stage, folder)
            return
        # A rename replaces an empty folder, and fails on one that was filled since we looked.
        with suppress(FileExistsError), _as_exists(errno.ENOTEMPTY):
            os.rename(stage, folder)
            return
    raise OutputError(
        "output", str(folder), "other processes keep writing this folder", "let one finish first"
    )


@contextmanager
def _as_exists(code: int) -> Iterator[None]:
    # Systems differ in which of the two codes says that a folder is in the way.
    try:
        yield
    except OSError as error:
        if error.errno == code:
            raise FileExistsError(errno.EEXIST, error.strerror) from error
        raise


def _is_empty(folder: Path) -> bool:
    with os.scandir(folder) as entries:
        return next(entries, None) is None


def _carry_over(folder: Path, stage: Path, names: frozenset[str]) -> None:
    """Link what somebody else put into our folder into the one that replaces it, so that nothing is lost."""
    for name in _foreign(folder, _generated(folder)):
        if name in names:
            problem = f"holds a file {name} that phichain did not write and would overwrite"
            raise OutputError("output", str(folder), problem, f"move {name} elsewhere", file=name)
        (stage / name).parent.mkdir(parents=True, exist_ok=True)
        try:
            os.link(folder / name, stage / name, follow_symlinks=False)
        except (OSError, NotImplementedError):
            shutil.copy2(folder / name, stage / name, follow_symlinks=False)


def _generated(folder: Path) -> frozenset[str]:
    """Names of the files that phichain wrote into the folder, by its manifest."""
    try:
        manifest = parse_json(read_regular(folder / MANIFEST, LARGEST_MANIFEST))
        return frozenset((*manifest["files"], MANIFEST)) if manifest["digest"] else frozenset()
    except (OSError, ValueError, TypeError, KeyError):
        problem = "is not a folder that phichain generated (it holds no manifest.json of ours)"
        raise OutputError(
            "output", str(folder), problem, "choose another folder, or remove this one"
        ) from None


def _foreign(folder: Path, known: frozenset[str]) -> Iterator[str]:
    for root, folders, names in os.walk(folder):
        folders[:] = [name for name in folders if name != _DISPOSABLE]
        links = [name for name in folders if os.path.islink(os.path.join(root, name))]
        for name in (*names, *links):
            relative = Path(root, name).relative_to(folder).as_posix()
            if relative not in known:
                yield relative


def _swap(stage: Path, folder: Path) -> None:
    """Exchange two folders in one step where the system can, in two otherwise."""
    if _exchange(stage, folder):
        return
    aside = stage.with_name(f"{stage.name}.old")
    os.rename(folder, aside)
    try:
        os.rename(stage, folder)
    except BaseException:
        os.rename(aside, folder)
        raise
    shutil.rmtree(aside, ignore_errors=True)


def _exchange(first: Path, second: Path) -> bool:
    """Exchange two paths in one step: renameat2 on Linux, renamex_np on macOS; False where neither serves."""
    libc = ctypes.CDLL(None, use_errno=True)
    one, two = os.fsencode(first), os.fsencode(second)
    at_working_folder, rename_exchange = -100, 2
    try:
        if sys.platform == "darwin":
            return bool(libc.renamex_np(one, two, rename_exchange) == 0)
        return bool(libc.renameat2(at_working_folder, one, at_working_folder, two, rename_exchange) == 0)
    except AttributeError:
        return False


def _sync_tree(folder: Path) -> None:
    for root, _, _ in os.walk(folder):
        _sync(Path(root))


def _sync(folder: Path) -> None:
    """Force a folder's entries to disk; some file systems have no such call and need none."""
    with suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
