"""The implicit solves of free spatial chains whose masses sit close to the joints, in double and in single precision.

Truth: the Programs themselves in 80 digits, on the manifold; and, independent of them, a dense solve on the reference's Jacobian.
The proof (tests/proof) shows the Programs exact, so that rounding is all that is left to measure.
"""

from __future__ import annotations

from fractions import Fraction
from itertools import product
from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf, sqrt

from phichain.ir.interpret import Algebra, run
from phichain.lowering.spatial.near_joints import near_joints
from phichain.reference import reference, tangent_directions
from phichain.scene import Scene
from tests.lowering.hard_chains import Hard
from tests.lowering.spatial.test_spatial_digits import chain, lowered
from tests.reference_cases import relative_error

DIGITS = 80
_OPERATIONS: dict[str, Any] = {
    "add": lambda a, b: a + b, "sub": lambda a, b: a - b, "mul": lambda a, b: a * b, "div": lambda a, b: a / b,
    "neg": lambda a: -a,
}  # fmt: skip


def _exact(value: Any) -> Any:
    whole = Fraction(value)
    return mpf(whole.numerator) / mpf(whole.denominator)


def _algebra(number: Any, root: Any) -> Algebra:
    operations = _OPERATIONS | {"sqrt": root}
    return Algebra(number, lambda kind, args, label: operations[kind](*args))


MANY = _algebra(_exact, sqrt)
DOUBLE = _algebra(float, np.sqrt)
SINGLE = _algebra(lambda value: np.float32(float(value)), np.sqrt)

#: q, v, u, a, right_q and right_v.
Arguments = dict[str, list[Any]]
Solution = tuple[list[Any], list[Any]]


def arguments(hard: Hard) -> Arguments:
    """The state and a right side, exactly on the manifold, with the accelerations there."""
    rng = np.random.default_rng(5)
    sides = {name: rng.normal(size=hard.scene.nv).tolist() for name in ("right_q", "right_v")}
    return on_manifold(hard.scene, {name: [mpf(x) for x in values] for name, values in (hard.inputs | sides).items()})


def on_manifold(scene: Scene, given: Arguments) -> Arguments:
    """Unit vectors made unit and what is to be tangent made tangent; `a` where it is missing."""
    found = {name: list(values) for name, values in given.items()}
    for k in range(2 * scene.has_cart, scene.nv, 3):
        at = slice(k, k + 3)
        norm = sqrt(sum(x * x for x in found["q"][at]))
        found["q"][at] = q = [x / norm for x in found["q"][at]]
        for name in ("v", "right_q", "right_v"):
            along = sum(x * y for x, y in zip(q, found[name][at], strict=True))
            found[name][at] = [x - along * y for x, y in zip(found[name][at], q, strict=True)]
    if "a" not in found:
        forward = lowered(scene, "forward_dynamics")
        found["a"] = run(forward, MANY, {array.name: found[array.name] for array in forward.inputs})["a"]
    return found


def solved(scene: Scene, gain: float, given: Arguments, algebra: Algebra, number: Any) -> Solution:
    """k by the Programs of the step, every operation in one algebra."""
    known = {name: [number(x) for x in values] for name, values in given.items()} | {"gain": [number(gain)]}
    with np.errstate(all="ignore"):
        for name in ("implicit_factors", "implicit_solution"):
            program = lowered(scene, name)
            known |= run(program, algebra, {array.name: known[array.name] for array in program.inputs})
    return known["k_q"], known["k_v"]


def apart(found: Solution, truth: Solution) -> float:
    return max(relative_error([mpf(float(x)) for x in a], b) for a, b in zip(found, truth, strict=True))


def attainable(scene: Scene, gain: float, given: Arguments, truth: Solution) -> float:
    """What arguments off by half a unit in the last place do."""
    rng, worst = np.random.default_rng(1), 0.0
    for _ in range(3):
        moved = {
            name: [x * (1 + mpf(float(rng.uniform(-1, 1))) / 2**53) for x in values] for name, values in given.items()
        }
        other = solved(scene, gain, on_manifold(scene, moved), MANY, mpf)
        worst = max(worst, *(relative_error(a, b) for a, b in zip(other, truth, strict=True)))
    return worst


def check(hard: Hard, gain: float, least: float = 1e-13) -> None:
    assert near_joints(hard.scene)
    with mp.workdps(DIGITS):
        given = arguments(hard)
        truth = solved(hard.scene, gain, given, MANY, mpf)
        error = apart(solved(hard.scene, gain, given, DOUBLE, float), truth)
        assert error < least or error < 10 * attainable(hard.scene, gain, given, truth), error
        single = solved(hard.scene, gain, given, SINGLE, np.float32)
    assert all(np.isfinite(float(x)) for part in single for x in part)


