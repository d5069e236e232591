"""What callables of compiled functions refuse: shapes, types, rows, numbers of arrays, parameters."""

from __future__ import annotations

import json
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import pytest

from phichain.errors import ArrayError
from phichain.native import Cache, build_folder
from phichain.pipeline import build
from phichain.scene import scene_from_dict
from phichain.system import System
from tests.native.evaluation import Q, U, V, assert_close, evaluated
from tests.native.generated_folder import PARAMETERS, expected, write


@pytest.mark.parametrize(
    ("value", "problem"),
    [
        (np.zeros(3), r"has shape \(3,\) where \(2,\) is expected"),
        (np.zeros((2, 1)), r"has shape \(2, 1\)"),
        (np.zeros((2, 2, 2)), r"has shape \(2, 2, 2\)"),
        (0.5, r"has shape \(\)"),
        ([], r"has shape \(0,\)"),
        (np.zeros(2, complex), "holds complex128 where real numbers are expected"),
        ([0.1, abs], "holds a function where real numbers are expected"),
        ([0.1, {}], "holds objects where real numbers are expected"),
        (np.array([1.0, None]), "holds None where real numbers are expected"),
        (["a", "b"], "holds text where real numbers are expected"),
        (np.zeros(2, "m8[s]"), "holds timedelta64"),
        (None, "holds None"),
        ([[1.0], [1.0, 2.0]], "cannot be read as an array of numbers"),
    ],
    ids=str,
)
def test_wrong_array_is_refused(system: System, value: Any, problem: str) -> None:
    with pytest.raises(ArrayError, match=problem) as caught:
        system.forward_dynamics(Q, value, U, p=PARAMETERS)
    assert caught.value.field == "forward_dynamics.v"
    assert caught.value.remedy
    # The call after a refused one starts afresh.
    assert_close(evaluated(system, Q, V, U, 0.0), expected(Q, V, U, 0.0))


def test_shape_message_says_what_to_pass(system: System) -> None:
    with pytest.raises(ArrayError) as caught:
        system.mass_matrix(np.zeros((5, 3)), p=PARAMETERS)
    assert str(caught.value) == (
        "mass_matrix.q: has shape (5, 3) where (2,) is expected "
        "(got an array of shape (5, 3) and dtype float64); pass (2,), or (n, 2) for n rows at once"
    )
    assert (caught.value.expected, caught.value.shape) == ((2,), (5, 3))


def test_scalar_of_the_wrong_shape(system: System) -> None:
    with pytest.raises(ArrayError, match=r"step\.h: has shape \(2, 1\) where a single number is expected"):
        system.step([[0.1], [0.2]], Q, V, U, p=PARAMETERS)


@pytest.mark.parametrize("count", [0, 2, 4])
def test_wrong_number_of_arrays(system: System, count: int) -> None:
    with pytest.raises(ArrayError, match=r"takes 3 arrays \(q, v, u\) and was given") as caught:
        system.forward_dynamics(*[Q] * count, p=PARAMETERS)
    assert "forward_dynamics(q, v, u, p=)" in caught.value.remedy


@pytest.mark.parametrize(("name", "says"), [("gravity", 'set base = "moving" in the scene'), ("mass", "what changes in time is an input u")])
def test_a_parameter_that_is_a_function_is_told_what_holds_functions(system: System, name: str, says: str) -> None:
    """Its name and the remedy; nothing of the array that NumPy would make of it."""
    with pytest.raises(ArrayError, match="is a function, and a runtime parameter is a number") as caught:
        system.forward_dynamics(Q, V, U, p={**PARAMETERS, name: np.sin})
    assert caught.value.field == f"forward_dynamics.p['{name}']" and says in caught.value.remedy


@pytest.mark.parametrize(
    ("p", "problem"),
    [
        (None, "the runtime parameters mass, gravity are missing"),
        ({}, "must hold exactly mass, gravity"),
        (3.0, "the runtime parameters mass, gravity are missing"),
        ({"mass": [1.0, 2.0]}, "must hold exactly mass, gravity"),
        ({**PARAMETERS, "length": 1.0}, "must hold exactly mass, gravity"),
        ({"mass": np.ones(2), "gravity": 9.0, "length": 1.0}, "must hold exactly mass, gravity"),
        ({"mass": [1.0, 2.0], "Gravity": 9.0}, "must hold exactly mass, gravity"),
        ({**PARAMETERS, "mass": 1.0}, r"p\['mass'\]: has shape \(\) where \(2,\) is expected"),
        ({**PARAMETERS, "mass": np.ones((4, 2))}, r"p\['mass'\]: has shape \(4, 2\)"),
        (
            {**PARAMETERS, "gravity": [9.0]},
            r"p\['gravity'\]: has shape \(1,\) where a single number is expected",
        ),
        ({**PARAMETERS, "gravity": 1j}, r"p\['gravity'\]: holds complex128"),
    ],
    ids=str,
)
@pytest.mark.parametrize("q", [Q, np.zeros((3, 2))], ids=["single", "batch"])
def test_wrong_parameters_are_refused(system: System, p: Any, problem: str, q: np.ndarray) -> None:
    with pytest.raises(ArrayError, match=problem):
        system.forward_dynamics(q, V, U, p=p)


