"""The O(N) solve of (I - g J) k = r against a dense one on the emitted Jacobian, and what it costs."""

from __future__ import annotations

from functools import cache
from typing import Any, Literal

import numpy as np
import pytest
from numpy.typing import NDArray

from phichain.ir import evaluate
from phichain.ir.nodes import Program
from phichain.ir.passes import total_operations
from phichain.lowering import lower_function
from phichain.mechanics import derive
from phichain.scene import Scene
from tests.lowering.chains import Arguments, kinds, label, random_arguments, scene


@cache
def lowered(chain: Scene, name: str, code: Literal["auto", "unrolled", "loops"] = "auto") -> Program:
    return lower_function(derive(chain), name, code)

Vector = NDArray[np.float64]
GAINS = (1e-3, 0.1, -0.05)


def swept(
    chain: Scene, arguments: Arguments, gain: float, right: tuple[Vector, Vector]
) -> tuple[Vector, Vector]:
    """k by the Programs of the step."""
    known: dict[str, Any] = {**arguments, "gain": np.array([gain])}
    known["a"] = evaluate(lowered(chain, "forward_dynamics"), arguments)["a"]
    known |= evaluate(lowered(chain, "implicit_factors", "loops"), known)
    known |= {"right_q": right[0], "right_v": right[1]}
    found = evaluate(lowered(chain, "implicit_solution", "loops"), known)
    return found["k_q"], found["k_v"]


def dense(
    chain: Scene, arguments: Arguments, gain: float, right: tuple[Vector, Vector]
) -> tuple[Vector, Vector]:
    """k by LU on the Jacobian of (v, a), in space that of the step's chart."""
    slopes = evaluate(lowered(chain, "state_jacobian", "loops"), arguments)
    dadq, dadv, size = slopes["dadq"], slopes["dadv"], chain.nv
    moving = np.eye(size)
    if not chain.is_planar:
        project, tilt = np.eye(size), np.zeros((size, size))
        for at in links(chain):
            q, omega = arguments["q"][at], arguments["v"][at]
            project[at, at] -= np.outer(q, q)
            tilt[at, at] = -np.outer(q, omega)  # domega = dsigma - q (omega . ds)
            moving[at, at] = np.cross(np.eye(3), q).T  # ds' = dsigma x q
        dadq, dadv = project @ (dadq + dadv @ tilt) @ project, project @ dadv @ project
    slope = np.block([[np.zeros((size, size)), moving], [dadq, dadv]])
    found = np.linalg.solve(np.eye(2 * size) - gain * slope, np.concatenate(right))
    return found[:size], found[size:]


def links(chain: Scene) -> list[slice]:
    start = 2 * chain.has_cart
    return [slice(k, k + 3) for k in range(start, chain.nv, 3)]


def right_side(chain: Scene, arguments: Arguments, seed: int) -> tuple[Vector, Vector]:
    rng = np.random.default_rng(seed)
    sides = rng.normal(size=chain.nv), rng.normal(size=chain.nv)
    if not chain.is_planar:
        for at in links(chain):
            q = arguments["q"][at]
            for side in sides:
                side[at] -= q * (q @ side[at])
    return sides


def apart(chain: Scene, gain: float, seed: int) -> float:
    """Largest difference of the two over the largest entry, angles and rates apart."""
    arguments = random_arguments(chain, lowered(chain, "forward_dynamics"), seed)
    right = right_side(chain, arguments, seed)
    pairs = zip(swept(chain, arguments, gain, right), dense(chain, arguments, gain, right), strict=True)
    return max(float(np.max(np.abs(a - b)) / np.max(np.abs(b))) for a, b in pairs)


@pytest.mark.long
@pytest.mark.parametrize(
    "chain",
    [
        *list(kinds())[::3],
        *(scene(1, s, b, "mid", "damped") for s in ("planar", "spatial") for b in ("fixed", "cart")),
    ],
    ids=label,
)
def test_it_is_the_dense_solution(chain: Scene) -> None:
    """Steps of every kind of scene are compared with 50 digits in tests/program; here the solve alone."""
    for seed, gain in enumerate(GAINS):
        assert apart(chain, gain, seed) < 1e-12, gain


