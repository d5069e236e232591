"""Generation makes SymPy terms in proportion to the links: nothing is multiplied out, checked or shown in N^2 of them."""

from __future__ import annotations

from typing import Any

import pytest
import sympy
from sympy.core.cache import clear_cache

from phichain.emit import library_files
from phichain.lowering import lower
from phichain.mechanics import derive
from phichain.proof import prove
from phichain.scene import Scene

KINDS: dict[str, dict[str, Any]] = {
    "planar on a cart": {"base": "cart", "cart_mass": 0.7, "damping": 0.1, "stiffness": 2.0},
    "planar, runtime": {"mass": "runtime", "length": "runtime"},
    "spatial": {"space": "spatial", "damping": 0.1},
}


@pytest.mark.parametrize("kind", KINDS.values(), ids=list(KINDS))
def test_sums_and_products_grow_with_the_links(kind: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    made = 0
    for operation in (sympy.Add, sympy.Mul):

        def flatten(entries: list[Any], true: Any = operation.flatten) -> Any:
            nonlocal made
            made += 1
            return true(entries)

        monkeypatch.setattr(operation, "flatten", flatten)
    counts = []
    for links in (12, 24, 48):
        clear_cache()
        made = 0
        scene = Scene("chain", links, **{"mass": 1.5, "length": 0.7} | kind, want=["forward_dynamics", "energy"])
        lowered = lower(derive(scene))
        assert prove(lowered.model, lowered).record
        assert library_files(scene, lowered)
        counts.append(made)
    assert counts[0] > 100 and counts[2] - counts[1] < 2.1 * (counts[1] - counts[0]), counts
