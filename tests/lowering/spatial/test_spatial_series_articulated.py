"""The same recurrences for masses anywhere on their links: right to 35 digits, and no digit lost to light links or masses near joints."""

from __future__ import annotations

from typing import Any

import pytest
from mpmath import mp, mpf

from phichain.ir import total_operations
from phichain.lowering.series.run import expand, expand_column
from phichain.lowering.series.spatial import spatial_series
from phichain.mechanics import derive
from phichain.scene import Scene
from tests.lowering.spatial.test_spatial_series import DAMPED, SPREAD, SPRUNG, chain, expanded, moved, rounded
from tests.lowering.taylor_oracle import DIGITS, DOUBLES, EXACT, Row, State, coefficients, gap, state

ORDERS = 12
RUNTIME = {name: "runtime" for name in ("mass", "length", "com", "gravity", "cart_mass", "stiffness", "damping")}
CHAINS = {
    "one": chain(1, com=0.3),
    "one on a cart": chain(1, True, com=0.3),
    "two": chain(2, com=[0.3, 0.9]),
    "three on a cart": chain(3, True, com=[0.3, 0.9, 0.1]),
    "one at its end": chain(4, True, com=[0.3, 1.3, 0.8, 0.2], code="loops"),
    "alike": chain(3, mass=0.2, length=0.5, com=0.25),
    "spread on a light cart": chain(4, True, **SPREAD, com=[0.5, 1e-11, 9.0, 0.3], cart_mass=1e-8),
    "heavier outwards": chain(3, True, mass=[1.0, 40.0, 2000.0], com=[0.3, 0.9, 0.1], **SPRUNG, **DAMPED),
    "damped on a cart": chain(3, True, com=[0.3, 0.9, 0.1], **SPRUNG, **DAMPED, code="loops"),
    "runtime": chain(3, True, **RUNTIME),
}


@pytest.mark.long
@pytest.mark.parametrize("name", CHAINS)
def test_coefficients_are_those_of_the_equations(name: str) -> None:
    scene, at = CHAINS[name], state(CHAINS[name])
    series = spatial_series(derive(scene))
    assert gap(expanded(series, at, ORDERS), coefficients(scene, at.q, at.v, at.u, ORDERS, **at.params)) < 1e-30


@pytest.mark.parametrize("links", [[[0, 0, 1]] * 3, [[0, 0, 1], [0, 0, -1], [0, 0, 1]]])
@pytest.mark.parametrize("name", ["alike", "damped on a cart"])
def test_links_in_line_and_folded(name: str, links: list[Row]) -> None:
    scene, orders = CHAINS[name], 8
    at = state(scene, 1, links)
    series = spatial_series(derive(scene))
    assert gap(expanded(series, at, orders), coefficients(scene, at.q, at.v, at.u, orders, **at.params)) < 1e-35


@pytest.mark.parametrize("name", ["one on a cart", "two", "damped on a cart"])
def test_columns_are_derivatives_of_the_coefficients(name: str) -> None:
    scene, at, orders = CHAINS[name], state(CHAINS[name]), 6
    series = spatial_series(derive(scene))
    with mp.workdps(DIGITS + 10):
        h = mpf(10) ** -20
        sides = [moved(scene, at, 5, sign * h) for sign in (1, -1)]
        rows = [coefficients(scene, side.q, side.v, side.u, orders, **side.params) for side in sides]
        true = [[(x - y) / (2 * h) for x, y in zip(*pair, strict=True)] for pair in zip(*rows, strict=True)]
        base = expand(series, EXACT, orders, at.q, at.v, at.u, **at.params)
        column = expand_column(series, EXACT, base, true[0][: scene.nq], true[0][scene.nq :], **at.params)
    assert gap(column.state, true) < 1e-30


NUMBERS: dict[str, dict[str, Any]] = {
    "alike": {"mass": 1.0},
    "heavy tip": {"mass": [1.0, 1.0, 1.0, 1e8]},
    "heavy in turn": {"mass": [1.0, 1e8, 1.0, 1e8]},
    "heavy root": {"mass": [1e8, 1.0, 1.0, 1.0]},
    "lighter and longer": {"mass": [1e8, 1e3, 1e-3, 1e-8], "length": [1e-4, 1e-2, 1e2, 1e4]},
    "short in turn": {"mass": 1.0, "length": [1.0, 1e-8, 1.0, 1e-8]},
}


@pytest.mark.long
@pytest.mark.parametrize("near", [False, True])
@pytest.mark.parametrize("place", [0.5, 1e-8, 1 - 1e-8])
@pytest.mark.parametrize("name", NUMBERS)
def test_doubles_keep_their_digits_whatever_spreads(name: str, place: float, near: bool) -> None:
    """Masses over 16 decades, lengths over 8, masses half way, near their joints, near their ends; links anywhere or in line."""
    keys = {"length": 1.0, **NUMBERS[name]}
    length = keys["length"] if isinstance(keys["length"], list) else [keys["length"]] * 4
    scene = chain(4, name in ("alike", "lighter and longer"), **keys, com=[place * x for x in length])
    at = rounded(state(scene, 3, [[(-1) ** i * 0.05 * (i + 1), 0.02 * i, 1] for i in range(4)] if near else ()))
    exact = State(*([mpf(x) for x in row] for row in (at.q, at.v, at.u)), params={})
    series = spatial_series(derive(scene))
    found = expand(series, DOUBLES, 5, at.q, at.v, at.u)
    true = expand(series, EXACT, 5, exact.q, exact.v, exact.u)
    assert gap(found.state, true.state) < (3e-12 if near and place < 0.1 else 3e-14)


@pytest.mark.parametrize("place", [0.5, 1e-8])
def test_the_first_order_keeps_its_digits_where_masses_grow_outwards(place: float) -> None:
    """By eight decades from link to link; later orders lose some, their multipliers being sums of two forces there."""
    scene = chain(4, mass=[1e-8, 1.0, 1e8, 1e16], length=1.0, com=place)
    at = rounded(state(scene, 3))
    exact = State(*([mpf(x) for x in row] for row in (at.q, at.v, at.u)), params={})
    series = spatial_series(derive(scene))
    found = expand(series, DOUBLES, 1, at.q, at.v, at.u)
    assert gap(found.state, expand(series, EXACT, 1, exact.q, exact.v, exact.u).state) < 3e-15


@pytest.mark.parametrize(("scene", "most"), [
    (chain(8, mass=0.2, length=0.5, com=0.25), 168),
    (chain(8, True, mass=0.2, length=0.5, com=0.25), 172),
    (chain(8, True, mass=0.2, length=0.5, com=0.25, stiffness=1.0, damping=0.1), 244),
])  # fmt: skip
def test_operations_of_an_order_beside_its_sums(scene: Scene, most: float) -> None:
    assert total_operations(spatial_series(derive(scene)).order) <= most * scene.links
