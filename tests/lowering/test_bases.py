"""Driven carts and moving bases: 50 digits, a Lagrangian by hand over four decades, and what one base says of another."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf

from phichain.contract.functions import ROWS
from phichain.errors import UnsupportedError
from phichain.ir import evaluate
from phichain.ir.builder import Builder
from phichain.ir.passes import prune, total_operations
from phichain.lowering import lower_function
from phichain.lowering.chain.base import on_wall
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.writers import WRITERS, Writer, declared
from phichain.mechanics import derive
from phichain.reference import tangent_directions
from phichain.scene import Scene
from phichain.transform.blocks import Block
from phichain.transform.tangent import jacobian
from tests.lowering.bases import GIVEN, chain, functions, given, named
from tests.lowering.chains import Arguments, gap, random_arguments
from tests.lowering.test_against_reference import agree, error, truth

SPREADS = [
    ([1.0, 1e-2, 1e2, 1e-1], [1.0, 1e-2, 1.0, 1e2]),
    ([1e-2, 1e2, 1.0, 1e2], [1e-1, 1e1, 1e-2, 1e2]),
    ([1e2, 1e-2, 1e-2, 1e2], [1e-2, 1e2, 1e2, 1e-2]),
]
"""Masses and lengths, each over four decades."""


def accelerations(of: Scene, arguments: Arguments, name: str = "forward_dynamics") -> np.ndarray:
    program = lower_function(derive(of), name, "loops")
    return next(iter(evaluate(program, {a.name: arguments[a.name] for a in (*program.params, *program.inputs)}).values()))


def drawn(of: Scene, seed: int, name: str = "forward_dynamics") -> Arguments:
    return random_arguments(of, lower_function(derive(of), name, "loops"), seed)


@pytest.mark.long
@pytest.mark.parametrize("of", [*given()], ids=named)
def test_every_function_in_many_digits(of: Scene) -> None:
    agree(of, functions(of), of_state=1e-13)


@pytest.mark.long
@pytest.mark.parametrize("of", [of for of in given() if not of.is_planar][::2], ids=named)
def test_spatial_jacobians_along_the_manifold(of: Scene) -> None:
    arguments = drawn(of, 1, "state_jacobian")
    program = lower_function(derive(of), "state_jacobian", "loops")
    found, expected = evaluate(program, arguments), truth(of, "state_jacobian", arguments)
    directions = tangent_directions(of, arguments["q"], arguments["v"], digits=30)
    along = [found["dadq"] @ np.array(dq, float) + found["dadv"] @ np.array(dv, float) for dq, dv in directions]
    assert gap(along, np.array([[float(x) for x in row] for row in expected["tangent"]])) < 1e-12
    assert error(found["dadu"], expected["dadu"]) < 1e-12


@pytest.mark.parametrize("com", [1.0, 0.5, 1e-2])
@pytest.mark.parametrize(("mass", "length"), SPREADS)
@pytest.mark.parametrize("base", ["moving", "cart"])
def test_four_decades_against_a_lagrangian_by_hand(base: str, mass: list[float], length: list[float], com: float) -> None:
    """1e-14, or ten times what the problem makes of a rounded input."""
    reach = [com * x for x in length]
    of = chain(base, 4, "planar", "tip", mass=mass, length=length, com=reach, angles="absolute")
    for seed in range(3):
        arguments = drawn(of, seed)
        found, exact = accelerations(of, arguments), by_hand(of, arguments)
        moved = {key: value * (1 + 2.0**-52) for key, value in arguments.items()}
        amplified = gap(np.array(by_hand(of, moved), float), np.array(exact, float))
        assert apart(found, exact) < max(1e-14, 10 * amplified), (seed, amplified)


@pytest.mark.parametrize("com", [1.0, 0.5, 1e-2])
@pytest.mark.parametrize(("mass", "length"), SPREADS)
@pytest.mark.parametrize("base", ["moving", "cart"])
def test_four_decades_in_space(base: str, mass: list[float], length: list[float], com: float) -> None:
    """The same against the blind reference, which knows positions alone."""
    of = chain(base, 4, "spatial", "tip", mass=mass, length=length, com=[com * x for x in length])
    arguments = drawn(of, 1)
    exact = truth(of, "forward_dynamics", arguments)["a"]
    moved = {key: value + (2.0**-53 if key == "q" else 2.0**-52 * value) for key, value in arguments.items()}
    amplified = error(np.array([float(x) for x in truth(of, "forward_dynamics", moved)["a"]]), exact)
    assert error(accelerations(of, arguments), exact) < max(1e-14, 10 * amplified)


@pytest.mark.parametrize("of", [of for of in given() if not of.runtime], ids=named)
def test_a_cart_that_is_driven_is_a_base_that_moves_sideways(of: Scene) -> None:
    """To the last bit: one has the other's fall; and a wall has what a base has that is not accelerated."""
    sideways = 1 if of.is_planar else 2
    cart = replace(of, base="cart", drive="acceleration", cart_mass=None, actuated=of.actuated_joints and of.actuated or "cart")
    moving = replace(of, base="moving", drive=None, cart_mass=None, actuated=of.actuated_joints and of.actuated or "none")
    arguments, torques = drawn(cart, 3), of.nu - of.base_inputs
    links = {name: arguments[name][sideways:] for name in ("q", "v")}
    u = arguments["u"]
    b = np.concatenate([u[:sideways], [0.0], u[sideways:]])
    found = accelerations(cart, arguments)
    assert np.array_equal(found[:sideways], u[:sideways])
    assert gap(found[sideways:], accelerations(moving, links | {"u": b})) < 1e-15
    still = {"u": np.zeros(moving.nu)} | links
    wall = links | ({"u": np.zeros(torques)} if torques else {})
    assert np.array_equal(accelerations(moving, still), accelerations(on_wall(moving), wall))


