"""Taylor recurrences are proven as truncated power series, and no mutant of them passes.

A mutant that expands the same motion is no fault. Those are told by another arithmetic, 50 digits over more orders, and counted apart.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from typing import Any

import pytest
from mpmath import mp

from phichain.errors import ProofError
from phichain.lowering.series.run import expand, expand_column
from phichain.lowering.series.series import Series
from phichain.lowering.series.spatial import spatial_series
from phichain.mechanics import Model, derive
from phichain.proof.identities.recurrences import ORDERS
from phichain.proof.prove import prove_recurrences
from phichain.scene import Scene
from tests.lowering.taylor_oracle import EXACT, Row, gap, state
from tests.proof.mutations import mutants

PER_KIND = {"factor": 4, "order": 4, "columns": 1}
UNEVEN: dict[str, Any] = {"mass": [0.7, 1.9, 0.4], "length": [0.5, 1.3, 0.8], "space": "spatial"}
CART: dict[str, Any] = {"base": "cart", "cart_mass": 0.9, "code": "loops"}
JOINTS: dict[str, Any] = {"stiffness": [2.0, 0.5, 1.5], "damping": [0.3, 0.1, 0.2]}
CHAINS = {
    scene.name: scene
    for scene in (
        Scene("tips", 3, **UNEVEN, want=("propagate",), variational=True),
        Scene("damped", 3, **UNEVEN, **CART, **JOINTS),
        Scene("coms", 3, **UNEVEN, **CART, com=[0.3, 0.9, 0.5]),
        Scene("runtime", 3, **{**UNEVEN, "mass": "runtime", "length": "runtime"}, **CART),
    )
}


def made(name: str) -> tuple[Model, Series]:
    model = derive(CHAINS[name])
    return model, spatial_series(model)


@pytest.mark.parametrize("name", CHAINS)
def test_recurrences_are_proven(name: str) -> None:
    found = prove_recurrences(*made(name))
    assert found.is_exact and f"{ORDERS} orders" in found.how


def changed(series: Series) -> Iterator[tuple[str, Series]]:
    """Mutants of all Programs of a series."""
    for part, per_kind in PER_KIND.items():
        program = getattr(series, part)
        for mutant in mutants(program, per_kind) if program is not None else ():
            yield f"{part}: {mutant.kind}", replace(series, **{part: mutant.program})


def expanded(scene: Scene, series: Series) -> list[Row]:
    """Coefficients, and those of a column, in 50 digits."""
    at = state(scene, 2)
    with mp.workdps(60):
        rho = Fraction(3, 8)
        base = expand(series, EXACT, ORDERS + 3, at.q, at.v, at.u, rho, **at.params)
        if series.columns is None:
            return base.state
        return [*base.state, *expand_column(series, EXACT, base, at.v, [x * 0 for x in at.v]).state]


def expands_the_same(scene: Scene, series: Series, mutant: Series) -> bool:
    return gap(expanded(scene, mutant), expanded(scene, series)) < 1e-40


@pytest.mark.parametrize("name", CHAINS)
def test_no_mutant_passes(name: str) -> None:
    model, series = made(name)
    fates: Counter[str] = Counter()
    for kind, mutant in changed(series):
        try:
            prove_recurrences(model, mutant)
        except ProofError as refusal:
            assert "\n" not in str(refusal) and "Traceback" not in str(refusal)
            fates["refused"] += 1
        else:
            assert expands_the_same(model.scene, series, mutant), kind
            fates["no fault"] += 1
    assert fates["refused"] >= 50 and fates["no fault"] <= fates["refused"] // 5, fates
