"""What a Model shows is proven as well: M, N, G, the joints' terms and both sides of (15) and (16)."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import sympy

from phichain.errors import ProofError
from phichain.mechanics.planar import PlanarExpressions
from phichain.mechanics.spatial import SpatialExpressions
from phichain.pipeline import generate
from phichain.proof import prove
from tests.proof.chains import SCENES

#: Terms by chain: only one without a cart has joints here.
TERMS = [
    *(("damped", term) for term in ("mass_matrix", "coriolis", "gravity_torque", "joint_torque")),
    *(("sprung", term) for term in ("mass_matrix", "coriolis", "gravity_torque", "joint_torque")),
    *(("flying", term) for term in ("mass_matrix", "coriolis", "gravity_torque")),
]


def one_entry(matrix: sympy.ImmutableDenseMatrix) -> sympy.ImmutableDenseMatrix:
    """The last entry that is not zero a little larger."""
    entries = list(matrix)
    last = max(i for i, entry in enumerate(entries) if entry != 0)
    entries[last] *= 1 + sympy.Rational(1, 2**50)
    return sympy.ImmutableDenseMatrix(*matrix.shape, entries)


MUTATIONS: dict[str, Callable[[Any], Any]] = {
    "none": lambda term: None, "negated": lambda term: -term, "doubled": lambda term: 2 * term, "zero": lambda term: 0 * term,
    "one entry": one_entry, "a row too few": lambda term: term[:-1, :],
}  # fmt: skip


def mutated(monkeypatch: pytest.MonkeyPatch, term: str, change: Callable[[Any], Any]) -> None:
    for kind in (PlanarExpressions, SpatialExpressions):
        written = kind.__dict__[term].func
        monkeypatch.setattr(kind, term, property(lambda self, written=written: change(written(self))))


@pytest.mark.long
@pytest.mark.parametrize("name", SCENES)
def test_what_is_shown_passes(name: str) -> None:
    prove(SCENES[name])


@pytest.mark.long
@pytest.mark.parametrize("mutation", MUTATIONS)
@pytest.mark.parametrize(("name", "term"), TERMS)
def test_another_term_is_refused(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, name: str, term: str, mutation: str
) -> None:
    mutated(monkeypatch, term, MUTATIONS[mutation])
    with pytest.raises(ProofError, match="as shown") as caught:
        generate(SCENES[name], tmp_path)
    assert "\n" not in str(caught.value) and not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["tips", "flying"])
def test_swapped_sides_are_refused(monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    def swapped(equations: Any) -> Any:
        return tuple(sympy.Eq(equation.lhs, -equation.rhs, evaluate=False) for equation in equations)

    mutated(monkeypatch, "equations", swapped)
    with pytest.raises(ProofError, match="equations as shown"):
        prove(SCENES[name])
