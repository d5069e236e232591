"""[forcing]: what a scene may force, and one clear sentence for what it may not."""

from __future__ import annotations

from typing import Any

import pytest

from phichain.errors import PhichainError, SceneError, UnsupportedError
from phichain.scene import Scene, scene_from_dict

CHAIN: dict[str, Any] = {"name": "pair", "links": 2, "mass": 1.0, "length": 1.0, "want": ["propagate"]}
CART: dict[str, Any] = {"base": "cart", "cart_mass": 1.0}


@pytest.mark.parametrize(
    ("more", "axis"),
    [
        ({"forced": 2}, None),
        ({"forced": 1, "angles": "absolute"}, None),
        ({"forced": "cart", **CART}, 1),
        ({"forced": "cart", "axis": 2, **CART, "space": "spatial"}, 2),
        ({"forced": "base", "base": "moving", "axis": 2}, 2),
        ({"forced": "base", "base": "moving", "axis": 3, "space": "spatial"}, 3),
    ],
)
def test_what_is_forced_survives_the_file(more: dict[str, Any], axis: int | None) -> None:
    scene = Scene(**CHAIN, **more)
    assert scene.axis == axis
    again = scene_from_dict(scene.to_dict())
    assert again == scene and again.digest == scene.digest


def test_a_scene_without_forcing_has_no_word_of_it() -> None:
    scene = Scene(**CHAIN)
    assert "forcing" not in scene.to_dict() and scene.forced is None and scene.axis is None
    assert scene.digest != Scene(**CHAIN, forced=1).digest


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ({"forced": 3}, "forcing.forced: is no joint of the chain (got 3); use a joint from 1 to 2"),
        ({"forced": True}, 'forcing.forced: is nothing that can be forced (got True); use a joint such as 1, "cart" or "base"'),
        ({"forced": "cart"}, 'forcing.forced: needs a cart, and the base is fixed (got \'cart\'); use a joint, or set base = "cart"'),
        (
            {"forced": "base"},
            ("forcing.forced: forces the acceleration of a moving base, and the base is fixed (got 'base'); "
            'set base = "moving", or use a joint'),
        ),
        ({"forced": 1, "axis": 1}, "forcing.axis: is the axis of a cart or a base, and a joint is forced (got 1); remove it"),
        ({"forced": "cart", "axis": 2, **CART}, "forcing.axis: is no axis that this cart can be forced along (got 2); use 1"),
        (
            {"forced": "base", "base": "moving", "axis": 3},
            "forcing.axis: is no axis that this base can be forced along (got 3); use 1 to 2, the last one down",
        ),
        (
            {"forced": 1, "space": "spatial"},
            "forcing.forced: forces a joint by a torque, and spatial joints are not actuated (got 1); use \"cart\" or \"base\"",
        ),
        (
            {"forced": 1, "want": ["energy"]},
            'forcing.forced: forces a flow that is not wanted (got 1); add "propagate" to want; amplitude and omega are its arguments',
        ),
        (
            {"axis": 1},
            ('forcing.axis: is the axis of a forcing, and nothing is forced (got 1); '
            'add forcing.forced (use a joint such as 1, "cart" or "base"), or remove it'),
        ),
    ],
)  # fmt: skip
def test_what_cannot_be_forced(more: dict[str, Any], message: str) -> None:
    with pytest.raises(SceneError) as caught:
        Scene(**{**CHAIN, **more})
    assert str(caught.value) == message


def test_a_flow_that_knows_no_forcing_is_refused() -> None:
    with pytest.raises(UnsupportedError, match="knows no forcing, which the scene has"):
        Scene(**{**CHAIN, "want": ["propagate", "propagate_stiff"]}, forced=1)


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ("amplitude", "is an argument of the flow, not of a scene (got 1); pass forcing=(amplitude, omega) to propagate"),
        ("frequency", "is an argument of the flow, not of a scene (got 1); pass forcing=(amplitude, omega) to propagate"),
        ("phase", "start the flow at t = phase / omega"),
        ("torque", "write forced = K for the torque at joint K"),
        ("forcd", 'did you mean "forced"?'),
    ],
)
def test_words_that_are_no_keys_of_it(key: str, words: str) -> None:
    table = {"name": "pair", "chain": {"links": 2, "mass": 1, "length": 1}, "functions": {"want": ["propagate"]}}
    with pytest.raises(PhichainError) as caught:
        scene_from_dict(table | {"forcing": {key: 1}})
    assert words in str(caught.value) and "\n" not in str(caught.value)
