"""The cache: owner-only, content-addressed, verified before anything is loaded, bounded."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import stat
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from phichain.errors import CacheError, OutputError
from phichain.native import Cache, CacheWarning, build_folder, default_cache
from phichain.system import System
from tests.native import generated_folder
from tests.native.processes import python

KEYS = [letter * 64 for letter in "abcd"]
Q, V, U = np.array([0.1, 0.2]), np.array([0.3, 0.4]), np.array([0.5, 0.6])


def content(key: str, size: int = 0) -> bytes:
    """Bytes that stand for a shared object built for `key`."""
    return key.encode() + bytes(size)


def acceleration(system: System) -> np.ndarray:
    return system.forward_dynamics(Q, V, U, p=generated_folder.PARAMETERS)


EXPECTED = generated_folder.expected(Q, V, U)["forward_dynamics"]


def test_entry_comes_back_and_is_its_owner_s_alone(cache: Cache) -> None:
    assert cache.fetch(KEYS[0]) is None
    cache.store(KEYS[0], content(KEYS[0]))
    assert cache.fetch(KEYS[0]) == content(KEYS[0])
    assert cache.fetch(KEYS[1]) is None
    assert {stat.S_IMODE(path.stat().st_mode) for path in (cache.root, cache.root / KEYS[0])} == {0o700}
    assert [path.name for path in cache.root.iterdir()] == [KEYS[0]]


def test_second_writer_of_the_same_key_changes_nothing(cache: Cache) -> None:
    cache.store(KEYS[0], content(KEYS[0]))
    before = (cache.root / KEYS[0]).stat().st_ino
    cache.store(KEYS[0], content(KEYS[0]))
    assert (cache.root / KEYS[0]).stat().st_ino == before
    assert [path.name for path in cache.root.iterdir()] == [KEYS[0]]


def flip_a_byte(entry: Path, other: Path) -> None:
    data = bytearray((entry / "library.so").read_bytes())
    data[len(data) // 2] ^= 1
    (entry / "library.so").write_bytes(data)


def truncate(entry: Path, other: Path) -> None:
    os.truncate(entry / "library.so", 100)


def take_another_s_library(entry: Path, other: Path) -> None:
    shutil.copy(other / "library.so", entry / "library.so")


def take_another_s_files(entry: Path, other: Path) -> None:
    for name in ("library.so", "record.json"):
        shutil.copy(other / name, entry / name)


def forge_the_record(entry: Path, other: Path) -> None:
    take_another_s_library(entry, other)
    library = (entry / "library.so").read_bytes()
    record = {"key": entry.name, "sha256": hashlib.sha256(library).hexdigest(), "size": len(library)}
    (entry / "record.json").write_text(json.dumps(record))


def lose_the_record(entry: Path, other: Path) -> None:
    (entry / "record.json").unlink()


def spoil_the_record(entry: Path, other: Path) -> None:
    (entry / "record.json").write_text("{")


def empty_the_record(entry: Path, other: Path) -> None:
    (entry / "record.json").write_text("null")


def link_elsewhere(entry: Path, other: Path) -> None:
    (entry / "library.so").unlink()
    (entry / "library.so").symlink_to(other / "library.so")


TAMPERINGS = [
    flip_a_byte,
    truncate,
    take_another_s_library,
    take_another_s_files,
    forge_the_record,
    lose_the_record,
    spoil_the_record,
    empty_the_record,
    link_elsewhere,
]


@pytest.mark.parametrize("tamper", TAMPERINGS, ids=lambda tamper: tamper.__name__)
def test_tampered_entry_is_never_returned(cache: Cache, tamper: Callable[[Path, Path], None]) -> None:
    for key in KEYS[:2]:
        cache.store(key, content(key, 200))
    tamper(cache.root / KEYS[0], cache.root / KEYS[1])
    with pytest.warns(CacheWarning, match="dropped the damaged cache entry aaaa"):
        assert cache.fetch(KEYS[0]) is None
    assert not (cache.root / KEYS[0]).exists()
    assert cache.fetch(KEYS[1]) == content(KEYS[1], 200)


@pytest.mark.parametrize("tamper", [flip_a_byte, forge_the_record], ids=lambda tamper: tamper.__name__)
def test_tampered_entry_is_built_again(
    tmp_path: Path, cache: Cache, tamper: Callable[[Path, Path], None]
) -> None:
    folder = generated_folder.write(tmp_path / "right")
    wrong = generated_folder.SOURCE.replace("+ v[1]", "- v[1]")
    build_folder(folder, cache=cache)
    entry = next(cache.root.glob("[0-9a-f]*"))
    build_folder(generated_folder.write(tmp_path / "wrong", source=wrong), cache=cache)
    other = next(path for path in cache.root.glob("[0-9a-f]*") if path != entry)
    tamper(entry, other)
    with pytest.warns(CacheWarning):
        rebuilt = build_folder(folder, cache=cache)
    np.testing.assert_allclose(acceleration(rebuilt), EXPECTED, rtol=1e-15)
    assert cache.fetch(entry.name) is not None


def test_compiled_folder_is_not_compiled_again(
    folder: Path, cache: Cache, monkeypatch: pytest.MonkeyPatch
) -> None:
    build_folder(folder, cache=cache)
    monkeypatch.setattr("phichain.native.library.compile_shared", None)
    np.testing.assert_allclose(acceleration(build_folder(folder, cache=cache)), EXPECTED, rtol=1e-15)


def test_changed_source_is_another_entry(tmp_path: Path, cache: Cache) -> None:
    build_folder(generated_folder.write(tmp_path / "one"), cache=cache)
    build_folder(generated_folder.write(tmp_path / "two", source=f"{generated_folder.SOURCE}\n"), cache=cache)
    build_folder(generated_folder.write(tmp_path / "three", "float"), cache=cache)
    assert cache.info().entries == 3


def test_cache_open_to_others_is_refused(cache: Cache) -> None:
    cache.root.mkdir(mode=0o755)
    cache.root.chmod(0o755)
    with pytest.raises(CacheError, match="open to other users") as caught:
        cache.fetch(KEYS[0])
    assert "chmod 700" in caught.value.remedy
    assert caught.value.mode == 0o755
    assert list(cache.root.iterdir()) == []


def test_cache_of_another_user_is_refused(cache: Cache, monkeypatch: pytest.MonkeyPatch) -> None:
    cache.store(KEYS[0], content(KEYS[0]))
    monkeypatch.setattr(os, "geteuid", lambda: cache.root.stat().st_uid + 1)
    with pytest.raises(CacheError, match="belongs to another user"):
        cache.fetch(KEYS[0])


def test_file_in_place_of_the_cache_is_refused(cache: Cache) -> None:
    cache.root.write_text("not a folder")
    with pytest.raises(CacheError, match="is not a folder"):
        cache.fetch(KEYS[0])
    with pytest.raises(OutputError):
        Cache(cache.root / "below").fetch(KEYS[0])


def test_full_disk(folder: Path, tiny_disk: Path) -> None:
    (tiny_disk / "filler").write_bytes(bytes(56 * 1024))
    store = Cache(tiny_disk / "cache")
    with pytest.raises(OutputError) as caught:
        build_folder(folder, cache=store)
    assert "space" in caught.value.remedy
    assert list(store.root.iterdir()) == []


def test_least_recently_used_entries_are_evicted(tmp_path: Path) -> None:
    cache = Cache(tmp_path / "cache", limit=3500)
    for key in KEYS[:3]:
        cache.store(key, content(key, 900))
    cache.fetch(KEYS[0])
    cache.store(KEYS[3], content(KEYS[3], 900))
    assert cache.fetch(KEYS[1]) is None
    assert all(cache.fetch(KEYS[k]) for k in (0, 2, 3))
    assert cache.info().size <= 3500


def test_entry_larger_than_the_limit_stays_until_the_next(tmp_path: Path) -> None:
    cache = Cache(tmp_path / "cache", limit=100)
    cache.store(KEYS[0], content(KEYS[0], 500))
    assert cache.fetch(KEYS[0])
    cache.store(KEYS[1], content(KEYS[1], 500))
    assert cache.info().entries == 1


def test_info_and_clear(cache: Cache) -> None:
    assert (cache.info().entries, cache.info().size, cache.clear()) == (0, 0, 0)
    assert not cache.root.exists()
    for key in KEYS:
        cache.store(key, content(key, 1000))
    (cache.root / "notes.txt").write_text("mine")
    assert cache.info().entries == 4
    assert 4000 < cache.info().size < 6000
    assert str(cache.info()).startswith(f"{cache.root}: 4 entries")
    assert cache.clear() == 4
    assert [path.name for path in cache.root.iterdir()] == ["notes.txt"]


@pytest.mark.parametrize(
    ("environment", "root"),
    [
        ({"PHICHAIN_CACHE": "/a/b", "XDG_CACHE_HOME": "/c"}, "/a/b"),
        ({"XDG_CACHE_HOME": "/c"}, "/c/phichain"),
        ({"XDG_CACHE_HOME": "not/absolute"}, None),
        ({}, None),
    ],
)
def test_default_location(
    environment: dict[str, str], root: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HOME", "/home/somebody")
    monkeypatch.setattr("sys.platform", "linux")
    assert default_cache(environment).root == Path(root or "/home/somebody/.cache/phichain")


def test_no_home_at_all(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os.path, "expanduser", lambda path: path)
    with pytest.raises(CacheError, match="no home folder"):
        default_cache({})


BUILDS = """
    import sys
    from pathlib import Path
    from phichain.native import Cache, build_folder
    from tests.native import test_cache

    system = build_folder(sys.argv[1], cache=Cache(Path(sys.argv[2])))
    assert (abs(test_cache.acceleration(system) - test_cache.EXPECTED) < 1e-14).all()
