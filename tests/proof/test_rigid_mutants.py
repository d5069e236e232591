"""Wrong moments of rigid links, each refused by the exact proof or by the digest of the Lagrangian's coefficients."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from fractions import Fraction
from itertools import product
from typing import Any

import pytest
import sympy

from phichain.errors import DerivationError, ProofError
from phichain.lowering import lower
from phichain.lowering.chain import body
from phichain.lowering.chain.body import Moments, point_masses
from phichain.mechanics import Model, derive
from phichain.proof import prove
from phichain.scene import Scene

KEYS: dict[str, Any] = {"mass": [0.3, 0.2], "length": [0.5, 0.4], "inertia": [0.01, 0.02], "want": ["forward_dynamics"]}
CHAINS = {
    "rods": Scene("rods", 2, base="cart", cart_mass=0.7, com=[0.2, 0.5], **KEYS),
    "runtime cart": Scene("runtime_cart", 2, base="cart", cart_mass="runtime", com=[0.2, 0.5], **KEYS),
    "wheel": Scene("wheel", 2, base="cart", cart_mass=0.7, com=[0.2, 0.0], actuated="all", **KEYS),
    "bars": Scene("bars", 2, space="spatial", base="cart", cart_mass=0.7, com=[0.2, 0.5], **KEYS),
    "held": Scene("held", 2, space="spatial", base="cart", cart_mass=0.7, com=[0.2, 0.0], stiffness=0.5, **KEYS),
}


def _moments(change: Callable[[Moments], Moments]) -> Callable[[Scene], Moments]:
    true = body.moments
    return lambda scene: change(true(scene))


def _nudged(values: tuple[Fraction, ...], k: int) -> tuple[Fraction, ...]:
    return tuple(value * (1 + (i == k) * Fraction(1, 2**40)) for i, value in enumerate(values))


MUTANTS: dict[str, Callable[[Moments], Moments]] = {
    "first moment of the tip": lambda found: replace(found, first=_nudged(found.first, 1)),
    "first moment of the base": lambda found: replace(found, first=_nudged(found.first, 0)),
    "second moment of the tip": lambda found: replace(found, second=_nudged(found.second, 1)),
    "second moment of the base": lambda found: replace(found, second=_nudged(found.second, 0)),
    "mass on the cart": lambda found: replace(found, left=found.left * (1 + Fraction(1, 2**40))),
    "no mass on the cart": lambda found: replace(found, left=Fraction(0)),
}


@pytest.fixture(autouse=True)
def forgets() -> Iterator[None]:
    """Chains of points are remembered."""
    point_masses.cache_clear()
    yield
    point_masses.cache_clear()


#: A first moment of zero stays zero, and what is left on a cart of unknown mass is the difference of the masses.
CASES = [
    (name, mutant)
    for name, mutant in product(CHAINS, MUTANTS)
    if not (name in ("wheel", "held") and mutant == "first moment of the tip" or name == "runtime cart" and "cart" in mutant)
]


@pytest.mark.long
@pytest.mark.parametrize(("name", "mutant"), CASES)
def test_wrong_moments_are_refused(name: str, mutant: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(body, "moments", _moments(MUTANTS[mutant]))
    with pytest.raises(ProofError, match="does not meet the Lagrangian"):
        prove(CHAINS[name])


def test_true_moments_are_proven() -> None:
    assert all(proven.is_exact for chain in CHAINS.values() for proven in prove(chain).functions)


@pytest.mark.parametrize("space", ["planar", "spatial"])
def test_chains_too_long_to_fold_are_proven(space: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Their moments are computed by the emitted code."""
    monkeypatch.setattr(body, "_LONGEST", 2)
    keys = {"mass": 0.3, "length": [0.5, 0.4, 0.2], "com": 0.2, "inertia": [0.01, 0.02, 0.01], "stiffness": 0.1}
    want = ["forward_dynamics", "propagate", "step_rosenbrock", "step_variational", "state_jacobian"]
    prove(Scene("long_chain", 3, space=space, base="cart", cart_mass=0.7, want=want, **keys))


def _without_inertia(model: Model) -> Model:
    """A Lagrangian of the same masses as points."""
    spins = {symbol: sympy.S.Zero for symbol in model.energies.kinetic.free_symbols if str(symbol).startswith("qdot")}
    return Model(model.scene, replace(model.energies, kinetic=model.energies.kinetic.xreplace(spins)))


def _doubled(model: Model) -> Model:
    spins = {symbol: 2 * symbol for symbol in model.energies.kinetic.free_symbols if str(symbol) == "qdot_2_1"}
    return Model(model.scene, replace(model.energies, kinetic=model.energies.kinetic.xreplace(spins)))


@pytest.mark.parametrize("mutant", [_without_inertia, _doubled])
@pytest.mark.parametrize("name", CHAINS)
def test_wrong_lagrangians_are_refused(name: str, mutant: Callable[[Model], Model]) -> None:
    with pytest.raises(DerivationError, match="Lagrangian"):
        lower(mutant(derive(CHAINS[name])))
