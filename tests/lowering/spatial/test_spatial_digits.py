"""Spatial chains whose masses sit close to the joints keep their digits, in double and in single precision.

With r << l a link turns by about l / r times its joint's acceleration, in the directions that nothing beyond holds, beside links
that turn slowly. The truth is the dense mechanics from positions in 30 digits; what the rounding of the state alone does to it
says how far any algorithm can come.
"""

from __future__ import annotations

from functools import cache
from itertools import product
from typing import Any

import numpy as np
import pytest
from mpmath import mpf

from phichain.ir import Program, evaluate
from phichain.ir.interpret import Algebra, run
from phichain.lowering import lower_function
from phichain.mechanics import derive
from phichain.reference import reference, tangent_directions
from phichain.scene import Scene
from tests.lowering.hard_chains import Hard
from tests.reference_cases import relative_error

RATIOS = (1e-2, 1e-4, 1e-6, 1e-8)
LINKS = (1, 2, 4, 7)
#: Which links have their mass near the joint, by their numbers from the base on.
PLACES: dict[str, Any] = {
    "all": lambda k: True,
    "in turn": lambda k: k % 2 == 0,
    "pairs": lambda k: k % 3 != 1,
}
JOINTS: dict[str, dict[str, Any]] = {"free": {}, "sprung": {"stiffness": 2.0, "damping": 0.3}}
_OPERATIONS = {
    "add": lambda a, b: a + b, "sub": lambda a, b: a - b, "mul": lambda a, b: a * b, "div": lambda a, b: a / b,
    "neg": lambda a: -a, "sqrt": np.sqrt,
}  # fmt: skip


def chain(links: int, base: str, ratio: float, place: str, joints: str = "free", seed: int = 0) -> Hard:
    """Masses and lengths over four decades, r = ratio * l or r = l, in a random state."""
    rng = np.random.default_rng([seed, links])
    mass, length = 10 ** rng.uniform(-2, 2, links), 10 ** rng.uniform(-2, 2, links)
    com = [x * ratio if PLACES[place](k) else x for k, x in enumerate(length.tolist())]
    cart = {"cart_mass": 1.7} if base == "cart" else {}
    scene = Scene(
        "digits", links, space="spatial", base=base, mass=mass.tolist(), length=length.tolist(), com=com,
        **(cart | JOINTS[joints]),
    )  # fmt: skip
    q, v = rng.normal(size=(2, links, 3))
    q /= np.linalg.norm(q, axis=1)[:, None]
    v -= q * np.sum(q * v, axis=1)[:, None]
    still = [0.0] * (2 * scene.has_cart)
    inputs = {"q": [*still, *q.ravel().tolist()], "v": [*still, *v.ravel().tolist()]}
    if scene.nu:
        inputs["u"] = rng.normal(size=scene.nu).tolist()
    return Hard(scene, inputs)


@cache
def lowered(scene: Scene, name: str) -> Program:
    return lower_function(derive(scene), name, "loops")


def program_of(hard: Hard, name: str = "forward_dynamics") -> Program:
    return lowered(hard.scene, name)


def in_double(hard: Hard) -> list[float]:
    program = program_of(hard)
    return evaluate(program, {array.name: hard.inputs[array.name] for array in program.inputs})["a"].tolist()


def in_single(hard: Hard, name: str = "forward_dynamics", output: str = "a") -> list[float]:
    """Every constant and every operation in binary32."""
    program = program_of(hard, name)
    algebra = Algebra(lambda value: np.float32(float(value)), lambda kind, args, label: _OPERATIONS[kind](*args))
    given = {array.name: [np.float32(x) for x in hard.inputs[array.name]] for array in program.inputs}
    with np.errstate(all="ignore"):
        return [float(x) for x in run(program, algebra, given)[output]]


def rounded(hard: Hard) -> Hard:
    """The same with arguments that are binary32 numbers."""
    single = {name: np.float32(values).astype(float).tolist() for name, values in hard.inputs.items()}
    return Hard(hard.scene, single)


CASES = list(product(LINKS, ("fixed", "cart"), RATIOS, PLACES))


@pytest.mark.long
@pytest.mark.parametrize(("links", "base", "ratio", "place"), CASES)
def test_double(links: int, base: str, ratio: float, place: str) -> None:
    check_double(chain(links, base, ratio, place))


@pytest.mark.long
@pytest.mark.parametrize(("base", "ratio", "place"), list(product(("fixed", "cart"), RATIOS, PLACES)))
def test_springs_and_dampers(base: str, ratio: float, place: str) -> None:
    check_double(chain(4, base, ratio, place, "sprung"))
    check_single(chain(4, base, ratio, place, "sprung"))


def check_double(hard: Hard) -> None:
    error = relative_error(in_double(hard), hard.truth())
    assert error < 1e-14 or error < 10 * hard.attainable(), error


@pytest.mark.parametrize(("links", "base", "ratio", "place"), CASES)
def test_single(links: int, base: str, ratio: float, place: str) -> None:
    check_single(chain(links, base, ratio, place))


def check_single(exact: Hard) -> None:
    hard = rounded(exact)
    found = in_single(hard)
    assert np.all(np.isfinite(found))
    error = relative_error(found, hard.truth())
    assert error < 2e-6 or error < 10 * hard.attainable(half_ulp=mpf(2) ** -24), error


@pytest.mark.parametrize(
    ("links", "base", "ratio", "place"), [*product((2,), ("fixed", "cart"), (1e-2, 1e-6), PLACES), (3, "cart", 1e-6, "in turn")]
)
def test_jacobian(links: int, base: str, ratio: float, place: str) -> None:
    """Along the tangents of the unit vectors, beside the reference's own derivative."""
    hard = chain(links, base, ratio, place)
    program = program_of(hard, "state_jacobian")
    found = evaluate(program, {array.name: hard.inputs[array.name] for array in program.inputs})
    expected = reference(hard.scene, "state_jacobian", hard.inputs, digits=40)["tangent"]
    directions = tangent_directions(hard.scene, hard.inputs["q"], hard.inputs["v"], digits=40)
    along = [
        found["dadq"] @ np.array(dq, dtype=float) + found["dadv"] @ np.array(dv, dtype=float)
        for dq, dv in directions
    ]
    assert relative_error(np.array(along).tolist(), expected) < 1e-12


@pytest.mark.parametrize(("links", "base"), [(1, "cart"), (2, "cart"), (3, "fixed")])
@pytest.mark.parametrize("ratio", [1e-2, 1e-6, 1e-8])
def test_jacobian_in_single(links: int, base: str, ratio: float) -> None:
    """Derivatives divide by squares of the pivots; the same in double is what `test_jacobian` holds."""
    hard = rounded(chain(links, base, ratio, "all"))
    program = program_of(hard, "state_jacobian")
    expected = evaluate(program, {array.name: hard.inputs[array.name] for array in program.inputs})
    for output in ("dadq", "dadv"):
        error = relative_error(in_single(hard, "state_jacobian", output), expected[output].ravel().tolist())
        assert error < 2e-6, error
