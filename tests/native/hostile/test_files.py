"""Folders and files are written whole or not at all."""

from __future__ import annotations

import errno
import json
import os
import signal
import stat
import time
from pathlib import Path

import pytest

from phichain import files
from phichain.errors import OutputError
from phichain.files import write_file, write_folder
from tests.native.processes import python


def generated(*names: str, text: str = "text") -> dict[str, bytes | str]:
    """The contents of a generated folder: the named files and the manifest that lists them."""
    manifest = {"digest": "0" * 64, "files": dict.fromkeys(names, "sha256:")}
    return {**dict.fromkeys(names, text), "manifest.json": json.dumps(manifest)}


def listing(folder: Path) -> dict[str, str]:
    """Every file under a folder, hidden ones too, with its content."""
    return {str(path.relative_to(folder)): path.read_text() for path in folder.rglob("*") if path.is_file()}


def test_folder_holds_exactly_what_was_given(tmp_path: Path) -> None:
    target = write_folder(tmp_path / "out" / "duo", {"duo.c": "é\n", "cmake/duo.cmake": b"\x00\xff"})
    assert target == (tmp_path / "out" / "duo").resolve()
    assert (target / "duo.c").read_bytes() == "é\n".encode()
    assert (target / "cmake" / "duo.cmake").read_bytes() == b"\x00\xff"
    assert [path.name for path in target.parent.iterdir()] == ["duo"]


def test_folder_has_ordinary_permissions(tmp_path: Path) -> None:
    target = write_folder(tmp_path / "duo", generated("duo.c"))
    (tmp_path / "ordinary").mkdir()
    assert stat.S_IMODE(target.stat().st_mode) == stat.S_IMODE((tmp_path / "ordinary").stat().st_mode)


def test_previous_folder_is_replaced_and_its_obsolete_files_go(tmp_path: Path) -> None:
    write_folder(tmp_path / "duo", generated("duo.c", "duo_casadi.c"))
    write_folder(tmp_path / "duo", generated("duo.c", text="new"))
    assert listing(tmp_path) == {f"duo/{name}": text for name, text in generated("duo.c", text="new").items()}


def test_two_steps_replace_a_folder_where_one_is_not_to_be_had(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(files, "_exchange", lambda first, second: False)
    test_previous_folder_is_replaced_and_its_obsolete_files_go(tmp_path)


def test_files_of_others_are_carried_over(tmp_path: Path) -> None:
    target = write_folder(tmp_path / "duo", generated("duo.c"))
    (target / "build").mkdir()
    (target / "build" / "main.o").write_text("object")
    (target / "link").symlink_to("build")
    (target / "__pycache__").mkdir()
    (target / "__pycache__" / "duo_casadi.pyc").write_text("bytecode")
    write_folder(target, generated("duo.c", text="new"))
    assert (target / "build" / "main.o").read_text() == "object"
    assert (target / "link").is_symlink()
    assert (target / "duo.c").read_text() == "new"
    assert not (target / "__pycache__").exists()


def test_file_of_others_is_never_overwritten(tmp_path: Path) -> None:
    target = write_folder(tmp_path / "duo", generated("duo.c"))
    (target / "duo_casadi.c").write_text("mine")
    before = listing(tmp_path)
    with pytest.raises(OutputError, match=r"holds a file duo_casadi\.c that phichain did not write"):
        write_folder(target, generated("duo.c", "duo_casadi.c"))
    assert listing(tmp_path) == before


@pytest.mark.parametrize("manifest", [None, "", "[]", "{}", '{"files": {}}', '{"manifest_version": 3}'])
def test_folder_that_is_not_ours_is_refused(tmp_path: Path, manifest: str | None) -> None:
    target = tmp_path / "thesis"
    target.mkdir()
    (target / "thesis.tex").write_text("years of work")
    if manifest is not None:
        (target / "manifest.json").write_text(manifest)
    before = listing(tmp_path)
    with pytest.raises(OutputError, match="not a folder that phichain generated") as caught:
        write_folder(target, generated("duo.c"))
    assert "choose another folder" in caught.value.remedy
    assert listing(tmp_path) == before


def test_empty_folder_is_taken(tmp_path: Path) -> None:
    (tmp_path / "duo").mkdir()
    assert (write_folder(tmp_path / "duo", generated("duo.c")) / "duo.c").exists()


@pytest.mark.parametrize("place", ["file", "file/duo", "file/deeper/duo"])
def test_path_through_a_file_is_refused(tmp_path: Path, place: str) -> None:
    (tmp_path / "file").write_text("kept")
    with pytest.raises(OutputError) as caught:
        write_folder(tmp_path / place, generated("duo.c"))
    assert caught.value.field == "output"
    assert listing(tmp_path) == {"file": "kept"}


@pytest.mark.parametrize("name", ["../duo.c", "/etc/duo.c", "", "a/../duo.c", "a//duo.c", "./duo.c"])
def test_file_name_that_leads_elsewhere_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(OutputError, match="plain relative path"):
        write_folder(tmp_path / "duo", {name: "text"})
    assert listing(tmp_path) == {}


def fail_with(code: int) -> object:
    def fail(*arguments: object) -> None:
        raise OSError(code, os.strerror(code))

    return fail


@pytest.mark.parametrize("code", [errno.ENOSPC, errno.EACCES, errno.EROFS, errno.EDQUOT])
def test_failed_write_leaves_no_trace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, code: int) -> None:
    monkeypatch.setattr(os, "fsync", fail_with(code))
    with pytest.raises(OutputError) as caught:
        write_folder(tmp_path / "new" / "parents" / "duo", generated("duo.c"))
    assert caught.value.errno == code
    assert os.strerror(code) in str(caught.value)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("step", ["fsync", "rename"])
