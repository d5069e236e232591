"""Records read back from NPZ files, entry by entry against a schema.

A type and a shape are checked before memory is asked for, nothing is unpickled, and whatever is wrong is one error that names the file,
the entry, its value and the remedy.
"""

from __future__ import annotations

import math
import struct
import zipfile
import zlib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final, NoReturn

import numpy as np

from phichain.archive.possible import impossible
from phichain.archive.schema import LARGEST, META, Array, Schema
from phichain.errors import OutputError
from phichain.origin import WROTE
from phichain.reading import open_regular, parse_json

_LARGEST_TEXT: Final = 2**26
_HEADER: Final = 2**16
"""More than the header of any array here takes."""

_PACKED: Final = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
"""How NumPy packs members; what other methods raise differs from one Python to the next."""
_BROKEN: Final = (
    OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile, zlib.error, struct.error, NotImplementedError, RuntimeError,
    MemoryError, OverflowError, SyntaxError, TypeError,
)  # fmt: skip


def refuse(path: Path | str, schema: Schema, entry: str, value: object, problem: str) -> NoReturn:
    """Say which entry of which file is not what its record holds.

    Raises:
        OutputError: Always.
    """
    impossible(path, schema.kind, entry, value, problem)


def read_archive(path: Path | str, schema: Schema) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """The arrays and small fields of a record.

    Args:
        path: The file.
        schema: What it must hold.

    Returns:
        The arrays that are there, and every field but `kind`.

    Raises:
        OutputError: The file is missing, is no NPZ, is cut short, holds another kind of record, or an entry that is missing,
            unknown, or not what the schema says.
    """
    reader = _Reader(path, schema)
    try:
        with open_regular(path, LARGEST) as file, zipfile.ZipFile(file) as archive:
            reader.demand_small(archive)
            meta = reader.fields(archive)
            return reader.arrays(archive), meta
    except _BROKEN as failure:
        why = str(failure) or type(failure).__name__
        raise OutputError(
            "path", str(path), f"no {schema.kind} can be read there: {why}", f"name a file that a {schema.kind} wrote"
        ) from failure


