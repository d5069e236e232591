"""The C of step_lie4 and step_variational: strict in every form, with nothing exported but what was wanted."""

from __future__ import annotations

from itertools import product
from pathlib import Path
from typing import Any

import pytest

from phichain.scene import Scene
from tests.generated.compiling import PLAIN, STRICT, compiled, symbols, write_c

WANT = ["step_lie4", "step_variational"]
LINKS: dict[str, Any] = {"mass": [0.7, 1.9, 0.4], "length": [0.5, 1.3, 0.8]}
KINDS: dict[str, dict[str, Any]] = {
    "plane_bent": {
        "space": "planar",
        "com": [0.3, 0.9, 0.6],
        "damping": 0.1,
        "stiffness": 2.0,
        "actuated": [1, 3],
    },
    "space_cart": {"space": "spatial", "base": "cart", "cart_mass": "runtime"},
}


@pytest.mark.long
@pytest.mark.parametrize("name", KINDS)
def test_it_compiles_without_a_word_and_exports_the_steps_alone(name: str, tmp_path: Path) -> None:
    for code, real in product(("loops", "unrolled"), ("double", "float")):
        scene = Scene(f"{name}_{code}_{real}", 3, want=WANT, code=code, real=real, **(LINKS | KINDS[name]))
        found = symbols(compiled(write_c(scene, tmp_path), *STRICT, *PLAIN, "-O1"))
        assert found.exported == {f"{scene.name}_{step}" for step in WANT}
        assert found.writable == frozenset()


def test_the_stack_grows_with_the_chain_alone(tmp_path: Path) -> None:
    """Loops stay loops: the text of 64 links is that of 34, whose numbers have as many digits."""
    lines = []
    for links in (34, 64):
        scene = Scene("chain_x", links, space="spatial", mass=0.1, length=0.1, want=WANT, code="loops")
        lines.append(len(write_c(scene, tmp_path).read_text().splitlines()))
    assert lines[0] == lines[1]
