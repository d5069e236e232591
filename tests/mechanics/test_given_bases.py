"""Equations over a base that is given its acceleration: Lagrange's, with a velocity that is not varied, and how they print."""

from __future__ import annotations

from typing import Any

import pytest
import sympy

from phichain.mechanics import derive, with_symbols
from phichain.scene import Scene

TWO: dict[str, Any] = {"mass": [0.5, 0.25], "length": [1.0, 0.5], "com": [0.5, 0.25]}


def residuals(scene: Scene) -> tuple[list[sympy.Expr], list[sympy.Expr]]:
    """Left less right side of the links' equations as shown, and d/dt dL/dtheta' - dL/dtheta with c' = b (x' and x'' on a cart)."""
    model = derive(scene)
    s, carts = model.symbols, len(model.symbols.cart)
    given = [(s.base_rate, s.base_acceleration)] if scene.is_moving else [(s.cart_rate, s.cart_acceleration)]
    shown = [equation.lhs - equation.rhs for equation in model.equations][carts:]
    lagrangian, hand = model.lagrangian, []
    moved = [(s.theta, s.theta_dot), (s.theta_dot, s.theta_ddot), *given]
    for angle, rate in zip(s.theta, s.theta_dot, strict=True):
        momentum = sympy.diff(lagrangian, rate)
        along = [sympy.diff(momentum, x) * y for xs, ys in moved for x, y in zip(xs, ys, strict=True)]
        hand.append(sympy.Add(*along) - sympy.diff(lagrangian, angle))
    return shown, hand


@pytest.mark.parametrize("angles", ["relative", "absolute", "adjacent"])
@pytest.mark.parametrize("base", [{"base": "moving"}, {"base": "cart", "drive": "acceleration", "cart_mass": 0.5}])
def test_links_obey_lagrange(base: dict[str, Any], angles: str) -> None:
    shown, hand = residuals(Scene("hand", 2, **TWO, **base, angles=angles, stiffness=0.5))
    symbols = sorted(set().union(*(entry.free_symbols for entry in shown + hand)), key=str)
    point = {symbol: sympy.Rational(7 * k + 3, 11 + k) for k, symbol in enumerate(symbols)}
    for one, other in zip(shown, hand, strict=True):
        assert abs((one - other).xreplace(point).evalf(40)) < sympy.Float("1e-35", 40)


def test_a_driven_cart_has_the_equation_of_its_drive() -> None:
    model = derive(Scene("told", 2, base="cart", drive="acceleration", **TWO))
    first = model.equations[0]
    assert (str(first.lhs), str(first.rhs)) == ("xddot", "b")
    assert model.total_mass == sympy.Rational(3, 4)  # of the links alone
    assert [str(u) for u in model.symbols.u] == ["b"]
    spatial = derive(Scene("told", 1, "spatial", "cart", drive="acceleration", mass=1, length=1))
    assert [str(e.rhs) for e in spatial.equations[:2]] == [str(e.rhs) for e in spatial.unit_vector_equations[:2]] == ["b_1", "b_2"]


def test_what_is_printed() -> None:
    moving = str(derive(Scene("shaken", 4, base="moving", mass=1, length=1)))
    assert "on a base that moves with velocity c and acceleration b" in moving
    assert "+ mu_i (b_1 cos(phi_i) - b_2 sin(phi_i))" in moving and "1/2 M00 |c|^2" in moving
    driven = str(derive(Scene("told", 4, base="cart", drive="acceleration", mass=1, length=1)))
    assert "cart driven by its acceleration b" in driven and "\nx'' = b\n" in driven
    space = str(derive(Scene("shaken", 4, "spatial", "moving", mass=1, length=1)))
    assert "+ mu_i q_i x b" in space and "+ mu_i b)" in space
    for scene in (Scene("shaken", 1, base="moving", mass=1, length=1), Scene("long_one", 4, "spatial", "moving", mass=1, length=1)):
        assert "b_" in derive(scene).latex() or r"\times b" in derive(scene).latex()


def test_symbols_stand_for_all_numbers() -> None:
    scene = with_symbols(Scene("told", 1, base="cart", drive="acceleration", mass=1, length=1, cart_mass=2))
    assert scene.cart_mass == "runtime" and str(derive(scene).total_mass) in ("m_0 + m_1", "m_1 + m_0")
