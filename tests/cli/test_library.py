"""The word SCENE: a file, a bundled scene, or planarN."""

from __future__ import annotations

from pathlib import Path

import pytest

from phichain.errors import SceneError
from phichain.scene import Scene, standard_scene
from phichain.scene.library import bundled_scenes, find_scene


def test_planar_n_is_paper_a_chain() -> None:
    assert find_scene("planar7") == standard_scene(7)


@pytest.mark.parametrize("name", sorted(bundled_scenes()))
def test_every_bundled_scene_is_found_by_its_own_name(name: str) -> None:
    assert find_scene(name).name == name


def test_a_file_is_read_wherever_it_is(tmp_path: Path) -> None:
    scene = Scene("mine", 2, mass=1.0, length=0.5)
    path = tmp_path / "anything.toml"
    path.write_text(scene.to_toml())
    assert find_scene(str(path)) == scene


@pytest.mark.parametrize(
    ("word", "field", "says"),
    [
        ("planar0", "chain.links", "is below 1"),
        ("planar-3", "chain.links", "is below 1"),
        ("planar2.5", "chain.links", "not a whole number"),
        ("planar1000000000", "chain.links", "is above"),
        ("planr4", "scene", 'did you mean "planar4"?'),
        ("planar", "scene", "no scene has that name"),
        ("", "scene", "no scene has that name"),
        ("nowhere.toml", "scene file", "No such file"),
    ],
)
def test_a_wrong_word_is_one_clear_error(word: str, field: str, says: str) -> None:
    with pytest.raises(SceneError) as caught:
        find_scene(word)
    assert caught.value.field == field
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_folders_of_generated_code_do_not_hide_the_scenes_they_came_from(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("planar3", "paper_b", "other"):
        (tmp_path / name).mkdir()
    assert find_scene("planar3") == standard_scene(3)
    assert find_scene("paper_b").name == "paper_b"
    with pytest.raises(SceneError, match="no scene has that name"):
        find_scene("other")