@dataclass
class _Reader:
    """One reading, with the sizes that were met so far."""

    path: Path | str
    schema: Schema
    sizes: dict[str, int] = field(default_factory=dict)

    def refuse(self, entry: str, value: object, problem: str) -> NoReturn:
        refuse(self.path, self.schema, entry, value, problem)

    def demand_small(self, archive: zipfile.ZipFile) -> None:
        """Refuse what unpacks to more than a record may take, members that hide behind one another's name, and what NumPy does not write."""
        members = [member.filename for member in archive.infolist()]
        size = sum(member.file_size for member in archive.infolist())
        if size > LARGEST:
            raise ValueError(f"it unpacks to {size} bytes, more than {LARGEST}")
        if len(set(members)) < len(members):
            raise ValueError("it holds two members of the same name")
        if strange := [member.filename for member in archive.infolist() if member.compress_type not in _PACKED]:
            raise ValueError(f"{strange[0]} is compressed by a method that is not ours")

    def fields(self, archive: zipfile.ZipFile) -> dict[str, Any]:
        """The small fields, checked."""
        name = f"{META}.npy"
        if name not in archive.namelist():
            self.refuse(META, None, "is missing")
        if archive.getinfo(name).file_size > _LARGEST_TEXT:
            self.refuse(META, archive.getinfo(name).file_size, "takes too many bytes")
        dtype, shape, content = _unpacked(archive, name)
        if dtype.kind != "U" or shape != ():
            self.refuse(META, (dtype.str, shape), "is no text")
        meta = parse_json(str(np.frombuffer(content, dtype)[0]) if dtype.itemsize else "")
        kind = meta.pop("kind", None) if isinstance(meta, dict) else None
        if kind != self.schema.kind:
            raise OutputError(
                "path", str(self.path), f"holds a {kind}, not a {self.schema.kind}",
                f"name a file that a {self.schema.kind} wrote",
            )  # fmt: skip
        if not isinstance(version := meta.pop(WROTE, ""), str):
            self.refuse(WROTE, version, "is no version")
        for entry, wanted in self.schema.fields.items():
            if entry not in meta and wanted.default is None:
                self.refuse(entry, None, "is missing")
            meta.setdefault(entry, wanted.default)
            if not wanted.fits(meta[entry]):
                self.refuse(entry, meta[entry], f"is not {wanted.what}")
            if wanted.size and (meta[entry] or wanted.is_counted):
                self.agree(entry, (wanted.size,), (len(meta[entry]),))
        for entry in meta:
            if entry not in self.schema.fields:
                self.refuse(entry, meta[entry], "is no entry")
        return meta

    def arrays(self, archive: zipfile.ZipFile) -> dict[str, np.ndarray]:
        """The arrays, checked."""
        members = {name.removesuffix(".npy"): name for name in archive.namelist() if name != f"{META}.npy"}
        for entry, name in members.items():
            if entry not in self.schema.arrays or entry == name:
                self.refuse(entry, name, "is no entry")
        found = {}
        for entry, wanted in self.schema.arrays.items():
            if entry in members:
                found[entry] = self.array(archive, members[entry], entry, wanted)
            elif not wanted.is_optional:
                self.refuse(entry, None, "is missing")
        return found

    def array(self, archive: zipfile.ZipFile, member: str, entry: str, wanted: Array) -> np.ndarray:
        """One array: its type and shape first, then its numbers."""
        ours = np.dtype(wanted.dtype)
        dtype, shape = _header(archive, member)[:2]
        if dtype.kind != ours.kind:
            self.refuse(entry, dtype.str, f"has another type than {ours}")
        # A list of no events has lost its further sizes.
        if not (shape == (0,) and self.sizes.get(wanted.shape[0]) == 0):
            has_more = wanted.further and len(shape) > len(wanted.shape)
            self.agree(entry, (*wanted.shape, wanted.further) if has_more else wanted.shape, shape)
        dtype, shape, content = _unpacked(archive, member)
        return np.frombuffer(content, dtype).reshape(shape).astype(ours, copy=True)

    def agree(self, entry: str, sizes: tuple[str, ...], shape: tuple[int, ...]) -> None:
        """Hold a shape against the sizes that are known, and learn those that are not."""
        if len(shape) == len(sizes):
            for name, size in zip(sizes, shape, strict=True):
                if "+" not in name and size >= 0:
                    self.sizes.setdefault(name, size)
        empty = [name for name in sizes if name in self.schema.filled and self.sizes.get(name) == 0]
        if empty:
            self.refuse(entry, shape, "is empty")
        known = tuple(sum(self.sizes.get(part, -1) for part in name.split("+")) for name in sizes)
        if known != shape:
            expected = ", ".join(f"{name} = {size}" if size >= 0 else name for name, size in zip(sizes, known, strict=True))
            self.refuse(entry, shape, f"has another shape than ({expected})")


def _header(archive: zipfile.ZipFile, member: str) -> tuple[np.dtype[Any], tuple[int, ...], int, bool]:
    """Type, shape, where the numbers begin, and whether they run in Fortran's order."""
    with archive.open(member) as file:
        version = np.lib.format.read_magic(file)
        if version not in ((1, 0), (2, 0)):
            raise ValueError(f"{member} is of a version {version} of NumPy's format that is not ours")
        read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
        try:
            shape, is_fortran, dtype = read(file, max_header_size=_HEADER)
        except Exception as failure:  # NumPy parses it as Python's own text, whose parsers fail in many ways
            raise ValueError(f"{member} has a header that cannot be read, {failure}") from failure
        return dtype, tuple(shape), file.tell(), is_fortran


def _unpacked(archive: zipfile.ZipFile, member: str) -> tuple[np.dtype[Any], tuple[int, ...], bytes]:
    """Type, shape and bytes of a member that is as long as its header says; Fortran's order is turned."""
    dtype, shape, start, is_fortran = _header(archive, member)
    if dtype.hasobject:
        raise ValueError(f"{member} holds Python objects")
    if start + math.prod(shape) * dtype.itemsize != archive.getinfo(member).file_size or min(shape, default=0) < 0:
        raise ValueError(f"{member} is not as long as its header says")
    content = archive.read(member)[start:]
    if is_fortran and len(shape) > 1:
        content = np.ascontiguousarray(np.frombuffer(content, dtype).reshape(shape, order="F")).tobytes()
    return dtype, shape, content
