"""A base is a record: laws that only these tests know go the whole road, and nothing but the table names a law."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import phichain
from phichain.contract.bases import bases, law_of, table
from phichain.errors import SceneError
from phichain.ir import evaluate
from phichain.lowering import lower, lower_function
from phichain.mechanics import derive
from phichain.pipeline import build
from phichain.proof import prove
from phichain.scene import Scene, scene_from_dict
from phichain.system.power import powers
from tests.lowering.bases import functions
from tests.lowering.chains import Arguments, gap, random_arguments
from tests.lowering.test_against_reference import agree

MOVING = law_of("moving")
LIFT = replace(
    MOVING, base="lift", told="down", on="on a lift", noun="lift that moves with velocity c_d and acceleration b_d", input="lift_acceleration",
    meaning="acceleration of the lift, down, m/s^2", place="lift", driven="the acceleration of the lift", argument="acceleration of the lift, down, m/s^2",
)  # fmt: skip
SHAKER = replace(LIFT, base="shaker", told="horizontal", on="on a shaker", input="shaking", place="shaker", driven="the acceleration of the shaker")

#: The files of the package that may name a law of the table, and for what.
NAMED = {
    "contract/bases/table.py": "the laws themselves",
    "scene/described.py": "the default, and keys that belong to a cart",
    "scene/schema.py": "the mass that a cart must have",
    "scene/scene.py": "the default",
    "rigs/carts.py": "the keys of a cart from its data sheet",
}


PROVEN = {"forward_dynamics", "linearization", "state_jacobian", "tensions", "constrained_accelerations", "implicit_factors", "implicit_solution"}
WORDS = re.compile(r"""["'](fixed|cart|moving|force|acceleration)["']""")


@pytest.fixture
def more_laws(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(table, "LAWS", (*table.LAWS, LIFT, SHAKER))


def chain(base: str, space: str = "planar", **more: object) -> Scene:
    keys = {"mass": [0.3, 0.2], "length": [0.5, 0.4], "com": [0.2, 0.5], "inertia": [0.01, 0.02], "damping": 0.1}
    return Scene(f"{base}_{space}", 2, space, base, **(keys | more))  # type: ignore[arg-type]


def moved(of: Scene) -> tuple[int, ...]:
    """Where the entries of u stand in that of the base that moves every way."""
    size = 2 if of.is_planar else 3
    return {"lift": (size - 1,), "shaker": tuple(range(size - 1))}[of.base]


def accelerations(of: Scene, arguments: Arguments) -> np.ndarray:
    program = lower_function(derive(of), "forward_dynamics")
    return evaluate(program, {a.name: arguments[a.name] for a in (*program.params, *program.inputs)})["a"]


@pytest.mark.long
@pytest.mark.usefixtures("more_laws")
@pytest.mark.parametrize("space", ["planar", "spatial"])
@pytest.mark.parametrize("base", ["lift", "shaker"])
def test_a_law_of_a_test_is_derived_lowered_and_proven(base: str, space: str) -> None:
    of = chain(base, space, **({"actuated": "all"} if space == "planar" else {}))
    of = replace(of, want=(*functions(of), "propagate_stiff"))
    model = derive(of)
    proof = prove(model, lower(model))
    assert PROVEN <= set(proof.exact)
    agree(of, ("forward_dynamics", "tensions", "linearization", "energy"))


@pytest.mark.usefixtures("more_laws")
@pytest.mark.parametrize("space", ["planar", "spatial"])
@pytest.mark.parametrize("base", ["lift", "shaker"])
def test_it_is_the_moving_base_that_moves_no_other_way(base: str, space: str) -> None:
    of = chain(base, space)
    whole = replace(of, base="moving")
    arguments = random_arguments(of, lower_function(derive(of), "forward_dynamics"), seed=3)
    u = np.zeros(whole.nu)
    u[list(moved(of))] = arguments["u"]
    assert gap(accelerations(of, arguments), accelerations(whole, arguments | {"u": u})) < 1e-15


@pytest.mark.usefixtures("more_laws")
@pytest.mark.parametrize("base", ["lift", "shaker"])
@pytest.mark.parametrize("form", [{}, {"damping": None}, {"com": None, "inertia": None}, {"com": None, "inertia": None, "damping": None}])
def test_derivatives_by_its_acceleration_are_those_along_its_axes(form: dict[str, object], base: str) -> None:
    """In every form that spatial derivatives have: of points or rods, tied or free."""
    of = chain(base, "spatial", want=["state_jacobian"], **form)
    whole, program = replace(of, base="moving"), lower_function(derive(of), "state_jacobian")
    arguments = random_arguments(of, program, seed=3)
    u = np.zeros(whole.nu)
    u[list(moved(of))] = arguments["u"]
    ours, theirs = evaluate(program, arguments), evaluate(lower_function(derive(whole), "state_jacobian"), arguments | {"u": u})
    assert gap(ours["dadu"], theirs["dadu"][:, list(moved(of))]) < 1e-14 and gap(ours["dadq"], theirs["dadq"]) < 1e-14


@pytest.mark.usefixtures("more_laws")
def test_it_is_compiled_flown_forced_and_its_work_is_booked() -> None:
    of = chain("lift", want=["forward_dynamics", "propagate", "energy"], forced="lift")
    assert (of.axis, of.u_names) == (2, ("lift_acceleration_2",))
    ours, whole = build(of), build(replace(of, base="moving", forced="base", axis=2))
    start = (np.array([0.4, -0.3]), np.array([0.2, 0.5]))
    found = ours.propagate(*start, 0.0, 2.0, 1e-13, u=[1.5], forcing=(2.0, 5.0))
    told = whole.propagate(*start, 0.0, 2.0, 1e-13, u=[0.0, 1.5], forcing=(2.0, 5.0))
    assert gap(found.q, told.q) < 1e-11
    x = np.concatenate(start)[None]
    assert gap(powers(ours, x, np.array([[1.5]])).work, powers(whole, x, np.array([[0.0, 1.5]])).work) < 1e-15


@pytest.mark.usefixtures("more_laws")
def test_every_layer_speaks_of_it() -> None:
    of = chain("lift")
    assert "on a lift" in str(of) and "lift that moves" in str(derive(of))
    assert scene_from_dict(of.to_dict()) == of
    with pytest.raises(SceneError, match="forced along .got 1.; use 2"):
        chain("lift", want=["propagate"], forced="lift", axis=1)


def test_without_the_tests_laws_nobody_knows_them() -> None:
    assert bases() == ("fixed", "cart", "moving")
    with pytest.raises(SceneError, match='use "fixed" or "cart" or "moving"'):
        chain("lift")


def meetings(node: ast.AST) -> Iterator[list[ast.AST]]:
    """What is compared with, passed as, or the default of one another."""
    match node:
        case ast.Compare(left, _, others):
            yield [left, *others]
        case ast.keyword(str(name), value):
            yield [ast.Name(name), value]
        case ast.Dict(keys, values):
            yield from ([ast.Name(key.value), value] for key, value in zip(keys, values, strict=True) if isinstance(key, ast.Constant))
        case ast.arguments(_, args, _, _, _, _, defaults):
            yield from ([ast.Name(name.arg), value] for name, value in zip(args[::-1], defaults[::-1], strict=False))
        case ast.Call(args=[ast.Constant(name), ast.Constant() as value]) | ast.Tuple([ast.Constant(name), ast.Constant() as value]):
            yield [ast.Name(str(name)), value]


def names_a_law(sides: list[ast.AST]) -> bool:
    """Whether one of them is called `base` or `drive`, and there is a word among them."""
    names = {getattr(side, "attr", getattr(side, "id", "")) for side in sides}
    parts = [part for side in sides for part in (side.elts if isinstance(side, ast.Tuple) else [side])]
    words = [part for part in parts if isinstance(part, ast.Constant) and isinstance(part.value, str)]
    return bool(words and {"base", "drive"} & names)


def laws_named(text: str) -> int:
    """How often a source text names a law."""
    return sum(map(names_a_law, (sides for node in ast.walk(ast.parse(text)) for sides in meetings(node))))


def test_no_layer_asks_which_law_it_is() -> None:
    """One file holds the laws and a handful name one; the limit is twelve."""
    root = Path(phichain.__file__).parent
    texts = {str(file.relative_to(root)): file.read_text() for file in root.rglob("*.py")}
    named = {name for name, text in texts.items() if WORDS.search(text) and laws_named(text)}
    assert named == set(NAMED) and len(NAMED) <= 12


@pytest.mark.parametrize("text", ['if scene.base == "moving": f()', 'x = "force" != drive', 'base in ("fixed", "cart")', 'f(base="cart")', 'd = {"drive": "force"}'])
def test_a_name_is_seen(text: str) -> None:
    assert laws_named(text)
    assert not laws_named(text.replace("base", "ground").replace("drive", "push"))