def test_function_without_parameters_checks_them_all_the_same(system: System) -> None:
    for p in ({"mass": [1.0, 2.0]}, np.zeros(2), {}):
        with pytest.raises(ArrayError, match=r"linearization\.p"):
            system.linearization([1, -1], p=p)


def test_scene_without_parameters_takes_none(tmp_path: Path, shared_cache: Cache) -> None:
    system = build_folder(write_folded(tmp_path), cache=shared_cache)
    for p in (None, {}, MappingProxyType({})):
        np.testing.assert_array_equal(system.linearization([1, -1], p=p)[0], np.diag([1.0, -1.0]))
        assert system.linearization(np.ones((3, 2)), p=p)[0].shape == (3, 2, 2)
    for p in (PARAMETERS, {"mass": 1.0}, 3.0):
        with pytest.raises(ArrayError, match="this scene has no runtime parameters"):
            system.linearization([1, -1], p=p)


def write_folded(parent: Path) -> Path:
    """A folder whose manifest knows no runtime parameter, and only the function that needs none."""
    folder = write(parent)
    manifest = json.loads((folder / "manifest.json").read_text())
    tables = manifest["scene"]
    tables["chain"].update(mass=1.0, gravity=9.0)
    tables["functions"]["want"] = ["linearization"]
    scene = scene_from_dict(tables)
    manifest.update(params=[], scene=scene.to_dict(), digest=scene.digest)
    manifest["functions"] = {"linearization": manifest["functions"]["linearization"]}
    (folder / "manifest.json").write_text(json.dumps(manifest))
    return folder


def test_rows_must_agree(system: System) -> None:
    with pytest.raises(ArrayError, match="has 4 rows where q has 3") as caught:
        system.forward_dynamics(np.zeros((3, 2)), np.zeros((4, 2)), U, p=PARAMETERS)
    assert caught.value.field == "forward_dynamics.v"
    with pytest.raises(ArrayError, match="has 1 rows where q has 3"):
        system.forward_dynamics(np.zeros((3, 2)), np.zeros((1, 2)), U, p=PARAMETERS)


@pytest.mark.long
@pytest.mark.parametrize("given", [("com", "inertia"), ("com",), ("inertia",)], ids=" and ".join)
def test_a_link_that_nothing_keeps_from_turning_is_refused(given: tuple[str, ...]) -> None:
    """Runtime or not: com = 0 asks for an inertia, link by link."""
    numbers = {"com": [0.2 if given == ("com",) else 0.0, 0.0], "inertia": [0.0, 0.1]}
    held = {name: "runtime" if name in given else {"com": [0.0, 0.3], "inertia": [0.1, 0.0]}[name] for name in numbers}
    chain = {"links": 2, "mass": 1.0, "length": 0.5, **held}
    system = build(scene_from_dict({"name": "bare", "chain": chain, "functions": {"want": ["forward_dynamics", "propagate"]}}))
    p = {name: numbers[name] for name in given}
    for _ in range(2):
        with pytest.raises(ArrayError, match=r"puts the mass of link [12] on its joint, and the link has no inertia"):
            system.forward_dynamics(np.ones(2), np.ones(2), p=p)
    right = {name: [0.2, 0.1] for name in given}
    assert np.isfinite(system.forward_dynamics(np.ones(2), np.ones(2), p=right)).all()
    with pytest.raises(ArrayError, match="has no inertia"):
        system.propagate(np.ones(2), np.ones(2), 0.0, 1.0, 1e-9, p=p)


def test_large_numbers_are_finite_without_a_warning() -> None:
    """Their squares are not, which is nobody's business."""
    import warnings

    from phichain.native.flows.checks import finite

    large = np.array([1e200, -1e300])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert finite("x", large) is large


def test_where_entries_begin() -> None:
    """Of arrays of every kind, written to or not, in one piece or not; of none nowhere."""
    from phichain.native.memory.arrays import place

    whole = np.arange(12.0).reshape(3, 4)
    fixed = whole.copy()
    fixed.setflags(write=False)
    for array in (whole, whole.T, whole[1:, 2:], whole[::-1], fixed, np.zeros(3, np.intc), np.array(1.0)):
        assert place(array) == array.ctypes.data
    assert place(np.empty((0, 4))) == 0