@pytest.mark.parametrize("masses", ["tip", "mid"])
def test_the_force_of_the_drive_moves_a_free_cart_as_told(masses: str) -> None:
    """inverse_dynamics gives the force; a cart of that mass under that force has that acceleration, and so have its links."""
    of = chain("cart", 3, "planar", masses, cart_mass=0.9, actuated="all")
    arguments = drawn(of, 5)
    a = accelerations(of, arguments)
    force = accelerations(of, arguments | {"a": a}, "inverse_dynamics")
    assert gap(force[1:], arguments["u"][1:]) < 1e-13
    assert gap(accelerations(replace(of, drive="force"), arguments | {"u": force}), a) < 1e-13


def test_inverse_dynamics_knows_the_base() -> None:
    of = chain("moving", 3, "planar", "mid", actuated="all")
    arguments = drawn(of, 6)
    a, b = accelerations(of, arguments), arguments["u"][:2]
    torques = accelerations(of, arguments | {"a": a, "b": b}, "inverse_dynamics")
    assert gap(torques, arguments["u"][2:]) < 1e-13


@pytest.mark.parametrize("space", ["planar", "spatial"])
def test_free_fall_takes_the_weight_away(space: str) -> None:
    """A base that falls with g leaves the links to their rates: from rest nothing moves."""
    of = chain("moving", 3, space, "mid")
    arguments = drawn(of, 7)
    arguments["v"] = np.zeros(of.nv)
    arguments["u"] = np.array([*[0.0] * (of.nu - 1), 9.81])
    assert np.max(np.abs(accelerations(of, arguments))) < 1e-14


@pytest.mark.parametrize("space", ["planar", "spatial"])
@pytest.mark.parametrize("masses", ["tip", "mid"])
def test_it_costs_no_more_than_a_cart_that_forces_move(space: str, masses: str) -> None:
    driven = chain("cart", 4, space, masses, cart_mass=1.7)
    counts = [total_operations(lower_function(derive(of), "forward_dynamics")) for of in (driven, replace(driven, drive="force"))]
    assert counts[0] <= counts[1]