#: Chains that are stiff or uneven, and the step times gamma at which their Jacobians are resolved by a dense solve.
UNEVEN: dict[str, tuple[dict[str, Any], float]] = {
    "light in turn": ({"mass": [1.0, 1e-8, 1.0, 1e-8]}, 1e-3),
    "heavy root": ({"mass": [1e8, 1.0, 1.0, 1.0]}, 1e-2),
    "long and short": ({"length": [1.0, 1e-4, 1.0, 1e-4]}, 1e-6),
    "dampers": ({"damping": [1e6] * 4}, 1e-3),
    "rotors": ({"armature": [1e4, 0.0, 1e-4, 1.0]}, 1e-2),
    "rotors on stiff springs": ({"armature": [1e-2, 1e2, 0.0, 1.0], "stiffness": [1e6, 0.0, 1e4, 1e6], "damping": 1.0}, 1e-4),
    "stiff springs with dampers": (
        {"stiffness": [0.0, 1e6, 0.0, 1e6], "damping": [0.0, 1e4, 0.0, 1e4]},
        1e-4,
    ),
}


@pytest.mark.long
@pytest.mark.parametrize("base", ["fixed", "cart"])
@pytest.mark.parametrize("com", [None, [0.5] * 4], ids=["at the ends", "half way"])
@pytest.mark.parametrize("name", UNEVEN)
def test_uneven_and_stiff_planar_chains(name: str, com: list[float] | None, base: str) -> None:
    """Where the dense solve is good to 1e-12 itself, so is the sweep."""
    numbers, gain = UNEVEN[name]
    keys: dict[str, Any] = {"mass": [1.0] * 4, "length": [1.0] * 4} | numbers
    if com is not None:
        keys["com"] = [0.5 * length for length in keys["length"]]
    if base == "cart":
        keys["cart_mass"] = 1.0
    chain = Scene("uneven", 4, space="planar", base=base, **keys)
    assert max(apart(chain, gain, seed) for seed in range(3)) < 1e-12


@pytest.mark.long
@pytest.mark.parametrize("joints", ["free", "damped"])
@pytest.mark.parametrize("base", ["fixed", "cart"])
@pytest.mark.parametrize("space", ["planar", "spatial"])
def test_a_link_costs_the_same_in_every_chain(space: str, base: str, joints: str) -> None:
    """Operations of a factorisation, of a solution and of the whole step grow by one amount a link, N = 16 .. 64; shorter chains read neighbours otherwise.

    A step's accelerations take the leaner of two forms as long as the numbers bound its rounding, which 64 spatial links do not.
    """
    names = ("implicit_factors", "implicit_solution", "step_rosenbrock")
    counts = {
        name: [
            total_operations(lowered(long_chain(n, space, base, joints), name, "loops"))
            for n in (16, 24, 32, 64)
        ]
        for name in names
    }
    for name, (sixteen, twenty_four, thirty_two, sixty_four) in counts.items():
        a_link = (twenty_four - sixteen) / 8
        assert a_link == (thirty_two - twenty_four) / 8, name
        if (space, name) != ("spatial", "step_rosenbrock"):
            assert a_link == (sixty_four - thirty_two) / 32, name
    # Two lanes count 100 operations a link more than the sweeps side by side (1750 and 2150 at most) and take 0.95 of the step's time.
    most = {("planar", "free"): 1870, ("planar", "damped"): 2260, ("spatial", "free"): 9500}
    assert counts["step_rosenbrock"][3] / 64 < most.get((space, joints), 13500)


@pytest.mark.parametrize("base", ["fixed", "cart"])
def test_a_link_with_its_mass_near_the_joint_costs_little_more(base: str) -> None:
    """A step of a free spatial chain: the careful form of its accelerations costs at most 1.85 times the lean one half way."""
    half, near = (
        [total_operations(lowered(long_chain(n, "spatial", base, "free", r), "step_rosenbrock", "loops")) for n in (8, 16, 32)]
        for r in (0.5, 1e-3)
    )
    assert near[1] - near[0] == (near[2] - near[1]) / 2
    assert near[1] - near[0] < 1.85 * (half[1] - half[0]) and near[1] - near[0] < 8 * 10200


def long_chain(links: int, space: str, base: str, joints: str, place: float = 0.5) -> Scene:
    keys: dict[str, Any] = {
        "mass": [0.5 + k % 3 for k in range(links)],
        "length": [1.0 + k % 2 for k in range(links)],
    }
    keys["com"] = [place * length for length in keys["length"]]
    if base == "cart":
        keys["cart_mass"] = 1.0
    if joints == "damped":
        keys |= {"damping": [0.1] * links, "stiffness": [1.0 + k for k in range(links)]}
    return Scene("links", links, space=space, base=base, **keys)
