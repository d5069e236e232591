"""What others wrote, keys, values and file names, never reaches the terminal raw."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from phichain.errors import SceneError, printable
from phichain.scene import load_scene, scene_from_dict
from phichain.scene.toml import DEEPEST, LARGEST
from tests.cli.conftest import Command

ODD = os.fsdecode(b"\xff\xfe")


def said(command: Command, folder: Path, text: str) -> str:
    """The one line that refuses a scene file."""
    path = folder / "scene.toml"
    path.write_text(text)
    answer = command("show", path)
    assert answer.code == 2 and answer.out == ""
    assert answer.err.startswith("phichain: ") and answer.err.endswith("\n")
    line = answer.err.removesuffix("\n")
    assert line.isprintable(), line
    return line


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ('name = "a"\n"x\\nphichain: all is well" = 1', "x\\nphichain: all is well: is not a key of a scene (got 1)"),
        ('name = "a"\n"\\u001b[2J\\u001b[31m" = 1', "\\x1b[2J\\x1b[31m: is not a key"),
        ('name = "a"\n[chain]\n"\\u202Egnol" = 1', "chain.\\u202egnol: is not a key"),
        ('name = "a\\u001b[31m"\n[chain]\nlinks = 1\nmass = 1.0\nlength = 1.0', "name: is not a C identifier (got 'a\\x1b[31m')"),
        ('name = "a"\n[chain]\nlinks = 1\nmass = 1.0\nlength = 1.0\nspace = "\\r\\u0007"', "'\\r\\x07'"),
        ('name = "a"\n[functions]\nwant = ["\\u001b]0;title\\u0007"]\n[chain]\nlinks = 1\nmass = 1\nlength = 1', "\\x1b]0;title\\x07"),
        ('name = "a"\n"\\u0085\\u2028" = 1', "\\x85\\u2028: is not a key"),
    ],
)
def test_control_characters_come_out_as_escapes(command: Command, tmp_path: Path, text: str, shown: str) -> None:
    assert shown in said(command, tmp_path, text)


def test_escapes_are_told_from_what_they_escape() -> None:
    assert printable("plain, ünïcode and 数") == "plain, ünïcode and 数"
    assert printable("a\tb\x1b[0m\x00\x7f\u200f") == "a\\tb\\x1b[0m\\x00\\x7f\\u200f"


DEEP = ".a" * 5000


@pytest.mark.parametrize(
    "text",
    [
        f"a{DEEP} = 1", f"[a{DEEP}]\nx = 1", f"[[a{DEEP}]]\nx = 1", f"x = {{a{DEEP} = 1}}", f'"a b"{DEEP} = 1',
        f"a{DEEP.replace('.', ' . ')} = 1", "'a'" + '."b c"' * 5000 + " = 1", "x = " + "[" * 5000 + "]" * 5000,
        "x = " + "{a=" * 5000 + "1" + "}" * 5000, f"chain{DEEP} = 1", f"[chain]\nmass{DEEP} = 1",
    ],
)  # fmt: skip
def test_a_file_that_nests_too_deeply(command: Command, tmp_path: Path, text: str) -> None:
    assert "is nested too deeply" in said(command, tmp_path, f'name = "a"\n{text}\n')


def test_keys_as_deep_as_allowed_are_read_and_refused_as_keys(command: Command, tmp_path: Path) -> None:
    assert "is not a key of a scene" in said(command, tmp_path, "b" + ".a" * (DEEPEST - 1) + " = 1")


def test_deep_tables_from_python_are_refused_by_name() -> None:
    deep: dict[str, object] = {}
    for _ in range(5000):
        deep = {"a": deep}
    for tables in ({"name": "a", "b": deep}, {"name": "a", "chain": {"mass": deep, "links": 1, "length": 1.0}}):
        with pytest.raises(SceneError):
            scene_from_dict(tables)


def test_files_that_are_no_files_or_too_large_are_refused_at_once(command: Command, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.toml")
    large = tmp_path / "large.toml"
    large.write_bytes(b"#" * (LARGEST + 1))
    for path, says in ((tmp_path / "pipe.toml", "not a regular file"), (large, "larger than"), (Path("/dev/zero"), "regular")):
        with pytest.raises(SceneError, match=says):
            load_scene(path)


def test_a_file_that_is_no_utf_8(tmp_path: Path) -> None:
    path = tmp_path / "latin.toml"
    path.write_bytes(b'name = "\xe9"')
    with pytest.raises(SceneError, match="is not TOML"):
        load_scene(path)


def test_the_largest_chain_fits_into_a_file(tmp_path: Path) -> None:
    third = ", ".join([repr(1 / 3 + 2.0**-50)] * 4096)
    keys = "".join(f"{key} = [{third}]\n" for key in ("mass", "length", "com"))
    path = tmp_path / "long.toml"
    joints = f"[joints]\ndamping = [{third}]\nstiffness = [{third}]\n"
    path.write_text(f'name = "far"\n[chain]\nlinks = 4096\n{keys}{joints}')
    assert load_scene(path).links == 4096


@pytest.mark.parametrize("ending", ["csv", "npz", "png"])
def test_results_in_a_file_whose_name_is_no_utf_8(command: Command, tmp_path: Path, ending: str) -> None:
    if ending == "png":
        pytest.importorskip("matplotlib")
    answer = command("simulate", "planar2", "--t", "0.1", "--points", "3", "--out", f"{ODD}.{ending}")
    assert (answer.code, answer.err) == (0, "")
    assert f"wrote \\udcff\\udcfe.{ending}\n" in answer.out
    assert (tmp_path / f"{ODD}.{ending}").stat().st_size > 0


def test_a_folder_whose_name_is_no_utf_8(command: Command, tmp_path: Path) -> None:
    answer = command("generate", "planar2", "--out", ODD)
    assert (answer.code, answer.err) == (0, "")
    assert "\\udcff\\udcfe/planar2: CMakeLists.txt" in answer.out
    assert (tmp_path / ODD / "planar2" / "planar2.c").is_file()
    answer = command("generate", "planar2", "--out", f"{ODD}\x1b[31m\n")
    assert answer.code == 0 and "\\udcff\\udcfe\\x1b[31m\\n/planar2" in answer.out
