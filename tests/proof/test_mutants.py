"""No mutant passes: Programs with one small change and Models with another Lagrangian are refused, each in one sentence.

A mutant that computes the same function is no fault. Those are told by another arithmetic, 50 digits at random states, and counted apart.
"""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from types import MappingProxyType
from typing import Any

import mpmath
import pytest
import sympy

from phichain.contract.functions import PLANAR_FUNCTIONS, SPATIAL_FUNCTIONS
from phichain.errors import ProofError
from phichain.ir.evaluate import evaluate_exactly
from phichain.ir.nodes import Program
from phichain.lowering import Lowered, lower
from phichain.mechanics import Model, derive
from phichain.mechanics.energies import names_of
from phichain.proof import prove
from phichain.scene import Scene
from tests.proof.mutations import Mutant, mutants

PLANAR = tuple(name for name in PLANAR_FUNCTIONS if name != "propagate") + ("momentum",)
SPATIAL = tuple(name for name in SPATIAL_FUNCTIONS if name != "propagate") + ("momentum",)
DAMPED = tuple(name for name in PLANAR if not name.startswith("phi"))
TWO = {"mass": [0.3, 0.2], "length": [0.5, 0.4]}
THREE = {"mass": [0.3, 0.2, 0.1], "length": [0.5, 0.4, 0.3]}

SCENES = {
    scene.name: scene
    for scene in (
        Scene("tips", 2, **TWO, actuated="all", want=PLANAR),
        Scene("coms", 2, **TWO, com=[0.2, 0.3], actuated="all", want=PLANAR),
        Scene("carted", 2, base="cart", cart_mass=0.7, **TWO, com=[0.2, 0.3], stiffness=[1.5, 0.5], want=PLANAR),
        Scene("damped", 2, **TWO, com=[0.2, 0.3], stiffness=1.0, damping=[0.1, 0.2], want=DAMPED),
        Scene("adjacent", 3, **THREE, angles="adjacent", actuated="all", want=PLANAR),
        Scene("absolute", 3, **THREE, com=0.2, angles="absolute", actuated="all", want=PLANAR, code="loops"),
        Scene("runtime", 2, mass="runtime", length="runtime", com="runtime", gravity="runtime", want=PLANAR, code="loops"),
        Scene("spatial", 2, space="spatial", **TWO, want=SPATIAL),
        Scene("flying", 2, space="spatial", base="cart", cart_mass=0.7, **TWO, com=[0.2, 0.3], want=SPATIAL),
        Scene("sprung", 2, space="spatial", **TWO, com=[0.2, 0.3], stiffness=1.0, damping=0.2, want=SPATIAL, code="loops"),
    )
}  # fmt: skip


@cache
def lowered(name: str) -> Lowered:
    return lower(derive(SCENES[name]))


def alone(whole: Lowered, program: Program) -> Lowered:
    """One function, and the forward dynamics that a Jacobian leans on."""
    wanted = {"forward_dynamics": whole.wanted["forward_dynamics"]} | {program.name: program}
    return replace(whole, wanted=MappingProxyType(wanted), helpers=MappingProxyType({}))


def state(scene: Scene, program: Program) -> dict[str, list[Any]]:
    """Arguments of 50 digits on the manifold of the chain's states."""
    source = random.Random(program.name)

    def numbers(count: int) -> list[Any]:
        return [mpmath.mpf(source.randrange(1, 1 << 40)) / (1 << 40) for _ in range(count)]

    values = {array.name: numbers(array.size) for array in (*program.params, *program.inputs)}
    if "s" in values:
        values["s"] = [mpmath.mpf(source.choice((-1, 1))) for _ in values["s"]]
    if not scene.is_planar and "q" in values:
        carts = 2 * scene.has_cart
        for k in range(carts, scene.nq, 3):
            link = values["q"][k : k + 3]
            length = mpmath.sqrt(sum(x * x for x in link))
            values["q"][k : k + 3] = link = [x / length for x in link]
            for rate in ("v", "q_dot"):
                if rate in values:
                    across = values[rate][k : k + 3]
                    along = sum(x * y for x, y in zip(link, across, strict=True))
                    values[rate][k : k + 3] = [x - along * y for x, y in zip(across, link, strict=True)]
    return values


def computes_the_same(scene: Scene, program: Program, mutant: Program) -> bool:
    with mpmath.workdps(50):
        given = state(scene, program)
        true = evaluate_exactly(program, given)
        try:
            found = evaluate_exactly(mutant, given)
        except (KeyError, ZeroDivisionError):
            return False
        pairs = [pair for name in true for pair in zip(true[name], found[name], strict=True)]
        return all(abs(a - b) <= mpmath.mpf(10) ** -40 * (1 + abs(a)) for a, b in pairs)


def program_mutants(name: str) -> Iterator[Mutant]:
    whole = lowered(name)
    for program in whole.wanted.values():
        yield from mutants(program, per_kind=1)


