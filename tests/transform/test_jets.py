"""The jets pass: recurrences against Taylor coefficients of the composed function, by Cauchy's formula at 80 digits."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import mpmath
import pytest

from phichain.errors import DerivationError
from phichain.ir.builder import Builder
from phichain.ir.evaluate import evaluate_exactly
from phichain.ir.nodes import Program
from phichain.ir.passes import total_operations, unroll
from phichain.lowering.field import vector_field
from phichain.mechanics import derive
from phichain.scene import Scene, scene_from_dict
from phichain.transform.jets import jets
from phichain.transform.lanes import FIRST, HELD, INVERSE_ORDER, LEFT, ORDER, RIGHT, SUMS

DIGITS = 80
ORDERS = 6

SCENES: dict[str, dict[str, Any]] = {
    "arms": {
        "links": 3,
        "space": "planar",
        "base": "fixed",
        "mass": [1, 2, 0.5],
        "length": [1, 0.7, 2],
        "com": [0.5, 0.3, 1],
    },
    "tips": {
        "links": 4,
        "space": "planar",
        "base": "cart",
        "mass": [1, 2, 0.5, 3],
        "length": 1,
        "cart_mass": 0.7,
    },
    "spatial": {
        "links": 2,
        "space": "spatial",
        "base": "cart",
        "mass": 0.1,
        "length": [0.1, 0.3],
        "cart_mass": 0.5,
    },
    "runtime": {
        "links": 2,
        "space": "planar",
        "base": "fixed",
        "mass": "runtime",
        "length": "runtime",
        "com": "runtime",
    },
    "spatial_arms": {
        "links": 2,
        "space": "spatial",
        "base": "fixed",
        "mass": [1, 2],
        "length": 1,
        "com": 0.5,
    },
}
JOINTS: dict[str, dict[str, Any]] = {
    "arms": {"actuated": "all", "angles": "adjacent", "stiffness": [1, 2, 3], "damping": 0.1},
    "spatial": {"stiffness": 0.3, "damping": 0.01},
}


def scene_of(name: str) -> Scene:
    table: dict[str, Any] = {"name": name, "chain": SCENES[name]}
    if name in JOINTS:
        table["joints"] = JOINTS[name]
    return scene_from_dict(table)


def coefficients(count: int, seed: int) -> list[list[mpmath.mpf]]:
    """Rows of ORDERS + 1 numbers of order one, decaying, the same on every machine."""
    return [
        [
            mpmath.mpf((7919 * (seed + 31 * i + 17 * n)) % 1013 - 500) / 700 / (n + 1)
            for n in range(ORDERS + 1)
        ]
        for i in range(count)
    ]


def constants(program: Program) -> dict[str, list[mpmath.mpf]]:
    """Parameters and held inputs."""
    held = [*program.params, *(array for array in program.inputs if array.name not in ("q", "v"))]
    return {a.name: [mpmath.mpf(3 + (5 * i + len(a.name)) % 7) / 5 for i in range(a.size)] for a in held}


def by_recurrence(
    program: Program, given: dict[str, list[list[mpmath.mpf]]]
) -> dict[str, list[list[mpmath.mpf]]]:
    """Coefficients of every output, driven as the emitted C drives them."""
    made = jets(program)
    with mpmath.workdps(DIGITS):
        fixed = constants(program)
        found = evaluate_exactly(
            made.start, fixed | {k: [row[0] for row in rows] for k, rows in given.items()}, DIGITS
        )
        held = {a.name: found[a.name] for a in made.start.outputs if a.name not in (LEFT, RIGHT)}
        left, right = [found.get(LEFT, [])], [found.get(RIGHT, [])]
        series = {array.name: [[value] for value in found[array.name]] for array in program.outputs}
        for n in range(1, ORDERS + 1):
            arguments = fixed | held | {k: [row[n] for row in rows] for k, rows in given.items()}
            arguments |= {LEFT + FIRST: left[0], RIGHT + FIRST: right[0], ORDER: [mpmath.mpf(n)]}
            arguments |= {INVERSE_ORDER: [mpmath.mpf(1) / n], SUMS: sums(left, right, n)}
            found = evaluate_exactly(made.follow, arguments, DIGITS)
            left.append(found.get(LEFT, []))
            right.append(found.get(RIGHT, []))
            for array in program.outputs:
                for cell, value in zip(series[array.name], found[array.name], strict=True):
                    cell.append(value)
        return series


def sums(left: list[list[Any]], right: list[list[Any]], n: int) -> list[Any]:
    lanes = range(len(left[0]))
    return [mpmath.fsum(left[j][lane] * right[n - j][lane] for j in range(1, n)) for lane in lanes]


def by_contour(
    program: Program, given: dict[str, list[list[mpmath.mpf]]]
) -> dict[str, list[list[mpmath.mpf]]]:
    """Coefficients of t -> program(q(t), v(t)) from its values on a small circle (Cauchy's formula, error radius^16)."""
    points, radius = 16, mpmath.mpf(10) ** -4
    with mpmath.workdps(DIGITS):
        fixed, values = constants(program), []
        roots = [mpmath.expjpi(mpmath.mpf(2 * k) / points) for k in range(points)]
        for root in roots:
            moved = {
                k: [mpmath.polyval(row[::-1], radius * root) for row in rows] for k, rows in given.items()
            }
            values.append(evaluate_exactly(program, fixed | moved, DIGITS))

        def series(name: str, cell: int) -> list[mpmath.mpf]:
            terms = [
                [f[name][cell] * root**-n for f, root in zip(values, roots, strict=True)]
                for n in range(ORDERS + 1)
            ]
            return [mpmath.re(mpmath.fsum(row)) / points / radius**n for n, row in enumerate(terms)]

        return {array.name: [series(array.name, i) for i in range(array.size)] for array in program.outputs}


def assert_same(program: Program) -> None:
    sizes = {array.name: array.size for array in program.inputs if array.name in ("q", "v")}
    with mpmath.workdps(DIGITS):
        given = {name: coefficients(size, 3 + len(name) * ord(name[0])) for name, size in sizes.items()}
        found, expected = by_recurrence(program, given), by_contour(program, given)
        for name, rows in expected.items():
            for row, mine in zip(rows, found[name], strict=True):
                for n, (a, b) in enumerate(zip(row, mine, strict=True)):
                    assert abs(a - b) <= mpmath.mpf(10) ** -25 * (1 + abs(a)), (name, n, a, b)


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("shape", ["loops", "unrolled"])
def test_recurrences_give_the_taylor_coefficients_of_the_vector_field(name: str, shape: str) -> None:
    program = vector_field(derive(scene_of(name)))
    assert_same(program if shape == "loops" else unroll(program))


def test_quotients_roots_and_constants_in_time() -> None:
    builder = Builder("mixed", "Everything that has a recurrence.")
    q, v, u = builder.input("q", (2,)), builder.input("v", (1,)), builder.input("u", (2,))
    out = builder.output("out", (5,))
    held = builder.let("ratio", u[0] / u[1])
    positive = 3 + q[0] * q[0]
    out[0] = (held * q[1] + v[0]) / positive
    out[1] = builder.sqrt(positive) / u[1]
    out[2] = builder.cos(q[0] * held) * held
    out[3] = held * held
    out[4] = (held / positive) * builder.sin(q[0] - v[0])
    assert_same(builder.finish())


def test_what_has_no_recurrence_is_refused() -> None:
    builder = Builder("bessel", "")
    q, out = builder.input("q", (1,)), builder.output("out", (1,))
    out[0] = builder.apply("besselj0", q[0])
    with pytest.raises(DerivationError, match="besselj0"):
        jets(builder.finish())


def test_the_sweep_is_linear_in_the_size_of_the_program() -> None:
    def cost(links: int) -> tuple[int, int]:
        chain = {"links": links, "space": "planar", "base": "fixed", "mass": 1, "length": 1, "com": 0.5}
        made = jets(vector_field(derive(scene_from_dict({"name": "p", "chain": chain}))))
        return made.products, total_operations(made.follow)

    few, more, most = cost(8), cost(16), cost(32)
    for i in range(2):
        assert most[i] - more[i] == 2 * (more[i] - few[i])


def test_values_that_do_not_vary_cost_nothing() -> None:
    builder = Builder("linear", "")
    q, u, out = builder.input("q", (1,)), builder.input("u", (1,)), builder.output("a", (1,))
    out[0] = builder.sin(u[0]) * q[0] + u[0] * u[0] + Fraction(1, 3)
    made = jets(builder.finish())
    assert made.products == 0
    assert HELD in {array.name for array in made.follow.inputs}
    assert total_operations(made.follow) == 1
