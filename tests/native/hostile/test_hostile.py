"""What others leave where ours should be: pipes, folders, devices, deep texts, compilers that lie, no temporary folder."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from phichain.errors import CompilerError, OutputError
from phichain.files import write_folder
from phichain.native import Cache, CacheWarning, CompilerOptions, build_folder, find_compiler
from phichain.native.process import OutlastedError, finished
from phichain.native.signature import read_manifest
from phichain.pipeline import build
from phichain.reading import parse_json, read_regular
from phichain.scene import Scene
from tests.native.test_compiler import ANSWERS, REAL_COMPILER, FakeCompiler, fake_compiler, is_running

__all__ = ["fake_compiler"]

Replace = Callable[[Path], object]


def pipe(path: Path) -> None:
    os.mkfifo(path)


def device(path: Path) -> None:
    path.symlink_to("/dev/zero")


def whole_folder(path: Path) -> None:
    path.mkdir()
    (path / "file").touch()


def deep(path: Path) -> None:
    path.write_text("[" * 100_000)


def deep_table(path: Path) -> None:
    path.write_text('{"key":' * 100_000)


def long_number(path: Path) -> None:
    path.write_text('{"size": ' + "9" * 10_000 + "}")


def large(path: Path) -> None:
    with path.open("wb") as file:
        file.truncate(2**40)


@pytest.mark.parametrize("name", ["library.so", "record.json"])
@pytest.mark.parametrize("put", [pipe, device, whole_folder, deep, deep_table, long_number, large], ids=lambda put: put.__name__)
def test_whatever_lies_in_an_entry_is_dropped_and_built_again(cache: Cache, put: Replace, name: str) -> None:
    key = "a" * 64
    content = b"some machine code of " + key.encode()
    cache.store(key, content)
    (cache.root / key / name).unlink()
    put(cache.root / key / name)
    with pytest.warns(CacheWarning, match="dropped the damaged cache entry aaaa"):
        assert cache.fetch(key) is None
    assert not list(cache.root.iterdir())
    cache.store(key, content)
    assert cache.fetch(key) == content


@pytest.mark.parametrize("put", [pipe, device, whole_folder, deep], ids=lambda put: put.__name__)
def test_whatever_stands_for_an_entry_is_dropped_or_in_the_way(cache: Cache, put: Replace) -> None:
    cache.prepare()
    put(cache.root / ("b" * 64))
    with pytest.warns(CacheWarning):
        assert cache.fetch("b" * 64) is None
    assert cache.info().entries == 0


@pytest.mark.parametrize("name", ["manifest.json", "duo.h", "duo.c"])
@pytest.mark.parametrize("put", [pipe, whole_folder, deep, large], ids=lambda put: put.__name__)
def test_whatever_lies_in_a_generated_folder_is_refused(folder: Path, cache: Cache, put: Replace, name: str) -> None:
    (folder / name).unlink()
    put(folder / name)
    with pytest.raises(OutputError):
        build_folder(folder, cache=cache)


@pytest.mark.parametrize("put", [pipe, device, whole_folder, deep, large], ids=lambda put: put.__name__)
def test_a_folder_with_such_a_manifest_is_not_replaced(tmp_path: Path, put: Replace) -> None:
    (tmp_path / "duo").mkdir()
    put(tmp_path / "duo" / "manifest.json")
    with pytest.raises(OutputError, match="is not a folder that phichain generated"):
        write_folder(tmp_path / "duo", {"a": "b"})
    assert (tmp_path / "duo" / "manifest.json").exists()


@pytest.mark.parametrize("lie", ["mkfifo library.so", "mkdir library.so", "ln -s /dev/zero library.so", "truncate -s 1T library.so"])
def test_a_compiler_that_leaves_no_file(fake_compiler: FakeCompiler, folder: Path, cache: Cache, lie: str) -> None:
    fake_compiler(f"{ANSWERS}{lie}")
    with pytest.raises(CompilerError, match="wrote no shared object"):
        build_folder(folder, cache=cache)
    assert cache.info().entries == 0


def test_a_compiler_whose_child_keeps_the_output_open(
    fake_compiler: FakeCompiler, folder: Path, cache: Cache, tmp_path: Path
) -> None:
    fake_compiler(f'sleep 600 & echo $! >> {tmp_path}/children\nexec {REAL_COMPILER} "$@"')
    system = build_folder(folder, CompilerOptions(timeout=120.0), cache)
    assert system.has("step")
    children = (tmp_path / "children").read_text().split()
    assert len(children) >= 4 and not any(is_running(int(child)) for child in children)


def test_a_child_in_a_session_of_its_own_is_not_waited_for(tmp_path: Path) -> None:
    if shutil.which("setsid") is None:
        pytest.skip("setsid is a tool of Linux")
    script = "echo before; setsid sleep 5 & echo after; exit 3"
    assert finished(["/bin/sh", "-c", script], tmp_path, os.environ, 100.0) == (3, "before\nafter\n", "")


def test_a_command_that_prints_without_end_is_ended_and_its_first_words_are_enough(tmp_path: Path) -> None:
    with pytest.raises(OutlastedError):
        finished(["/bin/sh", "-c", "yes"], tmp_path, os.environ, 0.5)
    code, output, complaint = finished(["/bin/sh", "-c", "yes | head -c 5000000; exec >&-; sleep 0.2; echo x >&2"], tmp_path, os.environ, 60.0)
    assert (code, len(output), complaint) == (0, 2**20, "x\n")


def test_a_command_ended_by_a_signal_and_one_with_a_zero_in_it(tmp_path: Path) -> None:
    assert finished(["/bin/sh", "-c", "kill -9 $$"], tmp_path, os.environ, 60.0)[0] == -9
    with pytest.raises(ValueError, match="null"):
        finished(["/bin/sh\0"], tmp_path, os.environ, 60.0)


def test_no_temporary_folder_is_needed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> str:
        raise FileNotFoundError("No usable temporary directory found")

    monkeypatch.setattr("tempfile.gettempdir", refuse)
    monkeypatch.setattr("tempfile._get_default_tempdir", refuse)
    monkeypatch.setattr("tempfile.tempdir", None)
    monkeypatch.setenv("TMPDIR", str(tmp_path / "absent"))
    monkeypatch.setenv("PHICHAIN_CACHE", str(tmp_path / "cache"))
    scene = Scene("anywhere", 1, mass=1.0, length=1.0)
    np.testing.assert_allclose(build(scene).forward_dynamics([np.pi / 2], [0.0]), [-9.81], rtol=1e-15)


def test_a_working_folder_that_is_gone_keeps_nobody_from_compiling(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, cache: Cache, folder: Path
) -> None:
    (tmp_path / "gone").mkdir()
    monkeypatch.chdir(tmp_path / "gone")
    (tmp_path / "gone").rmdir()
    assert build_folder(folder, cache=cache).has("step")
    assert find_compiler().version


def test_reading_says_what_is_in_the_way(tmp_path: Path) -> None:
    pipe(tmp_path / "pipe")
    (tmp_path / "file").write_bytes(b"12345")
    assert read_regular(tmp_path / "file", 5) == b"12345"
    for path, words in (("pipe", "not a regular file"), ("file", "larger than 4 bytes"), (".", "directory"), ("a\0b", "no path")):
        with pytest.raises(OSError, match=words):
            read_regular(tmp_path / path, 4)
    for text in ("[" * 10**6, b"\xff", "{", '"\\ud8'):
        with pytest.raises(ValueError):
            parse_json(text)


def test_manifest_of_a_newer_kind_keeps_its_further_keys(folder: Path) -> None:
    path = folder / "manifest.json"
    path.write_text(path.read_text().replace('{"name"', '{"proof": {"step": "exact, 3 points"}, "name"', 1))
    assert read_manifest(folder).name == "duo"
