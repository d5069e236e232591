"""Taylor recurrences of spatial chains against the proven equations in power-series arithmetic, and what they cost."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import pytest
from mpmath import mp, mpf

from phichain.ir import total_operations
from phichain.lowering.series.run import expand, expand_column
from phichain.lowering.series.series import Series
from phichain.lowering.series.spatial import spatial_series
from phichain.lowering.series.spatial.ends import spatial_ends
from phichain.mechanics import derive
from phichain.scene import Scene
from tests.lowering.taylor_oracle import DIGITS, DOUBLES, EXACT, Row, State, coefficients, gap, state

ORDERS = 12
UNEVEN: dict[str, Any] = {"mass": [0.7, 1.9, 0.4, 1.1], "length": [0.5, 1.3, 0.8, 0.6]}
SPREAD: dict[str, Any] = {"mass": [1.0, 1e8, 1e-8, 1.0], "length": [1.0, 1e-3, 10.0, 1.0]}
SPRUNG: dict[str, Any] = {"stiffness": [2.0, 0.5, 1.5, 0.8]}
DAMPED: dict[str, Any] = {"damping": [0.3, 0.1, 0.2, 0.4]}


def chain(links: int, cart: bool = False, **more: Any) -> Scene:
    keys: dict[str, Any] = {**UNEVEN, **more}
    keys = {name: value[:links] if isinstance(value, list) else value for name, value in keys.items()}
    if cart:
        keys.setdefault("cart_mass", 1.7)
    return Scene(
        "chain",
        links,
        space="spatial",
        base="cart" if cart else "fixed",
        want=("propagate",),
        variational=True,
        **keys,
    )


CHAINS = {
    "one": chain(1),
    "one on a cart": chain(1, True),
    "two": chain(2),
    "three on a cart": chain(3, True),
    "four": chain(4, code="loops"),
    "alike": chain(3, mass=0.2, length=0.5),
    "alike on a cart": chain(4, True, mass=0.2, length=0.5),
    "spread": chain(4, **SPREAD),
    "spread on a light cart": chain(4, True, **SPREAD, cart_mass=1e-8),
    "sprung": chain(3, **SPRUNG),
    "damped on a cart": chain(3, True, **SPRUNG, **DAMPED, code="loops"),
    "runtime": chain(3, mass="runtime", length="runtime", gravity="runtime", code="loops"),
    "all runtime": chain(
        3,
        True,
        mass="runtime",
        length="runtime",
        gravity="runtime",
        cart_mass="runtime",
        stiffness="runtime",
        damping="runtime",
    ),
}


def expanded(series: Series, at: State, orders: int, rho: Fraction = Fraction(1, 4)) -> list[Row]:
    """Coefficients in true time of a step in time scaled by rho."""
    size = len(at.q)
    with mp.workdps(DIGITS + 10):
        unit = EXACT.number(rho)
        found = expand(series, EXACT, orders, at.q, [x * unit for x in at.v], at.u, rho, **at.params)
        return [
            [x / unit ** (n + (i >= size)) for i, x in enumerate(row)] for n, row in enumerate(found.state)
        ]


@pytest.mark.parametrize("name", CHAINS)
def test_coefficients_are_those_of_the_equations(name: str) -> None:
    scene, at = CHAINS[name], state(CHAINS[name])
    series = spatial_series(derive(scene))
    assert (
        gap(expanded(series, at, ORDERS), coefficients(scene, at.q, at.v, at.u, ORDERS, **at.params)) < 1e-35
    )


@pytest.mark.parametrize(
    "links", [[[0, 0, 1]] * 3, [[0, 0, 1], [0, 0, -1], [0, 0, 1]], [[1, 0, 0], [-1, 0, 0], [0, 1, 0]]]
)
@pytest.mark.parametrize("name", ["alike", "three on a cart", "damped on a cart"])
def test_links_in_line_and_folded(name: str, links: list[Row]) -> None:
    scene = CHAINS[name]
    at = state(scene, 1, links)
    series = spatial_series(derive(scene))
    assert (
        gap(expanded(series, at, ORDERS), coefficients(scene, at.q, at.v, at.u, ORDERS, **at.params)) < 1e-35
    )


def moved(scene: Scene, at: State, seed: int, by: mpf) -> State:
    """The state on a curve through it on the manifold, at the parameter `by`."""
    other, carts = state(scene, seed), 2 * scene.has_cart
    q, v = ([x + by * y for x, y in zip(a, b, strict=True)] for a, b in ((at.q, other.q), (at.v, other.v)))
    for k in range(carts, scene.nq, 3):
        link = q[k : k + 3]
        size = mp.norm(link)
        q[k : k + 3] = link = [x / size for x in link]
        along = mp.fdot(link, v[k : k + 3])
        v[k : k + 3] = [x - along * y for x, y in zip(v[k : k + 3], link, strict=True)]
    return State(q, v, at.u, at.params)


@pytest.mark.parametrize(
    "name", ["one on a cart", "four", "spread on a light cart", "damped on a cart", "all runtime"]
)
def test_columns_are_derivatives_of_the_coefficients(name: str) -> None:
    scene, at, orders = CHAINS[name], state(CHAINS[name]), 8
    series = spatial_series(derive(scene))
    with mp.workdps(DIGITS + 10):
        h = mpf(10) ** -20
        ahead, behind = (moved(scene, at, 5, sign * h) for sign in (1, -1))
        rows = [
            coefficients(scene, side.q, side.v, side.u, orders, **side.params) for side in (ahead, behind)
        ]
        true = [[(x - y) / (2 * h) for x, y in zip(*pair, strict=True)] for pair in zip(*rows, strict=True)]
        base = expand(series, EXACT, orders, at.q, at.v, at.u, **at.params)
        column = expand_column(series, EXACT, base, true[0][: scene.nq], true[0][scene.nq :], **at.params)
    assert gap(column.state, true) < 1e-30


HARD = {
    "spread": CHAINS["spread"],
    "spread on a light cart": CHAINS["spread on a light cart"],
    "heavy tip": chain(4, mass=[1.0, 1.0, 1.0, 1e8], length=1.0),
    "heavy in turn": chain(4, True, mass=[1.0, 1e8, 1.0, 1e8], length=1.0),
    "light with a tip": chain(4, mass=[1e-8, 1e-8, 1e-8, 1.0], length=1.0),
    "heavy root": chain(4, mass=[1e8, 1.0, 1.0, 1.0], length=[1.0, 1e-4, 1.0, 1e4]),
    "alike on a cart": CHAINS["alike on a cart"],
}


def rounded(at: State) -> State:
    """The state in doubles."""
    return State(*([float(x) for x in row] for row in (at.q, at.v, at.u)), params={})


@pytest.mark.parametrize("near", [False, True])
@pytest.mark.parametrize("name", HARD)
def test_doubles_keep_their_digits_whatever_spreads(name: str, near: bool) -> None:
    """Every order, masses spread over 16 decades, links anywhere or within degrees of a line."""
    scene = HARD[name]
    at = rounded(
        state(scene, 3, [[(-1) ** i * 0.05 * (i + 1), 0.02 * i, 1] for i in range(4)] if near else ())
    )
    series, exact = (
        spatial_series(derive(scene)),
        State(*([mpf(x) for x in row] for row in (at.q, at.v, at.u)), params={}),
    )
    found = expand(series, DOUBLES, ORDERS, at.q, at.v, at.u)
    true = expand(series, EXACT, ORDERS, exact.q, exact.v, exact.u)
    assert gap(found.state, true.state) < 1e-14


@pytest.mark.parametrize(("scene", "most", "held"), [
    (chain(8, mass=0.2, length=0.5), 45, 12.5),
    (chain(8, True, mass=0.2, length=0.5), 50, 14),
    (chain(8, mass=list(range(1, 9)), length=list(range(2, 10))), 51, 12.5),
    (chain(8, True, mass=0.2, length=0.5, stiffness=1.0), 67, 17.25),
    (chain(8, True, mass=0.2, length=0.5, stiffness=1.0, damping=0.1), 121, 18.25),
])  # fmt: skip
def test_operations_of_an_order_beside_its_sums(scene: Scene, most: float, held: float) -> None:
    series = spatial_series(derive(scene))
    assert total_operations(series.order) <= most * scene.links
    assert series.held <= held * scene.links


@pytest.mark.parametrize("name", ["three on a cart", "alike", "four"])
def test_trajectories_side_by_side_keep_every_number_once(name: str) -> None:
    """What an order writes for eight at a time: three numbers a link and its multiplier where one trajectory takes twelve."""
    series = spatial_series(derive(CHAINS[name]))
    assert series.order_shared is not None
    written = [sum(array.size for array in order.outputs) for order in (series.order, series.order_shared)]
    assert written[1] <= 0.36 * written[0]
    assert total_operations(series.order_shared) <= 0.87 * total_operations(series.order)


def test_ends_there_and_back() -> None:
    """(q, omega) to (q, q') and back: the state itself, and of a variation what is tangent to the states."""
    scene = CHAINS["three on a cart"]
    ends, at, h = spatial_ends(scene), state(scene), mpf(10) ** -20
    with mp.workdps(DIGITS + 10):
        sides = [moved(scene, at, 5, sign * h) for sign in (0, 1, -1)]
        left = [EXACT.run(ends.leave, {"q": side.q, "rate": side.v}) for side in sides]
        (q, v), *others = [(side["q_out"], side["v_out"]) for side in left]
        d_rate, dq, dv = (
            [(x - y) / (2 * h) for x, y in zip(*pair, strict=True)]
            for pair in ([side.v for side in sides[1:]], *zip(*others, strict=True))
        )
        assert gap([EXACT.run(ends.enter, {"q": q, "v": v})["rate"]], [at.v]) < 1e-45
        assert (
            gap([EXACT.run(ends.enter_column, {"q": q, "v": v, "dq": dq, "dv": dv})["d_rate"]], [d_rate])
            < 1e-30
        )
        back = EXACT.run(ends.leave_column, {"q": at.q, "rate": at.v, "dq": dq, "d_rate": d_rate})
        assert gap([back["dq_out"], back["dv_out"]], [dq, dv]) < 1e-30
        # What stands along a link is no part of the state.
        longer = [x * 3 for x in at.q[:2]] + [x * mpf("1.5") for x in at.q[2:]]
        again = EXACT.run(ends.leave, {"q": longer, "rate": [x * mpf("1.5") for x in at.v]})
        assert gap([again["q_out"][2:], again["v_out"][2:]], [at.q[2:], v[2:]]) < 1e-45
