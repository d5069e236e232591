"""Records on file: what is altered, cut short or forged is one error that names file, entry, value and remedy."""

from __future__ import annotations

import io
import json
import os
import tempfile
import zipfile
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from phichain.archive import META
from phichain.errors import OutputError, PhichainError
from phichain.motion import Trajectory
from phichain.origin import WROTE
from tests.records.samples import OPTIONAL, RECORDS, trajectory


@cache
def whole(kind: str) -> bytes:
    """What a record writes; once, since every file is forced to disk."""
    with tempfile.TemporaryDirectory() as folder:
        content: bytes = RECORDS[kind]().to_npz(Path(folder, "record.npz")).read_bytes()
    return content


def written(tmp_path: Path, kind: str) -> Path:
    path = tmp_path / "record.npz"
    path.write_bytes(whole(kind))
    return path


def read(path: Path, kind: str) -> Any:
    return type(RECORDS[kind]()).from_npz(path)


def held(path: Path) -> dict[str, Any]:
    """Everything in a file, the small fields as a mapping."""
    with np.load(path, allow_pickle=False) as archive:
        return {name: json.loads(str(archive[name])) if name == META else archive[name] for name in archive.files}


def forged(path: Path, edit: Callable[[dict[str, Any]], object]) -> Path:
    """The file with other content; object arrays are pickled as an attacker would."""
    content = held(path)
    edit(content)
    if isinstance(content.get(META), dict):
        content[META] = np.asarray(json.dumps(content[META]))
    with path.open("wb") as file:
        np.savez(file, **content)
    return path


def same(a: Any, b: Any) -> bool:
    """Equality of records, arrays bit by bit and of one type."""
    if isinstance(a, np.ndarray):
        return a.dtype == b.dtype and np.array_equal(a, b)
    if isinstance(a, Mapping):
        return a.keys() == b.keys() and all(same(a[name], b[name]) for name in a)
    if isinstance(a, tuple):
        return len(a) == len(b) and all(map(same, a, b))
    return same(tuple(vars(a).values()), tuple(vars(b).values())) if hasattr(a, "__dict__") else a == b


@pytest.mark.parametrize("kind", RECORDS)
def test_a_record_comes_back_bit_by_bit(kind: str, tmp_path: Path) -> None:
    assert same(read(written(tmp_path, kind), kind), RECORDS[kind]())


@pytest.mark.parametrize("kind", RECORDS)
def test_a_record_without_events_comes_back(kind: str, tmp_path: Path) -> None:
    record = RECORDS[kind]()
    if hasattr(record, "events"):
        record = type(record)(**{**vars(record), "events": ()})
    assert same(read(record.to_npz(tmp_path / "record.npz"), kind), record)


