"""`generate --check`, and files that somebody edited."""

from __future__ import annotations

from pathlib import Path

import pytest

from phichain.errors import OutputError
from phichain.pipeline import check_folder, generate
from phichain.scene import Scene

CHAIN = Scene("drifted", 1, mass=1.0, length=0.5, real="float")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return generate(CHAIN, tmp_path, prove=False)


def test_a_fresh_folder_has_not_drifted(folder: Path) -> None:
    found = check_folder(CHAIN, folder.parent, prove=False)
    assert not found and str(found) == "up to date"


def test_drift_is_told_by_kind_and_nothing_is_written(folder: Path) -> None:
    (folder / "README.md").unlink()
    edited = folder / "drifted.c"
    edited.write_text(edited.read_text() + "/* mine */\n")
    found = check_folder(CHAIN, folder.parent, prove=False)
    assert str(found) == "missing: README.md\nedited by hand: drifted.c"
    assert not (folder / "README.md").exists() and "mine" in edited.read_text()


def test_what_another_version_wrote_is_out_of_date(folder: Path) -> None:
    """The manifest knows the file as it stands, and it is not what would be written now."""
    import hashlib

    source, manifest = folder / "drifted.c", folder / "manifest.json"
    before = hashlib.sha256(source.read_bytes()).hexdigest()
    source.write_text(source.read_text() + "/* of an older version */\n")
    manifest.write_text(manifest.read_text().replace(before, hashlib.sha256(source.read_bytes()).hexdigest()))
    assert str(check_folder(CHAIN, folder.parent, prove=False)) == "out of date: drifted.c, manifest.json"


def test_a_missing_folder_is_missing_whole(tmp_path: Path) -> None:
    assert "drifted.c" in check_folder(CHAIN, tmp_path, prove=False).missing


def test_another_scenes_folder_is_refused(folder: Path) -> None:
    other = Scene("drifted", 1, mass=2.0, length=0.5, real="float")
    with pytest.raises(OutputError, match=r"^check: holds another scene, or another version of this one"):
        check_folder(other, folder.parent, prove=False)
    (folder / "manifest.json").write_text("[]")
    with pytest.raises(OutputError, match=r"has no manifest\.json of ours"):
        check_folder(CHAIN, folder.parent, prove=False)


def test_an_edited_file_is_not_overwritten_without_a_word(folder: Path) -> None:
    edited = folder / "drifted.c"
    edited.write_text("/* mine */\n")
    with pytest.raises(OutputError, match=r"was edited since it was generated \(drifted\.c\)") as caught:
        generate(CHAIN, folder.parent, prove=False)
    assert "--force" in caught.value.remedy and edited.read_text() == "/* mine */\n"
    generate(CHAIN, folder.parent, prove=False, force=True)
    assert not check_folder(CHAIN, folder.parent, prove=False)


def test_the_command_exits_with_one_on_drift(folder: Path, tmp_path: Path) -> None:
    from typer.testing import CliRunner

    from phichain.app.cli import app

    file = tmp_path / "drifted.toml"
    file.write_text(CHAIN.to_toml())
    words = ["generate", str(file), "--out", str(folder.parent), "--no-proof", "--check"]
    assert CliRunner().invoke(app, words).exit_code == 0
    (folder / "drifted.h").write_text("")
    result = CliRunner().invoke(app, words)
    assert result.exit_code == 1 and "edited by hand: drifted.h" in result.output
