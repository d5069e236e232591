"""The derivation against closed forms, the Euler-Lagrange equations, and the dense reference."""

from __future__ import annotations

import itertools
import random
from fractions import Fraction
from typing import Any

import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st
from mpmath import mp

from phichain.errors import UnsupportedError
from phichain.mechanics import derive, with_symbols
from phichain.mechanics.lagrange import Model
from phichain.reference import reference
from phichain.scene import Scene, standard_scene
from tests.reference_cases import relative_error

RUNTIME: dict[str, Any] = {"mass": "runtime", "length": "runtime", "com": "runtime", "gravity": "runtime"}
CART: dict[str, Any] = {"base": "cart", "cart_mass": "runtime"}
MASSES: dict[str, Any] = {"mass": [1, 2, 0.5]}
JOINTS: dict[str, Any] = {"stiffness": "runtime", "damping": "runtime"}

sizes = st.floats(1e-4, 1e4)


@st.composite
def numeric_scenes(draw: st.DrawFn) -> Scene:
    links = draw(st.integers(1, 6))
    length = draw(st.lists(sizes, min_size=links, max_size=links))
    shares = draw(st.lists(st.sampled_from([1.0, 0.5, 0.3]), min_size=links, max_size=links))
    cart = draw(st.sampled_from([{}, {"base": "cart", "cart_mass": 0.7}]))
    return Scene(
        "a",
        links,
        draw(st.sampled_from(["planar", "spatial"])),
        mass=draw(st.lists(sizes, min_size=links, max_size=links)),
        length=length,
        com=[share * entry for share, entry in zip(shares, length, strict=True)],
        **cart,
    )


@given(scene=numeric_scenes())
def test_collected_coefficients_are_the_closed_forms_exactly(scene: Scene) -> None:
    """mu_k, c_ij and M00 of theory section 1, in exact fractions of the binary64 inputs."""
    model = derive(scene)
    m, lengths = ([Fraction(entry) for entry in values] for values in (scene.mass, scene.length))
    r = lengths if scene.com is None else [Fraction(entry) for entry in scene.com]
    links = range(scene.links)
    beyond = [sum(m[k + 1 :], Fraction(0)) for k in links]
    mu = tuple(m[k] * r[k] + lengths[k] * beyond[k] for k in links)
    assert model.mu == mu
    assert model.coupling == (mu if scene.has_cart else ())
    assert model.total_mass == sum(m) + (Fraction(scene.cart_mass) if scene.has_cart else 0)
    for i, j in itertools.product(links, links):
        closed = (
            m[i] * r[i] ** 2 + lengths[i] ** 2 * beyond[i] if i == j else lengths[min(i, j)] * mu[max(i, j)]
        )
        assert model.c[i][j] == closed


def test_runtime_coefficients_are_expressions_with_masses_gathered() -> None:
    model = derive(Scene("a", 3, **RUNTIME, **CART))
    m_1, m_2, m_3, m_0, l_1, l_2, r_2 = sympy.symbols("m_1 m_2 m_3 m_0 l_1 l_2 r_2", positive=True)
    assert model.mu[1] == l_2 * m_3 + m_2 * r_2
    assert model.c[0][1] == l_1 * l_2 * m_3 + l_1 * m_2 * r_2
    assert sympy.expand(model.c[0][0] - derive(Scene("a", 3, **RUNTIME)).c[0][0]) == 0
    assert model.total_mass == m_0 + m_1 + m_2 + m_3
    tip = derive(Scene("a", 3, mass="runtime", length="runtime"))
    assert tip.mu[1] == l_2 * (m_2 + m_3)


def test_coefficients_of_mixed_scenes_stay_exact() -> None:
    model = derive(Scene("a", 2, mass="runtime", length=0.1))
    m_2 = sympy.Symbol("m_2", positive=True)
    assert model.c[0][1] == m_2 * sympy.Rational(Fraction(0.1)) ** 2


@pytest.mark.parametrize("angles", ["relative", "absolute", "adjacent"])
@pytest.mark.parametrize("cart", [{}, CART], ids=["fixed", "cart"])
def test_planar_equations_are_those_of_euler_and_lagrange(angles: str, cart: dict[str, Any]) -> None:
    """d/dt dL/dq' - dL/dq + dR/dq' = force for every coordinate, R Rayleigh's function, all symbolic."""
    model = derive(Scene("a", 3, **RUNTIME, **cart, **JOINTS, angles=angles, actuated="all"))
    q, v, a = model.symbols.q, model.symbols.v, model.symbols.a
    bends = [outer - inner for outer, inner in zip(_rates(model), [0, *_rates(model)], strict=False)]
    rayleigh = sum(sympy.Symbol(f"d_{k}", positive=True) * rate**2 / 2 for k, rate in enumerate(bends, 1))
    for coordinate, rate, push, equation in zip(q, v, model.symbols.u, model.equations, strict=True):
        momentum = model.lagrangian.diff(rate)
        change = sum(momentum.diff(x) * x_dot for x, x_dot in zip((*q, *v), (*v, *a), strict=True))
        left = change - model.lagrangian.diff(coordinate) + rayleigh.diff(rate)
        assert _vanishes(left - equation.lhs)
        assert equation.rhs == push


