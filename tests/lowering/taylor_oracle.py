"""Taylor coefficients of a spatial motion by another road: the proven equations (15) in power-series arithmetic, 50 digits.

`direction_dynamics` is evaluated on truncated power series, one order after the other: what it gives at order n are the rates of
order n + 1.
"""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from mpmath import mp, mpf

from phichain.ir.evaluate import evaluate, evaluate_exactly
from phichain.ir.interpret import Algebra, run
from phichain.ir.nodes import Program
from phichain.lowering import lower_function
from phichain.lowering.series.run import Arithmetic
from phichain.mechanics import derive
from phichain.scene import Scene

Row = list[Any]
DIGITS = 50


def _product(a: Row, b: Row) -> Row:
    return [mp.fdot((a[j], b[n - j]) for j in range(n + 1)) for n in range(len(a))]


def _quotient(a: Row, b: Row) -> Row:
    found: Row = []
    for n in range(len(a)):
        found.append((a[n] - mp.fdot((found[j], b[n - j]) for j in range(n))) / b[0])
    return found


_KINDS = {
    "add": lambda a, b: [x + y for x, y in zip(a, b, strict=True)],
    "sub": lambda a, b: [x - y for x, y in zip(a, b, strict=True)],
    "neg": lambda a: [-x for x in a],
    "mul": _product,
    "div": _quotient,
}


def _on_series(program: Program, arguments: Mapping[str, Sequence[Row]], orders: int) -> dict[str, list[Row]]:
    def constant(value: Fraction) -> Row:
        return [mpf(value.numerator) / value.denominator, *[mpf(0)] * (orders - 1)]

    return run(program, Algebra(constant, lambda kind, args, label: _KINDS[kind](*args)), arguments)


def coefficients(scene: Scene, q: Row, v: Row, u: Row, orders: int, **params: Row) -> list[Row]:
    """(q_n, v_n) for n up to `orders`, in true time."""
    program = lower_function(derive(scene), "direction_dynamics", "loops")
    with mp.workdps(DIGITS + 10):
        found = [[mp.mpmathify(x) for x in (*q, *v)]]
        for n in range(orders):
            rows = [[row[i] for row in found] for i in range(len(found[0]))]
            still = {
                name: [[mp.mpmathify(x), *[mpf(0)] * n] for x in values]
                for name, values in {"u": u, **params}.items()
            }
            given = {"q": rows[: len(q)], "q_dot": rows[len(q) :], **still}
            known = {array.name: given[array.name] for array in (*program.params, *program.inputs)}
            rates = [entry[n] / (n + 1) for entry in _on_series(program, known, n + 1)["q_ddot"]]
            found.append([x / (n + 1) for x in found[n][len(q) :]] + rates)
        return found


def _known(program: Program, given: Mapping[str, Any]) -> dict[str, Any]:
    return {array.name: given[array.name] for array in (*program.params, *program.inputs)}


EXACT = Arithmetic(
    lambda program, given: evaluate_exactly(program, _known(program, given), DIGITS + 10),
    lambda value: mpf(value.numerator) / value.denominator,
    lambda pairs: mp.fdot(pairs),
)
DOUBLES = Arithmetic(
    lambda program, given: {
        name: list(map(float, row)) for name, row in evaluate(program, _known(program, given)).items()
    },
    float,
    lambda pairs: sum(a * b for a, b in pairs),
)


@dataclass(frozen=True)
class State:
    """(q, q') of a chain, inputs and runtime parameters."""

    q: Row
    v: Row
    u: Row
    params: dict[str, Row]


def state(scene: Scene, seed: int = 0, links: Sequence[Row] = (), speed: float = 1.0) -> State:
    """A random state, unit and tangent to 60 digits; `links` gives directions instead of random ones."""
    source, carts = random.Random(seed), 2 * scene.has_cart
    with mp.workdps(DIGITS + 10):

        def vector() -> Row:
            return [mpf(source.gauss(0, 1)) for _ in range(3)]

        free = scene.nq if scene.is_planar else carts
        q, v = ([mpf(source.uniform(-1, 1)) for _ in range(free)] for _ in range(2))
        for k in range(0 if scene.is_planar else scene.links):
            link = [mpf(x) for x in links[k]] if links else vector()
            size = mp.norm(link)
            link, turn = [x / size for x in link], vector()
            along = mp.fdot(link, turn)
            q += link
            v += [speed * (x - along * y) for x, y in zip(turn, link, strict=True)]
        u = [mpf(source.uniform(-1, 1)) for _ in range(scene.nu)]
        sizes = {name: 1 if name in ("gravity", "cart_mass") else scene.links for name in scene.runtime}
        params = {name: [mpf(source.uniform(0.6, 1.0)) for _ in range(size)] for name, size in sizes.items()}
        if "com" in params:
            params["com"] = [x * mpf("0.6") for x in params["com"]]
    return State(q, v, u, params)


def gap(found: Sequence[Row], true: Sequence[Row]) -> float:
    """The largest |found - true| over the largest |true|, order by order."""
    return max(
        float(max(abs(x - y) for x, y in zip(one, other, strict=True)) / max(abs(y) for y in other))
        for one, other in zip(found, true, strict=True)
    )
