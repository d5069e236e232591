"""Frozen records stay as they were made: read off the source and off the records that the package makes."""

from __future__ import annotations

import ast
import dataclasses
import pickle
import pkgutil
import typing
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import phichain
from phichain.continuation import Branch
from phichain.control import lqr
from phichain.motion import simulate
from phichain.orbits import trace
from phichain.records import Held, frozen, held, thawed
from tests.handmade import planar, uniform_planar

ROOT = Path(phichain.__file__).parent
NUMERICS = ("system", "motion", "continuation", "orbits", "control", "fractional", "report")
CHANGING = frozenset(
    ["append", "update", "setdefault", "add", "extend", "pop", "insert", "clear", "remove", "popitem", "sort", "reverse", "discard", "setflags"]
)


def frozen_classes(tree: ast.AST) -> Iterator[ast.ClassDef]:
    for node in ast.walk(tree):
        if isinstance(node, ast.ClassDef) and any(
            isinstance(mark, ast.Call) and ast.unparse(mark.func).endswith("dataclass") and "frozen=True" in ast.unparse(mark)
            for mark in node.decorator_list
        ):
            yield node


def own_field(node: ast.AST) -> bool:
    """Whether an expression begins with a field of self: self.x, self.x[3], self.x.y[3]."""
    while isinstance(node, ast.Attribute | ast.Subscript):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "self":
            return True
        node = node.value
    return False


def writes(source: str) -> list[str]:
    """Statements in methods of frozen records that change what they hold; `__init__` and `__post_init__` make it."""
    found = []
    for record in frozen_classes(ast.parse(source)):
        for method in record.body:
            if not isinstance(method, ast.FunctionDef) or method.name in ("__init__", "__post_init__"):
                continue
            for node in ast.walk(method):
                targets = node.targets if isinstance(node, ast.Assign | ast.Delete) else []
                if isinstance(node, ast.AugAssign | ast.AnnAssign):
                    targets = [node.target]
                changed = any(own_field(target) for target in targets)
                if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
                    name = node.func.attr
                    changed |= name == "__setattr__" or (name in CHANGING and own_field(node.func.value))
                if changed:
                    found.append(f"{record.name}.{method.name}: {ast.unparse(node)}")
    return found


def test_no_method_of_a_frozen_record_writes_into_it() -> None:
    found = [
        f"{path.relative_to(ROOT)} {line}" for path in sorted(ROOT.rglob("*.py")) for line in writes(path.read_text())
    ]
    assert found == []


@pytest.mark.parametrize(
    "body",
    [
        "self.cache[key] = 1",
        "self.inner.cache[key] += 1",
        "self.seen.append(key)",
        "object.__setattr__(self, 'cache', {})",
        "self.cache.setdefault(key, 1)",
        "del self.cache[key]",
    ],
)
def test_the_walk_finds_what_it_looks_for(body: str) -> None:
    source = f"@dataclass(frozen=True)\nclass Record:\n    def method(self, key):\n        {body}\n"
    assert len(writes(source)) == 1
    assert writes(source.replace("(frozen=True)", "")) == []
    assert writes(source.replace("def method", "def __post_init__")) == []


def records() -> list[type]:
    """The frozen dataclasses of the numerics that say they hold an array."""
    found = []
    for package in NUMERICS:
        home = import_module(f"phichain.{package}")
        names = [home.__name__] + [m.name for m in pkgutil.walk_packages(home.__path__, f"{home.__name__}.")]
        for name in names:
            made_there = (k for k in vars(import_module(name)).values() if getattr(k, "__module__", "") == name)
            found += [kind for kind in made_there if is_frozen(kind) and any(map(has_array, notes(kind)))]
    return found


def is_frozen(kind: object) -> bool:
    return isinstance(kind, type) and dataclasses.is_dataclass(kind) and kind.__dataclass_params__.frozen  # type: ignore[attr-defined]


def notes(kind: type) -> Iterator[object]:
    yield from typing.get_type_hints(kind).values()


def has_array(note: object) -> bool:
    # NDArray is an alias of its own in newer versions of NumPy.
    if typing.get_origin(note) in (np.ndarray, NDArray) or note is np.ndarray:
        return True
    if typing.get_origin(note) is typing.get_origin(typing.Callable):
        return False
    return any(has_array(part) for part in typing.get_args(note))


def test_every_record_of_arrays_holds_them_for_reading() -> None:
    found = records()
    assert len(found) >= 25
    from phichain.continuation import Extra, Problem  # which copy what they are given

    assert [kind for kind in found if not issubclass(kind, Held) and kind not in (Extra, Problem)] == []


@pytest.mark.parametrize(
    "make",
    [
        lambda: trace(uniform_planar(1), amplitude_max=0.3),
        lambda: simulate(uniform_planar(1), [0.3, 0.0], np.linspace(0, 0.2, 5), tol=1e-6),
        lambda: lqr(planar([0.2], [0.5], cart_mass=0.5, actuated="cart")),
    ],
    ids=["Branch", "Trajectory", "Gains"],
)
def test_arrays_of_results_refuse_to_be_written_to(make) -> None:
    made = make()
    for record in (made, pickle.loads(pickle.dumps(dataclasses.replace(made, **plain(made))))):
        arrays = {k: v for k, v in vars(record).items() if isinstance(v, np.ndarray)}
        assert len(arrays) >= 5
        for name, array in arrays.items():
            with pytest.raises(ValueError, match="read-only"):
                array[...] = 0
            assert np.array_equal(array, getattr(made, name))


def plain(record: object) -> dict[str, None]:
    """What cannot be pickled: the interpolant that a Trajectory carries."""
    return {"refine": None} if hasattr(record, "refine") else {}


def test_a_grid_of_times_stays_what_it_was_when_its_owner_changes_it() -> None:
    times = np.linspace(0, 0.2, 5)
    motion = simulate(uniform_planar(1), [0.3, 0.0], times, tol=1e-6)
    times[:] = 7.0
    assert motion.t.max() == 0.2


def test_records_read_from_files_are_no_different(tmp_path) -> None:
    branch = trace(uniform_planar(1), amplitude_max=0.3)
    copy = Branch.from_npz(branch.to_npz(tmp_path / "b.npz"))
    with pytest.raises(ValueError, match="read-only"):
        copy.points[0] = 0


def test_tables_are_frozen_to_the_bottom() -> None:
    inner = np.array([1, 2])
    table = frozen({"a": {"b": [1, {"c": 2}]}, "d": inner})
    with pytest.raises(TypeError):
        table["a"]["b"] = 0
    with pytest.raises(TypeError):
        table["a"]["b"][1]["c"] = 0
    inner[0] = 9
    assert table["d"].tolist() == [1, 2] and table["d"].dtype == inner.dtype
    assert thawed(table)["a"] == {"b": (1, {"c": 2})}
    assert held([1, 2]).dtype == float