"""


def test_processes_that_build_the_same_at_once(folder: Path, cache: Cache) -> None:
    builders = [python(BUILDS, folder, cache.root) for _ in range(3)]
    assert [builder.wait(120) for builder in builders] == [0, 0, 0]
    assert [len(path.name) for path in cache.root.iterdir()] == [64], (
        "something was left beside the one entry"
    )


DIES_LOADED = f"{BUILDS}\n    import os; os.kill(os.getpid(), 9)\n"


def test_killed_process_leaves_nothing_for_long(folder: Path, cache: Cache) -> None:
    assert python(DIES_LOADED, folder, cache.root).wait(60) == -9
    assert len(list(cache.root.iterdir())) == 2
    cache.store(KEYS[0], content(KEYS[0]))
    assert all(len(path.name) == 64 for path in cache.root.iterdir())


def test_loaded_code_outlives_the_cache(folder: Path, cache: Cache) -> None:
    system = build_folder(folder, cache=cache)
    shutil.rmtree(cache.root)
    np.testing.assert_allclose(acceleration(system), EXPECTED, rtol=1e-15)
    np.testing.assert_allclose(acceleration(build_folder(folder, cache=cache)), EXPECTED, rtol=1e-15)
    assert stat.S_IMODE(cache.root.stat().st_mode) == 0o700


def test_generated_folder_is_only_read(folder: Path, cache: Cache) -> None:
    before = {path.name: path.stat().st_mtime_ns for path in folder.iterdir()}
    build_folder(folder, cache=cache)
    assert {path.name: path.stat().st_mtime_ns for path in folder.iterdir()} == before


def test_library_is_loaded_from_the_verified_copy(folder: Path, cache: Cache) -> None:
    """What is mapped is a private copy, so a change of the cache's file after the check cannot reach it."""
    system = build_folder(folder, cache=cache)
    entry = next(cache.root.glob("[0-9a-f]*"))
    size = (entry / "library.so").stat().st_size
    with open(entry / "library.so", "r+b") as library:
        library.write(bytes(size))
    np.testing.assert_allclose(acceleration(system), EXPECTED, rtol=1e-15)