def _rates(model: Model) -> tuple[sympy.Expr, ...]:
    """Return the absolute rates phi_k', written out."""
    one, two, three = model.symbols.theta_dot
    kinds = {"relative": (one, one + two, one + two + three), "adjacent": (one, one + two, two + three)}
    return kinds.get(str(model.scene.angles), (one, two, three))


def _vanishes(value: sympy.Expr) -> bool:
    """Return whether an expression is zero at three random points, in 40 digits."""
    draw = random.Random(5)
    symbols = sorted(value.free_symbols, key=str)
    points = [{s: sympy.Float(draw.uniform(0.5, 2), 60) for s in symbols} for _ in range(3)]
    return all(abs(value.xreplace(point).evalf(40)) < 1e-35 for point in points)


def test_the_written_cosines_are_the_products_of_the_directions() -> None:
    """T and V of a planar chain are 1/2 sum m |r'|^2 and -g sum m e_2.r of the positions themselves."""
    model = derive(Scene("a", 3, **RUNTIME, **CART))
    symbols = model.symbols
    rates = dict(zip(symbols.q, symbols.v, strict=True))
    kinetic = sympy.Symbol("m_0", positive=True) * symbols.cart_rate[0] ** 2 / 2
    potential = sympy.S.Zero
    for k, position in enumerate(model.positions, start=1):
        velocity = sum((position.diff(x) * x_dot for x, x_dot in rates.items()), sympy.zeros(2, 1))
        kinetic += sympy.Symbol(f"m_{k}", positive=True) * velocity.dot(velocity) / 2
        potential -= sympy.Symbol(f"m_{k}", positive=True) * sympy.Symbol("g", positive=True) * position[1]
    assert _vanishes(kinetic - model.kinetic)
    assert _vanishes(potential - model.potential)


def _on_the_sphere(model: Model, seed: int) -> dict[sympy.Symbol, sympy.Rational]:
    """Return an exact rational motion of a spatial chain: unit q_k, tangent omega_k, consistent rates."""
    draw = random.Random(seed)
    number = lambda: sympy.Rational(draw.randint(-9, 9), draw.randint(1, 9))
    symbols, point = model.symbols, {}
    for k in range(model.scene.links):
        s, t = number(), number()
        q = sympy.Matrix([2 * s, 2 * t, 1 - s**2 - t**2]) / (1 + s**2 + t**2)
        omega, omega_dot = (q.cross(sympy.Matrix([number(), number(), number()])) for _ in range(2))
        rate = omega.cross(q)
        values = {
            "links": q,
            "omega": omega,
            "omega_dot": omega_dot,
            "link_rates": rate,
            "link_accelerations": omega_dot.cross(q) + omega.cross(rate),
        }
        for name, vector in values.items():
            point |= dict(zip(getattr(symbols, name)[k], vector, strict=True))
    others = (*symbols.cart_rate, *symbols.cart_acceleration, *symbols.force)
    return point | {symbol: number() for symbol in others}


def _spatial(**changes: Any) -> Model:
    numbers: dict[str, Any] = {"mass": [0.75, 1.5, 0.25], "length": [0.5, 2.0, 1.25], "com": [0.5, 0.75, 1.0]}
    return derive(Scene("a", 3, "spatial", **numbers, gravity=9.75, **changes))


@pytest.mark.parametrize(
    "joints", [{}, {"stiffness": [0.5, 2, 0.25], "damping": [1.5, 0.5, 0.125]}], ids=["free", "joints"]
)
@pytest.mark.parametrize("cart", [{}, {"base": "cart", "cart_mass": 0.5}], ids=["fixed", "cart"])
def test_spatial_equations_15_and_16_are_the_same_exactly(
    joints: dict[str, Any], cart: dict[str, Any]
) -> None:
    """q_i x row i of (15) is row i of (16), and back, at exact rational motions that satisfy neither."""
    model = _spatial(**joints, **cart)
    carts = len(model.symbols.cart)
    for seed in range(3):
        point = _on_the_sphere(model, seed)
        first, second = (
            sympy.Matrix([(eq.lhs - eq.rhs).xreplace(point) for eq in rows])
            for rows in (model.unit_vector_equations, model.equations)
        )
        assert first[:carts, :] == second[:carts, :]
        for k in range(3):
            q = sympy.Matrix([point[entry] for entry in model.symbols.links[k]])
            row_15, row_16 = (rows[carts + 3 * k : carts + 3 * k + 3, :] for rows in (first, second))
            assert q.cross(row_15) == row_16
            assert row_16.cross(q) == row_15
            assert any(row_16)


