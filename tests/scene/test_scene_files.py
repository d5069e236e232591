"""Scene files: the committed ones, the writer, and files that are none."""

import tomllib
from pathlib import Path

import pytest

from phichain.errors import SceneError
from phichain.scene import PLANAR_FUNCTIONS, SPATIAL_FUNCTIONS, Scene, load_scene, standard_scene

SCENES = Path(__file__).parents[2] / "scenes"
COMMITTED = sorted(SCENES.glob("*.toml"))


@pytest.mark.parametrize("path", COMMITTED, ids=lambda path: path.stem)
def test_committed_scenes_load_are_commented_and_carry_their_file_name(path):
    text = path.read_text(encoding="utf-8")
    scene = load_scene(path)
    assert scene.name == path.stem
    assert text.startswith("# ")
    assert scene.want == tuple(tomllib.loads(text)["functions"]["want"])


@pytest.mark.parametrize("links", [1, 2, 3, 4])
def test_paper_a_is_the_standard_scene_under_its_own_name(links):
    paper, standard = load_scene(SCENES / f"paper_a_{links}.toml"), standard_scene(links)
    assert paper.to_dict() | {"name": standard.name} == standard.to_dict()


def test_paper_b_has_the_printed_parameters():
    scene = load_scene(SCENES / "paper_b.toml")
    assert (scene.links, scene.space, scene.base, scene.cart_mass) == (5, "spatial", "cart", 0.5)
    assert (scene.mass, scene.length, scene.com) == ((0.1,) * 5, (0.1,) * 5, None)
    assert (scene.want, scene.nu) == (SPATIAL_FUNCTIONS, 2)


def test_the_yardsticks_of_leaving_out_want_everything():
    assert load_scene(SCENES / "planar4_full.toml").want == PLANAR_FUNCTIONS
    assert load_scene(SCENES / "spatial4_full.toml").want == SPATIAL_FUNCTIONS


def test_the_writer_writes_keys_in_their_order_and_equal_numbers_once():
    scene = Scene("a", 2, base="cart", mass=[1, 2.5], length=1e-8, cart_mass="runtime", actuated=[2])
    assert scene.to_toml() == (
        'name = "a"\n'
        "\n"
        "[chain]\n"
        "links = 2\n"
        'space = "planar"\n'
        'base = "cart"\n'
        "mass = [\n    1.0,\n    2.5,\n]\n"
        "length = 1e-08\n"
        'cart_mass = "runtime"\n'
        "gravity = 9.81\n"
        "\n"
        "[joints]\n"
        'angles = "relative"\n'
        "actuated = [\n    2,\n]\n"
        "\n"
        "[functions]\n"
        'want = [\n    "forward_dynamics",\n]\n'
        "\n"
        "[target]\n"
        'real = "double"\n'
        'code = "auto"\n'
    )


def test_long_lists_are_wrapped_and_read_back(tmp_path):
    scene = Scene("long_chain", 500, mass=[1 / k for k in range(1, 501)], length=1, actuated=range(1, 500))
    path = tmp_path / "long.toml"
    path.write_text(scene.to_toml(), encoding="utf-8")
    assert max(map(len, scene.to_toml().splitlines())) <= 100
    assert load_scene(str(path)) == scene


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (b"links = = 2\n", "is not TOML, Invalid value (at line 1, column 9)"),
        (b"name = 'a'\nname = 'b'\n", "is not TOML, Cannot overwrite a value"),
        (b"\xff\xfe", "is not TOML, 'utf-8' codec can't decode"),
        (b"a = " + b"[" * 100_000, "is nested too deeply"),
        (b"links = " + b"9" * 5000, "is not TOML, Exceeds the limit"),
        (b"", "is missing"),
        (b"name = 'a'\nchain = 1979-05-27\n", "is not a table"),
    ],
    ids=["syntax", "twice", "encoding", "nesting", "digits", "empty", "date"],
)
def test_files_that_are_no_scene(tmp_path, content, problem):
    path = tmp_path / "scene.toml"
    path.write_bytes(content)
    with pytest.raises(SceneError) as caught:
        load_scene(path)
    assert problem in str(caught.value)


def test_files_that_cannot_be_read(tmp_path):
    with pytest.raises(SceneError, match=r"^scene file: cannot be read, No such file or directory \(got '"):
        load_scene(tmp_path / "missing.toml")
    with pytest.raises(SceneError, match=r"^scene file: cannot be read, Is a directory \(got '"):
        load_scene(tmp_path)
    with pytest.raises(
        SceneError, match=r"^scene file: is not a path \(got 0\); give the path of a TOML file$"
    ):
        load_scene(0)
