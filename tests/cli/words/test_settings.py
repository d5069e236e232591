"""`--set` is held against what the scene leaves to run time, in the words of the command line."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from phichain.app.settings import values_given, with_values
from phichain.errors import ArrayError
from phichain.scene.library import find_scene
from tests.cli.conftest import Command
from tests.handmade import uniform_planar

SCENE = find_scene("runtime_double_pendulum")
PLAIN = find_scene("planar2")
SYSTEM = uniform_planar(2)
ALL = ["mass=1,2", "length=0.5", "com=0.25", "gravity=9.8"]


def test_one_number_serves_all_links_and_the_whole_chain_has_one() -> None:
    params = with_values(SYSTEM, SCENE, ALL).params
    assert params is not None and params["gravity"] == 9.8 and isinstance(params["gravity"], float)
    assert {name: params[name].tolist() for name in ("mass", "length", "com")} == {"mass": [1.0, 2.0], "length": [0.5, 0.5], "com": [0.25, 0.25]}
    assert with_values(SYSTEM, PLAIN, None) is SYSTEM
    three = replace(SCENE, links=3)
    assert np.array_equal(with_values(SYSTEM, three, ["mass=1,2,3", *ALL[1:]]).params["mass"], [1, 2, 3])  # type: ignore[index]


@pytest.mark.parametrize(
    ("scene", "words", "said"),
    [
        (PLAIN, ["mass=3"], r"^--set: is no runtime parameter of 'planar2', which has none \(got 'mass'\); write mass = \"runtime\" in the scene"),
        (SCENE, ["gravty=3"], r"which has mass, length, com, gravity \(got 'gravty'\); did you mean \"gravity\"\?"),
        (SCENE, ["gravity=3"], r"\['mass', 'length', 'com'\]\); write --set mass=A,B --set length=A,B --set com=A,B, or one number for all links"),
        (SCENE, None, r"are what 'runtime_double_pendulum' leaves to run time, and have no value .*--set gravity=A"),
        (SCENE, ["mass=1,2,3", *ALL[1:]], r"has 3 numbers \(got 'mass=1,2,3'\); write --set mass=A,B, 2 of them, or one for all"),
        (SCENE, [*ALL, "mass = 3"], r"^set: gives mass values a second time \(got 'mass = 3'\); give each parameter once"),
        (SCENE, [*ALL[:3], "gravity=9,8"], r"has 2 numbers \(got 'gravity=9,8'\); write --set gravity=A"),
    ],
)  # fmt: skip
def test_values_that_do_not_fit_are_one_sentence_with_the_option_to_write(scene: object, words: list[str] | None, said: str) -> None:
    with pytest.raises(ArrayError, match=said):
        with_values(SYSTEM, scene, words)  # type: ignore[arg-type]


def test_values_that_nobody_has_to_give_may_be_given() -> None:
    known = {"gravity": 9.8, "length": [0.5, 0.5], "com": [0.25, 0.25]}
    given = values_given(SCENE, ["mass=2", "gravity=1.6"], known)
    assert given["gravity"] == 1.6 and given["mass"].tolist() == [2.0, 2.0] and given["length"].tolist() == [0.5, 0.5]


@pytest.mark.parametrize("words", [("vary", "runtime_double_pendulum", "--parameter", "gravity", "--until", "9"), ("propagation", "runtime_double_pendulum")])
@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ((), "have no value (got ['mass', 'length', 'com'"),
        (("--set", "mass=1,2,3", "--set", "length=1", "--set", "com=0.5", "--set", "gravity=9.8"), "has 3 numbers (got 'mass=1,2,3')"),
        (("--set", "weight=1"), "is no runtime parameter of 'runtime_double_pendulum'"),
    ],
)  # fmt: skip
def test_every_command_holds_them_against_the_scene(command: Command, words: tuple[str, ...], settings: tuple[str, ...], said: str) -> None:
    answer = command(*words, *settings)
    assert answer.code == 2 and answer.err.startswith("phichain: --set: ") and said in answer.err and answer.err.count("\n") == 1
