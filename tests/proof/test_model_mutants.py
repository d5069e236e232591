"""No mutant of a Model passes: T, V or R other than those of the scene's masses are refused, whatever the Programs do.

A mutant that is the same T, V and R is no fault: those are told by SymPy's own arithmetic and counted apart.
"""

from __future__ import annotations

import random
from collections.abc import Iterator
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import pytest
import sympy

from phichain.errors import ProofError
from phichain.lowering import lower
from phichain.mechanics import Model, derive
from phichain.mechanics.energies import names_of
from phichain.proof import prove
from phichain.scene import Scene
from tests.proof.chains import SCENES, lowered

CHAINS = ("tips", "damped", "adjacent", "runtime", "flying", "sprung", "geared_cart", "shaken", "stepper_space")


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


@pytest.mark.long
@pytest.mark.parametrize("name", CHAINS)
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
