"""Words that are no commands and no options: one line that says what is meant, and nothing far-fetched."""

from __future__ import annotations

import pytest

from tests.cli.conftest import Command
from tests.cli.words.test_refusals import assert_one_line


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("rotor",), "joints.armature"),
        (("tensions", "planar2"), 'add "tensions" to [functions] want'),
        (("simulat", "planar2"), 'did you mean "simulate"?'),
        (("rigs",), "phichain.rigs from Python"),
        (("teapot",), "the commands are show, generate, "),
        (("simulate", "planar2", "--torque", "1"), "pass u to the functions or to simulate"),
        (("simulate", "planar2", "--tension"), 'want "tensions"'),
        (("simulate", "planar2", "--lena", "1"), 'did you mean "--lean"?'),
        (("lqr", "planar3_cart", "--limit", "3"), "saturate u"),
        (("functions", "--teapot"), "that command has none"),
        (("lqr", "planar3_cart", "--teapot"), "the options are --"),
    ],
    ids=str,
)
def test_each_is_answered_in_one_line(command: Command, words: tuple[str, ...], says: str) -> None:
    answer = command(*words)
    assert_one_line(answer, says)
    assert ("did you mean" in answer.err) == ("did you mean" in says)
