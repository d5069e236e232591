"""Spatial Jacobians from one factorisation: partial derivatives of the very forward dynamics, off the spheres too; operations; digits."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from phichain import build
from phichain.errors import ProofError
from phichain.ir import evaluate, total_operations
from phichain.ir.nodes import Program
from phichain.lowering import lower, lower_function
from phichain.lowering.chain.body import point_masses
from phichain.lowering.lower import Code
from phichain.lowering.spatial.derivatives.functions import suits
from phichain.mechanics import derive
from phichain.proof import prove
from phichain.reference import reference, tangent_directions
from phichain.scene import Scene
from phichain.transform.blocks import Block
from phichain.transform.tangent import jacobian
from tests.lowering.hard_chains import SPREADS
from tests.lowering.jacobians.test_planar_jacobian import _flipped, _ops

WANT = ("state_jacobian", "dynamics_and_jacobian")
CART: dict[str, Any] = {"base": "cart", "cart_mass": 3.0}
#: A cart that the chain pulls along, whose forces are a small difference.
LIGHT: dict[str, Any] = {"base": "cart", "cart_mass": 1e-3}
#: Springs, dampers and dry friction; masses before the ends; rigid links. One number stands for as many as there are links.
TIED: dict[str, Any] = {"stiffness": 0.7, "damping": 0.3}
RUBBED = TIED | {"friction": 0.5, "friction_speed": 0.4}
BEFORE: dict[str, Any] = {"com": 0.24}
PLAIN: list[dict[str, Any]] = [
    {}, {"mass": 0.2, "length": 0.3}, CART, CART | {"cart_mass": 9.0, "cart_damping": 0.4, "mass": 0.2, "length": 0.3},
    {"base": "cart", "drive": "acceleration"}, {"base": "moving"}, {"mass": "runtime", "length": "runtime"},
]  # fmt: skip
JOINED: list[dict[str, Any]] = [
    RUBBED | CART | {"cart_damping": 0.4, "cart_friction": 0.5, "cart_friction_speed": 0.3}, {"damping": "runtime", "mass": "runtime", "length": "runtime", "base": "moving"},
    {"stiffness": 0.7, "base": "cart", "drive": "acceleration"},
    CART | {"cart_friction": 0.5, "cart_friction_speed": 0.3}, BEFORE | RUBBED | CART | {"mass": 0.2, "length": 0.3}, BEFORE | CART | {"cart_friction": 0.5, "cart_friction_speed": 0.3},
    BEFORE | {"base": "cart", "drive": "acceleration", "inertia": 0.01},
    LIGHT, LIGHT | RUBBED | {"cart_damping": 0.4}, {"base": "cart", "cart_mass": "runtime", "mass": "runtime", "length": "runtime", "cart_damping": 0.4},
]  # fmt: skip


def chain(links: int, **more: Any) -> Scene:
    """No two links alike."""
    some = np.random.default_rng(links)
    keys: dict[str, Any] = {"mass": np.exp(some.uniform(-1, 1, links)).tolist(), "length": some.uniform(0.3, 1.4, links).tolist()}
    return Scene("some", links, space="spatial", **(keys | {"want": WANT} | more))


def arguments(scene: Scene) -> dict[str, Any]:
    """A state on the manifold, an input, runtime parameters."""
    some, carts = np.random.default_rng(3), 2 * scene.has_cart
    q, v = some.standard_normal((2, scene.links, 3))
    q /= np.linalg.norm(q, axis=1)[:, None]
    v -= q * np.sum(q * v, axis=1)[:, None]
    head = some.standard_normal(carts)
    drawn: dict[str, Any] = {"q": np.append(head, q), "v": np.append(head, v), "u": some.standard_normal(scene.nu)}
    drawn |= {name: some.uniform(0.5, 2.0, () if name == "cart_mass" else scene.links) for name in scene.runtime}
    return {name: values for name, values in drawn.items() if values.size}


def differentiated(scene: Scene, code: Code = "loops") -> Program:
    """The forward dynamics differentiated by the transform."""
    blocks = [Block("a", name, f"dad{name}") for name in ("q", "v", "u")[: 2 + (scene.nu > 0)]]
    return jacobian(lower_function(derive(scene), "forward_dynamics", code), "state_jacobian", "", blocks)


@pytest.mark.long
@pytest.mark.parametrize(
    ("links", "code", "more"),
    [
        *((links, code, more) for links, code in ((2, "unrolled"), (4, "loops")) for more in PLAIN),
        *((4, "loops", more) for more in JOINED), (3, "unrolled", JOINED[0]), (3, "unrolled", JOINED[4]),
        *((links, code, more) for links, code in ((1, "unrolled"), (2, "loops"), (3, "unrolled")) for more in (LIGHT, JOINED[-1])), (2, "loops", JOINED[-2]),
    ],
)  # fmt: skip
def test_every_entry_is_the_complex_step_of_the_forward_dynamics(links: int, code: Code, more: dict[str, Any]) -> None:
    """Off the spheres it is the derivative of the sweep as it stands, which no other form has."""
    scene = chain(links, **more)
    given, model = arguments(scene), derive(scene)
    assert suits(point_masses(scene))
    forward, both = lower_function(model, "forward_dynamics", "loops"), lower_function(model, "dynamics_and_jacobian", code)
    assert code == "unrolled" or total_operations(both) < total_operations(differentiated(scene))
    found = evaluate(both, given)
    assert np.allclose(found["a"], evaluate(forward, given)["a"], rtol=1e-12, atol=1e-12)
    for name in [name for name in ("q", "v", "u") if name in given]:
        moved = given[name] + 1e-40j * np.eye(given[name].size)
        true = evaluate(forward, given | {name: moved})["a"].imag.T / 1e-40
        # with dry friction and carts the complex step itself is good to 4e-15
        assert np.max(np.abs(found[f"dad{name}"] - true)) <= (1e-14 if scene.friction or scene.cart_friction else 2e-15) * np.max(np.abs(true)), name


@pytest.mark.parametrize("base", ["fixed", "cart"])
@pytest.mark.parametrize("spread", ["heavy tip", "heavy in turn", "heavier outwards"])
def test_masses_that_spread_cost_no_digit(spread: str, base: str) -> None:
    """As accurate along the manifold as the differentiated sweep, eight and sixteen decades apart; the truth is from positions."""
    mass, length = (values.tolist() for values in SPREADS[spread](3))
    scene = chain(3, mass=mass, length=length, **({"base": "cart", "cart_mass": sum(mass)} if base == "cart" else {}))
    assert_as_accurate_as_differentiated(scene)


@pytest.mark.long
@pytest.mark.parametrize("push", [0.0, 1.0], ids=["left alone", "pushed along"])
@pytest.mark.parametrize("cart_mass", [1e-2, 1e-8])
def test_nor_do_light_carts(cart_mass: float, push: float) -> None:
    """Pushed along the first link the cart feels a small difference of two forces; chains that grow heavier, lighter, and with springs."""
    mass, length = np.geomspace(1e-2, 1e2, 3).tolist(), [0.3, 3.0, 0.03]
    short = [(links, turn, {}) for links in (1, 2) for turn in (1, -1)]
    for links, turn, more in (*short, (2, 1, TIED), (3, 1, {}), (3, -1, {}), (3, 1, TIED)):
        scene = chain(links, mass=mass[::turn][:links], length=length[:links], base="cart", cart_mass=cart_mass, **more)
        given = arguments(scene)
        given["u"] = push * given["q"][2:4]
        assert_as_accurate_as_differentiated(scene, given)


def assert_as_accurate_as_differentiated(scene: Scene, given: dict[str, Any] | None = None) -> None:
    """Along the manifold, against positions."""
    given = given or arguments(scene)
    exact = np.array(reference(scene, "state_jacobian", given, digits=30)["tangent"], float)
    errors = []
    for program in (lower_function(derive(scene), "state_jacobian", "loops"), differentiated(scene)):
        out = evaluate(program, given)
        rows = [out["dadq"] @ np.array(dq, float) + out["dadv"] @ np.array(dv, float) for dq, dv in tangent_directions(scene, given["q"], given["v"])]
        errors.append(np.max(np.abs(rows - exact)) / np.max(np.abs(exact)))
    assert errors[0] <= max(8 * errors[1], 2e-14)


@pytest.mark.long
@pytest.mark.parametrize("base", ["fixed", "cart"])
@pytest.mark.parametrize(
    ("spread", "more"),
    [
        ("heavy in turn", RUBBED), ("heavier outwards", {"stiffness": 1e6, "damping": 10.0}), ("heavy tip", TIED | {"place": 0.9}),
    ],
)  # fmt: skip
def test_nor_do_springs_and_masses_before_the_ends(spread: str, more: dict[str, Any], base: str) -> None:
    """As far as the forms go that the accelerations take: some of these chains are differentiated."""
    mass, length = (values.tolist() for values in SPREADS[spread](3))
    keys = {name: value for name, value in more.items() if name != "place"}
    keys |= {"com": [more["place"] * l for l in length]} if "place" in more else {}
    scene = chain(3, mass=mass, length=length, **keys, **({"base": "cart", "cart_mass": sum(mass)} if base == "cart" else {}))
    assert_as_accurate_as_differentiated(scene)


def test_a_light_link_before_a_heavy_one_costs_no_digit() -> None:
    """Where the sweep by mobilities serves, stretches and forces along a heavy chain are differences unless they are kept apart (1e-11 here)."""
    for mass, length, place in (([0.01, 310.0], [0.043, 11.0], [0.41, 0.45]), ([440.0, 0.016, 850.0], [11.0, 0.27, 3.7], [0.47, 0.47, 0.57])):
        scene = chain(len(mass), mass=mass, length=length, com=(np.array(length) * place).tolist())
        assert suits(scene)
        assert_as_accurate_as_differentiated(scene)


@pytest.mark.parametrize(("more", "link"), [({}, 245), (CART, 290), (LIGHT, 300), ({"mass": 0.2, "length": 0.2}, 205)])
def test_a_pair_of_links_takes_24_operations(more: dict[str, Any], link: int) -> None:
    """A block of three by three by q_j and one by omega_j 24, a link some 200 to 300; the differentiated sweep took 400 a pair of links."""
    for links in (5, 16):
        found = lower_function(derive(chain(links, **more)), "state_jacobian", "loops")
        assert total_operations(found) <= 24 * links**2 + link * links


@pytest.mark.parametrize(
    ("links", "more", "most"),
    [
        (1, LIGHT, 118), (2, LIGHT, 409), (1, JOINED[-1], 173), (2, JOINED[-1], 506), (2, LIGHT | TIED, 1265),
    ],
)  # fmt: skip
def test_one_and_two_links_on_carts_that_may_be_light(links: int, more: dict[str, Any], most: int) -> None:
    """Differentiated, these took 162, 705, 220, 828 and 1740."""
    assert total_operations(lower_function(derive(chain(links, **more)), "state_jacobian")) <= most


@pytest.mark.parametrize(
    ("more", "pair", "link"),
    [
        (TIED, 35, 1280), (BEFORE | CART, 177, 810), (BEFORE | TIED, 258, 1500), (BEFORE | {"inertia": 0.001}, 177, 570),
    ],
)  # fmt: skip
def test_pairs_of_links_take_few_operations_in_every_form(more: dict[str, Any], pair: int, link: int) -> None:
    """A vector of three or four numbers a column goes over every link once where masses are before the ends; differentiated sweeps take 600 to 1700."""
    for links in (5, 9):
        found = lower_function(derive(chain(links, length=0.3, **more)), "state_jacobian", "loops")
        assert total_operations(found) <= pair * links**2 + link * links


@pytest.mark.long
@pytest.mark.parametrize("more", [BEFORE | TIED | CART, BEFORE | {"base": "moving"}])
def test_cells_that_are_written_anew_are_read_before_in_c_as_well(more: dict[str, Any]) -> None:
    """C puts expressions where their value is wanted: a column's entries stand before its vector goes on."""
    scene = chain(4, code="loops", want=["state_jacobian"], **more)
    given = arguments(scene)
    expected = evaluate(lower_function(derive(scene), "state_jacobian", "loops"), given)
    for name, found in zip(expected, build(scene).state_jacobian(*(given[k] for k in ("q", "v", "u"))), strict=True):
        assert np.max(np.abs(found - expected[name])) <= 1e-14 * np.max(np.abs(expected[name])), name


