"""What the proof stands on: the field, its points and atoms, and Programs compiled over it with their derivatives."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import pytest

from phichain.ir.interpret import Algebra, run
from phichain.ir.nodes import Affine, Array, Cell, Const, For, Local, Op, Program, Store, walk
from phichain.lowering import lower
from phichain.lowering.lower import lower_function
from phichain.mechanics import derive
from phichain.proof.modular.compiled import Given, compiled
from phichain.proof.modular.contracted import contracted
from phichain.proof.modular.field import PRIME, Source, cross, dot, exact, inverse, root
from phichain.proof.modular.points import Bessel, Point
from phichain.scene import Scene

CHAIN = Scene("chain", 3, mass=[0.3, 0.2, 0.1], length=[0.5, 0.4, 0.3], com=0.2, stiffness=1.0, code="loops")
FLYING = replace(CHAIN, name="flying", space="spatial", base="cart", cart_mass=0.001, angles=None)
"""On a cart so light that its Jacobian is differentiated column by column; so is that of rods held in their middles."""
STANDING = replace(FLYING, name="standing", base="fixed", drive=None, cart_mass=None, com=0.0, inertia=0.1, stiffness=None)


def test_numbers_of_a_scene_are_exact_in_the_field() -> None:
    assert exact(0.1) * inverse(10) % PRIME != inverse(100)
    assert exact(0.1) == Fraction(0.1).numerator * inverse(Fraction(0.1).denominator) % PRIME
    assert exact(Fraction(-3, 7)) * 7 % PRIME == -3 % PRIME
    with pytest.raises(ZeroDivisionError):
        inverse(PRIME)


def test_random_elements_are_the_same_on_every_machine() -> None:
    assert Source("digest", 1, "q").vector(2) == [1322903521980226588, 2295858526503799465]
    assert Source("digest", 2, "q").element() != Source("digest", 1, "q").element()


def test_points_lie_on_circle_and_sphere_and_tangents_across() -> None:
    source = Source("points")
    c, s = source.circle()
    unit = source.sphere()
    across = source.across(unit)
    assert (c * c + s * s) % PRIME == dot(unit, unit) == 1
    assert dot(unit, across) == 0 and any(across)
    assert dot(cross(unit, across), unit) == 0


def test_the_root_of_a_square_of_a_square_is_that_square() -> None:
    element = Source("root").element() ** 2 % PRIME
    assert root(element * element % PRIME) == element


def test_bessel_atoms_obey_what_the_functions_obey() -> None:
    bessel, x = Bessel(Source("bessel")), Source("x").element()
    orders = bessel(x)
    for n in range(1, 6):
        assert (x * (orders[n + 1] + orders[n - 1]) - 2 * n * orders[n]) % PRIME == 0
        assert bessel(PRIME - x)[n] == (-1) ** n * orders[n] % PRIME
    assert [bessel(0)[n] for n in range(6)] == [1, 0, 0, 0, 0, 0]
    assert bessel(x)[1] == Bessel(Source("bessel"))(x)[1] != bessel(x + 1)[1]


@pytest.mark.parametrize("scene", [CHAIN, FLYING], ids=lambda scene: scene.name)
@pytest.mark.parametrize("name", ["forward_dynamics", "energy", "state_jacobian"])
def test_compiled_programs_are_the_interpreted_ones(scene: Scene, name: str) -> None:
    """The interpreter that every backend shares, over the same field with angles as objects, against the compiled text."""
    program = lower_function(derive(scene), name)
    point = Point(scene, 1, ())
    given = point.given()
    found = compiled(program)(given, point)

    def apply(kind: str, args: list, label: str) -> tuple:
        values, points = [arg[0] for arg in args], [arg[1] for arg in args]
        match kind:
            case "sin" | "cos":
                return points[0][kind == "sin"], None
            case "add" | "sub" if None not in points:
                (c, s), (C, S) = points
                S = S if kind == "add" else -S
                return (values[0] + (values[1] if kind == "add" else -values[1])) % PRIME, (c * C - s * S, s * C + c * S)
            case "add":
                return sum(values) % PRIME, None
            case "sub":
                return (values[0] - values[1]) % PRIME, None
            case "mul":
                return values[0] * values[1] % PRIME, None
            case "div":
                return values[0] * inverse(values[1]) % PRIME, None
            case "neg":
                return -values[0] % PRIME, None
        raise AssertionError(kind)

    zero = (1, 0)
    algebra = Algebra(lambda value: (exact(value), zero if value == 0 else None), apply)
    arguments = {name: [(value, None) for value in values] for name, values in given.values.items()}
    if scene.is_planar:
        arguments["q"] = list(zip(point.q, point.circles, strict=True))
    true = run(program, algebra, arguments)
    for output, values in true.items():
        assert [value % PRIME for value, _ in values] == found[output][0]


@pytest.mark.parametrize("scene", [CHAIN, FLYING], ids=lambda scene: scene.name)
def test_directional_derivatives_are_those_of_the_jacobian(scene: Scene) -> None:
    model, point = derive(scene), Point(scene, 1, ())
    forward, jacobian = (lower_function(model, name) for name in ("forward_dynamics", "state_jacobian"))
    moved = {"q": point.free("dq"), "v": point.free("dv")}
    slope = compiled(forward, 1)(replace(point.given(), along=moved), point)["a"][1]
    blocks, nv = compiled(jacobian)(point.given(), point), scene.nv
    for i, value in enumerate(slope):
        rows = (dot(blocks[f"dad{name}"][0][i * nv : (i + 1) * nv], direction) for name, direction in moved.items())
        assert value == sum(rows) % PRIME


def test_second_derivatives_are_mixed_ones() -> None:
    """x y / (x + y) along x and y: 2 x y / (x + y)^3."""
    x, y = Cell("x", Affine(0)), Cell("x", Affine(1))
    body = (
        Op("product", "mul", (x, y)),
        Op("sum", "add", (x, y)),
        Op("ratio", "div", (Local("product"), Local("sum"))),
        Store(Cell("out", Affine(0)), Local("ratio")),
    )
    program = Program("ratio", "", (), (Array("x", (2,)),), (Array("out", ()),), (), {}, body)
    given = Given({"x": [3, 5]}, along={"x": [1, 0]}, across={"x": [0, 1]})
    value, along, across, mixed = (part[0] for part in compiled(program, 2)(given)["out"])
    assert [value, along, across, mixed] == [exact(Fraction(n, d)) for n, d in ((15, 8), (25, 64), (9, 64), (30, 512))]


def tiny(index: int, stored: int = 0, size: int = 2) -> Program:
    """out[stored] = x[index]"""
    body = (Store(Cell("out", Affine(stored)), Cell("x", Affine(index))),)
    return Program("tiny", "", (), (Array("x", (size,)),), (Array("out", (1,)),), (), {}, body)


@pytest.mark.parametrize(("index", "stored"), [(-1, 0), (2, 0), (0, 1), (0, -1)])
def test_indices_neither_wrap_nor_leave_their_array(index: int, stored: int) -> None:
    assert compiled(tiny(1))(Given({"x": [7, 9]}))["out"][0] == [9]
    with pytest.raises((KeyError, IndexError)):
        compiled(tiny(index, stored))(Given({"x": [7, 9]}))


@pytest.mark.parametrize("scene", [STANDING, FLYING], ids=lambda scene: scene.name)
def test_a_jacobian_times_a_vector_is_the_sum_over_its_columns(scene: Scene) -> None:
    program, point = lower(derive(replace(scene, want=("state_jacobian",)))).wanted["state_jacobian"], Point(scene, 2, ())
    plan = contracted(program)
    assert plan is not None
    vectors = {array.name: point.free(array.name, array.shape[1]) for array in program.outputs}
    weights = {}
    for block in plan.blocks:
        assert block.weights is not None
        weights[block.weights.name] = vectors[block.output][block.column :][: block.count]
    whole, given = compiled(program)(point.given(), point), point.given()
    times = compiled(plan.program)(replace(given, values={**given.values, **weights}), point)
    for block in plan.blocks:
        vector = vectors[block.output]
        rows = [whole[block.output][0][i : i + len(vector)] for i in range(0, len(whole[block.output][0]), len(vector))]
        assert times[block.rows][0] == [dot(row, vector) for row in rows]


def test_a_loop_over_seeds_that_is_not_linear_is_left_whole() -> None:
    program = lower(derive(replace(FLYING, want=("state_jacobian",)))).wanted["state_jacobian"]
    loop = next(s for s in program.body if isinstance(s, For) and s.variable == "seed")
    shifted = next(s for s in walk(loop.body) if isinstance(s, Op) and s.kind == "add")

    def changed(statements: tuple, **change: object) -> tuple:
        return tuple(
            replace(s, **change) if s is shifted else replace(s, body=changed(s.body, **change)) if isinstance(s, For) else s
            for s in statements
        )

    for change in ({"args": (shifted.args[0], Const(Fraction(1)))}, {"kind": "div"}, {"kind": "mul"}):
        assert contracted(replace(program, body=changed(program.body, **change))) is None