@pytest.mark.parametrize("name", SCENES)
def test_every_mutant_of_a_program_is_refused(name: str) -> None:
    whole, scene = lowered(name), SCENES[name]
    refused, same, missed = Counter[str](), Counter[str](), []
    for mutant in program_mutants(name):
        try:
            prove(whole.model, alone(whole, mutant.program))
        except ProofError as refusal:
            assert refusal.function == mutant.program.name
            assert str(refusal.point) in refusal.problem
            refused[mutant.kind] += 1
        else:
            if computes_the_same(scene, whole.wanted[mutant.program.name], mutant.program):
                same[mutant.kind] += 1
            else:
                missed.append(f"{mutant.program.name}: {mutant.kind}")
    print(name, sum(refused.values()), dict(same))
    assert not missed
    assert sum(refused.values()) >= 40, refused
    assert sum(same.values()) <= sum(refused.values()) // 4, same


def model_mutants(model: Model) -> Iterator[tuple[str, Model]]:
    """Models with another T, V or R: as a whole, in one of their terms, or in one of the definitions they lean on."""

    def changed(what: str, **energies: Any) -> tuple[str, Model]:
        return what, replace(model, energies=replace(model.energies, **energies))

    for name in ("kinetic", "potential", "dissipation"):
        whole = getattr(model.energies, name)
        if whole == 0:
            continue
        yield changed(f"{name} := 0", **{name: sympy.S.Zero})
        yield changed(f"2 {name}", **{name: 2 * whole})
        yield changed(f"-{name}", **{name: -whole})
        for i, term in enumerate(sympy.Add.make_args(whole)):
            yield changed(f"{name} without term {i}", **{name: whole - term})
            yield changed(f"{name} with term {i} by one ulp", **{name: whole + term * sympy.Rational(1, 2**53)})
    energies = model.energies
    used = {s for _, e in energies.definitions for s in e.free_symbols} | energies.kinetic.free_symbols
    used |= energies.potential.free_symbols | energies.dissipation.free_symbols
    for i, (symbol, expression) in enumerate(energies.definitions):
        # What nothing leans on, the place of the tip's joint, is no part of T, V or R.
        if symbol not in used:
            continue
        for what, other in (("-", -expression), ("2 ", 2 * expression), ("0 ", sympy.S.Zero)):
            if other != expression:
                definitions = list(model.energies.definitions)
                definitions[i] = (symbol, other)
                yield changed(f"{what}{symbol}", definitions=tuple(definitions))


def energies_at_random(model: Model) -> list[Any]:
    """T, V, R and the positions of the masses at one random state, by SymPy's own arithmetic in 40 digits."""
    source, values = random.Random(1), dict[Any, Any]()

    def value(expression: sympy.Expr) -> Any:
        for symbol in sorted(expression.free_symbols - set(values), key=str):
            values[symbol] = sympy.Rational(source.randrange(1, 1 << 20), 1 << 20)
        return expression.xreplace(values).evalf(40)

    for symbol, expression in model.energies.definitions:
        values[symbol] = value(expression)
    names = names_of(model.scene)
    places = [place for k in range(1, model.scene.links + 1) for place in names.mass(k)]
    energies = model.energies
    return [value(entry) for entry in (energies.kinetic, energies.potential, energies.dissipation, *places)]


def is_the_same(model: Model, mutant: Model) -> bool:
    pairs = zip(energies_at_random(model), energies_at_random(mutant), strict=True)
    return all(abs(a - b) < sympy.Float("1e-30", 40) for a, b in pairs)


@pytest.mark.parametrize("name", SCENES)
def test_every_mutant_of_a_model_is_refused_whatever_its_programs_are(name: str) -> None:
    whole = lowered(name)
    # Without Programs: the Lagrangian alone is refused, so Programs that follow it cannot help it.
    bare = replace(whole, wanted=MappingProxyType({}), helpers=MappingProxyType({}))
    refused, same, missed = 0, [], []
    for what, mutant in model_mutants(whole.model):
        try:
            prove(mutant, bare)
        except ProofError as refusal:
            assert "positions of the masses" in refusal.problem
            refused += 1
        else:
            (same if is_the_same(whole.model, mutant) else missed).append(what)
    print(name, refused, same)
    assert not missed
    assert refused >= 40
    # -y in the place of y, where y enters squared
    assert all(what.startswith("-") for what in same), same


def test_a_doubled_lagrangian_is_refused_with_programs_that_follow_it() -> None:
    """Masses doubled and gravity with them: the Programs of one chain solve the Lagrangian of another, consistently."""
    scene = SCENES["coms"]
    heavy = lower(derive(replace_masses(scene, [0.6, 0.4])))
    double = replace(heavy.model, scene=scene)
    with pytest.raises(ProofError, match="coms: T"):
        prove(double, replace(heavy, model=double))


def replace_masses(scene: Scene, mass: list[float]) -> Scene:
    return replace(scene, mass=mass)