def test_auto_is_loops_that_take_little_more_than_straight_line_code() -> None:
    """In a quarter of its text; the differentiated sweep takes more even in a straight line."""
    model = derive(chain(5, **CART))
    found, flat = lower_function(model, "state_jacobian", "auto"), lower_function(model, "state_jacobian", "unrolled")
    assert not found.is_straight_line
    assert total_operations(found) <= 4 / 3 * total_operations(flat)
    assert total_operations(flat) < 0.75 * total_operations(differentiated(model.scene, "unrolled"))
    assert lower_function(derive(chain(2, **CART)), "state_jacobian", "auto").is_straight_line


@pytest.mark.parametrize(
    "more",
    [
        {"com": 1e-4}, {"com": "runtime"}, {"com": 0.0, "inertia": 0.2}, {"com": "runtime", "inertia": 0.2},
    ],
)  # fmt: skip
def test_other_chains_are_differentiated(more: dict[str, Any]) -> None:
    scene = chain(2, **more)
    assert not suits(scene)
    found = lower_function(derive(scene), "state_jacobian", "unrolled")
    assert total_operations(found) == total_operations(differentiated(scene, "unrolled"))


@pytest.mark.long
@pytest.mark.parametrize(("links", "more"), [(3, CART), (3, LIGHT), (4, TIED), (4, BEFORE)])
def test_a_wrong_sign_anywhere_is_refused(links: int, more: dict[str, Any]) -> None:
    """Additions turned into subtractions in turn (some of many), but those that add zeros at the ends: they change no number."""
    model = derive(chain(links, code="loops", want=["state_jacobian"], **more))
    lowered, given = lower(model), arguments(model.scene)
    prove(model, lowered)
    program = lowered.wanted["state_jacobian"]
    right, refused = evaluate(program, given), 0
    places = [i for i, op in enumerate(_ops(program.body)) if op.kind == "add"]
    for place in places[:: max(1, len(places) // 6)]:
        wrong = replace(program, body=_flipped(program.body, [place]))
        found = evaluate(wrong, given)
        if all(np.array_equal(found[name], right[name]) for name in right):
            continue
        refused += 1
        with pytest.raises(ProofError):
            prove(model, replace(lowered, wanted={"state_jacobian": wrong}))
    assert refused >= 5
