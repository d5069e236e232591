"""Reading what others may have written: whole files of bounded size, rows of CSV, and JSON that nests as deep as ours does.

A name may turn out to be a pipe, a device, a folder or a file of a terabyte. Such a thing is told before anything is read, so
that no read waits for a writer who never comes or asks for more memory than there is.
"""

from __future__ import annotations

import csv
import errno
import json
import os
import stat
from collections.abc import Mapping
from itertools import dropwhile
from typing import IO, Any, Final

MEBIBYTE: Final = 2**20


def read_regular(path: str | os.PathLike[str], most: int, folder: int | None = None) -> bytes:
    """The content of a regular file.

    Args:
        path: The file.
        most: Bytes above which it is refused.
        folder: Descriptor of the folder that `path` is relative to; then no symbolic link is followed either.

    Raises:
        OSError: It is missing, is no regular file, or is larger.
    """
    with open_regular(path, most, folder) as file:
        content = file.read(most + 1)
    if len(content) > most:
        raise _too_large(path, most)
    return content


def open_regular(path: str | os.PathLike[str], most: int, folder: int | None = None) -> IO[bytes]:
    """A regular file, open for reading; arguments and errors as in `read_regular`."""
    # Without O_NONBLOCK the opening of a pipe would wait for somebody to write.
    flags = os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC | (0 if folder is None else os.O_NOFOLLOW)
    try:
        descriptor = os.open(path, flags, dir_fd=folder)
    except ValueError as error:  # a NUL within the path
        raise OSError(errno.EINVAL, f"no path, {error}", path) from error
    try:
        found = os.fstat(descriptor)
        if stat.S_ISDIR(found.st_mode):
            raise OSError(errno.EISDIR, os.strerror(errno.EISDIR), os.fspath(path))
        if not stat.S_ISREG(found.st_mode):
            raise OSError(errno.EINVAL, "not a regular file", os.fspath(path))
        if found.st_size > most:
            raise _too_large(path, most)
        return os.fdopen(descriptor, "rb")
    except BaseException:
        os.close(descriptor)
        raise


def read_rows(path: str | os.PathLike[str], most: int) -> list[list[str]]:
    """The rows of a CSV file in UTF-8, with or without the mark that spreadsheets put before it, and without the comments above its header.

    Raises:
        OSError: As `read_regular`.
        ValueError: It is no text in UTF-8, or no CSV.
    """
    try:
        lines = read_regular(path, most).decode("utf-8-sig").splitlines()
        return list(csv.reader(dropwhile(lambda line: line.startswith("#"), lines)))
    except csv.Error as error:
        raise ValueError(str(error)) from error


def parse_json(text: bytes | str) -> Any:
    """The value of a JSON text.

    Raises:
        ValueError: It is no JSON, or nests deeper than anything of ours.
    """
    try:
        return json.loads(text)
    except RecursionError:
        raise ValueError("nested too deeply") from None


def text_of(found: Mapping[str, Any], name: str) -> str:
    """A field that is a text.

    Raises:
        KeyError: It is missing.
        TypeError: It is none.
    """
    value = found[name]
    if not isinstance(value, str):
        raise TypeError(f"its {name} is no text")
    return value


def _too_large(path: str | os.PathLike[str], most: int) -> OSError:
    return OSError(errno.EFBIG, f"larger than {most} bytes", os.fspath(path))
