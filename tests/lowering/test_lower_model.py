"""The Lagrangian writes the dynamics: a Model with any other one is not lowered, whatever is wrong with it."""

from __future__ import annotations

import re
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
import sympy

from phichain import build, generate
from phichain.errors import DerivationError
from phichain.ir.builder import Builder
from phichain.lowering import lower, lower_function
from phichain.lowering.chain.parameters import Parameters
from phichain.mechanics import Model, derive
from phichain.mechanics.planar import PlanarExpressions
from phichain.mechanics.spatial import SpatialExpressions
from phichain.scene import Scene
from tests.lowering.model_mutants import KINDS, model_of, mutants

ONE_SENTENCE = re.compile(r"Lagrangian(\.\w+)?: .*\(got .+\); .+")


@pytest.mark.long
@pytest.mark.parametrize("kind", KINDS)
def test_every_mutant_of_the_lagrangian_is_refused(kind: str) -> None:
    model, survivors, count = model_of(kind), [], 0
    for name, mutant in mutants(model):
        count += 1
        try:
            lower(mutant)
        except DerivationError as error:
            assert ONE_SENTENCE.fullmatch(str(error)), error
        else:
            survivors.append(name)
    assert not survivors
    assert count >= 60


@pytest.mark.parametrize("kind", KINDS)
def test_the_model_itself_is_lowered(kind: str) -> None:
    assert set(lower(model_of(kind)).wanted) == {"forward_dynamics", "energy"}


@pytest.mark.parametrize("kind", ["planar cart", "spatial cart, runtime"])
def test_one_function_alone_is_refused_too(kind: str) -> None:
    for _, mutant in mutants(model_of(kind)):
        with pytest.raises(DerivationError):
            lower_function(mutant, "energy")


@pytest.mark.parametrize(
    ("kind", "mutant", "message"),
    [
        ("planar fixed", "c_1_3", "Lagrangian.c_1_3: in the Model's Lagrangian is not the 0.015 that the Programs"),
        ("planar fixed, runtime", "c_1_2", "Lagrangian.c_1_2: in the Model's Lagrangian is not the l_1*(l_2*m_3 + m_2*r_2)"),
        ("planar cart", "M00", "Lagrangian.M00: in the Model's Lagrangian is not the 4.5 that the Programs"),
        ("planar cart", "mu_2 in T", "Lagrangian.coupling_2: in the Model's Lagrangian is not the 0.4"),
        ("spatial fixed", "gravity dropped", "Lagrangian.g: in the Model's Lagrangian is not the 9.81"),
        ("spatial fixed", "k_2", "Lagrangian.k_2: in the Model's Lagrangian is not the 0.2 that the Programs"),
        ("spatial fixed", "d_3", "Lagrangian.d_3: in the Model's Lagrangian is not the 0.2 that the Programs"),
        ("planar cart", "the cart's friction", "Lagrangian.R: is not the form whose coefficients"),
    ],
)
def test_the_error_names_the_coefficient_and_both_values(kind: str, mutant: str, message: str) -> None:
    with pytest.raises(DerivationError) as caught:
        lower(dict(mutants(model_of(kind)))[mutant])
    assert str(caught.value).startswith(message), caught.value
    assert "derive the model with phichain.derive" in caught.value.remedy


@pytest.mark.parametrize("name", ["kinetic", "potential"])
@pytest.mark.parametrize("factor", [0, 2, -1])
@pytest.mark.parametrize("kind", KINDS)
def test_what_a_short_chain_shows_is_what_it_is(
    kind: str, factor: int, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """T and V as they are written out, too, not only in their definitions."""
    written = PlanarExpressions if KINDS[kind].get("space") != "spatial" else SpatialExpressions
    right = getattr(written, name).func
    monkeypatch.setattr(written, name, property(lambda self: factor * right(self)))
    with pytest.raises(DerivationError, match=f"Lagrangian.{'T' if name == 'kinetic' else 'V'}: "):
        lower(model_of(kind))


@pytest.mark.parametrize("verb", [generate, build])
def test_nothing_is_generated_or_built_from_another_lagrangian(
    verb: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = Scene("duo", 2, mass="runtime", length=0.5, want=["energy"])
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("phichain.scratch.derive", lambda given: dict(mutants(model_of("planar fixed")))["kinetic := 0"])
    with pytest.raises(DerivationError, match="Lagrangian"):
        verb(scene)
    assert not list(tmp_path.iterdir())


def test_the_coefficients_of_a_program_are_read_off_the_lagrangian() -> None:
    """With T := 0 the Parameters hold zeros: there is no other source of mu, c_kk and M00."""
    model = model_of("planar cart")
    still = dict(mutants(model))["kinetic := 0"]
    known = Parameters(Builder("any", ""), still)
    assert known.total_mass.constant == 0 and known.c_diagonal[1].constant == 0
    true = Parameters(Builder("any", ""), model)
    assert true.c_diagonal[1].constant == model.c[1][1] != 0


@pytest.mark.parametrize("name", ["mu", "c_diagonal", "total_mass", "outer_mass"])
def test_recurrences_of_runtime_parameters_are_held_against_the_lagrangian(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A wrong recurrence is as bad as a wrong Lagrangian."""
    right = getattr(Parameters, name).fget

    def wrong(self: Parameters) -> Any:
        value = right(self)
        if name == "total_mass":
            return value + value
        return self.derived(f"{name}_doubled", lambda k: value[k] + value[k])

    monkeypatch.setattr(Parameters, name, property(wrong))
    with pytest.raises(DerivationError, match=r"Lagrangian\.\w+: "):
        lower(model_of("planar cart, runtime"))


def test_coefficients_of_a_mixed_product_are_read_too() -> None:
    """T in other terms, equal as a form, is the same Lagrangian: it is read, not recognised."""
    model = model_of("planar fixed")
    other = _rewritten(model)
    assert other.energies.kinetic != model.energies.kinetic
    assert other.c == model.c
    assert lower(other).wanted == lower(model).wanted


def _rewritten(model: Model) -> Model:
    a, b = sympy.symbols("rdot_1_1 rdot_2_1")
    mixed = model.energies.kinetic + (a + b) ** 2 / 4 - (a - b) ** 2 / 4 - a * b
    return replace(model, energies=replace(model.energies, kinetic=mixed))


def test_a_long_chain_is_checked_as_well() -> None:
    scene = Scene("long_chain", 64, mass=[1 / (k + 2) for k in range(64)], length=0.5, com=0.2, want=["energy"])
    model = derive(scene)
    assert model.mu[63] == Fraction(1 / 65) * Fraction(0.2)
    lower(model)
    for name, mutant in mutants(model):
        if name in ("c_1_2", "kinetic doubled", "gravity dropped", "r_2_2 doubled"):
            with pytest.raises(DerivationError):
                lower(mutant)