@pytest.mark.parametrize("kind", RECORDS)
def test_a_file_cut_anywhere_is_one_error_that_names_it(kind: str, tmp_path: Path) -> None:
    path = written(tmp_path, kind)
    whole = path.read_bytes()
    for size in (0, 1, 4, 30, 600, len(whole) // 2, len(whole) - 30, len(whole) - 1):
        path.write_bytes(whole[:size])
        with pytest.raises(OutputError, match=f"no {kind} can be read there") as caught:
            read(path, kind)
        assert caught.value.value == str(path)
        assert f"that a {kind} wrote" in caught.value.remedy


@pytest.mark.parametrize("kind", RECORDS)
def test_a_changed_byte_is_an_error_or_no_change(kind: str, tmp_path: Path) -> None:
    path, record = written(tmp_path, kind), RECORDS[kind]()
    whole = path.read_bytes()
    for at in range(0, len(whole), 37):
        path.write_bytes(whole[:at] + bytes([whole[at] ^ 0x55]) + whole[at + 1 :])
        try:
            found = read(path, kind)
        except PhichainError:
            continue
        assert same(found, record)  # a date, or another byte that says nothing


@pytest.mark.parametrize("kind", RECORDS)
def test_every_entry_that_is_missing_is_named(kind: str, tmp_path: Path) -> None:
    whole = held(written(tmp_path, kind))
    for name in whole:
        if name in OPTIONAL[kind]:
            continue
        path = forged(written(tmp_path, kind), lambda content, name=name: content.pop(name))
        words = "does not hold the paths" if kind == "Propagation" and "_total" in name else "is missing"
        with pytest.raises(OutputError, match=rf": {words}.*, in the {kind} of the file {path}"):
            read(path, kind)
    for name in whole[META].keys() - {"kind", WROTE, *OPTIONAL[kind]}:
        path = forged(written(tmp_path, kind), lambda content, name=name: content[META].pop(name))
        with pytest.raises(OutputError, match=rf"^{name}: is missing"):
            read(path, kind)


BAD_ARRAYS: dict[str, Callable[[np.ndarray], Any]] = {
    "text": lambda array: array.astype(str),
    "bytes": lambda array: array.astype("S"),
    "truth": lambda array: array.astype(bool),
    "times": lambda array: array.real.astype("m8[s]"),
    "scalar": lambda array: array.ravel()[0],
    "more dimensions": lambda array: array[None],
    "longer": lambda array: np.concatenate([array, array]),
    "structure": lambda array: np.zeros(array.shape, [("a", float), ("b", float)]),
    "objects": lambda array: array.astype(object),
}


@pytest.mark.parametrize("kind", RECORDS)
@pytest.mark.parametrize("how", BAD_ARRAYS)
def test_arrays_of_another_type_or_shape_are_refused(kind: str, how: str, tmp_path: Path) -> None:
    names = [name for name in held(written(tmp_path, kind)) if name != META]
    for name in names:
        path = forged(written(tmp_path, kind), lambda content, name=name: content.update({name: BAD_ARRAYS[how](content[name])}))
        with pytest.raises(OutputError) as caught:
            read(path, kind)
        assert str(path) in str(caught.value)


BAD_FIELDS = (None, -1.5, "nonsense", [], {}, ["a", 2], True, 10**400, {"steps": -1})


def fits(name: str, value: Any) -> bool:
    """What a field may hold as well, judged by hand."""
    texts = ("name", "method", "reason", "digest") if name != "status" else ()
    return (
        (name in (*texts, "status") and isinstance(value, str))
        or (name in ("tol", "residual", "holds_until") and type(value) in (int, float))
        or (name in ("q_names", "v_names", "u_names", "names", "state_names", "input_names", "s") and value == [])
        or (name == "counts" and value == {})
        or (name == "initial" and value is True)
        or (name in ("p", "params") and value in ({}, {"steps": -1}))
    )


@pytest.mark.parametrize("kind", RECORDS)
def test_fields_of_another_kind_are_refused_by_name(kind: str, tmp_path: Path) -> None:
    names = held(written(tmp_path, kind))[META].keys() - {"kind", WROTE}
    for name in sorted(names):
        for value in BAD_FIELDS:
            path = forged(written(tmp_path, kind), lambda content, name=name, value=value: content[META].update({name: value}))
            if fits(name, value):
                continue
            with pytest.raises(OutputError) as caught:
                read(path, kind)
            assert str(path) in str(caught.value)


def test_an_entry_that_no_record_has_is_refused(tmp_path: Path) -> None:
    path = forged(written(tmp_path, "Branch"), lambda content: content.update(more=np.ones(3)))
    with pytest.raises(OutputError, match=r"^more: is no entry"):
        read(path, "Branch")
    path = forged(written(tmp_path, "Branch"), lambda content: content[META].update({"x\ny": 1}))
    with pytest.raises(OutputError, match=r"^x\\ny: is no entry"):
        read(path, "Branch")


def test_another_kind_of_record_is_named(tmp_path: Path) -> None:
    for kind, other in (("Branch", "Trajectory"), ("Gains", "Branch"), ("Trajectory", "Gains")):
        with pytest.raises(OutputError, match=f"holds a {kind}, not a {other}"):
            read(written(tmp_path, kind), other)


@pytest.mark.parametrize("text", ["[" * 200_000, '{"a":' * 50_000, "", "[]", "{", "null", "[1]", '"kind"', "1" * 5000])
def test_small_fields_that_are_no_fields(text: str, tmp_path: Path) -> None:
    path = forged(written(tmp_path, "Trajectory"), lambda content: content.update({META: np.asarray(text)}))
    with pytest.raises(OutputError, match="Trajectory"):
        read(path, "Trajectory")


def header(shape: tuple[int, ...], dtype: str = "<f8") -> bytes:
    """The first bytes of an array of a shape that nobody could hold."""
    stream = io.BytesIO()
    np.lib.format.write_array_header_1_0(stream, {"shape": shape, "fortran_order": False, "descr": dtype})
    return stream.getvalue()


@pytest.mark.parametrize(
    "member",
    [
        header((10**15,)), header((10**15,), "<U10") + b"abc", header((2**62, 2**62)), header((-1,)), b"", b"\x93NUMPY",
        b"\x93NUMPY\x03\x00" + b"\xff" * 8, b"\x93NUMPY\x01\x00\xff\xff" + b"(" * 0xFFFF, b"PK\x03\x04" * 10,
    ],
)  # fmt: skip
def test_headers_that_promise_what_the_file_has_not(member: bytes, tmp_path: Path) -> None:
    path = written(tmp_path, "Trajectory")
    with zipfile.ZipFile(path) as archive:
        parts = {name: archive.read(name) for name in archive.namelist()}
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in (parts | {"t.npy": member}).items():
            archive.writestr(name, content)
    with pytest.raises(OutputError) as caught:
        read(path, "Trajectory")
    assert path.name in str(caught.value)


@pytest.mark.parametrize("member", [f"{META}.npy", "q.npy"])
def test_a_member_that_stands_there_twice(member: str, tmp_path: Path) -> None:
    path = written(tmp_path, "Trajectory")
    with zipfile.ZipFile(path, "a") as archive, pytest.warns(UserWarning, match="Duplicate name"):
        archive.writestr(member, b"")
    with pytest.raises(OutputError, match="two members of the same name"):
        read(path, "Trajectory")


def test_a_pipe_a_folder_and_a_device_are_told_at_once(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.npz")
    (tmp_path / "folder.npz").mkdir()
    for path in (tmp_path / "pipe.npz", tmp_path / "folder.npz", Path("/dev/zero"), tmp_path / "absent.npz", Path("a\0b")):
        with pytest.raises(OutputError, match="no Trajectory can be read there"):
            Trajectory.from_npz(path)


def test_arrays_in_other_layouts_are_the_same_record(tmp_path: Path) -> None:
    def turn(content: dict[str, Any]) -> None:
        content["q"] = np.asfortranarray(content["q"])
        content["v"] = content["v"].astype(">f8")

    path = forged(written(tmp_path, "Trajectory"), turn)
    assert same(read(path, "Trajectory"), trajectory())


@pytest.mark.parametrize("method", (zipfile.ZIP_LZMA, zipfile.ZIP_BZIP2))
def test_members_that_numpy_does_not_write_are_refused_before_they_are_unpacked(method: int, tmp_path: Path) -> None:
    path = written(tmp_path, "Branch")
    with zipfile.ZipFile(path) as whole:
        members = {name: whole.read(name) for name in whole.namelist()}
    with zipfile.ZipFile(path, "w", method) as other:
        for name, content in members.items():
            other.writestr(name, content)
    with pytest.raises(OutputError, match=r"no Branch can be read there: \w+\.npy is compressed by a method that is not ours"):
        read(path, "Branch")
