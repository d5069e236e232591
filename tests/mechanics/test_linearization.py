"""The symbolic linearisation (19) against the reference, and its form with the signs as symbols."""

from __future__ import annotations

import itertools
from typing import Any

import pytest
import sympy
from mpmath import mpf

from phichain.errors import ArrayError
from phichain.mechanics import derive
from phichain.mechanics.linearization import linearize
from phichain.reference import reference
from phichain.scene import Scene
from tests.reference_cases import relative_error

SIZES: dict[str, Any] = {
    "links": 3,
    "mass": [0.7, 1.1, 0.4],
    "length": [0.5, 0.8, 0.3],
    "com": [0.2, 0.8, 0.1],
}
JOINTS: dict[str, Any] = {"damping": [0.3, 0.1, 0.2], "stiffness": [2.0, 0.5, 1.5]}
CART: dict[str, Any] = {"base": "cart", "cart_mass": 0.9}
SCENES = {
    "relative": Scene("a", **SIZES, actuated=[1, 3]),
    "adjacent-joints": Scene("a", **SIZES, **JOINTS, angles="adjacent", actuated="all"),
    "absolute-cart": Scene("a", **SIZES, **CART, **JOINTS, angles="absolute"),
    "relative-cart": Scene("a", **SIZES, **CART, actuated="none"),
    "spatial": Scene("a", space="spatial", **SIZES),
    "spatial-cart-joints": Scene("a", space="spatial", **SIZES, **CART, **JOINTS),
}


def entries(matrix: Any) -> list[Any]:
    return [mpf(entry.p) / entry.q for entry in matrix]


@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES.keys())
def test_the_matrices_are_those_of_the_reference_at_every_equilibrium(scene: Scene) -> None:
    model = derive(scene)
    for signs in itertools.product((1, -1), repeat=3):
        expected = reference(scene, "linearization", {"s": signs}, digits=30)
        found = linearize(model, signs)
        assert found.signs == signs
        assert ("D" in expected) == any(found.D)
        for name, matrix in expected.items():
            assert relative_error(entries(getattr(found, name)), matrix) < 1e-14, name
        assert found.M.is_symmetric() and found.G.is_symmetric()


@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES.keys())
def test_symbolic_signs_give_every_equilibrium_at_once(scene: Scene) -> None:
    model = derive(scene)
    general = linearize(model)
    assert [str(s) for s in general.signs] == ["s_1", "s_2", "s_3"]
    for signs in itertools.product((1, -1), repeat=3):
        values = dict(zip(general.signs, signs, strict=True))
        for name in "MDGB":
            assert getattr(general, name).xreplace(values) == getattr(linearize(model, signs), name)


def test_paper_b_gravity_block_weighs_all_outer_masses() -> None:
    """G_qq = s_1 (sum m_a) g l_1 I_2, ..., s_n m_n g l_n I_2; the printed parentheses are misplaced."""
    scene = Scene(
        "a", 2, "spatial", "cart", mass="runtime", length="runtime", cart_mass="runtime", gravity="runtime"
    )
    m_1, m_2, l_1, l_2, g = sympy.symbols("m_1 m_2 l_1 l_2 g", positive=True)
    s_1, s_2 = sympy.symbols("s_1 s_2")
    top, tip = s_1 * g * l_1 * (m_1 + m_2), s_2 * g * l_2 * m_2
    assert linearize(derive(scene)).G == sympy.diag(0, 0, top, top, tip, tip)


@pytest.mark.parametrize("signs", [(1, 1), (1, 1, 0), (1, 1, 2), ()])
def test_signs_must_be_one_per_link(signs: tuple[int, ...]) -> None:
    with pytest.raises(ArrayError, match="3 times"):
        linearize(derive(SCENES["spatial"]), signs)