@pytest.mark.parametrize("of", [of for of in given(4) if of.is_planar], ids=named)
def test_jacobians_as_written_are_those_of_the_accelerations(of: Scene) -> None:
    """The form that long chains take, against the accelerations differentiated operation by operation."""
    model, row = derive(of), ROWS["state_jacobian"]
    written = writer_of(row.name, of)
    builder = Builder(row.name, row.doc)
    written.write(builder, of, Parameters(builder, model), **declared(builder, of, row.name))
    forward = lower_function(model, "forward_dynamics", "loops")
    blocks = [Block("a", name, f"dad{name}") for name in ("q", "v", "u")]
    arguments = drawn(of, 2, "state_jacobian")
    found, expected = (evaluate(p, arguments) for p in (prune(builder.finish()), jacobian(forward, row.name, row.doc, blocks)))
    for name in found:
        assert gap(found[name], expected[name]) < 1e-14


def writer_of(name: str, of: Scene) -> Writer:
    written = WRITERS.of(name, of.space)
    assert written.suits(of)
    return written


def test_long_jacobians_cost_what_those_on_a_wall_do() -> None:
    counts = []
    for base in ("fixed", "moving", "cart"):
        keys = {} if base == "fixed" else {**GIVEN[base]}
        of = Scene("long_chain", 10, base=base, mass=0.3, length=0.4, com=0.2, actuated="all", **keys)
        counts.append(total_operations(lower_function(derive(of), "state_jacobian")))
    assert max(counts[1:]) < 1.15 * counts[0]


def test_a_driven_cart_has_no_balance_of_forces() -> None:
    with pytest.raises(UnsupportedError, match="goes where it is told .*use base = \"fixed\""):
        chain("cart", 2, "planar", "tip", want=["phi"])


def apart(found: Any, exact: Any) -> float:
    """max |found - exact| / max |exact|, found taken exactly."""
    return float(max(abs(mpf(float(a)) - b) for a, b in zip(found, exact, strict=True)) / max(map(abs, exact)))


def by_hand(of: Scene, arguments: Arguments) -> list[Any]:
    """The accelerations of a planar chain of absolute angles by its Lagrangian, dense and in 60 digits.

    r_a = p + sum_k lever_ak (sin phi_k, cos phi_k), p'' = b: sum_a m_a (dr_a/dphi_i).(r_a'' - g e_2) = 0.
    """
    with mp.workdps(60):
        n, carts = of.links, int(of.has_cart)
        read = [[mpf(float(x)) for x in values] for values in (of.mass, of.length, of.com or of.length)]
        mass, length, com = read
        phi, rate, u = ([mpf(float(x)) for x in arguments[name]] for name in ("q", "v", "u"))
        phi, rate = phi[carts:], rate[carts:]
        b = [u[0], mpf(0)] if carts else u
        lever = [[length[k] if k < a else com[k] if k == a else mpf(0) for k in range(n)] for a in range(n)]
        tangent = [[mp.cos(x), -mp.sin(x)] for x in phi]
        inward = [[-(w**2) * mp.sin(x), -(w**2) * mp.cos(x)] for x, w in zip(phi, rate, strict=True)]
        matrix, right = mp.matrix(n), mp.matrix(n, 1)
        for a in range(n):
            known = [b[i] + sum(lever[a][k] * inward[k][i] for k in range(n)) - (mpf(of.gravity) if i else 0) for i in range(2)]
            for i in range(n):
                right[i] -= mass[a] * lever[a][i] * (tangent[i][0] * known[0] + tangent[i][1] * known[1])
                for j in range(n):
                    turn = tangent[i][0] * tangent[j][0] + tangent[i][1] * tangent[j][1]
                    matrix[i, j] += mass[a] * lever[a][i] * lever[a][j] * turn
        return [*u[:carts], *mp.lu_solve(matrix, right)]