@pytest.mark.long
@pytest.mark.parametrize(
    ("links", "base", "ratio", "place"),
    [*product((1, 2, 4), ("fixed", "cart"), (1e-2, 1e-4, 1e-8), ("all", "in turn"))],
)
def test_random_states(links: int, base: str, ratio: float, place: str) -> None:
    """Steps that resolve the light links, whose rates go as l / r, and longer ones on one link."""
    check(chain(links, base, ratio, place), 1e-2 * ratio)
    if links == 1:
        check(chain(links, base, ratio, place), 1e-2 * ratio**0.5)


def resting(links: int, base: str, ratio: float, off: float = 0.3) -> Hard:
    """A chain of equal links at rest, a little off the plumb line."""
    rng = np.random.default_rng(links)
    cart = {"cart_mass": 1.7} if base == "cart" else {}
    scene = Scene(
        "resting", links, space="spatial", base=base, mass=[1.0] * links, length=[1.0] * links, com=[ratio] * links, **cart
    )
    q = off * rng.normal(size=(links, 3)) + [0.0, 0.0, 1.0]
    q /= np.linalg.norm(q, axis=1)[:, None]
    still = [0.0] * (2 * scene.has_cart)
    return Hard(scene, {"q": [*still, *q.ravel().tolist()], "v": [0.0] * scene.nv, "u": [0.0] * scene.nu})


@pytest.mark.long
@pytest.mark.parametrize(("links", "base", "ratio"), [*product((2, 3, 6), ("fixed", "cart"), (1e-2, 1e-4, 1e-8))])
def test_chains_at_rest(links: int, base: str, ratio: float) -> None:
    check(resting(links, base, ratio), 1e-2 * ratio)


@pytest.mark.parametrize(("links", "base", "ratio"), [*product((2, 3, 6), ("fixed", "cart"), (1e-2, 1e-4, 1e-8))])
def test_hanging_chains(links: int, base: str, ratio: float) -> None:
    """Nothing is fast here but what would swing as sqrt(g / r), and steps may be far larger than that."""
    for gain in (1e-2 * ratio**0.5, ratio**0.5, 0.1):
        check(resting(links, base, ratio, 0.0), gain)


def chart(scene: Scene, q: list[Any], along: tuple[list[Any], list[Any]]) -> list[Any]:
    """(s, sigma) of a direction or of a derivative: both parts across the q_k."""
    found = []
    for part in along:
        part = list(part)
        for k in range(2 * scene.has_cart, scene.nv, 3):
            at = slice(k, k + 3)
            dot = sum(x * y for x, y in zip(q[at], part[at], strict=True))
            part[at] = [x - dot * y for x, y in zip(part[at], q[at], strict=True)]
        found += part
    return found


def slope(scene: Scene, given: Arguments, dq: list[Any], dv: list[Any]) -> list[Any]:
    """The derivative of (x', omega_k x q_k)."""
    found = list(dv)
    for k in range(2 * scene.has_cart, scene.nv, 3):
        at = slice(k, k + 3)
        for i in range(3):
            x, y = (i + 1) % 3, (i + 2) % 3
            q, v, p, w = given["q"][at], given["v"][at], dq[at], dv[at]
            found[k + i] = w[x] * q[y] - w[y] * q[x] + v[x] * p[y] - v[y] * p[x]
    return found


@pytest.mark.parametrize(
    ("links", "base", "ratio"), [(1, "cart", 1e-8), (2, "fixed", 1e-2), (2, "cart", 1e-4), (3, "fixed", 1e-6)]
)
def test_it_solves_the_equations_of_the_reference(links: int, base: str, ratio: float) -> None:
    hard, gain = resting(links, base, ratio), 0.1 * ratio
    scene = hard.scene
    with mp.workdps(DIGITS):
        given = arguments(hard)
        found = solved(scene, gain, given, DOUBLE, float)
        state = {name: given[name] for name in hard.inputs}
        slopes = reference(scene, "state_jacobian", hard.inputs, digits=DIGITS)["tangent"]
        pairs = tangent_directions(scene, hard.inputs["q"], hard.inputs["v"], digits=DIGITS)
        columns, moved = [], []
        for (dq, dv), a in zip(pairs, slopes, strict=True):
            columns.append(chart(scene, state["q"], (dq, dv)))
            rate = chart(scene, state["q"], (slope(scene, given, dq, dv), [mpf(x) for x in a]))
            moved.append([x - gain * y for x, y in zip(columns[-1], rate, strict=True)])
        right = [*given["right_q"], *given["right_v"]]
        size = len(columns)
        system = mp.matrix(size, size)
        for i, j in product(range(size), repeat=2):
            system[i, j] = sum(x * y for x, y in zip(columns[i], moved[j], strict=True))
        side = mp.matrix([sum(x * y for x, y in zip(column, right, strict=True)) for column in columns])
        weights = mp.lu_solve(system, side)
        k = [sum(weights[j] * columns[j][i] for j in range(size)) for i in range(2 * scene.nv)]
        truth = k[: scene.nv], k[scene.nv :]
        error = apart(found, truth)
        assert error < 1e-13 or error < 10 * attainable(scene, gain, given, truth), error