def test_failed_replacement_keeps_the_previous_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, step: str
) -> None:
    target = write_folder(tmp_path / "duo", generated("duo.c", text="old"))
    before = listing(tmp_path)
    rename, renames = os.rename, []

    def fail_at_second_rename(*paths: Path) -> None:
        renames.append(paths)
        if len(renames) == 2:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        rename(*paths)

    monkeypatch.setattr(files, "_exchange", lambda first, second: False)
    monkeypatch.setattr(os, step, fail_at_second_rename if step == "rename" else fail_with(errno.ENOSPC))
    with pytest.raises(OutputError):
        write_folder(target, generated("duo.c", text="new"))
    assert listing(tmp_path) == before


def test_full_disk_keeps_the_previous_folder(tiny_disk: Path) -> None:
    target = write_folder(tiny_disk / "duo", generated("duo.c", text="old"))
    before = listing(tiny_disk)
    with pytest.raises(OutputError, match="No space left on device") as caught:
        write_folder(target, generated("duo.c", "duo.h", text="x" * 40_000))
    assert "free some space" in caught.value.remedy
    assert listing(tiny_disk) == before
    with pytest.raises(OutputError, match="No space left on device"):
        write_file(tiny_disk / "table.csv", "x" * 80_000)
    assert listing(tiny_disk) == before


KILLED_BEFORE_THE_RENAME = """
    import os, signal, sys
    from phichain import files
    from tests.native.hostile.test_files import generated

    files._install = lambda *paths: os.kill(os.getpid(), signal.SIGKILL)
    files.write_folder(sys.argv[1], generated("duo.c", text="new"))
"""


@pytest.mark.parametrize("existed", [False, True])
def test_killed_process_leaves_nothing_under_the_target(tmp_path: Path, existed: bool) -> None:
    target = tmp_path / "duo"
    if existed:
        write_folder(target, generated("duo.c", text="old"))
    assert python(KILLED_BEFORE_THE_RENAME, target).wait(60) == -signal.SIGKILL
    assert target.exists() == existed
    assert not existed or (target / "duo.c").read_text() == "old"
    write_folder(target, generated("duo.c", text="new"))
    assert [path.name for path in tmp_path.iterdir()] == ["duo"], (
        "what the killed process left was not removed"
    )
    assert (target / "duo.c").read_text() == "new"


def seen_whole(target: Path) -> bool:
    """Look at both files of one and the same folder; False when it was replaced and removed in between."""
    folder = os.open(target, os.O_RDONLY)
    try:
        texts = {os.read(os.open(name, os.O_RDONLY, dir_fd=folder), 100) for name in ("duo.c", "duo.h")}
    except FileNotFoundError:
        return False
    finally:
        os.close(folder)
    assert len(texts) == 1
    return True


WRITES_FOREVER = """
    import itertools, sys
    from phichain.files import write_folder
    from tests.native.hostile.test_files import generated

    for count in itertools.count():
        write_folder(sys.argv[1], generated("duo.c", "duo.h", text=f"{sys.argv[2]}{count}"))
"""


def test_two_writers_killed_at_any_time_leave_one_whole_folder(tmp_path: Path) -> None:
    target = tmp_path / "duo"
    writers = [python(WRITES_FOREVER, target, letter) for letter in "ab"]
    deadline = time.monotonic() + 60
    while not target.exists() and time.monotonic() < deadline:
        time.sleep(0.01)
    whole = [seen_whole(target) for _ in range(200)]
    assert any(whole)
    for writer in writers:
        writer.kill()
        assert writer.wait(60) == -signal.SIGKILL
    assert sorted(path.name for path in target.iterdir()) == ["duo.c", "duo.h", "manifest.json"]
    assert (target / "duo.c").read_text() == (target / "duo.h").read_text()


def test_file_is_replaced_whole(tmp_path: Path) -> None:
    path = write_file(tmp_path / "tables" / "table.csv", "old")
    write_file(path, b"new")
    assert listing(tmp_path) == {"tables/table.csv": "new"}


def test_failed_file_keeps_the_previous_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write_file(tmp_path / "table.csv", "old")
    monkeypatch.setattr(os, "fsync", fail_with(errno.ENOSPC))
    with pytest.raises(OutputError):
        write_file(path, "new")
    assert listing(tmp_path) == {"table.csv": "old"}
