"""The coefficients that lowering computes by recurrences against those that the Lagrangian yields: two derivations, one chain."""

from __future__ import annotations

from phichain.errors import DerivationError
from phichain.ir.builder import Builder
from phichain.lowering.parameters import Parameters
from phichain.mechanics import Model


def check_coefficients(model: Model) -> None:
    """Compare mu_k, c_ij and M00 exactly; scenes with runtime parameters have no numbers to compare.

    Raises:
        DerivationError: they differ, which no scene should bring about.
    """
    scene = model.scene
    if {"mass", "length", "com", "cart_mass"} & set(scene.runtime):
        return
    parameters = Parameters(Builder("crosscheck", ""), scene)
    for k in range(scene.links):
        _same(f"mu_{k + 1}", parameters.mu[k].constant, model.mu[k])
        _same(f"c_{k + 1}_{k + 1}", parameters.c_diagonal[k].constant, model.c[k][k])
        for j in range(k + 1, scene.links):
            product = (parameters.length[k] * parameters.mu[j]).constant
            _same(f"c_{k + 1}_{j + 1}", product, model.c[k][j])
    _same("M00", parameters.total_mass.constant, model.total_mass)


def _same(name: str, lowered: object, derived: object) -> None:
    if lowered != derived:
        raise DerivationError(
            name, lowered, f"lowering and the Lagrangian ({derived}) disagree", "report this scene, its numbers are not to be used"
        )
