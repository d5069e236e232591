"""A scene may have the name of a stencil's own words: what is put in for one of them is not taken for another."""

from __future__ import annotations

from typing import Any

import pytest

from phichain.emit.law.loop import KINDS, Called, loop_source
from phichain.errors import SceneError
from phichain.scene import Scene
from phichain.scratch import folder_texts

KEYS: dict[str, Any] = {
    "base": "cart", "cart_mass": 0.5, "mass": 0.1, "length": 0.2, "friction": 0.1, "friction_speed": 0.1, "want": ("propagate", "propagate_batch"),
}  # fmt: skip


@pytest.mark.long
@pytest.mark.parametrize("word", ["loop", "wide", "phi", "law", "stem_arm", "phi_arm", "wide_arm", "STEM_arm"])
def test_flows_of_a_chain_with_such_a_name(word: str) -> None:
    other = "qzqxqzqxq"[: len(word)]
    found, expected = (folder_texts(Scene(name, 1, **KEYS), False, False) for name in (word, other))
    assert found[f"{word}.c"] == expected[f"{other}.c"].replace(other, word).replace(other.upper(), word.upper())


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("word", ["loop", "law", "law_call", "phi_real"])
def test_loops_of_a_chain_and_a_law_with_such_names(word: str, kind: str) -> None:
    other = "z" * len(word)
    found, expected = (loop_source(Scene(name, 1, **KEYS), Called(f"{name}_law", kind, 2)) for name in (word, other))
    assert found == expected.replace(other, word)


def test_the_one_word_that_says_two_things_is_refused() -> None:
    for name in ("stem", "Stem"):
        with pytest.raises(SceneError, match="is the word for names in the flows"):
            Scene(name, 1, **KEYS)