def test_spatial_equations_are_those_of_euler_and_lagrange_on_the_sphere() -> None:
    """(I - q q^T)(d/dt dL/dq' - dL/dq) = 0 for links and d/dt dL/dx' = u for the cart, exactly."""
    model = _spatial(base="cart", cart_mass=0.5, stiffness=[0.5, 2, 0.25])
    symbols, L = model.symbols, model.lagrangian
    states = [*symbols.cart_rate, *sum(symbols.links, ()), *sum(symbols.link_rates, ())]
    rates = [*symbols.cart_acceleration, *sum(symbols.link_rates, ()), *sum(symbols.link_accelerations, ())]

    def change(momentum: sympy.Expr) -> sympy.Expr:
        return sum(momentum.diff(x) * x_dot for x, x_dot in zip(states, rates, strict=True))

    point = _on_the_sphere(model, 11)
    rows = [
        change(L.diff(rate)) - force for rate, force in zip(symbols.cart_rate, symbols.force, strict=True)
    ]
    for link, link_rate in zip(symbols.links, symbols.link_rates, strict=True):
        free = sympy.Matrix(
            [change(L.diff(rate)) - L.diff(x) for x, rate in zip(link, link_rate, strict=True)]
        )
        q = sympy.Matrix(link)
        rows += list(free - q * q.dot(free))
    for row, equation in zip(rows, model.unit_vector_equations, strict=True):
        assert row.xreplace(point) == (equation.lhs - equation.rhs).xreplace(point)


@pytest.mark.parametrize(
    "scene",
    [
        Scene("a", 3, **MASSES, length=0.4, com=0.3, angles="adjacent", base="cart", cart_mass=2, stiffness=1),
        Scene("a", 3, **MASSES, length=0.4, angles="relative", damping=0.1),
        Scene("a", 2, "spatial", "cart", mass=[1, 2], length=[0.5, 0.4], com=0.3, cart_mass=2, stiffness=0.3),
        Scene("a", 2, "spatial", mass=[1, 2], length=[0.5, 0.4], damping=0.25, stiffness=0.3),
    ],
    ids=["planar-cart", "planar", "spatial-cart", "spatial"],
)  # fmt: skip
def test_expressions_evaluate_to_the_dense_reference(scene: Scene) -> None:
    model = derive(scene)
    draw = random.Random(2)
    inputs = {
        name: [draw.uniform(-1, 1) for _ in range(size)]
        for name, size in zip("qvu", (scene.nq, scene.nv, scene.nu), strict=True)
    }
    if not scene.is_planar:
        exact = reference(scene, "project", inputs)
        inputs |= {"q": exact["q_out"], "v": exact["v_out"]}
    a = reference(scene, "forward_dynamics", inputs)["a"]
    symbols = model.symbols
    point = dict(
        zip(
            (*symbols.q, *symbols.v, *symbols.u, *symbols.a),
            (*inputs["q"], *inputs["v"], *inputs["u"], *a),
            strict=True,
        )
    )
    for link, rate, omega in (
        zip(symbols.links, symbols.link_rates, symbols.omega, strict=True) if not scene.is_planar else ()
    ):
        point |= dict(zip(rate, sympy.Matrix(omega).cross(sympy.Matrix(link)).xreplace(point), strict=True))

    def value(expression: Any) -> Any:
        return [mp.mpf(x.xreplace(point).evalf(20)) for x in expression]

    expected = {"mass_matrix": "M", "coriolis": "N", "gravity_torque": "G"}
    for name, output in expected.items():
        found = value(getattr(model, name))
        assert relative_error(found, reference(scene, name, inputs)[output]) < 1e-14, name
    energy = reference(scene, "energy", inputs)
    assert relative_error(value([model.kinetic, model.potential]), list(energy.values())) < 1e-14
    positions = [entry for position in model.positions for entry in position]
    assert relative_error(value(positions), reference(scene, "positions", inputs)["r"]) < 1e-14
    residual = value([eq.lhs - eq.rhs for eq in model.equations])
    assert max(map(abs, residual)) < 1e-13 * max(map(abs, a))


def test_with_symbols_keeps_the_structure_of_the_scene() -> None:
    tip = with_symbols(Scene("a", 2, mass=1.0, length=2.0, damping=0.5))
    assert tip.tip_masses and tip.stiffness is None and tip.cart_mass is None
    assert tip.runtime == ("mass", "length", "gravity", "damping")


def test_models_are_values() -> None:
    assert derive(standard_scene(3)) == derive(standard_scene(3)) != derive(standard_scene(2))
    with pytest.raises(UnsupportedError, match="unit vectors"):
        _ = derive(standard_scene(2)).unit_vector_equations


@settings(max_examples=3, deadline=None)
@given(links=st.integers(64, 80))
def test_long_chains_derive_without_expanding_anything(links: int) -> None:
    model = derive(Scene("a", links, mass=0.1, length=0.3, com=0.2))
    assert model.c[0][-1] == Fraction(0.3) * model.mu[-1]
