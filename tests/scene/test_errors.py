"""Errors: one sentence, the offending values, and nothing lost on the way between processes."""

import pickle

import numpy as np
import pytest

from phichain import errors
from phichain.errors import CompilerError, PhichainError, SceneError, shown

CHILDREN = [
    value
    for value in vars(errors).values()
    if isinstance(value, type) and issubclass(value, PhichainError) and value is not PhichainError
]


def test_a_message_is_one_sentence_with_field_value_and_remedy():
    error = SceneError("chain.mass", -1.0, "is not positive", "use a number above zero", link=2)
    assert str(error) == "chain.mass: is not positive (got -1.0); use a number above zero"
    assert (error.field, error.value, error.problem) == ("chain.mass", -1.0, "is not positive")
    assert error.remedy == "use a number above zero"
    assert error.data == {"link": 2}
    assert error.link == 2


@pytest.mark.parametrize("child", CHILDREN, ids=lambda child: child.__name__)
def test_every_child_survives_pickling(child):
    error = child("field", [1, 2], "is wrong", "do better", margin=0.5)
    copy = pickle.loads(pickle.dumps(error))
    assert type(copy) is child
    assert str(copy) == str(error)
    assert dict(copy.data) == {"margin": 0.5}


def test_data_cannot_be_changed_and_unknown_entries_are_attribute_errors():
    error = CompilerError("compiler", "cc", "is missing", "install one", command="cc -c x.c")
    with pytest.raises(TypeError):
        error.data["command"] = "other"
    with pytest.raises(AttributeError, match=r"CompilerError carries no 'stderr'; it carries \['command'\]"):
        _ = error.stderr


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, "nothing"),
        ("two\nlines", "'two\\nlines'"),
        (np.zeros((3, 2), dtype=np.float32), "an array of shape (3, 2) and dtype float32"),
        (np.zeros(5), "an array of shape (5,) and dtype float64"),
        (np.array([-1.0, 2.0]), "[-1.0, 2.0]"),
        (np.float64(-1.0), "-1.0"),
        (10**5000, "a number too long to print"),
    ],
    ids=["none", "newline", "array", "row", "few", "number", "digits"],
)
def test_values_are_shown_on_one_line(value, text):
    assert shown(value) == text


def test_long_values_are_shortened():
    text = shown(list(range(1000)))
    assert len(text) == 79
    assert text.startswith("[0, 1, 2")
    assert text.endswith("998, 999]")
