"""What friction brings into the code has a unit and a meaning: its names stand in the table from which comments are written."""

from __future__ import annotations

import re
from typing import Any

import pytest

from phichain.contract.functions import ROWS
from phichain.contract.quantities import quantities_of
from phichain.ir.nodes import For, Op, Program, walk
from phichain.lowering import lower
from phichain.lowering.series import series
from phichain.mechanics import derive
from phichain.scene import Scene
from tests.offered import offered

_BEHIND = re.compile(r"(_(\d+|[ijk]|at|end))+$")
DAMPED: dict[str, Any] = {"damping": 0.2, "code": "loops"}
DRY: dict[str, Any] = {**DAMPED, "friction": 0.3, "friction_speed": 0.5}


def names_of(program: Program) -> set[str]:
    """The stems of what a Program names, but for what the contract and the scene name: arguments and parameters."""
    found = {array.name for array in program.work} | set(program.tables)
    for statement in walk(program.body):
        found |= {statement.result} if isinstance(statement, Op) else set()
        found |= {carry.name for carry in statement.carries} if isinstance(statement, For) else set()
    stems = {_BEHIND.sub("", name) for name in found}
    return {stem for stem in stems if not re.fullmatch(r"t\d*|d_\w+", stem)}


def named(space: str, **keys: Any) -> tuple[Scene, dict[str, set[str]]]:
    """Names by function, of everything that a chain can want and of its Taylor recurrences."""
    chain: dict[str, Any] = {"space": space, "mass": [1.0, 2.0, 3.0], "length": [0.5, 0.6, 0.7], **keys}
    if keys.get("base") == "cart":
        chain |= {"cart_mass": 1.0, "cart_damping": 0.3}
    if "friction" in keys and keys.get("base") == "cart":
        chain |= {"cart_friction": 0.4, "cart_friction_speed": 0.5}
    known = [name for name in offered(space, True, on_request=True) if ROWS[name].absence(Scene("n", 3, **chain)) is None]
    scene = Scene("n", 3, want=known, **chain)
    model = derive(scene)
    made, lowered = series(model), lower(model)
    programs = [*lowered.wanted.values(), *lowered.helpers.values(), made.factor, made.order, *filter(None, [made.columns, made.tangent])]
    return scene, {program.name: names_of(program) for program in programs}


@pytest.mark.long
@pytest.mark.parametrize(("base", "com"), [("fixed", None), ("cart", [0.2, 0.3, 0.35])], ids=["fixed", "cart"])
@pytest.mark.parametrize("space", ["planar", "spatial"])
def test_every_name_that_dry_friction_brings_has_its_row(space: str, base: str, com: Any) -> None:
    _, without = named(space, base=base, com=com, **DAMPED)
    scene, names = named(space, base=base, com=com, **DRY)
    brought = {name: found - without.get(name, set()) - {"friction", "cart_friction"} for name, found in names.items()}
    assert any("saturat" in name for found in brought.values() for name in found)
    for function, found in brought.items():
        rows = {row.name: row for _, row in quantities_of(function, scene)}
        assert found <= set(rows), (function, sorted(found - set(rows)))
        assert all(rows[name].meaning for name in found)
